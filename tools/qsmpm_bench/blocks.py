"""Studies on blocks of soil: rates by basis, cost against size, empty cells, a million points."""

from __future__ import annotations

import subprocess

from qsmpm_bench import charts
from qsmpm_bench.context import Bench
from qsmpm_bench.decks import ELASTIC, TOP, block, scene
from qsmpm_bench.measure import Deck, Sample, Spread, cpu, fitted_exponent, memory_mib, run_deck
from qsmpm_bench.tables import Result, Table

STANDARD = "BASIS=STANDARD, INTEGRATION=POINTS"
METHODS = {
    "STANDARD POINTS": STANDARD,
    "STANDARD CELL": "BASIS=STANDARD, INTEGRATION=CELL",
    "GIMP POINTS": "BASIS=GIMP, INTEGRATION=POINTS",
    "GIMP CELL": "BASIS=GIMP, INTEGRATION=CELL",
    "SPLINE2 POINTS": "BASIS=SPLINE2, INTEGRATION=POINTS",
    "SPLINE2 CELL": "BASIS=SPLINE2, INTEGRATION=CELL",
    "SPLINE2G POINTS": "BASIS=SPLINE2G, INTEGRATION=POINTS",
    "SPLINE2G CELL": "BASIS=SPLINE2G, INTEGRATION=CELL",
    "SPLINE3 CELL": "BASIS=SPLINE3, INTEGRATION=CELL",
}
MODELS = {"PLANE STRAIN": (32, 9), "AXISYMMETRIC": (32, 9), "3D": (6, 27)}
QUICK_MODELS = {"PLANE STRAIN": (8, 9), "AXISYMMETRIC": (8, 9), "3D": (3, 27)}


def kernels(bench: Bench) -> Result:
    """Point-iterations per CPU second by basis, integration and dimension."""
    models = QUICK_MODELS if bench.quick else MODELS
    decks = [block(f"{model} {name}", model, cells, points, method, 2 if bench.quick else 5)
             for model, (cells, points) in models.items() for name, method in METHODS.items()]
    samples = bench.times_against(decks)
    table = Table("rates", ["model", "basis, integration", "points", "iterations", "CPU s",
                            "million point-iterations / CPU s", "ns / stress update in the evaluation"],
                  title="Whole process: Mohr-Coulomb block under self-weight",
                  note="Point-iterations: material points times Newton iterations, with start-up and output of the "
                       "process. CELL updates stresses at Gauss points of full cells and at the material "
                       "points of the others; the last column counts those.")
    if bench.against:
        table.columns.append("CPU s of the other / CPU s")
    names, rates = [], []
    for deck in decks:
        runs = samples[deck.name]
        rate = Spread.of(run.figures["point_iterations"] / run.cpu * 1e-6 for run in runs)
        update = Spread.of(run.figures["parts"]["evaluation"]["cpu_seconds"] / run.figures["stress_updates"] * 1e9
                           for run in runs)
        row = [*split(deck.name), runs[0].figures["points"], runs[0].figures["iterations"], cpu(runs),
               rate, update]
        if bench.against:
            row.append(cpu(samples[f"{deck.name} against"]).median / cpu(runs).median)
        table.add(*row)
        names.append(deck.name)
        rates.append(rate.median)
    if bench.figures:
        charts.bars(bench.figures / "bench_kernels.svg", names, rates, "million point-iterations per CPU second")
    result = Result("kernels", [table])
    program = bench.program.parent / "bench_kernels"
    if program.exists():
        result.text = subprocess.run([str(program)], capture_output=True, text=True, check=False, timeout=600).stdout
    return result


def split(name: str) -> tuple[str, str]:
    """Model and method for a name of this study."""
    model = next(model for model in MODELS if name.startswith(model + " "))
    return model, name[len(model) + 1:]


def sizes(bench: Bench) -> dict[str, list[int]]:
    """Cells along an edge: 9 points per cell in 2D, 8 in 3D."""
    if bench.quick:
        return {"PLANE STRAIN": [11, 22, 33], "3D": [5, 7, 9]}
    plane, solid = [11, 33, 105, 200, 333], [5, 8, 13, 20, 30]
    return {"PLANE STRAIN": plane, "3D": solid + ([50] if bench.krylov() else [])}


def size(bench: Bench) -> Result:
    """Cost and memory against the number of points: one elastic step, default solver."""
    table = Table("sizes", ["model", "points", "equations", "solver", "CPU s", "without factorisation and solves",
                            "factorisation GF/s", "MiB", "bytes / point", "bytes / equation",
                            "memory / (factor + 600 B a point)"],
                  title="Elastic block, one load step, full Newton, no empty cells",
                  note="Bytes: the peak memory of the process minus that of the process of the smallest row. Factor: its "
                       "entries as reported by the solver, 4 bytes each in single precision and incomplete factors, otherwise 8; "
                       "target 1.3.")
    result, lines = Result("size", [table]), []
    for model, edges in sizes(bench).items():
        points = 8 if model == "3D" else 9
        decks = [block(f"size {model} {n}", model, n, points, STANDARD, 1, material=ELASTIC, wide=1.0) for n in edges]
        samples = bench.times(decks)
        least = memory_mib(samples[decks[0].name])
        counts, costs, lean = [], [], []
        for deck in decks:
            runs = samples[deck.name]
            figures = runs[0].figures
            rest = Spread.of(run.cpu - solving(run) for run in runs)
            used = (memory_mib(runs) - least) * 2**20
            table.add(model, figures["points"], figures["equations"], figures["solver"], cpu(runs), rest,
                      Spread.of(factor_rate(run) for run in runs), memory_mib(runs),
                      used / figures["points"] if used else None, used / figures["equations"] if used else None,
                      used / expected_bytes(figures) if used else None)
            counts.append(float(figures["points"]))
            costs.append(cpu(runs).median)
            lean.append(rest.median)
        result.remarks.append(
            f"{model}: CPU seconds increase with the number of points to the power "
            f"{fitted_exponent(counts[1:], costs[1:]):.2f}, without factorisation and solves "
            f"{fitted_exponent(counts[1:], lean[1:]):.2f} (least squares, without the smallest size).")
        lines += [(model, counts, costs, "o-"), (f"{model}, without factorisation and solves", counts, lean, "o--")]
    if bench.figures:
        charts.log_lines(bench.figures / "bench_size.svg", lines, "material points", "CPU seconds, one elastic step")
    return result


def expected_bytes(figures: dict) -> float:
    """Bytes of the factor and 600 per material point."""
    short = any(word in figures["solver"] for word in ("single", "IC(0)", "ILU(0)"))
    return (4 if short else 8) * figures["factor_entries"] + 600 * figures["points"]


def factor_rate(run: Sample) -> float:
    """Operations of the factorisations divided by their CPU seconds [GF/s]."""
    seconds = run.figures["parts"]["factorisation"]["cpu_seconds"]
    return run.figures["factor_operations"] / max(seconds, 1e-6) * 1e-9


def solving(run: Sample) -> float:
    """CPU seconds in factorisation and solves."""
    parts = run.figures["parts"]
    return parts["factorisation"]["cpu_seconds"] + parts["solves"]["cpu_seconds"]


def empty(bench: Bench) -> Result:
    """The same scene in a domain ten times larger: time and memory, target at most 5 % more."""
    steps = (("STEPS=50", "STEPS=5"),) if bench.quick else ()
    cells = 4 if bench.quick else 10
    pairs = {
        "cantilever": (scene("cantilever", *steps, file="cantilever_paper.inp"),
                       Deck("cantilever, large", TOP / "input" / "cantilever_paper.inp",
                            (("X, 0, 11, 44", "X, 0, 35, 140"), ("Y, -9.5, 1.5, 44", "Y, -31.5, 3.5, 140"), *steps))),
        "cube, 3D": (block("cube", "3D", cells, 8, "BASIS=GIMP, INTEGRATION=POINTS", 3, wide=1.5),
                     block("cube, large", "3D", cells, 8, "BASIS=GIMP, INTEGRATION=POINTS", 3, wide=3.2)),
    }
    samples = bench.times([deck for pair in pairs.values() for deck in pair])
    table = Table("empty", ["scene", "active cells", "CPU s", "CPU s, domain 10 times larger", "ratio", "MiB",
                            "MiB, domain 10 times larger", "MiB ratio"],
                  title="The same scene in a domain ten times larger")
    result, bars = Result("empty", [table]), {}
    for name, (small, large) in pairs.items():
        one, other = samples[small.name], samples[large.name]
        ratios = [b.cpu / a.cpu for a, b in zip(one, other)]
        growth = memory_mib(other) / memory_mib(one)
        table.add(name, one[0].figures["active_cells"], cpu(one), cpu(other), Spread.of(ratios), memory_mib(one),
                  memory_mib(other), growth)
        bars[f"{name}, time"], bars[f"{name}, memory"] = Spread.of(ratios).median, growth
        worst = max(Spread.of(ratios).median, growth)
        result.remarks.append(f"{name}: target at most 1.05 for time and memory, the larger ratio is {worst:.2f}: "
                              f"{'met' if worst <= 1.05 else 'missed'}.")
    if bench.figures:
        charts.bars(bench.figures / "bench_empty.svg", list(bars), list(bars.values()),
                    "domain ten times larger / original domain", (1.05, "target: at most 1.05"))
    return result


def million(bench: Bench) -> Result:
    """A million material points in 3D, one elastic step with the iterative solver, with output and restart."""
    card = bench.krylov()
    cells = 12 if bench.quick else 50
    if card is None and not bench.quick:
        return Result("million", remarks=["Not run: this build of the program has no iterative solver (*SOLVER); the "
                                          "factor of 400 000 equations in 3D is too large for the memory."])
    deck = block("million", "3D", cells, 8, STANDARD, 1, material=ELASTIC, wide=1.0, solver=card or "", output=True)
    table = Table("million", ["run", "points", "equations", "iterations", "CPU s", "wall s", "GiB", "output, CPU s"],
                  title="HEX8, 8 points per cell, elastic, full Newton, results and restart file written")
    first = run_deck(deck, bench.program, bench.root)
    assert first.directory is not None
    again = run_deck(Deck("million, restarted", text=deck.text), bench.program, bench.root,
                     restart=first.directory / "restart.h5")
    for name, run in (("one step", first), ("restarted at its end: read and written again", again)):
        figures = run.figures
        table.add(name, figures["points"] or first.figures["points"], figures["equations"], figures["iterations"],
                  run.cpu, run.wall, run.memory / 2**30, figures["parts"]["output"]["cpu_seconds"])
    return Result("million", [table], [f"restart.h5 of one step: "
                                       f"{(first.directory / 'restart.h5').stat().st_size / 2**20:.0f} MiB."])
