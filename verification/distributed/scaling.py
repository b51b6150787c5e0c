#!/usr/bin/env python3
"""Wall and CPU seconds, memory, sweeps and imbalance of runs on more and more ranks: one scene for all of them, and one
that grows with them.

    scaling.py [--ranks 1 2] [--cells 26] [--load 5.6] [--limit 300] [--json build/scaling.json] [--program build/qsmpm-mpi]

The scene is a vertical cut in space, CELLS cells a metre and eight points a cell, whose weight grows until it yields
widely, short of where it fails. `strong` runs it on all numbers of ranks, `weak` with as many metres
of it as there are ranks. Prints a table; cost_model.py draws what the file holds. Where ranks outnumber the cores they
wait for each other, and the seconds say nothing.
"""
from __future__ import annotations

import argparse
import json
import os
import pathlib
import re
import resource
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict, dataclass

TOP = pathlib.Path(__file__).resolve().parents[2]
DECK = """*HEADING
A cut of 1 m, {metres} m long, under more and more weight.
*UNITS, LENGTH=m, FORCE=kN
*MODEL, TYPE=3D
*GRID, ELEMENT=HEX8
X, 0, 1.5, {across}
Y, 0, 1, {cells}
Z, 0, {metres}, {along}
*NSET, NSET=base, PLANE=Y
0
*NSET, NSET=left, PLANE=X
0
*NSET, NSET=front, PLANE=Z
0
*NSET, NSET=back, PLANE=Z
{metres}
*MATERIAL, NAME=soil
*ELASTIC
1000, 0.3
*MOHR COULOMB
1, 25, 0
*UNIT WEIGHT
1
*BODY, NAME=cut, MATERIAL=soil, SHAPE=BOX
0, 1, 0, 1, 0, {metres}
*POINTS, BODY=cut, PER ELEMENT=8
*METHOD, BASIS=STANDARD, INTEGRATION=POINTS, KINEMATICS=LOGARITHMIC
*SOLVER, TYPE={solver}
*FIELD, VTK=NO
*PHASE, NAME=weight, LOAD FACTOR={load}
*FIX
base, ALL
left, X
front, Z
back, Z
*GRAVITY
0, -1, 0
*CONTROLS, STEPS=4, NEWTON=FULL, TOLERANCE=1E-4, STABILISATION SHARE=1
*END PHASE
"""


@dataclass(frozen=True)
class Result:
    """How a run went."""

    kind: str
    scene: str
    ranks: int
    points: int
    exit_code: int
    wall_seconds: float
    cpu_seconds: float
    megabytes: float
    """Largest memory of a rank."""
    iterations: int
    sweeps: int
    imbalance: float


def run(kind: str, program: pathlib.Path, cells: int, metres: int, ranks: int, load: float, solver: str, limit: float) -> Result:
    """Run the scene on so many ranks."""
    deck = DECK.format(cells=cells, across=round(1.5 * cells), metres=metres, along=cells * metres, solver=solver, load=load)
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "OMPI_ALLOW_RUN_AS_ROOT": "1",
                   "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / "cut.inp").write_text(deck)
        before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
        command = ["mpirun", "--oversubscribe", "-n", str(ranks), program, "run", folder / "cut.inp", "--out", folder / "run", "--quiet"]
        try:
            code = subprocess.run(command, capture_output=True, env=environment, timeout=limit).returncode
        except subprocess.TimeoutExpired:
            code = -1
        wall, after = time.perf_counter() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
        log = (folder / "run" / "job.log").read_text() if (folder / "run" / "job.log").is_file() else ""
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return Result(kind, f"{cells} cells a metre, {solver}", ranks, 8 * cells**3 * metres, code, wall, spent, after.ru_maxrss / 1024,
                  sum(map(int, re.findall(r"(\d+) iterations", log))), int(first(r"(\d+) sweeps", log)), first(r"imbalance (\S+)", log))


def first(pattern: str, text: str) -> float:
    """The last number that a pattern finds, 0 for none."""
    found = re.findall(pattern, text)
    return float(found[-1]) if found else 0.0


def main() -> int:
    """All runs."""
    words = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    words.add_argument("--ranks", type=int, nargs="+", default=[1, 2])
    words.add_argument("--cells", type=int, default=26, help="cells a metre; 26: 140608 points, 54756 equations")
    words.add_argument("--solver", default="PETSC")
    words.add_argument("--load", type=float, default=5.6, help="weight at the end; beyond 6.5 the cut fails")
    words.add_argument("--limit", type=float, default=300.0, help="seconds by the clock that a run may take")
    words.add_argument("--kinds", nargs="+", choices=("strong", "weak"), default=["strong", "weak"])
    words.add_argument("--json", type=pathlib.Path, default=TOP / "build" / "scaling.json")
    words.add_argument("--program", type=pathlib.Path, default=TOP / "build" / "qsmpm-mpi")
    given = words.parse_args()
    results: list[Result] = []
    print("| | points | ranks | exit | wall s | CPU s | MB a rank | iterations | sweeps | imbalance |\n" + "|---" * 10 + "|")
    for kind in given.kinds:
        for ranks in given.ranks:
            result = run(kind, given.program.resolve(), given.cells, ranks if kind == "weak" else 1, ranks, given.load, given.solver, given.limit)
            results.append(result)
            print(f"| {kind} | {result.points} | {ranks} | {result.exit_code} | {result.wall_seconds:.1f} | {result.cpu_seconds:.1f} | "
                  f"{result.megabytes:.0f} | {result.iterations} | {result.sweeps} | {result.imbalance:.2f} |", flush=True)
            given.json.write_text(json.dumps([asdict(r) for r in results], indent=1))
    return 0 if all(result.exit_code == 0 for result in results) else 1


if __name__ == "__main__":
    sys.exit(main())
