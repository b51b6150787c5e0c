"""Soil with suction: infiltration of light rain above the water level, drainage of a column.

S = (1 + u^n)^-m, k_r = S^(1/2) (1 - u^(n-1) S)^2, u = alpha s, m = 1 - 1/n, s the suction as a height (van Genuchten
1980 after Mualem 1976).
"""

from __future__ import annotations

import functools
import math

from qsmpm_verify.reference.arguments import positive, within
from qsmpm_verify.reference.consolidation import _tridiagonal

PLACES = 4000
"""Steps of the integral over the height."""
CELLS, STEPS = 60, 200
"""Differences in space and time."""


def held_water(suction: float, alpha: float, n: float) -> float:
    """Degree of saturation.

    Formula: S = (1 + (alpha s)^n)^(1/n - 1)
    Units: suction s as a height; alpha 1 over a height; n [-]; result [-]
    Range: alpha > 0, n > 1; s < 0 is treated as zero
    Assumes: no residual water
    Source: van Genuchten 1980, equation 3
    Check: values by hand
    """
    positive(alpha=alpha)
    within("n", n, 1.0)
    return float((1 + (alpha * max(0.0, suction)) ** n) ** (1 / n - 1))


def let_water(suction: float, alpha: float, n: float) -> float:
    """Permeability over that of saturated ground.

    Formula: k_r = S^(1/2) (1 - (1 - S^(1/m))^m)^2
    Units: as held_water; result [-]
    Range: as held_water
    Assumes: as held_water
    Source: van Genuchten 1980, equation 8, after Mualem 1976
    Check: values by hand
    """
    share, m = held_water(suction, alpha, n), 1 - 1 / n
    return math.sqrt(share) * (1 - (1 - share ** (1 / m)) ** m) ** 2


def rain_suction(height: float, rain: float, alpha: float, n: float) -> float:
    """Suction at a height above the water level with steady infiltration.

    Formula: ds/dz = 1 - q/(k k_r(s)), s = 0 at the water level
    Units: height z; rain q/k [-]; alpha 1 over a height; n [-]; result a height
    Range: z > 0, q/k from 0 to 1
    Assumes: steady flow along the vertical
    Source: Gardner 1958, by Runge and Kutta's method
    Check: no rain, and the suction at which k_r = q/k far above the water level
    """
    positive(height=height)
    within("rain", rain, 0.0, 1.0)

    def slope(s: float) -> float:
        return 1 - rain / max(let_water(s, alpha, n), 1e-12)

    s, h = 0.0, height / PLACES
    for _ in range(PLACES):
        a = slope(s)
        b = slope(s + h / 2 * a)
        c = slope(s + h / 2 * b)
        s += h / 6 * (a + 2 * b + 2 * c + slope(s + h * c))
    return s


def draining_column(
    time: float, porosity: float, alpha: float, n: float, modulus: float = 1e12, loss: float = 0.0, settlement: bool = False,
) -> float:  # fmt: skip
    """Outflow per unit time over k, or settlement over the height, of a column with initial steady flow whose top is closed.

    Formula: n dS/dt + S de/dt = d/dz(k_r (dp/dz + 1)), M e = S p - w, p = 0 at the start and at the base, no flow at the top
    Units: time k t/H [-]; drainable porosity n; alpha H [-]; n [-]; modulus M/(gamma_w H) [-]; weight lost on drainage; settlement
    Range: all > 0, loss from 0 on
    Assumes: one dimension, small strains; w is the weight lost above
    Source: Liakopoulos 1965 as in Lewis and Schrefler 1998, with van Genuchten's curves, by differences in space and time
    Check: k at the start, the drained water at the end, its settlement
    """
    positive(time=time, porosity=porosity, modulus=modulus)
    within("loss", loss, 0.0)
    return _drained(time, porosity, alpha, n, modulus, loss)[settlement]


@functools.cache
def _drained(time: float, porosity: float, alpha: float, n: float, modulus: float, loss: float) -> tuple[float, float]:
    """Outflow and settlement: first-order steps, extrapolated from steps twice as long."""
    long, short = (_drained_in(steps, time, porosity, alpha, n, modulus, loss) for steps in (STEPS // 2, STEPS))
    return 2 * short[0] - long[0], 2 * short[1] - long[1]


def _drained_in(
    steps: int, time: float, porosity: float, alpha: float, n: float, modulus: float, loss: float
) -> tuple[float, float]:  # fmt: skip
    """The same for a number of steps."""
    h = 1.0 / CELLS
    p, lost, flow = [0.0] * CELLS, [0.0] * CELLS, 1.0
    for step in range(1, steps + 1):
        dt = time * 2 * step / (steps * (steps + 1))
        p, flow = _drain(p, lost, dt, (porosity, alpha, n, modulus))
        above = 0.0
        for i in range(CELLS - 1, -1, -1):
            gone = loss * (1 - held_water(-p[i], alpha, n)) * h
            lost[i] = -(above + gone / 2)
            above += gone
    return flow, -sum((held_water(-x, alpha, n) * x - c) / modulus for x, c in zip(p, lost, strict=True)) * h


def _drain(p: list[float], lost: list[float], dt: float, soil: tuple[float, float, float, float]) -> tuple[list[float], float]:
    """Pressures after a step, by Newton's method with numerical derivatives, and the outflow at the base."""
    porosity, alpha, n, modulus = soil
    h, small, top = 1.0 / len(p), 1e-7, len(p) - 1

    def water(x: float, i: int) -> float:
        """Water stored by a cell in the step; its weight lags."""
        s, was = held_water(-x, alpha, n), held_water(-p[i], alpha, n)
        return h / dt * (porosity * (s - was) + s * (s * x - was * p[i]) / modulus)

    def falls(upper: float, lower: float, way: float) -> float:
        """Flow downwards between two points."""
        return 0.5 * (let_water(-upper, alpha, n) + let_water(-lower, alpha, n)) * ((upper - lower) / way + 1)

    new = list(p)
    for _ in range(40):
        rest, main = [water(x, i) for i, x in enumerate(new)], [0.0] * len(p)
        lower, upper = [0.0] * len(p), [0.0] * len(p)
        for i, x in enumerate(new):
            main[i] += (water(x - small, i) - rest[i]) / -small
        for i in range(top + 1):
            below, way = (new[i - 1], h) if i else (0.0, h / 2)
            flow = falls(new[i], below, way)
            own = (falls(new[i] - small, below, way) - flow) / -small
            rest[i] += flow
            main[i] += own
            if i:
                other = (falls(new[i], below - small, way) - flow) / -small
                rest[i - 1] -= flow
                lower[i] += other
                main[i - 1] -= other
                upper[i - 1] -= own
        change = _tridiagonal(lower, main, upper, [-r for r in rest])
        new = [x + max(-0.2, min(0.2, d)) for x, d in zip(new, change, strict=True)]
        if max(map(abs, change)) < 1e-10:
            break
    return new, falls(new[0], 0.0, h / 2)
