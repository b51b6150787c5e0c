"""A DXF drawing as a section, read by ezdxf: closed lines and intersecting lines form regions, named by texts or layers."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import ezdxf
from ezdxf import recover
from ezdxf.path import make_path
from shapely.geometry import LineString, Point, Polygon

from qsmpm_verify.importing.faces import Drawn, add_faces, cut_into_faces, nearness
from qsmpm_verify.importing.loads import add_even
from qsmpm_verify.importing.section import METRES, Section, along_x, plain_name
from qsmpm_verify.trouble import Trouble

LINES = {"LINE", "LWPOLYLINE", "POLYLINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE"}
UNITS = {1: "in", 2: "ft", 4: "mm", 5: "cm", 6: "m", 7: "km", 14: "dm"}
"""Units of $INSUNITS (DXF reference, header variables)."""
WATER = re.compile(r"water|gwl|gwt|phreatic|piezo|wasser|nappe|freatic", re.IGNORECASE)
LOAD = re.compile(r"\b(?:sur)?(?:load|charge)s?(?![a-z])[ _=:-]*(\d+(?:\.\d+)?)?", re.IGNORECASE)
"""Layer names of loads, with their kPa."""
# Of the size of the drawing: how far a chord may be from its curve.
CHORD = 1.0e-3


def read_dxf(path: Path, unit: str | None, water: str | None, gap: float | None) -> Section:
    """The section of a drawing; a layer of water lines is recognised by its name, or is `water`."""
    if not path.is_file():
        raise Trouble(f"{path}: no such file")
    try:
        drawing, _ = recover.readfile(path)
    except (ezdxf.DXFError, OSError) as error:
        raise Trouble(f"{path}: not a DXF drawing: {error}") from error
    section = Section()
    metres = metres_of(drawing, unit, section)
    seen = list(entities_of(drawing, section))
    upright = is_upright(seen, path)
    lines, texts = lines_of(seen, upright), texts_of(seen, upright)
    is_water = re.compile(re.escape(water), re.IGNORECASE).fullmatch if water else WATER.search
    levels = [drawn for drawn in lines if is_water(drawn.layer)]
    if water and not levels:
        raise Trouble(f"{path}: no line on layer '{water}'; available are {', '.join(sorted({line.layer for line in lines}))}")
    loads = [drawn for drawn in lines if not is_water(drawn.layer) and LOAD.search(drawn.layer)]
    take_regions(section, [line for line in lines if not is_water(line.layer) and line not in loads], texts, metres, gap)
    for load in loads:
        size = LOAD.search(load.layer)
        if size is None or size[1] is None:
            raise Trouble(f"{path}: layer '{load.layer}': its name contains no kPa; name it 'load 20', or differently if it bounds soil")
        add_even(section, [(x * metres, y * metres) for x, y, *_ in load.line.coords], float(size[1]), f"layer '{load.layer}'")
    for level in levels:
        corners = [(x * metres, y * metres) for x, y, *_ in level.line.coords]
        section.water.append(along_x(corners, f"{path}: layer '{level.layer}'"))
        section.notes.append(f"layer '{level.layer}' is used as water level")
    return section


def metres_of(drawing: Any, unit: str | None, section: Section) -> float:
    """Metres in a unit of the drawing."""
    known = UNITS.get(int(drawing.header.get("$INSUNITS", 0)))
    if unit is None and known is None:
        code = drawing.header.get("$INSUNITS", 0)
        section.notes.append(f"the drawing defines no known unit ($INSUNITS = {code}): metres are assumed; --unit defines another one")
    chosen = unit or known or "m"
    if chosen != "m":
        section.notes.append(f"drawn in {chosen}, converted to m")
    return METRES[chosen]


def entities_of(drawing: Any, section: Section) -> Iterator[Any]:
    """Content of the model space, with blocks resolved; hidden and unused objects are counted."""
    hidden = {layer.dxf.name for layer in drawing.layers if layer.is_off() or layer.is_frozen()}
    left: Counter[str] = Counter()

    def walk(entities: Any, layer: str | None) -> Iterator[Any]:
        for entity in entities:
            name = entity.dxf.layer if layer is None or entity.dxf.layer != "0" else layer
            if name in hidden:
                left[f"on hidden layer '{name}'"] += 1
            elif entity.dxftype() == "INSERT":
                yield from walk(entity.virtual_entities(), name)
            elif entity.dxftype() in LINES or entity.dxftype() in ("TEXT", "MTEXT"):
                entity.dxf.layer = name
                yield entity
            else:
                left[entity.dxftype()] += 1

    yield from walk(drawing.modelspace(), None)
    section.left += [f"{count} x {what}" for what, count in sorted(left.items())]


def is_upright(entities: list[Any], path: Path) -> bool:
    """Whether the section is drawn in x and z; a 3D drawing is an error."""
    places = [v for entity in entities if entity.dxftype() in LINES for v in make_path(entity).control_vertices()]
    if not places:
        raise Trouble(f"{path}: no lines in the model space")
    reach = [max(p[a] for p in places) - min(p[a] for p in places) for a in range(3)]
    thin = 1.0e-6 * max(reach)
    if reach[2] > thin and reach[1] > thin:
        raise Trouble(f"{path}: the lines are three-dimensional (y over {reach[1]:g}, z over {reach[2]:g}); a section must be drawn in x and y, or x and z")
    return reach[2] > thin


def lines_of(entities: list[Any], upright: bool) -> list[Drawn]:
    """Lines as their corners, curves as chords."""
    paths = [(entity, make_path(entity)) for entity in entities if entity.dxftype() in LINES]
    places = [v for _, way in paths for v in way.control_vertices()]
    size = max(max(v[a] for v in places) - min(v[a] for v in places) for a in range(3))
    found: list[Drawn] = []
    for entity, way in paths:
        corners = [(v.x, v.z if upright else v.y) for v in way.flattening(CHORD * size)]
        if len(corners) < 2 or LineString(corners).length <= 0.0:
            continue
        closed = way.is_closed or bool(getattr(entity, "closed", False)) or bool(getattr(entity, "is_closed", False))
        if closed and corners[0] != corners[-1]:
            corners.append(corners[0])
        found.append(Drawn(LineString(corners), entity.dxf.layer, closed))
    return found


def texts_of(entities: list[Any], upright: bool) -> list[tuple[Point, str]]:
    """Texts and their insertion points."""
    found = []
    for entity in entities:
        if entity.dxftype() in LINES:
            continue
        text = entity.plain_text() if entity.dxftype() == "MTEXT" else entity.dxf.text
        place = entity.dxf.insert
        if plain_name(text):
            found.append((Point(place.x, place.z if upright else place.y), plain_name(text)))
    return found


def take_regions(section: Section, lines: list[Drawn], texts: list[tuple[Point, str]], metres: float, gap: float | None) -> None:
    """Faces of the lines, each named by the text inside, or by the layer of the smallest closed line around it."""
    if not lines:
        raise Trouble("the drawing contains no lines except those of water")
    cut = cut_into_faces(lines, (gap or 0.0) / metres)
    for x, y in cut.loose:
        section.left.append(f"a line has a free end at ({x * metres:.6g}, {y * metres:.6g}) and bounds no region there; --gap LENGTH closes gaps")
    around = sorted(((Polygon(line.line.coords), line.layer) for line in lines if line.closed), key=lambda pair: pair[0].area)
    near = nearness(lines)
    soils: list[str] = []
    for face in cut.faces:
        inside = [text for place, text in texts if face.contains(place)]
        middle = face.representative_point()
        outlines = [(outline, layer) for outline, layer in around if outline.buffer(near).contains(middle)]
        layers = [layer for _, layer in outlines]
        for (small, one), (large, other) in pairwise(outlines if not inside else []):
            if one != other and small.difference(large).area > near * small.length:
                raise Trouble(f"closed lines of layers '{one}' and '{other}' overlap around ({middle.x * metres:.6g}, {middle.y * metres:.6g}): "
                              "draw each soil once, or name the parts by texts inside")
        soils.append(inside[0] if inside else plain_name(layers[0]) if layers else "ground")
        if len(inside) > 1:
            section.notes.append(f"a region contains {len(inside)} texts; it is named '{inside[0]}', not '{inside[1]}'")
    for name in sorted({soil for soil in soils if soils.count(soil) > 1}):
        section.notes.append(f"{soils.count(name)} regions are of soil '{name}'; a text inside each distinguishes them")
    add_faces(section, list(zip(soils, cut.faces, strict=True)), metres, near)
