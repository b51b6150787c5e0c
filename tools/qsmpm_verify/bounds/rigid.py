"""Bodies that do not fail: they move as rigid bodies, so their stresses are not unknowns, and the forces on each body are in equilibrium as a whole.

In the upper bound all nodes of such a body have its motions; in the lower bound the tractions of the surrounding soil, its weight and its loads do no work on them.
A motion is v = (a - w (y - y_0), b + w (x - x_0)) with w over the size of the body; motions prevented by supports are omitted. A body with displacement-controlled faces
or in contact with a *RIGID BODY remains a soil body with sufficient strength.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg
import scipy.sparse as sparse
from scipy.sparse.csgraph import connected_components

from qsmpm_verify.bounds.lines import cross, distance
from qsmpm_verify.bounds.model import ON, Model
from qsmpm_verify.results import Array


@dataclass(frozen=True)
class Motions:
    """Free motions of a body: its centre and size, and a, b, w of each (m, 3)."""

    centre: Array
    size: float
    free: Array

    def at(self, places: Array) -> Array:
        """Velocities of each motion at positions (n, 2): (m, n, 2)."""
        apart = (places - self.centre) / self.size
        turn = np.stack([-apart[:, 1], apart[:, 0]], 1)
        return np.asarray(self.free[:, None, :2] + self.free[:, 2, None, None] * turn)


def motions_of(places: Array, at: Array, direction: Array) -> Motions:
    """Motions of a body with corners (n, 2), constrained at positions along directions (k, 2)."""
    whole = Motions(places.mean(axis=0), float(np.ptp(places, axis=0).max()), np.eye(3))
    if not len(at):
        return whole
    taken = np.einsum("mnd,nd->nm", whole.at(at), direction)
    return Motions(whole.centre, whole.size, scipy.linalg.null_space(taken, rcond=1e-9).T)


def bodies_of(model: Model, by_corners: bool) -> Array:
    """Number of the body of each triangle, -1 for soil: triangles that do not fail, connected by edges, or by corners as well."""
    rigid = np.array([not strength.fails for strength in model.strengths])[model.material]
    count, corners = len(rigid), len(model.mesh.places)
    if by_corners:
        links = np.stack([np.repeat(np.arange(count), 3), count + model.mesh.corners.ravel()], 1)[np.repeat(rigid, 3)]
    else:
        inner = model.sides[model.sides[:, 1] >= 0]
        links = inner[rigid[inner].all(axis=1)]
    graph = sparse.csr_matrix((np.ones(len(links)), links.T), (count + corners, count + corners))
    number = np.where(rigid, connected_components(graph, directed=False)[1][:count], -1)
    acted = np.unique(model.edges[model.pushed.any(axis=1) | model.touching])
    number[np.isin(number, number[np.isin(model.mesh.corners, acted).any(axis=1)])] = -1
    kept = np.unique(number[number >= 0])
    return np.where(number >= 0, np.searchsorted(kept, number), -1)


def body_at(model: Model, body: Array, place: Array) -> int:
    """The body that contains a position, boundary included, -1 for none."""
    corners = model.mesh.places[model.mesh.corners]
    ahead = np.roll(corners, -1, axis=1)
    inside = np.all(cross(ahead - corners, place - corners) >= 0.0, axis=1)
    near = distance(place[None], corners.reshape(-1, 2), ahead.reshape(-1, 2))[0].reshape(-1, 3).min(axis=1)
    own = np.flatnonzero((body >= 0) & (inside | (near < ON * np.ptp(model.mesh.places))))
    return int(body[own[0]]) if len(own) else -1
