"""Cohesion and friction of a material at a factor of safety; Davis' reduction for soil with dilatancy less than friction."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from qsmpm_verify.results import Array


@dataclass(frozen=True)
class Strength:
    """c, angles in degrees, a tension cut-off; levels and cohesions where c varies along an axis; whether it
    can yield."""

    cohesion: float
    friction: float
    dilatancy: float
    tension: float | None = None
    profile: Array | None = None
    axis: int = 1
    fails: bool = True

    def reduced(self) -> bool:
        """Whether its flow is not associated, so that Davis' strength replaces it."""
        return self.dilatancy < self.friction

    def cohesions(self, places: Array) -> Array:
        """c at points (..., 2): linear between levels, constant outside them."""
        if self.profile is None:
            return np.full(places.shape[:-1], self.cohesion)
        return np.interp(places[..., self.axis], self.profile[:, 0], self.profile[:, 1])

    def levels(self) -> Array:
        """Levels of the corners of the profile."""
        return np.empty(0) if self.profile is None else self.profile[:, 0]

    def at(self, factor: float, flow: str) -> tuple[float, float]:
        """Factor on c, and phi in radians, at a factor of safety and after Davis."""
        phi, psi = math.radians(self.friction), math.radians(self.dilatancy)
        lowered = math.atan(math.tan(phi) / factor)
        if flow == "DAVIS A":
            share = davis(phi, psi)
        else:
            share = davis(lowered, min(psi, lowered))
        return share / factor, math.atan(share * math.tan(phi) / factor)


def davis(phi: float, psi: float) -> float:
    """Davis (1968): strength on a slip line of soil with phi and psi divided by that of associated soil."""
    return math.cos(psi) * math.cos(phi) / (1.0 - math.sin(psi) * math.sin(phi))


FAR = 1e6


def profile_of(kind: str, rows: list[list[float]], least: float) -> Array:
    """Levels in ascending order and cohesions. LINEAR: a line that does not fall below the least value."""
    if kind == "TABLE":
        table = np.array([row[:2] for row in rows])
        return table[np.argsort(table[:, 0])]
    level, strength, gain = rows[0]
    if gain == 0.0:
        return np.array([[level, max(strength, least)]])
    kink = level - (least - strength) / gain
    ends = sorted([(kink, least), (kink - math.copysign(FAR, gain), least + FAR * abs(gain))])
    return np.array(ends)
