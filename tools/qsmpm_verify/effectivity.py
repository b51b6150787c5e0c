"""`trust`: what runs state of the error of their stresses, beside the true error where the stress is known.

Rows are those tests of the stability map whose stress is known at every point, and manufactured fields. Mean and
largest are of the norm of the stress difference over all points, as shares of the root mean square of the stress;
a loaded surface counts for the largest stated. The effectivity is stated over true.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from qsmpm_verify.batch import checked_program
from qsmpm_verify.chart import markdown_table
from qsmpm_verify.cpu_limit import run_limited
from qsmpm_verify.mapping import log_text, stated_error, warns_of_stress
from qsmpm_verify.places import BUILD, PROGRAM, STABILITY, TOP
from qsmpm_verify.report import table
from qsmpm_verify.results import Array, Points, ResultError, read_points
from qsmpm_verify.runner import run_case
from qsmpm_verify.stability import load_rows

SHEARS_TWICE = np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])
"""Weights of the components in the norm of a tensor."""
HEADINGS = ["scene", "method", "true mean", "stated", "ratio", "true largest", "stated", "ratio", "warns"]


def uniform(*components: float) -> Callable[[Points], Array]:
    """A stress that is the same at every point."""
    return lambda points: np.tile(np.array(components), (len(points.field("volume")), 1))


def column(points: Points) -> Array:
    """The column of test S2: the weight above the place where a point started."""
    start = points.field("position")[:, 1] - points.field("displacement")[:, 1]
    stress = np.zeros((len(start), 6))
    stress[:, 1] = -0.8 * (50.0 - start)
    return stress


EXACT: dict[str, Callable[[Points], Array]] = {
    "S1": uniform(0, -1000 / 3, 0, 0, 0, 0),
    "S2": column,
    "S3": uniform(-10, -10, -6, 0, 0, 0),
    "S13": uniform(0, -1, 0, 0, 0, 0),
}
"""Exact stress of the tests whose stress is known, by components 11, 22, 33, 12, 13, 23."""

FIELDS = (
    ("BASIS=STANDARD", 4), ("BASIS=GIMP", 4), ("BASIS=SPLINE2, INTEGRATION=CELL", 9),
    ("BASIS=SPLINE2G, INTEGRATION=CELL", 9), ("BASIS=SPLINE3, INTEGRATION=CELL", 16),
)  # fmt: skip
"""Methods tried on a manufactured field, and their points a cell."""


@dataclass(frozen=True)
class Line:
    """A run: true and stated errors as shares; NaN where there is none."""

    scene: str
    method: str
    mean: float
    stated_mean: float
    largest: float = math.nan
    stated_largest: float = math.nan
    warned: bool | None = None


def true_errors(points: Points, exact: Array) -> tuple[float, float]:
    """Mean over the volume and largest of the norm of the stress error, over the root mean square of the stress."""
    volume = points.field("volume")
    stress = points.field("stress")
    error = np.sqrt(((stress - exact) ** 2) @ SHEARS_TWICE)
    scale = math.sqrt(float(np.average((stress**2) @ SHEARS_TWICE, weights=volume)))
    return float(np.average(error, weights=volume)) / scale, float(error.max()) / scale


def deck_lines(program: Path, out: Path, fresh: bool) -> list[Line]:
    """Tests of the map."""
    lines = []
    for test in load_rows(STABILITY, TOP, list(EXACT))[1]:
        for trial in test.trials:
            run = run_case(trial.case, program, out, fresh=fresh)
            if run.exit_code != 0:
                raise ResultError(f"{trial.case.name} has not finished: {run.message}")
            points, log = read_points(run.directory), log_text(run)
            mean, largest = true_errors(points, EXACT[test.id](points))
            stated = stated_error(log, "mean"), stated_error(log, "largest")
            lines.append(Line(test.id, trial.method, mean, stated[0], largest, stated[1], warns_of_stress(log)))
    return lines


def field_lines(folder: Path, cells: int) -> list[Line]:
    """A manufactured field on a square of some cells a side: root mean squares, from build/manufactured."""
    lines = []
    for method, points in FIELDS:
        words = [str(folder / "manufactured"), method, str(points), "2", str(cells), "20"]
        try:
            text = run_limited(words, 300.0).output
            stated, true = (float(word) for word in text.split()[-6:-4])
        except (OSError, ValueError) as error:
            raise ResultError(f"{' '.join(words)}: {error}") from error
        lines.append(Line(f"field, n = {cells}", method.removeprefix("BASIS=").split(",")[0], true, stated))
    return lines


def shown(line: Line) -> list[str]:
    """A line as text; errors below 1e-6 have no ratio."""

    def ratio(stated: float, true: float) -> str:
        return f"{stated / true:.2f}" if true > 1e-6 else "-"

    warned = {None: "", True: "yes", False: "no"}[line.warned]
    row = [line.scene, line.method, f"{line.mean:.1e}", f"{line.stated_mean:.1e}", ratio(line.stated_mean, line.mean)]
    if math.isnan(line.largest):
        return [*row, "", "", "", warned]
    largest = ratio(line.stated_largest, line.largest)
    return [*row, f"{line.largest:.1e}", f"{line.stated_largest:.1e}", largest, warned]


def add_words(verbs: argparse._SubParsersAction) -> None:
    """Words of the verb."""
    verb = verbs.add_parser("trust", help="what runs state of their stress error, beside the true one")
    verb.add_argument("--program", type=Path, default=PROGRAM, help="the program to run")
    verb.add_argument("--out", type=Path, default=BUILD / "stability", help="folder of the runs, those of `map`")
    verb.add_argument("--fresh", action="store_true", help="run again what has been run already")
    verb.add_argument("--markdown", action="store_true", help="print the table as a page has it")
    verb.set_defaults(act=act, jobs=1)


def act(words: argparse.Namespace) -> int:
    """Run and tell."""
    program = checked_program(words)
    lines = deck_lines(program, words.out, words.fresh)
    for cells in (16, 32):
        lines += field_lines(program.parent, cells)
    rows = [shown(line) for line in lines]
    print("\n".join(markdown_table(HEADINGS, rows)) if words.markdown else table(HEADINGS, rows))
    return 0
