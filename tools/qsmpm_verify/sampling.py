"""Runs of a study: decks by the program, or another program of the same build whose last line is read."""

from __future__ import annotations

import hashlib
import math
import os
import re
import shutil
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

from qsmpm_verify.cache import keep, kept, program_hash
from qsmpm_verify.cpu_limit import run_limited
from qsmpm_verify.front import Sample
from qsmpm_verify.judge import judge_quantity
from qsmpm_verify.runner import last_line, run_case
from qsmpm_verify.studies import Entry, Study

Tell = Callable[[str, float, bool], None]


def deck_sample(
    study: Study, label: str, entry: Entry, program: Path, root: Path, fresh: bool
) -> tuple[Sample, float, bool]:
    """Run a deck and evaluate its error; returns wall-clock seconds and whether the run was already available."""
    run = run_case(entry.case, program, root, fresh=fresh)
    failed = Sample(study.name, label, entry.size, math.nan, math.nan, entry.case.name)
    if run.exit_code not in entry.exit_codes:
        reason = run.message if run.exit_code is None else f"exit {run.exit_code}: {run.message}"
        return replace(failed, message=reason), run.wall_seconds, run.reused
    verdict = judge_quantity(run, study.error, {})
    error = verdict.value if study.error.reference is None else verdict.error
    if verdict.note or error is None or not math.isfinite(error):
        return (
            replace(failed, message=verdict.note.removeprefix(f"{run.directory / 'curves.csv'}: ") or "no result"),
            run.wall_seconds,
            run.reused,
        )
    seconds = math.nan if verdict.cpu_seconds is None else max(verdict.cpu_seconds, 1e-3)
    return measured(study, failed, abs(error), seconds), run.wall_seconds, run.reused


def measured(study: Study, empty: Sample, error: float, seconds: float) -> Sample:
    """A sample with its values; errors below the floor of the study are set to it."""
    return replace(empty, error=max(error, study.floor), seconds=seconds, at_floor=error <= study.floor)


def command_sample(
    study: Study, label: str, entry: Entry, program: Path, root: Path, fresh: bool
) -> tuple[Sample, float, bool]:
    """Run another program of the build; the values of its last line are kept in the same way as deck runs."""
    tool = program.parent / entry.command[0]
    folder = root / entry.case.name
    failed = Sample(study.name, label, entry.size, math.nan, math.nan, entry.case.name)
    if not tool.is_file():
        return replace(failed, message=f"{tool} not found"), 0.0, False
    key = hashlib.sha256(" ".join([program_hash(tool), *entry.command]).encode()).hexdigest()
    record = folder / "line.json"
    content = None if fresh else kept(record, key)
    line, reused = (content["line"], True) if content and "line" in content else ("", False)
    if not reused:
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        environment = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
        with (folder / "terminal.txt").open("wb") as output:
            ended = run_limited([tool, *entry.command[1:]], entry.case.time_limit, folder, environment, output)
        if ended.code is None or ended.code < 0:
            return replace(failed, message=ended.how), ended.cpu, False
        line = last_line(folder / "terminal.txt")
        keep(record, {"key": key, "line": line})
    hit = re.search(study.pattern, line)
    if not hit:
        return replace(failed, message=line), 0.0, reused
    seconds = max(float(hit["seconds"]), 1e-3)
    return measured(study, failed, float(hit["error"]), seconds), seconds, reused


def sample_study(
    study: Study, efforts: tuple[str, ...], program: Path, root: Path, jobs: int, repeats: int, fresh: bool, tell: Tell
) -> list[Sample]:
    """All runs of the requested efforts, in the order of the study; of repeated runs the fastest counts."""
    waiting = [(m.label, e) for m in study.methods for e in m.entries if e.case.effort in efforts]

    def one(label: str, entry: Entry) -> Sample:
        found: list[Sample] = []
        for count in range(repeats):
            named = (
                entry if count == 0 else replace(entry, case=replace(entry.case, name=f"{entry.case.name}@{count + 1}"))
            )
            take = command_sample if entry.command else deck_sample
            sample, seconds, reused = take(study, label, named, program, root, fresh)
            tell(named.case.name, seconds, reused)
            found.append(sample)
        return min(found, key=lambda s: s.seconds if s.good else math.inf)

    with ThreadPoolExecutor(max_workers=jobs) as pool:
        futures = [pool.submit(one, label, entry) for label, entry in waiting]
        try:
            return [future.result() for future in futures]
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def count_runs(study: Study, efforts: tuple[str, ...]) -> int:
    """Number of runs of the requested efforts."""
    return sum(e.case.effort in efforts for m in study.methods for e in m.entries)
