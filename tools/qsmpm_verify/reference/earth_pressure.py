"""Earth pressure of sand on rough walls."""

from __future__ import annotations

import math

from qsmpm_verify.reference.arguments import between, within

STEPS = 1200
"""Steps of the march from the wall to the surface."""


def passive_wall(friction_angle: float, wall_angle: float) -> float:
    """Passive earth pressure of sand on a rough upright wall, by slip lines.

    Formula: p = gamma r chi(t), major stress at a(t) below the horizontal, t below the surface; chi' and a' by equilibrium,
        2 a = D + asin(sin D/sin phi) at the wall, a = 0 where Rankine's zone begins, t = 45 - phi/2
    Units: angles of friction of the sand and of the wall D [degrees]; result [-] = push, D off the normal / (gamma H^2/2)
    Range: 0 < phi < 60, 0 <= D < phi
    Assumes: plane strain, no cohesion, level ground, phi = psi, wall that the sand slides up along
    Source: Sokolovskii 1965, Statics of Granular Media
    Check: Rankine's pressure as the wall gets smooth; Lancellotta's (2002) bound from below, Coulomb's wedge from above; steps doubled
    """
    within("wall_angle", wall_angle, 0.0)
    between("friction_angle", friction_angle, max(0.0, wall_angle), 60.0)
    sine, slope = math.sin(math.radians(friction_angle)), math.radians(wall_angle)
    if wall_angle == 0:
        return (1 + sine) / (1 - sine)
    dip = (slope + math.asin(math.sin(slope) / sine)) / 2
    normal = 1 + sine * math.cos(2 * dip)
    low, high = 1.0, 200.0
    while high - low > 1e-9 * high:
        middle = (low + high) / 2
        low, high = (low, middle) if _levels_early(sine, dip, middle / normal) else (middle, high)
    return low / math.cos(slope)


def _levels_early(sine: float, dip: float, chi: float) -> bool:
    """Whether the major stress of a march from the wall is level before Rankine's zone is reached: chi is too large."""
    start, end = math.pi / 2, math.pi / 4 - math.asin(sine) / 2
    step = (end - start) / STEPS
    place, state = start, (chi, dip)
    for _ in range(STEPS):
        if state[1] <= 0:
            return True
        # A ray that is a slip line ends the march: chi is too small.
        if _slip(sine, place, state[1]) <= 0 or _slip(sine, place + step / 2, state[1]) <= 0:
            return False
        first = _rate(sine, place, state)
        second = _rate(sine, place + step / 2, _moved(state, first, step / 2))
        state, place = _moved(state, second, step), place + step
    return False


def _slip(sine: float, place: float, dip: float) -> float:
    """Above zero between the slip lines, zero where a ray is one."""
    s, c = sine * math.sin(2 * (dip - place)), sine * math.cos(2 * (dip - place))
    return s * s - c * (1 - c)


def _moved(state: tuple[float, float], rate: tuple[float, float], step: float) -> tuple[float, float]:
    return state[0] + step * rate[0], state[1] + step * rate[1]


def _rate(sine: float, place: float, state: tuple[float, float]) -> tuple[float, float]:
    """chi' and a' from equilibrium along and across the ray."""
    chi, dip = state
    s, c = sine * math.sin(2 * (dip - place)), sine * math.cos(2 * (dip - place))
    along, across = math.sin(place) - chi * (1 + 3 * c), math.cos(place) - 3 * chi * s
    # | s      2 chi c | |chi'    |   |along |
    # | 1 - c  2 chi s | |(a - t)'| = |across|
    slip = s * s - c * (1 - c)
    return (s * along - c * across) / slip, (s * across - (1 - c) * along) / (2 * chi * slip) + 1
