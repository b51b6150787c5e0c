#!/usr/bin/env python3
"""What a run on many ranks costs, estimated: points, equations, memory and seconds of an iteration, up to 1e9 points.

    cost_model.py                              the table of docs/distributed.md
    cost_model.py --scaling build/scaling.json --figure docs/figures/distributed.svg
                                               what scaling.py measured, drawn beside the model of this machine

A body fills its cells, eight points a hexahedron; the cells of a rank are a cube. It computes those and a ring of copies,
so that its share of the work is (s + 2w)^3/s^3 with s cells along a side and a ring of w. The seconds of a point and of an
equation are those measured on one core of the machine of docs/distributed.md, those of a message are of an ordinary
cluster: 10 us and 5 GB/s. Not in it: points spread unevenly over ranks, cores that share their memory, a coarse grid of
the multigrid that no longer fits many ranks, and the grid of all cells that every rank lays while a model is built. Where
a model is built whole (docs/distributed.md, limits) every rank needs 600 bytes for each of all points besides.
"""
from __future__ import annotations

import argparse
import json
import pathlib
from dataclasses import dataclass
from typing import Any

POINTS_A_CELL = 8
BYTES_OF_POINT = 600.0
"""docs/performance.md: memory of a run over its points."""
BYTES_OF_ENTRY = 12.0
"""A value of eight bytes and the number of its column."""
MATRICES = 2.5
"""The matrix, its copy in PETSc and the coarser ones of the multigrid, in matrices."""
VECTORS = 30
"""Vectors of FGMRES and its levels."""
SECONDS_OF_EQUATION = 42e-6
"""Set-up of GAMG and 14 sweeps to 1e-8 for a row of 75 entries (`*SOLVER, TYPE=PETSC`, docs/distributed.md)."""
ENTRIES_MEASURED = 75
SWEEPS = 14
EXCHANGES = 6
"""Products of a sweep on the finest level: the smoother before and after, the residual, the Krylov method."""
LEVELS = 6
LATENCY, REDUCTION, BANDWIDTH = 10e-6, 30e-6, 5e9
ITERATIONS = 500
CARRIED = 0.3
"""Cells that points move through a face in a step."""


@dataclass(frozen=True)
class Basis:
    """Functions of a body in space: cells that a ring needs, and that a row reaches over; its entries; microseconds of a point."""

    name: str
    ring: int
    reach: int
    entries: int
    point: float


BASES = (Basis("HEX8", 1, 1, 75, 0.6), Basis("SPLINE2", 1, 2, 316, 2.0))
"""Rings of bodies without surfaces that are integrated at their points: half the degree, rounded up (src/distribution/division.f90)."""


@dataclass(frozen=True)
class Estimate:
    """One rank's part of a run."""

    basis: Basis
    points: float
    ranks: float

    @property
    def own(self) -> float:
        """Points of the rank."""
        return self.points / self.ranks

    @property
    def side(self) -> float:
        """Cells along a side of its cube."""
        return float((self.own / POINTS_A_CELL) ** (1 / 3))

    @property
    def ring(self) -> float:
        """Cells of the ring over own cells; none on one rank."""
        return ((self.side + 2 * self.basis.ring) ** 3 - self.side**3) / self.side**3 if self.ranks > 1 else 0.0

    @property
    def equations(self) -> float:
        """Three a node, as many nodes as cells."""
        return 3 * self.own / POINTS_A_CELL

    @property
    def memory(self) -> float:
        """Bytes of the rank."""
        matrix = self.equations * self.basis.entries * BYTES_OF_ENTRY * MATRICES
        return self.own * (1 + self.ring) * BYTES_OF_POINT + matrix + self.equations * 8 * VECTORS

    @property
    def laws(self) -> float:
        """Seconds of an iteration at the points, copies too; two evaluations, one with the tangent."""
        return 2 * self.own * (1 + self.ring) * self.basis.point * 1e-6

    @property
    def solver(self) -> float:
        """Seconds of an iteration in the equations."""
        return self.equations * SECONDS_OF_EQUATION * self.basis.entries / ENTRIES_MEASURED

    @property
    def messages(self) -> float:
        """Seconds of an iteration for what ranks tell each other."""
        if self.ranks == 1:
            return 0.0
        halo = ((self.side + 2 * self.basis.reach) ** 3 - self.side**3) * 3 * 8
        return SWEEPS * EXCHANGES * (1.4 * halo / BANDWIDTH + LEVELS * LATENCY) + SWEEPS * 3 * REDUCTION

    @property
    def seconds(self) -> float:
        """Of an iteration."""
        return self.laws + self.solver + self.messages

    @property
    def migrated(self) -> float:
        """Bytes that leave a rank in a step through one face."""
        return CARRIED * POINTS_A_CELL * self.side**2 * BYTES_OF_POINT


def table() -> str:
    """The table of the page."""
    rows = ["| body | points | ranks | points a rank | equations a rank | GB a rank | GB in all | ring/own | "
            "laws, solver, messages of an iteration [s] | MB migrated a step | hours of 500 iterations |", "|---" * 11 + "|"]
    for basis in BASES:
        for points, ranks in ((1e6, 1), (1e7, 100), (1e8, 100), (1e9, 1e4), (1e9, 1e3)):
            e = Estimate(basis, points, ranks)
            rows.append(f"| {basis.name} | {points:.0e} | {ranks:.0f} | {e.own:.0e} | {e.equations:.1e} | {e.memory / 1e9:.2f} | "
                        f"{e.memory * ranks / 1e9:.0f} | {e.ring:.2f} | {e.laws:.2f}, {e.solver:.2f}, {e.messages:.3f} | "
                        f"{e.migrated / 1e6:.2f} | {ITERATIONS * e.seconds / 3600:.2f} |")
    return "\n".join(rows)


def draw(measured: pathlib.Path, figure: pathlib.Path) -> None:
    """Wall seconds over ranks: what was measured, and one rank's seconds by the share of work that the estimate gives."""
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    plt.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "qsmpm"})
    runs = json.loads(measured.read_text())
    picture, (left, right) = plt.subplots(1, 2, figsize=(9, 3.6))
    for axes, kind, title in ((left, "strong", "one scene"), (right, "weak", "as many points a rank")):
        rows = [run for run in runs if run["kind"] == kind]
        for name in sorted({run["scene"] for run in rows}):
            mine = in_order(rows, name)
            ranks = [r["ranks"] for r in mine]
            axes.plot(ranks, [r["wall_seconds"] for r in mine], "o-", label=name)
            alone = mine[0]["wall_seconds"]
            work = [Estimate(BASES[0], r["points"], r["ranks"]) for r in mine]
            axes.plot(ranks, [alone * e.seconds / work[0].seconds for e in work], "k:", lw=1, label="estimate")
        axes.set(xlabel="ranks", ylabel="seconds by the clock", title=title)
    beside = [run for run in runs if run["kind"] == "beside"]
    for name in sorted({run["scene"] for run in beside}):
        mine = in_order(beside, name)
        right.plot([r["ranks"] for r in mine], [r["wall_seconds"] for r in mine], "x--", label="runs of one rank, side by side")
    for axes in (left, right):
        axes.set_xticks(sorted({run["ranks"] for run in runs}))
        axes.set_ylim(bottom=0.0)
        axes.legend(fontsize=7)
    picture.tight_layout()
    picture.savefig(figure, metadata={"Date": None})


def in_order(runs: list[dict[str, Any]], scene: str) -> list[dict[str, Any]]:
    """The runs of a scene by their ranks."""
    return sorted((run for run in runs if run["scene"] == scene), key=lambda run: int(run["ranks"]))


def main() -> None:
    """Table, or figure."""
    words = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    words.add_argument("--scaling", type=pathlib.Path, help="what scaling.py wrote")
    words.add_argument("--figure", type=pathlib.Path, help="SVG to write")
    given = words.parse_args()
    if given.scaling and given.figure:
        draw(given.scaling, given.figure)
    else:
        print(table())


if __name__ == "__main__":
    main()
