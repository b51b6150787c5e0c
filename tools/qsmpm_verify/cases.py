"""Verification cases: what verification/cases/*.toml says, checked strictly.

A file describes one deck and its variants:

    title = "..."                 one line for the list
    deck = "input/NAME.inp"       from the top of the tree
    source = "..."                where the references come from

    [[quantity]]                  asked of every variant
    [[case]]                      a variant; its full name is FILE/NAME
    name = "steps_40"
    effort = "small"              small (with bounds checks too), quick or long
    exit_code = 0                 what the program must return
    time_limit = 60               CPU seconds (of a thread) until it is stopped, ten times what it takes (30; 120 where it is long):
                                  the dearest runs first
    expected_to_fail = "..."      why exit code or figures miss, with the figure that is got (see below)
    command = "run"               run, point for the test of one material point, or python: `deck` is a script that
                                  runs analyses itself, with PROGRAM and --out as words
    replace = [["old", "new"]]    text replacements in a copy of the deck; each must hit once or more
    each = [{n = 16}, {n = 64}]   one case an entry, {n} replaced in its texts (families.py)
    [[case.quantity]]             asked of this variant only

A quantity is a column of curves.csv at a place, a measure of the material points at the end, or a
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
    tolerance_below = 1e-2        for figures below the reference in place of tolerance, which then holds above it
    at_least = 17.8               a bound (or at_most, or both) in place of reference and tolerance
    order_from = {case = "FILE/NAME", refinement = 64}
                                  the figure is the order of convergence, log(other/own)/log(refinement);
                                  judged by a bound
    growth_from = {case = "FILE/NAME"}
                                  the figure is own/other; judged by a bound
    print = true                  the figure is printed and not asserted
    reason = "..."                why this tolerance
    source = "..."                overrides the file's
    expected_to_fail = "..."      why it misses, with the figure that is got

What is expected to fail is a fault that is known and not cured: it counts as passed while it misses, and as failed when
it holds, so that the mark is taken off. The mark of a figure asks for a figure that is there and off; that of a
case for any miss, an exit code, a limit of time or a figure that is not reached among them.
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
    """A case file is not right."""


@dataclass(frozen=True)
class Quantity:
    """A figure of a run and what it must be."""

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
    """A deck, how to run it and what its results must be."""

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
        """Names of the cases this one is compared with."""
        tables = [t for q in self.quantities for t in (q.reference, q.order_from, q.growth_from)]
        return {table["case"] for table in tables if isinstance(table, dict) and "case" in table}


def check_keys(table: dict[str, Any], allowed: set[str], where: str) -> None:
    """A key nobody knows is an error."""
    for key in table:
        if key not in allowed:
            raise CaseError(f"{where}: unknown key '{key}'; known are {', '.join(sorted(allowed))}")


def _check_mark(table: dict[str, Any], where: str) -> None:
    """What is expected to fail says what it gets: a sentence with a figure in it."""
    mark = table.get("expected_to_fail")
    if mark is not None and not (isinstance(mark, str) and any(letter.isdigit() for letter in mark)):
        raise CaseError(f"{where}: expected_to_fail says the reason, with the figure that is got")


def _check_reference(reference: Any, where: str) -> None:
    if not isinstance(reference, dict):
        return
    if "case" in reference:
        check_keys(reference, {"case"}, where)
    elif reference.get("function") not in REFERENCES:
        raise CaseError(f"{where}: reference needs a case or a function out of {', '.join(REFERENCES)}")


def _check_comparison(quantity: Quantity, where: str) -> None:
    """An order or a growth: another case, one figure each, a bound or print."""
    if quantity.order_from is None and quantity.growth_from is None:
        return
    if quantity.order_from is not None and quantity.growth_from is not None:
        raise CaseError(f"{where}: give either order_from or growth_from")
    word = "growth_from" if quantity.order_from is None else "order_from"
    keys = {"case"} if quantity.order_from is None else {"case", "refinement"}
    table = quantity.growth_from if quantity.order_from is None else quantity.order_from
    if not isinstance(table, dict) or set(table) != keys or not isinstance(table["case"], str):
        raise CaseError(f"{where}: {word} takes {' and '.join(sorted(keys))}, case is FILE/NAME")
    ratio = table.get("refinement", 2)
    if isinstance(ratio, bool) or not isinstance(ratio, (int, float)) or not 1 < ratio < math.inf:
        raise CaseError(f"{where}: refinement is a number above 1")
    if quantity.reference is not None or quantity.tolerance is not None:
        raise CaseError(f"{where}: {word} is judged by at_least or at_most, not by a reference")
    if quantity.at == "every":
        raise CaseError(f"{where}: {word} compares one figure, not every row")


def _quantity(table: dict[str, Any], source: str, where: str) -> Quantity:
    where = f"{where}, quantity '{table.get('name', '?')}'"
    check_keys(table, set(Quantity.__dataclass_fields__), where)
    quantity = Quantity(**{"source": source, **table})
    if sum(given is not None for given in (quantity.column, quantity.measure, quantity.trace)) != 1:
        raise CaseError(f"{where}: give either a column, a measure or a trace")
    for word, name, known in (("measure", quantity.measure, MEASURES), ("trace", quantity.trace, TRACES)):
        if name is not None and name not in known:
            raise CaseError(f"{where}: unknown {word}; known are {', '.join(known)}")
    if isinstance(quantity.at, str) and quantity.at not in PLACES:
        raise CaseError(f"{where}: at is one of {', '.join(PLACES)}, or a table of one column")
    if isinstance(quantity.at, dict) and len(quantity.at) != 1:
        raise CaseError(f"{where}: at = {{COLUMN = VALUE}} takes one column")
    if quantity.error not in ("relative", "absolute"):
        raise CaseError(f"{where}: error is relative or absolute")
    _check_reference(quantity.reference, where)
    _check_comparison(quantity, where)
    bounded = quantity.at_least is not None or quantity.at_most is not None
    if bounded and quantity.tolerance is not None:
        raise CaseError(f"{where}: a bound takes no tolerance")
    if quantity.tolerance_below is not None and quantity.tolerance is None:
        raise CaseError(f"{where}: tolerance_below takes a tolerance for figures above the reference")
    asserted = (quantity.reference is not None and quantity.tolerance is not None) or bounded
    if asserted == quantity.print:
        raise CaseError(f"{where}: give reference and tolerance, a bound, or print = true")
    _check_mark(table, where)
    if quantity.print and quantity.expected_to_fail:
        raise CaseError(f"{where}: a figure that is only printed is not expected to fail")
    if asserted and not (quantity.reason and quantity.source):
        raise CaseError(f"{where}: an asserted figure names its reason and its source")
    return quantity


def printed_quantity(table: dict[str, Any], source: str, where: str, free: bool = False) -> Quantity:
    """A quantity that is measured and not asserted; `free` allows one that is read elsewhere."""
    if free and set(table) == {"name"}:
        return Quantity(name=table["name"], print=True)
    check_keys(table, set(Quantity.__dataclass_fields__) - {"tolerance", "tolerance_below", "at_least", "at_most", "print", "expected_to_fail"}, where)
    return _quantity({**table, "print": True}, source, where)


def _case(
    entry: dict[str, Any], table: dict[str, Any], common: tuple[Quantity, ...], stem: str, top: Path, where: str
) -> Case:
    """One case out of its table and the file's."""
    check_keys(
        entry,
        {"name", "title", "deck", "effort", "exit_code", "time_limit", "replace", "quantity", "command",
         "expected_to_fail"},
        where,
    )  # fmt: skip
    _check_mark(entry, where)
    own = tuple(_quantity(q, table.get("source", ""), where) for q in entry.get("quantity", []))
    if entry.get("effort", "quick") not in EFFORTS:
        raise CaseError(f"{where}: effort is one of {', '.join(EFFORTS)}")
    if entry.get("command", table.get("command", "run")) not in COMMANDS:
        raise CaseError(f"{where}: command is one of {', '.join(COMMANDS)}")
    if any(len(pair) != 2 for pair in entry.get("replace", [])):
        raise CaseError(f"{where}: replace takes pairs of old and new text")
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
    """The cases of one file; decks are found from the top of the tree."""
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
        raise CaseError(f"{folder} is not there: call this inside a checkout of QSMPM, or name one in QSMPM_TREE")
    cases: dict[str, Case] = {}
    for path in sorted(folder.glob("*.toml")):
        for case in load_file(path, top):
            if case.name in cases:
                raise CaseError(f"{path}: two cases are called {case.name}")
            cases[case.name] = case
    for case in cases.values():
        for other in case.needs():
            if other not in cases:
                raise CaseError(f"{case.name}: refers to the unknown case {other}")
    return cases


def select(cases: dict[str, Case], names: list[str], efforts: tuple[str, ...]) -> list[Case]:
    """The cases asked for by name, pattern or file, of the efforts given, with those they need."""
    chosen: list[str] = []
    for name in names or ["*"]:
        found = [n for n in cases if n == name or n.split("/")[0] == name or fnmatch(n, name)]
        if not found:
            raise CaseError(f"no case '{name}'; `qsmpm-verify list` tells the names")
        chosen += [n for n in found if cases[n].effort in efforts]
    for name in chosen:
        chosen += [other for other in sorted(cases[name].needs()) if other not in chosen]
    return [cases[name] for name in cases if name in chosen]
