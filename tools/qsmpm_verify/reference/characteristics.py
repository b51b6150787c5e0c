"""Stress field of Mohr-Coulomb soil with weight beside a strip footing or a wall: method of characteristics.

The soil at rest beside the footing or the wall (x > 0, z down) is in the passive state. Its boundary, a straight
slip line from the edge, is the start of the integration: a fan at the edge, then slip lines that leave
the base of the footing, z = 0, or the wall, x = 0. The unknowns at every node are position, mean stress s and angle t of the major
stress from the vertical. With e = 45 - phi/2, R = c cos phi + s sin phi and the unit weight g

    along dx/dz = tan(t + e):  ds + 2 R / cos phi dt = g (dz - tan phi dx)
    along dx/dz = tan(t - e):  ds - 2 R / cos phi dt = g (dz + tan phi dx)

both with means of the two ends (second order). Without friction the cohesion may grow with depth, c = c_0 + k z: -k dx
on the right of the first, +k dx of the second (Davis & Booker 1973). Source: Sokolovskii 1965; own discretisation.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
X, Z, MEAN, ANGLE = range(4)
SECTORS = 24
"""Sectors of the fan of the coarse integration; the fine one has twice as many."""
ROUNDS = 60
"""Limit of the fixed-point iterations of a node; each gains at least one digit."""


@dataclass(frozen=True)
class Soil:
    """Strength and loads: friction [radian], cohesion [stress], surcharge [stress], weight [force/volume], gain k of
    cohesion with depth [stress/length], 0 with friction."""

    friction: float
    cohesion: float
    surcharge: float
    weight: float
    gain: float = 0.0

    @property
    def spread(self) -> float:
        """Angle between the major stress and the slip lines."""
        return math.pi / 4 - self.friction / 2

    def radius(self, mean: Any, depth: Any) -> Any:
        """Radius of Mohr's circle at a mean stress and a depth."""
        cohesion = self.cohesion + self.gain * depth
        return cohesion * math.cos(self.friction) + mean * math.sin(self.friction)

    def vertical(self, nodes: Array) -> Array:
        """Vertical stress of nodes."""
        return np.asarray(nodes[MEAN] + self.radius(nodes[MEAN], nodes[Z]) * np.cos(2 * nodes[ANGLE]))

    def horizontal(self, nodes: Array) -> Array:
        """Horizontal stress of nodes."""
        return np.asarray(nodes[MEAN] - self.radius(nodes[MEAN], nodes[Z]) * np.cos(2 * nodes[ANGLE]))

    def shear(self, nodes: Array) -> Array:
        """Shear stress of nodes on horizontal planes."""
        return np.asarray(self.radius(nodes[MEAN], nodes[Z]) * np.sin(2 * nodes[ANGLE]))


@dataclass(frozen=True)
class Field:
    """Nodes of the integration: `fronts[d, :, j]` is node d - j of slip line j, `base[:, j]` its end on the footing or the wall."""

    soil: Soil
    fan: int
    fronts: Array
    base: Array

    def line_from_base(self, start: int) -> Array:
        """Nodes of the slip line that leaves the base at its node `start`."""
        j = np.arange(start, self.base.shape[1])
        return self.fronts[self.fan + start + j, :, j].T


def _node(soil: Soil, a: Array, b: Array) -> Array:
    """Nodes where the slip lines from a (t + e) and from b (t - e) intersect."""
    cosine, sine, slope, spread = math.cos(soil.friction), math.sin(soil.friction), math.tan(soil.friction), soil.spread
    angle, mean, z = (a[ANGLE] + b[ANGLE]) / 2, (a[MEAN] + b[MEAN]) / 2, (a[Z] + b[Z]) / 2
    # Mohr's radius at the mean of two ends, twice over cos phi: what the ends of the known nodes give of it
    weight_x, weight_z = soil.weight * slope + soil.gain, soil.weight
    known_a, known_b = (2 * soil.radius(end[MEAN] / 2, end[Z] / 2) / cosine for end in (a, b))
    start_a, start_b = (end[MEAN] - weight_z * end[Z] + sign * weight_x * end[X] for end, sign in ((a, 1), (b, -1)))
    for _ in range(ROUNDS):
        first, second = (angle + a[ANGLE]) / 2 + spread, (angle + b[ANGLE]) / 2 - spread
        sine_a, cosine_a, sine_b, cosine_b = np.sin(first), np.cos(first), np.sin(second), np.cos(second)
        along_a, along_b = a[X] * cosine_a - a[Z] * sine_a, b[X] * cosine_b - b[Z] * sine_b
        across = sine_a * cosine_b - cosine_a * sine_b
        x, z = (along_b * sine_a - along_a * sine_b) / across, (along_b * cosine_a - along_a * cosine_b) / across
        own = soil.gain * z + mean * (sine / cosine)
        factor_a, factor_b, height = known_a + own, known_b + own, weight_z * z
        right_a = start_a + factor_a * a[ANGLE] + height - weight_x * x
        right_b = start_b - factor_b * b[ANGLE] + height + weight_x * x
        new = (right_a - right_b) / (factor_a + factor_b)
        change = float(np.abs(new - angle).max())
        angle, mean = new, right_a - factor_a * new
        if change < 1e-12:
            break
    return np.array([x, z, mean, angle])


def _base_node(soil: Soil, a: Array, end: float, wall: bool) -> Array:
    """Node where the slip line from a reaches the base or the wall, major stress at the angle `end`."""
    along = math.tan((end + a[ANGLE]) / 2 + soil.spread)
    x, z = (0.0, a[Z] - a[X] / along) if wall else (a[X] - along * a[Z], 0.0)
    pull = soil.weight * (z - a[Z] - math.tan(soil.friction) * (x - a[X])) - soil.gain * (x - a[X])
    turn = (a[ANGLE] - end) / math.cos(soil.friction)
    # s - s_a = turn (R(s) + R(s_a)) + pull, linear in s
    middle = soil.radius(a[MEAN] / 2, (z + a[Z]) / 2)
    mean = (a[MEAN] + turn * 2 * middle + pull) / (1 - turn * math.sin(soil.friction))
    return np.array([x, z, mean, end])


def _edge(soil: Soil, fan: Array) -> Array:
    """Mean stress at the edge of the footing over the angles of the fan."""
    passive = (soil.surcharge + soil.cohesion * math.cos(soil.friction)) / (1 - math.sin(soil.friction))
    if soil.friction == 0:
        return np.asarray(passive + soil.cohesion * (math.pi - 2 * fan))
    pole = soil.cohesion / math.tan(soil.friction)
    return np.asarray((passive + pole) * np.exp((math.pi - 2 * fan) * math.tan(soil.friction)) - pole)


def march(soil: Soil, places: Array, fan: int, end: float, wall: bool = False) -> Field:
    """The field from nodes at distances `places` along the passive boundary and `fan` sectors to the angle `end` of the
    major stress at the base, or at the wall."""
    count, angles = len(places), np.linspace(math.pi / 2, end, fan + 1)
    far = np.concatenate([[0.0], places])
    front = np.zeros((4, count + 1))
    front[X], front[Z] = far * math.cos(soil.spread), far * math.sin(soil.spread)
    front[MEAN] = soil.surcharge + soil.cohesion * math.cos(soil.friction)
    front[MEAN] += (soil.weight + soil.gain) * front[Z]
    front[MEAN] /= 1 - math.sin(soil.friction)
    front[ANGLE] = math.pi / 2
    edge = _edge(soil, angles)
    fronts, base = [front], np.zeros((4, count + 1))
    base[:, 0] = 0.0, 0.0, edge[-1], end
    for d in range(1, fan + 2 * count + 1):
        low, high = max(1, (d - fan) // 2 + 1), min(count, d - 1)
        front = front.copy()
        before = fronts[-1]
        if low <= high:
            front[:, low : high + 1] = _node(soil, before[:, low : high + 1], before[:, low - 1 : high])
        if d <= fan:
            front[:, 0] = 0.0, 0.0, edge[d], angles[d]
        elif (d - fan) % 2 == 0:
            j = (d - fan) // 2
            front[:, j] = base[:, j] = _base_node(soil, before[:, j], end, wall)
        fronts.append(front)
    return Field(soil, fan, np.array(fronts), base)


def _refined(ratio: float, span: float, fan: int) -> Array:
    """Distances that increase by a constant factor from 0.01 to 0.01 * span."""
    return np.asarray(0.01 * ratio ** np.arange(round(fan * math.log(span) / (SECTORS * math.log(1.2)) + 1)))


def far_field(friction: float, fan: int, end: float, wall: bool = False) -> Field:
    """Integration for cohesionless soil, friction [radian], weight 1, far enough for the surcharge 1 to be negligible."""
    return march(Soil(friction, 0.0, 1.0, 1.0), _refined(1.2 ** (SECTORS / fan), 1e10, fan), fan, end, wall)


def extrapolated(coarse: float, fine: float) -> float:
    """Second-order extrapolation from two integrations, the finer with half the spacing."""
    return fine + (fine - coarse) / 3
