"""Surfaces of bodies in 3D: the faces of a tetrahedral mesh of neighbouring points that belong to one body only.

The mesh is that of the initial positions; tetrahedra wider than the spacing of the points, and those that have been stretched
apart since, are omitted. The surface is moved outwards by half a spacing, to the boundary of the body.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import Delaunay, cKDTree

from qsmpm_verify.results import Array

# Circumradius of a tetrahedron over the spacing of its points beyond which it bridges a gap.
WIDEST = 1.7
# Length of the longest edge over that of the start beyond which a tetrahedron is torn.
TORN = 5.0
# Length of a way outwards at a sharp edge, over that on a plane.
LONGEST = 1.8
FACES = ((1, 2, 3, 0), (0, 3, 2, 1), (0, 1, 3, 2), (0, 2, 1, 3))


@dataclass(frozen=True)
class Skin:
    """Positions of its corners, the point of each corner, its triangles, and the points inside or on the surface."""

    places: Array
    source: Array
    faces: Array
    inside: Array


def _volumes(places: Array, tetrahedra: Array) -> Array:
    """Six times the volume of tetrahedra, with its sign."""
    a, b, c, d = (places[tetrahedra[:, k]] for k in range(4))
    return np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a)


def _longest(places: Array, tetrahedra: Array) -> Array:
    """Longest edges of tetrahedra."""
    pairs = ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))
    return np.max([np.linalg.norm(places[tetrahedra[:, i]] - places[tetrahedra[:, j]], axis=1) for i, j in pairs], axis=0)


def _radii(places: Array, tetrahedra: Array) -> Array:
    """Circumradii; those of flat ones are large."""
    first = places[tetrahedra[:, 0]]
    edges = places[tetrahedra[:, 1:]] - first[:, None, :]
    flat = np.abs(np.linalg.det(edges)) < 1e-12 * np.linalg.norm(edges, axis=2).max(axis=1) ** 3
    edges[flat] = np.eye(3)
    centres = np.linalg.solve(edges, 0.5 * np.sum(edges**2, axis=2)[..., None])[..., 0]
    radii = np.linalg.norm(centres, axis=1)
    radii[flat] = np.inf
    return radii


def _outwards(places: Array, faces: Array, half: Array) -> Array:
    """Displacement of each corner to the intersection of the planes of its faces, moved outwards by half a spacing."""
    a, b, c = (places[faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    matrix, right = np.zeros((len(places), 3, 3)), np.zeros((len(places), 3))
    for k in range(3):
        np.add.at(matrix, faces[:, k], normals[:, :, None] * normals[:, None, :])
        np.add.at(right, faces[:, k], normals)
    # A weak spring keeps the way short where the faces leave a direction free.
    trace = np.trace(matrix, axis1=1, axis2=2)[:, None, None]
    way = np.linalg.solve(matrix + 1e-3 * np.maximum(trace, 1e-9) * np.eye(3), right[..., None])[..., 0]
    length = np.linalg.norm(way, axis=1, keepdims=True)
    return half[:, None] * way * np.minimum(1.0, LONGEST / np.maximum(length, 1e-300))


def skin_of(start: Array, place: Array, members: Array) -> Skin | None:
    """The surface of some of the points; none for fewer than five points or a flat body."""
    origin, now = start[members], place[members]
    if len(members) < 5 or np.linalg.matrix_rank(origin - origin[0], tol=1e-9 * np.ptp(origin)) < 3:
        return None
    spacing = np.median(cKDTree(origin).query(origin, k=4)[0][:, 1:], axis=1)
    # Points of a lattice lie on spheres by eights: a little disorder leaves one net.
    shaken = origin + 1e-5 * spacing[:, None] * np.random.default_rng(0).uniform(-1, 1, origin.shape)
    net = Delaunay(shaken).simplices
    kept = _radii(shaken, net) <= WIDEST * spacing[net].max(axis=1)
    net = net[kept & (_longest(now, net) <= TORN * _longest(shaken, net))]
    before = _volumes(shaken, net)
    net[before < 0] = net[before < 0][:, [0, 2, 1, 3]]
    if not len(net):
        return None
    faces = np.concatenate([net[:, face[:3]] for face in FACES])
    _, first, counts = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    faces = faces[first[counts == 1]]
    corners, faces = np.unique(faces, return_inverse=True)
    faces = faces.reshape(-1, 3)
    way = _outwards(origin[corners], faces, 0.5 * spacing[corners])
    return Skin(now[corners] + way, members[corners], faces, members[np.unique(net)])


def skins_of(start: Array, place: Array, kinds: Array) -> list[Skin]:
    """A surface for each group of points."""
    found = (skin_of(start, place, np.flatnonzero(kinds == kind)) for kind in np.unique(kinds))
    return [skin for skin in found if skin is not None]
