#!/usr/bin/env python3
"""Seconds, memory, sweeps and imbalance of runs on more and more ranks: one scene for all of them, one that grows with
them, and what the machine itself loses when as many cores work.

    scaling.py [--ranks 1 2] [--cells 26] [--load 5.6] [--repeat 3] [--kinds strong weak beside] [--limit 300]
               [--json build/scaling.json] [--program build/qsmpm-mpi] [--judge]

On a machine with eight cores or more `scaling.py --judge --kinds weak --cells 20 --ranks 1 8` is the test of weak scaling:
from the fewest to the most ranks, each with as many points, the seconds by the clock grow by no more than half, the sweeps
of the hardest correction by no more than three, the memory of a rank by no more than a fifth either way, and no part has
more than 1.25 times the mean of points. Exit code 1 where one of them does.

The scene is a vertical cut in space, CELLS cells a metre and eight points a cell, whose weight grows until it yields
widely, short of where it fails. `strong` runs it on all numbers of ranks, `weak` with as many metres of it as there are
ranks, and `beside` runs the scene of one rank so many times at once, each by itself: cores share their memory, and what
that costs is not the ranks' fault. Of repeated runs the one that took least by the clock counts. On one
rank the three are one run.

Prints a table; cost_model.py draws what the file holds. Seconds of the parts are those by the clock on the first rank:
`begin` is reading, building and starting the model, which every rank does for all of it, `points` evaluation and
assembly, `set-up` the matrix and its multigrid, `solves` the solutions, `sharing` points that move and migrate, `rest`
results, control and mpirun. CPU seconds of `beside` are those of one of the runs. Where ranks outnumber the cores they
wait for each other, and the seconds say nothing.
"""
from __future__ import annotations

import argparse
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict, dataclass, field, replace

from support import ENVIRONMENT, TOP, run_limited

PARTS = {"begin": ("input", "initialisation"), "points": ("evaluation", "assembly"), "set-up": ("analysis", "factorisation"),
         "solves": ("solves",), "sharing": ("convection",)}
"""Columns of the table, in parts of the profile."""
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
    """Largest memory of a rank, as the first one tells it."""
    iterations: int
    sweeps: int
    most_sweeps: int
    """Of one correction."""
    imbalance: float
    """Own points of the largest part over their mean, when the model was shared."""
    copies: float
    """Copies of a point."""
    parts: dict[str, float] = field(default_factory=dict)
    """Seconds by the clock on the first rank, by the names of PARTS, and the rest."""


@dataclass(frozen=True)
class Bench:
    """What all runs have in common."""

    program: pathlib.Path
    cells: int
    load: float
    solver: str
    limit: float

    def deck(self, metres: int) -> str:
        """The scene, so many metres long."""
        return DECK.format(cells=self.cells, across=round(1.5 * self.cells), metres=metres, along=self.cells * metres, solver=self.solver,
                           load=self.load)  # fmt: skip

    def run(self, kind: str, metres: int, ranks: int, beside: int = 1) -> Result:
        """The scene on so many ranks, once, or so many times at once; then the slowest of them."""
        with tempfile.TemporaryDirectory(prefix="qsmpm-scaling-") as name:
            folder = pathlib.Path(name)
            (folder / "cut.inp").write_text(self.deck(metres))
            # Bound to cores, runs side by side would share the first one.
            words = ["mpirun", "--bind-to", "none", "-n", str(ranks), str(self.program), "run", str(folder / "cut.inp"), "--quiet",
                     "--profile", "--out"]  # fmt: skip
            others = [subprocess.Popen([*words, str(folder / f"other-{i}")], env=ENVIRONMENT, stdout=subprocess.DEVNULL,
                                       stderr=subprocess.DEVNULL) for i in range(1, beside)]  # fmt: skip
            began = time.perf_counter()
            done = run_limited([*words, folder / "run"], self.limit * 2, folder, ENVIRONMENT, wall=self.limit)
            codes = [other.wait(self.limit) for other in others]
            wall = time.perf_counter() - began
            bad = next((code for code in codes if code != 0), -1 if done.code is None else done.code)
            return self.told(kind, folder / "run", metres, ranks * beside, bad, wall, done.cpu)

    def told(self, kind: str, folder: pathlib.Path, metres: int, ranks: int, code: int, wall: float, cpu: float) -> Result:
        """What log and profile of a run say."""
        log, path = folder / "job.log", folder / "profile.json"
        profile = json.loads(path.read_text()) if path.is_file() else {}
        shared = re.search(r"imbalance (\S+) of their points, (\S+) copies of a point", log.read_text() if log.is_file() else "")
        parts = {name: sum(profile["parts"][p]["wall_seconds"] for p in of) for name, of in PARTS.items()} if profile else {}
        parts["rest"] = wall - sum(parts.values())
        return Result(kind, f"{self.cells} cells a metre, {self.solver}", ranks, 8 * self.cells**3 * metres, code, wall, cpu,
                      profile.get("peak_memory_bytes", 0) / 1e6, profile.get("iterations", 0), profile.get("sweeps", 0),
                      profile.get("most_sweeps", 0), float(shared[1]) if shared else 1.0, float(shared[2]) if shared else 0.0, parts)  # fmt: skip


def row(result: Result) -> str:
    """A line of the table."""
    figures = " | ".join(f"{result.parts.get(name, 0.0):.1f}" for name in (*PARTS, "rest"))
    return (f"| {result.kind} | {result.points} | {result.ranks} | {result.exit_code} | {result.wall_seconds:.1f} | {result.cpu_seconds:.1f} | "
            f"{figures} | {result.megabytes:.0f} | {result.iterations} | {result.sweeps} | {result.imbalance:.2f} | {result.copies:.2f} |")


def judge(results: list[Result]) -> list[str]:
    """What is wrong with weak scaling, from the fewest ranks to the most."""
    weak = sorted((r for r in results if r.kind == "weak"), key=lambda r: r.ranks)
    if len(weak) < 2:
        return ["no weak scaling to judge: two numbers of ranks at least"]
    one, many = weak[0], weak[-1]
    wrong = [f"{r.ranks} ranks ended with {r.exit_code}" for r in weak if r.exit_code != 0]
    for name, figure, low, high in (
            ("seconds by the clock", many.wall_seconds / one.wall_seconds, 0.0, 1.5),
            ("sweeps of a correction, more", many.most_sweeps - one.most_sweeps, -3.0, 3.0),
            ("memory of a rank", many.megabytes / one.megabytes if one.megabytes else 0.0, 0.8, 1.2),
            ("imbalance of points", many.imbalance, 1.0, 1.25)):  # fmt: skip
        told = f"{name}: {figure:.2f} on {many.ranks} ranks against {one.ranks}, from {low} to {high}"
        print(told)
        if not low <= figure <= high:
            wrong.append(told)
    return wrong


def main() -> int:
    """All runs."""
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--ranks", type=int, nargs="+", default=[1, 2])
    words.add_argument("--cells", type=int, default=26, help="cells a metre; 26: 140608 points, 54756 equations")
    words.add_argument("--solver", default="PETSC")
    words.add_argument("--load", type=float, default=5.6, help="weight at the end; beyond 6.5 the cut fails")
    words.add_argument("--repeat", type=int, default=1, help="runs of each kind, of which the quickest counts")
    words.add_argument("--limit", type=float, default=300.0, help="seconds by the clock that a run may take")
    words.add_argument("--kinds", nargs="+", choices=("strong", "weak", "beside"), default=["strong", "weak", "beside"])
    words.add_argument("--json", type=pathlib.Path, default=TOP / "build" / "scaling.json")
    words.add_argument("--program", type=pathlib.Path, default=TOP / "build" / "qsmpm-mpi")
    words.add_argument("--judge", action="store_true", help="judge weak scaling by its limits")
    given = words.parse_args()
    bench = Bench(given.program.resolve(), given.cells, given.load, given.solver, given.limit)
    results: list[Result] = []
    known: dict[tuple[int, int, int], Result] = {}
    names = ["", "points", "ranks", "exit", "wall s", "CPU s", *PARTS, "rest", "MB a rank", "iterations", "sweeps", "imbalance", "copies"]
    print(f"| {' | '.join(names)} |\n" + "|---" * len(names) + "|")
    for kind in given.kinds:
        for ranks in given.ranks:
            shape = {"strong": (1, ranks, 1), "weak": (ranks, ranks, 1), "beside": (1, 1, ranks)}[kind]
            if shape not in known:
                known[shape] = min((bench.run(kind, *shape) for _ in range(given.repeat)), key=lambda r: (r.exit_code != 0, r.wall_seconds))
            results.append(replace(known[shape], kind=kind))
            print(row(results[-1]), flush=True)
            given.json.write_text(json.dumps([asdict(r) for r in results], indent=1))
    wrong = judge(results) if given.judge else []
    for sentence in wrong:
        print(f"FAILED {sentence}")
    return 1 if wrong or any(result.exit_code != 0 for result in results) else 0


if __name__ == "__main__":
    sys.exit(main())
