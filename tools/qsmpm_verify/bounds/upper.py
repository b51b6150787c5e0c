"""Upper bound: 6-node triangles with straight sides, velocities quadratic, strain rates linear (Makrodimopoulos and Martin 2007).

Posed in its dual: stresses at the three corners of each triangle, weights a third of its area, in balance with the loads in the mean over every free
node, inside the cones. A strain rate that the flow rule allows at the corners is allowed everywhere between them, and what is dissipated there is not
more than the linear function through the corners. Cohesion and pore pressure, linear on a triangle, enter as (2 c_1 + c_2 + c_3)/4: the
integral of their product with a linear function is then exact.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sparse

from qsmpm_verify.bounds.cone import Balance
from qsmpm_verify.bounds.model import Loads, Model
from qsmpm_verify.results import Array
from qsmpm_verify.trouble import Trouble


def lifted(corners: Array) -> Array:
    """Corner values of a linear function as they count in an integral with another one."""
    return np.asarray((corners + corners.sum(axis=1)[:, None]) / 4.0)


@dataclass(frozen=True)
class Nodes:
    """Corners, then the middles of edges: numbers on triangles, directions that are free (rows over 2 n), given velocities."""

    triangles: Array
    free: sparse.csr_matrix
    given: Array

    def velocity(self, motion: Array) -> Array:
        """Velocities of the nodes, by those of the free directions."""
        return np.asarray((self.free.T @ motion + self.given).reshape(-1, 2))


def nodes_of(model: Model) -> Nodes:
    """Nodes and how they are held: by all edges that they lie on."""
    corners, edges = len(model.mesh.places), len(model.edges)
    count = corners + edges
    held = np.zeros(count, dtype=int)
    direction, given = np.zeros((count, 2)), np.zeros((count, 2))
    pushed = np.zeros(count, dtype=bool)
    for edge in np.flatnonzero(model.held):
        for node in (*model.edges[edge], corners + edge):
            both = model.held[edge] == 2 or held[node] == 2
            if held[node] == 1 and not both:
                a, b = direction[node], model.direction[edge]
                both = abs(a[0] * b[1] - a[1] * b[0]) > 1e-9
            held[node] = 2 if both else 1
            direction[node] = model.direction[edge]
            if model.pushed[edge].any():
                if pushed[node] and np.any(given[node] != model.pushed[edge]):
                    raise Trouble("*PRESCRIBE: sets that touch are pushed with different velocities")
                given[node], pushed[node] = model.pushed[edge], True
    both_free, one_free = np.flatnonzero(held == 0), np.flatnonzero(held == 1)
    rows = np.concatenate([np.arange(2 * len(both_free)), np.repeat(2 * len(both_free) + np.arange(len(one_free)), 2)])
    columns = np.concatenate([(2 * both_free[:, None] + [0, 1]).ravel(), (2 * one_free[:, None] + [0, 1]).ravel()])
    along = np.stack([-direction[one_free, 1], direction[one_free, 0]], 1)
    values = np.concatenate([np.ones(2 * len(both_free)), along.ravel()])
    free = sparse.csr_matrix((values, (rows, columns)), (2 * len(both_free) + len(one_free), 2 * count))
    return Nodes(np.hstack([model.mesh.corners, corners + model.number]), free, given.ravel())


def node_forces(model: Model, loads: Loads) -> Array:
    """Forces of weights and tractions on the nodes: (2 n)."""
    corners = len(model.mesh.places)
    found = np.zeros((corners + len(model.edges), 2))
    share = model.area[:, None] / 3.0 * loads.weight
    for side in range(3):
        np.add.at(found, corners + model.number[:, side], share)
    force = loads.traction * model.length[:, None, None]
    for end in range(2):
        np.add.at(found, model.edges[:, end], force[:, end] / 6.0)
    found[corners:] += force.sum(axis=1) / 3.0
    return found.ravel()


def _divergence(model: Model, nodes: Nodes) -> sparse.csr_matrix:
    """Forces on the nodes of the stresses (m, d, t) at the corners."""
    slopes = model.gradients()
    number = np.arange(len(model.area))
    rows, columns, values = [], [], []
    for corner in range(3):
        share = np.zeros(3)
        share[corner] = 1.0
        shapes = [(4.0 * share[k] - 1.0) * slopes[:, k] for k in range(3)]
        shapes += [4.0 * (share[k] * slopes[:, (k + 1) % 3] + share[(k + 1) % 3] * slopes[:, k]) for k in range(3)]
        first = 3 * (3 * number + corner)
        for k, slope in enumerate(shapes):
            x, y = (slope * model.area[:, None] / 3.0).T
            node = 2 * nodes.triangles[:, k]
            for row, column, value in ((node, first, x), (node, first + 1, x), (node, first + 2, y), (node + 1, first, y),
                                       (node + 1, first + 1, -y), (node + 1, first + 2, x)):  # fmt: skip
                rows.append(row)
                columns.append(column)
                values.append(value)
    shape = (nodes.free.shape[1], 9 * len(number))
    return sparse.csr_matrix((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape)


def upper_balance(model: Model, nodes: Nodes, before: Loads, live: Loads) -> Balance:
    """Balance of the free directions; the figure is the power of the forces that push."""
    matrix = _divergence(model, nodes)
    dead, more = node_forces(model, before), node_forces(model, live)
    figure = matrix.T @ nodes.given if nodes.given.any() else None
    return Balance(sparse.csr_matrix(nodes.free @ matrix), nodes.free @ dead, nodes.free @ more, figure)
