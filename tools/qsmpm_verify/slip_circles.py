"""Factor of safety of a layered section by Bishop's simplified method: soil polygons, a water line, loads on the ground; search over circles.

F = sum((c b + (W - u b) tan phi) / (cos a + sin a tan phi / F)) R / M, with M the moment about the centre of the weight W of soil, water above the ground
and loads, and of the thrust of that water on slopes (Bishop 1955). Circles intersect the ground at two points and have a width of arc; those that leave the
section, intersect its base, overhang, or have cos a + sin a tan phi / F below 0.2 are not admissible.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from scipy.optimize import minimize  # type: ignore[import-untyped]
from shapely.geometry import LineString, Polygon

from qsmpm_verify.results import Array

Place = tuple[float, float, float]
"""Two x where a circle intersects the ground, half the angle of its arc."""
NEVER = 1.0e9
SHARE = 0.2
"""Below it a slice resists more than its soil (Whitman and Bailey 1967)."""

DRIVING = 0.01
"""Moment divided by weight and radius that is too small to be distinguished from zero with the columns used."""


@dataclass(frozen=True)
class Ground:
    """A soil: outline, unit weights above and below the water, c, phi in degrees."""

    outline: tuple[tuple[float, float], ...]
    weight: float
    saturated: float
    cohesion: float
    friction: float


@dataclass(frozen=True)
class Slope:
    """Soils; a water line that is extended horizontally beyond its ends; loads (x1, x2, pressure downwards); unit weight of water."""

    grounds: Sequence[Ground]
    water: Sequence[tuple[float, float]] = ()
    loads: Sequence[tuple[float, float, float]] = ()
    water_weight: float = 9.81


@dataclass
class Columns:
    """The section in columns of equal width: for each soil and column the bottom and top of the soil, equal where it is absent."""

    x: Array
    width: float
    bottom: Array
    top: Array
    surface: Array
    floor: Array
    water: Array
    load: Array
    push: Array
    """Horizontal force to the right of the free water on each column."""
    numbers: Array
    """For each soil: unit weights above and below the water, c, tan phi."""


def columns_of(slope: Slope, count: int) -> Columns:
    """Columns by vertical lines through the middle of each."""
    shapes = [Polygon(ground.outline) for ground in slope.grounds]
    low_x, low_y, high_x, high_y = shapely.total_bounds(shapes)
    width = (high_x - low_x) / count
    x = low_x + (np.arange(count) + 0.5) * width
    bottom, top = np.full((2, len(shapes), count), low_y)
    for i, shape in enumerate(shapes):
        for j, place in enumerate(x):
            cut = shape.intersection(LineString([(place, low_y - 1.0), (place, high_y + 1.0)]))
            if not cut.is_empty:
                bottom[i, j], top[i, j] = cut.bounds[1], cut.bounds[3]
    surface, floor = top.max(axis=0), np.where(top > bottom, bottom, high_y).min(axis=0)
    water = np.interp(x, *np.array(slope.water).T) if len(slope.water) else np.full(count, low_y - 1.0)
    load = sum((np.where((x > a) & (x < b), p, 0.0) for a, b, p in slope.loads), np.zeros(count))
    numbers = np.array([(g.weight, g.saturated, g.cohesion, math.tan(math.radians(g.friction))) for g in slope.grounds])
    push = slope.water_weight * np.maximum(water - surface, 0.0) * np.gradient(surface)
    return Columns(x, width, bottom, top, surface, floor, water, load, push, numbers)


def circle_through(cut: Columns, place: Place) -> tuple[float, float, float] | None:
    """The circle that intersects the ground at two x, with half the angle of its arc."""
    start, end, half = place
    if not (cut.x[0] < start < end < cut.x[-1] and 0.02 < half < 1.57 and end - start > 4.0 * cut.width):
        return None
    low, high = np.interp([start, end], cut.x, cut.surface)
    chord = math.hypot(end - start, high - low)
    lift = 0.5 / math.tan(half)
    return float(0.5 * (start + end) - lift * (high - low)), float(0.5 * (low + high) + lift * (end - start)), 0.5 * chord / math.sin(half)


def factor_of(cut: Columns, place: Place, water_weight: float) -> float:
    """Factor of safety of the soil above the circle through two x of the ground, with half the angle of its arc; NEVER for an inadmissible circle."""
    circle = circle_through(cut, place)
    if circle is None:
        return NEVER
    x, y, radius = circle
    share = np.clip(np.minimum(cut.x + 0.5 * cut.width, place[1]) - np.maximum(cut.x - 0.5 * cut.width, place[0]), 0.0, cut.width)
    take = np.flatnonzero(share > 0.0)
    width, across = share[take], np.clip((cut.x[take] - x) / radius, -1.0, 1.0)
    base = y - radius * np.sqrt(1.0 - across**2)
    if len(take) < 8 or np.any((base > cut.surface[take])[1:-1]) or np.any((base < cut.floor[take])[1:-1]) or np.max(cut.surface[take]) > y:
        return NEVER
    surface, water = cut.surface[take], cut.water[take]
    low, high = np.maximum(cut.bottom[:, take], base), cut.top[:, take]
    wet = np.clip(np.minimum(high, water) - low, 0.0, None)
    dry = np.clip(high - np.maximum(low, water), 0.0, None)
    ponded = water_weight * np.maximum(water - surface, 0.0)
    weight = width * (cut.numbers[:, 0] @ dry + cut.numbers[:, 1] @ wet + ponded + cut.load[take])
    within = (cut.bottom[:, take] <= base) & (base < high)
    soil = np.argmax(within, axis=0)
    cohesion, friction = cut.numbers[soil, 2], cut.numbers[soil, 3]
    pressure = water_weight * np.maximum(water - base, 0.0)
    sine, cosine = across, np.sqrt(1.0 - across**2)
    # Clockwise: weight right of the centre, water that pushes to the left below it.
    moment = float(np.sum(weight * sine) - np.sum(cut.push[take] * width / cut.width * (y - surface)) / radius)
    sine, moment = (sine, moment) if moment > 0.0 else (-sine, -moment)
    if moment < DRIVING * float(np.sum(weight)):
        return NEVER
    held = cohesion * width + np.maximum(weight - pressure * width, 0.0) * friction
    factor = 1.0
    for _ in range(100):
        share = cosine + sine * friction / factor
        if np.min(share) < SHARE:
            return NEVER
        before, factor = factor, float(np.sum(held / share)) / moment
        if abs(factor - before) < 1.0e-7:
            return factor
    return NEVER


def on_circle(slope: Slope, place: Place, count: int = 1200) -> tuple[float, tuple[float, float, float]]:
    """Factor of safety for one circle given by two x of the ground and half its angle, and its centre and radius."""
    cut = columns_of(slope, count)
    circle = circle_through(cut, place)
    value = factor_of(cut, place, slope.water_weight)
    if circle is None or value >= NEVER:
        raise ArithmeticError("this circle is not an admissible slip circle")
    return value, circle


def bishop(slope: Slope, count: int = 1200, grid: int = 36, angles: int = 10) -> tuple[float, Place]:
    """Lowest factor and its circle: all circles of a grid with coarse columns, then a simplex search with fine ones from the four best distinct circles."""

    def tried(cut: Columns, place: Place) -> float:
        return factor_of(cut, place, slope.water_weight)

    coarse, fine = columns_of(slope, count // 6), columns_of(slope, count)
    ends = np.linspace(coarse.x[0], coarse.x[-1], grid + 2)[1:-1]
    every = [(a, b, h) for i, a in enumerate(ends) for b in ends[i + 1 :] for h in np.linspace(0.1, 1.5, angles)]
    ranked = sorted((tried(coarse, place), place) for place in every)
    starts: list[Place] = []
    for value, place in ranked:
        if value < NEVER and len(starts) < 4 and all(max(abs(place[0] - p[0]), abs(place[1] - p[1])) > 2.5 * (ends[1] - ends[0]) for p in starts):
            starts.append(place)
    if not starts:
        raise ArithmeticError("no slip circle was found")
    spread = np.array([[0.0, 0.0, 0.0], [ends[1] - ends[0], 0.0, 0.0], [0.0, ends[1] - ends[0], 0.0], [0.0, 0.0, 0.1]])
    found = []
    for start in starts:
        options = {"initial_simplex": np.array(start) + spread, "xatol": 1e-4, "fatol": 1e-6}
        found.append(minimize(lambda p: tried(fine, tuple(p)), start, method="Nelder-Mead", options=options))
    best = min(found, key=lambda one: float(one.fun))
    if best.fun >= NEVER:
        raise ArithmeticError("no slip circle was found")
    return float(best.fun), (float(best.x[0]), float(best.x[1]), float(best.x[2]))
