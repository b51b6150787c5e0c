#!/usr/bin/env python3
"""Twenty factors of safety from Python in one process: a slope of 4 m at 45 degrees, cohesion and friction varied.

    verification/week/twenty_runs.py PROGRAM --out DIR

A row a run: the factor, that of the best logarithmic spiral, and after the twenty the first of them once more.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools"))

DECK = """*HEADING
A slope of 4 m at 45 degrees
*UNITS, LENGTH=m, FORCE=kN
*MODEL, TYPE=PLANE STRAIN
*GRID
X, 0, 20, 50
Y, 0, 4, 10
*NSET, NSET=base, PLANE=Y
0
*NSET, NSET=left, PLANE=X
0
*NSET, NSET=right, PLANE=X
20
*MATERIAL, NAME=soil
*ELASTIC
20000, 0.3
*MOHR COULOMB
{cohesion}, {friction}, {friction}
*UNIT WEIGHT
18
*BODY, NAME=slope, MATERIAL=soil, SHAPE=POLYGON
0, 0
14, 0
10, 4
0, 4
*HISTORY, NAME=crest, QUANTITY=DISPLACEMENT, COMPONENT=Y
10, 4
*PHASE, NAME=weight
*FIX
base, ALL
left, X
right, X
*GRAVITY
0, -1
*CONTROLS, STEPS=3
*END PHASE
*PHASE, NAME=factor, TYPE=SAFETY
*END PHASE
"""


def factor(cohesion: float, friction: float) -> float:
    """The last stable factor of one slope."""
    import qsmpm

    with qsmpm.Simulation(text=DECK.format(cohesion=cohesion, friction=friction)) as run:
        run.run()
        found = run.phase_results[-1].factor_of_safety
    assert found is not None
    return float(found[0])


def main() -> int:
    """Run them and write curves.csv."""
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("program", type=Path)
    words.add_argument("--out", type=Path, required=True)
    asked = words.parse_args()
    os.environ.setdefault("QSMPM_LIBRARY", str(asked.program.parent / "libqsmpm.so"))
    from qsmpm_verify.reference import REFERENCES

    started = time.process_time()
    soils = [(cohesion, friction) for cohesion in (6.0, 8.0, 10.0, 12.0, 14.0) for friction in (18.0, 22.0, 26.0, 30.0)]
    found = [factor(*soil) for soil in [*soils, soils[0]]]
    seconds = time.process_time() - started
    spiral = REFERENCES["slope_spiral_safety"]
    hand = [spiral(unit_weight=18.0, cohesion=c, friction=f, angle=45.0, height=4.0) for c, f in soils]
    asked.out.mkdir(parents=True, exist_ok=True)
    rows = [f"1,{i + 1},{i + 1},{f:.17g},{h:.17g},{f / h - 1:.17g},0" for i, (f, h) in enumerate(zip(found, hand))]
    rows.append(f"2,21,21,{found[-1]:.17g},{hand[0]:.17g},{found[-1] / hand[0] - 1:.17g},{found[-1] - found[0]:.17g}")
    head = "phase,step,load_factor,factor [-],spiral [-],above [-],again [-]"
    (asked.out / "curves.csv").write_text("\n".join([head, *rows]) + "\n", encoding="utf-8")
    (asked.out / "timing.json").write_text(json.dumps({"cpu_seconds": seconds, "wall_seconds": seconds}) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
