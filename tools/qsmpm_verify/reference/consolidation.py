"""Soil from which pore water flows in time: a layer under a load, and a cylinder squeezed from outside.

M = E (1 - nu)/((1 + nu)(1 - 2 nu)) and G are the moduli of the skeleton, c = k M/gamma_w the coefficient of
consolidation; water and grains do not change their volume. Pressures are divided by the load.
"""

from __future__ import annotations

import cmath
import math

from qsmpm_verify.reference.arguments import poisson_ratio, positive, within

TERMS = 400
"""Terms of a series in time."""
TALBOT = 24
"""Places on Talbot's contour."""


def layer_settlement(time_factor: float) -> float:
    """Settlement of a layer that drains at its top, over its settlement at the end.

    Formula: U = 1 - sum 8/((2 m + 1)^2 pi^2) exp(-((2 m + 1) pi/2)^2 T)
    Units: time_factor T = c t/H^2 [-]; result [-]
    Range: T > 0
    Assumes: one dimension, a load that comes at once and stays, small strains
    Source: Terzaghi 1923
    Check: finite differences in depth and time
    """
    positive(time_factor=time_factor)
    odd = [(2 * m + 1) * math.pi / 2 for m in range(TERMS)]
    return 1 - sum(2 / r**2 * math.exp(-(r**2) * time_factor) for r in odd)


def layer_pressure(time_factor: float, depth: float = 1.0) -> float:
    """Excess pore pressure in a layer that drains at its top, over the load.

    Formula: p = sum 4/((2 m + 1) pi) sin((2 m + 1) pi z/2) exp(-((2 m + 1) pi/2)^2 T)
    Units: time_factor T = c t/H^2 [-], depth z below the top over the height [-]; result [-]
    Range: T > 0, z from 0 to 1
    Assumes: as layer_settlement
    Source: Terzaghi 1923
    Check: finite differences in depth and time
    """
    positive(time_factor=time_factor)
    within("depth", depth, 0.0, 1.0)
    odd = [(2 * m + 1) * math.pi / 2 for m in range(TERMS)]
    return sum(2 / r * math.sin(r * depth) * math.exp(-(r**2) * time_factor) for r in odd)


def _bessel(order: int, z: complex) -> complex:
    """I_0 or I_1 by its series."""
    term: complex = 1.0 if order == 0 else z / 2
    total = term
    for k in range(1, 400):
        term *= (z / 2) ** 2 / (k * (k + order))
        total += term
        if abs(term) < 1e-17 * abs(total):
            break
    return total


def cylinder_pressure(time_factor: float, poisson: float, radius: float = 0.0) -> float:
    """Excess pore pressure in a cylinder that is squeezed from outside and drains there, over the load.

    Formula: Laplace transform of p/P: (I_0(l) - I_0(l r))/(s (I_0(l) - 2 G/M I_1(l)/l)), l = sqrt(s)
    Units: time_factor T = c t/R^2 [-], poisson [-], radius r over R [-]; result [-]
    Range: T from 0.002 on, r from 0 to 1
    Assumes: plane strain, axisymmetry, a pressure that comes at once and stays, small strains
    Source: de Leeuw 1965; inverted by Talbot's contour as Abate and Valko 2004
    Check: finite differences in radius and time, with the total stress that keeps the cylinder in equilibrium
    """
    within("time_factor", time_factor, 0.002)
    within("radius", radius, 0.0, 1.0)
    poisson_ratio(poisson)
    shear = (1 - 2 * poisson) / (1 - poisson)  # 2 G/M

    def transform(s: complex) -> complex:
        l = cmath.sqrt(s)
        rim = _bessel(0, l)
        return (rim - _bessel(0, l * radius)) / (s * (rim - shear * _bessel(1, l) / l))

    least = 2 * TALBOT / 5
    total = 0.5 * math.exp(least) * transform(complex(least / time_factor))
    for k in range(1, TALBOT):
        angle = k * math.pi / TALBOT
        cot = 1 / math.tan(angle)
        place = 2 * k * math.pi / 5 * complex(cot, 1)
        weight = complex(1, angle * (1 + cot**2) - cot)
        total += (weight * cmath.exp(place) * transform(place / time_factor)).real
    return float((0.4 / time_factor * total).real)
