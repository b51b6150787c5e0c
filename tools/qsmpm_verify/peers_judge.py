"""Comparison of results of QSMPM with those of other programs, one line for each check."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from qsmpm_verify.peers_compute import Outcome
from qsmpm_verify.peers_scenes import FIELDS, Check, Point, Scene
from qsmpm_verify.reference import REFERENCES


@dataclass(frozen=True)
class Finding:
    """One line. `held` is None if it is printed only, or could not be compared: then `note` states the reason."""

    scene: str
    quantity: str
    run: str
    value: float | None
    against: str
    peer: str
    peer_value: float | None
    difference: float | None
    tolerance: float | None
    held: bool | None
    reason: str
    seconds: float | None
    peer_seconds: float | None
    note: str = ""
    said: tuple[str, ...] = ()


def limit(values: list[float]) -> float:
    """Limit of results on successively halved meshes, from the last three (Aitken)."""
    first, second, third = values[-3:]
    if second == first or abs(third - second) >= abs(second - first):
        raise ValueError("the values do not converge")
    return third + (third - second) ** 2 / ((second - first) - (third - second))


def figure(outcome: Outcome, quantity: str) -> float:
    """A result of a run; `reaction` is the largest component of the support reactions."""
    if quantity == "reaction":
        if outcome.solution is None:
            raise ValueError("support reactions are available for finite elements only")
        return float(np.abs(outcome.solution.reaction).max())
    value = outcome.figures.get(quantity)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise ValueError(f"no value '{quantity}'")
    return float(value)


def _field(own: Outcome, other: Outcome, quantity: str) -> tuple[float, float, float]:
    """Largest displacement, or pressure, of both and their largest difference relative to the first."""
    if own.solution is None or other.solution is None:
        raise ValueError("fields can be compared on a common finite element mesh only")
    one, two = own.solution.displacement, other.solution.displacement
    if quantity == "pressure field":
        if own.solution.pressure is None or other.solution.pressure is None:
            raise ValueError("pressures can be compared for runs with groundwater flow only")
        one, two = own.solution.pressure, other.solution.pressure
    if one.shape != two.shape:
        raise ValueError("the two runs have different nodes")
    size = float(np.abs(one).max())
    return size, float(np.abs(two).max()), float(np.abs(one - two).max()) / size


def _reference(reference: float | dict[str, Any]) -> float:
    if isinstance(reference, dict):
        return REFERENCES[reference["function"]](**{k: v for k, v in reference.items() if k != "function"})
    return float(reference)


def _compare(check: Check, outcomes: dict[str, Outcome]) -> tuple[float, float, float]:
    """Value, value of the other run and the relative difference."""
    if check.quantity in FIELDS:
        return _field(outcomes[check.runs[0]], outcomes[check.against], check.quantity)
    values = [check.scale * figure(outcomes[name], check.quantity) for name in check.runs]
    value = values[0] if len(values) == 1 else limit(values)
    if check.against:
        other = check.scale * figure(outcomes[check.against], check.quantity)
    else:
        other = _reference(check.reference)  # type: ignore[arg-type]
    return value, other, abs(value - other) / abs(other)


def judge_check(scene: Scene, check: Check, outcomes: dict[str, Outcome]) -> Finding | None:
    """The line of a check; None if one of its runs was not requested."""
    if any(name not in outcomes for name in check.needs()):
        return None
    own, other = outcomes[check.runs[-1]], outcomes.get(check.against)
    run = check.runs[0] if len(check.runs) == 1 else f"limit of {', '.join(check.runs)}"
    value = peer_value = difference = held = None
    note = next((f"{name}: {outcomes[name].trouble}" for name in check.needs() if outcomes[name].trouble), "")
    absent = any(outcomes[name].absent for name in check.needs())
    if not note:
        try:
            value, peer_value, difference = _compare(check, outcomes)
            held = None if check.tolerance is None else bool(difference <= check.tolerance)
        except (ValueError, ArithmeticError) as error:
            note = str(error)
    if note and not absent:
        held = False
    return Finding(
        scene.name, check.name, f"{own.program} {run}" if own.program != "QSMPM" else run, value,
        check.against or "reference", other.program if other else "", peer_value, difference, check.tolerance, held,
        check.reason, own.cpu_seconds, other.cpu_seconds if other else None, note,
        tuple(f"{name}: {outcomes[name].said}" for name in check.needs() if outcomes[name].said),
    )  # fmt: skip


def chart_point(scene: Scene, point: Point, outcomes: dict[str, Outcome]) -> dict[str, Any] | None:
    """A point for the charts of error against cost; without error and seconds if the run has no result."""
    outcome = outcomes.get(point.run)
    if outcome is None or outcome.absent:
        return None
    entry: dict[str, Any] = {
        "study": point.study, "label": point.label, "scene": scene.name, "run": point.run, "peer": outcome.program,
        "size": point.size, "error": None, "seconds": None, "note": point.note,
    }  # fmt: skip
    try:
        if outcome.trouble:
            raise ValueError(outcome.trouble)
        value = figure(outcome, point.quantity)
    except ValueError as trouble:
        return {**entry, "note": f"{point.note} {trouble}".strip()}
    error = value if point.reference is None else abs(value - point.reference) / abs(point.reference)
    return {**entry, "error": error, "seconds": outcome.cpu_seconds}


def as_rows(findings: list[Finding]) -> list[dict[str, Any]]:
    """The lines as JSON objects."""
    return [asdict(finding) for finding in findings]
