"""Upper bounds of slopes of any outline: rotation along a logarithmic spiral, with water, depth and a horizontal force.

Lengths, unit weights and strengths in consistent units, angles in degrees. The ground is a polyline from left to
right that descends to the right, so that the soil rotates counterclockwise about a pole above it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from qsmpm_verify.reference.arguments import not_negative, positive, within
from qsmpm_verify.reference.element_tests import davis_cohesion, davis_friction
from qsmpm_verify.reference.numerics import minimum

Array = np.ndarray
NEVER = 1e6
"""Ratio for an inadmissible mechanism."""
CHORDS = 160
"""Segments of a spiral."""
STARTS = 3
"""Points of the coarse search from which the simplex search starts."""


@dataclass(frozen=True)
class Scene:
    """Ground and water as lines, unit weights, the horizontal fraction of gravity and the strength."""

    ground: Array
    """Corners (2, n), x increasing."""
    water: Array
    """Water level in the ground and above it (2, n)."""
    water_weight: float
    moist: float
    saturated: float
    push: float
    cohesion: Callable[[Array], Array]
    """Gradient with height."""
    friction: float
    """tan phi"""
    floor: float
    """Height of the firm base, the lower limit of slip surfaces."""


def _height(line: Array, x: Array) -> Array:
    return np.interp(x, line[0], line[1])


def _slope(line: Array, x: Array) -> Array:
    """dy/dx of a line, 0 beyond its ends."""
    piece = np.clip(np.searchsorted(line[0], x) - 1, 0, line.shape[1] - 2)
    steep = np.diff(line[1]) / np.diff(line[0])
    return np.where((x < line[0, 0]) | (x > line[0, -1]), 0.0, steep[piece])


def _spiral(scene: Scene, pole: tuple[float, float], leaves: float, slope: float) -> tuple[Array, Array, Array] | None:
    """Angles and corners of the spiral that exits at x = leaves, from its entry; None if there is none."""
    x_out, y_out = leaves, float(_height(scene.ground, np.array([leaves]))[0])
    end = math.atan2(y_out - pole[1], x_out - pole[0])
    radius = math.hypot(x_out - pole[0], y_out - pole[1])
    if not -math.pi < end < 0:
        return None
    turn = np.linspace(end, -math.pi, 4 * CHORDS)
    far = radius * np.exp((turn - end) * slope)
    above = pole[1] + far * np.sin(turn) - _height(scene.ground, pole[0] + far * np.cos(turn))
    crossed = np.flatnonzero(above[1:] >= 0)
    if len(crossed) == 0 or crossed[0] < 8:
        return None
    last = crossed[0] + 1
    share = above[last - 1] / (above[last - 1] - above[last])
    start = turn[last - 1] + share * (turn[last] - turn[last - 1])
    turn = np.linspace(start, end, CHORDS + 1)
    # the corners of ground and water bound pieces too
    corners = np.concatenate([scene.ground[0], scene.water[0]])
    x = pole[0] + radius * np.exp((turn - end) * slope) * np.cos(turn)
    turn = np.union1d(turn, np.interp(corners[(corners > x[0]) & (corners < x[-1])], x, turn))
    far = radius * np.exp((turn - end) * slope)
    x, y = pole[0] + far * np.cos(turn), pole[1] + far * np.sin(turn)
    if np.any(np.diff(x) <= 0) or np.min(y) < scene.floor or pole[1] <= np.max(_height(scene.ground, x)):
        return None
    return turn, x, y


def _ratio(scene: Scene, pole: tuple[float, float], leaves: float, factor: float) -> float:
    """Work of the strength divided by a factor, over that of the loads; below 1 the slope is unstable."""
    slope = scene.friction / factor
    found = _spiral(scene, pole, leaves, slope)
    if found is None:
        return NEVER
    turn, x, y = found
    middle_x, middle_y = (x[1:] + x[:-1]) / 2, (y[1:] + y[:-1]) / 2
    width, angle = np.diff(x), np.diff(turn)
    arm, depth = middle_x - pole[0], pole[1] - middle_y
    square = arm**2 + depth**2
    top = _height(scene.ground, middle_x)
    spent = float(np.sum(scene.cohesion(middle_y) / factor * square * angle))
    level = _height(scene.water, middle_x)
    wet = np.clip(np.minimum(level, top) - middle_y, 0.0, top - middle_y)
    dry = top - middle_y - wet
    weight = scene.saturated * wet + scene.moist * dry
    # moments of the horizontal force about the pole: heights of the two parts
    sideways = scene.saturated * wet * (depth - wet / 2) + scene.moist * dry * (depth - wet - dry / 2)
    work = float(np.sum(width * (scene.push * sideways - weight * arm)))
    pressure = scene.water_weight * np.maximum(level - middle_y, 0.0)
    work += slope * float(np.sum(pressure * square * angle))
    free = scene.water_weight * np.maximum(level - top, 0.0)
    work += float(np.sum(width * free * (_slope(scene.ground, middle_x) * (pole[1] - top) - arm)))
    return spent / work if work > 1e-12 else NEVER


def _coarse(scene: Scene, factor: float) -> list[tuple[float, float, float]]:
    """The best of many mechanisms: pole and exit point of the slip surface."""
    low, high = float(np.min(scene.ground[1])), float(np.max(scene.ground[1]))
    size = high - low
    steep = np.flatnonzero(np.diff(scene.ground[1]) < 0)
    left, right = float(scene.ground[0, steep[0]]), float(scene.ground[0, steep[-1] + 1])
    places = [
        (float(x), high + lift * size, float(out))
        for x in np.linspace(max(scene.ground[0, 0], left - size), right + size, 13)
        for lift in (0.05, 0.2, 0.4, 0.7, 1.0, 1.5, 2.2, 3.0)
        for out in np.linspace(left + 0.3 * (right - left), min(scene.ground[0, -1], right + size), 9)
    ]
    values = [_ratio(scene, place[:2], place[2], factor) for place in places]
    if min(values) >= NEVER:
        raise ArithmeticError("no slip surface found")
    return [places[i] for i in np.argsort(values)[:STARTS]]


def _least(scene: Scene, starts: list[tuple[float, float, float]], factor: float) -> float:
    """Logarithm of the smallest ratio near some mechanisms."""
    size = float(np.ptp(scene.ground[1]))

    def at(place: Sequence[float]) -> float:
        return math.log(_ratio(scene, (float(place[0]), float(place[1])), float(place[2]), factor))

    return min(minimum(at, start, 1e-5 * size) for start in starts)


def _critical(scene: Scene, factor: float) -> float:
    """Factor at which the best mechanism near the best ones of a factor is critical: secant iterations on log(ratio)."""
    starts = _coarse(scene, factor)
    place, steep = math.log(factor), -1.0
    value = _least(scene, starts, factor)
    for _ in range(20):
        if abs(value) < 1e-6:
            return math.exp(place)
        step = min(max(-value / steep, -0.3), 0.3)
        place, before = place + step, value
        value = _least(scene, starts, math.exp(place))
        steep = min((value - before) / step, -0.3)
    raise ArithmeticError("no factor found")


def _factor(scene: Scene) -> float:
    """Factor by which the strength is divided until the best mechanism is critical."""
    factor = _critical(scene, 1.0)
    for _ in range(10):
        again = _critical(scene, factor)
        if not again < factor * (1 - 1e-5):
            return min(again, factor)
        factor = again
    raise ArithmeticError("no factor found")


def _line(*corners: tuple[float, float]) -> Array:
    return np.array(corners, dtype=float).T


def slope_water_safety(
    unit_weight: float,
    saturated: float,
    cohesion: float,
    friction: float,
    dilatancy: float,
    angle: float,
    height: float,
    inside: float,
    outside: float,
    water_weight: float,
    gain: float = 0.0,
    push: float = 0.0,
    below: float = 0.0,
) -> float:
    """Strength reduction factor of a slope with water, depth and a horizontal force, best logarithmic spiral: an upper bound.

    Formula: F such that the least of spent/work is 1, spent = int c/F r^2 da, work = int (k Y - X) dW + int u tan(phi)/F r^2 da + free water
    Units: lengths, weights, cohesion consistent; levels above the toe; increase of c [stress/length] from the crest downwards; angles [degree]; result [-]
    Range: 0 <= outside <= inside; where they differ the level follows the face downwards (drawdown); no surface deeper than `below` under the toe
    Assumes: rigid rotation about a pole above the crest; u = gamma_w (level - y); push k: horizontal fraction of gravity; psi < phi: Davis A
    Source: Chen 1975; pore water as Michalowski 1995, drawdown as Morgenstern 1963; own search
    Check: slope_spiral_safety; a submerged slope with gamma'; work of a mechanism by summation over small squares; Taylor's number
    """
    positive(unit_weight=unit_weight, saturated=saturated, height=height)
    not_negative(water_weight=water_weight, below=below, gain=gain, push=push)
    within("angle", angle, 1.0, 89.0)
    within("outside", outside, 0.0, inside)
    run, wide = height / math.tan(math.radians(angle)), 10 * height
    ground = _line((-run - wide, height), (-run, height), (0.0, 0.0), (wide, 0.0))
    face = [(-run * min(level, height) / height, min(level, height)) for level in (inside, outside)]
    water = _line((-run - wide, inside), *(face if inside > outside else []), (wide, outside))
    if inside > height and inside > outside:
        raise ValueError("water above the crest must be level")
    strength = davis_cohesion(cohesion, friction, dilatancy)
    growth = davis_cohesion(gain, friction, dilatancy)
    slope = math.tan(math.radians(davis_friction(friction, dilatancy)))
    return _factor(
        Scene(ground, water, water_weight, unit_weight, saturated, push, lambda y: strength + growth * (height - y), slope, -below)
    )


def dam_safety(drawn: bool) -> float:
    """Strength reduction factor of the dam of input/dam_drawdown.inp, Davis A, before or after drawdown: an upper bound.

    Formula: the smaller value of both faces, each as slope_water_safety
    Units: result [-]
    Range: this dam: 6 m, faces of 1:2, c = 12 kPa, phi = 28, psi = 0; water at 5 m, then at 1 m above the foundation outside
    Assumes: as slope_water_safety; surfaces no deeper than 2 m under the toe
    Source: as slope_water_safety
    Check: one face with the level below the crest extended inside has a lower factor, by at most 4 %
    """
    ground = [(0.0, 2.0), (7.0, 2.0), (19.0, 8.0), (23.0, 8.0), (35.0, 2.0), (42.0, 2.0)]
    start = [(0.0, 3.0), (9.0, 3.0)] if drawn else [(0.0, 7.0)]
    water = [*start, (17.0, 7.0), (25.0, 3.0), (33.0, 2.0), (42.0, 2.0)]
    cohesion, slope = davis_cohesion(12.0, 28.0, 0.0), math.tan(math.radians(davis_friction(28.0, 0.0)))
    faces = [(_line(*ground), _line(*water))]
    faces.append((_line(*_mirrored(ground)), _line(*_mirrored(water))))
    return min(
        _factor(Scene(land, level, 9.81, 19.0, 20.5, 0.0, lambda y: cohesion + 0 * y, slope, 0.0)) for land, level in faces
    )


def _mirrored(corners: list[tuple[float, float]]) -> list[tuple[float, float]]:
    return [(-x, y) for x, y in reversed(corners)]
