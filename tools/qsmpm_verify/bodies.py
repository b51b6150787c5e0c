"""States of a run as plane bodies, with a common view."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from qsmpm_verify.fields import unit_of
from qsmpm_verify.outlines import outline_of
from qsmpm_verify.plane_picture import BAR, Body, Frame
from qsmpm_verify.results import Array, Mesh, Points
from qsmpm_verify.surroundings import Surroundings
from qsmpm_verify.told import materials, units

# What is seen of a rigid body beyond the soil, over the size of the soil.
BODY_ROOM = 0.12


def is_flat(states: list[Points]) -> bool:
    """Whether all points are in a plane."""
    places = np.concatenate([points.field("position") for points in states])
    return bool(np.ptp(places[:, 2]) <= 1e-9 * np.ptp(places, axis=0).max())


def start_of(points: Points) -> Array:
    """Initial positions of the points."""
    return points.field("position") - points.field("displacement")


def frame_of(states: list[Points], values: list[Array], field: str, title: str, ends: Sequence[float] = ()) -> Frame:
    """A common view and colour scale for all states of a plane body."""
    everything = np.concatenate([p for points in states for p in (start_of(points), points.field("position"))])[:, :2]
    low, high = _view(everything.min(axis=0), everything.max(axis=0), [points.around for points in states])
    least, most = ends or (min(v.min() for v in values), max(v.max() for v in values))
    folder = states[0].path.parent
    names = materials(folder) if field == "material" else {}
    return Frame(low, high, least, most, field, title, names, units(folder).get("LENGTH", ""),
                 max(points.around.pressure for points in states), unit_of(folder, "pressure"))


def _view(low: Array, high: Array, around: list[Surroundings]) -> tuple[Array, Array]:
    """Corners of a view of the soil between two corners, with space for the nearest part of the bodies and for the water."""
    size = float((high - low).max())
    least, most = low - 0.04 * size, high + 0.04 * size
    for state in around:
        for shown in (body.area(size) for body in state.bodies):
            if shown is not None:
                least = np.minimum(least, np.maximum(shown.min(axis=0), low - BODY_ROOM * size))
                most = np.maximum(most, np.minimum(shown.max(axis=0), high + BODY_ROOM * size))
        if state.pressure > 0:
            ends = state.bars(BAR * size / state.pressure).reshape(-1, 2)
            least, most = np.minimum(least, ends.min(axis=0) - 0.02 * size), np.maximum(most, ends.max(axis=0) + 0.02 * size)
        for line in state.water:
            most[1] = max(most[1], min(line[:, 1].max() + 0.04 * size, high[1] + size))
    return least, most


def body_of(points: Points, values: Array, mesh: Mesh) -> Body:
    """A state as a plane body; materials are separate."""
    kinds, start = points.fields.get("material", np.zeros(len(values))), start_of(points)[:, :2]
    flow = None
    if "darcy_velocity" in points.fields and np.array_equal(values, points.fields["head"]):
        flow = np.where(points.field("pore_pressure")[:, None] > 0, points.field("darcy_velocity")[:, :2], np.nan)
    return Body(start, points.field("position")[:, :2], values, kinds, outline_of(points.path.parent, mesh, start),
                points.around, flow)
