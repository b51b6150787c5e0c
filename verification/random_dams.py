#!/usr/bin/env python3
"""Random dams that water flows through: is the flow found, steady and as the lake falls? And random quay walls in ground that consolidates.

    verification/random_dams.py [--scene dam|quay] [--count 100] [--seed 5] [--program build/qsmpm] [--keep DIR]

Heights of 4 to 20 m, slopes of 1:1.2 to 1:3, half of them with a core of 1e-1 to 1e-6 of the shells, levels of 30 to 100 % of the height, a toe drain in a
third, 5 to 12 cells a height; the lake falls by a share of its depth within 0.01 to 10 times H n/k. A flow is found where the program says neither
that it is not, nor that it took more suction than was meant.

Quays are `verification/cases/decks/consolidation_quay.inp` with other strengths, permeabilities, times, levels before and behind, walls and cells: the
run comes to its end, a wall whose water in front falls leans to it, and one whose levels stay moves by 5 mm at the most. Closes with `N passed, N failed`.
"""

from __future__ import annotations

import argparse
import csv
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


def with_curves(deck: str, number: int, seed: int) -> str:
    """The same of soils that hold water by curves of their own."""
    chance = random.Random(f"curves {seed} {number}")
    return re.sub(
        r"(DRAINABLE POROSITY=[\d.]+)", lambda found: f"{found[1]}, ALPHA={10.0 ** chance.uniform(-0.7, 0.9):.4g}, N={chance.uniform(1.1, 4.0):.4g}", deck,
    )  # fmt: skip


def quay(number: int, seed: int) -> tuple[str, float, float]:
    """A quay by its number, and how far its head may move along x at the least and the most."""
    chance = random.Random(f"{seed} {number}")
    before, wide = chance.choice([0.0, 1.0, 2.0]), chance.choice([1.0, 1.5, 2.0])
    front, behind = before + chance.choice([0.0, -1.0, -1.5, 0.5]), before + chance.choice([0.0, 0.5, -1.0])
    columns, rows = chance.choice([(20, 8), (26, 10), (40, 16)])
    text = (TOP / "verification/cases/decks/consolidation_quay.inp").read_text()
    for old, new in (
        ("\n1, 33, 3\n", f"\n{chance.choice([1, 3, 5, 8])}, {chance.choice([28, 30, 33, 36])}, 3\n"),
        ("\n0, 1\n*END", f"\n0, {before}\n*END"), ("lake, 1\n", f"lake, {front}\n"), ("right, 1\n", f"right, {behind}\n"),
        ("TIME=20", f"TIME={chance.choice([1, 20, 500])}"), ("X, 0, 40, 20\nY, -12, 4, 8", f"X, 0, 40, {columns}\nY, -12, 4, {rows}"),
        ("POROSITY=0.2\n1\n", f"POROSITY=0.2\n{chance.choice([1, 1e-2, 1e-4])}\n"),
        ("POROSITY=0.05\n1e-3\n", f"POROSITY=0.05\n{chance.choice([1e-3, 1e-5, 1e-7])}\n"), ("18, 19, -6, 3", f"18, {18 + wide}, -6, 3"),
        ("\n19, 40, -6, 0", f"\n{18 + wide}, 40, -6, 0"), ("\n19, 40, 0, 3", f"\n{18 + wide}, 40, 0, 3"),
    ):  # fmt: skip
        if old not in text:
            raise SystemExit(f"consolidation_quay.inp has no {old!r} any more")
        text = text.replace(old, new)
    still = front == before == behind
    return text, -5e-3 if still else -1.0, 5e-3 if still else 0.0 if front < before <= behind else 1.0


def moved(folder: pathlib.Path) -> float:
    """How far the head of a quay has moved."""
    with (folder / "curves.csv").open() as stream:
        return float(list(csv.DictReader(stream))[-1]["head [m]"])


def run_quays(given: argparse.Namespace) -> int:
    """Run quays; the number of those that fail."""
    failed, seconds = 0, 0.0
    with tempfile.TemporaryDirectory() as name:
        for number in range(given.count):
            folder = pathlib.Path(name) / str(number)
            folder.mkdir()
            deck = folder / f"quay_{number}.inp"
            text, least, most = quay(number, given.seed)
            text = with_curves(text, number, given.seed) if given.curves else text
            deck.write_text(text)
            ended = run_limited([given.program.resolve(), "run", deck, "--out", folder / "out", "--quiet"], SECONDS, folder)
            seconds += ended.cpu
            if ended.code == 0 and least <= moved(folder / "out") <= most:
                continue
            failed += 1
            print(f"quay {number}: {ended.how}; {moved(folder / 'out') if ended.code == 0 else (ended.output + ended.errors)[-300:]}")
            if given.keep:
                given.keep.mkdir(parents=True, exist_ok=True)
                (given.keep / deck.name).write_text(text)
    print(f"{seconds:.0f} CPU s")
    return failed


def main() -> int:
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--scene", choices=["dam", "quay"], default="dam")
    words.add_argument("--count", type=int, default=100)
    words.add_argument("--seed", type=int, default=5)
    words.add_argument("--curves", action="store_true", help="soils with ALPHA and N")
    words.add_argument("--program", type=pathlib.Path, default=TOP / "build/qsmpm")
    words.add_argument("--keep", type=pathlib.Path, help="folder for the decks whose flow is not found")
    given = words.parse_args()
    if given.scene == "quay":
        failed = run_quays(given)
        print(f"{given.count - failed} passed, {failed} failed")
        return 1 if failed else 0
    failed, iterations, steps, seconds = 0, [], [], 0.0
    with tempfile.TemporaryDirectory() as folder:
        for number in range(given.count):
            deck = pathlib.Path(folder) / f"dam_{number}.inp"
            text = dam(number, given.seed)
            deck.write_text(with_curves(text, number, given.seed) if given.curves else text)
            ended = run_limited([given.program.resolve(), "check", deck], SECONDS, pathlib.Path(folder))
            said = ended.output + ended.errors
            flows = re.findall(r"triangles,(?: at the end of the phase, after (\d+) steps in time,)? (\d+) iterations", said)
            iterations += [int(count) for time, count in flows if not time]
            steps += [int(time) for time, _ in flows if time]
            seconds += ended.cpu
            if ended.code == 0 and len(flows) == 2 and "does not converge" not in said:
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
