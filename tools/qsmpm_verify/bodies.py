"""States of a run as plane bodies, and one view of them all."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from qsmpm_verify.outlines import outline_of
from qsmpm_verify.plane_picture import Body, Frame
from qsmpm_verify.results import Array, Mesh, Points
from qsmpm_verify.told import materials, units


def is_flat(states: list[Points]) -> bool:
    """Whether all points lie in a plane."""
    places = np.concatenate([points.field("position") for points in states])
    return bool(np.ptp(places[:, 2]) <= 1e-9 * np.ptp(places, axis=0).max())


def start_of(points: Points) -> Array:
    """Where the points started."""
    return points.field("position") - points.field("displacement")


def frame_of(states: list[Points], values: list[Array], field: str, title: str, ends: Sequence[float] = ()) -> Frame:
    """One view and one scale of colours for all states of a plane body."""
    everything = np.concatenate([p for points in states for p in (start_of(points), points.field("position"))])[:, :2]
    margin = 0.04 * float(np.ptp(everything, axis=0).max())
    least, most = ends or (min(v.min() for v in values), max(v.max() for v in values))
    folder = states[0].path.parent
    names = materials(folder) if field == "material" else {}
    return Frame(everything.min(axis=0) - margin, everything.max(axis=0) + margin, least, most, field, title, names,
                 units(folder).get("LENGTH", ""))


def body_of(points: Points, values: Array, mesh: Mesh) -> Body:
    """A state as a plane body; materials are apart from each other."""
    kinds, start = points.fields.get("material", np.zeros(len(values))), start_of(points)[:, :2]
    return Body(start, points.field("position")[:, :2], values, kinds, outline_of(points.path.parent, mesh, start))
