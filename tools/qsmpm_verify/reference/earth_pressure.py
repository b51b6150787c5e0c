"""Earth pressure on smooth and rough walls."""

from __future__ import annotations

import math

from qsmpm_verify.reference.arguments import between, friction_angle, not_negative, within
from qsmpm_verify.reference.characteristics import SECTORS, Z, extrapolated, far_field


def _rankine(friction: float, sign: int) -> float:
    """Coefficient of the passive (1) or active (-1) pressure."""
    return math.tan(math.pi / 4 + sign * friction_angle("friction", friction) / 2) ** 2


def rankine_passive(depth: float, unit_weight: float, cohesion: float, friction: float, surcharge: float = 0.0) -> float:
    """Passive pressure on a smooth vertical wall.

    Formula: K (gamma z + q) + 2 c sqrt(K), K = tan(45 + phi/2)^2
    Units: depth [length], unit_weight [force/volume], cohesion, surcharge [stress], friction [degree]; result [stress]
    Range: depth >= 0, 0 <= phi < 90
    Assumes: plane strain, level ground, smooth wall
    Source: Rankine 1857
    Check: rankine_active of the resulting vertical stress is the horizontal one
    """
    not_negative(depth=depth, unit_weight=unit_weight, cohesion=cohesion, surcharge=surcharge)
    ratio = _rankine(friction, 1)
    return ratio * (unit_weight * depth + surcharge) + 2 * cohesion * math.sqrt(ratio)


def rankine_active(depth: float, unit_weight: float, cohesion: float, friction: float, surcharge: float = 0.0) -> float:
    """Active pressure on a smooth vertical wall; 0 where the soil is self-supporting.

    Formula: max(0, K (gamma z + q) - 2 c sqrt(K)), K = tan(45 - phi/2)^2
    Units: depth [length], unit_weight [force/volume], cohesion, surcharge [stress], friction [degree]; result [stress]
    Range: depth >= 0, 0 <= phi < 90
    Assumes: plane strain, level ground, smooth wall, no tension between wall and soil
    Source: Rankine 1857
    Check: rankine_passive of the result is the vertical stress
    """
    not_negative(depth=depth, unit_weight=unit_weight, cohesion=cohesion, surcharge=surcharge)
    ratio = _rankine(friction, -1)
    return max(0.0, ratio * (unit_weight * depth + surcharge) - 2 * cohesion * math.sqrt(ratio))


def passive_wall(friction: float, wall: float) -> float:
    """Passive earth pressure of sand on a rough vertical wall, by slip lines.

    Formula: gradient of the pressure with depth, far from the surface; method of characteristics; inclination of the major stress
        (D + asin(sin D/sin phi))/2 at the wall
    Units: friction of the sand phi and of the wall D [degree]; result [-] = force, inclined by D to the normal / (gamma H^2/2)
    Range: 5 <= phi <= 45, 0 <= D < phi
    Assumes: plane strain, associated flow, no cohesion, level ground, sand slides upwards along the wall, surcharge -> 0
    Source: Sokolovskii 1965; own integration
    Check: similarity solution of the same equations, from the wall to the passive zone; Rankine's pressure, Lancellotta's (2002) and Coulomb's bounds
    """
    within("friction", friction, 5.0, 45.0)
    within("wall", wall, 0.0)
    between("wall", wall, -1.0, friction)
    return extrapolated(_growth(friction, wall, SECTORS), _growth(friction, wall, 2 * SECTORS)) / math.cos(math.radians(wall))


def _growth(friction: float, wall: float, fan: int) -> float:
    """Gradient of the normal pressure on the wall with depth."""
    phi, slope = math.radians(friction), math.radians(wall)
    dip = (slope + math.asin(math.sin(slope) / math.sin(phi))) / 2
    field = far_field(phi, fan, math.pi / 2 - dip, wall=True)
    pressure = field.soil.horizontal(field.base)
    return float((pressure[-1] - pressure[-2]) / (field.base[Z, -1] - field.base[Z, -2]))
