"""Comparison of two versions of the program, such as before and after a change: the same decks, run alternately."""

from __future__ import annotations

from qsmpm_bench.blocks import METHODS
from qsmpm_bench.context import Bench
from qsmpm_bench.decks import NO_HOLD, block, first_steps, scene
from qsmpm_bench.measure import BenchError, Deck
from qsmpm_bench.tables import Result, Table

#: Splines in space, by the methods of `kernels`.
SPLINES = ("SPLINE2 POINTS", "SPLINE2 CELL", "SPLINE2G POINTS", "SPLINE2G CELL", "SPLINE3 CELL")


def compared(bench: Bench) -> list[Deck]:
    """Decks of the comparison: plane bodies, a slice in 3D, splines in 3D."""
    if bench.quick:
        return [scene("oedometer"), block("splines in 3D, SPLINE2 CELL", "3D", 3, 27, METHODS["SPLINE2 CELL"], 2)]
    return [scene("slope, grid", NO_HOLD, file="slope_grid.inp"),
            scene("slope, coarse wedge 15", NO_HOLD, file="slope_e200_coarse.inp"),
            first_steps("slope, 6-node triangles", "slope_e50_plane.inp", 30), scene("footing"),
            scene("cantilever", file="cantilever_paper.inp"),
            first_steps("3D slice, one layer", "slope_e200_fine.inp", 10),
            *(block(f"splines in 3D, {name}", "3D", 6, 27, METHODS[name], 5) for name in SPLINES)]


def against(bench: Bench) -> Result:
    """CPU seconds of another program over those of this one, the minimum of the runs of each."""
    if bench.against is None:
        raise BenchError("against requires --against PROGRAM, the program to compare with")
    samples = bench.times_against(compared(bench))
    table = Table("against", ["scene", "equations", "iterations", "of the other", "CPU s", "of the other", "times as fast",
                              "evaluation s", "of the other", "times as fast"],
                  title="This program and another one, alternately",
                  note="CPU seconds are the minimum of the runs of each program.")
    for deck in compared(bench):
        mine, other = samples[deck.name], samples[f"{deck.name} against"]
        least = [min(run.cpu for run in runs) for runs in (mine, other)]
        evaluation = [min(run.figures["parts"]["evaluation"]["cpu_seconds"] for run in runs) for runs in (mine, other)]
        table.add(deck.name, mine[0].figures["equations"], mine[0].figures["iterations"], other[0].figures.get("iterations"),
                  *least, least[1] / least[0], *evaluation, evaluation[1] / evaluation[0])
    return Result("against", [table])
