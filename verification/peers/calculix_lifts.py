#!/usr/bin/env python3
"""An elastic column built in five lifts, by QSMPM and by CalculiX (20-node bricks, *MODEL CHANGE), beside the closed form.

    verification/peers/calculix_lifts.py [--program FILE]

The deck of QSMPM is verification/cases/decks/stages_lifts_5.inp. Settlements of the tops of the lifts from where they
were put in place; exit code 1 where two of the three differ by more than 1e-3 of the largest.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

TOP = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(TOP / "tools"))

from qsmpm_verify.results import read_curves  # noqa: E402

LIFTS, THICK, YOUNG, POISSON, WEIGHT = 5, 2, 1e7, 0.25, 20.0
HEIGHT = LIFTS * THICK
MODULUS = YOUNG * (1 - POISSON) / ((1 + POISSON) * (1 - 2 * POISSON))
ALLOWED = 1e-3

Place = tuple[float, float, float]


def brick(bottom: float) -> list[Place]:
    """Places of the nodes of a cube of 1 m, in CalculiX' order: corners, middles of the edges below, above and between."""
    below = [(0.0, bottom, 0.0), (1.0, bottom, 0.0), (1.0, bottom, -1.0), (0.0, bottom, -1.0)]
    above = [(x, bottom + 1.0, z) for x, _, z in below]

    def middle(a: Place, b: Place) -> Place:
        return (a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2

    rings = [middle(ring[i], ring[(i + 1) % 4]) for ring in (below, above) for i in range(4)]
    return [*below, *above, *rings, *(middle(a, b) for a, b in zip(below, above))]


def calculix_deck() -> str:
    """The column, confined at its sides; every step adds a lift without strain, and its weight."""
    cubes = [brick(float(y)) for y in range(HEIGHT)]
    places = list(dict.fromkeys(place for cube in cubes for place in cube))
    number = {place: i for i, place in enumerate(places, 1)}
    lines = ["*NODE, NSET=ALL", *(f"{i},{x},{y},{z}" for (x, y, z), i in number.items())]
    for lift in range(LIFTS):
        lines.append(f"*ELEMENT, TYPE=C3D20, ELSET=L{lift + 1}")
        for y in range(lift * THICK, (lift + 1) * THICK):
            words = [str(y + 1), *(str(number[place]) for place in cubes[y])]
            lines += [",".join(words[:11]) + ",", ",".join(words[11:])]
    lines += ["*ELSET, ELSET=COLUMN", ",".join(f"L{i + 1}" for i in range(LIFTS)), "*NSET, NSET=BASE"]
    lines += [str(i) for (_, y, _), i in number.items() if y == 0]
    lines += ["*NSET, NSET=TOPS", *(str(number[0.0, float(THICK * (i + 1)), 0.0]) for i in range(LIFTS))]
    lines += ["*MATERIAL, NAME=SOIL", "*ELASTIC", f"{YOUNG},{POISSON}", "*DENSITY", "1",
              "*SOLID SECTION, ELSET=COLUMN, MATERIAL=SOIL", "*BOUNDARY", "ALL,1", "ALL,3", "BASE,2"]  # fmt: skip
    for lift in range(1, LIFTS + 1):
        change = f"ADD=STRAINFREE\nL{lift}" if lift > 1 else "REMOVE\n" + ",".join(f"L{i}" for i in range(2, LIFTS + 1))
        lines += ["*STEP, NLGEOM", "*STATIC", f"*MODEL CHANGE, TYPE=ELEMENT, {change}", "*DLOAD",
                  f"L{lift},GRAV,{WEIGHT},0.,-1.,0.", "*NODE PRINT, NSET=TOPS", "U", "*END STEP"]  # fmt: skip
    return "\n".join(lines) + "\n"


def by_calculix(folder: Path) -> list[float]:
    """Settlements at the end of the last step."""
    (folder / "lifts.inp").write_text(calculix_deck())
    subprocess.run(["ccx", "lifts"], cwd=folder, check=True, capture_output=True, timeout=120)
    block = (folder / "lifts.dat").read_text().split("displacements")[-1]
    return [float(hit[1]) for hit in re.finditer(r"^\s*\d+\s+\S+\s+(\S+)\s+\S+$", block, re.MULTILINE)]


def by_qsmpm(program: Path, folder: Path) -> list[float]:
    """The last row of the curves."""
    deck = TOP / "verification" / "cases" / "decks" / "stages_lifts_5.inp"
    subprocess.run([program, "run", deck, "--quiet", "--out", folder / "out"], check=True, timeout=120)
    curves = read_curves(folder / "out")
    return [float(curves.column(f"top{i}")[-1]) for i in range(1, LIFTS + 1)]


def closed_form() -> list[float]:
    """-(gamma z (H - z) + gamma d (z - d/2))/M: the lifts above, and the lift itself on what it has settled by its own weight."""
    tops = [THICK * i for i in range(1, LIFTS + 1)]
    return [-WEIGHT * (z * (HEIGHT - z) + THICK * (z - THICK / 2)) / MODULUS for z in tops]


def main() -> int:
    """Both programs and the formula side by side."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=Path, default=TOP / "build" / "qsmpm")
    words = parser.parse_args()
    if not shutil.which("ccx"):
        print("CalculiX (ccx) is not installed: left out")
        return 0
    with tempfile.TemporaryDirectory() as name:
        peer, own = by_calculix(Path(name)), by_qsmpm(words.program.resolve(), Path(name))
    rows = list(zip(own, peer, closed_form()))
    worst = max(max(row) - min(row) for row in rows) / max(-row[2] for row in rows)
    for lift, row in enumerate(rows, 1):
        print(f"top of lift {lift}: QSMPM {row[0]:.6e}, CalculiX {row[1]:.6e}, closed form {row[2]:.6e}")
    print(f"largest difference {worst:.1e} of the largest settlement, allowed {ALLOWED:.0e}")
    return 0 if worst <= ALLOWED else 1


if __name__ == "__main__":
    sys.exit(main())
