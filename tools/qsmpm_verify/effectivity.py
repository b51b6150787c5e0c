"""`trust`: the stress error that runs report, compared with the true error where the stress is known.

The rows are the tests of the stability map with known stress at every point, cavities in bodies of two sizes
(verification/trust), and manufactured fields. Mean and largest are defined in docs/methods/stress_error.md, with the true
error instead of the estimated one: of the norm of the stress difference at the points, relative to the stress around
them; a loaded surface is included in the largest reported. The effectivity is the reported error divided by the true error.
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
from qsmpm_verify.places import BUILD, PROGRAM, STABILITY, TOP, TRUST
from qsmpm_verify.report import table
from qsmpm_verify.results import Array, Points, ResultError, read_points
from qsmpm_verify.runner import run_case
from qsmpm_verify.stability import Test, load_methods, load_rows, load_test

SHEARS_TWICE = np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])
"""Weights of the components in the norm of a tensor."""
HEADINGS = ["scene", "method", "true mean", "stated", "ratio", "true largest", "stated", "ratio", "warns"]
LOW, HIGH = 0.5, 2.0
"""An estimate between these ratios to the true error is accurate."""
LEAST = 1e-6
"""True errors below this value are due to tolerances and round-off: they have no ratio."""


def uniform(*components: float) -> Callable[[Points], Array]:
    """A uniform stress."""
    return lambda points: np.tile(np.array(components), (len(points.field("volume")), 1))


def column(points: Points) -> Array:
    """The column of test S2: the weight above the initial position of a point."""
    start = points.field("position")[:, 1] - points.field("displacement")[:, 1]
    stress = np.zeros((len(start), 6))
    stress[:, 1] = -0.8 * (50.0 - start)
    return stress


def square(points: Points) -> Array:
    """The rotated square of test S3 with Hencky's law: its tractions act on the undeformed sides, which shorten."""
    stiffness = 1e6 / (1.3 * 0.4)
    stretch = 1.0
    for _ in range(5):
        stretch = math.exp(-10.0 * stretch / stiffness)
    return uniform(*(np.array([-10, -10, -6, 0, 0, 0]) / stretch))(points)


def cavity(ambient: float) -> Callable[[Points], Array]:
    """Lame's cavity of radius 1 under a pressure of 1, in a body under another pressure (Poisson's ratio 0.3)."""

    def exact(points: Points) -> Array:
        radial = 1.0 / points.field("position")[:, 0] ** 2
        stress = np.zeros((len(radial), 6))
        stress[:, 0], stress[:, 1], stress[:, 2] = -radial - ambient, -0.6 * ambient, radial - ambient
        return stress

    return exact


EXACT: dict[str, Callable[[Points], Array]] = {
    "S1": uniform(0, -1000 / 3, 0, 0, 0, 0),
    "S2": column,
    "S3": square,
    "S13": uniform(0, -1, 0, 0, 0, 0),
    "T1": cavity(0.0),
    "T2": cavity(0.0),
    "T3": cavity(1.0),
    "T4": cavity(1.0),
}
"""Exact stress of the tests whose stress is known, by components 11, 22, 33, 12, 13, 23."""

FIELDS = (
    ("BASIS=STANDARD", 4), ("BASIS=GIMP", 4), ("BASIS=SPLINE2, INTEGRATION=CELL", 9),
    ("BASIS=SPLINE2G, INTEGRATION=CELL", 9), ("BASIS=SPLINE3, INTEGRATION=CELL", 16),
)  # fmt: skip
"""Methods for a manufactured field, and their points per cell."""


@dataclass(frozen=True)
class Line:
    """A run: true and reported relative errors; NaN if there is none."""

    scene: str
    method: str
    mean: float
    stated_mean: float
    largest: float = math.nan
    stated_largest: float = math.nan
    warned: bool | None = None


def mean_error(share: Array, scale: Array, volume: Array) -> float:
    """Mean of an error relative to the surrounding stress, over the points with error, as reported by a run."""
    weight = volume * scale**2 * np.sqrt(share)
    return float(np.average(share, weights=weight)) if weight.sum() > 0 else 0.0


def true_errors(points: Points, exact: Array) -> tuple[float, float]:
    """Mean and largest of the norm of the stress error relative to the stress around each point."""
    scale = points.field("stress_scale")
    share = np.sqrt(((points.field("stress") - exact) ** 2) @ SHEARS_TWICE) / scale
    return mean_error(share, scale, points.field("volume")), float(share.max())


def known_tests() -> list[Test]:
    """The tests whose stress is known."""
    methods = load_methods(STABILITY)
    tests = load_rows(STABILITY, TOP, [name for name in EXACT if name.startswith("S")])[1]
    return tests + [load_test(path, methods, TOP) for path in sorted(TRUST.glob("*.toml"))]


def deck_lines(program: Path, out: Path, fresh: bool) -> list[Line]:
    """Tests of the map."""
    lines = []
    for test in known_tests():
        for trial in test.trials:
            run = run_case(trial.case, program, out, fresh=fresh)
            if run.exit_code != 0:
                raise ResultError(f"{trial.case.name} did not finish: {run.message}")
            points, log = read_points(run.directory), log_text(run)
            mean, largest = true_errors(points, EXACT[test.id](points))
            stated = stated_error(log, "mean"), stated_error(log, "largest")
            lines.append(Line(test.id, trial.method, mean, stated[0], largest, stated[1], warns_of_stress(log)))
    return lines


def field_lines(folder: Path, cells: int) -> list[Line]:
    """A manufactured field on a square with a number of cells per side: root mean squares, from build/manufactured."""
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


def ratios(line: Line) -> tuple[float, float]:
    """Effectivities of mean and largest; NaN if the true error is negligible."""
    mean = line.stated_mean / line.mean if line.mean > LEAST else math.nan
    return mean, line.stated_largest / line.largest if line.largest > LEAST else math.nan


def shown(line: Line) -> list[str]:
    """A line as text."""
    mean, largest = (f"{ratio:.2f}" if math.isfinite(ratio) else "-" for ratio in ratios(line))
    warned = {None: "", True: "yes", False: "no"}[line.warned]
    row = [line.scene, line.method, f"{line.mean:.1e}", f"{line.stated_mean:.1e}", mean]
    if math.isnan(line.largest):
        return [*row, "", "", "", warned]
    return [*row, f"{line.largest:.1e}", f"{line.stated_largest:.1e}", largest, warned]


def counted(lines: list[Line]) -> str:
    """Number of accurate effectivities."""
    words = []
    for index, name in enumerate(("mean", "largest")):
        found = [ratio for ratio in (ratios(line)[index] for line in lines) if math.isfinite(ratio)]
        right = sum(LOW <= ratio <= HIGH for ratio in found)
        words.append(f"{right} of {len(found)} reported {name} errors are between {LOW:g} and {HIGH:g} times the true one")
    return "; ".join(words)


def sizes(lines: list[Line]) -> str:
    """Change of the reported errors of the cavities with the size of the body."""
    stated = {(line.scene, line.method): (line.stated_mean, line.stated_largest) for line in lines}
    words = []
    for near, far, name in (("T1", "T2", "quiet"), ("T3", "T4", "pressed")):
        pairs = [(stated[near, method], stated[far, method]) for scene, method in stated if scene == near]
        if not pairs:
            continue
        change = [max(abs(b[k] / a[k] - 1) for a, b in pairs) for k in (0, 1)]
        words.append(f"{name} body: mean by up to {100 * change[0]:.0f} %, largest by up to {100 * change[1]:.1f} %")
    return "20 instead of 2 radii around the cavity change the reported error, " + "; ".join(words)


def add_words(verbs: argparse._SubParsersAction) -> None:
    """Arguments of the subcommand."""
    verb = verbs.add_parser("trust", help="compare the stress error reported by runs with the true error")
    verb.add_argument("--program", type=Path, default=PROGRAM, help="program to run")
    verb.add_argument("--out", type=Path, default=BUILD / "stability", help="folder of the runs, the same as for `map`")
    verb.add_argument("--fresh", action="store_true", help="repeat runs that are already available")
    verb.add_argument("--markdown", action="store_true", help="print the table in Markdown")
    verb.set_defaults(act=act, jobs=1)


def act(words: argparse.Namespace) -> int:
    """Run and report."""
    program = checked_program(words)
    lines = deck_lines(program, words.out, words.fresh)
    for cells in (16, 32):
        lines += field_lines(program.parent, cells)
    rows = [shown(line) for line in lines]
    print("\n".join(markdown_table(HEADINGS, rows)) if words.markdown else table(HEADINGS, rows))
    print("", counted(lines), sizes(lines), sep="\n")
    return 0
