"""Stability of a straight slope under its own weight: logarithmic spiral, slip circle, Davis's strengths.

Slope angle, friction and dilatancy in degrees. The toe is the lowest point of the soil that can move: slip
surfaces exit through it. All results follow from the stability number N = g H / c at collapse.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from qsmpm_verify.reference.arguments import between, friction_angle, positive, within
from qsmpm_verify.reference.element_tests import davis_cohesion, davis_friction
from qsmpm_verify.reference.numerics import minimum, root

GAUSS = np.polynomial.legendre.leggauss(32)
"""Points and weights of the integral along a slip circle."""
NEVER = 1e30
"""Stability number for an inadmissible slip surface."""
Number = Callable[[float, float], float]


def _spiral(place: Sequence[float], slope: float, angle: float) -> float:
    """N of the spiral between the angles place[0] (crest) and place[1] (toe); slope = tan phi."""
    start, end = place
    if not 0 < start < end < math.pi:
        return NEVER
    growth = math.exp((end - start) * slope)
    rise = math.sin(end) * growth - math.sin(start)
    top = math.cos(start) - math.cos(end) * growth - rise / math.tan(angle)
    if rise <= 1e-9 or top <= 1e-9:
        return NEVER
    cube = growth**3
    sector = (3 * slope * math.cos(end) + math.sin(end)) * cube - 3 * slope * math.cos(start) - math.sin(start)
    above = top * (2 * math.cos(start) - top) * math.sin(start) / 6
    beside = growth / 6 * (math.sin(end - start) - top * math.sin(end))
    beside *= math.cos(start) - top + math.cos(end) * growth
    weight = sector / (3 * (1 + 9 * slope**2)) - above - beside
    if weight <= 1e-12:
        return NEVER
    return math.expm1(2 * (end - start) * slope) / (2 * slope) * rise / weight


def _circle(place: Sequence[float], slope: float, angle: float) -> float:
    """N of the slip circle by Bishop's slices at F = 1: place = width behind the crest / H, half the arc's angle."""
    behind, half = place
    run = 1 / math.tan(angle) if angle < math.pi / 2 else 0.0
    if behind <= 1e-6 or not 1e-3 < half < math.pi / 2:
        return NEVER
    far = run + behind
    chord = math.hypot(far, 1.0)
    radius = chord / (2 * math.sin(half))
    lift = radius * math.cos(half) / chord
    centre_x, centre_y = far / 2 - lift, 0.5 + lift * far
    if centre_y < 1 or centre_x + radius < far or centre_x - radius > 0:
        return NEVER
    places, weights = GAUSS
    pieces = [(0.0, run), (run, far)] if run > 0 else [(0.0, far)]
    x = np.concatenate([a + (b - a) * (places + 1) / 2 for a, b in pieces])
    width = np.concatenate([(b - a) * weights / 2 for a, b in pieces])
    sine = (x - centre_x) / radius
    cosine = np.sqrt(1 - sine**2)
    surface = np.minimum(x * math.tan(angle), 1.0) if run > 0 else np.ones_like(x)
    weight = width * (surface - (centre_y - radius * cosine))
    share = cosine + sine * slope
    if np.min(share) < 0.1:
        return NEVER
    driving = float(np.sum(weight * sine) - np.sum(weight * slope / share))
    return float(np.sum(width / share)) / driving if driving > 1e-12 else NEVER


def _least(surface: Callable[..., float], slope: float, angle: float, ranges: tuple[float, float]) -> float:
    """Smallest N over slip surfaces: a grid, then a simplex search from its best point; NEVER if none is found."""
    grid = [(ranges[0] * (i + 0.5) / 30, ranges[1] * (j + 0.5) / 30) for i in range(30) for j in range(30)]
    best = min(grid, key=lambda place: surface(place, slope, angle))
    if surface(best, slope, angle) >= NEVER:
        return NEVER
    return math.exp(minimum(lambda place: math.log(surface(place, slope, angle)), best))


def _spiral_number(friction: float, angle: float) -> float:
    """Stability number of the best spiral, angles in radian."""
    return _least(_spiral, math.tan(friction), angle, (math.pi, math.pi))


def _circle_number(friction: float, angle: float) -> float:
    """Stability number of the best circle, angles in radian."""
    return _least(_circle, math.tan(friction), angle, (4.0, math.pi / 2))


def _unit_weight(number: Number, cohesion: float, friction: float, angle: float, height: float) -> float:
    """Critical unit weight of checked arguments."""
    positive(cohesion=cohesion, height=height)
    phi = friction_angle("friction", friction, 1.0)
    within("angle", angle, friction + 1, 90.0)
    found = number(phi, math.radians(angle))
    if found >= NEVER:
        raise ArithmeticError("no slip surface found: the slope angle hardly exceeds the friction angle")
    return found * cohesion / height


def _safety(
    number: Number, unit_weight: float, cohesion: float, friction: float, angle: float, height: float
) -> float:
    """Factor by which c and tan phi are divided until the slope is critical."""
    positive(unit_weight=unit_weight, cohesion=cohesion, height=height)
    slope = math.tan(friction_angle("friction", friction, 1.0))
    within("angle", angle, friction + 1, 90.0)

    def spare(factor: float) -> float:
        reduced = math.atan(slope / factor)
        return math.log(number(reduced, math.radians(angle)) * cohesion / (factor * unit_weight * height))

    # friction alone holds the slope at the least factor
    least = 1.0005 * slope / math.tan(math.radians(min(angle, 89.0)))
    high = 2 * max(least, 1.0)
    while spare(high) > 0:
        high *= 2
    return root(spare, least, high, 1e-9)


def slope_spiral_unit_weight(cohesion: float, friction: float, angle: float, height: float) -> float:
    """Critical unit weight of a slope, psi = phi, best logarithmic spiral through the toe: an upper bound.

    Formula: g H / c = min over spirals of (dissipation along the spiral) / (moment of the weight about its pole)
    Units: cohesion [stress], friction and angle [degree], height [length]; result [force/volume]
    Range: 1 <= phi, phi + 1 <= angle <= 90; below phi = 5 and 53 degrees deeper surfaces can be more critical
    Assumes: rigid rotation about the pole, associated flow
    Source: Chen 1975
    Check: dissipation and weight of the sliding body summed over polygons, search by differential evolution
    """
    return _unit_weight(_spiral_number, cohesion, friction, angle, height)


def slope_bishop_unit_weight(cohesion: float, friction: float, angle: float, height: float) -> float:
    """Critical unit weight of a slope by Bishop's simplified method, best circle through the toe.

    Formula: 1 = sum((c b + W tan phi) / (cos a + sin a tan phi)) / sum(W sin a), least over circles
    Units: cohesion [stress], friction and angle [degree], height [length]; result [force/volume]
    Range: as slope_spiral_unit_weight
    Assumes: horizontal forces between slices, no water
    Source: Bishop 1955; own search over circles
    Check: factor of safety of one by plain slices, search by differential evolution
    """
    return _unit_weight(_circle_number, cohesion, friction, angle, height)


def slope_spiral_safety(
    unit_weight: float, cohesion: float, friction: float, angle: float, height: float
) -> float:
    """Strength reduction factor of a slope, best logarithmic spiral through the toe.

    Formula: F such that slope_spiral_unit_weight(c / F, atan(tan phi / F)) = unit_weight
    Units: unit_weight [force/volume], cohesion [stress], friction and angle [degree], height [length]; result [-]
    Range: as slope_spiral_unit_weight
    Assumes: as slope_spiral_unit_weight
    Source: own search
    Check: the reduced strengths are critical for polygons
    """
    return _safety(_spiral_number, unit_weight, cohesion, friction, angle, height)


def slope_davis_a_safety(
    unit_weight: float, cohesion: float, friction: float, dilatancy: float, angle: float, height: float
) -> float:
    """Strength reduction factor of a slope with dilatancy less than friction, Davis A.

    Formula: slope_spiral_safety of c* = b c and tan phi* = b tan phi, b of davis_factor with the given angles
    Units: as slope_spiral_safety, dilatancy [degree]
    Range: as slope_spiral_unit_weight of phi*, 0 <= psi <= phi
    Assumes: as davis_factor and slope_spiral_unit_weight
    Source: Davis 1968; Tschuchnigg, Schweiger & Sloan 2015; own search
    Check: the reduced strengths are critical for polygons
    """
    strengths = davis_cohesion(cohesion, friction, dilatancy), davis_friction(friction, dilatancy)
    return slope_spiral_safety(unit_weight, *strengths, angle, height)


def slope_davis_b_safety(
    unit_weight: float, cohesion: float, friction: float, dilatancy: float, angle: float, height: float
) -> float:
    """The same, Davis B: b from the angles divided by the factor.

    Formula: F such that slope_davis_a_safety(c / F, phi_F, min(psi, phi_F)) = 1, tan phi_F = tan phi / F
    Units: as slope_davis_a_safety
    Range: as slope_davis_a_safety
    Assumes: as slope_davis_a_safety
    Source: Tschuchnigg, Schweiger & Sloan 2015; own search
    Check: the reduced strengths are critical for polygons
    """
    slope = math.tan(friction_angle("friction", friction, 1.0))

    def spare(factor: float) -> float:
        reduced = math.degrees(math.atan(slope / factor))
        flow = min(dilatancy, reduced)
        return math.log(slope_davis_a_safety(unit_weight, cohesion / factor, reduced, flow, angle, height))

    associated = slope_spiral_safety(unit_weight, cohesion, friction, angle, height)
    low = 0.5 * associated
    return root(spare, low, 1.0001 * associated, 1e-9)


def slope_bishop_safety(
    unit_weight: float, cohesion: float, friction: float, angle: float, height: float
) -> float:
    """Factor of safety of a slope by Bishop's simplified method, best circle through the toe.

    Formula: F = sum((c b + W tan phi) / (cos a + sin a tan phi / F)) / sum(W sin a), least over circles
    Units: as slope_spiral_safety
    Range: as slope_spiral_unit_weight
    Assumes: as slope_bishop_unit_weight
    Source: Bishop 1955; Griffiths & Lane 1999, example 1, is 1.38 by charts and 1.4 by finite elements
    Check: plain slices with the fixed-point iteration of F, search by differential evolution
    """
    return _safety(_circle_number, unit_weight, cohesion, friction, angle, height)


def slope_steepest_angle(load: float, friction: float) -> float:
    """Steepest stable slope, psi = phi, logarithmic spiral through the toe.

    Formula: angle such that g H / c of slope_spiral_unit_weight is the load
    Units: load = g H / c [-], friction [degree]; result [degree]
    Range: load above the stability number of a vertical cut
    Assumes: as slope_spiral_unit_weight
    Source: own search
    Check: slope_spiral_unit_weight at the angle found, by the polygons of its check
    """
    phi = friction_angle("friction", friction, 1.0)
    between("load", load, low=_spiral_number(phi, math.pi / 2))
    angle = root(lambda a: math.log(_spiral_number(phi, a) / load), phi + math.radians(1.0), math.pi / 2, 1e-9)
    return math.degrees(angle)


def slope_associated_unit_weight() -> float:
    """Critical unit weight of the 45 degree slope of the paper, psi = phi: 22.896 kN/m3, an upper bound.

    Formula: slope_spiral_unit_weight(c = 1 kPa, phi = 25, angle = 45, H = 1 m)
    Units: result [kN/m3]
    Range: this slope
    Assumes: as slope_spiral_unit_weight
    Source: own search; Chen 1975 prints 22.92
    Check: as slope_spiral_unit_weight
    """
    return slope_spiral_unit_weight(1.0, 25.0, 45.0, 1.0)


def slope_davis_unit_weight() -> float:
    """The same with Davis's strengths for psi = 0: 17.787 kN/m3, a lower estimate.

    Formula: slope_spiral_unit_weight(c* = b c, tan phi* = b tan phi), b = cos phi
    Units: result [kN/m3]
    Range: this slope
    Assumes: as davis_factor and slope_spiral_unit_weight
    Source: Davis 1968; own search
    Check: as slope_spiral_unit_weight
    """
    return slope_spiral_unit_weight(davis_cohesion(1.0, 25.0, 0.0), davis_friction(25.0, 0.0), 45.0, 1.0)


def slope_elastic_settlement(unit_weight: float, young: float = 1.0) -> float:
    """Elastic crest settlement of the 45 degree slope.

    Formula: u = 0.304384 g H^2 / E
    Units: unit_weight [kN/m3], young [kPa]; result [m]
    Range: H = 1 m, nu = 0.33, small strain
    Assumes: base fixed at toe level, left side on rollers 1 m behind the crest point (2 m behind: 0.303415)
    Source: own finite elements, 6-node triangles, 16 to 256 cells per height, extrapolated to zero size; CalculiX 2.20 the same to 128
    Check: limit of CalculiX on 8 to 32 cells per height (`qsmpm-verify peers slope`); linearity in g / E; bounds
    """
    positive(young=young)
    return 0.304384 * unit_weight / young
