"""Nodal loads: equivalent nodal forces of a uniform traction and of the self-weight of the cells of a plane mesh."""

from __future__ import annotations

import numpy as np

from qsmpm_verify.results import Array

EDGE_SHARES = {2: (1 / 2, 1 / 2), 3: (1 / 6, 1 / 6, 4 / 6)}
"""Fractions of a uniform load at the nodes of a straight edge: ends first, then the midside node."""

EDGES = {
    5: ((0, 1), (1, 2), (2, 0)),
    9: ((0, 1), (1, 2), (2, 3), (3, 0)),
    22: ((0, 1, 3), (1, 2, 4), (2, 0, 5)),
    23: ((0, 1, 4), (1, 2, 5), (2, 3, 6), (3, 0, 7)),
}
"""Edges of the plane cells by VTK type: ends first, then the midside node."""

CORNERS = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
TRIANGLE_SHARES = {5: (1 / 3, 1 / 3, 1 / 3), 22: (0, 0, 0, 1 / 3, 1 / 3, 1 / 3)}
"""Fractions of the area of a triangle with straight sides."""


def outer_edges(cells: Array, vtk_type: int) -> list[tuple[int, ...]]:
    """Edges that belong to one cell only, as nodes: ends first, then the midside node."""
    seen: dict[frozenset[int], list[tuple[int, ...]]] = {}
    for cell in cells:
        for edge in EDGES[vtk_type]:
            nodes = tuple(int(cell[i]) for i in edge)
            seen.setdefault(frozenset(nodes), []).append(nodes)
    return [edges[0] for edges in seen.values() if len(edges) == 1]


def traction_forces(nodes: Array, edges: list[tuple[int, ...]], traction: Array) -> Array:
    """Nodal loads (nodes, 2) equivalent to a uniform traction on straight edges."""
    forces = np.zeros_like(nodes)
    for edge in edges:
        length = np.linalg.norm(nodes[edge[1]] - nodes[edge[0]])
        for node, share in zip(edge, EDGE_SHARES[len(edge)]):
            forces[node] += share * length * traction
    return forces


def _quad_shape(xi: float, eta: float, count: int) -> Array:
    """Shape functions of the 4- or 8-node quadrilateral."""
    a, b = 1 + CORNERS[:, 0] * xi, 1 + CORNERS[:, 1] * eta
    if count == 4:
        return a * b / 4
    middles = [(1 - xi**2) * (1 - eta), (1 + xi) * (1 - eta**2), (1 - xi**2) * (1 + eta), (1 - xi) * (1 - eta**2)]
    return np.concatenate([a * b * (a + b - 3) / 4, np.array(middles) / 2])


def _quad_jacobian(corners: Array, xi: float, eta: float) -> float:
    """Area of a quadrilateral with straight sides over that of its reference square, at a point."""
    along = CORNERS * (1 + CORNERS[:, ::-1] * (eta, xi)) / 4
    return float(np.linalg.det(along.T @ corners))


def shares_of_area(places: Array, vtk_type: int) -> Array:
    """Integral of each shape function over a cell with straight sides."""
    if vtk_type in TRIANGLE_SHARES:
        one, other = places[1] - places[0], places[2] - places[0]
        return 0.5 * (one[0] * other[1] - one[1] * other[0]) * np.array(TRIANGLE_SHARES[vtk_type])
    shares = np.zeros(len(places))
    for xi, along in zip(*np.polynomial.legendre.leggauss(3)):
        for eta, across in zip(*np.polynomial.legendre.leggauss(3)):
            area = along * across * _quad_jacobian(places[:4], xi, eta)
            shares += area * _quad_shape(xi, eta, len(places))
    return shares


def weight_forces(nodes: Array, cells: Array, vtk_type: int, weight: tuple[float, float]) -> Array:
    """Nodal loads (nodes, 2) for a given weight per volume."""
    forces = np.zeros_like(nodes)
    for cell in cells:
        forces[cell] += shares_of_area(nodes[cell], vtk_type)[:, None] * np.array(weight)
    return forces
