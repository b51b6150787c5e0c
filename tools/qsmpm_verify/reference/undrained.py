"""Undrained soil: strength for effective stress without change of volume, and a loaded layer.

Compression positive; p0, s1 and s3 initial effective stresses; linear elasticity without volumetric coupling of
the skeleton, psi = 0, so that the mean effective stress is constant up to and at failure.
"""

from __future__ import annotations

import math

from qsmpm_verify.reference.arguments import between, friction_angle, not_negative, positive
from qsmpm_verify.reference.numerics import root


def undrained_triaxial_deviator(pressure: float, cohesion: float, friction: float) -> float:
    """Deviator at failure of an undrained triaxial compression test.

    Formula: q = 6 (p0 sin phi + c cos phi) / (3 - sin phi)
    Units: pressure = p0, cohesion [stress], friction [degree]; result [stress]
    Range: 0 <= phi < 90
    Assumes: Mohr-Coulomb, psi = 0, constant volume
    Source: Potts & Zdravkovic 1999
    Check: root of the yield function over q at the mean effective stress p0
    """
    not_negative(cohesion=cohesion)
    positive(pressure=pressure)
    sine = math.sin(friction_angle("friction", friction))
    return 6 * (pressure * sine + cohesion * math.sqrt(1 - sine**2)) / (3 - sine)


def undrained_plane_strength(major: float, minor: float, cohesion: float, friction: float) -> float:
    """Undrained shear strength in plane strain.

    Formula: s_u = c cos phi + (s1 + s3)/2 sin phi
    Units: major = s1, initial minor = s3 in the plane, cohesion [stress], friction [degree]; result [stress]
    Range: 0 <= phi < 90
    Assumes: Mohr-Coulomb, psi = 0, constant volume: the mean stress in the plane is constant
    Source: Potts & Zdravkovic 1999
    Check: Hooke's law at constant volume stepped until Mohr's circle reaches the strength
    """
    not_negative(cohesion=cohesion)
    angle = friction_angle("friction", friction)
    return cohesion * math.cos(angle) + (major + minor) / 2 * math.sin(angle)


def _moduli(young: float, poisson: float, undrained: float) -> tuple[float, float]:
    """Confined modulus M and stiffness of the water K_w/n."""
    positive(young=young)
    between("poisson", poisson, 0.0, 0.5)
    between("undrained", undrained, poisson, 0.5)
    shear = young / (2 * (1 + poisson))
    bulk = 2 * shear / 3 * (1 + poisson) / (1 - 2 * poisson)
    return bulk + 4 * shear / 3, 2 * shear / 3 * (1 + undrained) / (1 - 2 * undrained) - bulk


def undrained_column_stretch(load: float, young: float, poisson: float, undrained: float) -> float:
    """Height over initial height of an undrained layer under a load on its top.

    Formula: M ln(l)/l + (K_w/n) ln(l) = -q, K_w/n of the undrained Poisson's ratio
    Units: load = q, young [stress], poisson and undrained [-]; result l [-]
    Range: q >= 0, 0 <= nu < nu_u < 1/2
    Assumes: Hencky elasticity, sides fixed, q per initial area, pore pressure p = -(K_w/n) ln l
    Source: own derivation
    Check: the force as the derivative of the energy of skeleton and water
    """
    not_negative(load=load)
    confined, water = _moduli(young, poisson, undrained)
    return root(lambda ratio: confined * math.log(ratio) / ratio + water * math.log(ratio) + load, 0.5, 1.0)


def undrained_column_pressure(load: float, young: float, poisson: float, undrained: float) -> float:
    """Excess pore pressure of this layer.

    Formula: p = -(K_w/n) ln l, l of undrained_column_stretch
    Units: as there; result [stress]
    Range: as there
    Assumes: as there
    Source: own derivation
    Check: as there
    """
    stretch = undrained_column_stretch(load, young, poisson, undrained)
    return -_moduli(young, poisson, undrained)[1] * math.log(stretch)
