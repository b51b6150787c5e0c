"""A section as a deck: self-weight, water and loads, then a factor of safety."""

from __future__ import annotations

import math
from collections.abc import Sequence

from qsmpm_verify.importing.loads import ground_of, tractions_of
from qsmpm_verify.importing.section import Point, Section, area_of
from qsmpm_verify.importing.soils import completed


def deck_of(section: Section, source: str, cells: int) -> str:
    """Keywords of the deck; `cells` of the grid over the height of the section."""
    low_x, high_x, low_y, high_y = section.box()
    size = (high_y - low_y) / cells
    across = max(1, math.ceil((high_x - low_x) / size - 1.0e-9))
    lines = ["*HEADING", f"Generated from {source} by qsmpm-verify import"]
    lines += ["*UNITS, LENGTH=m, FORCE=kN", "*MODEL, TYPE=PLANE STRAIN", "*GRID"]
    lines += [f"X, {text(low_x)}, {text(high_x)}, {across}", f"Y, {text(low_y)}, {text(high_y)}, {cells}"]
    for name, axis, value in (("base", "Y", low_y), ("left", "X", low_x), ("right", "X", high_x)):
        lines += [f"*NSET, NSET={name}, PLANE={axis}", text(value)]
    for soil in section.soils.values():
        whole = completed(soil, section)
        lines += [f"*MATERIAL, NAME={whole.name}", "*ELASTIC", f"{text(whole.young)}, {text(whole.poisson)}"]
        lines += ["*MOHR COULOMB", f"{text(whole.cohesion)}, {text(whole.friction)}, {text(whole.dilation)}"]
        lines += ["*UNIT WEIGHT", f"{text(whole.weight)}, {text(whole.saturated_weight)}"]
    for region in section.regions:
        outline = region.outline if area_of(region.outline) > 0.0 else tuple(reversed(region.outline))
        lines += [f"*BODY, NAME={region.name}, MATERIAL={region.soil}, SHAPE=POLYGON", *pairs(outline)]
    tractions = tractions_of(section)
    for place, (pieces, _) in enumerate(tractions, start=1):
        lines += [f"*SURFACE, NAME=load {place}, TYPE=SEGMENT", *(f"{text(a)}, {text(b)}, {text(c)}, {text(d)}" for (a, b), (c, d) in pieces)]
    floor = [(stretch.low, stretch.high) for stretch in ground_of(section, 1)]
    uneven = max(abs(y - low_y) for piece in floor for _, y in piece) > 1.0e-6 * (high_y - low_y)
    if uneven:
        section.notes.append("the lower boundary is not level: it is fixed along its whole length")
        lines += ["*SURFACE, NAME=floor, TYPE=SEGMENT", *(f"{text(a)}, {text(b)}, {text(c)}, {text(d)}" for (a, b), (c, d) in floor)]
    lines += ["*PHASE, NAME=weight", "*FIX", "base, ALL", "left, X", "right, X"]
    lines += [*(["*SUPPORT, SURFACE=floor, TYPE=ALL"] if uneven else []), "*GRAVITY", "0, -1"]
    for level in section.water[:1]:
        lines += [f"*WATER LEVEL, UNIT WEIGHT={text(section.water_weight)}", *pairs(level)]
        lines += [f"*WATER LEVEL, BODY={region.name}, TYPE=NONE" for region in section.regions if region.soil in section.dry]
    for place, (_, traction) in enumerate(tractions, start=1):
        lines += [f"*TRACTION, SURFACE=load {place}", f"0, {text(-traction)}"]
    lines += ["*CONTROLS, STEPS=4", "*END PHASE", "*PHASE, NAME=factor, TYPE=SAFETY", "*END PHASE"]
    for further in section.water[1:]:
        section.left.append(f"a further water line from ({further[0][0]:g}, {further[0][1]:g}): a deck has one level for all bodies; BODY= defines others")
    return "\n".join(lines) + "\n"


def pairs(points: Sequence[Point]) -> list[str]:
    """One line for each corner."""
    return [f"{text(x)}, {text(y)}" for x, y in points]


def text(value: float | None) -> str:
    """A number with as few digits as possible; a tenth of a micrometre in a kilometre is resolved."""
    return f"{0.0 if value is None or abs(value) < 1.0e-12 else value:.10g}"
