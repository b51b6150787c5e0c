"""Lines divided into regions: the faces of the planar graph of all lines, and faces as parts without holes."""

from __future__ import annotations

import math
from dataclasses import dataclass

import shapely
from shapely.geometry import LineString, Point, Polygon, box
from shapely.ops import polygonize_full

from qsmpm_verify.importing.section import Region, Section, Soil, numbered, without_repeats

# Of the size of the drawing: nearer is the same place, and a face that is thinner is none.
NEAR = 1.0e-7


@dataclass(frozen=True)
class Drawn:
    """A line of a drawing: its corners, its layer, and whether it is closed."""

    line: LineString
    layer: str
    closed: bool


@dataclass(frozen=True)
class Cut:
    """Faces, and the free ends of lines."""

    faces: list[Polygon]
    loose: list[tuple[float, float]]


def size_of(lines: list[Drawn]) -> float:
    """Larger side of the box of the drawing."""
    low_x, low_y, high_x, high_y = shapely.total_bounds([drawn.line for drawn in lines])
    return float(max(high_x - low_x, high_y - low_y))


def nearness(lines: list[Drawn]) -> float:
    """Length treated as zero: a power of ten, so that round coordinates remain round."""
    return float(10.0 ** math.floor(math.log10(NEAR * size_of(lines))))


def close_gaps(lines: list[Drawn], gap: float) -> list[LineString]:
    """Ends of open lines that are nearer than `gap` to another line, moved to it."""
    moved: list[LineString] = []
    for drawn in lines:
        corners = [(x, y) for x, y, *_ in drawn.line.coords]
        if not drawn.closed:
            others = shapely.union_all([other.line for other in lines if other is not drawn])
            for end in (0, -1):
                place = Point(corners[end])
                if not others.is_empty and place.distance(others) <= gap:
                    nearest = shapely.shortest_line(place, others).coords[-1]
                    corners[end] = (nearest[0], nearest[1])
        moved.append(LineString(corners))
    return moved


def cut_into_faces(lines: list[Drawn], gap: float) -> Cut:
    """All faces, holes included; free ends of lines."""
    near = nearness(lines)
    noded = shapely.unary_union(close_gaps(lines, max(gap, near)), grid_size=near)
    polygons, dangles, cuts, _ = polygonize_full(noded)
    faces = [face for face in polygons.geoms if face.area > near * face.length]
    faces.sort(key=lambda face: (round(face.representative_point().y, 6), round(face.representative_point().x, 6)))
    loose = [(x, y) for bad in (dangles, cuts) for line in bad.geoms for x, y in (line.coords[0], line.coords[-1])]
    outside = shapely.union_all(faces).boundary if faces else None
    return Cut(faces, sorted({point for point in loose if outside is None or Point(point).distance(outside) > near}))


def without_holes(polygon: Polygon) -> list[Polygon]:
    """A face as parts without holes, divided vertically through each hole."""
    if not polygon.interiors:
        return [polygon]
    low_x, low_y, high_x, high_y = polygon.bounds
    middle = Polygon(polygon.interiors[0]).representative_point().x
    halves = (box(low_x, low_y, middle, high_y), box(middle, low_y, high_x, high_y))
    pieces = [part for half in halves for part in shapely.get_parts(polygon.intersection(half)) if part.geom_type == "Polygon"]
    return [whole for piece in pieces for whole in without_holes(piece)]


def add_faces(section: Section, faces: list[tuple[str, Polygon]], metres: float, near: float) -> None:
    """Faces of soils, in the unit of the drawing, as regions without holes; corners nearer than `near` are merged."""
    pieces = [(soil, piece) for soil, face in faces for piece in without_holes(face)]
    for (soil, piece), name in zip(pieces, numbered([soil for soil, _ in pieces]), strict=True):
        corners = [(x * metres, y * metres) for x, y, *_ in piece.exterior.coords]
        section.regions.append(Region(name, soil, without_repeats(corners, near * metres)))
        section.soils.setdefault(soil, Soil(soil))
