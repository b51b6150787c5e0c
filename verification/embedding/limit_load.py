#!/usr/bin/env python3
"""A host that changes the load from results: the load that a block carries, by bisection.

Every trial starts from the same state in memory; a trial that finds no equilibrium is taken back.
"""
import pathlib
import sys

import qsmpm

HERE = pathlib.Path(__file__).resolve().parent


def limit_load(run: qsmpm.Simulation, low: float, high: float, accuracy: float) -> float:
    """Load between `low`, which is carried, and `high`, which is not."""
    trial = 0
    run.checkpoint()
    while high - low > accuracy * high:
        load = 0.5 * (low + high)
        trial += 1
        try:
            run.add_stage(f"trial {trial}", steps=2)
            run.set_traction("top", (0.0, load))
            run.run()
        except qsmpm.NotConvergedError:
            high = load
        else:
            low = load
        run.restore_checkpoint()
    return low


if __name__ == "__main__":
    with qsmpm.Simulation(HERE / "pull.inp") as analysis:
        analysis.run()
        found = limit_load(analysis, 1.0, 20.0, 1e-3)
    print(f"limit load {found:.6f}, exact 10")
    sys.exit(0)
