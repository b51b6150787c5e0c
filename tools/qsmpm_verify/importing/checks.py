"""Checks of a section before it is written: size, overlapping or self-intersecting regions, water and loads beside it."""

from __future__ import annotations

from itertools import combinations

import shapely
from shapely.geometry import Polygon
from shapely.validation import explain_validity

from qsmpm_verify.importing.loads import STEPS, ground_of
from qsmpm_verify.importing.section import Section
from qsmpm_verify.trouble import Trouble

SMALLEST, LARGEST = 0.5, 500.0
"""Range of heights of a section in metres outside which a note on the unit is given."""
LIGHT, HEAVY = 5.0, 40.0
"""Range of unit weights of soil in kN/m3 outside which a note on the unit is given."""
AWAY = 0.05
"""Distance in metres that the line of a load may have from the ground."""
NEAR = 1.0e-6
"""Fraction of the area of a region below which an overlap is ignored."""


def check_section(section: Section) -> None:
    """Reject sections that cannot be converted; note data that may be interpreted differently from what is meant."""
    low_x, high_x, low_y, high_y = section.box()
    section.notes.insert(0, f"{high_x - low_x:.6g} m wide, {high_y - low_y:.6g} m high")
    if not SMALLEST <= high_y - low_y <= LARGEST:
        section.notes.append(f"a height of {high_y - low_y:.4g} m: check the unit of the file; --unit defines that of a drawing")
    check_regions(section)
    for water in section.water:
        heights = [y for _, y in water]
        if max(heights) < low_y or min(heights) > 2.0 * high_y - low_y:
            section.notes.append("the water line is below the section, or above it by more than its height: check the unit")
        for end, beyond in ((water[0], water[0][0] - low_x), (water[-1], high_x - water[-1][0])):
            if beyond > NEAR * (high_x - low_x):
                section.notes.append(f"the water line ends at ({end[0]:.6g}, {end[1]:.6g}), {beyond:.4g} m inside the section: it is extended horizontally from there")
    if section.water and section.dry:
        section.notes.append(f"the water line does not apply to {', '.join(sorted(section.dry))}: no pore pressure there")
    check_loads(section)


def check_regions(section: Section) -> None:
    """Regions must be simple polygons beside each other."""
    shapes = {region.name: Polygon(region.outline) for region in section.regions if len(region.outline) > 2}
    for region in section.regions:
        if region.name not in shapes or not shapes[region.name].is_valid or shapes[region.name].area == 0.0:
            why = explain_validity(shapes[region.name]) if region.name in shapes else "fewer than three corners"
            raise Trouble(f"region '{region.name}' is not a simple polygon: {why}")
    for (one, first), (other, second) in combinations(shapes.items(), 2):
        common = first.intersection(second)
        if common.area > NEAR * min(first.area, second.area):
            place = common.representative_point()
            raise Trouble(f"regions '{one}' and '{other}' overlap by {common.area:.4g} m2 around ({place.x:.6g}, {place.y:.6g}): a point can only be in one region")
    parts = shapely.get_parts(shapely.union_all([shape.buffer(NEAR * shape.length) for shape in shapes.values()]))
    if len(parts) > 1:
        ends = shapely.shortest_line(parts[0], parts[1]).coords
        raise Trouble(f"the regions are not connected: {len(parts)} parts; between ({ends[0][0]:.6g}, {ends[0][1]:.6g}) and "
                      f"({ends[1][0]:.6g}, {ends[1][1]:.6g}) there is no soil")  # fmt: skip
    for hole in parts[0].interiors:
        place = Polygon(hole).representative_point()
        section.notes.append(f"an opening of {Polygon(hole).area:.4g} m2 around ({place.x:.4g}, {place.y:.4g}): there is no region")


def check_soils(section: Section) -> None:
    """Notes on soil parameters that are probably not in kN and m."""
    for soil in section.soils.values():
        for weight in (soil.weight, soil.saturated_weight):
            if weight is not None and not LIGHT <= weight <= HEAVY:
                section.notes.append(f"soil '{soil.name}': a unit weight of {weight:g} kN/m3: check that it is in kN/m3, not in kg/m3 or t/m3")
        if soil.weight is not None and soil.saturated_weight is not None and soil.saturated_weight < soil.weight:
            raise Trouble(f"soil '{soil.name}': saturated_weight {soil.saturated_weight:g} is less than weight {soil.weight:g}: it must include the weight of the water")
        if soil.friction is not None and 0.0 < soil.friction < 2.0:
            section.notes.append(f"soil '{soil.name}': a friction angle of {soil.friction:g} degrees: check that it is in degrees")


def check_loads(section: Section) -> None:
    """Report where loads act, and which part of them is beside the section."""
    ground = ground_of(section)
    for load in section.loads:
        left, right = load.points[0][0], load.points[-1][0]
        sizes = [size for _, size in load.points]
        covered = sum(max(0.0, min(right, stretch.high[0]) - max(left, stretch.low[0])) for stretch in ground)
        if covered < (1.0 - NEAR) * (right - left):
            beside = f"{right - left - covered:.4g} m of its {right - left:.4g} m from x = {left:g} to {right:g}"
            section.left.append(f"{load.name}: {beside} are beside the section")
        below = [stretch for stretch in ground if stretch.high[0] > left and stretch.low[0] < right]
        near = [stretch.at(x)[1] for stretch in below for x in (max(left, stretch.low[0]), min(right, stretch.high[0]))]
        if load.drawn_at is not None and near and max(abs(y - load.drawn_at) for y in near) > AWAY:
            there = f"the ground, which is at {min(near):.4g} to {max(near):.4g} there"
            section.notes.append(f"{load.name}: its line at y = {load.drawn_at:g} is not {there}; it acts on the ground")
        if covered > 0.0:
            even = min(sizes) == max(sizes)
            size = f"{sizes[0]:.6g} kPa" if even else f"{sizes[0]:.6g} to {sizes[-1]:.6g} kPa, in {STEPS} steps,"
            section.notes.append(f"{load.name}: {size} on horizontal area, downwards on the ground from x = {left:g} to {right:g}")
