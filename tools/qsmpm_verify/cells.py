"""Cells of a plane mesh, used to evaluate its points: the cell that contains a position, its width, and positions in units of cells."""

from __future__ import annotations

from dataclasses import dataclass

import matplotlib.tri as tri
import numpy as np
from scipy.spatial import cKDTree

from qsmpm_verify.results import Array, Mesh

# Corners of the plane cells of VTK; they come first in a cell.
CORNERS = {5: 3, 22: 3, 9: 4, 23: 4, 28: 4}
# Cells that are no grid guide the points only where some are so many times longer one way than the other.
LONG = 3.0


@dataclass(frozen=True)
class Cells:
    """Corners of the cells, their centres, their extents along the axes (n, 2), and the triangles used for point location.

    All extents are one if cells are not used: if they are not a grid and none is elongated.
    `lines` are the coordinates between the columns and the rows if all cells belong to a grid along the axes.
    """

    corners: list[Array]
    middles: Array
    extents: Array
    finder: tri.TriFinder
    owner: Array
    lines: tuple[Array, Array] | None = None

    def at(self, places: Array) -> Array:
        """Number of the cell at each position; -1 outside the mesh."""
        found = np.asarray(self.finder(*places.T), dtype=int)
        return np.where(found >= 0, self.owner[found], -1)

    def extents_at(self, places: Array) -> Array:
        """Extents of the cell at each position, (n, 2); outside the mesh those of the nearest cell."""
        cell = self.at(places)
        out = cell < 0
        if out.any():
            cell[out] = cKDTree(self.middles).query(places[out])[1]
        return self.extents[cell]

    def even(self, places: Array) -> Array:
        """Positions in columns and rows of a grid, each of width one; if the cells are not a grid, in units of the median extent."""
        if self.lines is None:
            return places / np.median(self.extents, axis=0)
        return np.stack([_counted(places[:, k], self.lines[k]) for k in range(2)], axis=1)


def _counted(values: Array, lines: Array) -> Array:
    """Values as grid-line numbers, interpolated linearly and extrapolated."""
    first = np.clip(np.searchsorted(lines, values, side="right") - 1, 0, len(lines) - 2)
    return first + (values - lines[first]) / (lines[first + 1] - lines[first])


def _lines(low: Array, high: Array) -> tuple[Array, Array] | None:
    """Lines of a grid along the axes whose cells, from lower to upper bound, are all boxes or halves of boxes."""
    size = high.max(axis=0) - low.min(axis=0)
    found = []
    for k in range(2):
        ends = np.sort(np.concatenate([low[:, k], high[:, k]]))
        ends = ends[np.concatenate([[True], np.diff(ends) > 1e-9 * size[k]])]
        if np.any(np.searchsorted(ends, high[:, k] - 1e-9 * size[k]) - np.searchsorted(ends, low[:, k] - 1e-9 * size[k]) != 1):
            return None
        found.append(ends)
    return found[0], found[1]


def cells_of(mesh: Mesh) -> Cells | None:
    """The plane cells of a mesh; none if it has none, or none for point location."""
    corners = [cell[: CORNERS[int(kind)]] for kind, cell in zip(mesh.types, mesh.cells) if int(kind) in CORNERS]
    if not corners:
        return None
    # A triangle has its first corner twice.
    table = np.array([c if len(c) == 4 else [*c, c[0]] for c in corners])
    fans = np.concatenate([table[:, [0, 1, 2]], table[:, [0, 2, 3]]])
    owner = np.tile(np.arange(len(table)), 2)
    real = fans[:, 0] != fans[:, 2]
    places = mesh.nodes[table][..., :2]
    try:
        finder = tri.Triangulation(mesh.nodes[:, 0], mesh.nodes[:, 1], fans[real]).get_trifinder()
    except (RuntimeError, ValueError):
        return None
    low, high = places.min(axis=1), places.max(axis=1)
    # The mean of the corners is in a cell, the middle of its extents on the side of half a box.
    middles = np.array([mesh.nodes[c, :2].mean(axis=0) for c in corners])
    extents, lines = np.maximum(high - low, 1e-300), _lines(low, high)
    if lines is None and np.all(extents.max(axis=1) < LONG * extents.min(axis=1)):
        extents = np.ones_like(extents)
    return Cells(corners, middles, extents, finder, owner[real], lines)
