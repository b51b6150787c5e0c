"""A model of RS2 as a section: .fez (an archive) or .fea (its text)."""

from __future__ import annotations

import re
from pathlib import Path

from shapely.geometry import LineString, Polygon

from qsmpm_verify.importing.faces import Drawn, add_faces, cut_into_faces, nearness
from qsmpm_verify.importing.loads import add_even
from qsmpm_verify.importing.rocscience import Units, number, pairs_of, settings_of, texts_of, times, units_of
from qsmpm_verify.importing.section import Point, Section, Soil, along_x, plain_name
from qsmpm_verify.trouble import Trouble

WEIGHT_COLUMN, RU_COLUMN = 1, 68
"""Columns of a row of `material properties`, from 0."""
LISTS = {"line load": "new line loads", "bolt": "bolts", "joint": "joint networks"}
"""Blocks without a counterpart in the imported deck, by the beginning of their entries."""
PIEZO_MODE, DRY_MODE = 3, 2
"""Water of a material: by a piezometric line, by a ratio ru (0: none)."""


def read_rs2(path: Path) -> Section:
    """The section of a model."""
    text = next(iter(texts_of(path, (".fea",)).values()))
    lines = [line.strip() for line in text.splitlines()]
    if "model description:" not in lines:
        raise Trouble(f"{path}: not a model of RS2: no section 'model description'")
    settings = settings_of(until_blank(lines, "model description:"))
    section = Section()
    units = units_of(settings.get("RFCunits", ""), section, path)
    soils = soils_of(text, units)
    take_zones(section, lines, soils, units, path)
    for soil, left in soils.values():
        if soil.name in section.soils:
            section.soils[soil.name] = soil
            section.left += left
    take_water(section, lines, units)
    take_loads(section, inside(lines, "new distributed loads"), units)
    for entry, block in LISTS.items():
        if count := sum(line.startswith(entry) and line.endswith("start:") for line in inside(lines, block)):
            section.left.append(f"{count} x {entry}")
    seismic = [word for word in settings.get("seismic", "").split()[:2] if word.strip("-0.")]
    section.left += [f"seismic {settings['seismic']}"] if seismic else []
    return section


def until_blank(lines: list[str], heading: str) -> list[str]:
    """Lines below a heading up to the next blank line; none without the heading."""
    if heading not in lines:
        return []
    first = lines.index(heading) + 1
    return lines[first : lines.index("", first)] if "" in lines[first:] else lines[first:]


def inside(lines: list[str], block: str) -> list[str]:
    """Lines between the start and the end of a block."""
    if f"{block} start:" not in lines or f"{block} end:" not in lines:
        return []
    return lines[lines.index(f"{block} start:") + 1 : lines.index(f"{block} end:")]


def place_of(line: str) -> Point:
    """Coordinates after a colon."""
    x, y = line.split(":", 1)[1].split(",")
    return float(x), float(y)


def take_zones(section: Section, lines: list[str], soils: dict[int, tuple[Soil, list[str]]], units: Units, path: Path) -> None:
    """Faces formed by the boundaries, each with the material of a triangle inside."""
    drawn: list[Drawn] = []
    kind, corners = "", list[Point]()
    geometry = inside(lines, "v6 geometry")
    for place, line in enumerate(geometry):
        if found := re.match(r'type:\s*"([^"]+)"', line):
            kind = found[1]
        elif line == "vertices start:":
            first = next(i for i in range(place, len(geometry)) if geometry[i].startswith("num points:")) + 1
            corners = [place_of(text) for text in geometry[first : first + int(geometry[first - 1].split(":")[1])]]
            closed = kind == "external"
            if kind in ("external", "material", "excavation", "stage"):
                drawn.append(Drawn(LineString([*corners, corners[0]] if closed else corners), kind, closed))
            else:
                section.left.append(f"a boundary of kind '{kind}' from ({corners[0][0]:g}, {corners[0][1]:g})")
    if not any(line.closed for line in drawn):
        raise Trouble(f"{path}: this model has no external boundary")
    mesh = inside(lines, "materials mesh")
    section.left += ["stages after the first one"] if any(line.startswith("stage 2:") for line in mesh) else []
    seeds = seeds_of(mesh)
    faces = []
    for face in cut_into_faces(drawn, 0.0).faces:
        numbers = [number_of_it for triangle, number_of_it in seeds if face.contains(triangle.representative_point())]
        if numbers and numbers[0] in soils:
            faces.append((soils[numbers[0]][0].name, face))
        else:
            x, y = face.representative_point().coords[0]
            section.left.append(f"a zone around ({x * units.metres:.6g}, {y * units.metres:.6g}) has no material: treated as empty")
    add_faces(section, faces, units.metres, nearness(drawn))


def seeds_of(lines: list[str]) -> list[tuple[Polygon, int]]:
    """Triangles of the mesh of materials, and the material number of each in the first stage."""
    found = []
    for place, line in enumerate(lines):
        if line.startswith("P1:"):
            stage = next((text for text in lines[place : place + 8] if text.startswith("stage 1:")), None)
            if stage is not None:
                found.append((Polygon([place_of(text) for text in lines[place : place + 3]]), int(stage.split(":")[1])))
    return found


def soils_of(text: str, units: Units) -> dict[int, tuple[Soil, list[str]]]:
    """Soils by their numbers, and the data of each without a counterpart."""
    lines = text.splitlines()
    weights = [row.split() for row in body(lines, "material properties:") if re.match(r"\s*-?\d", row)]
    found: dict[int, tuple[Soil, list[str]]] = {}
    for block in re.split(r"\n(?=\s*material\s+\d+:)", "\n" + "\n".join(body(lines, "material types:"))):
        head = re.match(r"\s*material\s+(\d+):\s*(.*)", block)
        if not head:
            continue
        place, name = int(head[1]), plain_name(head[2]) or f"material {head[1]}"
        model = (re.search(r"Plasticity Specifications:\s*(\S+)", block) or ["", "none"])[1]
        elastic = pairs_of(next((line for line in block.splitlines() if line.strip().startswith("nu:")), ""))
        strength = pairs_of(next((line for line in block.splitlines() if line.strip().startswith("C:")), ""))
        row = weights[place - 1] if place <= len(weights) else []
        weight = float(row[WEIGHT_COLUMN]) * units.weight if len(row) > WEIGHT_COLUMN else None
        left = [f"soil '{name}': pore pressure by ru = {row[RU_COLUMN]}"] if len(row) > RU_COLUMN and float(row[RU_COLUMN]) else []
        cohesion = friction = dilation = None
        if model == "MohrCoulomb":
            cohesion, friction, dilation = times(number(strength, "C"), units.stress), number(strength, "phi"), number(strength, "dil")
            left += [f"soil '{name}': tensile strength {strength['T']}, a deck of the import has no tension cut-off"] if number(strength, "T") else []
        else:
            left.append(f"soil '{name}' is of model '{model}': its strength must be given in the table")
        soil = Soil(name, weight or None, None, times(number(elastic, "E"), units.stress), number(elastic, "nu"), cohesion, friction, dilation)
        found[place] = (soil, left)
    return found


def body(lines: list[str], heading: str) -> list[str]:
    """Lines below an unindented heading up to the next one."""
    if heading not in (line.rstrip() for line in lines):
        return []
    first = [line.rstrip() for line in lines].index(heading) + 1
    last = next((i for i in range(first, len(lines)) if lines[i][:1].strip() and lines[i].rstrip().endswith(":")), len(lines))
    return lines[first:last]


def take_water(section: Section, lines: list[str], units: Units) -> None:
    """Piezometric lines used by a material."""
    modes = [int(line.split(":")[1]) for line in lines if line.startswith("iStaticWaterMode:")]
    used = {int(line.split(":")[1]) for line in lines if line.startswith("piezo_to_use:")}
    rows = until_blank(lines, "piezos:")
    place = 1
    for _ in range(int(rows[0]) if rows else 0):
        number_of_it, count = int(rows[place]), int(rows[place + 1])
        corners = [(float(row.split()[0]) * units.metres, float(row.split()[1]) * units.metres) for row in rows[place + 2 : place + 2 + count]]
        place += 2 + count
        if number_of_it in used:
            section.water.append(along_x(corners, f"piezometric line {number_of_it}"))
    if section.water:
        section.notes.append("the piezometric line applies to all soils")
    if others := sorted({mode for mode in modes if mode not in (PIEZO_MODE, DRY_MODE)}):
        section.left.append(f"water of a type (iStaticWaterMode {', '.join(map(str, others))}) other than a piezometric line: *WATER LEVEL, TYPE=SEEPAGE computes one")


def take_loads(section: Section, lines: list[str], units: Units) -> None:
    """Uniform loads on the ground, normal to it or vertical; other loads are omitted."""
    for place, line in enumerate(lines):
        if not re.fullmatch(r"distributed load \d+ start:", line):
            continue
        block = lines[place : lines.index(line.replace("start", "end"), place)]
        words = {key.strip(): value.strip().strip('"').lower() for key, _, value in (row.partition(":") for row in block)}
        what = line.removesuffix(" start:")
        corners = [place_of(row) for row in block if re.match(r"\d+:\s*\S+,", row)]
        odd = [key for key in ("triangular", "flip angle", "is_groundwater") if words.get(key, "no") in ("yes", "true", "1", "on")]
        size = number(words, "magnitude1")
        if odd or words.get("type", "normal") not in ("normal", "vertical") or size is None or len(corners) < 2:
            section.left.append(f"{what}: {', '.join(odd) or 'type ' + words.get('type', 'none')}: not a uniform vertical load")
        else:
            add_even(section, [(x * units.metres, y * units.metres) for x, y in corners], size * units.stress, what)
