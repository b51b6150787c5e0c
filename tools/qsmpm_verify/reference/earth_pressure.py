"""Earth pressure of sand on rough walls."""

from __future__ import annotations

import math

from qsmpm_verify.reference.arguments import between, within
from qsmpm_verify.reference.characteristics import SECTORS, Z, extrapolated, far_field


def passive_wall(friction: float, wall: float) -> float:
    """Passive earth pressure of sand on a rough upright wall, by slip lines.

    Formula: growth of the pressure with the depth, far from the surface; method of characteristics; the major stress dips by
        (D + asin(sin D/sin phi))/2 at the wall
    Units: friction of the sand phi and of the wall D [degree]; result [-] = push, D off the normal / (gamma H^2/2)
    Range: 5 <= phi <= 45, 0 <= D < phi
    Assumes: plane strain, associated flow, no cohesion, level ground, wall that the sand slides up along, surcharge -> 0
    Source: Sokolovskii 1965; own march
    Check: similarity solution of the same equations, from the wall to the passive zone; Rankine's pressure, Lancellotta's (2002) and Coulomb's bounds
    """
    within("friction", friction, 5.0, 45.0)
    within("wall", wall, 0.0)
    between("wall", wall, -1.0, friction)
    return extrapolated(_growth(friction, wall, SECTORS), _growth(friction, wall, 2 * SECTORS)) / math.cos(math.radians(wall))


def _growth(friction: float, wall: float, fan: int) -> float:
    """Growth of the normal pressure on the wall with the depth."""
    phi, slope = math.radians(friction), math.radians(wall)
    dip = (slope + math.asin(math.sin(slope) / math.sin(phi))) / 2
    field = far_field(phi, fan, math.pi / 2 - dip, wall=True)
    pressure = field.soil.horizontal(field.base)
    return float((pressure[-1] - pressure[-2]) / (field.base[Z, -1] - field.base[Z, -2]))
