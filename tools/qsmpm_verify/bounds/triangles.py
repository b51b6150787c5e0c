"""Triangles whose edges are on the lines of the geometry, and bisection of marked triangles.

Edges of the lines are bisected until no vertex is inside the circle over one of them: each is then an edge of the Delaunay triangulation (Ruppert 1995).
Triangles that are too large or too thin get a vertex at their circumcentre, unless it is inside the circle over an edge, which is
bisected instead. Near an acute corner edges end at powers of two from it, so that the bisection terminates.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial import Delaunay, cKDTree

from qsmpm_verify.bounds.lines import cross
from qsmpm_verify.results import Array
from qsmpm_verify.trouble import Trouble

ROUNDS = 80
# Shortest over longest edge allowed in the circle: sine of 22 degrees, twice.
THIN = 2.0 * math.sin(math.radians(22.0))


@dataclass(frozen=True)
class Triangles:
    """Vertices and corners, counter-clockwise; the first two corners are the ends of the edge that is bisected next."""

    places: Array
    corners: Array

    def areas(self) -> Array:
        """Area of each triangle."""
        a, b, c = (self.places[self.corners[:, k]] for k in range(3))
        return np.asarray(cross(b - a, c - a) / 2.0)


def _halved(places: Array, edges: Array, which: Array, corners: int) -> tuple[Array, Array]:
    """Edges divided in two: at the midpoint, or at a power of two from an end that is a corner of the geometry."""
    a, b = places[edges[which, 0]], places[edges[which, 1]]
    length = np.linalg.norm(b - a, axis=1)
    share = np.full(len(which), 0.5)
    first, second = edges[which, 0] < corners, edges[which, 1] < corners
    shell = 2.0 ** np.round(np.log2(length / 2.0)) / length
    share = np.where(first & ~second, shell, np.where(second & ~first, 1.0 - shell, share))
    new = len(places) + np.arange(len(which))
    middle = a + share[:, None] * (b - a)
    kept = np.delete(edges, which, axis=0)
    halves = np.vstack([np.stack([edges[which, 0], new], 1), np.stack([new, edges[which, 1]], 1)])
    return np.vstack([places, middle]), np.vstack([kept, halves])


def _encroached(places: Array, edges: Array, others: Array) -> Array:
    """Edges whose circle contains a vertex other than their ends."""
    middle = places[edges].mean(axis=1)
    radius = np.linalg.norm(places[edges[:, 0]] - middle, axis=1)
    tree = cKDTree(others)
    count = min(3, len(others))
    apart, near = tree.query(middle, count)
    apart, near = apart.reshape(len(edges), count), near.reshape(len(edges), count)
    own = np.linalg.norm(others[near] - places[edges[:, 0]][:, None], axis=-1) < 1e-9 * radius[:, None]
    own |= np.linalg.norm(others[near] - places[edges[:, 1]][:, None], axis=-1) < 1e-9 * radius[:, None]
    return np.asarray(np.any((apart < radius[:, None] * (1.0 - 1e-9)) & ~own, axis=1))


def _circles(places: Array, corners: Array) -> tuple[Array, Array]:
    """Circumcentres and radii of triangles."""
    a, b, c = (places[corners[:, k]] for k in range(3))
    u, v = b - a, c - a
    twice = 2.0 * cross(u, v)
    uu, vv = (u**2).sum(1), (v**2).sum(1)
    centre = np.stack([v[:, 1] * uu - u[:, 1] * vv, u[:, 0] * vv - v[:, 0] * uu], 1) / twice[:, None]
    return a + centre, np.linalg.norm(centre, axis=1)


def _shortest(places: Array, corners: Array) -> Array:
    """Shortest edge of each triangle."""
    return np.asarray(np.min([np.linalg.norm(places[corners[:, k]] - places[corners[:, k - 1]], axis=1) for k in range(3)], axis=0))


def _spread(centres: Array, radii: Array) -> Array:
    """Vertices to be added that are not too close to each other, the larger circles first."""
    taken: list[int] = []
    for k in np.argsort(-radii, kind="stable"):
        if not taken or np.min(np.linalg.norm(centres[taken] - centres[k], axis=1) / np.maximum(radii[taken], radii[k])) > 0.8:
            taken.append(int(k))
    return np.array(taken, dtype=int)


def _delaunay(places: Array, box: Array) -> Array:
    """Triangulation of all vertices, with distant corners around them."""
    hull = Delaunay(np.vstack([places, box]))
    found = hull.simplices
    all_places = hull.points
    turn = cross(all_places[found[:, 1]] - all_places[found[:, 0]], all_places[found[:, 2]] - all_places[found[:, 0]])
    found = np.where((turn < 0)[:, None], found[:, ::-1], found)
    return np.asarray(found[(found < len(places)).all(axis=1)])


def _there(corners: Array, edges: Array, count: int) -> Array:
    """Which edges are edges of triangles: for four vertices on one circle there is a choice."""
    pairs = np.sort(np.stack([corners, np.roll(corners, -1, axis=1)], axis=2), axis=2).reshape(-1, 2)
    low, high = np.sort(edges, axis=1).T
    return np.asarray(np.isin(low * count + high, pairs[:, 0].astype(np.int64) * count + pairs[:, 1]))


def triangulate(corners: Array, edges: Array, belongs: Callable[[Array], Array], size: float) -> Triangles:
    """Triangles up to a given size whose centre is inside the ground."""
    places, count = corners, len(corners)
    low, high = corners.min(axis=0), corners.max(axis=0)
    extent = float((high - low).max())
    middle = (low + high) / 2.0
    box = middle + 8.0 * extent * np.array([[-1.0, -1.03], [1.01, -1.0], [0.98, 1.0], [-1.0, 0.99]])
    for turn in range(2 * ROUNDS):
        long = np.linalg.norm(places[edges[:, 1]] - places[edges[:, 0]], axis=1) > 1.2 * size
        split = np.flatnonzero(long | _encroached(places, edges, places))
        if len(split):
            places, edges = _halved(places, edges, split, count)
            continue
        found = _delaunay(places, box)
        lost = np.flatnonzero(~_there(found, edges, len(places)))
        if len(lost):
            places, edges = _halved(places, edges, lost, count)
            continue
        found = found[belongs(places[found].mean(axis=1))]
        if turn >= ROUNDS:
            break
        centre, radius = _circles(places, found)
        shortest = _shortest(places, found)
        bad = (radius > 0.72 * size) | ((shortest < THIN * radius) & (shortest > 0.02 * size))
        bad &= belongs(centre)
        which = np.flatnonzero(bad)
        if not len(which):
            break
        which = which[_spread(centre[which], radius[which])]
        new = centre[which]
        hit = _encroached(places, edges, new)
        if hit.any():
            places, edges = _halved(places, edges, np.flatnonzero(hit), count)
        else:
            places = np.vstack([places, new])
    else:
        raise Trouble("no triangular mesh can be generated between the lines of the geometry: some meet at too small an angle")
    return with_longest_first(places, found)


def with_longest_first(places: Array, corners: Array) -> Triangles:
    """Used vertices only; the longest edge of each triangle is bisected first."""
    used, numbers = np.unique(corners, return_inverse=True)
    places, corners = places[used], numbers.reshape(corners.shape)
    length = np.stack([np.linalg.norm(places[corners[:, (k + 1) % 3]] - places[corners[:, k]], axis=1) for k in range(3)], 1)
    first = np.argmax(length.round(12), axis=1)
    turned = np.stack([corners[np.arange(len(corners)), (first + k) % 3] for k in range(3)], 1)
    return Triangles(places, turned)


def numbered_edges(corners: Array) -> tuple[Array, Array]:
    """Edges by their ends in ascending order, and their numbers on each triangle: between its corners 0 1, 1 2, 2 0."""
    pairs = np.sort(np.stack([corners, np.roll(corners, -1, axis=1)], axis=2), axis=2)
    edges, number = np.unique(pairs.reshape(-1, 2), axis=0, return_inverse=True)
    return edges, number.reshape(-1, 3)


def halve(mesh: Triangles, marked: Array, opposite: Array | None = None) -> Triangles:
    """Bisect all edges of marked triangles, and others as needed for a conforming mesh (newest-vertex bisection).

    `opposite` are further edges to bisect, as triangle and edge number."""
    edges, number = numbered_edges(mesh.corners)
    cut = np.zeros(len(edges), dtype=bool)
    cut[number[marked].ravel()] = True
    if opposite is not None:
        cut[number[opposite[:, 0], opposite[:, 1]]] = True
    while True:
        need = cut[number].any(axis=1) & ~cut[number[:, 0]]
        if not need.any():
            break
        cut[number[need, 0]] = True
    new = np.full(len(edges), -1)
    new[cut] = len(mesh.places) + np.arange(int(cut.sum()))
    places = np.vstack([mesh.places, mesh.places[edges[cut]].mean(axis=1)])
    a, b, c = mesh.corners.T
    m, right, left = new[number].T
    whole = m < 0
    parts = [mesh.corners[whole]]
    for half, side in (((c, a, m), left), ((b, c, m), right)):
        p, q, r = half
        plain, twice = ~whole & (side < 0), ~whole & (side >= 0)
        parts.append(np.stack([p, q, r], 1)[plain])
        parts += [np.stack([r, p, side], 1)[twice], np.stack([q, r, side], 1)[twice]]
    return Triangles(places, np.vstack(parts))


def cut_at(mesh: Triangles, places: Array) -> Triangles:
    """Bisect triangles at some corners through these corners, and their neighbours across, each at most once."""
    _, number = numbered_edges(mesh.corners)
    wanted: list[int] = []
    used: set[int] = set()
    beside: dict[int, list[tuple[int, int]]] = {}
    for triangle, row in enumerate(number):
        for k, edge in enumerate(row):
            beside.setdefault(int(edge), []).append((triangle, k))
    for triangle, k in np.argwhere(np.isin(mesh.corners, places)):
        edge = int(number[triangle, (k + 1) % 3])
        both = {t for t, _ in beside[edge]}
        if not both & used:
            used |= both
            wanted.append(edge)
    new_places, corners = [mesh.places], [np.delete(mesh.corners, sorted(used), axis=0)]
    for count, edge in enumerate(wanted):
        middle = len(mesh.places) + count
        for triangle, k in beside[edge]:
            a, b, c = (int(mesh.corners[triangle, (k + turn) % 3]) for turn in range(3))
            corners.append(np.array([(a, middle, c), (middle, b, c)]))
        a, b = (mesh.corners[beside[edge][0][0], (beside[edge][0][1] + turn) % 3] for turn in range(2))
        new_places.append((mesh.places[a] + mesh.places[b])[None] / 2.0)
    return with_longest_first(np.vstack(new_places), np.vstack(corners))
