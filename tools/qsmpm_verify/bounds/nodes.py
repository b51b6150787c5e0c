"""Nodes of the upper bound: corners of triangles, then midpoints of edges, and their constraints.

Velocities are continuous except where a rigid body moves along fixed ground beside it (the foot of a wall), or displacement-controlled nodes meet others
(the edge of a trapdoor): there every triangle has its own node, edges between them have two midpoints, and the soil slips along them with
its strength.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sparse

from qsmpm_verify.bounds.model import Model
from qsmpm_verify.bounds.rigid import Motions, bodies_of, motions_of
from qsmpm_verify.results import Array
from qsmpm_verify.trouble import Trouble


@dataclass(frozen=True)
class Nodes:
    """Numbers on triangles (3 corners, 3 midpoints), and on edges for each side (first end, second end, midpoint; -1 if there is no second side);
    free directions (rows over 2 n), those of bodies that do not fail last; prescribed velocities, edges along which velocities jump; the body that a
    triangle is part of, -1 for soil, and the motions of each with the first of their rows."""

    triangles: Array
    edges: Array
    free: sparse.csr_matrix
    given: Array
    torn: Array
    body: Array
    motions: list[tuple[int, Motions]]

    def work(self, body: int, place: Array, force: Array) -> tuple[Array, Array]:
        """Rows of the motions of a body, and the work of a force at a position on them."""
        first, motions = self.motions[body]
        return first + np.arange(len(motions.free)), motions.at(place[None])[:, 0] @ force

    def velocity(self, motion: Array) -> Array:
        """Velocities of the nodes from those of the free directions."""
        return np.asarray((self.free.T @ motion + self.given).reshape(-1, 2))


def feet(model: Model) -> Array:
    """Corners at which faces in contact with a moving body meet constrained ones, and corners at which a component has two velocities."""
    moving = model.touching & model.pushed.any(axis=1)
    found = np.intersect1d(model.edges[moving].ravel(), model.edges[model.held > 0].ravel())
    at = model.edges[np.flatnonzero((model.held > 0) & model.pushed.any(axis=1))].ravel()
    torn = [corner for corner in np.unique(at) if contradict(model, np.flatnonzero((model.held > 0) & (model.edges == corner).any(axis=1)))]
    return np.union1d(found, np.array(torn, dtype=int))


def contradict(model: Model, edges: Array) -> bool:
    """Whether edges require two velocities of a component."""
    for edge in edges:
        for axis in np.eye(2) if model.held[edge] == 2 else model.direction[edge][None]:
            alike = (model.held[edges] == 2) | (np.abs(model.direction[edges] @ axis) > 1.0 - 1e-9)
            if np.ptp((model.pushed[edges] @ axis)[alike]) > 0.0:
                return True
    return False


def numbered(model: Model) -> tuple[Array, Array, int]:
    """Numbers of the nodes on triangles, edges with two midpoints, and the number of nodes."""
    corners = len(model.mesh.places)
    found = np.hstack([model.mesh.corners, corners + model.number])
    count, torn = corners + len(model.edges), []
    for foot in feet(model):
        for triangle in np.flatnonzero((model.mesh.corners == foot).any(axis=1))[1:]:
            found[triangle, np.flatnonzero(model.mesh.corners[triangle] == foot)[0]] = count
            count += 1
        for edge in np.flatnonzero((model.edges == foot).any(axis=1) & (model.sides[:, 1] >= 0)):
            triangle = model.sides[edge, 1]
            found[triangle, 3 + np.flatnonzero(model.number[triangle] == edge)[0]] = count
            count += 1
            torn.append(edge)
    return found, np.unique(np.array(torn, dtype=int)), count


def on_edges(model: Model, triangles: Array) -> Array:
    """Nodes of edges as seen from each side: (edges, 2, 3)."""
    found = np.full((len(model.edges), 2, 3), -1)
    for side in range(2):
        edges = np.flatnonzero(model.sides[:, side] >= 0)
        triangle = model.sides[edges, side]
        for end in range(2):
            corner = np.argmax(model.mesh.corners[triangle] == model.edges[edges, end][:, None], axis=1)
            found[edges, side, end] = triangles[triangle, corner]
        middle = np.argmax(model.number[triangle] == edges[:, None], axis=1)
        found[edges, side, 2] = triangles[triangle, 3 + middle]
    return found


def nodes_of(model: Model) -> Nodes:
    """Nodes and their constraints, from all edges that contain them."""
    triangles, torn, count = numbered(model)
    edges = on_edges(model, triangles)
    held = np.zeros(count, dtype=int)
    direction, given = np.zeros((count, 2)), np.zeros((count, 2))
    pushed = np.zeros(count, dtype=bool)
    for edge in np.flatnonzero(model.held):
        for node in np.unique(edges[edge][edges[edge] >= 0]):
            both = model.held[edge] == 2 or held[node] == 2
            if held[node] == 1 and not both:
                a, b = direction[node], model.direction[edge]
                both = abs(a[0] * b[1] - a[1] * b[0]) > 1e-9
            held[node] = 2 if both else 1
            direction[node] = model.direction[edge]
            if model.pushed[edge].any():
                if pushed[node] and np.any(given[node] != model.pushed[edge]):
                    raise Trouble("*PRESCRIBE: adjacent sets have different prescribed velocities")
                given[node], pushed[node] = model.pushed[edge], True
    body = bodies_of(model, by_corners=True)
    part = np.full(count, -1)
    for number in range(int(body.max(initial=-1)) + 1):
        part[triangles[body == number]] = number
    both_free, one_free = np.flatnonzero((held == 0) & (part < 0)), np.flatnonzero((held == 1) & (part < 0))
    rows = np.concatenate([np.arange(2 * len(both_free)), np.repeat(2 * len(both_free) + np.arange(len(one_free)), 2)])
    columns = np.concatenate([(2 * both_free[:, None] + [0, 1]).ravel(), (2 * one_free[:, None] + [0, 1]).ravel()])
    along = np.stack([-direction[one_free, 1], direction[one_free, 0]], 1)
    values = np.concatenate([np.ones(2 * len(both_free)), along.ravel()])
    free = [sparse.csr_matrix((values, (rows, columns)), (2 * len(both_free) + len(one_free), 2 * count))]
    corners, first = model.mesh.places[model.mesh.corners], free[0].shape[0]
    place = np.zeros((count, 2))
    place[triangles[:, :3]], place[triangles[:, 3:]] = corners, (corners + np.roll(corners, -1, axis=1)) / 2.0
    found = []
    for number in range(int(body.max(initial=-1)) + 1):
        own = np.flatnonzero(part == number)
        fixed, one = own[held[own] == 2], own[held[own] == 1]
        at = np.concatenate([place[one], place[fixed], place[fixed]])
        motions = motions_of(place[own], at, np.concatenate([direction[one], np.repeat(np.eye(2), len(fixed), axis=0)]))
        values = motions.at(place[own]).reshape(len(motions.free), 2 * len(own))
        columns = (2 * own[:, None] + [0, 1]).ravel()
        free.append(sparse.csr_matrix((values.ravel(), (np.repeat(np.arange(len(values)), len(columns)), np.tile(columns, len(values)))), (len(values), 2 * count)))
        found.append((first, motions))
        first += len(values)
    return Nodes(triangles, edges, sparse.csr_matrix(sparse.vstack(free)), given.ravel(), torn, body, found)
