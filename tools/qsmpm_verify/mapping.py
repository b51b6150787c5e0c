"""Fields of the stability map: run one test with one method and rate the outcome."""

from __future__ import annotations

import math
import os
import re
from dataclasses import dataclass
from pathlib import Path
from threading import Lock

from qsmpm_verify.cpu_limit import run_limited
from qsmpm_verify.judge import judge_quantity
from qsmpm_verify.runner import Run, run_case
from qsmpm_verify.stability import Test, Trial

# The last line in which a run says how far its stresses are off (src/output/error_report.f90).
STATED = re.compile(
    r"^stress error, estimated: mean (?P<mean>\S+) %, largest (?P<largest>\S+) %"
    r"(?:.*; on loaded surface '.*' mean \S+ %, largest (?P<surface_largest>\S+) %)?",
    re.MULTILINE,
)
HONEST = 0.5
"""Share of a true error that a run must report for the error to count as reported."""
PASS, DEGRADED, TOLD, SILENT, NONE = "pass", "degraded", "fails and says so", "fails silently", "not for it"
TELLING = re.compile(
    r"^(?!phase \d).*(?:warning|increment cut back|stopped|inaccurate|not converged).*$", re.IGNORECASE | re.MULTILINE
)


@dataclass(frozen=True)
class Field:
    """Outcome of a test with one method."""

    test: str
    method: str
    outcome: str
    figure: float = math.nan
    exit_code: int | None = None
    note: str = ""
    seconds: float = 0.0
    stated: float = math.nan


def log_tells(run: Run) -> str:
    """First objection in the log of a successful run; empty if there is none."""
    hit = TELLING.search(log_text(run))
    return hit[0].strip() if hit else ""


def log_text(run: Run) -> str:
    """The log of a run; empty if there is none."""
    try:
        return (run.directory / "job.log").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""


def stated_error(log: str, kind: str) -> float:
    """Estimate of the relative stress error that a run reports at its end; NaN if there is none.

    "mean" is over the points; "largest" includes loaded surfaces.
    """
    hits = list(STATED.finditer(log))
    if not hits or not kind:
        return math.nan
    shares = [hits[-1][kind], hits[-1]["surface_largest"] if kind == "largest" else None]
    return max(float(share) / 100 for share in shares if share is not None)


def warns_of_stress(log: str) -> bool:
    """Whether a run warns about its stresses."""
    return bool(re.search(r"^warning: .*stresses ", log, re.MULTILINE))


def outcome_of(test: Test, figure: float, message: str, stated: float = math.nan) -> str:
    """Rating of a field whose run ended as the test allows.

    Where runs estimate the quantity of the test, the estimate must be at least half of the value: a warning with an
    estimate that is far too small does not count.
    """
    if abs(figure) <= test.good:
        return PASS
    if abs(figure) <= test.fair:
        return DEGRADED
    if test.states and not stated >= HONEST * abs(figure):
        return SILENT
    return TOLD if message else SILENT


def deck_field(test: Test, trial: Trial, program: Path, root: Path, fresh: bool) -> tuple[Field, bool]:
    """Run the deck of a field; returns whether the run was already available."""
    run = run_case(trial.case, program, root, fresh=fresh)
    code = run.exit_code
    if code is None or code < 0 or code > 128:
        note = run.message or f"ended by signal {code}"
        return Field(test.id, trial.method, TOLD, math.nan, code, note, run.wall_seconds), run.reused
    if code not in test.ends:
        # What must end with a message and ends well, has said nothing.
        outcome = SILENT if code == 0 else TOLD
        return Field(test.id, trial.method, outcome, math.nan, code, run.message, run.wall_seconds), run.reused
    if test.figure is None:
        return Field(test.id, trial.method, PASS, math.nan, code, run.message, run.wall_seconds), run.reused
    verdict = judge_quantity(run, test.figure, {})
    figure = verdict.value if test.figure.reference is None else verdict.error
    if verdict.note or figure is None:
        return Field(test.id, trial.method, SILENT, math.nan, code, verdict.note, run.wall_seconds), run.reused
    message = run.message if code != 0 else log_tells(run)
    stated = stated_error(log_text(run), test.states)
    if test.states and code == 0:
        message = message if warns_of_stress(log_text(run)) else ""
    outcome = outcome_of(test, figure, message, stated)
    return Field(test.id, trial.method, outcome, figure, code, message, run.wall_seconds, stated), run.reused


class Commands:
    """Other programs of the build, each run once for all methods."""

    def __init__(self, program: Path) -> None:
        self.folder = program.parent
        self._texts: dict[tuple[str, ...], str] = {}
        self._lock = Lock()

    def text(self, command: tuple[str, ...]) -> str:
        """Output of a command; for a missing program the reason."""
        with self._lock:
            if command not in self._texts:
                environment = {**os.environ, "OMP_NUM_THREADS": "1"}
                try:
                    ended = run_limited([self.folder / command[0], *command[1:]], 300.0, env=environment)
                    self._texts[command] = f"{ended.output}{ended.reason}\n"
                except OSError as error:
                    self._texts[command] = f"{error}\n"
            return self._texts[command]


def command_field(test: Test, trial: Trial, commands: Commands) -> Field:
    """Read the value of a field from the output of another program."""
    text = commands.text(test.command)
    hit = re.search(trial.pattern, text)
    if not hit:
        last = text.strip().splitlines()[-1:] or ["nothing printed"]
        return Field(test.id, trial.method, TOLD, math.nan, None, f"no figure: {last[0]}")
    figure = float(hit["figure"])
    return Field(test.id, trial.method, outcome_of(test, figure, ""), figure, 0)
