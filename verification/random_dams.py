#!/usr/bin/env python3
"""Random dams that water flows through: is the flow found, steady and as the lake falls?

    verification/random_dams.py [--count 100] [--seed 5] [--program build/qsmpm] [--keep DIR]

Heights of 4 to 20 m, slopes of 1:1.2 to 1:3, half of them with a core of 1e-1 to 1e-6 of the shells, levels of 30 to 100 % of the height, a toe drain in a
third, 5 to 12 cells a height; the lake falls by a share of its depth within 0.01 to 10 times H n/k. A flow is found where the program says neither
that it is not, nor that it took more suction than was meant. Closes with `N passed, N failed`.
"""

from __future__ import annotations

import argparse
import pathlib
import random
import re
import sys
import tempfile

TOP = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(TOP / "tools"))
from qsmpm_verify.cpu_limit import run_limited  # noqa: E402

SECONDS = 60.0
DECK = """*HEADING
Random dam {number}.
*UNITS, LENGTH=m, FORCE=kN
*MODEL, TYPE=PLANE STRAIN
*GRID
X, 0, {length}, {columns}
Y, 0, {top}, {rows}
*NSET, NSET=base, PLANE=Y
0
*NSET, NSET=drain, BOX
{drain}, {foot}, 0, 0
*SURFACE, NAME=lake, TYPE=OUTLINE, BODY=up, BOX
-1, {crest_a}, 0, {top}
*SURFACE, NAME=land, TYPE=OUTLINE, BODY=down, BOX
{crest_b}, {beyond}, 0, {top}
*MATERIAL, NAME=shell
*ELASTIC
30000, 0.3
*UNIT WEIGHT
19, 20
*PERMEABILITY, DRAINABLE POROSITY={pores}
{k}
*MATERIAL, NAME=core
*ELASTIC
30000, 0.3
*UNIT WEIGHT
19, 20
*PERMEABILITY, DRAINABLE POROSITY=0.02
{core}
*BODY, NAME=up, MATERIAL=shell, SHAPE=POLYGON
0, 0
{core_a}, 0
{crest_c}, {height}
{crest_a}, {height}
*BODY, NAME=core, MATERIAL=core, SHAPE=POLYGON
{core_a}, 0
{core_b}, 0
{crest_d}, {height}
{crest_c}, {height}
*BODY, NAME=down, MATERIAL=shell, SHAPE=POLYGON
{core_b}, 0
{foot}, 0
{crest_b}, {height}
{crest_d}, {height}
*PHASE, NAME=full
*FIX
base, ALL
*GRAVITY
0, -1
*WATER LEVEL, TYPE=SEEPAGE, UNIT WEIGHT=9.81
lake, {level}
{other}, {low}
*CONTROLS, STEPS=1
*END PHASE
*PHASE, NAME=falls, TIME={time}
*WATER LEVEL, TYPE=SEEPAGE, FLOW=TRANSIENT, UNIT WEIGHT=9.81
lake, {fallen}
{other}, {low}
*CONTROLS, STEPS=1
*END PHASE
"""


def dam(number: int, seed: int) -> str:
    """A dam by its number."""
    chance = random.Random(f"{seed} {number}")
    height, crest = chance.uniform(4.0, 20.0), chance.uniform(3.0, 8.0)
    up, down = chance.uniform(1.2, 3.0) * height, chance.uniform(1.2, 3.0) * height
    cells = chance.randint(5, 12)
    crest_a, crest_b, foot = up, up + crest, up + crest + down
    middle, wide = up + 0.5 * crest, chance.uniform(0.15, 0.4) * min(up, down)
    k = 10.0 ** chance.uniform(-8.0, -3.0)
    level = chance.uniform(0.3, 1.0) * height
    low = chance.choice([0.0, chance.uniform(0.0, 0.3) * level])
    pores = chance.uniform(0.02, 0.3)
    toe = chance.random() < 0.33
    values = {
        "number": number, "length": foot * 1.02, "columns": max(8, round(cells * foot / height / 1.5)), "top": 1.1 * height, "rows": round(1.1 * cells),
        "drain": foot - 0.3 * down, "foot": foot, "crest_a": crest_a, "crest_b": crest_b, "beyond": foot + 1.0, "height": height, "pores": pores, "k": k,
        "core": k * (10.0 ** -chance.uniform(1.0, 6.0) if chance.random() < 0.5 else 1.0), "core_a": middle - wide, "core_b": middle + wide,
        "crest_c": middle - 0.25 * crest, "crest_d": middle + 0.25 * crest, "level": level, "low": 0.0 if toe else low,
        "other": "drain" if toe else "land", "time": 10.0 ** chance.uniform(-2.0, 1.0) * height * pores / k,
        "fallen": level * (1.0 - chance.uniform(0.2, 0.95)),
    }  # fmt: skip
    return DECK.format(**{name: value if isinstance(value, (int, str)) else f"{value:.6g}" for name, value in values.items()})


def main() -> int:
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--count", type=int, default=100)
    words.add_argument("--seed", type=int, default=5)
    words.add_argument("--program", type=pathlib.Path, default=TOP / "build/qsmpm")
    words.add_argument("--keep", type=pathlib.Path, help="folder for the decks whose flow is not found")
    given = words.parse_args()
    failed, iterations, steps, seconds = 0, [], [], 0.0
    with tempfile.TemporaryDirectory() as folder:
        for number in range(given.count):
            deck = pathlib.Path(folder) / f"dam_{number}.inp"
            deck.write_text(dam(number, given.seed))
            ended = run_limited([given.program.resolve(), "check", deck], SECONDS, pathlib.Path(folder))
            said = ended.output + ended.errors
            flows = re.findall(r"triangles,(?: at the end of the phase, after (\d+) steps in time,)? (\d+) iterations", said)
            iterations += [int(count) for time, count in flows if not time]
            steps += [int(time) for time, _ in flows if time]
            seconds += ended.cpu
            if ended.code == 0 and len(flows) == 2 and "is not found" not in said:
                continue
            failed += 1
            told = next((line for line in said.splitlines() if "not found" in line or "error" in line), ended.how)
            print(f"dam {number}: {told[:200]}")
            if given.keep:
                given.keep.mkdir(parents=True, exist_ok=True)
                (given.keep / deck.name).write_text(deck.read_text())
    print(f"iterations of a steady flow: {sum(iterations) / max(1, len(iterations)):.0f} in the mean, {max(iterations, default=0)} at the most; "
          f"steps in time: {sum(steps) / max(1, len(steps)):.0f} and {max(steps, default=0)}; {seconds:.0f} CPU s")  # fmt: skip
    print(f"{given.count - failed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
