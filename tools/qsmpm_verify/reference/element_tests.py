"""Mohr-Coulomb soil in element tests: triaxial, biaxial, simple shear, apex.

Stresses and strains positive in compression, friction and dilatancy angles in degrees.
"""

from __future__ import annotations

import math

from qsmpm_verify.reference.arguments import dilatancy_angle, friction_angle, not_negative, poisson_ratio, positive


def flow_number(friction: float) -> float:
    """Ratio of major to minor principal stress at failure without cohesion.

    Formula: N = (1 + sin phi) / (1 - sin phi) = tan^2(45 + phi/2)
    Units: friction [degree]; result [-]
    Range: 0 <= phi < 90
    Assumes: Mohr-Coulomb
    Source: Rankine 1857
    Check: the plane on which tau / sigma is largest, by search over planes
    """
    sine = math.sin(friction_angle("friction", friction))
    return (1 + sine) / (1 - sine)


def major_stress_at_failure(minor: float, cohesion: float, friction: float) -> float:
    """Major principal stress at failure, triaxial or biaxial.

    Formula: s1 = s3 N + 2 c sqrt(N), N = tan^2(45 + phi/2)
    Units: minor s3 and cohesion [stress], friction [degree]; result [stress]
    Range: s3 above minus the apex stress c cot(phi)
    Assumes: Mohr-Coulomb, intermediate stress between the other two
    Source: Mohr 1900
    Check: root of max(tau - sigma tan phi) = c over all planes
    """
    not_negative(cohesion=cohesion)
    number = flow_number(friction)
    if friction > 0 and minor < -apex_tension(cohesion, friction):
        raise ValueError(f"minor = {minor:g} is beyond the apex")
    return minor * number + 2 * cohesion * math.sqrt(number)


def triaxial_yield_strain(minor: float, cohesion: float, friction: float, young: float) -> float:
    """Axial strain at which triaxial compression from an isotropic stress reaches failure.

    Formula: eps1 = (s1 - s3) / E, s1 of major_stress_at_failure
    Units: minor = cell pressure, cohesion, young [stress], friction [degree]; result [-]
    Range: small strain
    Assumes: linear elasticity up to failure, constant cell pressure
    Source: own derivation
    Check: Hooke's law stepped until a plane reaches the strength
    """
    positive(young=young)
    return (major_stress_at_failure(minor, cohesion, friction) - minor) / young


def biaxial_yield_strain(minor: float, cohesion: float, friction: float, young: float, poisson: float) -> float:
    """Axial strain at which plane-strain compression from an isotropic stress reaches failure.

    Formula: eps1 = (1 - nu^2) (s1 - s3) / E
    Units: minor = cell pressure, cohesion, young [stress], friction [degree]; result [-]
    Range: small strain, intermediate stress between the two others (0 <= nu < 0.5)
    Assumes: linear elasticity up to failure, no strain in direction 2, constant cell pressure
    Source: own derivation
    Check: Hooke's law stepped until a plane reaches the strength
    """
    poisson_ratio(poisson)
    not_negative(poisson=poisson)
    return (1 - poisson**2) * triaxial_yield_strain(minor, cohesion, friction, young)


def biaxial_intermediate_stress(minor: float, cohesion: float, friction: float, poisson: float) -> float:
    """Stress in the direction without strain when plane-strain compression reaches failure.

    Formula: s2 = s3 + nu (s1 - s3)
    Units: minor and cohesion [stress], friction [degree]; result [stress]
    Range: 0 <= nu < 0.5
    Assumes: as biaxial_yield_strain
    Source: own derivation
    Check: Hooke's law stepped until a plane reaches the strength
    """
    poisson_ratio(poisson)
    not_negative(poisson=poisson)
    return minor + poisson * (major_stress_at_failure(minor, cohesion, friction) - minor)


def dilation_rate(dilatancy: float) -> float:
    """Volumetric strain per axial strain in triaxial or biaxial compression at failure.

    Formula: d eps_v / d eps_1 = -2 sin psi / (1 - sin psi)
    Units: dilatancy psi [degree]; result [-], negative for an increase of volume
    Range: 0 <= psi < 90
    Assumes: flow potential of Mohr-Coulomb shape, no elastic strain increment
    Source: Vermeer & de Borst 1984
    Check: finite differences of the flow potential
    """
    sine = math.sin(friction_angle("dilatancy", dilatancy))
    return -2 * sine / (1 - sine)


def apex_tension(cohesion: float, friction: float) -> float:
    """Largest hydrostatic tension of Mohr-Coulomb soil.

    Formula: c cot(phi)
    Units: cohesion [stress], friction [degree]; result [stress], tension positive
    Range: 0 < phi < 90
    Assumes: no tension cut-off
    Source: Mohr-Coulomb
    Check: stress at which the strength on all planes vanishes
    """
    not_negative(cohesion=cohesion)
    angle = friction_angle("friction", friction)
    positive(friction=friction)
    return cohesion / math.tan(angle)


def davis_factor(friction: float, dilatancy: float) -> float:
    """Factor on c and tan(phi) for a soil with dilatancy less than friction.

    Formula: b = cos psi cos phi / (1 - sin psi sin phi)
    Units: friction and dilatancy [degree]; result [-]
    Range: 0 <= psi <= phi < 90; 1 for psi = phi
    Assumes: slip plane is a line of zero extension
    Source: Davis 1968
    Check: rate integration of simple shear to failure
    """
    phi = friction_angle("friction", friction)
    psi = dilatancy_angle(dilatancy, friction)
    return math.cos(psi) * math.cos(phi) / (1 - math.sin(psi) * math.sin(phi))


def davis_cohesion(cohesion: float, friction: float, dilatancy: float) -> float:
    """Cohesion on a slip plane.

    Formula: c* = b c, b of davis_factor
    Units: cohesion [stress], angles [degree]; result [stress]
    Range: 0 <= psi <= phi < 90
    Assumes: as davis_factor
    Source: Davis 1968
    Check: rate integration of simple shear to failure
    """
    not_negative(cohesion=cohesion)
    return davis_factor(friction, dilatancy) * cohesion


def davis_friction(friction: float, dilatancy: float) -> float:
    """Friction angle on a slip plane.

    Formula: tan phi* = b tan phi, b of davis_factor
    Units: angles and result [degree]
    Range: 0 <= psi <= phi < 90
    Assumes: as davis_factor
    Source: Davis 1968
    Check: rate integration of simple shear to failure
    """
    return math.degrees(math.atan(davis_factor(friction, dilatancy) * math.tan(math.radians(friction))))


def simple_shear_strength(normal: float, cohesion: float, friction: float, dilatancy: float) -> float:
    """Shear stress at failure in simple shear under a constant normal stress, for any initial stress.

    Formula: tau = s_y tan phi* + c* = (s_y sin phi + c cos phi) cos psi / (1 - sin psi sin phi)
    Units: normal s_y and cohesion [stress], angles [degree]; result [stress]
    Range: 0 <= psi <= phi < 90
    Assumes: coaxial plastic flow, out-of-plane principal stress is the intermediate one
    Source: Davis 1968
    Check: rate integration of elastic-plastic simple shear from three coefficients of earth pressure
    """
    star = math.radians(davis_friction(friction, dilatancy))
    return normal * math.tan(star) + davis_cohesion(cohesion, friction, dilatancy)


def elastic_earth_pressure(poisson: float) -> float:
    """Lateral over axial stress in elastic one-dimensional compression.

    Formula: K0 = nu / (1 - nu); Mohr-Coulomb soil remains elastic if K0 > 1 / N (c = 0)
    Units: [-]
    Range: -1 < nu < 0.5
    Assumes: linear elasticity, no lateral strain
    Source: Hooke
    Check: Hooke's law in flexibility form
    """
    poisson_ratio(poisson)
    return poisson / (1 - poisson)
