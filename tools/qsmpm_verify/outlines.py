"""Initial outlines of the bodies of a plane run, as segments: those defined in the deck, otherwise those of the cells with points."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from matplotlib.path import Path as MplPath

from qsmpm_verify.cells import Cells, cells_of
from qsmpm_verify.results import Array, Mesh
from qsmpm_verify.study.cards import Card, Deck, read_deck
from qsmpm_verify.trouble import Trouble

def _polygon(body: Card) -> Array | None:
    """Corners of a body whose shape is defined in the deck."""
    try:
        rows = [[float(v.lower().replace("d", "e")) for v in row] for row in body.data()]
        if body.value("SHAPE") == "BOX":
            x1, x2, y1, y2 = rows[0][:4]
            return np.array([[x1, y1], [x2, y1], [x2, y2], [x1, y2]])
        if body.value("SHAPE") == "POLYGON":
            return np.array([row[:2] for row in rows])
    except (ValueError, IndexError):
        pass
    return None


# The last point before a sharp corner is further from it than points are from a side.
CORNER_REACH = 1.5


# A polygon whose points span less than this share of its area is that of a body that is not there.
LEAST_COVER = 0.3

# Places all over a triangle, as shares of its corners.
OVER = np.array([(i, j, 6 - i - j) for i in range(7) for j in range(7 - i)]) / 6


@dataclass(frozen=True)
class Outline:
    """Initial geometry of the bodies: polygons, cells, and the boundaries (n, 2 ends, 2) of the cells with points.

    `filled` are the cells with points, and `of_cells` states that these form the bodies; otherwise only the polygons do.
    `sides` are the lowest and highest coordinates of a fixed mesh, (2, 2); soil does not leave it.
    """

    polygons: tuple[Array, ...] = ()
    bounds: Array = field(default_factory=lambda: np.zeros((0, 2, 2)))
    cells: Cells | None = None
    filled: Array = field(default_factory=lambda: np.zeros(0, dtype=bool))
    of_cells: bool = False
    sides: Array | None = None

    @property
    def segments(self) -> Array:
        """Segments of all outlines, (n, 2 ends, 2)."""
        return np.concatenate([*map(sides_of, self.polygons), self.bounds])

    def of(self, start: Array, triangles: Array, areas: Array) -> Outline:
        """The remaining bodies without these points: excavated, not yet active, or of another material."""
        held = (MplPath(corners).contains_points(start)[triangles].all(axis=1) for corners in self.polygons)
        kept = tuple(c for c, mine in zip(self.polygons, held) if np.sum(areas[mine]) > LEAST_COVER * _area(c))
        return replace(self, polygons=kept, filled=self.filled if self.cells is None else _filled(self.cells, start))

    def inside(self, places: Array) -> Array:
        """Whether points are inside a body."""
        found = np.zeros(len(places), dtype=bool)
        for corners in self.polygons:
            found |= MplPath(corners).contains_points(places)
        if self.cells is not None and self.of_cells:
            cell = self.cells.at(places)
            found |= (cell >= 0) & self.filled[cell]
        return found

    def bare(self, triangles: Array) -> Array:
        """Whether triangles (n, 3 corners, 2) cover a cell without points."""
        found = np.zeros(len(triangles), dtype=bool)
        if self.cells is None:
            return found
        for share in OVER:
            cell = self.cells.at(np.einsum("k,nkj->nj", share, triangles))
            found |= (cell >= 0) & ~self.filled[cell]
        return found

    def owners(self, places: Array) -> Array:
        """Number of the polygon that contains each point, the last one of several; -1 for none."""
        found = np.full(len(places), -1)
        for number, corners in enumerate(self.polygons):
            found[MplPath(corners).contains_points(places)] = number
        return found


NOTHING = Outline()


def sides_of(corners: Array) -> Array:
    """Sides of a polygon, (n, 2 ends, 2)."""
    return np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)


def _area(corners: Array) -> float:
    """Area of a polygon."""
    x, y = corners.T
    return 0.5 * abs(float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))))


def _filled(cells: Cells, start: Array) -> Array:
    """Which cells have points."""
    found = cells.at(start)
    filled = np.zeros(len(cells.corners), dtype=bool)
    filled[found[found >= 0]] = True
    return filled


def _of_cells(cells: Cells, filled: Array, nodes: Array) -> Array:
    """Edges of the cells with points that belong to one of them only, (n, 2 ends, 2)."""
    chosen = [cells.corners[c] for c in np.flatnonzero(filled)]
    edges = np.array([(corners[i - 1], corners[i]) for corners in chosen for i in range(len(corners))])
    if not len(edges):
        return NOTHING.bounds
    _, first, counts = np.unique(np.sort(edges, axis=1), axis=0, return_index=True, return_counts=True)
    return nodes[edges[first[counts == 1]], :2]


def _moves(deck: Deck) -> bool:
    """Whether the mesh moves with the material or with a plate."""
    return bool(deck.all("MOVING MESH")) or any(card.value("BASIS") == "FEM" for card in deck.all("METHOD"))


def outline_of(folder: Path, mesh: Mesh, start: Array) -> Outline:
    """Geometry of the bodies from the deck and the mesh of a run."""
    cells = cells_of(mesh)
    known = NOTHING if cells is None else Outline(cells=cells, filled=_filled(cells, start))
    for path in sorted(folder.glob("*.echo.inp"))[:1]:
        try:
            deck = read_deck(path)
        except Trouble:
            break
        bodies = deck.all("BODY")
        corners = tuple(c for c in map(_polygon, bodies) if c is not None)
        sides = None if _moves(deck) else np.stack([mesh.nodes.min(axis=0), mesh.nodes.max(axis=0)])[:, :2]
        known = replace(known, polygons=corners, sides=sides)
        if cells is not None and len(corners) < len(bodies):
            known = replace(known, bounds=_of_cells(cells, known.filled, mesh.nodes), of_cells=True)
    return known


def snapped(places: Array, reach: Array, outline: Outline, owners: Array) -> Array:
    """Points moved to the outline within their distance along the axes (n, 2); the point nearest to a corner moves to the corner.

    Points with an owner, the number of a polygon, move to its sides: in elongated cells another body may be nearer.
    """
    moved = places.copy()
    for number in np.unique(owners):
        mine = owners == number
        moved[mine] = _beside(places[mine], reach[mine], outline.segments if number < 0 else sides_of(outline.polygons[number]))
    for corner in np.unique(outline.segments.reshape(-1, 2), axis=0) if len(places) else []:
        distance = np.linalg.norm((moved - corner) / reach, axis=1)
        nearest = int(np.argmin(distance))
        if distance[nearest] <= CORNER_REACH:
            moved[nearest] = corner
    return moved


def _beside(places: Array, reach: Array, segments: Array) -> Array:
    """Points moved to the nearest segment within their distance."""
    if not len(segments):
        return places
    moved = places.copy()
    for i, place in enumerate(places):
        first, along = segments[:, 0] / reach[i], (segments[:, 1] - segments[:, 0]) / reach[i]
        square = np.maximum(np.sum(along**2, axis=1), 1e-300)
        share = np.clip(np.sum((place / reach[i] - first) * along, axis=1) / square, 0.0, 1.0)
        feet = first + share[:, None] * along
        distance = np.linalg.norm(feet - place / reach[i], axis=1)
        nearest = int(np.argmin(distance))
        if distance[nearest] <= 1.0:
            moved[i] = feet[nearest] * reach[i]
    return moved
