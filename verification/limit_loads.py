#!/usr/bin/env python3
"""Limit loads of slopes with the whole load asked for, and with the recommended *CONTROLS: cost, knee, last load.

Usage: limit_loads.py BINARY [SLOPE...] [--jobs N]   (minutes of CPU time; runs go to output/limit_loads)

A slope is ANGLE/FRICTION in degrees, c = 1, psi = phi; the scene is verification/cases/decks/limit_load.inp with another
outline and strength. `whole` asks for 1.25 times the exact limit load in steps of a hundredth of that, as a run without
LIMIT COMPLIANCE must; `limit` is the deck's own *CONTROLS in the same steps; `long` the same in steps four times as
long. Loads are relative to the log spiral's (Chen 1975). The knee of `whole` is taken from the column `compliance` of its
curves by the rule that LIMIT COMPLIANCE follows.
"""
from __future__ import annotations

import argparse
import concurrent.futures
import csv
import json
import math
import pathlib
import re
import sys

TOP = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(TOP / "tools"))
from qsmpm_verify.cpu_limit import run_limited  # noqa: E402
from qsmpm_verify.reference.slope import slope_spiral_unit_weight  # noqa: E402

DECK = TOP / "verification/cases/decks/limit_load.inp"
FOLDER = TOP / "output/limit_loads"
SLOPES = ("45/25", "60/20", "45/20", "60/25", "75/15", "30/15", "26.565/20")
#: Load that is asked for over the exact limit load, and steps to the exact one.
BEYOND, STEPS = 1.25, 100
#: Compliance at the knee over the first one.
LIMIT = 10.0


def deck_of(angle: float, friction: float, steps: int, whole: bool) -> str:
    """The deck of a slope: its crest at x = 1, or 2 where it is flat, and three heights of ground before its toe."""
    crest, run = (2.0 if angle < 44 else 1.0), 1.0 / math.tan(math.radians(angle))
    width = math.ceil(crest + run + 3)
    cells = 20
    text = DECK.read_text(encoding="utf-8")
    changes = [
        (r"X, 0, 5, 100", f"X, 0, {width}, {width * cells}"), (r"PLANE=X\n5", f"PLANE=X\n{width}"),
        (r"1, 25, 25", f"1, {friction:g}, {friction:g}"), (r"2, 0\n1, 1", f"{crest + run:.6f}, 0\n{crest:g}, 1"),
        (r"SCALE=-1\n1, 1", f"SCALE=-1\n{crest:g}, 1"),
        (r"LOAD FACTOR=25", f"LOAD FACTOR={BEYOND * exact(angle, friction):.6f}"),
        (r"STEPS=\d+", f"STEPS={round(BEYOND * steps)}"),
        (r"SMALLEST STEP=[\d.]+", f"SMALLEST STEP={0.05 * steps / STEPS:g}"),
    ]  # fmt: skip
    if whole:
        changes += [(r" STABILISATION FADE=[\d.]+,", ""), (r" LIMIT COMPLIANCE=\d+,", "")]
    for old, new in changes:
        text, count = re.subn(old, new, text)
        if count != 1:
            sys.exit(f"{DECK}: '{old}' is in it {count} times")
    return text


def exact(angle: float, friction: float) -> float:
    """Limit load of the slope."""
    return slope_spiral_unit_weight(1.0, friction, angle, 1.0)


def knee_of(rows: list[dict[str, float]]) -> float | None:
    """Load at ten times the first compliance, log-linear between the middles of steps."""
    before = None
    last = 0.0
    for row in rows:
        here = (0.5 * (last + row["load_factor"]), math.log(max(row["compliance"], 1e-300) / LIMIT))
        if before and here[1] > 0:
            return before[0] + (here[0] - before[0]) * before[1] / (before[1] - here[1])
        before, last = here, row["load_factor"]
    return None


def run(binary: str, slope: str, way: str) -> dict[str, object]:
    """Run a slope in one way and take its figures."""
    angle, friction = (float(word) for word in slope.split("/"))
    name = f"slope_{slope.replace('/', '_')}_{way}"
    path = FOLDER / f"{name}.inp"
    path.write_text(deck_of(angle, friction, STEPS // 4 if way == "long" else STEPS, way == "whole"), encoding="utf-8")
    ended = run_limited([binary, "run", path, "--out", FOLDER / name, "--profile"], 600.0)
    if ended.code not in (0, 3):
        sys.exit(f"{name}: {ended.how}: {ended.errors}")
    with (FOLDER / name / "curves.csv").open(encoding="utf-8") as file:
        rows = [{key.split(" [")[0]: float(value) for key, value in row.items()} for row in csv.DictReader(file)]
    profile = json.loads((FOLDER / name / "profile.json").read_text(encoding="utf-8"))
    limit = FOLDER / name / "limit_load.json"
    knee = json.loads(limit.read_text(encoding="utf-8"))["knee"] if limit.exists() else knee_of(rows)
    return {"cpu": ended.cpu, "its": profile["iterations"], "code": ended.code,
            "knee": knee / exact(angle, friction) if knee else None,
            "last": rows[-1]["load_factor"] / exact(angle, friction)}  # fmt: skip


def main() -> None:
    """Run the slopes and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("binary")
    parser.add_argument("slopes", nargs="*", default=SLOPES, metavar="SLOPE")
    parser.add_argument("--jobs", type=int, default=1)
    words = parser.parse_args()
    FOLDER.mkdir(parents=True, exist_ok=True)
    print("| slope | way | CPU s | iterations | knee | last load | exit code | CPU of whole over this | knee apart |")
    print("|---|---|---|---|---|---|---|---|---|")
    with concurrent.futures.ThreadPoolExecutor(words.jobs) as pool:
        ways = [(slope, way) for slope in words.slopes for way in ("whole", "limit", "long")]
        for (slope, way), found in zip(ways, pool.map(lambda pair: run(words.binary, *pair), ways), strict=True):
            if way == "whole":
                first = found
            ratio = f"{first['cpu'] / found['cpu']:.1f}"
            apart = f"{found['knee'] / first['knee'] - 1:+.2%}" if found["knee"] and first["knee"] else "-"
            knee = f"{found['knee']:.4f}" if found["knee"] else "none"
            print(f"| {slope} | {way} | {found['cpu']:.2f} | {found['its']} | {knee} | {found['last']:.4f} "
                  f"| {found['code']} | {ratio} | {apart} |", flush=True)  # fmt: skip


if __name__ == "__main__":
    main()
