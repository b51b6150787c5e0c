"""Verification cases: the format of verification/cases/*.toml, checked strictly.

A file describes one deck and its variants:

    title = "..."                 one line for the list
    deck = "input/NAME.inp"       from the top of the tree
    source = "..."                source of the references

    [[quantity]]                  evaluated for every variant
    [[case]]                      a variant; its full name is FILE/NAME
    name = "steps_40"
    effort = "small"              small (also with bounds checks), quick or long
    exit_code = 0                 required exit code
    time_limit = 60               CPU seconds (per thread) after which it is stopped, ten times its usual time (default 30; 120 for long):
                                  the longest runs are started first
    expected_to_fail = "..."      why exit code or results miss, with the value obtained (see below)
    command = "run"               run, point for the test of one material point, or python: `deck` is a script that
                                  runs analyses itself, with PROGRAM and --out as arguments
    replace = [["old", "new"]]    text replacements in a copy of the deck; each must match at least once
    each = [{n = 16}, {n = 64}]   one case for each entry, {n} replaced in its texts (families.py)
    [[case.quantity]]             evaluated for this variant only

A quantity is a column of curves.csv at a position, a measure of the material points at the end, or a
trace of the whole run:

    name = "axial stress at 90 %"
    column = "axial_stress"       or: measure = "column_stress_error", arguments = {...} (measures.py)
                                  or: trace = "knee", arguments = {...} (traces.py)
    at = "last"                   last, first, max, min, every; or {load_factor = 0.5}: linear between rows
    phase = "loading"             only the rows of a phase, by name or number
    scale = -1.0                  factor on the column
    reference = 9.0               a number; or {function = "van_langen", strain = "column:NAME"};
                                  or {case = "FILE/NAME"}: the same quantity of another case
    tolerance = 1e-6              with error = "relative" (default) or "absolute"
    tolerance_below = 1e-2        for values below the reference instead of tolerance, which then applies above it
    at_least = 17.8               a bound (or at_most, or both) instead of reference and tolerance
    order_from = {case = "FILE/NAME", refinement = 64}
                                  the value is the order of convergence, log(other/own)/log(refinement);
                                  assessed by a bound
    growth_from = {case = "FILE/NAME"}
                                  the value is own/other; assessed by a bound
    print = true                  the value is printed and not asserted
    reason = "..."                reason for the tolerance
    source = "..."                overrides the file's
    expected_to_fail = "..."      why it misses, with the value obtained

An expected failure is a known defect without a remedy: it counts as passed while it misses, and as failed when
it passes, so that the mark is removed. The mark of a quantity requires a value that can be evaluated and misses; that of a
case requires any miss, including an exit code, a time limit or a value that is not reached.
"""

from __future__ import annotations

import math
import tomllib
from dataclasses import dataclass, field
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

from qsmpm_verify.families import FamilyError, expand
from qsmpm_verify.measures import MEASURES
from qsmpm_verify.reference import REFERENCES
from qsmpm_verify.traces import TRACES
from qsmpm_verify.trouble import Trouble

EFFORTS = ("small", "quick", "long")
COMMANDS = ("run", "point", "python")
PLACES = ("last", "first", "max", "min", "every")


class CaseError(Trouble):
    """Error in a case file."""


@dataclass(frozen=True)
class Quantity:
    """A result of a run and its required value."""

    name: str
    column: str | None = None
    measure: str | None = None
    trace: str | None = None
    arguments: dict[str, Any] = field(default_factory=dict)
    at: str | dict[str, float] = "last"
    phase: int | str | None = None
    scale: float = 1.0
    reference: float | dict[str, Any] | None = None
    tolerance: float | None = None
    tolerance_below: float | None = None
    error: str = "relative"
    at_least: float | None = None
    at_most: float | None = None
    order_from: dict[str, Any] | None = None
    growth_from: dict[str, Any] | None = None
    print: bool = False
    reason: str = ""
    source: str = ""
    expected_to_fail: str = ""


@dataclass(frozen=True)
class Case:
    """A deck, how to run it and its required results."""

    name: str
    title: str
    deck: Path
    quantities: tuple[Quantity, ...]
    effort: str = "quick"
    exit_code: int = 0
    time_limit: float = 120.0
    replace: tuple[tuple[str, str], ...] = ()
    command: str = "run"
    expected_to_fail: str = ""

    def needs(self) -> set[str]:
        """Names of the cases with which this one is compared."""
        tables = [t for q in self.quantities for t in (q.reference, q.order_from, q.growth_from)]
        return {table["case"] for table in tables if isinstance(table, dict) and "case" in table}


def check_keys(table: dict[str, Any], allowed: set[str], where: str) -> None:
    """An unknown key is an error."""
    for key in table:
        if key not in allowed:
            raise CaseError(f"{where}: unknown key '{key}'; known are {', '.join(sorted(allowed))}")


def _check_mark(table: dict[str, Any], where: str) -> None:
    """The reason of an expected failure must be a sentence that contains a value."""
    mark = table.get("expected_to_fail")
    if mark is not None and not (isinstance(mark, str) and any(letter.isdigit() for letter in mark)):
        raise CaseError(f"{where}: expected_to_fail must state the reason and the value obtained")


def _check_reference(reference: Any, where: str) -> None:
    if not isinstance(reference, dict):
        return
    if "case" in reference:
        check_keys(reference, {"case"}, where)
    elif reference.get("function") not in REFERENCES:
        raise CaseError(f"{where}: reference requires a case or one of the functions {', '.join(REFERENCES)}")


def _check_comparison(quantity: Quantity, where: str) -> None:
    """An order or a growth: another case, one value each, a bound or print."""
    if quantity.order_from is None and quantity.growth_from is None:
        return
    if quantity.order_from is not None and quantity.growth_from is not None:
        raise CaseError(f"{where}: either order_from or growth_from is allowed, not both")
    word = "growth_from" if quantity.order_from is None else "order_from"
    keys = {"case"} if quantity.order_from is None else {"case", "refinement"}
    table = quantity.growth_from if quantity.order_from is None else quantity.order_from
    if not isinstance(table, dict) or set(table) != keys or not isinstance(table["case"], str):
        raise CaseError(f"{where}: {word} requires {' and '.join(sorted(keys))}, with case = FILE/NAME")
    ratio = table.get("refinement", 2)
    if isinstance(ratio, bool) or not isinstance(ratio, (int, float)) or not 1 < ratio < math.inf:
        raise CaseError(f"{where}: refinement must be a number above 1")
    if quantity.reference is not None or quantity.tolerance is not None:
        raise CaseError(f"{where}: {word} requires at_least or at_most, not a reference")
    if quantity.at == "every":
        raise CaseError(f"{where}: {word} compares one value, not every row")


def _quantity(table: dict[str, Any], source: str, where: str) -> Quantity:
    where = f"{where}, quantity '{table.get('name', '?')}'"
    check_keys(table, set(Quantity.__dataclass_fields__), where)
    quantity = Quantity(**{"source": source, **table})
    if sum(given is not None for given in (quantity.column, quantity.measure, quantity.trace)) != 1:
        raise CaseError(f"{where}: exactly one of column, measure and trace is required")
    for word, name, known in (("measure", quantity.measure, MEASURES), ("trace", quantity.trace, TRACES)):
        if name is not None and name not in known:
            raise CaseError(f"{where}: unknown {word}; known are {', '.join(known)}")
    if isinstance(quantity.at, str) and quantity.at not in PLACES:
        raise CaseError(f"{where}: at must be one of {', '.join(PLACES)}, or a table of one column")
    if isinstance(quantity.at, dict) and len(quantity.at) != 1:
        raise CaseError(f"{where}: at = {{COLUMN = VALUE}} takes one column")
    if quantity.error not in ("relative", "absolute"):
        raise CaseError(f"{where}: error must be relative or absolute")
    _check_reference(quantity.reference, where)
    _check_comparison(quantity, where)
    bounded = quantity.at_least is not None or quantity.at_most is not None
    if bounded and quantity.tolerance is not None:
        raise CaseError(f"{where}: a bound takes no tolerance")
    if quantity.tolerance_below is not None and quantity.tolerance is None:
        raise CaseError(f"{where}: tolerance_below requires a tolerance for values above the reference")
    asserted = (quantity.reference is not None and quantity.tolerance is not None) or bounded
    if asserted == quantity.print:
        raise CaseError(f"{where}: reference and tolerance, a bound, or print = true is required")
    _check_mark(table, where)
    if quantity.print and quantity.expected_to_fail:
        raise CaseError(f"{where}: a value that is only printed cannot be expected to fail")
    if asserted and not (quantity.reason and quantity.source):
        raise CaseError(f"{where}: an asserted value requires a reason and a source")
    return quantity


def printed_quantity(table: dict[str, Any], source: str, where: str, free: bool = False) -> Quantity:
    """A quantity that is measured and not asserted; `free` allows one that is read from another program."""
    if free and set(table) == {"name"}:
        return Quantity(name=table["name"], print=True)
    check_keys(table, set(Quantity.__dataclass_fields__) - {"tolerance", "tolerance_below", "at_least", "at_most", "print", "expected_to_fail"}, where)
    return _quantity({**table, "print": True}, source, where)


def _case(
    entry: dict[str, Any], table: dict[str, Any], common: tuple[Quantity, ...], stem: str, top: Path, where: str
) -> Case:
    """One case from its table and that of the file."""
    check_keys(
        entry,
        {"name", "title", "deck", "effort", "exit_code", "time_limit", "replace", "quantity", "command",
         "expected_to_fail"},
        where,
    )  # fmt: skip
    _check_mark(entry, where)
    own = tuple(_quantity(q, table.get("source", ""), where) for q in entry.get("quantity", []))
    if entry.get("effort", "quick") not in EFFORTS:
        raise CaseError(f"{where}: effort must be one of {', '.join(EFFORTS)}")
    if entry.get("command", table.get("command", "run")) not in COMMANDS:
        raise CaseError(f"{where}: command must be one of {', '.join(COMMANDS)}")
    if any(len(pair) != 2 for pair in entry.get("replace", [])):
        raise CaseError(f"{where}: replace requires pairs of old and new text")
    if "name" not in entry:
        raise CaseError(f"{where}: 'name' is missing")
    return Case(
        name=f"{stem}/{entry['name']}",
        title=entry.get("title", table["title"]),
        deck=top / entry.get("deck", table["deck"]),
        quantities=common + own,
        effort=entry.get("effort", "quick"),
        exit_code=entry.get("exit_code", 0),
        time_limit=entry.get("time_limit", 120.0 if entry.get("effort") == "long" else 30.0),
        command=entry.get("command", table.get("command", "run")),
        replace=tuple((old, str(new)) for old, new in entry.get("replace", [])),
        expected_to_fail=entry.get("expected_to_fail", ""),
    )


def load_file(path: Path, top: Path) -> list[Case]:
    """The cases of one file; decks are given relative to the top of the tree."""
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except tomllib.TOMLDecodeError as error:
        raise CaseError(f"{path}: {error}") from error
    check_keys(table, {"title", "deck", "source", "quantity", "case", "command"}, str(path))
    for key in ("title", "deck", "case"):
        if key not in table:
            raise CaseError(f"{path}: '{key}' is missing")
    common = tuple(_quantity(q, table.get("source", ""), str(path)) for q in table.get("quantity", []))
    cases: list[Case] = []
    for entry in table["case"]:
        where = f"{path}, case '{entry.get('name', '?')}'"
        try:
            cases += [_case(one, table, common, path.stem, top, where) for one in expand(entry)]
        except FamilyError as error:
            raise CaseError(f"{where}: {error}") from error
    return cases


def load_all(folder: Path, top: Path) -> dict[str, Case]:
    """Every case of a folder by its full name; references to unknown cases are errors."""
    if not folder.is_dir():
        raise CaseError(f"{folder} not found: run this command inside a checkout of QSMPM, or set QSMPM_TREE to one")
    cases: dict[str, Case] = {}
    for path in sorted(folder.glob("*.toml")):
        for case in load_file(path, top):
            if case.name in cases:
                raise CaseError(f"{path}: two cases have the name {case.name}")
            cases[case.name] = case
    for case in cases.values():
        for other in case.needs():
            if other not in cases:
                raise CaseError(f"{case.name}: refers to the unknown case {other}")
    return cases


def select(cases: dict[str, Case], names: list[str], efforts: tuple[str, ...]) -> list[Case]:
    """The cases requested by name, pattern or file, of the given efforts, with the cases they depend on."""
    chosen: list[str] = []
    for name in names or ["*"]:
        found = [n for n in cases if n == name or n.split("/")[0] == name or fnmatch(n, name)]
        if not found:
            raise CaseError(f"unknown case '{name}'; `qsmpm-verify list` prints the names")
        chosen += [n for n in found if cases[n].effort in efforts]
    for name in chosen:
        chosen += [other for other in sorted(cases[name].needs()) if other not in chosen]
    return [cases[name] for name in cases if name in chosen]
