"""A section independent of the file format: soil regions, water lines, loads, and what could not be imported."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from qsmpm_verify.trouble import Trouble

Point = tuple[float, float]

METRES = {"mm": 1.0e-3, "cm": 1.0e-2, "dm": 0.1, "m": 1.0, "km": 1.0e3, "in": 0.0254, "ft": 0.3048}


@dataclass(frozen=True)
class Soil:
    """Parameters of a soil in kN and m; None if unknown."""

    name: str
    weight: float | None = None
    saturated_weight: float | None = None
    young: float | None = None
    poisson: float | None = None
    cohesion: float | None = None
    friction: float | None = None
    dilation: float | None = None


@dataclass(frozen=True)
class Region:
    """One body: a closed outline whose last corner does not repeat the first."""

    name: str
    soil: str
    outline: tuple[Point, ...]


@dataclass(frozen=True)
class Load:
    """A downward load on the ground: kPa on horizontal area at points along x, from left to right, linear in between."""

    name: str
    points: tuple[tuple[float, float], ...]
    drawn_at: float | None = None
    """Height of its line, if that is meant to be the ground."""


@dataclass
class Section:
    """The content of a file, in metres and kN."""

    regions: list[Region] = field(default_factory=list)
    soils: dict[str, Soil] = field(default_factory=dict)
    water: list[tuple[Point, ...]] = field(default_factory=list)
    water_weight: float = 9.81
    dry: set[str] = field(default_factory=set)
    """Soils to which the water line does not apply."""
    loads: list[Load] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    """Sentences on how data were interpreted."""
    left: list[str] = field(default_factory=list)
    """What has no counterpart and was omitted, with its position."""

    def box(self) -> tuple[float, float, float, float]:
        """Least and largest x, least and largest y of the regions."""
        if not self.regions:
            raise Trouble("no closed line: no soil region was found")
        x, y = zip(*(point for region in self.regions for point in region.outline), strict=True)
        return min(x), max(x), min(y), max(y)


def area_of(outline: Sequence[Point]) -> float:
    """Signed area, positive for counter-clockwise corners."""
    following = [*outline[1:], outline[0]]
    return 0.5 * sum(a[0] * b[1] - b[0] * a[1] for a, b in zip(outline, following, strict=True))


def without_repeats(points: Sequence[Point], near: float) -> tuple[Point, ...]:
    """Corners without consecutive duplicates; the first one is not repeated at the end."""
    kept: list[Point] = []
    for point in points:
        if not kept or max(abs(point[0] - kept[-1][0]), abs(point[1] - kept[-1][1])) > near:
            kept.append(point)
    while len(kept) > 1 and max(abs(kept[0][0] - kept[-1][0]), abs(kept[0][1] - kept[-1][1])) <= near:
        kept.pop()
    return tuple(kept)


def along_x(line: Sequence[Point], what: str) -> tuple[Point, ...]:
    """A water line from left to right; one that reverses in x is not a level."""
    points = list(line)
    if len(points) < 2:
        raise Trouble(f"{what}: a water line requires at least two corners")
    if points[-1][0] < points[0][0]:
        points.reverse()
    if any(b[0] < a[0] for a, b in zip(points, points[1:], strict=False)):
        raise Trouble(f"{what}: the water line reverses in x near ({points[0][0]:g}, {points[0][1]:g})")
    return tuple(points)


def numbered(names: Sequence[str]) -> list[str]:
    """Unique names: the second one of a kind is named `name 2`."""
    met: dict[str, int] = {}
    taken: list[str] = []
    for name in names:
        met[name.lower()] = met.get(name.lower(), 0) + 1
        number = met[name.lower()]
        taken.append(name if number == 1 else f"{name} {number}")
    return taken


def plain_name(text: str) -> str:
    """A name valid in a deck: no commas, quotes or equals signs."""
    return " ".join("".join(" " if c in ",\"'=*" or not c.isprintable() else c for c in text).split())[:60]
