"""A GeoStudio project (.gsz: a ZIP with one XML) as a section: geometry, soils and piezometric line of one of its analyses."""

from __future__ import annotations

import xml.etree.ElementTree as ET
import zipfile
from collections import Counter
from pathlib import Path

from qsmpm_verify.importing.loads import add_fill
from qsmpm_verify.importing.section import Point, Region, Section, Soil, along_x, numbered, plain_name, without_repeats
from qsmpm_verify.trouble import Trouble

FOOT, POUNDS_PER_CUBIC_FOOT, POUNDS_PER_SQUARE_FOOT = 0.3048, 0.157087, 0.0478803
"""Metres, kN/m3 and kPa in the units of projects that are not metric."""
LARGEST = 200_000_000
"""Largest size of the XML in bytes."""
TAKEN = {"MaterialUsesPiezs", "PiezometricSurfaces", "DataPoints", "Surcharges"}
SETTINGS = {"SlipSurface", "SlipSurfaceOptimization", "UnitWaterWeight", "LambdaPoints", "SideFunction", "ConvergenceOptions"}
"""Entries of a stability analysis on its search, which is not needed here."""


def number(node: ET.Element | None, tag: str) -> float | None:
    """Number in a child element, None if there is none."""
    text = word(node, tag)
    try:
        return float(text) if text else None
    except ValueError:
        return None


def word(node: ET.Element | None, tag: str) -> str:
    """Text of a child element, empty if there is none."""
    child = node.find(tag) if node is not None else None
    if child is None or child.text is None or child.get("Missing") == "true":
        return ""
    return child.text.strip()


def read_gsz(path: Path, wanted: str | None) -> Section:
    """The section of an analysis of a project, by name or number; default the first one."""
    root = root_of(path)
    analysis, number_of_it = chosen(root, wanted, path)
    section = Section()
    metric = not is_imperial(root)
    if not metric:
        section.notes.append("in feet and pounds; converted to m and kN")
    section.notes.append(f"analysis '{word(analysis, 'Name')}'")
    take_regions(section, root, analysis, number_of_it, FOOT if not metric else 1.0)
    take_soils(section, root, metric)
    take_water(section, root, number_of_it, metric)
    return section


def root_of(path: Path) -> ET.Element:
    """Root of the XML of the model, at the top of the archive."""
    if not path.is_file():
        raise Trouble(f"{path}: no such file")
    if not zipfile.is_zipfile(path):
        raise Trouble(f"{path}: not a GeoStudio project: no ZIP archive")
    with zipfile.ZipFile(path) as archive:
        inside = [info for info in archive.infolist() if "/" not in info.filename and info.filename.lower().endswith(".xml")]
        if not inside or inside[0].file_size > LARGEST:
            raise Trouble(f"{path}: not a GeoStudio project: no XML of a model at its top")
        data = archive.read(inside[0])
    if b"<!ENTITY" in data:
        raise Trouble(f"{path}: its XML declares entities, which is not supported")
    try:
        root = ET.fromstring(data)
    except ET.ParseError as error:
        raise Trouble(f"{path}: {inside[0].filename}: {error}") from error
    if root.tag != "GSIData":
        raise Trouble(f"{path}: not a GeoStudio project: the root of its XML is {root.tag}")
    return root


def is_imperial(root: ET.Element) -> bool:
    """Whether the project is in feet."""
    units = root.find("./Coordinates/EngCoords")
    return units is not None and any(kind in (units.get("UnitSystem") or "").lower() for kind in ("imperial", "english", "us"))


def chosen(root: ET.Element, wanted: str | None, path: Path) -> tuple[ET.Element, str]:
    """An analysis and its number."""
    analyses = root.findall("./Analyses/Analysis")
    names = [f"{word(one, 'ID')} '{word(one, 'Name')}'" for one in analyses]
    for one in analyses:
        if wanted is None or wanted in (word(one, "ID"), word(one, "Name")):
            return one, word(one, "ID")
    raise Trouble(f"{path}: no analysis '{wanted}'; available are {', '.join(names) or 'none'}" if wanted else f"{path}: no analysis")


def take_regions(section: Section, root: ET.Element, analysis: ET.Element, number_of_it: str, metres: float) -> None:
    """Regions of the geometry of the analysis, with the materials of its context."""
    geometries = root.findall("./Geometries/Geometry")
    place = int(number(analysis, "GeometryId") or 1)
    if not 0 < place <= len(geometries):
        raise Trouble(f"analysis {number_of_it} has geometry {place} of {len(geometries)}")
    geometry = geometries[place - 1]
    points: dict[str, Point] = {
        p.get("ID", ""): (float(p.get("X", "")) * metres, float(p.get("Y", "")) * metres)
        for p in geometry.findall("./Points/Point") if p.get("X") and p.get("Y")
    }  # fmt: skip
    names = {word(m, "ID"): plain_name(word(m, "Name")) or f"material {word(m, 'ID')}" for m in root.findall("./Materials/Material")}
    material = {
        use.get("ID", "").removeprefix("Regions-"): use.get("Entry", "")
        for context in root.findall("./Contexts/Context") if word(context, "AnalysisID") == number_of_it
        for use in context.findall("./GeometryUsesMaterials/GeometryUsesMaterial")
    }  # fmt: skip
    found: list[tuple[str, list[Point]]] = []
    for region in geometry.findall("./Regions/Region"):
        label, corners = word(region, "ID"), word(region, "PointIDs").split(",")
        missing = [corner for corner in corners if corner not in points]
        if missing:
            raise Trouble(f"region {label} has corner {missing[0] or 'none'}, which is not a point")
        if material.get(label) not in names:
            section.left.append(f"region {label} has no material in this analysis: treated as empty")
            continue
        found.append((names[material[label]], [points[corner] for corner in corners]))
    for (soil, outline), name in zip(found, numbered([soil for soil, _ in found]), strict=True):
        section.regions.append(Region(name, soil, without_repeats(outline, 0.0)))
        section.soils.setdefault(soil, Soil(soil))


def take_soils(section: Section, root: ET.Element, metric: bool) -> None:
    """Strength and unit weight of the soils in use."""
    weight, stress = (1.0, 1.0) if metric else (POUNDS_PER_CUBIC_FOOT, POUNDS_PER_SQUARE_FOOT)
    for material in root.findall("./Materials/Material"):
        name = plain_name(word(material, "Name")) or f"material {word(material, 'ID')}"
        if name not in section.soils:
            continue
        model, values = word(material, "SlopeModel"), material.find("StressStrain")
        gamma = number(values, "UnitWeight")
        cohesion, friction = number(values, "CohesionPrime"), number(values, "PhiPrime")
        if model == "UndrainedPhiZero":
            cohesion, friction = number(values, "Cohesion"), 0.0
        elif model != "MohrCoulomb":
            section.left.append(f"soil '{name}' is of model '{model}': its strength must be given in the table")
            cohesion = friction = None
        else:
            cohesion, friction = cohesion or 0.0, friction or 0.0
            if number(values, "PhiB"):
                section.left.append(f"soil '{name}': PhiB, strength from suction")
        section.soils[name] = Soil(name, gamma and gamma * weight, None, None, None, None if cohesion is None else cohesion * stress, friction)


def take_water(section: Section, root: ET.Element, number_of_it: str, metric: bool) -> None:
    """Piezometric line and surcharges of the analysis (fill between a line and the ground: its `Pressure` is a unit weight), and a list of what
    else belongs to it."""
    metres, weight = (1.0, 1.0) if metric else (FOOT, POUNDS_PER_CUBIC_FOOT)
    for item in root.findall("./WaterItems/WaterItem"):
        if word(item, "AnalysisID") == number_of_it:
            section.water_weight = (number(item.find("Entry"), "UnitWaterWeight") or 9.81 / weight) * weight
            option = word(item.find("Entry/ResultInputInfo"), "Option")
            if option not in ("", "None", "PiezoSurface"):
                section.left.append(f"water by '{option}': *WATER LEVEL requires a line, or TYPE=SEEPAGE computes one")
    for item in root.findall("./StabilityItems/StabilityItem"):
        entry = item.find("Entry")
        if word(item, "AnalysisID") != number_of_it or entry is None:
            continue
        local = {
            p.get("Number", ""): (float(p.get("X", "")) * metres, float(p.get("Y", "")) * metres)
            for p in entry.findall("./DataPoints/DataPoint") if p.get("X") and p.get("Y")
        }  # fmt: skip
        for surface in entry.findall("./PiezometricSurfaces/PiezometricSurface"):
            corners = [local[p.text.strip()] for p in surface.findall("./DataPoints/DataPoint") if p.text and p.text.strip() in local]
            section.water.append(along_x(corners, f"piezometric surface {word(surface, 'ID')}"))
        used = {use.get("ID") for use in entry.findall("./MaterialUsesPiezs/MaterialUsesPiez") if use.get("UsesID")}
        names = {word(m, "ID"): plain_name(word(m, "Name")) or f"material {word(m, 'ID')}" for m in root.findall("./Materials/Material")}
        section.dry |= {name for label, name in names.items() if used and label not in used and name in section.soils}
        for place, fill in enumerate(entry.findall("./Surcharges/Surcharge"), start=1):
            corners = [local[p.text.strip()] for p in fill.findall("./DataPoints/DataPoint") if p.text and p.text.strip() in local]
            gamma = number(fill, "Pressure")
            if len(corners) < 2 or gamma is None:
                section.left.append(f"surcharge {place} of the analysis: no line, or no unit weight")
            else:
                add_fill(section, corners, gamma * weight, f"surcharge {place}")
        others = Counter(child.tag for child in entry if child.tag not in TAKEN | SETTINGS and (len(child) or child.attrib))
        section.left += [f"{tag} of the analysis" for tag in sorted(others)]
