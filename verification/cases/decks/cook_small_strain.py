#!/usr/bin/env python3
"""Cook's membrane of cook.inp in small strain by NumPy: what its cells give by themselves.

    cook_small_strain.py [N]

N by N bilinear cells (16) with 2 by 2 Gauss points in plane strain. The volume strain of a cell is its mean; what
deviates from it meets half the shear modulus in series with the bulk modulus (docs/methods/uniform_pressure.md,
eps = 0.5). Prints the rise of the middle and of the upper corner of the loaded end.
"""

from __future__ import annotations

import sys

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import spsolve

YOUNG, POISSON, TRACTION, EPS = 240.565, 0.4999, 6.25, 0.5
SHEAR = YOUNG / 2 / (1 + POISSON)
BULK = YOUNG / 3 / (1 - 2 * POISSON) + SHEAR / 3  # of the plane
DEVIATOR = SHEAR * np.array([[1, -1, 0], [-1, 1, 0], [0, 0, 1]])
CORNERS = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])


def stiffness(corners: np.ndarray) -> np.ndarray:
    """Of a cell with corners (4, 2)."""
    deviating = BULK * EPS * SHEAR / (BULK + EPS * SHEAR)
    total, mean, area = np.zeros((8, 8)), np.zeros(8), 0.0
    for xi, eta in CORNERS / np.sqrt(3):
        local = np.array([CORNERS[:, 0] * (1 + CORNERS[:, 1] * eta), CORNERS[:, 1] * (1 + CORNERS[:, 0] * xi)]) / 4
        jacobian = local @ corners
        gradient, weight = np.linalg.solve(jacobian, local), np.linalg.det(jacobian)
        strain = np.zeros((3, 8))
        strain[0, ::2] = strain[2, 1::2] = gradient[0]
        strain[1, 1::2] = strain[2, ::2] = gradient[1]
        volume = strain[0] + strain[1]
        total += weight * (strain.T @ DEVIATOR @ strain + deviating * np.outer(volume, volume))
        mean += weight * volume
        area += weight
    return total + (BULK - deviating) * np.outer(mean, mean) / area


def main() -> None:
    n = int(sys.argv[1]) if len(sys.argv) > 1 else 16
    along, up = np.meshgrid(np.arange(n + 1) / n, np.arange(n + 1) / n)
    places = np.column_stack([48 * along.ravel(), (44 * along + (44 - 28 * along) * up).ravel()])
    matrix, force = sparse.lil_matrix((2 * len(places), 2 * len(places))), np.zeros(2 * len(places))
    for j in range(n):
        for i in range(n):
            cell = (n + 1) * j + i + np.array([0, 1, n + 2, n + 1])
            rows = np.column_stack([2 * cell, 2 * cell + 1]).ravel()
            matrix[np.ix_(rows, rows)] += stiffness(places[cell])
        for node in ((n + 1) * j + n, (n + 1) * (j + 1) + n):
            force[2 * node + 1] += TRACTION * 16 / n / 2
    free = np.flatnonzero(np.repeat(places[:, 0] > 0, 2))
    rise = np.zeros(2 * len(places))
    rise[free] = spsolve(matrix.tocsr()[free][:, free].tocsc(), force[free])
    print(f"middle {rise[2 * ((n + 1) * (n // 2) + n) + 1]:.6f}, corner {rise[2 * ((n + 1) * n + n) + 1]:.6f}")


if __name__ == "__main__":
    main()
