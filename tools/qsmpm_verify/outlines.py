"""Outlines of the bodies of a plane run at its start, as segments: those the deck names, else those of the cells with points."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

import matplotlib.tri as tri
import numpy as np
from matplotlib.path import Path as MplPath

from qsmpm_verify.results import Array, Mesh
from qsmpm_verify.study.cards import Card, Deck, read_deck
from qsmpm_verify.trouble import Trouble

# Corners of the plane cells of VTK; they come first in a cell.
CORNERS = {5: 3, 22: 3, 9: 4, 23: 4, 28: 4}


def _polygon(body: Card) -> Array | None:
    """Corners of a body whose shape the deck tells."""
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


@dataclass(frozen=True)
class Outline:
    """What is known of the bodies at the start: polygons, and cells with points with their bounds (n, 2 ends, 2).

    `sides` are the lowest and highest coordinates of a mesh that stays where it is, (2, 2); soil does not leave it.
    """

    polygons: tuple[Array, ...] = ()
    bounds: Array = field(default_factory=lambda: np.zeros((0, 2, 2)))
    cells: tri.TriFinder | None = None
    filled: Array | None = None
    sides: Array | None = None

    @property
    def segments(self) -> Array:
        """Segments of all outlines, (n, 2 ends, 2)."""
        return np.concatenate([*(np.stack([c, np.roll(c, -1, axis=0)], axis=1) for c in self.polygons), self.bounds])

    def of(self, start: Array, triangles: Array, areas: Array) -> Outline:
        """What is left when bodies without these points are taken away: dug out, not built yet, or of another material."""
        held = (MplPath(corners).contains_points(start)[triangles].all(axis=1) for corners in self.polygons)
        kept = tuple(c for c, mine in zip(self.polygons, held) if np.sum(areas[mine]) > LEAST_COVER * _area(c))
        return replace(self, polygons=kept)

    def inside(self, places: Array) -> Array:
        """Whether places lie in a body."""
        found = np.zeros(len(places), dtype=bool)
        for corners in self.polygons:
            found |= MplPath(corners).contains_points(places)
        if self.cells is not None and self.filled is not None:
            cell = np.asarray(self.cells(*places.T), dtype=int)
            found |= (cell >= 0) & self.filled[cell]
        return found


NOTHING = Outline()


def _area(corners: Array) -> float:
    """Area of a polygon."""
    x, y = corners.T
    return 0.5 * abs(float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))))


def _of_cells(mesh: Mesh, start: Array) -> Outline:
    """The cells with points, and their edges that belong to one of them only."""
    cells = [cell[: CORNERS[int(kind)]] for kind, cell in zip(mesh.types, mesh.cells) if int(kind) in CORNERS]
    fans = np.array([[c[0], c[i], c[i + 1]] for c in cells for i in range(1, len(c) - 1)])
    if not len(fans):
        return NOTHING
    owner = np.repeat(np.arange(len(cells)), [len(c) - 2 for c in cells])
    finder = tri.Triangulation(mesh.nodes[:, 0], mesh.nodes[:, 1], fans).get_trifinder()
    found = np.asarray(finder(*start.T), dtype=int)
    filled = np.zeros(len(cells), dtype=bool)
    filled[owner[found[found >= 0]]] = True
    edges = np.array([(cells[c][i - 1], cells[c][i]) for c in np.flatnonzero(filled) for i in range(len(cells[c]))])
    if not len(edges):
        return NOTHING
    _, first, counts = np.unique(np.sort(edges, axis=1), axis=0, return_index=True, return_counts=True)
    return Outline((), mesh.nodes[edges[first[counts == 1]], :2], finder, filled[owner])


def _moves(deck: Deck) -> bool:
    """Whether the mesh goes with the soil or with a plate."""
    return bool(deck.all("MOVING MESH")) or any(card.value("BASIS") == "FEM" for card in deck.all("METHOD"))


def outline_of(folder: Path, mesh: Mesh, start: Array) -> Outline:
    """What the deck and the mesh of a run tell of its bodies."""
    for path in sorted(folder.glob("*.echo.inp"))[:1]:
        try:
            deck = read_deck(path)
        except Trouble:
            break
        bodies = deck.all("BODY")
        corners = tuple(c for c in map(_polygon, bodies) if c is not None)
        rest = _of_cells(mesh, start) if len(corners) < len(bodies) else NOTHING
        sides = None if _moves(deck) else np.stack([mesh.nodes.min(axis=0), mesh.nodes.max(axis=0)])[:, :2]
        return replace(rest, polygons=corners, sides=sides)
    return NOTHING


def snapped(places: Array, reach: Array, segments: Array) -> Array:
    """Places put on the nearest segment within their reach; the place nearest to a corner goes into it."""
    if not len(segments) or not len(places):
        return places
    moved = places.copy()
    first, along = segments[:, 0], segments[:, 1] - segments[:, 0]
    square = np.maximum(np.sum(along**2, axis=1), 1e-300)
    for i, place in enumerate(places):
        share = np.clip(np.sum((place - first) * along, axis=1) / square, 0.0, 1.0)
        feet = first + share[:, None] * along
        distance = np.linalg.norm(feet - place, axis=1)
        nearest = int(np.argmin(distance))
        if distance[nearest] <= reach[i]:
            moved[i] = feet[nearest]
    for corner in np.unique(segments.reshape(-1, 2), axis=0):
        distance = np.linalg.norm(moved - corner, axis=1)
        nearest = int(np.argmin(distance))
        if distance[nearest] <= CORNER_REACH * reach[nearest]:
            moved[nearest] = corner
    return moved
