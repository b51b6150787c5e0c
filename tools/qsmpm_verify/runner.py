"""Run the program on the decks of cases, several at a time, each in a folder of its own."""

from __future__ import annotations

import os
import shutil
import subprocess
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from qsmpm_verify.cases import Case


@dataclass(frozen=True)
class Run:
    """A run that has ended."""

    case: Case
    directory: Path
    exit_code: int | None
    wall_seconds: float
    message: str = ""


def write_deck(case: Case, directory: Path) -> Path:
    """Copy the deck into the folder with the replacements of the case.

    The copy stands elsewhere, so relative names behind INPUT= and FILE= keep pointing into the
    folder of the original: what lies beside the original is linked beside the copy.
    A replacement that hits nothing is an error: the deck has changed and the case has not.
    """
    text = case.deck.read_text(encoding="utf-8")
    for old, new in case.replace:
        if old not in text:
            raise ValueError(f"{case.deck.name}: nothing to replace at {old!r}")
        text = text.replace(old, new)
    for neighbour in case.deck.parent.iterdir():
        if neighbour.suffix != ".inp" or "INPUT=" in text.upper():
            (directory / neighbour.name).symlink_to(neighbour.resolve())
    copy = directory / case.deck.name
    copy.unlink(missing_ok=True)
    copy.write_text(text, encoding="utf-8")
    return copy


def run_case(case: Case, program: Path, root: Path, threads: int = 1) -> Run:
    """Run one case under root/NAME; a crash, a missing deck or a run out of time is told, not raised."""
    directory = root / case.name
    shutil.rmtree(directory, ignore_errors=True)
    (directory / "deck").mkdir(parents=True)
    results = directory / "results"
    started = time.monotonic()
    try:
        deck = write_deck(case, directory / "deck")
    except (OSError, ValueError) as error:
        return Run(case, results, None, 0.0, str(error))
    command = [str(program), "run", str(deck), "--out", str(results), "--threads", str(threads)]
    environment = {**os.environ, "OMP_NUM_THREADS": str(threads), "OPENBLAS_NUM_THREADS": str(threads)}
    with (directory / "terminal.txt").open("wb") as terminal:
        try:
            code: int | None = subprocess.run(
                command,
                stdin=subprocess.DEVNULL,
                stdout=terminal,
                stderr=subprocess.STDOUT,
                timeout=case.time_limit,
                env=environment,
                check=False,
            ).returncode
            message = ""
        except subprocess.TimeoutExpired:
            code, message = None, f"stopped after {case.time_limit:g} s"
        except OSError as error:
            code, message = None, str(error)
    if code is not None and code != case.exit_code:
        message = last_line(directory / "terminal.txt")
    return Run(case, results, code, time.monotonic() - started, message)


def last_line(path: Path) -> str:
    """The last line of a terminal's output that says something."""
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    return next((line.strip() for line in reversed(lines) if line.strip()), "")


def run_all(
    cases: list[Case], program: Path, root: Path, jobs: int, tell: Callable[[Run], None]
) -> dict[str, Run]:
    """Run the cases, `jobs` at a time; `tell` hears of each one as it ends."""
    runs: dict[str, Run] = {}

    def one(case: Case) -> Run:
        run = run_case(case, program, root)
        tell(run)
        return run

    with ThreadPoolExecutor(max_workers=max(1, jobs)) as pool:
        for run in pool.map(one, sorted(cases, key=lambda case: -case.time_limit)):
            runs[run.case.name] = run
    return runs
