"""A column that compresses under its own weight, lateral strain prevented or nu = 0.

Height l0, modulus E, unit weight g (force per initial volume); Q = g l0 / E is the only parameter that
matters. Compression is positive. A negative unit weight describes a hanging column.
"""

from __future__ import annotations

import math

from qsmpm_verify.reference.arguments import between, positive, step_count, within


def lambert_w(x: float) -> float:
    """Principal branch of Lambert's W.

    Formula: w exp(w) = x
    Units: [-]
    Range: x >= -1/e
    Assumes: nothing; Halley iteration to round-off
    Source: Corless et al. 1996
    Check: the inverse function; scipy.special.lambertw
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


def _load(height: float, young: float, unit_weight: float, least: float) -> float:
    """Q = g l0 / E, rejected at or below the least value with a solution."""
    positive(height=height, young=young)
    load = unit_weight * height / young
    if load <= least:
        raise ValueError(f"hanging column with unit_weight * height / young = {load:g}: no equilibrium")
    return load


def column_height_hencky(height: float, young: float, unit_weight: float) -> float:
    """Height of the column, logarithmic law.

    Formula: h = (E/g) (W(Q) + W(Q)^2 / 2), Q = g l0 / E
    Units: height [length], young [stress], unit_weight [force/volume]; result [length]
    Range: Q > -1/e
    Assumes: nu = 0; stretch exp(-W(q)) at reference height X, q = g (l0 - X) / E
    Source: own derivation; reproduces the 24.060 m of AMPLE's column (Coombs & Augarde 2020: 50 m, 10 kPa, 0.8 kN/m3)
    Check: quadrature of the stretch found by bisection of the equilibrium
    """
    if unit_weight == 0:
        return height
    w = lambert_w(_load(height, young, unit_weight, -math.exp(-1)))
    return young / unit_weight * (w + w * w / 2)


def column_position_hencky(place: float, height: float, young: float, unit_weight: float) -> float:
    """Final height of a point of the column initially at height X, logarithmic law.

    Formula: x(X) = (E/g) (G(Q) - G(q)), G(q) = W(q) + W(q)^2 / 2, q = g (l0 - X) / E
    Units: position X and height [length], young [stress], unit_weight [force/volume]; result [length]
    Range: 0 <= X <= l0, Q > -1/e
    Assumes: as column_height_hencky
    Source: own derivation, integral of the stretch from the foot
    Check: quadrature of the stretch; finite differences of x(X)
    """
    within("place", place, -1e-9 * height, height * (1 + 1e-9))
    if unit_weight == 0:
        return place
    foot = lambert_w(_load(height, young, unit_weight, -math.exp(-1)))
    below = lambert_w(unit_weight * (height - place) / young)
    return young / unit_weight * (foot + foot * foot / 2 - below - below * below / 2)


def column_base_stretch_hencky(height: float, young: float, unit_weight: float) -> float:
    """Stretch at the foot of the column, logarithmic law.

    Formula: lambda = exp(-W(Q))
    Units: height [length], young [stress], unit_weight [force/volume]; result [-]
    Range: Q > -1/e
    Assumes: as column_height_hencky
    Source: own derivation
    Check: bisection of the equilibrium g l0 = -E ln(lambda) / lambda
    """
    return math.exp(-lambert_w(_load(height, young, unit_weight, -math.exp(-1))))


def column_height_rate(height: float, young: float, unit_weight: float) -> float:
    """Height of the column, rate law.

    Formula: h = (E/g) ln(1 + Q)
    Units: height [length], young [stress], unit_weight [force/volume]; result [length]
    Range: Q > -1: a hanging column with weight at or above E has no equilibrium
    Assumes: nu = 0 (otherwise the constrained modulus for E); constant mass
    Source: own derivation
    Check: quadrature of the stretch of the integrated rate
    """
    if unit_weight == 0:
        return height
    return young / unit_weight * math.log1p(_load(height, young, unit_weight, -1.0))


def column_position_rate(place: float, height: float, young: float, unit_weight: float) -> float:
    """Final height of a point of the column initially at height X, rate law.

    Formula: x(X) = (E/g) ln((1 + Q) / (1 + q)), q = g (l0 - X) / E
    Units: position X and height [length], young [stress], unit_weight [force/volume]; result [length]
    Range: 0 <= X <= l0, Q > -1
    Assumes: as column_height_rate
    Source: own derivation, integral of the stretch from the foot
    Check: quadrature of the stretch of the integrated rate
    """
    within("place", place, -1e-9 * height, height * (1 + 1e-9))
    if unit_weight == 0:
        return place
    load = _load(height, young, unit_weight, -1.0)
    return young / unit_weight * (math.log1p(load) - math.log1p(unit_weight * (height - place) / young))


def column_base_stretch_rate(height: float, young: float, unit_weight: float) -> float:
    """Stretch at the foot of the column, rate law.

    Formula: lambda = 1 / (1 + Q)
    Units: height [length], young [stress], unit_weight [force/volume]; result [-]
    Range: Q > -1
    Assumes: as column_height_rate
    Source: own derivation
    Check: Runge-Kutta integration of d lambda / d sigma = lambda / (E - sigma), tension positive
    """
    return 1 / (1 + _load(height, young, unit_weight, -1.0))


def column_height_paper_steps(height: float, young: float, unit_weight: float, steps: float) -> float:
    """Height of the column, rate law, weight applied in n equal steps of the first-order update.

    Formula: h = (E/g) (ln(1 + b Q) / b^2 - a Q / b), a = 1/n, b = 1 - a; (E/g)(Q - Q^2/2) for n = 1
    Units: height [length], young [stress], unit_weight [force/volume], steps [-]; result [length]
    Range: n > Q, otherwise the foot inverts in the first step; Q > -1
    Assumes: as column_height_rate; stress at the start of the step in -sigma tr(d eps); lambda = (1 - a q)/(1 + b q)
    Source: own derivation
    Check: the update carried out step by step at many heights, midpoint rule
    """
    load = _load(height, young, unit_weight, -1.0)
    count = step_count(steps)
    between("unit_weight * height / young", load, high=count)
    a = 1 / count
    b = 1 - a
    if b == 0:
        return young / unit_weight * (load - load * load / 2)
    return young / unit_weight * (math.log1p(b * load) / b**2 - a * load / b)


def column_height_shrinking_mass(height: float, young: float, unit_weight: float) -> float:
    """Height of the column if the mass of a point were its density times its decreasing volume: an error, not a target.

    Formula: h = (E/g) (sqrt(1 + 2 Q) - 1)
    Units: height [length], young [stress], unit_weight [force/volume]; result [length]
    Range: Q > -1/2
    Assumes: rate law, eq. 29 of Beuth et al. 2008 with a constant density: the weight decreases with the volume
    Source: own derivation, l0 = h + g h^2 / (2 E)
    Check: iteration of a stack of thin slices whose weight follows their volume
    """
    if unit_weight == 0:
        return height
    return young / unit_weight * (math.sqrt(1 + 2 * _load(height, young, unit_weight, -0.5)) - 1)


def column_stress(place: float, height: float, unit_weight: float) -> float:
    """Vertical stress at the point initially at height X, for any law, compression positive.

    Formula: sigma = g (l0 - X)
    Units: position X and height [length], unit_weight [force/volume]; result [stress]
    Range: 0 <= X <= l0
    Assumes: equilibrium, constant mass, no lateral strain
    Source: equilibrium
    Check: sum of the weights of thin slices above the point
    """
    positive(height=height)
    within("place", place, -1e-9 * height, height * (1 + 1e-9))
    return unit_weight * (height - place)


def column_base_stress(height: float, unit_weight: float) -> float:
    """Vertical stress at the foot of the column, for any law, compression positive.

    Formula: sigma = g l0
    Units: height [length], unit_weight [force/volume]; result [stress]
    Range: height > 0
    Assumes: equilibrium, constant mass
    Source: equilibrium
    Check: sum of the weights of thin slices
    """
    return column_stress(0.0, height, unit_weight)
