#!/usr/bin/env python3
"""CPU seconds of a safety phase against the same factors tried by separate runs.

    safety_cost.py QSMPM [CELLS ...]

The slope of verification/cases/decks/slope_safety.inp, psi = phi, with so many cells a height (10 and 20). `inside` is the
run with its safety phase; `apart` are runs of the first phase alone, each from nothing, with c/F and atan(tan(phi)/F) for
every F that the search tried, static steps only. Both say which factors are stable. Prints a table.
"""
from __future__ import annotations

import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile

TOP = pathlib.Path(__file__).resolve().parents[1]
DECK = TOP / "verification" / "cases" / "decks" / "slope_safety.inp"
STRENGTH = "1, 25, 25"


def run(program: str, deck: pathlib.Path, folder: pathlib.Path) -> tuple[int, float]:
    """Exit code and CPU seconds of a run."""
    code = subprocess.run([program, "run", deck, "--out", folder, "--quiet"], capture_output=True).returncode
    return code, json.loads((folder / "timing.json").read_text())["cpu_seconds"]


def lowered(factor: float) -> str:
    """Strength divided by a factor, as the deck has it."""
    angle = math.degrees(math.atan(math.tan(math.radians(25.0)) / factor))
    return f"{1 / factor!r}, {angle!r}, {angle!r}"


def tried(folder: pathlib.Path) -> list[tuple[float, bool]]:
    """Factors that a search tried, and whether they were stable."""
    head, *rows = (folder / "curves.csv").read_text().splitlines()
    column = head.split(",").index("F")
    stable = [(float(row.split(",")[column]), True) for row in rows if row.startswith("2,")]
    log = (folder / "job.log").read_text()
    return stable + [(float(hit), False) for hit in re.findall(r"no equilibrium at strength/([0-9.]+):", log)]


def compare(program: str, cells: int, folder: pathlib.Path) -> str:
    """A row of the table."""
    text = DECK.read_text().replace("X, 0, 5, 50", f"X, 0, 5, {5 * cells}").replace("Y, 0, 1, 10", f"Y, 0, 1, {cells}")
    deck = folder / "deck.inp"
    deck.write_text(text)
    _, inside = run(program, deck, folder / "inside")
    alone = text[: text.index("*PHASE, NAME=factor")].replace("STABILISATION FADE=0.1", "STABILISATION FADE=0.1, DAMPING=NO")
    apart, same = 0.0, 0
    factors = tried(folder / "inside")
    for factor, stable in factors:
        deck.write_text(alone.replace(STRENGTH, lowered(factor)))
        code, seconds = run(program, deck, folder / "apart")
        apart += seconds
        same += (code == 0) == stable
    return f"| {cells} | {len(factors)} | {inside:.2f} | {apart:.2f} | {inside / apart:.2f} | {same} |"


def main() -> None:
    """Print the table."""
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    print("| cells a height | factors tried | inside, CPU s | apart, CPU s | inside/apart | same answers |\n|---|---|---|---|---|---|")
    for cells in [int(word) for word in sys.argv[2:]] or [10, 20]:
        with tempfile.TemporaryDirectory() as folder:
            print(compare(sys.argv[1], cells, pathlib.Path(folder)), flush=True)


if __name__ == "__main__":
    main()
