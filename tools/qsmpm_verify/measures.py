"""Figures computed from all material points of a state; a case names them under `measure`."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from qsmpm_verify.results import Points

Measure = Callable[..., float]


def total_volume(points: Points) -> float:
    """Sum of the point volumes [volume]."""
    return float(points.field("volume").sum())


def extreme_stress(points: Points, component: int, largest: bool = True) -> float:
    """Largest (or smallest) value of a stress component over the points, 1 = 11, 2 = 22 ... [stress]."""
    values = points.field("stress")[:, component - 1]
    return float(values.max() if largest else values.min())


def mean_stress(points: Points, component: int) -> float:
    """Volume-weighted mean of a stress component over the points, 1 = 11, 2 = 22 ... [stress]."""
    return float(np.average(points.field("stress")[:, component - 1], weights=points.field("volume")))


def column_stress_error(points: Points, height: float, unit_weight: float, axis: int = 2) -> float:
    """Stress error of the self-weight column, sum |s - s(X)| V / (g l0 sum V) [-].

    s(X) = -g (l0 - X) with X the height of the point at the start, V its volume.
    Source of the measure: AMPLE's column (Coombs & Augarde 2020), there with the volumes at the start.
    """
    start = points.field("position")[:, axis - 1] - points.field("displacement")[:, axis - 1]
    error = np.abs(points.field("stress")[:, axis - 1] + unit_weight * (height - start))
    volume = points.field("volume")
    return float((error * volume).sum() / (unit_weight * height * volume.sum()))


MEASURES: dict[str, Measure] = {
    f.__name__: f for f in (total_volume, extreme_stress, mean_stress, column_stress_error)
}
"""The functions a case file may name."""
