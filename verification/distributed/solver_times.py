#!/usr/bin/env python3
"""CPU seconds of the solvers on bodies in 3D, in whole runs: the table of docs/distributed.md.

    solver_times.py [--cells N ...] [--scene elastic yielding incompressible] [--solver AUTO KRYLOV PETSC] [--load F]
                    [--poisson NU ...] [--build BUILD]

Bodies of N^3 cells of HEX8, 8 points a cell: a cube that is elastic, and a cut under nearly the weight at which it
fails, in four steps, with nu = 0.3 or what is given, or 0.495. One line a run; `solver s` are the seconds of analysis, set-up or
factorisation and solves.
"""
from __future__ import annotations

import argparse
import itertools
import pathlib
import tempfile

from one_rank import cut
from support import TOP, Place

SCENES = {
    "elastic": lambda cells, poisson, load, solver: cut(cells, poisson, 2.0, 1, strength="", solver=solver, wide=1.0),
    "yielding": lambda cells, poisson, load, solver: cut(cells, poisson, load, 4, solver=solver),
    "incompressible": lambda cells, poisson, load, solver: cut(cells, 0.495, load, 4, solver=solver),
}
PARTS = ("analysis", "factorisation", "solves")


def main() -> None:
    reader = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    reader.add_argument("--cells", nargs="+", type=int, default=[14])
    reader.add_argument("--scene", nargs="+", choices=SCENES, default=list(SCENES))
    reader.add_argument("--solver", nargs="+", default=["AUTO", "KRYLOV", "PETSC"])
    reader.add_argument("--load", type=float, default=6.2, help="load factor of the cuts")
    reader.add_argument("--poisson", nargs="+", type=float, default=[0.3], help="Poisson's ratios of elastic and yielding")
    reader.add_argument("--build", type=pathlib.Path, default=TOP / "build")
    words = reader.parse_args()
    print("| body | equations | solver | in the end | iterations | sweeps | most | solver s | whole s | MB |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory(prefix="qsmpm-times-") as folder:
        place = Place(words.build.resolve(), pathlib.Path(folder))
        for scene, cells, poisson, solver in itertools.product(words.scene, words.cells, words.poisson, words.solver):
            run = place.run("qsmpm-mpi", SCENES[scene](cells, poisson, words.load, solver),
                            f"{scene}-{cells}-{poisson}-{solver.split(',')[0]}", seconds=3600)  # fmt: skip
            told = run.profile
            seconds = sum(told["parts"][part]["cpu_seconds"] for part in PARTS)
            soil = f" nu = {poisson}" if len(words.poisson) > 1 else ""
            print(f"| {scene} {cells}^3{soil} | {told['equations']} | {solver} | {told['solver']} | {told['iterations']} | "
                  f"{told['sweeps']} | {told['most_sweeps']} | {seconds:.2f} | {told['cpu_seconds']:.2f} | "
                  f"{told['peak_memory_bytes'] / 1e6:.0f} |", flush=True)  # fmt: skip


if __name__ == "__main__":
    main()
