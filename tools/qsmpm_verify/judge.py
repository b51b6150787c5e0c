"""Compare the results of finished runs with their references."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from qsmpm_verify.cases import Case, Quantity
from qsmpm_verify.measures import MEASURES
from qsmpm_verify.reference import REFERENCES
from qsmpm_verify.results import Array, Curves, ResultError, read_cpu_seconds, read_curves, read_points
from qsmpm_verify.runner import Run
from qsmpm_verify.traces import TRACES
from qsmpm_verify.trouble import Trouble


@dataclass(frozen=True)
class Verdict:
    """One line of the report. `held` is None for a value that is only printed; `expected` marks a known miss."""

    case: str
    quantity: str
    value: float
    reference: str
    error: float | None
    tolerance: str
    held: bool | None
    cpu_seconds: float | None
    note: str = ""
    expected: bool = False


HOLDS_NOW = "passes now: remove expected_to_fail"
"""Note on an expected failure that passes."""


class Place:
    """Position in the curves at which a quantity is evaluated: rows of a phase, one of them or a point between two."""

    def __init__(self, curves: Curves, quantity: Quantity) -> None:
        self.curves = curves
        self.quantity = quantity
        if quantity.phase is None:
            self.rows = np.arange(len(curves))
        else:
            self.rows = curves.rows_of_phase(quantity.phase)

    def take(self, name: str) -> Array:
        """Values of a column at the position, one or (for `every`) many."""
        values = self.curves.column(name)[self.rows]
        at = self.quantity.at
        if isinstance(at, dict):
            return np.array([self._between(values, *next(iter(at.items())))])
        if at == "every":
            return values
        if at in ("max", "min"):
            own = self.quantity.scale * self.curves.column(self.quantity.column or name)[self.rows]
            return values[[int(np.argmax(own) if at == "max" else np.argmin(own))]]
        return values[[-1 if at == "last" else 0]]

    def _between(self, values: Array, column: str, wanted: float) -> float:
        """Linear interpolation between the two rows around the first crossing of `wanted`; no extrapolation."""
        x = self.curves.column(column)[self.rows]
        slack = 1e-9 * max(1.0, abs(wanted))
        for i in range(len(x)):
            if abs(x[i] - wanted) <= slack:
                return float(values[i])
            if i and (x[i - 1] - wanted) * (x[i] - wanted) < 0:
                share = (wanted - x[i - 1]) / (x[i] - x[i - 1])
                return float(values[i - 1] + share * (values[i] - values[i - 1]))
        raise ResultError(
            f"{self.curves.path}: {column} = {wanted:g} is not reached (range {x.min():g} to {x.max():g})"
        )


def _plain_values(run: Run, quantity: Quantity) -> Array:
    """The value of the run, or the values for `every`."""
    if quantity.measure is not None:
        points = read_points(run.directory)
        return np.array([quantity.scale * MEASURES[quantity.measure](points, **quantity.arguments)])
    if quantity.trace is not None:
        return np.array([quantity.scale * TRACES[quantity.trace](run.directory, **quantity.arguments)])
    place = Place(read_curves(run.directory), quantity)
    return quantity.scale * place.take(str(quantity.column))


def _values(run: Run, quantity: Quantity, runs: Mapping[str, Run]) -> Array:
    """The value to be assessed: that of the run, its order of convergence or its growth from another run."""
    own = _plain_values(run, quantity)
    table = quantity.order_from or quantity.growth_from
    if table is None:
        return own
    other = runs.get(table["case"])
    if other is None:
        raise ResultError(f"case {table['case']} was not run")
    before = _plain_values(other, quantity)
    ratio = float(own[0]) / float(before[0])
    if not (math.isfinite(ratio) and ratio > 0):
        raise ResultError(f"{own[0]:g} against {before[0]:g} of case {table['case']}: no ratio of errors")
    return np.array([ratio if quantity.order_from is None else -math.log(ratio) / math.log(table["refinement"])])


def _references(run: Run, quantity: Quantity, runs: Mapping[str, Run], count: int) -> Array:
    """The references of the values, as many as there are values."""
    reference = quantity.reference
    if not isinstance(reference, dict):
        return np.full(count, math.nan if reference is None else float(reference))
    if "case" in reference:
        other = runs.get(reference["case"])
        if other is None:
            raise ResultError(f"case {reference['case']} was not run")
        found = _plain_values(other, quantity)
        if len(found) != count:
            raise ResultError(f"{count} rows against {len(found)} of case {reference['case']}")
        return found
    columns: dict[str, Array] = {}
    fixed: dict[str, Any] = {}
    for name, argument in reference.items():
        if name == "function":
            continue
        if isinstance(argument, str) and argument.startswith("column:"):
            place = Place(read_curves(run.directory), quantity)
            columns[name] = place.take(argument.removeprefix("column:"))
        else:
            fixed[name] = argument
    function = REFERENCES[reference["function"]]
    return np.array(
        [function(**fixed, **{n: float(v[i]) for n, v in columns.items()}) for i in range(count)]
    )


def _against_reference(quantity: Quantity, values: Array, wanted: Array) -> tuple[int, Array]:
    """Index of the worst value and the errors; NaN is the worst of all."""
    errors = np.abs(values - wanted)
    if quantity.error == "relative":
        errors = np.divide(
            errors, np.abs(wanted), out=np.where(errors == 0, 0.0, np.inf), where=wanted != 0
        )
    errors = np.where(np.isfinite(values) & np.isfinite(wanted), errors, np.inf)
    return int(np.argmax(errors)), errors


def _allowed(quantity: Quantity, values: Array, wanted: Array) -> Array:
    """The tolerance for each value, which may be different below the reference."""
    above = float(quantity.tolerance or 0.0)
    below = above if quantity.tolerance_below is None else float(quantity.tolerance_below)
    return np.where(values < wanted, below, above)


def _bounded(quantity: Quantity, values: Array) -> tuple[int, bool]:
    """Index of the value furthest outside its bounds, and whether all are inside."""
    low = -math.inf if quantity.at_least is None else quantity.at_least
    high = math.inf if quantity.at_most is None else quantity.at_most
    outside = np.maximum(low - values, values - high)
    outside = np.where(np.isfinite(values), outside, np.inf)
    worst = int(np.argmax(outside))
    return worst, bool(outside[worst] <= 0)


def judge_quantity(run: Run, quantity: Quantity, runs: Mapping[str, Run]) -> Verdict:
    """One quantity of a run; if it cannot be evaluated, it is a miss with the reason as its note."""
    cpu = cpu_seconds(run)
    name = run.case.name
    try:
        values = _values(run, quantity, runs)
        if quantity.at_least is not None or quantity.at_most is not None:
            index, held = _bounded(quantity, values)
            low = "" if quantity.at_least is None else f">= {quantity.at_least:g}"
            high = "" if quantity.at_most is None else f"<= {quantity.at_most:g}"
            bounds = " ".join(filter(None, (low, high)))
            return Verdict(name, quantity.name, float(values[index]), bounds, None, "-", held, cpu)
        wanted = _references(run, quantity, runs, len(values))
        if quantity.print:
            index = len(values) - 1
            known = math.isfinite(wanted[index])
            error = float(_against_reference(quantity, values, wanted)[1][index]) if known else None
            shown = f"{wanted[index]:.6g}" if known else "-"
            return Verdict(name, quantity.name, float(values[index]), shown, error, "-", None, cpu)
        _, errors = _against_reference(quantity, values, wanted)
        allowed = _allowed(quantity, values, wanted)
        index = int(np.argmax(errors - allowed if quantity.tolerance_below is not None else errors))
        return Verdict(
            name,
            quantity.name,
            float(values[index]),
            f"{wanted[index]:.6g}",
            float(errors[index]),
            f"{allowed[index]:.1e}" + (" abs" if quantity.error == "absolute" else ""),
            bool(errors[index] <= allowed[index]),
            cpu,
        )
    except (Trouble, TypeError, ValueError, ArithmeticError) as error:
        return Verdict(name, quantity.name, math.nan, "-", None, "-", False, cpu, str(error))


def judge_exit(run: Run) -> Verdict:
    """Whether the program ended as expected."""
    code = math.nan if run.exit_code is None else float(run.exit_code)
    held = run.exit_code == run.case.exit_code
    return Verdict(
        run.case.name, "exit code", code, str(run.case.exit_code), None, "exact", held,
        cpu_seconds(run), run.message,
    )  # fmt: skip


def cpu_seconds(run: Run) -> float | None:
    """CPU seconds of the run, if it wrote them."""
    try:
        return read_cpu_seconds(run.directory)
    except ResultError:
        return None


def _against_mark(verdict: Verdict, mark: str) -> Verdict:
    """The verdict of a value that is expected to fail; a value that cannot be evaluated does not count as such."""
    if not mark or (verdict.held is False and verdict.note):
        return verdict
    return replace(verdict, held=not verdict.held, expected=not verdict.held, note=HOLDS_NOW if verdict.held else mark)


def judge(case: Case, runs: Mapping[str, Run]) -> list[Verdict]:
    """The verdicts of a case: its exit code and its quantities."""
    run = runs[case.name]
    figures = [_against_mark(judge_quantity(run, q, runs), q.expected_to_fail) for q in case.quantities]
    verdicts = [judge_exit(run), *figures]
    if not case.expected_to_fail:
        return verdicts
    if all(v.held is not False for v in verdicts):
        return [replace(verdicts[0], held=False, note=HOLDS_NOW), *figures]
    return [
        replace(v, held=True, expected=True, note=case.expected_to_fail) if v.held is False and v.note != HOLDS_NOW else v
        for v in verdicts
    ]
