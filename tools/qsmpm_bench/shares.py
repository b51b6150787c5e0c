"""Studies on the decks of the tree: distribution of the CPU time, threads, the smallest model of a scene, linear solvers."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np

from qsmpm_bench import charts
from qsmpm_bench.blocks import STANDARD, factor_rate
from qsmpm_bench.context import Bench
from qsmpm_bench.decks import INPUT, NO_HOLD, block, first_steps, scene
from qsmpm_bench.machine import blas_of, dgemm_rate
from qsmpm_bench.measure import BenchError, Deck, Sample, Spread, cpu, interleave, memory_mib
from qsmpm_bench.tables import Result, Table
from qsmpm_verify.results import Curves, read_curves

PARTS = ["input", "initialisation", "analysis", "evaluation", "assembly", "factorisation", "solves", "step error",
         "convection", "output", "control"]
SLICE = "3D slice, three layers, factors in double"
EVERY_FACTOR = ("*METHOD,", "*SOLVER, PRECISION=DOUBLE, KEEP FACTOR=NO\n*METHOD,")
#: Layers of the slices; the plane of the fine one has 9579 nodes in three.
THREE_LAYERS = ("Z, 0, 0.07142857143, 1", "Z, 0, 0.07142857143, 3")


def scenes(bench: Bench) -> list[Deck]:
    """Decks whose CPU time is divided into parts; the last is the slice in 3D."""
    if bench.quick:
        return [scene("oedometer"), first_steps("slope, grid", "slope_grid.inp", 4),
                first_steps(SLICE, "slope_e200_coarse.inp", 2, ("Z, 0, 0.25, 1", "Z, 0, 0.25, 3"))]
    return [scene("cantilever", file="cantilever_paper.inp"), scene("slope, grid", NO_HOLD, file="slope_grid.inp"),
            scene("slope, coarse wedge 15", NO_HOLD, file="slope_e200_coarse.inp"), scene("footing"),
            first_steps("3D slice, one layer", "slope_e200_fine.inp", 20),
            first_steps("3D slice, three layers", "slope_e200_fine.inp", 5, THREE_LAYERS),
            first_steps(SLICE, "slope_e200_fine.inp", 5, THREE_LAYERS, EVERY_FACTOR)]


def parts(bench: Bench) -> Result:
    """Share of the CPU seconds for each part; in 3D the rate of the factorisation compared with the matrix product of the machine."""
    decks = scenes(bench)
    samples = bench.times_against(decks)
    table = Table("shares", ["scene", "points", "equations", "solver", "iterations", "evaluations", "CPU s",
                             *[f"{part} %" for part in PARTS]],
                  title="Share of the CPU seconds for each part",
                  note="Medians. The parts are those of `qsmpm run --profile`: analysis is the numbering of the "
                       "equations, their order and the symbolic factorisation; step error measures the error of a "
                       "step if the deck requests it; control is the remainder of a step.")
    if bench.against:
        table.columns.append("CPU s of the other / CPU s")
    bars: dict[str, list[float]] = {part: [] for part in PARTS}
    for deck in decks:
        runs = samples[deck.name]
        figures = runs[0].figures
        shares = [Spread.of(share(run, part) for run in runs).median for part in PARTS]
        row = [deck.name, figures["points"], figures["equations"], figures["solver"], figures["iterations"],
               figures["evaluations"], cpu(runs), *[f"{100 * value:.1f}" for value in shares]]
        if bench.against:
            row.append(cpu(samples[f"{deck.name} against"]).median / cpu(runs).median)
        table.add(*row)
        for part, value in zip(PARTS, shares):
            bars[part].append(100 * value)
    if bench.figures:
        charts.stacked(bench.figures / "bench_parts.svg", [deck.name for deck in decks], bars, "% of CPU seconds")
    return Result("parts", [table, factor_table(bench, samples[SLICE])], [solving_remark(samples[SLICE])])


def share(run: Sample, part: str) -> float:
    """Share of a part in the CPU seconds of the run."""
    return run.figures["parts"][part]["cpu_seconds"] / run.figures["cpu_seconds"]


def factor_table(bench: Bench, runs: list[Sample]) -> Table:
    """Rate of the factorisation of the slice compared with dgemm, both with one thread, one after the other."""
    rates = Spread.of(factor_rate(run) for run in runs)
    product = Spread.of(dgemm_rate(blas_of(bench.program)) for _ in range(3))
    figures = runs[0].figures
    if bench.figures:
        charts.bars(bench.figures / "bench_factor.svg", [f"factorisation, {SLICE}", "dgemm"],
                    [rates.median, product.median], "GF/s, one thread", (0.5 * product.median, "target: half of dgemm"))
    table = Table("factor", ["equations", "entries of the factor", "operations of one", "factorisation GF/s",
                             "dgemm GF/s", "ratio", "target"],
                  title=f"{SLICE}: rate of the factorisation and of the machine's matrix product")
    table.add(figures["equations"], figures["factor_entries"],
              figures["factor_operations"] / figures["factorisations"], rates, product,
              rates.median / product.median, ">= 0.5")
    return table


def solving_remark(runs: list[Sample]) -> str:
    """The target of the slice."""
    found = Spread.of(share(run, "factorisation") + share(run, "solves") for run in runs).median
    return (f"{SLICE}: {100 * found:.0f} % of the CPU seconds in factorisation and solves, target at least 70 %: "
            f"{'met' if found >= 0.7 else 'missed'}.")


def threads(bench: Bench) -> Result:
    """One and two threads: wall-clock seconds, and whether the bytes of the results are identical."""
    decks = scenes(bench)
    if not bench.quick:
        decks += [block("block in the plane", "PLANE STRAIN", 70, 9, STANDARD, 10), block("cube", "3D", 13, 8, STANDARD, 5)]
    runs = interleave({f"{deck.name}, {count}": bench.job(deck, count) for deck in decks for count in (1, 2)}, bench.repeat, bench.tell)
    table = Table("threads", ["scene", "equations", "wall s, 1 thread", "wall s, 2 threads", "speed-up", "CPU s, 2 threads",
                              "same bytes"],
                  title="One and two threads",
                  note="Bytes: curves.csv, restart.h5 and all results files.")
    for deck in decks:
        one, two = runs[f"{deck.name}, 1"], runs[f"{deck.name}, 2"]
        first, second = (Spread.of(run.wall for run in each) for each in (one, two))
        table.add(deck.name, one[0].figures["equations"], first, second, first.median / second.median, cpu(two),
                  same_bytes(folder_of(one), folder_of(two)))
    return Result("threads", [table])


def folder_of(runs: list[Sample]) -> Path:
    """Results of the last run."""
    directory = runs[-1].directory
    if directory is None:
        raise BenchError("a run has written no results")
    return directory


def same_bytes(one: Path, other: Path) -> bool:
    """Whether two runs wrote the same results."""
    def contents(folder: Path) -> dict[str, bytes]:
        return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*"))
                if path.suffix in (".vtu", ".h5", ".pvd", ".csv")}

    return contents(one) == contents(other)


def scene_study(bench: Bench) -> Result:
    """The model selected by the program, its plane equivalent and the same slice run in 3D, in one layer and in four."""
    steps = 2 if bench.quick else 30
    auto = "slope_auto.inp"
    solid = ("TYPE=AUTO", "TYPE=3D")
    decks = [first_steps("chosen (TYPE=AUTO)", auto, steps), first_steps("plane twin", "slope_e200_plane.inp", steps),
             first_steps("3D, one layer", auto, steps, solid),
             first_steps("3D, four layers", auto, steps, solid, ("Z, 0, 0.25, 1", "Z, 0, 0.25, 4"))]
    samples = bench.times(decks)
    table = Table("scene", ["model", "points", "equations", "steps", "CPU s", "CPU s / chosen", "MiB",
                            "last load factor", "settlement there", "largest difference of the curve",
                            "the same to load factor 20"],
                  title="The same slope as four models",
                  note="Differences of the crest settlement from that of the chosen model, relative to it, row by row.")
    chosen = cpu(samples[decks[0].name]).median
    curve = read_curves(folder_of(samples[decks[0].name]))
    remarks = []
    for deck in decks:
        runs = samples[deck.name]
        other = read_curves(folder_of(runs))
        apart = [difference(curve, other, upto) for upto in (float(steps), 20.0)]
        ratio = cpu(runs).median / chosen
        table.add(deck.name, runs[0].figures["points"], runs[0].figures["equations"], runs[0].figures["steps"],
                  cpu(runs), ratio, memory_mib(runs), float(other.column("load_factor")[-1]),
                  float(other.column("crest_settlement")[-1]), *apart)
        if deck.name.startswith("3D"):
            remarks.append(f"{deck.name}: {ratio:.1f} times the CPU seconds of the chosen model, target 20: "
                           f"{'met' if ratio >= 20 else 'missed'}; curve within {100 * apart[0]:.2g} %, target 1 %: "
                           f"{'met' if apart[0] <= 0.01 else 'missed'}.")
        elif deck.name == "plane twin":
            remarks.append(f"Plane twin: curve within {apart[0]:.1g}, target 1e-6: "
                           f"{'met' if apart[0] <= 1e-6 else 'missed'}.")
    if bench.figures:
        charts.bars(bench.figures / "bench_scene.svg", [deck.name for deck in decks],
                    [cpu(samples[deck.name]).median for deck in decks], "CPU seconds to the end of the load")
    return Result("scene", [table], remarks)


def difference(one: Curves, other: Curves, upto: float) -> float:
    """Largest relative difference of two settlement curves at the load factors of the first, up to one of them."""
    factors = one.column("load_factor")
    mine = one.column("crest_settlement")
    theirs = np.interp(factors, other.column("load_factor"), other.column("crest_settlement"))
    return float(np.max(np.abs(theirs - mine)[factors <= upto] / np.abs(mine)[factors <= upto]))


def solvers(bench: Bench) -> Result:
    """Output of build/bench_solvers."""
    program = bench.program.parent / "bench_solvers"
    if not program.exists():
        return Result("solvers", remarks=["Not run: build it with `cmake --build build --target bench_solvers`."])
    command = [str(program), "3000" if bench.quick else "100000"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=3600)
    if done.returncode != 0:
        raise BenchError(f"{program.name}: exit code {done.returncode}: {done.stderr.strip()[:200]}")
    return Result("solvers", text=done.stdout)
