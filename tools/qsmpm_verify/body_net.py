"""A plane body as a triangular mesh over its material points, up to its boundary.

The mesh is the Delaunay triangulation of the initial positions, one for each material; triangles wider than the spacing of the
points are gaps and omitted. The spacing is measured in extents of the initial cell of each point, along either axis: in
elongated cells it differs between the directions. Points are half a spacing inside the boundary: a rim
of this width is added, up to the outline of the body if it is known, and moves with the deformation gradient of the
adjacent triangles. Triangles stretched apart since are omitted as well: none connects two separate parts.
"""

from __future__ import annotations

from dataclasses import dataclass

import matplotlib.tri as tri
import numpy as np
from scipy.spatial import cKDTree

from qsmpm_verify.outlines import Outline, snapped
from qsmpm_verify.results import Array

# A lattice has triangles of 0.71 spacings around their centre, neighbours of twice the spacing 1.1.
WIDEST = 1.25
# Inside the outline of a body points may stand further apart one way than the other; a cut is wider still.
WIDEST_INSIDE = 3.0
# Slip surfaces draw triangles out and keep their area; what has grown to so many times its area, or that of neighbours, opens a gap.
TORN = 3.0
# Neighbours that started so much nearer than they are, on such a share of the points, started in one another.
OVERLAP = 0.4
LEAST_OVERLAP = 0.01
# Places on the edge of a triangle that tell whether it lies inside.
SHARES = (0.1, 0.3, 0.45, 0.55, 0.7, 0.9)
# A rim that turned over or was drawn out is held at this many times its width at the start.
LONGEST_RIM = 1.5
# A rim that started on a side of the mesh is there as long as its point is not further than so many times its width.
BESIDE = 2.5


@dataclass(frozen=True)
class Net:
    """Triangles over initial and current positions, the point that gives the value of each position, and the outline as pairs of positions."""

    before: Array
    now: Array
    triangles: Array
    source: Array
    outline: Array


def spacings(start: Array, net: Array, extents: Array) -> Array:
    """Spacing of each point from its neighbours in extents of its cell: the mean of its two shortest edges in a triangulation."""
    edges = np.unique(np.sort(np.concatenate([net[:, [0, 1]], net[:, [1, 2]], net[:, [2, 0]]]), axis=1), axis=0)
    ends = np.concatenate([edges[:, 0], edges[:, 1]])
    apart = np.tile(start[edges[:, 0]] - start[edges[:, 1]], (2, 1))
    lengths = np.linalg.norm(apart / extents[ends], axis=1)
    order = np.lexsort((lengths, ends))
    count = np.bincount(ends, minlength=len(start))
    first = (np.cumsum(count) - count)[count > 0]
    found = np.zeros(len(start))
    # A point of a net has two edges or more.
    found[count > 0] = 0.5 * (lengths[order[first]] + lengths[order[first + 1]])
    return found


def _areas(places: Array, triangles: Array) -> Array:
    """Areas of triangles, negative for inverted ones."""
    a, b, c = (places[triangles[:, i]] for i in range(3))
    return 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])


def _circumradii(places: Array, triangles: Array) -> Array:
    """Circumradius of each triangle; infinite for flat ones."""
    a, b, c = (places[triangles[:, i]] for i in range(3))
    sides = [np.linalg.norm(p - q, axis=1) for p, q in ((b, c), (c, a), (a, b))]
    area = np.abs(_areas(places, triangles))
    with np.errstate(divide="ignore", invalid="ignore"):
        radii = sides[0] * sides[1] * sides[2] / (4.0 * area)
    return np.where(area > 1e-12 * np.max(sides) ** 2, radii, np.inf)


def _boundary(triangles: Array) -> tuple[Array, Array]:
    """Directed edges that belong to one triangle only, with the body on their left, and the opposite corner of each."""
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    opposite = np.concatenate([triangles[:, 2], triangles[:, 0], triangles[:, 1]])
    _, first, counts = np.unique(np.sort(edges, axis=1), axis=0, return_index=True, return_counts=True)
    return edges[first[counts == 1]], opposite[first[counts == 1]]


def _gradients(before: Array, now: Array, triangles: Array) -> Array:
    """Deformation gradient at each position, the area-weighted mean of the adjacent triangles."""
    a, b, c = (triangles[:, i] for i in range(3))
    old = np.stack([before[b] - before[a], before[c] - before[a]], axis=2)
    new = np.stack([now[b] - now[a], now[c] - now[a]], axis=2)
    area = np.abs(np.linalg.det(old))
    parts = (new @ np.linalg.inv(old)) * area[:, None, None]
    total, weight = np.zeros((len(before), 2, 2)), np.zeros(len(before))
    for corner in (a, b, c):
        np.add.at(total, corner, parts)
        np.add.at(weight, corner, area)
    total[weight == 0], weight[weight == 0] = np.eye(2), 1.0
    return total / weight[:, None, None]


def _outward(before: Array, edges: Array, opposite: Array, extents: Array) -> tuple[Array, Array]:
    """Points of the boundary and the vector from each half a spacing outwards, longer at corners.

    The spacing across an edge is the height of its triangle, in extents of the cell of its point: at a corner of elongated cells
    both sides are then equally far away.
    """
    total, width, count = np.zeros_like(before), np.zeros(len(before)), np.zeros(len(before))
    for corner in (edges[:, 0], edges[:, 1]):
        along = (before[edges[:, 1]] - before[edges[:, 0]]) / extents[corner]
        normals = np.stack([along[:, 1], -along[:, 0]], axis=1) / np.linalg.norm(along, axis=1)[:, None]
        height = np.abs(np.sum((before[opposite] - before[edges[:, 0]]) / extents[corner] * normals, axis=1))
        np.add.at(total, corner, normals)
        np.add.at(width, corner, 0.5 * height)
        np.add.at(count, corner, 1.0)
    rim = np.flatnonzero(count)
    mean = total[rim] / count[rim, None]
    # Both sides of a corner are half a spacing away from its points: the mean normal over its square; held at sharp ones.
    size = np.maximum(np.sum(mean**2, axis=1), 0.5)
    return rim, (width[rim] / count[rim] / size)[:, None] * mean * extents[rim]


def _skirts(places: Array, first: Array, last: Array, first_out: Array, last_out: Array) -> Array:
    """Two triangles between each edge and its rim, divided by the diagonal inside: at a re-entrant corner one is outside."""
    cuts = [((last, first, first_out), (last, first_out, last_out)), ((last, first, last_out), (first, first_out, last_out))]
    pairs = [[np.stack(corners, axis=1) for corners in cut] for cut in cuts]
    least = [np.minimum(_areas(places, one), _areas(places, other)) for one, other in pairs]
    better = (least[1] > least[0])[:, None]
    return np.concatenate([np.where(better, pairs[1][k], pairs[0][k]) for k in range(2)])


def _held(start: Array, width: Array, point: Array, edge: Array, sides: Array) -> Array:
    """Points of a rim of given width along the axes: none outside the mesh, and those that started on its sides and remained there stay on them."""
    near = 1e-6 * np.ptp(sides, axis=0).max()
    within = np.all((point >= sides[0]) & (point <= sides[1]), axis=1)[:, None]
    edge = np.where(within, np.clip(edge, sides[0], sides[1]), edge)
    for side in sides:
        stays = within & (np.abs(start - side) <= near) & (np.abs(point - side) <= BESIDE * width)
        edge = np.where(stays, side, edge)
    return edge


def _with_rim(before: Array, now: Array, triangles: Array, spacing: Array, extents: Array, outline: Outline) -> Net:
    """The mesh of the points, `spacing` (n, 2) along the axes, with the rim."""
    edges, opposite = _boundary(triangles)
    rim, out = _outward(before, edges, opposite, extents)
    out = snapped(before[rim] + out, spacing[rim], outline, outline.owners(before[rim])) - before[rim]
    moved = np.einsum("pij,pj->pi", _gradients(before, now, triangles)[rim], out)
    length, most = np.linalg.norm(moved, axis=1), LONGEST_RIM * np.linalg.norm(out, axis=1)
    moved *= np.minimum(1.0, most / np.maximum(length, 1e-300))[:, None]
    edge = now[rim] + moved
    if outline.sides is not None:
        edge = _held(before[rim] + out, np.abs(out), now[rim], edge, outline.sides)
    number = np.zeros(len(before), dtype=int)
    number[rim] = len(before) + np.arange(len(rim))
    first, last = edges[:, 0], edges[:, 1]
    places = np.concatenate([before, before[rim] + out])
    skirts = _skirts(places, first, last, number[first], number[last])
    return Net(
        places, np.concatenate([now, edge]),
        np.concatenate([triangles, skirts]), np.concatenate([np.arange(len(before)), rim]),
        np.stack([number[first], number[last]], axis=1),
    )  # fmt: skip


def _lies_inside(outline: Outline, corners: Array) -> Array:
    """Whether triangles are inside a body, from their centres and points on each edge, which may cross a re-entrant corner."""
    found = outline.inside(corners.mean(axis=1))
    # The middle of an edge may be where two bodies meet, which is in neither.
    for share in SHARES:
        for k in range(3):
            found &= outline.inside((1 - share) * corners[:, k] + share * corners[:, (k + 1) % 3])
    return found


def _bridges(outline: Outline, start: Array, triangles: Array) -> Array:
    """Whether triangles connect two bodies across an area that is in neither."""
    owner = outline.owners(start)[triangles]
    found = np.all(owner >= 0, axis=1) & (np.ptp(owner, axis=1) > 0)
    found[found] = ~_lies_inside(outline, start[triangles[found]])
    return found


def _bodies(outline: Outline, start: Array, place: Array, triangles: Array, extents: Array, spacing: Array) -> Array:
    """Triangles that are inside a body and bridge no gap, for points with a given `spacing` in `extents` of their cells."""
    widest, narrowest = extents[triangles].max(axis=1), extents[triangles].min(axis=1)
    local = np.maximum(spacing[triangles].max(axis=1), 1e-300)
    scaled = start[triangles] / widest[:, None, :]
    radius = _circumradii(scaled.reshape(-1, 2), np.arange(3 * len(triangles)).reshape(-1, 3)) / local
    torn = np.abs(_areas(place, triangles)) > TORN * np.maximum(_areas(start, triangles), 0.5 * local**2 * widest.prod(axis=1))
    near = (radius <= WIDEST) & ~torn
    # Beside long cells the gap that short ones leave looks narrow.
    doubtful = np.flatnonzero(near & (radius * (widest / narrowest).max(axis=1) > WIDEST))
    doubtful = doubtful[outline.bare(start[triangles[doubtful]])]
    near[doubtful] = _lies_inside(outline, start[triangles[doubtful]])
    wide = np.flatnonzero((radius > WIDEST) & ~torn)
    wide = wide[_lies_inside(outline, start[triangles[wide]])]
    near[wide] = radius[wide] <= WIDEST_INSIDE
    return near & ~_bridges(outline, start, triangles)


def net_of(start: Array, place: Array, outline: Outline) -> Net | None:
    """The mesh of points with initial positions `start` and current positions `place` (each with 2 columns); none for fewer than three."""
    if len(start) < 3 or np.linalg.matrix_rank(start - start[0], tol=1e-9 * np.ptp(start)) < 2:
        return None
    cells = outline.cells
    triangles = tri.Triangulation(*(start if cells is None else cells.even(start)).T).get_masked_triangles()
    extents = np.ones_like(start) if cells is None else cells.extents_at(start)
    turned = _areas(start, triangles) < 0
    triangles[turned] = triangles[turned][:, [0, 2, 1]]
    own = outline.of(start, triangles, _areas(start, triangles))
    spacing = spacings(start, triangles, extents)
    kept = _bodies(own, start, place, triangles, extents, spacing)
    return _with_rim(start, place, triangles[kept], spacing[:, None] * extents, extents, own) if kept.any() else None


def _overlap(start: Array, place: Array) -> bool:
    """Whether initial positions of different groups overlap: a lift that fills the settlement below it."""
    if len(start) < 3:
        return False
    near = [cKDTree(where).query(where, k=2)[0][:, 1] for where in (start, place)]
    return bool(np.mean(near[0] < OVERLAP * near[1]) > LEAST_OVERLAP)


def nets_of(start: Array, place: Array, kinds: Array, outline: Outline) -> list[tuple[Net, Array]]:
    """A mesh for each group of points, with the numbers of its points; in the current positions if the initial ones overlap."""
    found = []
    for kind in np.unique(kinds):
        members = np.flatnonzero(kinds == kind)
        if _overlap(start[members], place[members]):
            net = net_of(place[members], place[members], Outline(cells=outline.cells, filled=outline.filled))
        else:
            net = net_of(start[members], place[members], outline)
        if net is not None:
            found.append((net, members))
    return found
