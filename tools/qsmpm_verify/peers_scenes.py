"""Scenes that other programs also compute: the format of verification/peers/*.toml, checked strictly.

title = "..."                 one line
deck = "input/NAME.inp"       of QSMPM, from the top of the tree
note = "..."                  which laws and elements are compared and why the comparison is valid

[[run]]                       one computation
name = "fem"
program = "qsmpm"             qsmpm (default), calculix, kratos, ogs, script, xslope or bounds
effort = "quick"              quick (default) or long
replace = [["old", "new"]]    qsmpm: in the deck; `deck` names another one
make = [["FILE", "SCRIPT", "WORD"]]   qsmpm: files written beside the deck, the output of a script of the tree
of = "fem"                    calculix, kratos, ogs: the run whose mesh, supports and loads are used; xslope, bounds: whose deck is used
element = "CPE8R"             calculix, kratos: if not the default for the cells
law = "NEO HOOKE"             calculix: ELASTIC (default) or NEO HOOKE
steps = 20                    calculix, kratos: steps of a finite deformation; 0 (default) is linear
command = ["kratos_column.py", "16"]  script: of tools/peers, with its arguments
phase = "factor"              xslope, bounds: the phase whose state is used
method = "bishop"             xslope: of limit equilibrium, or seepage with cells of `size`
grid = false                  xslope: no additional search of circles from a grid of centres
each = [{n = 8}]              one run an entry (families.py)

[[check]]
of = "fem"                    the run that is assessed
against = "ccx"               another run; or reference = 1.5, or reference = {function = "..."}
quantity = "field"            field: largest difference of displacements over all nodes by the largest displacement;
                              pressure field: the same for the excess pore pressures of nodes;
                              reaction: largest component of the support reactions; or a history, or a value of a script
limit_of = ["a", "b"]         instead of `of`: the limit of three or more runs with successively halved cells (Aitken)
scale = 1.0                   factor on the value
tolerance = 1e-6              relative, with reason = "..."; or print = true
name = "..."                  of the line, default the quantity

[[point]]                     of a chart of error against cost
study = "cantilever"          of verification/studies
label = "Kratos MPM"
run = "..."
quantity = "tip_deflection"
reference = 8.2539            the error is the relative difference from it; without one the value is the error
size = 4
note = "..."
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from qsmpm_verify.cases import CaseError, check_keys
from qsmpm_verify.families import FamilyError, expand
from qsmpm_verify.reference import REFERENCES

FIELDS = ("field", "pressure field")
KEYS = {
    "qsmpm": {"deck", "replace", "make"}, "calculix": {"of", "element", "law", "steps"},
    "kratos": {"of", "element", "steps"}, "ogs": {"of"}, "script": {"command"},
    "xslope": {"of", "phase", "method", "size", "grid"}, "bounds": {"of", "phase"},
}  # fmt: skip
CHECK_KEYS = {"of", "against", "reference", "quantity", "limit_of", "scale", "tolerance", "reason", "print", "name"}
POINT_KEYS = {"study", "label", "run", "quantity", "reference", "size", "note"}


@dataclass(frozen=True)
class PeerRun:
    """One computation of a scene."""

    name: str
    program: str
    effort: str
    words: dict[str, Any]


@dataclass(frozen=True)
class Check:
    """A value of a run, or the limit of several, compared with another run or a reference."""

    runs: tuple[str, ...]
    against: str
    reference: float | dict[str, Any] | None
    quantity: str
    scale: float
    tolerance: float | None
    reason: str
    name: str

    def needs(self) -> tuple[str, ...]:
        """Runs that are required for a verdict."""
        return self.runs + ((self.against,) if self.against else ())


@dataclass(frozen=True)
class Point:
    """A point of a chart of error against cost."""

    study: str
    label: str
    run: str
    quantity: str
    reference: float | None
    size: float
    note: str


@dataclass(frozen=True)
class Scene:
    """A scene, its runs in the order of their dependencies, and its checks."""

    name: str
    title: str
    deck: Path
    note: str
    runs: dict[str, PeerRun]
    checks: tuple[Check, ...]
    points: tuple[Point, ...] = field(default=())


def _run(table: dict[str, Any], known: dict[str, PeerRun], where: str) -> PeerRun:
    program = table.get("program", "qsmpm")
    if program not in KEYS:
        raise CaseError(f"{where}: program must be one of {', '.join(KEYS)}")
    check_keys(table, {"name", "program", "effort"} | KEYS[program], where)
    if table.get("effort", "quick") not in ("quick", "long"):
        raise CaseError(f"{where}: effort must be quick or long")
    if "of" in KEYS[program] and getattr(known.get(table.get("of", "")), "program", "") != "qsmpm":
        raise CaseError(f"{where}: of must name an earlier run of qsmpm")
    words = {key: value for key, value in table.items() if key in KEYS[program]}
    return PeerRun(table["name"], program, table.get("effort", "quick"), words)


def _runs(tables: list[dict[str, Any]], where: str) -> dict[str, PeerRun]:
    runs: dict[str, PeerRun] = {}
    for table in tables:
        if "name" not in table:
            raise CaseError(f"{where}: a run requires a name")
        try:
            members = expand(table)
        except FamilyError as error:
            raise CaseError(f"{where}, run '{table['name']}': {error}") from error
        for member in members:
            if member["name"] in runs:
                raise CaseError(f"{where}: two runs have the name {member['name']}")
            runs[member["name"]] = _run(member, runs, f"{where}, run '{member['name']}'")
    return runs


def _check(table: dict[str, Any], runs: dict[str, PeerRun], where: str) -> Check:
    where = f"{where}, check of '{table.get('of', table.get('limit_of'))}'"
    check_keys(table, CHECK_KEYS, where)
    if ("of" in table) == ("limit_of" in table) or ("against" in table) == ("reference" in table):
        raise CaseError(f"{where}: of or limit_of, and against or reference, are required")
    reference = table.get("reference")
    if isinstance(reference, dict) and reference.get("function") not in REFERENCES:
        raise CaseError(f"{where}: reference must be a number or name a function")
    if ("tolerance" in table) == bool(table.get("print")) or ("tolerance" in table and not table.get("reason")):
        raise CaseError(f"{where}: tolerance and reason, or print = true, are required")
    if not isinstance(table.get("quantity"), str):
        raise CaseError(f"{where}: quantity is missing")
    chosen = tuple(table.get("limit_of", ())) or (table["of"],)
    if len(chosen) == 2 or (len(chosen) > 1 and table["quantity"] in (*FIELDS, "reaction")):
        raise CaseError(f"{where}: a limit requires a history or value of three runs or more")
    check = Check(
        chosen, table.get("against", ""), reference, table["quantity"], float(table.get("scale", 1.0)),
        table.get("tolerance"), table.get("reason", "printed, not assessed"), table.get("name", table["quantity"]),
    )  # fmt: skip
    for name in check.needs():
        if name not in runs:
            raise CaseError(f"{where}: unknown run '{name}'; known are {', '.join(runs)}")
    return check


def _points(tables: list[dict[str, Any]], runs: dict[str, PeerRun], where: str) -> list[Point]:
    points = []
    for table in tables:
        for member in expand({"name": table.get("run", ""), **table}):
            entry = {key: value for key, value in member.items() if key != "name"}
            check_keys(entry, POINT_KEYS, f"{where}, point '{entry.get('label')}'")
            if entry.get("run") not in runs or not {"study", "label", "quantity", "size"} <= set(entry):
                raise CaseError(f"{where}, point '{entry.get('label')}': study, label, quantity, size and a known run are required")
            reference = entry.get("reference")
            points.append(Point(
                entry["study"], entry["label"], entry["run"], entry["quantity"],
                None if reference is None else float(reference), float(entry["size"]), entry.get("note", ""),
            ))  # fmt: skip
    return points


def load_scene(path: Path, top: Path) -> Scene:
    """The scene of one file."""
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except tomllib.TOMLDecodeError as error:
        raise CaseError(f"{path}: {error}") from error
    check_keys(table, {"title", "deck", "note", "run", "check", "point"}, str(path))
    for key in ("title", "deck", "note", "run"):
        if key not in table:
            raise CaseError(f"{path}: '{key}' is missing")
    runs = _runs(table["run"], str(path))
    checks = tuple(_check(entry, runs, str(path)) for entry in table.get("check", []))
    points = tuple(_points(table.get("point", []), runs, str(path)))
    return Scene(path.stem, table["title"], top / table["deck"], table["note"], runs, checks, points)


def load_scenes(folder: Path, top: Path, names: list[str]) -> list[Scene]:
    """The requested scenes, default all."""
    known = {path.stem: path for path in sorted(folder.glob("*.toml"))}
    for name in names:
        if name not in known:
            raise CaseError(f"unknown scene '{name}'; known are {', '.join(known)}")
    return [load_scene(known[name], top) for name in names or known]
