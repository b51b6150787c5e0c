"""A model of Slide2 as a section: .slmd (an archive of scenarios), .slim (an archive of one), .sli (its text)."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import shapely
from shapely.geometry import Polygon

from qsmpm_verify.importing.faces import NEAR, add_faces
from qsmpm_verify.importing.loads import add_even
from qsmpm_verify.importing.rocscience import Units, number, pairs_of, sections_of, settings_of, texts_of, times, units_of, whole
from qsmpm_verify.importing.section import Point, Section, Soil, along_x, plain_name
from qsmpm_verify.trouble import Trouble

MOHR_COULOMB = 0
DOWN = 270.0
"""Angle of a load."""
LISTS = {
    "anchors": r"\s*\d+\s+x1:", "pore pressures": r".*\bv:", "tension crack": r".*vertices:",
}  # fmt: skip
"""Sections without a counterpart in the imported deck, and the form of their entries."""


def read_slide(path: Path, wanted: str | None) -> Section:
    """The section of a scenario, by name or number; default the first one."""
    texts = texts_of(path, (".sli", ".slsp", ".slsc", ".slmm"))
    shared = [sections_of(text) for name, text in texts.items() if name.lower().endswith(".slsp")]
    scenario = chosen(texts, wanted, path)
    model = sections_of(scenario[1])
    settings = settings_of(model.get("model description", []))
    section = Section()
    section.notes.append(f"scenario '{scenario[0]}'")
    common = settings_of(shared[0].get("shared model description", [])) if shared else {}
    units = units_of(settings.get("units") or common.get("units", ""), section, path)
    places = {
        int(found[1]): (float(found[2]), float(found[3]))
        for line in model.get("vertices", []) if (found := re.match(r"\s*(\d+)\s+x:\s*(\S+)\s+y:\s*(\S+)", line))
    }  # fmt: skip
    names = names_of([*(part.get("material properties", []) for part in shared), model.get("material properties", [])])
    take_cells(section, model, places, names, units, path)
    for number_of_it, words in soils_of([*(part.get("material types", []) for part in shared), model.get("material types", [])]).items():
        take_soil(section, names.get(number_of_it, number_of_it), words, units)
    take_water(section, model, settings, places, units)
    take_loads(section, model.get("forces", []), units)
    for what, entry in LISTS.items():
        if count := sum(bool(re.match(entry, line)) for line in model.get(what, [])):
            section.left.append(f"{count} x {what}")
    section.left += [f"{key} = {settings[key]}" for key in ("seismic", "seismicv", "design_selection") if number(settings, key)]
    return section


def chosen(texts: dict[str, str], wanted: str | None, path: Path) -> tuple[str, str]:
    """Name and text of a scenario."""
    called: dict[str, str] = {}
    for name, text in texts.items():
        if name.lower().endswith(".slmm"):
            called.update(re.findall(r'sc_filename:\s*"(?:[^"]*[/\\])?([^"]+)".*?sc_name:\s*"([^"]*)"', text, re.S))
    models = {Path(name).name: text for name, text in texts.items() if "material types:" in text and not name.lower().endswith(".slsp")}
    order = [name for name in called if name in models] + [name for name in models if name not in called]
    if not order:
        raise Trouble(f"{path}: not a model of Slide2: no section 'material types'")
    for place, name in enumerate(order, start=1):
        if wanted is None or wanted in (str(place), called.get(name, Path(name).stem)):
            return called.get(name, Path(name).stem), models[name]
    raise Trouble(f"{path}: no scenario '{wanted}'; available are {', '.join(called.get(name, Path(name).stem) for name in order)}")


def names_of(bodies: list[list[str]]) -> dict[str, str]:
    """Names of soils by `soil1`, `soil2` ...: the rows with a hatch are soils, in order."""
    found = [plain_name(row[1]) for body in bodies for line in body if (row := re.match(r"\s*(.*?)\s+red:.*\bhatch:", line))]
    return {f"soil{i}": name for i, name in enumerate(found, start=1) if name}


def soils_of(bodies: list[list[str]]) -> dict[str, dict[str, str]]:
    """Data of each soil, in the shared model and in the scenario."""
    found: dict[str, dict[str, str]] = {}
    for body in bodies:
        for line in body:
            if row := re.match(r"\s*(soil\d+)\s*=\s*(.*)", line):
                found.setdefault(row[1], {}).update(pairs_of(row[2]))
    return found


def take_cells(section: Section, model: dict[str, list[str]], places: dict[int, Point], names: dict[str, str], units: Units, path: Path) -> None:
    """The cells of each soil, merged."""
    cells: dict[str, list[Polygon]] = {}
    for line in model.get("cells", []):
        if row := re.match(r"\s*\d+\s+vertices:\s*\[([^\]]*)\]\s*material:\s*(\S+)", line):
            corners = [int(word) for word in row[1].split(",") if word.strip()]
            if any(corner not in places for corner in corners):
                raise Trouble(f"{path}: a cell has a corner that is not a vertex: {line.strip()}")
            cell = Polygon([places[corner] for corner in corners]) if len(corners) > 2 else Polygon()
            if not cell.is_valid or cell.is_empty:
                raise Trouble(f"{path}: a cell is not a simple polygon: {line.strip()}")
            cells.setdefault(row[2], []).append(cell)
    if not cells:
        raise Trouble(f"{path}: this scenario has no cells of soil")
    low_x, low_y, high_x, high_y = shapely.total_bounds([cell for parts in cells.values() for cell in parts])
    near = NEAR * max(high_x - low_x, high_y - low_y)
    faces = [
        (names.get(soil, soil), face)
        for soil, parts in cells.items() for face in shapely.get_parts(shapely.unary_union(parts)) if face.area > 0.0
    ]  # fmt: skip
    add_faces(section, faces, units.metres, near)


def take_soil(section: Section, name: str, words: dict[str, str], units: Units) -> None:
    """Strength and unit weight of a soil in the section."""
    if name not in section.soils:
        return
    soil = Soil(name, times(number(words, "uw"), units.weight) or None, times(number(words, "uwbwt"), units.weight))
    if "type" in words and whole(words, "type") == MOHR_COULOMB:
        soil = replace(soil, cohesion=(number(words, "c") or 0.0) * units.stress, friction=number(words, "phi") or 0.0)
    else:
        section.left.append(f"soil '{name}' is of strength type {words.get('type', 'none')}, not Mohr-Coulomb: its strength must be given in the table")
    if number(words, "wtable") == 0.0:
        section.dry.add(name)
    if number(words, "withru"):
        section.left.append(f"soil '{name}': pore pressure by ru = {words.get('ru', '')}")
    section.soils[name] = soil


def take_water(section: Section, model: dict[str, list[str]], settings: dict[str, str], places: dict[int, Point], units: Units) -> None:
    """The water table."""
    section.water_weight = times(number(settings, "gammaw"), units.weight) or section.water_weight
    way = settings.get("water", "none").rstrip(",")
    line = [row[1] for text in model.get("water table", []) if (row := re.search(r"vertices:\s*\[([^\]]*)\]", text))]
    if way == "hu" and line:
        corners = [places[int(word)] for word in line[0].split(",") if word.strip()]
        section.water.append(along_x([(x * units.metres, y * units.metres) for x, y in corners], "the water table"))
        section.notes.append("the water table applies to all soils" if not section.dry else "the water table applies to soils with wtable: 1")
    elif way not in ("none", "", "hu"):
        section.left.append(f"water by '{way}': *WATER LEVEL requires a line, or TYPE=SEEPAGE computes one")


def take_loads(section: Section, lines: list[str], units: Units) -> None:
    """Uniform vertical loads; other loads are omitted."""
    for line in lines:
        words = pairs_of(line)
        if "load" not in words:
            continue
        size, other = number(words, "load") or 0.0, number(words, "load2")
        places = [number(words, key) for key in ("x1", "y1", "x2", "y2")]
        x, y, end_x, end_y = (value if value is None else value * units.metres for value in places)
        what = f"load {line.split()[0]}"
        if x is None or y is None or end_x is None or end_y is None or number(words, "type") or number(words, "angle") != DOWN or other not in (None, size):
            section.left.append(f"{what}: {line.strip()}: not a uniform vertical load over a length (angle: 270)")
        else:
            add_even(section, ((x, y), (end_x, end_y)), size * units.stress, what)
