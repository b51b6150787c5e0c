#!/usr/bin/env python3
"""Factors of safety of drained slopes by default, beside the log spiral and the bounds of limit analysis.

Usage: factors.py BINARY [SLOPE...] [--cells N] [--markdown FILE]   (a minute of CPU time; runs go to output/factors)
       factors.py BINARY [SLOPE...] --splines 40     beside averaged quadratic splines on so many cells a height, psi = phi: minutes a slope

A slope is ANGLE/FRICTION in degrees, c = 1 and height 1 on ground of half its height, built at 0.7 of its exact limit load. The deck
names its grid of N cells a height and nothing of the method. With psi = phi the log spiral through the toe (Chen 1975) is an upper
bound, and the bounds of limit analysis are near. With psi = 0 they are those of strength reduced after Davis.
"""
from __future__ import annotations

import argparse
import json
import math
import pathlib
import sys

TOP = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(TOP / "tools"))
from qsmpm_verify.bounds.phases import read_scene  # noqa: E402
from qsmpm_verify.bounds.search import Search  # noqa: E402
from qsmpm_verify.cpu_limit import run_limited  # noqa: E402
from qsmpm_verify.reference.slope import slope_spiral_safety, slope_spiral_unit_weight  # noqa: E402
from qsmpm_verify.study.cards import read_deck  # noqa: E402

FOLDER = TOP / "output/factors"
SLOPES = ("33.2/17.5", "38.7/14", "45/25", "52.3/23", "63.4/31", "71.6/12", "82/28", "90/20")
# Bounds of limit analysis of these slopes with psi = phi: `factors.py BINARY` writes the decks, `tools/qsmpm-verify bounds output/factors/NAME_a.inp
# --triangles 1500 --passes 4` tells them (a minute each). The spiral through the toe is an upper bound, up to 0.8 % above them.
BRACKETS = {
    "33.2/17.5": (1.14962, 1.15138), "38.7/14": (1.21223, 1.21573), "45/25": (1.14612, 1.15158), "52.3/23": (1.19021, 1.19728),
    "63.4/31": (1.1843, 1.1944), "71.6/12": (1.31125, 1.31537), "82/28": (1.25388, 1.26304), "90/20": (1.30537, 1.3098),
}
DECK = """*MODEL, TYPE=PLANE STRAIN
*UNITS, LENGTH=m, FORCE=kN
*GRID
X, 0, {width}, {along}
Y, -0.5, 1, {up}
*NSET, NSET=base, PLANE=Y
-0.5
*NSET, NSET=left, PLANE=X
0
*NSET, NSET=right, PLANE=X
{width}
*MATERIAL, NAME=soil
*ELASTIC
1e4, 0.3
*MOHR COULOMB
1, {friction}, {dilatancy}
*UNIT WEIGHT
{weight:.8g}
*BODY, NAME=slope, MATERIAL=soil, SHAPE=POLYGON
0, -0.5
{width}, -0.5
{width}, 0
{toe:.8g}, 0
{crest}, 1
0, 1
*PHASE, NAME=built
*FIX
base, ALL
left, X
right, X
*GRAVITY
0, -1
*END PHASE
*PHASE, NAME=factor, TYPE=SAFETY
*END PHASE
"""


def deck_of(angle: float, friction: float, dilatancy: float, weight: float, cells: int) -> str:
    """The deck of a slope with a height and a half behind its crest and two before its toe."""
    crest = 1.5
    toe = crest + 1.0 / math.tan(math.radians(angle))
    width = math.ceil(toe + 2.0)
    return DECK.format(width=width, along=width * cells, up=3 * cells // 2, friction=friction, dilatancy=dilatancy, weight=weight, toe=toe, crest=crest)


def slope_of(slope: str, cells: int, dilatant: bool = True) -> tuple[str, float]:
    """The deck of a slope ANGLE/FRICTION at 0.7 of its limit load, and the factor of psi = phi."""
    angle, friction = map(float, slope.split("/"))
    weight = 0.7 * slope_spiral_unit_weight(1.0, friction, angle, 1.0)
    return deck_of(angle, friction, friction if dilatant else 0.0, weight, cells), slope_spiral_safety(weight, 1.0, friction, angle, 1.0)


def run(binary: pathlib.Path, name: str, deck: str) -> tuple[float, float, str]:
    """Last stable factor, CPU seconds, and what is to be noted."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    path = FOLDER / f"{name}.inp"
    path.write_text(deck, encoding="utf-8")
    done = run_limited([binary, "run", path, "--out", FOLDER / name], 600.0)
    found = json.loads((FOLDER / name / "safety.json").read_text(encoding="utf-8"))["phases"][-1]
    note = "" if found.get("refused") is None else "no mechanism seen"
    return float(found["stable"]), done.cpu, note if done.code == 0 else f"exit {done.code}"


def bracket_of(slope: str, associated: bool, deck: pathlib.Path) -> tuple[float, float]:
    """Bounds of the factor: those that are known, or of a search of seconds."""
    if associated and slope in BRACKETS:
        return BRACKETS[slope]
    found = Search(read_scene(read_deck(deck))).run()
    return found.lower.value, found.upper.value


def row(binary: pathlib.Path, slope: str, associated: bool, cells: int) -> str:
    """A line of the table; the error is that from the middle of the bracket, or with psi = 0, where it is wider, beyond it."""
    deck, exact = slope_of(slope, cells, associated)
    name = slope.replace("/", "_").replace(".", "p") + ("_a" if associated else "_0")
    factor, seconds, note = run(binary, name, deck)
    low, high = bracket_of(slope, associated, FOLDER / f"{name}.inp")
    error = factor / (0.5 * (low + high)) - 1.0 if associated else factor / min(max(factor, low), high) - 1.0
    told = f"{exact:.4f}" if associated else "-"
    return f"| {slope} | {'phi' if associated else '0'} | {told} | {low:.4f} to {high:.4f} | {factor:.4f} | {error:+.1%} | {seconds:.1f} | {note} |"


def compare(binary: pathlib.Path, slopes: list[str], cells: int, spline_cells: int) -> None:
    """Errors from the middle of the bounds and CPU seconds by default and on splines, and by how much the latter are dearer."""
    print(f"| slope | by default, {cells} cells | CPU s | SPLINE2G, {spline_cells} cells | CPU s | times |\n|---|---|---|---|---|---|")
    for slope in slopes:
        middle = 0.5 * sum(BRACKETS[slope])
        factor, seconds, _ = run(binary, "by_default", slope_of(slope, cells)[0])
        method = "*METHOD, BASIS=SPLINE2G, INTEGRATION=CELL, FACTOR=0.001\n*GRID, ELEMENT=QUAD4\n"
        other, dearer, _ = run(binary, "splines", slope_of(slope, spline_cells)[0].replace("*GRID\n", method, 1))
        print(f"| {slope} | {factor:.4f}, {factor / middle - 1.0:+.1%} | {seconds:.1f} | {other:.4f}, {other / middle - 1.0:+.1%} | {dearer:.0f} "
              f"| {dearer / seconds:.0f} |", flush=True)


def main() -> int:
    """All slopes, both flow rules."""
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("binary", type=pathlib.Path)
    words.add_argument("slopes", nargs="*", default=SLOPES)
    words.add_argument("--cells", type=int, default=10)
    words.add_argument("--markdown", type=pathlib.Path)
    words.add_argument("--splines", type=int, default=0)
    asked = words.parse_args()
    if asked.splines:
        compare(asked.binary.resolve(), asked.slopes, asked.cells, asked.splines)
        return 0
    lines = ["| slope | psi | log spiral | bounds | by default | error | CPU s | note |", "|---|---|---|---|---|---|---|---|"]
    print("\n".join(lines))
    for associated in (True, False):
        for slope in asked.slopes:
            line = row(asked.binary.resolve(), slope, associated, asked.cells)
            lines.append(line)
            print(line, flush=True)
    if asked.markdown:
        head = f"Factors of safety on {asked.cells} cells a height, `verification/factors.py build/qsmpm --cells {asked.cells} --markdown {asked.markdown}`.\n\n"
        asked.markdown.write_text(head + "\n".join(lines) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
