"""A block compressed between smooth platens, incompressible Tresca soil, plane strain. Compression positive."""

from __future__ import annotations

import math

from qsmpm_verify.reference.arguments import positive, within


def upsetting_force(height_ratio: float) -> float:
    """Force on the platens once the block yields, at any strain.

    Formula: F / (2 s_u W0) = H0 / H
    Units: height_ratio H/H0 [-]; result [-], over twice the strength and the initial width
    Range: 0 < H/H0 <= 1, yield reached
    Assumes: no friction on the platens, constant volume, small elastic strain
    Source: own derivation, stress 2 s_u on the width W0 H0 / H
    Check: plastic work rate; integration of the width at constant volume
    """
    positive(height_ratio=height_ratio)
    within("height_ratio", height_ratio, high=1.0)
    return 1 / height_ratio


def upsetting_work(height_ratio: float) -> float:
    """Work from the initial height to a height.

    Formula: A / (2 s_u W0 H0) = ln(H0 / H)
    Units: height_ratio H/H0 [-]; result [-]
    Range: 0 < H/H0 <= 1
    Assumes: as upsetting_force, rigid-plastic
    Source: own derivation
    Check: quadrature of the force
    """
    return math.log(upsetting_force(height_ratio))
