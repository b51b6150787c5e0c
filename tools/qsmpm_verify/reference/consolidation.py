"""Transient consolidation: a layer under a load, a cylinder and a sphere under external pressure.

M = E (1 - nu)/((1 + nu)(1 - 2 nu)) and G are the moduli of the skeleton, c = k M/gamma_w the coefficient of
consolidation; water and grains are incompressible. Pressures are divided by the load.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable

from qsmpm_verify.reference.arguments import poisson_ratio, positive, within

TERMS = 400
"""Terms of a time series."""
TALBOT = 24
"""Points on Talbot's contour."""
THICK_CELLS, THICK_STEPS = 100, 600
"""Differences in space and time of a layer with large strain."""
COLUMN_CELLS, COLUMN_STEPS = 100, 1000
"""Differences in space and time of a draining column."""


def layer_settlement(time_factor: float) -> float:
    """Settlement of a layer that drains at its top, over its final settlement.

    Formula: U = 1 - sum 8/((2 m + 1)^2 pi^2) exp(-((2 m + 1) pi/2)^2 T)
    Units: time_factor T = c t/H^2 [-]; result [-]
    Range: T > 0
    Assumes: one dimension, a load applied instantaneously and held constant, small strains
    Source: Terzaghi 1923
    Check: finite differences in depth and time
    """
    positive(time_factor=time_factor)
    odd = [(2 * m + 1) * math.pi / 2 for m in range(TERMS)]
    return 1 - sum(2 / r**2 * math.exp(-(r**2) * time_factor) for r in odd)


def ramped_layer_settlement(time_factor: float, rise: float) -> float:
    """Settlement of a layer that drains at its top under a load applied at a constant rate and then held constant, over its final settlement.

    Formula: (I(T) - I(T - T_0))/T_0, I(T) = T - sum 2/r^4 (1 - exp(-r^2 T)), r = (2 m + 1) pi/2; T < T_0: I(T)/T_0
    Units: time_factor T = c t/H^2 [-], rise T_0 at which the load reaches its final value [-]; result [-]
    Range: T > 0, T_0 > 0
    Assumes: one dimension, small strains
    Source: Terzaghi 1923, Terzaghi and Froelich 1936
    Check: mean of layer_settlement over the rise
    """
    positive(time_factor=time_factor, rise=rise)
    odd = [(2 * m + 1) * math.pi / 2 for m in range(TERMS)]

    def passed(time: float) -> float:
        return time - sum(2 / r**4 * -math.expm1(-(r**2) * time) for r in odd) if time > 0 else 0.0

    return (passed(time_factor) - passed(time_factor - rise)) / rise


def two_layer_settlement(time_factor: float, contrast: float, share: float = 0.5) -> float:
    """Settlement of soil below a more permeable layer that drains at its top, of equal stiffness, over its final settlement.

    Formula: by Laplace transform (K s)^1/2 (t + r)/((1 + r t) s^2), t = tanh(a (s/K)^1/2), r = tanh((1 - a) s^1/2)/K^1/2
    Units: time_factor T = c t/H^2 of the lower soil [-], contrast K of permeabilities, upper over lower [-], share a of the
        upper layer in the height H [-]; result [-]
    Range: T > 0, K > 0, a from 0 to 1
    Assumes: as layer_settlement
    Source: Schiffman and Stein 1970, by Talbot's inversion instead of their series
    Check: layer_settlement for K = 1; finite differences
    """
    positive(time_factor=time_factor, contrast=contrast)
    within("share", share, 0.0, 1.0)

    def transform(s: complex) -> complex:
        upper = cmath.tanh(share * cmath.sqrt(s / contrast))
        lower = cmath.tanh((1 - share) * cmath.sqrt(s)) / math.sqrt(contrast)
        return cmath.sqrt(contrast * s) * (upper + lower) / (1 + lower * upper) / s**2

    return _inverted(transform, time_factor)


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


def permeability_ratio(stretch: float, void_ratio: float = 0.0, index: float = 0.0, power: float = 0.0) -> float:
    """Permeability of soil whose volume has changed, over its initial value.

    Formula: e = (1 + e_0) J - 1; with C_k 10^((e - e_0)/C_k), without (e/e_0)^3 (1 + e_0)/(1 + e); without e_0 J^power
    Units: stretch J of the volume [-], void_ratio e_0 [-], index C_k [-], power [-]; result [-]
    Range: J > 0, e_0 and C_k from 0 on
    Assumes: incompressible grains
    Source: Taylor 1948 (index); Carman 1956 (e_0 alone); Xie and Leo 2004 (power 2)
    Check: values by hand
    """
    positive(stretch=stretch)
    within("void_ratio", void_ratio, 0.0)
    within("index", index, 0.0)
    e = max(0.0, (1 + void_ratio) * stretch - 1)
    if index > 0:
        return float(10 ** ((e - void_ratio) / index))
    if void_ratio > 0:
        return (e / void_ratio) ** 3 * (1 + void_ratio) / (1 + e)
    return float(stretch**power)


def thick_layer_settlement(
    time_factor: float, load: float, void_ratio: float = 0.0, index: float = 0.0, power: float = 0.0, cauchy: bool = False,
) -> float:  # fmt: skip
    """Settlement over the height of a layer that drains at its top, with large strains and variable permeability.

    Formula: dJ/dt = d/dA(K/(gamma_w J) dp/dA), p = P + M ln(J)/J, p = 0 at the top, no flow at the base
    Units: time_factor T = c t/H^2 [-], c = K_0 M/gamma_w; load P/M [-]; void_ratio, index, power as permeability_ratio; cauchy; result [-]
    Range: T > 0, P > 0
    Assumes: one dimension, a load applied instantaneously, Hencky's law: of Kirchhoff's stress, or with cauchy p = P + M ln J
    Source: Gibson, England and Hussey 1967, by differences in space and time (steps proportional to their number)
    Check: closed form of Xie and Leo 2004 for power 2 and cauchy; layer_settlement for small loads
    """
    positive(time_factor=time_factor, load=load)
    measure = 0 if cauchy else 1

    def stress_of(x: float) -> tuple[float, float]:
        """Stress over M at a logarithm of the stretch, and its derivative."""
        return x * math.exp(-measure * x), (1 - measure * x) * math.exp(-measure * x)

    def conductance_of(x: float) -> float:
        return permeability_ratio(math.exp(x), void_ratio, index, power) / math.exp(x)

    top = 0.0
    for _ in range(60):
        p, dp = stress_of(top)
        top -= (p + load) / dp
    log_j = [0.0] * THICK_CELLS
    for step in range(1, THICK_STEPS + 1):
        dt = time_factor * 2 * step / (THICK_STEPS * (THICK_STEPS + 1))
        log_j = _thick_step(log_j, dt, load, conductance_of(top), stress_of, conductance_of)
    return 1 - sum(math.exp(x) for x in log_j) / THICK_CELLS


def _thick_step(
    log_j: list[float], dt: float, load: float, k_top: float, stress_of: Callable[[float], tuple[float, float]],
    conductance_of: Callable[[float], float],
) -> list[float]:  # fmt: skip
    """Logarithms of the stretch after a step, by Newton's method; the flow between two cells uses the mean of their conductances."""
    h, small = 1.0 / len(log_j), 1e-6
    old = [math.exp(x) for x in log_j]
    for _ in range(30):
        j = [math.exp(x) for x in log_j]
        p, dp = zip(*(stress_of(x) for x in log_j), strict=True)
        k = [conductance_of(x) for x in log_j]
        dk = [(conductance_of(x + small) - c) / small for x, c in zip(log_j, k, strict=True)]
        rest = [(new - was) * h / dt for new, was in zip(j, old, strict=True)]
        main = [new * h / dt for new in j]
        lower, upper = [0.0] * len(j), [0.0] * len(j)
        rest[0] += k_top * (load + p[0]) / (h / 2)
        main[0] += k_top * dp[0] / (h / 2)
        for i in range(len(j) - 1):
            # What flows down from a cell into the next one.
            c, drop = (k[i] + k[i + 1]) / 2, (p[i] - p[i + 1]) / h
            by_upper, by_lower = dk[i] / 2 * drop + c * dp[i] / h, dk[i + 1] / 2 * drop - c * dp[i + 1] / h
            rest[i] += c * drop
            rest[i + 1] -= c * drop
            main[i] += by_upper
            upper[i] += by_lower
            lower[i + 1] -= by_upper
            main[i + 1] -= by_lower
        change = _tridiagonal(lower, main, upper, [-r for r in rest])
        log_j = [x + d for x, d in zip(log_j, change, strict=True)]
        if max(map(abs, change)) < 1e-12:
            break
    return log_j


def emptying_column(time: float, porosity: float, modulus: float, loss: float = 0.0, outflow: bool = False) -> float:
    """Settlement, or outflow, over the height of saturated ground whose base is opened to the air, so that its phreatic surface falls.

    Formula: n dS/dt + S de/dt = d/dy(k_r (dp/dy + 1)), M e = S p - w, S = 1 for p >= 0, S falls to 0 over a cell, k_r = S
    Units: time k t/H [-]; drainable porosity n; modulus M/(gamma_w H) [-]; weight lost on drainage over gamma_w [-]; outflow
    Range: all > 0, loss from 0 on
    Assumes: one dimension, small strains, no suction beyond a cell; w is the weight lost above
    Source: Biot 1941 with Bishop's stress, by differences in space and time, upwind
    Check: columns of stiff ground (outflow k t, then n H) and the settlement at the end, (1 - loss)/(2 M)
    """
    positive(time=time, porosity=porosity, modulus=modulus)
    within("loss", loss, 0.0)
    h, dt = 1.0 / COLUMN_CELLS, time / COLUMN_STEPS
    p = [1.0 - (i + 0.5) * h for i in range(COLUMN_CELLS)]
    full, lost, gone = [1.0] * COLUMN_CELLS, [0.0] * COLUMN_CELLS, 0.0
    grown = [0.0] * COLUMN_CELLS
    start = list(p)
    for _ in range(COLUMN_STEPS):
        p = _column_step(p, full, grown, [b + c for b, c in zip(start, lost, strict=True)], dt, porosity, modulus)
        full = [max(0.0, min(1.0, 1 + x / h)) for x in p]
        grown = [(s * x - b - c) / modulus for s, x, b, c in zip(full, p, start, lost, strict=True)]
        gone += dt * full[0] * (p[0] / (h / 2) + 1)
        above = 0.0
        for i in range(COLUMN_CELLS - 1, -1, -1):
            lost[i] = -(above + loss * (1 - full[i]) * h / 2)
            above += loss * (1 - full[i]) * h
    if outflow:
        return gone
    return -sum((s * x - b - c) / modulus for s, x, b, c in zip(full, p, start, lost, strict=True)) * h


def _column_step(
    p: list[float], full: list[float], grown: list[float], base: list[float], dt: float, porosity: float, modulus: float,
) -> list[float]:  # fmt: skip
    """Pressures after a step, by Newton's method; an iteration of a cell is limited where it begins to fill, or is full."""
    n, h = len(p), 1.0 / len(p)
    for _ in range(60):
        s = [max(0.0, min(1.0, 1 + x / h)) for x in p]
        ds = [1 / h if -h < x < 0 else 0.0 for x in p]
        e = [(a * x - b) / modulus for a, x, b in zip(s, p, base, strict=True)]
        rest = [h * (porosity * (s[i] - full[i]) + s[i] * (e[i] - grown[i])) for i in range(n)]
        main = [h * (porosity * ds[i] + ds[i] * (e[i] - grown[i]) + s[i] * (s[i] + ds[i] * p[i]) / modulus) for i in range(n)]
        lower, upper = [0.0] * n, [0.0] * n
        for i in range(n):
            # What flows down out of a cell.
            drop = (p[0] / (h / 2) if i == 0 else (p[i] - p[i - 1]) / h) + 1
            by_own, by_below = dt * (ds[i] * drop + s[i] / (h / 2 if i == 0 else h)), -dt * s[i] / h
            rest[i] += dt * s[i] * drop
            main[i] += by_own + 1e-14
            if i > 0:
                rest[i - 1] -= dt * s[i] * drop
                lower[i] += by_below
                main[i - 1] -= by_below
                upper[i - 1] -= by_own
        change = _tridiagonal(lower, main, upper, [-r for r in rest])
        before = p
        p = [x + d for x, d in zip(p, change, strict=True)]
        for i, x in enumerate(before):
            if x > 0:
                p[i] = max(p[i], -1e-3 * h)
            elif x > -h:
                p[i] = max(min(p[i], 1e-3 * h), -1.001 * h)
        if max(map(abs, change)) < 1e-9:
            break
    return p


def _tridiagonal(lower: list[float], main: list[float], upper: list[float], right: list[float]) -> list[float]:
    """Solve a tridiagonal system."""
    main, right = list(main), list(right)
    for i in range(1, len(main)):
        factor = lower[i] / main[i - 1]
        main[i] -= factor * upper[i - 1]
        right[i] -= factor * right[i - 1]
    for i in range(len(main) - 1, -1, -1):
        right[i] = (right[i] - (upper[i] * right[i + 1] if i + 1 < len(main) else 0.0)) / main[i]
    return right


def _bessel(order: int, z: complex) -> complex:
    """I_0 or I_1 by series."""
    term: complex = 1.0 if order == 0 else z / 2
    total = term
    for k in range(1, 400):
        term *= (z / 2) ** 2 / (k * (k + order))
        total += term
        if abs(term) < 1e-17 * abs(total):
            break
    return total


def cylinder_pressure(time_factor: float, poisson: float, radius: float = 0.0) -> float:
    """Excess pore pressure in a cylinder under external pressure that drains at its surface, over the load.

    Formula: Laplace transform of p/P: (I_0(l) - I_0(l r))/(s (I_0(l) - 2 G/M I_1(l)/l)), l = sqrt(s)
    Units: time_factor T = c t/R^2 [-], poisson [-], radius r over R [-]; result [-]
    Range: T from 0.002 on, r from 0 to 1
    Assumes: plane strain, axisymmetry, a pressure applied instantaneously and held constant, small strains
    Source: de Leeuw 1965; inverted on Talbot's contour as Abate and Valko 2004
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

    return _inverted(transform, time_factor)


def ball_pressure(time_factor: float, poisson: float, radius: float = 0.0) -> float:
    """Excess pore pressure in a sphere under external pressure that drains at its surface, over the load.

    Formula: Laplace transform of p/P: (sinh l - sinh(l r)/r)/(s (sinh l - 4 G/M (l cosh l - sinh l)/l^2)), l = sqrt(s)
    Units: time_factor T = c t/R^2 [-], poisson [-], radius r over R [-]; result [-]
    Range: T from 0.002 on, r from 0 to 1
    Assumes: a pressure applied instantaneously and held constant, small strains
    Source: Cryer 1963; inverted on Talbot's contour as Abate and Valko 2004
    Check: finite differences in radius and time, with the total stress that keeps the sphere in equilibrium
    """
    within("time_factor", time_factor, 0.002)
    within("radius", radius, 0.0, 1.0)
    poisson_ratio(poisson)
    shear = 2 * (1 - 2 * poisson) / (1 - poisson)  # 4 G/M

    def transform(s: complex) -> complex:
        l = cmath.sqrt(s)
        here = cmath.sinh(l * radius) / radius if radius > 0 else l
        return (cmath.sinh(l) - here) / (s * (cmath.sinh(l) - shear * (l * cmath.cosh(l) - cmath.sinh(l)) / s))

    return _inverted(transform, time_factor)


def _inverted(transform: Callable[[complex], complex], time_factor: float) -> float:
    """The function of time from its Laplace transform."""
    least = 2 * TALBOT / 5
    total = 0.5 * math.exp(least) * transform(complex(least / time_factor))
    for k in range(1, TALBOT):
        angle = k * math.pi / TALBOT
        cot = 1 / math.tan(angle)
        place = 2 * k * math.pi / 5 * complex(cot, 1)
        weight = complex(1, angle * (1 + cot**2) - cot)
        total += (weight * cmath.exp(place) * transform(place / time_factor)).real
    return float((0.4 / time_factor * total).real)
