"""Upper bound: 6-node triangles with straight sides, velocities quadratic, strain rates linear (Makrodimopoulos and Martin 2007).

Dual form: stresses at the three corners of each triangle, weights a third of its area, in equilibrium with the loads in the mean over every free
node, inside the cones. A strain rate that satisfies the flow rule at the corners satisfies it everywhere between them, and the dissipation there is not
more than the linear function through the corners. Cohesion and pore pressure, linear on a triangle, enter as (2 c_1 + c_2 + c_3)/4: the
integral of their product with a linear function is then exact.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sparse

from qsmpm_verify.bounds.cone import Balance
from qsmpm_verify.bounds.contact import joint_forces
from qsmpm_verify.bounds.model import Loads, Model
from qsmpm_verify.bounds.nodes import Nodes
from qsmpm_verify.bounds.props import columns_of, limits_of
from qsmpm_verify.results import Array


def lifted(corners: Array) -> Array:
    """Corner values of a linear function as weighted in an integral with another linear function."""
    return np.asarray((corners + corners.sum(axis=1)[:, None]) / 4.0)


def node_forces(model: Model, nodes: Nodes, loads: Loads) -> Array:
    """Forces of weights and tractions on the nodes: (2 n)."""
    found = np.zeros((len(nodes.given) // 2, 2))
    share = model.area[:, None] / 3.0 * loads.weight
    for side in range(3):
        np.add.at(found, nodes.triangles[:, 3 + side], share)
    force = loads.traction * model.length[:, None, None]
    for end in range(2):
        np.add.at(found, nodes.edges[:, 0, end], force[:, end] / 6.0)
    np.add.at(found, nodes.edges[:, 0, 2], force.sum(axis=1) / 3.0)
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
    """Equilibrium of the free directions; the objective is the power of the prescribed velocities."""
    matrix = _divergence(model, nodes)
    dead, more = node_forces(model, nodes, before), node_forces(model, nodes, live)
    figure = matrix.T @ nodes.given if nodes.given.any() else None
    if model.touching.any() or len(nodes.torn):
        forces, power = joint_forces(model, nodes)
        matrix = sparse.csr_matrix(sparse.hstack([matrix, -forces]))
        figure = np.concatenate([np.zeros(matrix.shape[1] - len(power)) if figure is None else figure, power])
        if nodes.given.any():
            figure -= np.concatenate([np.zeros(len(figure) - len(power)), forces.T @ nodes.given])
    still = nodes.body >= 0
    stress = sparse.diags(np.repeat(~still, 9).astype(float))
    whole = nodes.free @ matrix[:, : stress.shape[0]] @ stress
    further = columns_of(model, nodes.body, whole.shape[0], nodes.work)
    figure = None if figure is None else np.concatenate([figure, np.zeros(len(model.props))])
    whole = sparse.hstack([whole, nodes.free @ matrix[:, stress.shape[0] :], -further])
    return Balance(sparse.csr_matrix(whole), nodes.free @ dead, nodes.free @ more, figure, limits_of(model.props), still)
