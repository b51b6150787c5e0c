"""Heads that are linear on triangles: at points, and the phreatic surface, where the head equals the elevation."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from qsmpm_verify.bounds.deformed import thinned
from qsmpm_verify.bounds.lines import cross, distance, merged
from qsmpm_verify.results import Array
from qsmpm_verify.surroundings import chain

# Triangles with the nearest centres that a place is looked for in.
BESIDE = 50
# Shares of an edge: how far the surface of the water may be off where a vertex is left out, and within what distance of an outline it has none.
SLACK, ASIDE = 0.02, 0.25


@dataclass(frozen=True)
class Heads:
    """Triangles of the program that contain ground, and the heads at their corners (n, 3)."""

    places: Array
    corners: Array
    values: Array

    def at(self, places: Array) -> Array:
        """Heads at points (n, 2)."""
        own, share = shares(self.places[self.corners], places)
        return np.asarray(np.sum(share * self.values[self.corners[own]], axis=1))

    def surface(self, outlines: Array) -> Iterable[Array]:
        """Lines of zero pressure; where such a line follows an outline, as on a seepage face, there is none."""
        ends = self.corners[:, [[0, 1], [1, 2], [2, 0], [1, 0], [2, 1], [0, 2]]].reshape(-1, 2)
        long = np.linalg.norm(self.places[ends[:, 1]] - self.places[ends[:, 0]], axis=1)
        edge = float(long.max())
        rise = self.values - self.places[:, 1]
        rise[np.abs(rise) < 1e-6 * edge] = 0.0
        cut = (rise[ends[:, 0]] > 0.0) & (rise[ends[:, 1]] <= 0.0)
        wet, dry = ends[cut].T
        line = self.places[wet] + (rise[wet] / (rise[wet] - rise[dry]))[:, None] * (self.places[dry] - self.places[wet])
        apart = distance(line, *np.moveaxis(outlines, 1, 0)).min(axis=1)
        line, _ = merged(line[(apart > ASIDE * long[cut]) | ((apart < 1e-6 * edge) & (rise[dry] < 0.0))], 1e-6 * edge)
        line = line[chain(line)] if len(line) else line
        for piece in np.split(line, np.flatnonzero(np.linalg.norm(np.diff(line, axis=0), axis=1) > edge) + 1):
            kept = thinned(piece, SLACK * edge) if len(piece) > 1 else piece
            yield np.stack([kept[:-1], kept[1:]], axis=1)


def shares(corners: Array, places: Array) -> tuple[Array, Array]:
    """The triangle (n, 3, 2) of each point, and its linear functions there; outside all triangles those of the nearby boundary."""
    near = cKDTree(corners.mean(axis=1)).query(places, k=range(1, min(BESIDE, len(corners)) + 1))[1]
    a, b, c = (corners[near, k] for k in range(3))
    apart = places[:, None] - a
    share = np.stack([cross(apart, c - a), cross(b - a, apart)], -1) / cross(b - a, c - a)[..., None]
    share = np.concatenate([1.0 - share.sum(-1, keepdims=True), share], -1)
    best = np.arange(len(places)), np.argmax(share.min(-1), axis=1)
    inside = np.maximum(share[best], 0.0)
    return near[best], inside / inside.sum(axis=1, keepdims=True)
