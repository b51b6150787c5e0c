"""Iterations of the modified Newton method: stiffness frozen at the start of the step."""

from __future__ import annotations

import math

from qsmpm_verify.reference.arguments import between, positive

MOST = 100000
"""Iterations after which a count is considered divergent."""


def frozen_stiffness_iterations(ratio: float, tolerance: float) -> float:
    """Iterations until the error has fallen by a factor when tangent and frozen stiffness differ.

    Formula: n = ln(tol) / ln |1 - Kt/K0|, rounded up
    Units: ratio Kt/K0 [-], tolerance [-]; result [-]; infinite outside of 0 < Kt/K0 < 2
    Range: 0 < tol < 1
    Assumes: constant tangent Kt
    Source: contraction of a linear iteration
    Check: the iteration carried out on a linear spring
    """
    between("tolerance", tolerance, 0.0, 1.0)
    factor = abs(1 - ratio)
    if factor >= 1:
        return math.inf
    return 1.0 if factor == 0 else float(math.ceil(math.log(tolerance) / math.log(factor)))


def frozen_stiffness_least_stretch() -> float:
    """Smallest lambda1/lambda0 of one confined compression step, rate law, at which the frozen stiffness converges.

    Formula: (lambda1 / lambda0) = 1 / sqrt(2): Kt/K0 = (lambda0 / lambda1)^2 reaches 2
    Units: [-]
    Range: load control, one element, nu = 0 or the constrained modulus
    Assumes: rate law, sigma = M (1 - 1/lambda)
    Source: own derivation
    Check: the iteration carried out on either side of the limit
    """
    return math.sqrt(0.5)


def frozen_stiffness_confined_iterations(stretch: float, tolerance: float = 1e-10) -> float:
    """Iterations of one confined compression step under load, stiffness frozen at the start, rate law.

    Formula: x_(k+1) = x_k + (1/x_k - 1/lambda), x_0 = 1, until |1/x_k - 1/lambda| <= tol
    Units: stretch = lambda1/lambda0, tolerance = stress out of balance over M [-]; result [-], infinite if it diverges
    Range: lambda > 0, not 1
    Assumes: step from a state free of stress
    Source: own derivation
    Check: contraction rate 1 - 1/lambda^2 of the tail
    """
    positive(stretch=stretch)
    between("tolerance", tolerance, 0.0, 1.0)
    place = 1.0
    for count in range(MOST):
        unbalanced = 1 / place - 1 / stretch
        if abs(unbalanced) <= tolerance:
            return float(count)
        place += unbalanced
        if place <= 0:
            return math.inf
    return math.inf
