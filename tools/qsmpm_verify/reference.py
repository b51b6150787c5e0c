"""Reference solutions: closed forms, independent integrations and published figures.

Every function states formula, source and units, takes and returns plain numbers in consistent
units, and has its own test in tests/test_reference.py. Compression is positive here where a formula
is usually written that way (oedometer, column); the docstring says so.
"""

from __future__ import annotations

import math
from collections.abc import Callable

Reference = Callable[..., float]


def constrained_modulus(young: float, poisson: float) -> float:
    """Modulus of one-dimensional compression, M = E (1-nu) / ((1+nu)(1-2 nu)) [stress].

    Source: linear elasticity with zero lateral strain.
    """
    return young * (1 - poisson) / ((1 + poisson) * (1 - 2 * poisson))


def van_langen(strain: float, modulus: float = 1.0) -> float:
    """Axial Cauchy stress of the oedometer, sigma = M e / (1 - e), compression positive [stress].

    e = 1 - L/L0 is the engineering strain, M the constrained modulus (E for nu = 0). It is the exact
    integral of the Jaumann law with the -sigma tr(d eps) term: d(lambda sigma) = M d lambda.
    Source: van Langen 1991, E (exp(eps_L) - 1) with eps_L = -ln(1 - e); Beuth et al. 2008, sect. 4.1.
    """
    return modulus * strain / (1 - strain)


def van_langen_paper_steps(strain: float, steps: float, modulus: float = 1.0) -> float:
    """The same with n equal strain steps of the first-order update, M e / (1 - e + e/n) [stress].

    The stress of the step's start in the -sigma tr(d eps) term (INTEGRATION=PAPER): the product of
    the step factors (M + s_k) = (M + s_(k-1)) (1 + d_k) telescopes. Source: own derivation.
    """
    return modulus * strain / (1 - strain + strain / steps)


def hencky_oedometer(strain: float, modulus: float = 1.0) -> float:
    """Axial Cauchy stress of the oedometer for KINEMATICS=LOGARITHMIC, compression positive [stress].

    Kirchhoff stress linear in the logarithmic strain, tau = M eps_L, hence
    sigma = M eps_L exp(eps_L) with eps_L = -ln(1 - e). Source: Hencky 1928 elasticity, own derivation.
    """
    logarithmic = -math.log1p(-strain)
    return modulus * logarithmic * math.exp(logarithmic)


def lambert_w(x: float) -> float:
    """Principal branch of Lambert's W, w exp(w) = x for x >= -1/e [-].

    Newton-Halley iteration. Source: Corless et al. 1996.
    """
    if x < -math.exp(-1):
        raise ValueError(f"Lambert W has no real value at {x}")
    w = math.log1p(x) if x > -0.25 else -1 + math.sqrt(2 * (1 + math.e * x))
    for _ in range(50):
        excess = w * math.exp(w) - x
        slope = math.exp(w) * (w + 1)
        if slope == 0 or excess == 0:
            break
        change = excess / (slope - (w + 2) * excess / (2 * w + 2))
        w -= change
        if abs(change) <= 1e-16 * (1 + abs(w)):
            break
    return w


def column_height_hencky(height: float, young: float, unit_weight: float) -> float:
    """Height of a column under its own weight, Hencky law, nu = 0 [length].

    h = (E/g) (W(Q) + W(Q)^2 / 2) with g the unit weight, Q = g l0 / E and W Lambert's function.
    Stretch at reference height X: lambda = exp(-W(q)), q = g (l0 - X) / E.
    Source: own derivation; the setting (l0 50 m, E 10 kPa, rho 80, g 10) is AMPLE's column, whose
    24.060 m it reproduces (Coombs & Augarde 2020).
    """
    w = lambert_w(unit_weight * height / young)
    return young / unit_weight * (w + w * w / 2)


def column_position_hencky(place: float, height: float, young: float, unit_weight: float) -> float:
    """Height at which a point of the column ends that was at height X, Hencky law, nu = 0 [length].

    x(X) = (E/g) (G(g l0 / E) - G(g (l0 - X) / E)) with G(q) = W(q) + W(q)^2 / 2: the integral of the
    stretch exp(-W(q)), for G'(q) = W'(q) (1 + W(q)) = exp(-W(q)). Source: own derivation.
    """
    below = lambert_w(unit_weight * (height - place) / young)
    foot = lambert_w(unit_weight * height / young)
    return young / unit_weight * (foot + foot * foot / 2 - below - below * below / 2)


def column_height_rate(height: float, young: float, unit_weight: float) -> float:
    """Height of a column under its own weight, Jaumann law, nu = 0 [length].

    h = (E/g) ln(1 + Q), Q = g l0 / E; lambda = 1 / (1 + q). Mass is kept. Source: own derivation.
    """
    return young / unit_weight * math.log1p(unit_weight * height / young)


def column_height_paper_steps(height: float, young: float, unit_weight: float, steps: float) -> float:
    """The same with gravity applied in n equal steps of the first-order update [length].

    lambda = (1 - a q) / (1 + b q) with a = 1/n, b = 1 - a;
    h = (E/g) [ln(1 + b Q) / b^2 - a Q / b] for n > 1, (E/g) (Q - Q^2/2) for n = 1.
    Source: own derivation.
    """
    load = unit_weight * height / young
    a = 1 / steps
    b = 1 - a
    if b == 0:
        return young / unit_weight * (load - load * load / 2)
    return young / unit_weight * (math.log1p(b * load) / b**2 - a * load / b)


def column_base_stress(height: float, unit_weight: float) -> float:
    """Vertical stress at the foot of a column, g l0 whatever the law, compression positive [stress].

    Source: equilibrium; mass is kept.
    """
    return unit_weight * height


def _shoot(
    start_slope: float, load: float, axial: float, shear: float, steps: int
) -> tuple[float, float, float]:
    """Tip slope derivative and tip coordinates for a start curvature (unit length, Runge-Kutta 4)."""

    def rate(state: tuple[float, float, float, float]) -> tuple[float, float, float, float]:
        theta, bending = state[0], state[1]
        sine, cosine = math.sin(theta), math.cos(theta)
        stretch, slide = 1 + load * sine * axial, load * cosine * shear
        forward = stretch * cosine - slide * sine
        sideways = stretch * sine + slide * cosine
        return bending, -load * forward, forward, sideways

    h = 1 / steps
    y = (0.0, start_slope, 0.0, 0.0)
    for _ in range(steps):
        k1 = rate(y)
        k2 = rate(tuple(a + h / 2 * b for a, b in zip(y, k1)))
        k3 = rate(tuple(a + h / 2 * b for a, b in zip(y, k2)))
        k4 = rate(tuple(a + h * b for a, b in zip(y, k3)))
        y = tuple(a + h / 6 * (b + 2 * c + 2 * d + e) for a, b, c, d, e in zip(y, k1, k2, k3, k4))
    return y[1], y[2], y[3]


def cantilever_tip(
    load_parameter: float, axial: float = 0.0, shear: float = 0.0, steps: int = 400
) -> tuple[float, float]:
    """Tip shortening u/L and deflection w/L of a cantilever under a dead transverse end load [-].

    k = P L^2 / (E I); axial = E I / (E A L^2) and shear = E I / (G A_s L^2) are the flexibilities
    of the Reissner beam, zero for the elastica:
    E I theta' = M, M' = -P x', x' = (1 + e) cos theta - g sin theta, e = P sin theta / EA,
    g = P cos theta / GA_s, theta(0) = 0, M(L) = 0; shooting on M(0) by bisection.
    Source: Reissner 1972; the elastica figures agree with Mattiasson 1981 to his five digits.
    """
    low, high = 0.0, 4 * load_parameter
    while high - low > 1e-13 * (1 + high):
        middle = (low + high) / 2
        if _shoot(middle, load_parameter, axial, shear, steps)[0] < 0:
            low = middle
        else:
            high = middle
    _, x, y = _shoot((low + high) / 2, load_parameter, axial, shear, steps)
    return 1 - x, y


def _beam(
    force: float, length: float, depth: float, young: float, poisson: float, elastica: bool
) -> tuple[float, float]:
    """Tip shortening and deflection of a plane-strain beam of unit width [length]."""
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
    """Tip deflection w of a plane-strain cantilever of unit width, dead end load [length].

    Reissner beam with E / (1 - nu^2) and shear factor 5/6; `elastica` leaves axial and shear strain
    out. AMPLE's beam (10 x 1 m, 12 MPa, nu 0.2, 100 kN; k = 9.6): 8.1754 m, elastica 8.0624 m.
    Source: see cantilever_tip.
    """
    return _beam(force, length, depth, young, poisson, elastica)[1]


def beam_shortening(
    force: float, length: float, depth: float, young: float, poisson: float, elastica: bool = False
) -> float:
    """Tip shortening u of the same beam [length]: 5.4804 m, elastica 5.4613 m for AMPLE's."""
    return _beam(force, length, depth, young, poisson, elastica)[0]


def slope_elastic_settlement(unit_weight: float, young: float = 1.0) -> float:
    """Crest settlement of the 45 degree slope while it is elastic, 0.30344 gamma H^2 / E [length].

    H = 1 m, nu = 0.33, base fixed at toe level, left side on rollers 2 m behind the crest point.
    Source: own finite-element computation (8-node cells, converged to the digits given).
    """
    return 0.30344 * unit_weight / young


def slope_associated_unit_weight() -> float:
    """Critical unit weight of the 45 degree slope, psi = phi [force/volume]: 22.896 kN/m3.

    c = 1 kPa, phi = 25 degrees, H = 1 m; optimum log spiral through the toe, an upper bound.
    Source: own optimisation; Chen 1975 prints 22.92.
    """
    return 22.896


def slope_davis_unit_weight() -> float:
    """The same with Davis's strengths for psi = 0 [force/volume]: 17.787 kN/m3, a lower estimate.

    c* = b c, tan phi* = b tan phi, b = cos psi cos phi / (1 - sin psi sin phi).
    Source: Davis 1968, log spiral with the reduced strengths.
    """
    return 17.787


def prandtl_footing(cohesion: float = 1.0) -> float:
    """Bearing pressure of a rigid strip footing on Tresca soil, (2 + pi) s_u [stress].

    Source: Prandtl 1920; the same for smooth and rough footings.
    """
    return (2 + math.pi) * cohesion


REFERENCES: dict[str, Reference] = {
    f.__name__: f
    for f in (
        constrained_modulus,
        van_langen,
        van_langen_paper_steps,
        hencky_oedometer,
        column_height_hencky,
        column_position_hencky,
        column_height_rate,
        column_height_paper_steps,
        column_base_stress,
        beam_deflection,
        beam_shortening,
        slope_elastic_settlement,
        slope_associated_unit_weight,
        slope_davis_unit_weight,
        prandtl_footing,
    )
}
"""The functions a case file may name."""
