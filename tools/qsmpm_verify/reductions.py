"""Reductions of scenes: the format of verification/studies/scene/*.toml, and the results of both models.

[[reduction]]
name = "plane_strain"         of its runs
title = "..."                 of its bars
scene = "..."                 one line
deck = "..."                  from the top of the tree
effort = "quick"              small, quick or long
both = [["old", "new"]]       in the decks of both models
whole = [["old", "new"]]      in the deck of the full scene, after those of both
reduced = [["old", "new"]]    in the deck of the reduced model
column = "u"                  the result that may change, a column of curves.csv
what = "..."                  description of this result
note = "..."
time_limit = 300
"""

from __future__ import annotations

import json
import tomllib
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from qsmpm_verify.cases import EFFORTS, Case, CaseError, check_keys
from qsmpm_verify.results import Curves, ResultError, read_curves
from qsmpm_verify.runner import Run, run_case
from qsmpm_verify.trouble import RunFailed

TEXTS = ("name", "title", "scene", "deck", "column", "what", "note")
KEYS = {*TEXTS, "effort", "both", "whole", "reduced", "time_limit"}


@dataclass(frozen=True)
class Reduction:
    """A full scene, its reduced model and the compared result."""

    name: str
    title: str
    scene: str
    column: str
    what: str
    note: str
    whole: Case
    reduced: Case


@dataclass(frozen=True)
class Cost:
    """Cost of a model: CPU seconds, memory in MiB, equations, points."""

    seconds: float
    memory: float
    equations: int
    points: int


@dataclass(frozen=True)
class Saving:
    """Both models of a reduction and the largest change of the result, relative to its largest value."""

    reduction: Reduction
    whole: Cost
    reduced: Cost
    change: float


def _reduction(table: dict[str, Any], top: Path, where: str) -> Reduction:
    """A checked table of a file."""
    check_keys(table, KEYS, where)
    for key in TEXTS:
        if not isinstance(table.get(key), str) or not table[key]:
            raise CaseError(f"{where}: a reduction requires the key {key}")
    where = f"{where}, '{table['name']}'"
    effort = table.get("effort", "quick")
    if effort not in EFFORTS:
        raise CaseError(f"{where}: effort must be one of {', '.join(EFFORTS)}")

    def case(model: str) -> Case:
        pairs = [*table.get("both", []), *table.get(model, [])]
        if not all(isinstance(p, list) and len(p) == 2 and all(isinstance(t, str) for t in p) for p in pairs):
            raise CaseError(f"{where}: replacements must be pairs of texts")
        return Case(f"{table['name']}/{model}", table["title"], top / table["deck"], (), effort,
                    time_limit=float(table.get("time_limit", 300.0)), replace=tuple((a, b) for a, b in pairs))

    whole, reduced = case("whole"), case("reduced")
    if whole.replace == reduced.replace:
        raise CaseError(f"{where}: both models have the same deck")
    words = {key: table[key] for key in ("name", "title", "scene", "column", "what", "note")}
    return Reduction(**words, whole=whole, reduced=reduced)


def load_reductions(folder: Path, top: Path, names: list[str], efforts: tuple[str, ...]) -> list[Reduction]:
    """The requested reductions of the given efforts."""
    found: dict[str, Reduction] = {}
    for path in sorted(folder.glob("*.toml")):
        try:
            tables = tomllib.loads(path.read_text(encoding="utf-8"))
        except tomllib.TOMLDecodeError as error:
            raise CaseError(f"{path}: {error}") from error
        check_keys(tables, {"reduction"}, str(path))
        for table in tables.get("reduction", []):
            reduction = _reduction(table, top, str(path))
            if reduction.name in found:
                raise CaseError(f"{path}: two reductions have the name {reduction.name}")
            found[reduction.name] = reduction
    if not found:
        raise CaseError(f"{folder}: no reductions found")
    unknown = [name for name in names if name not in found]
    if unknown:
        raise CaseError(f"unknown reduction '{unknown[0]}'; known are {', '.join(found)}")
    return [found[n] for n in names] if names else [r for r in found.values() if r.whole.effort in efforts]


def cost_of(run: Run) -> Cost:
    """Cost of a run from its profile."""
    path = run.directory / "profile.json"
    try:
        figures = json.loads(path.read_text(encoding="utf-8"))
        return Cost(float(figures["cpu_seconds"]), float(figures["peak_memory_bytes"]) / 2**20,
                    int(figures["equations"]), int(figures["points"]))
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ResultError(f"{path}: not the profile of a run ({error!r})") from error


def largest_change(whole: Curves, reduced: Curves, column: str) -> float:
    """Largest difference over all steps, relative to the largest value of the full scene; interpolated linearly where
    the steps of the two models differ."""
    gap = 0.0
    for phase in np.unique(whole.column("phase")):
        rows, others = (curves.rows_of_phase(int(phase)) for curves in (whole, reduced))
        if not len(others):
            raise ResultError(f"{reduced.path}: phase {int(phase)} was not run")
        at = whole.column("load_factor")[rows]
        theirs = np.interp(at, reduced.column("load_factor")[others], reduced.column(column)[others])
        gap = max(gap, float(np.abs(theirs - whole.column(column)[rows]).max()))
    size = float(np.abs(whole.column(column)).max())
    if size == 0:
        raise ResultError(f"{whole.path}: {column} is zero throughout")
    return gap / size


def _run(case: Case, program: Path, root: Path, repeat: int, fresh: bool, tell: Callable[[Run], None]) -> tuple[Run, Cost]:
    """Run a model; of repeated runs the one with the least CPU time counts."""
    taken: list[tuple[Run, Cost]] = []
    for count in range(repeat):
        named = case if count == 0 else replace(case, name=f"{case.name}@{count + 1}")
        run = run_case(named, program, root, fresh=fresh, options=("--profile",))
        tell(run)
        if run.exit_code != 0:
            reason = run.message if run.exit_code is None else f"exit {run.exit_code}: {run.message}"
            raise RunFailed(f"scene {case.name}: {reason}")
        taken.append((run, cost_of(run)))
    return min(taken, key=lambda pair: pair[1].seconds)


def measure(
    reduction: Reduction, program: Path, root: Path, repeat: int, fresh: bool, tell: Callable[[Run], None]
) -> Saving:
    """Run both models and compare."""
    whole, cost = _run(reduction.whole, program, root, repeat, fresh, tell)
    reduced, less = _run(reduction.reduced, program, root, repeat, fresh, tell)
    change = largest_change(read_curves(whole.directory), read_curves(reduced.directory), reduction.column)
    return Saving(reduction, cost, less, change)
