"""Loads on the ground: pressures on horizontal area over ranges of x, as tractions on the ground surface below."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely
from shapely.geometry import LineString, Polygon

from qsmpm_verify.importing.section import Load, Point, Section

STEPS = 8
"""Number of parts of a range over which a load varies: a traction is uniform on its surface."""


@dataclass(frozen=True)
class Stretch:
    """Ground without a corner between two x, and its heights there."""

    low: Point
    high: Point

    def at(self, x: float) -> Point:
        """The position of an x on it."""
        share = (x - self.low[0]) / (self.high[0] - self.low[0])
        return x, self.low[1] + share * (self.high[1] - self.low[1])


def ground_of(section: Section, side: int = 3) -> list[Stretch]:
    """The ground from left to right: the upper boundary of all regions, or their lower one (`side` 1); a vertical face is between two parts."""
    soil = shapely.union_all([shapely.make_valid(Polygon(region.outline)) for region in section.regions])
    low_x, high_x, low_y, high_y = section.box()
    near = 1.0e-6 * (high_x - low_x)
    bounds = [part for part in shapely.get_parts(soil) if isinstance(part, Polygon)]
    found = []
    for left, right in pairwise(sorted({x for part in bounds for x, *_ in part.exterior.coords})):
        heights = []
        for x in (0.75 * left + 0.25 * right, 0.25 * left + 0.75 * right):
            cut = soil.intersection(LineString([(x, low_y - 1.0), (x, high_y + 1.0)]))
            if right - left > near and not cut.is_empty:
                heights.append(cut.bounds[side])
        if len(heights) == 2:
            slope = 0.5 * (heights[1] - heights[0])
            found.append(Stretch((left, heights[0] - slope), (right, heights[1] + slope)))
    return found


def add_even(section: Section, line: Sequence[Point], pressure: float, what: str) -> None:
    """A uniform load drawn as a line; on a slope the reference area differs between file formats, so the load is omitted."""
    (x, y), (end_x, end_y) = line[0], line[-1]
    if max(p[1] for p in line) - min(p[1] for p in line) > 1.0e-3 * abs(end_x - x):
        section.left.append(f"{what} from ({x:g}, {y:g}) to ({end_x:g}, {end_y:g}): the reference area of a load is only unique on level ground")
    else:
        section.loads.append(Load(what, ((min(x, end_x), pressure), (max(x, end_x), pressure)), y))


def add_fill(section: Section, line: Sequence[Point], weight: float, what: str) -> None:
    """The weight of fill between the ground and a line above it."""
    points = sorted(line)
    for stretch in ground_of(section):
        low, high = max(stretch.low[0], points[0][0]), min(stretch.high[0], points[-1][0])
        if high > low:
            places = [low, *(x for x, _ in points if low < x < high), high]
            depths = [float(np.interp(x, [p[0] for p in points], [p[1] for p in points])) - stretch.at(x)[1] for x in places]
            if min(depths) < -1.0e-6 * (high - low):
                section.left.append(f"{what}: below the ground between x = {low:g} and {high:g}; it has no weight there")
            if max(depths) > 0.0:
                section.loads.append(Load(what, tuple((x, weight * max(depth, 0.0)) for x, depth in zip(places, depths, strict=True))))


def tractions_of(section: Section) -> list[tuple[list[tuple[Point, Point]], float]]:
    """Parts of the ground, the soil on their left, and the downward traction on each list of them."""
    found: list[tuple[list[tuple[Point, Point]], float]] = []
    ground = ground_of(section)
    for load in section.loads:
        pieces: dict[float, list[tuple[Point, Point]]] = {}
        for (left, p_left), (right, p_right) in pairwise(load.points):
            for stretch in ground:
                low, high = max(left, stretch.low[0]), min(right, stretch.high[0])
                for a, b in pairwise(np.linspace(low, high, STEPS + 1 if p_left != p_right else 2).tolist() if high > low else []):
                    start, end = stretch.at(a), stretch.at(b)
                    pressure = float(np.interp(0.5 * (a + b), (left, right), (p_left, p_right)))
                    traction = pressure * (b - a) / float(np.hypot(b - a, end[1] - start[1]))
                    pieces.setdefault(float(f"{traction:.6g}"), []).append((end, start))
        found += [(places, traction) for traction, places in pieces.items() if traction > 0.0]
    return found
