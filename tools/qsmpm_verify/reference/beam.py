"""Slender bars: cantilever under a dead end load, buckling column.

The cantilever is Reissner's beam (bending, axial and shear strain); with zero flexibilities it is
the elastica. Lengths are divided by L, forces by E I / L^2 unless the docstring says otherwise.
"""

from __future__ import annotations

import math

from qsmpm_verify.reference.arguments import between, not_negative, poisson_ratio, positive
from qsmpm_verify.reference.numerics import integral, root

State = tuple[float, float, float, float]


def _shoot(start: float, load: float, axial: float, shear: float, steps: int) -> State:
    """Slope, bending moment and position of the tip for a moment at the clamp (Runge-Kutta 4, unit length)."""

    def rate(state: State) -> State:
        sine, cosine = math.sin(state[0]), math.cos(state[0])
        stretch, slide = 1 + load * sine * axial, load * cosine * shear
        forward = stretch * cosine - slide * sine
        return state[1], -load * forward, forward, stretch * sine + slide * cosine

    def moved(state: State, by: float, change: State) -> State:
        return tuple(a + by * b for a, b in zip(state, change))  # type: ignore[return-value]

    h = 1 / steps
    y: State = (0.0, start, 0.0, 0.0)
    for _ in range(steps):
        k1 = rate(y)
        k2 = rate(moved(y, h / 2, k1))
        k3 = rate(moved(y, h / 2, k2))
        k4 = rate(moved(y, h, k3))
        for weight, change in ((1, k1), (2, k2), (2, k3), (1, k4)):
            y = moved(y, h * weight / 6, change)
    return y


def _tip(load: float, axial: float, shear: float, steps: int) -> State:
    """State of the tip of the beam in equilibrium: shooting method on the moment at the clamp."""
    between("load_parameter", load, 0.0, 45.0)
    not_negative(axial=axial, shear=shear)
    between("load_parameter * (shear - axial)", load * (shear - axial), high=1.0)
    # the moment of a beam bent to 90 degrees; below the least one the beam would swing back and forth
    most = math.sqrt(2 * load + load**2 * max(axial - shear, 0.0))
    least = 0.0 if load <= 10 else 0.97 * most
    start = root(lambda moment: _shoot(moment, load, axial, shear, steps)[1], least, 1.01 * most)
    return _shoot(start, load, axial, shear, steps)


def cantilever_tip(
    load_parameter: float, axial: float = 0.0, shear: float = 0.0, steps: int = 400
) -> tuple[float, float]:
    """Tip shortening u/L and deflection w/L of a cantilever under a dead transverse end load.

    Formula: E I theta' = M, M' = -P x', x' = (1 + e) cos theta - g sin theta, \
e = P sin theta / EA, g = P cos theta / GAs
    Units: load_parameter k = P L^2 / (E I) [-], axial = E I / (E A L^2) and shear = E I / (G As L^2) [-]; result [-]
    Range: 0 < k < 45, k (shear - axial) < 1
    Assumes: theta(0) = 0, M(L) = 0, load of constant direction; axial = shear = 0 is the elastica
    Source: Reissner 1972; the elastica agrees with Mattiasson 1981 to his five digits
    Check: first integral M(theta) and quadrature over the slope
    """
    _, _, x, y = _tip(load_parameter, axial, shear, steps)
    return 1 - x, y


def cantilever_slope(load_parameter: float, axial: float = 0.0, shear: float = 0.0) -> float:
    """Slope of the tip of the same cantilever.

    Formula: theta(L) of cantilever_tip
    Units: as cantilever_tip; result [radian]
    Range: as cantilever_tip
    Assumes: as cantilever_tip
    Source: Reissner 1972; Mattiasson 1981
    Check: first integral M(theta) and quadrature over the slope
    """
    return _tip(load_parameter, axial, shear, 400)[0]


def _beam(
    force: float, length: float, depth: float, young: float, poisson: float, elastica: bool
) -> tuple[float, float]:
    """Tip shortening and deflection of a plane-strain beam of unit width [length]."""
    positive(force=force, length=length, depth=depth, young=young)
    poisson_ratio(poisson)
    plane = young / (1 - poisson**2)
    bending = plane * depth**3 / 12
    shear_stiffness = 5 / 6 * young / (2 * (1 + poisson)) * depth
    axial = 0.0 if elastica else bending / (plane * depth * length**2)
    shear = 0.0 if elastica else bending / (shear_stiffness * length**2)
    shortening, deflection = cantilever_tip(force * length**2 / bending, axial, shear)
    return length * shortening, length * deflection


def beam_deflection(
    force: float, length: float, depth: float, young: float, poisson: float, elastica: bool = False
) -> float:
    """Tip deflection of a plane-strain cantilever of unit width, dead end load.

    Formula: L w(k)/L of cantilever_tip, EI = E d^3 / (12 (1 - nu^2)), EA = E d / (1 - nu^2), GAs = 5/6 G d
    Units: force [force/width], length and depth [length], young [stress]; result [length]
    Range: a slender beam, depth well below length; -1 < nu < 0.5
    Assumes: Reissner beam; elastica neglects axial and shear strain
    Source: Reissner 1972; AMPLE's beam (10 x 1 m, 12 MPa, nu 0.2, 100 kN) gives 8.1754 m, elastica 8.0624 m
    Check: quadrature over the slope; engineering beam theory with shear at a small load
    """
    return _beam(force, length, depth, young, poisson, elastica)[1]


def beam_shortening(
    force: float, length: float, depth: float, young: float, poisson: float, elastica: bool = False
) -> float:
    """Tip shortening of the same beam.

    Formula: L u(k)/L of cantilever_tip, stiffnesses as beam_deflection
    Units: as beam_deflection; result [length]
    Range: as beam_deflection
    Assumes: as beam_deflection
    Source: Reissner 1972; AMPLE's beam gives 5.4804 m, elastica 5.4613 m
    Check: quadrature over the slope
    """
    return _beam(force, length, depth, young, poisson, elastica)[0]


def euler_load(bending_stiffness: float, length: float) -> float:
    """Buckling load of a column clamped at the foot and free at the head, dead axial load.

    Formula: P = pi^2 E I / (4 L^2) = 2.467401 E I / L^2
    Units: bending_stiffness E I [force length^2], length [length]; result [force]
    Range: both positive
    Assumes: no axial and shear strain
    Source: Euler 1744; Timoshenko & Gere 1961
    Check: smallest eigenvalue of a finite-difference column
    """
    positive(bending_stiffness=bending_stiffness, length=length)
    return math.pi**2 * bending_stiffness / (4 * length**2)


def _modulus(slope: float) -> float:
    """sin(alpha/2) of the tip slope in degrees."""
    between("slope", slope, 0.0, 180.0)
    return math.sin(math.radians(slope) / 2)


def _elliptic(modulus: float, power: int) -> float:
    """Complete elliptic integral K (power -1) or E (power 1) by quadrature."""
    return integral(lambda a: (1 - (modulus * math.sin(a)) ** 2) ** (power / 2), 0.0, math.pi / 2)


def post_buckling_load(slope: float) -> float:
    """Axial load over the buckling load at a slope of the tip.

    Formula: P / P_cr = (2 K(p) / pi)^2, p = sin(alpha / 2)
    Units: slope alpha of the tip [degree]; result [-]
    Range: 0 < alpha < 180
    Assumes: inextensible column clamped at the foot, dead load
    Source: Lagrange; Timoshenko & Gere 1961 (60 degrees: 1.152)
    Check: Runge-Kutta integration of E I theta'' = -P sin theta from foot to head
    """
    return (2 * _elliptic(_modulus(slope), -1) / math.pi) ** 2


def post_buckling_deflection(slope: float) -> float:
    """Lateral displacement of the tip over the length.

    Formula: w / L = 2 p / K(p), p = sin(alpha / 2)
    Units: slope alpha of the tip [degree]; result [-]
    Range: 0 < alpha < 180
    Assumes: as post_buckling_load
    Source: Timoshenko & Gere 1961 (60 degrees: 0.593)
    Check: Runge-Kutta integration from foot to head
    """
    modulus = _modulus(slope)
    return 2 * modulus / _elliptic(modulus, -1)


def post_buckling_height(slope: float) -> float:
    """Height of the tip above the foot over the length.

    Formula: h / L = 2 E(p) / K(p) - 1, p = sin(alpha / 2)
    Units: slope alpha of the tip [degree]; result [-], negative if the tip is below the foot
    Range: 0 < alpha < 180
    Assumes: as post_buckling_load
    Source: Timoshenko & Gere 1961 (60 degrees: 0.741)
    Check: Runge-Kutta integration from foot to head
    """
    modulus = _modulus(slope)
    return 2 * _elliptic(modulus, 1) / _elliptic(modulus, -1) - 1
