"""Run the program on the decks of cases, several in parallel, each in its own folder."""

from __future__ import annotations

import os
import shutil
import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from qsmpm_verify import cache
from qsmpm_verify.cases import Case
from qsmpm_verify.cpu_limit import run_limited


@dataclass(frozen=True)
class Run:
    """A finished run."""

    case: Case
    directory: Path
    exit_code: int | None
    wall_seconds: float
    message: str = ""
    reused: bool = False


def deck_text(case: Case) -> str:
    """The deck with the replacements of the case.

    A replacement without a match is an error: the deck has changed but not the case.
    """
    text = case.deck.read_text(encoding="utf-8")
    for old, new in case.replace:
        if old not in text:
            raise ValueError(f"{case.deck.name}: nothing to replace at {old!r}")
        text = text.replace(old, new)
    return text


def write_deck(case: Case, directory: Path) -> Path:
    """Copy the deck into the folder with the replacements of the case.

    The copy is in another folder. So that relative names after INPUT= and FILE= remain valid, the files
    beside the original are linked beside the copy.
    """
    text = deck_text(case)
    for neighbour in case.deck.parent.iterdir():
        if neighbour.suffix != ".inp" or "INPUT=" in text.upper():
            (directory / neighbour.name).symlink_to(neighbour.resolve())
    copy = directory / case.deck.name
    copy.unlink(missing_ok=True)
    copy.write_text(text, encoding="utf-8")
    return copy


def run_case(
    case: Case, program: Path, root: Path, threads: int = 1, fresh: bool = False, options: tuple[str, ...] = ()
) -> Run:
    """Run one case under root/NAME, or reuse the available run if nothing has changed.

    A crash, a missing deck or an exceeded time limit is reported, not raised.
    """
    directory = root / case.name
    results = directory / "results"
    try:
        key = cache.run_key(deck_text(case) + " ".join(options), case.deck.parent, program, threads)
        kept = None if fresh else cache.recall(directory, key)
        if kept is not None:
            return Run(case, results, kept.exit_code, kept.wall_seconds, kept.message, reused=True)
        shutil.rmtree(directory, ignore_errors=True)
        (directory / "deck").mkdir(parents=True)
        deck = write_deck(case, directory / "deck")
    except (OSError, ValueError) as error:
        return Run(case, results, None, 0.0, str(error))
    started = time.monotonic()
    code, message = _execute(
        _command(case, program, deck, results, threads) + list(options),
        directory / "terminal.txt", case.time_limit, threads,
    )  # fmt: skip
    if code is not None and code != case.exit_code:
        message = last_line(directory / "terminal.txt")
    run = Run(case, results, code, time.monotonic() - started, message)
    if code is not None:
        cache.remember(directory, key, cache.Record(code, run.wall_seconds, message))
    return run


def _command(case: Case, program: Path, deck: Path, results: Path, threads: int) -> list[str]:
    """The command: the program, or a script of the tree that calls the library beside it."""
    if case.command == "python":
        return [sys.executable, str(case.deck), str(program), "--out", str(results)]
    words = ["--tangent"] if case.command == "point" else ["--threads", str(threads)]
    return [str(program), case.command, str(deck), "--out", str(results), *words]


def _execute(command: list[str], terminal: Path, time_limit: float, threads: int) -> tuple[int | None, str]:
    """Exit code of a command whose output goes to a file; None and the reason if it did not end by itself."""
    environment = {**os.environ, "OMP_NUM_THREADS": str(threads), "OPENBLAS_NUM_THREADS": str(threads)}
    with terminal.open("wb") as output:
        try:
            ended = run_limited(command, time_limit * threads, env=environment, output=output)
        except OSError as error:
            return None, str(error)
    return ended.code, ended.reason


def last_line(path: Path) -> str:
    """The last line of terminal output that is not empty."""
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    return next((line.strip() for line in reversed(lines) if line.strip()), "")


def run_all(
    cases: list[Case], program: Path, root: Path, jobs: int, tell: Callable[[Run], None], fresh: bool = False
) -> dict[str, Run]:
    """Run the cases, `jobs` in parallel, those with the longest time limit first; `tell` is called as each one ends.

    After an interruption no further run is started; finished runs are kept.
    """

    def one(case: Case) -> Run:
        run = run_case(case, program, root, fresh=fresh)
        tell(run)
        return run

    with ThreadPoolExecutor(max_workers=max(1, jobs)) as pool:
        waiting = [pool.submit(one, case) for case in sorted(cases, key=lambda case: -case.time_limit)]
        try:
            return {run.case.name: run for run in (future.result() for future in waiting)}
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
