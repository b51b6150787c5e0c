"""Rigid bodies in contact: tractions between them and the soil, |t| <= a - n tan(delta), without tension.

In the lower bound the traction at both ends of an edge is that of the stresses there. In the upper bound the jump of velocities on an edge is quadratic;
its three coefficients in Bernstein's polynomials, u_a, 2 u_m - (u_a + u_b)/2 and u_b less the velocity of the body, obey the flow rule one by one, and so does the
jump between them, which is their mean. Their dissipation, a third of the length each, is not less than that of the jump. The tractions at the three
points are unknowns of the dual, two each.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sparse

from qsmpm_verify.bounds.cone import Joint
from qsmpm_verify.bounds.lower import traction_part
from qsmpm_verify.bounds.model import Model
from qsmpm_verify.bounds.nodes import Nodes
from qsmpm_verify.results import Array

# Coefficients of the jump by the velocities of both ends and of the middle.
JUMP = np.array([[1.0, 0.0, 0.0], [-0.5, -0.5, 2.0], [0.0, 1.0, 0.0]])


def along_of(model: Model, edges: Array) -> Array:
    """Unit vectors along edges."""
    return np.stack([-model.normal[edges, 1], model.normal[edges, 0]], 1)


def lower_joint(model: Model) -> Joint | None:
    """Tractions at both ends of the edges in contact; none without contact."""
    edges = np.flatnonzero(model.touching)
    if not len(edges):
        return None
    parts: list[list[sparse.csr_matrix]] = [[], []]
    for end in range(2):
        for found, unit in zip(parts, (model.normal[edges], along_of(model, edges))):
            columns, values = traction_part(model, edges, unit, end, 0)
            rows = np.repeat(np.arange(len(edges)), 3)
            found.append(sparse.csr_matrix((values.ravel(), (rows, columns.ravel())), (len(edges), 9 * len(model.area))))
    strength = np.concatenate([model.joint[edges, end] for end in range(2)])
    return Joint(sparse.csr_matrix(sparse.vstack(parts[0])), sparse.csr_matrix(sparse.vstack(parts[1])), strength[:, 0], strength[:, 1], np.ones(len(strength), dtype=bool))


def joint_forces(model: Model, nodes: Nodes) -> tuple[sparse.csr_matrix, Array]:
    """Forces on the nodes (2 n) of the tractions n and t at three points of each edge in contact or with a jump, and their power on the velocity of the bodies."""
    touched = np.flatnonzero(model.touching)
    edges = np.concatenate([touched, nodes.torn])
    count = len(edges)
    rows, columns, values = [], [], []
    power = np.zeros((count, 3, 2))
    for axis, unit in enumerate((model.normal[edges], along_of(model, edges))):
        weight = model.length[edges, None] / 3.0 * unit
        for place in range(3):
            power[: len(touched), place, axis] = np.sum(weight * model.pushed[edges], axis=1)[: len(touched)]
            for side, sign in ((0, 1.0), (1, -1.0)):
                some = np.arange(count) if side == 0 else np.arange(len(touched), count)
                for node in range(3):
                    for component in range(2):
                        rows.append(2 * nodes.edges[edges[some], side, node] + component)
                        columns.append(6 * some + 2 * place + axis)
                        values.append(sign * JUMP[place, node] * weight[some, component])
    shape = (len(nodes.given), 6 * count)
    return sparse.csr_matrix((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape), power.ravel()


def upper_joint(model: Model, nodes: Nodes, flow: str) -> Joint | None:
    """Tractions at three points of the edges in contact or with a jump, unknowns after the stresses; none without such edges. Soil with a jump may be in tension."""
    edges = np.flatnonzero(model.touching)
    if not len(edges) and not len(nodes.torn):
        return None
    ends = np.concatenate([model.joint[edges], [_of_soil(model, edge, flow) for edge in nodes.torn]]) if len(nodes.torn) else model.joint[edges]
    stresses, places = 9 * len(model.area), 3 * len(ends)
    at = np.arange(places)
    pull, shear = (sparse.csr_matrix((np.ones(places), (at, stresses + 2 * at + axis)), (places, stresses + 2 * places)) for axis in range(2))
    strength = np.stack([ends[:, 0], ends.mean(axis=1), ends[:, 1]], 1).reshape(-1, 2)
    return Joint(pull, shear, strength[:, 0], strength[:, 1], at < 3 * len(edges))


def _of_soil(model: Model, edge: int, flow: str) -> Array:
    """Tangent of friction and cohesion of the soil on the first side of an edge, at both ends."""
    triangle = model.sides[edge, 0]
    share, phi = model.strengths[model.material[triangle]].at(1.0, flow)
    corner = np.argmax(model.mesh.corners[triangle][None] == model.edges[edge][:, None], axis=1)
    return np.stack([np.full(2, np.tan(phi)), share * model.cohesion[triangle, corner]], 1)
