"""`curve`: compare a result with a formula of the library or a table, with error norms and a figure; or plot it alone.

The result is the folder of a run, its curves.csv or any CSV with a line of headings `name [unit]`. A table is
read in the same way and interpolated linearly; the norms include the rows of the result within its range.
"""

from __future__ import annotations

import argparse
import json
import math
from dataclasses import asdict, dataclass
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from qsmpm_verify.formula import Formula, read_formula, signed_column
from qsmpm_verify.plots import first_history, save
from qsmpm_verify.results import Array, Curves, ResultError, how_it_ended, read_curves
from qsmpm_verify.told import read_phase
from qsmpm_verify.trouble import Trouble
from qsmpm_verify.units import kind_of, mismatch, wrong_kind


@dataclass(frozen=True)
class Comparison:
    """Two curves at the same positions, and their difference."""

    x_name: str
    y_name: str
    x_unit: str
    y_unit: str
    x: Array
    y: Array
    reference: Array
    left_out: int

    def norms(self) -> Norms:
        """Norms of the difference; relative ones refer to the largest reference."""
        gap = np.abs(self.y - self.reference)
        worst = int(np.argmax(gap))
        size = float(np.abs(self.reference).max())

        def share(value: float) -> float:
            return value / size if size > 0 else math.inf if value > 0 else 0.0

        rms, end = float(np.sqrt(np.mean(gap**2))), float(gap[-1])
        return Norms(
            len(gap), self.left_out, float(gap[worst]), share(float(gap[worst])), float(self.x[worst]), rms, share(rms),
            float(self.y[-1]), float(self.reference[-1]), end, share(end),
        )  # fmt: skip


@dataclass(frozen=True)
class Norms:
    """Errors of a curve in its unit, and relative to the largest reference."""

    rows: int
    rows_left_out: int
    largest: float
    largest_share: float
    largest_at: float
    rms: float
    rms_share: float
    end_value: float
    end_reference: float
    end: float
    end_share: float


def open_result(path: Path, unfinished: bool) -> Curves:
    """The curves of a finished run, or of a table without a run."""
    curves = read_curves(path)
    reason = how_it_ended(curves.path.parent) if curves.path.name == "curves.csv" else None
    if reason is None:
        return curves
    if reason and not unfinished:
        raise ResultError(f"{curves.path}: the run did not finish ({reason}); --unfinished accepts it")
    if not curves.path.read_bytes().endswith(b"\n") and not unfinished:
        raise ResultError(f"{curves.path}: the last line is incomplete; --unfinished accepts it")
    return curves


def _plain(name: str) -> str:
    """Name of a column without its sign."""
    return name.removeprefix("-")


def _scaled(name: str, factor: float) -> str:
    """Name of a column with its factor."""
    return name if factor == 1 else f"{factor:g} {name}"


def _finite(values: Array, what: str) -> Array:
    if not np.all(np.isfinite(values)):
        raise ResultError(f"{what}: row {int(np.argmax(~np.isfinite(values))) + 1} is not a finite number")
    return values


def _table_column(table: Curves, wanted: str | None, fallback: str, place: int) -> str:
    """Column of a table: the requested one, the one of the same name, or the first or second numerical one."""
    if wanted:
        return wanted
    if _plain(fallback) in table.columns:
        return fallback
    names = list(table.columns)
    if len(names) <= place:
        raise ResultError(f"{table.path}: a table requires two columns of numbers")
    return names[place]


def table_values(table: Curves, x_name: str, y_name: str, x: Array) -> Array:
    """A table at the positions x, interpolated linearly; NaN outside its range."""
    own_x = _finite(signed_column(table, x_name), str(table.path))
    own_y = _finite(signed_column(table, y_name), str(table.path))
    order = np.argsort(own_x, kind="stable")
    if len(own_x) < 2 or np.any(np.diff(own_x[order]) <= 0):
        raise ResultError(f"{table.path}: {x_name} has fewer than two values or a repeated value; --against-x selects another column")
    slack = 1e-9 * float(own_x.max() - own_x.min())
    inside = (x >= own_x.min() - slack) & (x <= own_x.max() + slack)
    return np.where(inside, np.interp(x, own_x[order], own_y[order]), np.nan)


def _check_units(words: argparse.Namespace, pairs: list[tuple[str, str]]) -> None:
    """A factor given by the user determines the unit that it changes."""
    for name, reason in pairs:
        if reason and not words.any_unit:
            raise ResultError(f"{name}: {reason}; --scale, --x-scale or --any-unit resolves it")


def against_table(words: argparse.Namespace, own: tuple[str, str], units: tuple[str, str], x: Array) -> Array:
    """The table named on the command line, at the positions x; units and columns are checked."""
    table = open_result(Path(words.against), words.unfinished)
    other_x = _table_column(table, words.against_x, own[0], 0)
    other_y = _table_column(table, words.against_y, own[1], 1)
    theirs = [table.units.get(_plain(name), "") for name in (other_x, other_y)]
    _check_units(words, [
        (own[0], mismatch(units[0], theirs[0]) if abs(words.x_scale) == 1 else ""),
        (own[1], mismatch(units[1], theirs[1]) if abs(words.scale) == 1 else ""),
    ])  # fmt: skip
    return table_values(table, other_x, other_y, x)


def compare(words: argparse.Namespace) -> Comparison:
    """The comparison requested on the command line."""
    curves = open_result(words.result, words.unfinished)
    rows = np.arange(len(curves)) if words.phase is None else curves.rows_of_phase(words.phase)
    formula: Formula | None = None
    if words.against.startswith("function:"):
        formula = read_formula(words.against.removeprefix("function:"))
    x_name = words.x or (next(iter(formula.columns.values()), None) if formula else None) or "load_factor"
    y_name = words.y or first_history(curves, beside=_plain(x_name))
    x = words.x_scale * _finite(signed_column(curves, x_name)[rows], f"{curves.path}: {x_name}")
    y = words.scale * _finite(signed_column(curves, y_name)[rows], f"{curves.path}: {y_name}")
    units = curves.units.get(_plain(x_name), ""), curves.units.get(_plain(y_name), "")
    if formula:
        wrong = wrong_kind(units[1], kind_of(formula.function)) if abs(words.scale) == 1 else ""
        _check_units(words, [(y_name, wrong)])
        reference = formula.along(curves, rows)
    else:
        reference = against_table(words, (x_name, y_name), units, x)
    covered = np.isfinite(reference)
    if not covered.any():
        span = f"{x_name} from {x.min():g} to {x.max():g}"
        raise ResultError(f"{words.against}: no row of {curves.path} is within its range ({span})")
    x_name, y_name = _scaled(x_name, words.x_scale), _scaled(y_name, words.scale)
    return Comparison(x_name, y_name, *units, x[covered], y[covered], reference[covered], int(np.sum(~covered)))


def tell(words: argparse.Namespace) -> int:
    """A result without a reference: its value at the end, the smallest and the largest."""
    if words.json or words.tolerance is not None:
        raise Trouble("--json and --tolerance require --against")
    curves = open_result(words.result, words.unfinished)
    rows = np.arange(len(curves)) if words.phase is None else curves.rows_of_phase(words.phase)
    x_name = words.x or "load_factor"
    y_name = words.y or first_history(curves, beside=_plain(x_name))
    x = words.x_scale * _finite(signed_column(curves, x_name)[rows], f"{curves.path}: {x_name}")
    y = words.scale * _finite(signed_column(curves, y_name)[rows], f"{curves.path}: {y_name}")
    unit = curves.units.get(_plain(y_name), "") if words.scale == 1 else ""
    print(f"{_scaled(y_name, words.scale)} of {words.result}" + (f" [{unit}]" if unit else "") + f", {len(y)} rows")
    for what, place in (("end", len(y) - 1), ("least", int(np.argmin(y))), ("largest", int(np.argmax(y)))):
        print(f"{what:10} {y[place]:.8g} at {_scaled(x_name, words.x_scale)} = {x[place]:.6g}")
    if words.out:
        print(draw_alone((x_name, y_name), x, y, curves, words))
    return 0


def draw_alone(names: tuple[str, str], x: Array, y: Array, curves: Curves, words: argparse.Namespace) -> Path:
    """The curve alone."""
    figure, axes = plt.subplots(figsize=(6.4, 4.4))
    axes.plot(x, y, "o-", ms=3, lw=1)
    for set_label, name, scale in ((axes.set_xlabel, names[0], words.x_scale), (axes.set_ylabel, names[1], words.scale)):
        unit = curves.units.get(_plain(name), "") if scale == 1 else ""
        set_label(_scaled(name, scale) + (f" [{unit}]" if unit else ""))
    axes.set_title(str(words.result), fontsize=10, loc="left")
    axes.grid(alpha=0.3)
    return save(figure, words.out)


def draw(comparison: Comparison, words: argparse.Namespace) -> Path:
    """The two curves in one diagram, the difference below."""
    figure, (upper, lower) = plt.subplots(2, 1, figsize=(6.4, 5.6), sharex=True, height_ratios=(3, 1))
    order = np.argsort(comparison.x, kind="stable")
    upper.plot(comparison.x[order], comparison.reference[order], "k-", lw=1, label=words.against)
    upper.plot(comparison.x, comparison.y, "o", ms=4, mfc="none", label=str(words.result))
    lower.plot(comparison.x, comparison.y - comparison.reference, ".-", lw=0.8, color="tab:red")
    unit = f" [{comparison.y_unit}]" if comparison.y_unit else ""
    upper.set_ylabel(comparison.y_name + unit)
    lower.set_ylabel("difference" + unit)
    lower.set_xlabel(comparison.x_name + (f" [{comparison.x_unit}]" if comparison.x_unit else ""))
    upper.legend(fontsize=7)
    for axes in (upper, lower):
        axes.grid(alpha=0.3)
    return save(figure, words.out)


def add_words(verbs: argparse._SubParsersAction) -> None:
    """Arguments of the subcommand."""
    verb = verbs.add_parser("curve", help="compare a result with a formula or a table: error norms and a figure")
    verb.add_argument("result", type=Path, help="folder of a run, its curves.csv, or a CSV with headings `name [unit]`")
    verb.add_argument(
        "--against",
        metavar="REFERENCE",
        help="function:NAME(argument=value, argument=COLUMN), a CSV or a folder; `functions` lists the names. Without it the "
        "result is reported alone",
    )
    verb.add_argument("--x", help="column along x, -COLUMN for its negative; default the column of the formula, or load_factor")
    verb.add_argument("--y", help="column along y; default the first history")
    verb.add_argument("--scale", type=float, default=1.0, help="factor on y; determines its unit")
    verb.add_argument("--x-scale", type=float, default=1.0, help="factor on x; determines its unit")
    verb.add_argument("--against-x", help="column of the table along x")
    verb.add_argument("--against-y", help="column of the table along y")
    verb.add_argument("--phase", type=read_phase, help="rows of one phase, by name or number")
    verb.add_argument("--any-unit", action="store_true", help="compare regardless of the units in the headings")
    verb.add_argument("--unfinished", action="store_true", help="accept a run that did not finish")
    verb.add_argument("--tolerance", type=float, help="exit code 1 if the largest relative error exceeds this value")
    verb.add_argument("--out", type=Path, help="file of the figure, .png, .svg or .pdf")
    verb.add_argument("--json", type=Path, help="write the norms to a JSON file")
    verb.set_defaults(act=act)


def act(words: argparse.Namespace) -> int:
    """Compare, print, plot."""
    if words.out and words.out.suffix.lower() not in (".png", ".svg", ".pdf"):
        raise Trouble(f"{words.out}: a figure must be a .png, .svg or .pdf file")
    if not words.against:
        return tell(words)
    comparison = compare(words)
    norms = comparison.norms()
    unit = f" {comparison.y_unit}" if comparison.y_unit else ""
    print(f"{comparison.y_name} of {words.result} against {words.against}")
    outside = f", {norms.rows_left_out} outside the range of the reference" if norms.rows_left_out else ""
    print(f"rows       {norms.rows}{outside}")
    print(
        f"max error  {norms.largest:.4g}{unit}, {norms.largest_share:.3e} of the largest reference, "
        f"at {comparison.x_name} = {norms.largest_at:.6g}"
    )
    print(f"rms error  {norms.rms:.4g}{unit}, {norms.rms_share:.3e}")
    print(f"end value  {norms.end_value:.8g} against {norms.end_reference:.8g}{unit}, {norms.end_share:.3e}")
    if words.out:
        print(draw(comparison, words))
    if words.json:
        words.json.parent.mkdir(parents=True, exist_ok=True)
        words.json.write_text(json.dumps(asdict(norms), indent=1) + "\n", encoding="utf-8")
    return 1 if words.tolerance is not None and not norms.largest_share <= words.tolerance else 0
