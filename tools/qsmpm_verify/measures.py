"""Quantities computed from all material points of a state; a case names them under `measure`."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from qsmpm_verify.reference import column_position_hencky
from qsmpm_verify.results import Array, Points, ResultError

Measure = Callable[..., float]


def total_volume(points: Points) -> float:
    """Sum of the point volumes [volume]."""
    return float(points.field("volume").sum())


def volume_within(points: Points, low: list[float], high: list[float]) -> float:
    """Volume of the points in a box, given by the least and the largest coordinates [volume]."""
    place = points.field("position")[:, : len(low)]
    inside = np.all((place >= low) & (place <= high), axis=1)
    return float(points.field("volume")[inside].sum())


def share_above(points: Points, field: str, share: float) -> float:
    """Volume of the points where a field exceeds a fraction of its largest value, over the total volume [-]."""
    values = points.field(field)
    volume = points.field("volume")
    return float(volume[values > share * values.max()].sum() / volume.sum())


def extreme_stress(points: Points, component: int, largest: bool = True) -> float:
    """Largest (or smallest) value of a stress component over the points, 1 = 11, 2 = 22 ... [stress]."""
    values = points.field("stress")[:, component - 1]
    return float(values.max() if largest else values.min())


def mean_stress(points: Points, component: int) -> float:
    """Volume-weighted mean of a stress component over the points, 1 = 11, 2 = 22 ... [stress]."""
    return float(np.average(points.field("stress")[:, component - 1], weights=points.field("volume")))


def column_stress_error(points: Points, height: float, unit_weight: float, axis: int = 2) -> float:
    """Stress error of the self-weight column, sum |s - s(X)| V / (g l0 sum V) [-].

    s(X) = -g (l0 - X) with X the height of the point at the start, V its volume at the start.
    Source of the measure: AMPLE's column (Coombs & Augarde 2020). It depends neither on the constitutive law nor on the
    time integration, because the column is statically determinate. See column_position_error.
    """
    start = points.field("position")[:, axis - 1] - points.field("displacement")[:, axis - 1]
    error = np.abs(points.field("stress")[:, axis - 1] + unit_weight * (height - start))
    return float(np.average(error, weights=points.field("initial_volume")) / (unit_weight * height))


def column_position_error(points: Points, height: float, unit_weight: float, young: float, axis: int = 2) -> float:
    """Position error of the self-weight column, Hencky's law, sum |x - x(X)| V / (l0 sum V) [-].

    x(X) is the position of a point initially at X in the closed form, V its volume at the start.
    """
    now = points.field("position")[:, axis - 1]
    start = now - points.field("displacement")[:, axis - 1]
    exact = np.array([column_position_hencky(float(x), height, young, unit_weight) for x in start])
    return float(np.average(np.abs(now - exact), weights=points.field("initial_volume")) / height)


def uniform_stress_error(points: Points, component: int, stress: float) -> float:
    """Largest error of a stress component over all points, |s - stress| / |stress|, 1 = 11, 2 = 22 ... [-]."""
    return float(np.abs(points.field("stress")[:, component - 1] - stress).max() / abs(stress))


def _pressure_error(points: Points, pressure: float, components: list[int]) -> Array:
    stress = points.field("stress")[:, np.array(components) - 1]
    return np.asarray((stress + pressure * (np.array(components) <= 3)) / pressure)


def uniform_pressure_error(points: Points, pressure: float, components: list[int]) -> float:
    """Largest error of stress components under a uniform pressure, shear included, over all points [-].

    Components count 1 = 11, 2 = 22, 3 = 33, 4 = 12 ...; |s + p| / p of normal stresses, |s| / p of shear.
    """
    return float(np.abs(_pressure_error(points, pressure, components)).max())


def uniform_pressure_rms(points: Points, pressure: float, components: list[int]) -> float:
    """Root mean square of the same error over points and components [-]."""
    return float(np.sqrt(np.mean(_pressure_error(points, pressure, components) ** 2)))


def confined_strain_error(points: Points, strain: float) -> float:
    """Largest error of the strain over all points in confined compression, |1 - V/V0 - e| / e [-]."""
    own = 1 - points.field("volume") / points.field("initial_volume")
    return float(np.abs(own - strain).max() / abs(strain))


def followed_rows(rows: Array, base: float, plate: float, pushed: float) -> Array:
    """Grid rows that followed a plate displaced from `plate` by `pushed`, as *MOVING MESH moves them.

    Rows between base and plate scale, rows beyond the plate shift, rows behind the base do not move.
    """
    share = np.clip((rows - base) / (plate - base), 0.0, 1.0)
    return rows - share * pushed


def pressure_scatter(points: Points, strength: float, base: float, plate: float) -> float:
    """Scatter of the pressure inside the cells of a plane grid whose rows follow a plate, divided by a strength [-].

    Volume-weighted standard deviation of the mean stress of the points in one cell, root mean square over
    all cells weighted by their volume. The plate has moved down by the load factor of the state. A point outside
    the grid, or no cell with two points in it, is an error.
    """
    place, volume = points.field("position"), points.field("volume")
    pressure = points.field("stress")[:, :3].mean(axis=1)
    lines = np.unique(points.nodes[:, 0])
    rows = followed_rows(np.unique(points.nodes[:, 1]), base, plate, points.load_factor)
    column, row = np.searchsorted(lines, place[:, 0]) - 1, np.searchsorted(rows, place[:, 1]) - 1
    if column.min() < 0 or row.min() < 0 or column.max() > len(lines) - 2 or row.max() > len(rows) - 2:
        raise ResultError(f"{points.path}: a material point is outside the grid")
    _, cell = np.unique(column * len(rows) + row, return_inverse=True)
    if cell.max() + 1 == len(cell):
        raise ResultError(f"{points.path}: no cell contains two material points")
    mean = np.bincount(cell, volume * pressure) / np.bincount(cell, volume)
    return float(np.sqrt(np.average((pressure - mean[cell]) ** 2, weights=volume)) / strength)


MEASURES: dict[str, Measure] = {
    f.__name__: f
    for f in (
        total_volume,
        volume_within,
        share_above,
        extreme_stress,
        mean_stress,
        column_stress_error,
        column_position_error,
        uniform_stress_error,
        uniform_pressure_error,
        uniform_pressure_rms,
        confined_strain_error,
        pressure_scatter,
    )
}
"""Functions that a case file may name."""
