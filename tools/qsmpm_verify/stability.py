"""Tests of the stability map: the format of verification/stability/*.toml, checked strictly.

methods.toml lists the columns: a name and the texts that tests insert into their decks. Every other file is a row:

    id = "S2"                     a letter and a number
    title = "..."                 what is tested
    asks = "..."                  what is required of a method
    deck = "input/NAME.inp"       from the top of the tree
    replace = [["old", "{method}"], ["PER ELEMENT=4", "PER ELEMENT={points}"]]
    ends = [0]                    exit codes of a valid result; others are reported failures
    good = 1e-3                   largest value that passes
    fair = 5e-2                   largest value rated degraded; above it the test has failed
    states = "largest"            the value is a stress error, which runs also estimate: "mean" or
                                  "largest". A failure counts as reported only if the run warns and states at least half of it
    time_limit = 120
    only = ["FEM"]                applicable methods; skip = [...] methods that are not; skip_reason states why

    [figure]                      a quantity as in a case (cases.py): the error if it has a reference, else the
    name = "..."                  value itself. Without it only the exit code is assessed

    [also.FEM]                    differences for one method: deck, replace
    command = ["conditioning"]    another program of the same build instead of a deck, read by
    pattern = '(?P<figure>...)'   with the texts of the method inserted
"""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from qsmpm_verify.cases import Case, CaseError, Quantity, check_keys, printed_quantity
from qsmpm_verify.families import FamilyError, fill

TEST_KEYS = {
    "id", "title", "asks", "deck", "replace", "ends", "good", "fair", "time_limit", "only", "skip", "skip_reason",
    "figure", "also", "command", "pattern", "states",
}  # fmt: skip
METHOD_KEYS = {"name", "method", "points", "basis", "integration"}


@dataclass(frozen=True)
class Trial:
    """One field of the map: a deck with one method, or a command of another program."""

    method: str
    case: Case
    pattern: str = ""


@dataclass(frozen=True)
class Test:
    """One row of the map."""

    id: str
    title: str
    asks: str
    ends: tuple[int, ...]
    good: float
    fair: float
    figure: Quantity | None
    command: tuple[str, ...]
    trials: tuple[Trial, ...]
    skip_reason: str
    states: str = ""


def _read(path: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise CaseError(f"{path}: {error.strerror}") from error
    except tomllib.TOMLDecodeError as error:
        raise CaseError(f"{path}: {error}") from error


def load_methods(folder: Path) -> list[dict[str, Any]]:
    """The columns of the map."""
    path = folder / "methods.toml"
    table = _read(path)
    check_keys(table, {"method"}, str(path))
    for method in table["method"]:
        if set(method) != METHOD_KEYS:
            raise CaseError(f"{path}: a method has {', '.join(sorted(METHOD_KEYS))}")
    return list(table["method"])


def _trial(table: dict[str, Any], words: dict[str, Any], stem: str, top: Path, where: str) -> Trial:
    """The field of a row for one method."""
    also = table.get("also", {}).get(words["name"], {})
    check_keys(also, {"deck", "replace"}, f"{where}, also.{words['name']}")
    own = {**table, **also}
    try:
        replace = fill(own.get("replace", []), words, set())
    except FamilyError as error:
        raise CaseError(f"{where}: {error}") from error
    case = Case(
        name=f"{stem}/{words['name']}",
        title=table["title"],
        deck=top / own.get("deck", ""),
        quantities=(),
        time_limit=float(table.get("time_limit", 120.0)),
        replace=tuple((old, str(new)) for old, new in replace),
    )
    pattern = table.get("pattern", "")
    for word in ("basis", "integration"):
        pattern = pattern.replace("{" + word + "}", re.escape(str(words[word])))
    return Trial(words["name"], case, pattern)


def load_test(path: Path, methods: list[dict[str, Any]], top: Path) -> Test:
    """One row of the map."""
    table, where = _read(path), str(path)
    check_keys(table, TEST_KEYS, where)
    for key in ("id", "title", "asks"):
        if not table.get(key):
            raise CaseError(f"{where}: '{key}' is missing")
    if ("deck" in table) == ("command" in table) or ("command" in table) != ("pattern" in table):
        raise CaseError(f"{where}: a deck, or a command with a pattern, is required")
    figure = None
    if "figure" in table:
        figure = printed_quantity(table["figure"], "", where, free="command" in table)
        if not isinstance(table.get("good"), (int, float)) or not isinstance(table.get("fair"), (int, float)):
            raise CaseError(f"{where}: a figure requires good and fair")
        if table["good"] > table["fair"]:
            raise CaseError(f"{where}: good must not exceed fair")
    if table.get("states", "mean") not in ("mean", "largest") or ("states" in table and "figure" not in table):
        raise CaseError(f"{where}: states must be mean or largest and requires a figure")
    names = [method["name"] for method in methods]
    for name in (*table.get("only", []), *table.get("skip", []), *table.get("also", {})):
        if name not in names:
            raise CaseError(f"{where}: unknown method '{name}'; known are {', '.join(names)}")
    wanted = [n for n in table.get("only", names) if n not in table.get("skip", [])]
    if len(wanted) < len(names) and not table.get("skip_reason"):
        raise CaseError(f"{where}: skip requires a skip_reason")
    trials = tuple(_trial(table, m, path.stem, top, where) for m in methods if m["name"] in wanted)
    return Test(
        table["id"], table["title"], table["asks"], tuple(table.get("ends", [0])), float(table.get("good", 0.0)),
        float(table.get("fair", 0.0)), figure, tuple(table.get("command", [])), trials, table.get("skip_reason", ""),
        table.get("states", ""),
    )  # fmt: skip


def load_rows(folder: Path, top: Path, names: list[str]) -> tuple[list[str], list[Test]]:
    """The columns of the map and the requested rows, default all, in the order of their numbers."""
    methods = load_methods(folder)
    paths = [path for path in sorted(folder.glob("*.toml")) if path.name != "methods.toml"]
    tests = [load_test(path, methods, top) for path in paths]
    known = [test.id for test in tests]
    if len(set(known)) != len(known):
        raise CaseError(f"{folder}: two tests have the same id")
    for name in names:
        if name.upper() not in known:
            raise CaseError(f"unknown test '{name}'; known are {', '.join(known)}")
    wanted = {name.upper() for name in names} or set(known)
    return [method["name"] for method in methods], [test for test in tests if test.id in wanted]
