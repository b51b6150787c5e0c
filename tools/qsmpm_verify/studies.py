"""Studies of error against cost: the format of verification/studies/*.toml, checked strictly.

title = "..."                 one line
deck = "input/NAME.inp"       from the top of the tree
size = "cells over the height"   meaning of the size of an entry; orders of convergence are fitted over it
source = "..."                source of the reference of the error
note = "..."                  additional sentence below the table
bounds = 1.0                  limit analysis of the deck, times this factor, is added to the chart; the reference must be a function
floor = 1e-12                 smaller errors are set to it: round-off, or the accuracy of the reference

[error]                       the error: a quantity as in a case (cases.py), without tolerance.
name = "stress error"         With a reference: the difference from it, relative unless error = "absolute";
measure = "..."               without one: the value itself is the error

[[method]]                    one line of the chart
label = "GIMP, 4 points"
each = [{n = 16}, {n = 64}]   one run for each entry (families.py), in order of increasing size
size = "{n}"
effort = "quick"              small, quick or long, as in a case
replace = [["old", "new"]]    in the deck
exit_codes = [0]              exit codes that the program may return
time_limit = 300
command = ["manufactured", "BASIS=GIMP", "4", "2", "{n}", "20"]
                              another program of the same build instead of the deck; its last line is read
pattern = '(?P<error>...) ... (?P<seconds>...)'   with this expression, given once for the study

[[other]]                     stored results of another code
label = "..."
points = [[size, error, seconds], ...]
caveat = "..."                how they differ from those of QSMPM
source = "..."
"""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from qsmpm_verify.cases import EFFORTS, Case, CaseError, Quantity, check_keys, printed_quantity
from qsmpm_verify.families import FamilyError, expand

STUDY_KEYS = {"title", "deck", "size", "source", "note", "floor", "bounds", "error", "pattern", "method", "other"}
METHOD_KEYS = {"label", "name", "size", "effort", "replace", "exit_codes", "time_limit", "command"}


@dataclass(frozen=True)
class Entry:
    """One run of a method."""

    case: Case
    size: float
    exit_codes: tuple[int, ...]
    command: tuple[str, ...] = ()


@dataclass(frozen=True)
class Method:
    """One line of the chart."""

    label: str
    entries: tuple[Entry, ...]


@dataclass(frozen=True)
class Other:
    """Results of another code, stored or computed here: size (NaN if unknown), error, seconds."""

    label: str
    points: tuple[tuple[float, float, float], ...]
    caveat: str
    source: str
    how: str = "stored"


@dataclass(frozen=True)
class Study:
    """A scene, its error, the methods that compute it and results of other codes."""

    name: str
    title: str
    size: str
    source: str
    note: str
    error: Quantity
    pattern: str
    floor: float
    methods: tuple[Method, ...]
    others: tuple[Other, ...]
    bounds: float = 0.0


def _entry(table: dict[str, Any], study: dict[str, Any], name: str, top: Path, where: str) -> Entry:
    """One run of a method's table with its placeholders replaced."""
    check_keys(table, METHOD_KEYS, where)
    try:
        size = float(table["size"])
    except (KeyError, TypeError, ValueError):
        raise CaseError(f"{where}: size must be a number") from None
    if table.get("effort", "quick") not in EFFORTS:
        raise CaseError(f"{where}: effort must be one of {', '.join(EFFORTS)}")
    if "command" not in table and "deck" not in study:
        raise CaseError(f"{where}: a deck of the study or a command is required")
    if "command" in table and "pattern" not in study:
        raise CaseError(f"{where}: a command requires the pattern of the study")
    case = Case(
        name=name,
        title=study["title"],
        deck=top / study.get("deck", ""),
        quantities=(),
        effort=table.get("effort", "quick"),
        time_limit=float(table.get("time_limit", 300.0)),
        replace=tuple((old, str(new)) for old, new in table.get("replace", [])),
    )
    return Entry(case, size, tuple(table.get("exit_codes", [0])), tuple(str(w) for w in table.get("command", [])))


def _method(table: dict[str, Any], study: dict[str, Any], stem: str, top: Path, where: str) -> Method:
    """One line of the chart; its runs are named STUDY/LABEL_SIZE."""
    if not isinstance(table.get("label"), str) or "{" in table["label"]:
        raise CaseError(f"{where}: label must be a text without words in braces")
    where = f"{where}, method '{table['label']}'"
    short = re.sub(r"\W+", "_", table["label"].lower()).strip("_")
    try:
        members = expand({**table, "name": table.get("name", "{n}") if "each" in table else "run"})
    except FamilyError as error:
        raise CaseError(f"{where}: {error}") from error
    entries = tuple(_entry(m, study, f"{stem}/{short}_{m['name']}", top, where) for m in members)
    if any(a.size >= b.size for a, b in zip(entries, entries[1:])):
        raise CaseError(f"{where}: sizes must increase from entry to entry")
    return Method(table["label"], entries)


def _other(table: dict[str, Any], where: str) -> Other:
    check_keys(table, {"label", "points", "caveat", "source"}, where)
    for key in ("label", "points", "caveat", "source"):
        if not table.get(key):
            raise CaseError(f"{where}: results of another code require {key}")
    given = [[float(v) for v in point] for point in table["points"]]
    if any(len(point) != 3 or min(point) <= 0 for point in given):
        raise CaseError(f"{where}: points must be [size, error, seconds], all positive")
    points = tuple((size, error, seconds) for size, error, seconds in given)
    return Other(table["label"], points, table["caveat"], table["source"])


def load_study(path: Path, top: Path) -> Study:
    """The study of one file."""
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise CaseError(f"{path}: {error.strerror}") from error
    except tomllib.TOMLDecodeError as error:
        raise CaseError(f"{path}: {error}") from error
    check_keys(table, STUDY_KEYS, str(path))
    for key in ("title", "size", "source", "error", "method"):
        if key not in table:
            raise CaseError(f"{path}: '{key}' is missing")
    if "pattern" in table and not {"error", "seconds"} <= set(re.compile(table["pattern"]).groupindex):
        raise CaseError(f"{path}: pattern must have the groups error and seconds")
    methods = tuple(_method(m, table, path.stem, top, str(path)) for m in table["method"])
    names = [entry.case.name for method in methods for entry in method.entries]
    if len(set(names)) != len(names):
        raise CaseError(f"{path}: two runs have the same name; labels must differ")
    return Study(
        path.stem, table["title"], table["size"], table["source"], table.get("note", ""),
        printed_quantity(table["error"], table["source"], str(path), free="pattern" in table),
        table.get("pattern", ""), float(table.get("floor", 0.0)), methods,
        tuple(_other(o, str(path)) for o in table.get("other", [])), float(table.get("bounds", 0.0)),
    )  # fmt: skip


def load_studies(folder: Path, top: Path, names: list[str]) -> list[Study]:
    """The requested studies, default all; the path of a file is accepted as well."""
    if not folder.is_dir() and not names:
        raise CaseError(f"{folder} not found: run this command inside a checkout of QSMPM, or set QSMPM_TREE to one")
    known = {path.stem: path for path in sorted(folder.glob("*.toml"))}
    chosen: list[Path] = []
    for name in names or list(known):
        path = known.get(name, Path(name))
        if name not in known and path.suffix != ".toml":
            raise CaseError(f"unknown study '{name}'; known are {', '.join(known) or 'none'}")
        chosen.append(path)
    return [load_study(path, top) for path in chosen]
