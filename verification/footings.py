#!/usr/bin/env python3
"""Limit loads of footings by default, beside exact values.

Usage: footings.py BINARY [FOOTING...] [--cells N] [--markdown FILE]   (two minutes of CPU time; runs go to output/footings)

Half a footing of the width or diameter 2 on ground of 5 by 10 that is stiff (E is a million times the strength, or ten million times
the stress of a metre of soil), so that the limit load is reached while the scene is still as drawn: beside the edge soil heaves up to
thirty times as far as the footing goes, and the load rises with that. The deck names its grid of N cells
a half width and nothing of the method. A rough footing holds its nodes, a smooth one only pushes them.
"""
from __future__ import annotations

import argparse
import csv
import pathlib
import sys

TOP = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(TOP / "tools"))
from qsmpm_verify.cpu_limit import run_limited  # noqa: E402
from qsmpm_verify.reference import bearing  # noqa: E402

FOLDER = TOP / "output/footings"
DECK = """*MODEL, TYPE={model}
*UNITS, LENGTH=m, FORCE=kN
*GRID
X, 0, 3, {near}
X, 3, {width}, {cells}, {growth}
Y, -5, -2, {below}
Y, -2, 0, {above}
*NSET, NSET=base, PLANE=Y
-5
*NSET, NSET=axis, PLANE=X
0
*NSET, NSET=far, PLANE=X
{width}
*NSET, NSET=plate, BOX
0, 1, 0, 0
*MATERIAL, NAME=soil
*ELASTIC
{stiffness}, 0.3
*MOHR COULOMB
{strength}
{profile}{weight}*BODY, NAME=ground, MATERIAL=soil, SHAPE=BOX
0, {width}, -5, 0
*HISTORY, NAME=reaction, QUANTITY=REACTION, COMPONENT=Y, NSET=plate, SCALE=-1
{ground}*PHASE, NAME=push
*FIX
base, ALL
axis, X
far, X
{rough}*PRESCRIBE
plate, Y, {settlement}
*CONTROLS, STEPS=20
*END PHASE
"""
GROUND = """*PHASE, NAME=ground
*INITIAL, TYPE=K0
0, 0.5
*FIX
base, ALL
axis, X
far, X
*GRAVITY
0, -1
*CONTROLS, STEPS=1
*END PHASE
"""
# Force on half the footing: the exact pressure times the half width, in axisymmetry (per radian) times R^2/2. Circles: Cox, Eason and
# Hopkins (1961), Eason and Shield (1960). Rough, with weight and cohesion: the middle of 15.62 and 15.91, by `tools/qsmpm-verify bounds
# output/footings/strip_rough_weight_phi30_4.inp --phase push --passes 6` (the sum of N_gamma and N_c is 15.06). Clay whose strength
# increases with depth, k B/s_u = 4: the middle of 7.813 and 7.877 (smooth), of 9.118 and 9.258 (rough), by `tools/qsmpm-verify bounds
# output/footings/strip_smooth_clay_kBs4_8.inp --phase push --passes 5` after a run with --cells 8.
FOOTINGS = {
    "strip, smooth, clay": ("plane", "1, 0, 0", False, bearing.prandtl_footing(1.0)),
    "strip, rough, clay": ("plane", "1, 0, 0", True, bearing.prandtl_footing(1.0)),
    "strip, smooth, clay, k B/s = 4": ("rising", "1, 0, 0", False, 7.845),
    "strip, rough, clay, k B/s = 4": ("rising", "1, 0, 0", True, 9.188),
    "strip, smooth, phi 25": ("plane", "1, 25, 25", False, bearing.bearing_nc(25.0)),
    "strip, rough, phi 25": ("plane", "1, 25, 25", True, bearing.bearing_nc(25.0)),
    "strip, smooth, weight, phi 30": ("weight", "0.01, 30, 30", False, bearing.bearing_capacity_smooth(30.0, 0.01, 0.0, 1.0, 2.0)),
    "strip, rough, weight, phi 30": ("weight", "0.01, 30, 30", True, 15.76),
    "circle, smooth, clay": ("circle", "1, 0, 0", False, 5.69),
    "circle, rough, clay": ("circle", "1, 0, 0", True, 6.05),
}


def deck_of(kind: str, strength: str, rough: bool, cells: int) -> str:
    """The deck of one footing."""
    cohesion = float(strength.split(",")[0])
    width = 10
    return DECK.format(
        model="AXISYMMETRIC" if kind == "circle" else "PLANE STRAIN", near=3 * cells, width=width, cells=3 * cells, growth=3, below=2 * cells, above=2 * cells,
        stiffness=1e7 if kind == "weight" else 1e6 * cohesion, strength=strength, weight="*UNIT WEIGHT\n1\n" if kind == "weight" else "", ground=GROUND if kind == "weight" else "",
        profile="*STRENGTH PROFILE, STIFFNESS RATIO=1e6\n0, 1, 2\n" if kind == "rising" else "",
        rough="plate, X\n" if rough else "", settlement=-0.00001 if kind == "weight" else -0.0001,
    )  # fmt: skip


def run(binary: pathlib.Path, name: str, deck: str) -> tuple[float, float, float, str]:
    """Last and largest reaction, CPU seconds and what is to be noted."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    path = FOLDER / f"{name}.inp"
    path.write_text(deck, encoding="utf-8")
    done = run_limited([binary, "run", path, "--out", FOLDER / name], 300.0)
    with (FOLDER / name / "curves.csv").open(encoding="utf-8") as lines:
        rows = list(csv.DictReader(lines))
    column = next(c for c in rows[0] if c.startswith("reaction"))
    course = [float(r[column]) for r in rows if r["phase"] == rows[-1]["phase"]]
    return course[-1], max(course), done.cpu, "" if done.code == 0 else f"exit {done.code}"


def main() -> int:
    """All footings."""
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("binary", type=pathlib.Path)
    words.add_argument("footings", nargs="*", default=list(FOOTINGS))
    words.add_argument("--cells", type=int, default=4)
    words.add_argument("--markdown", type=pathlib.Path)
    asked = words.parse_args()
    lines = ["| footing | exact | last | largest | error | CPU s | note |", "|---|---|---|---|---|---|---|"]
    print("\n".join(lines))
    for footing in asked.footings:
        kind, strength, rough, pressure = FOOTINGS[footing]
        name = footing.replace(", ", "_").translate(str.maketrans("", "", " /=")) + f"_{asked.cells}"
        last, largest, seconds, note = run(asked.binary.resolve(), name, deck_of(kind, strength, rough, asked.cells))
        exact = pressure * (0.5 if kind == "circle" else 1.0)
        lines.append(f"| {footing} | {exact:.4g} | {last:.4g} | {largest:.4g} | {last / exact - 1.0:+.1%} | {seconds:.1f} | {note} |")
        print(lines[-1], flush=True)
    if asked.markdown:
        head = f"Footings on {asked.cells} cells a half width, `verification/footings.py build/qsmpm --cells {asked.cells} --markdown {asked.markdown}`.\n\n"
        asked.markdown.write_text(head + "\n".join(lines) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
