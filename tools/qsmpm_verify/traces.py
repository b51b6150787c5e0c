"""Quantities computed from the history of a run, its curves or its log; a case names them under `trace`."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np

from qsmpm_verify.results import ResultError, read_cpu_seconds, read_curves

Trace = Callable[..., float]

HOLD = re.compile(r"constant load test at load factor\s+(\S+): (?:after .* has grown by\s+(\S+) %|rejected at re-solve (\d+))")


def knee(folder: Path, column: str, factor: float = 10.0, load: str = "load_factor") -> float:
    """Load at the end of the first step whose compliance exceeds `factor` times the first one [load].

    Compliance: increment of the column divided by the increment of the load in a step; the curve starts at the origin.
    A curve without such a step is an error.
    """
    if factor <= 1:
        raise ResultError(f"knee: factor {factor:g} must be above 1")
    curves = read_curves(folder)
    loads = np.concatenate([[0.0], curves.column(load)])
    steps = np.diff(loads)
    if np.any(steps <= 0):
        raise ResultError(f"{curves.path}: {load} does not increase in every step")
    compliance = np.diff(np.concatenate([[0.0], curves.column(column)])) / steps
    if compliance[0] <= 0:
        raise ResultError(f"{curves.path}: {column} does not increase with {load} in the first step")
    beyond = np.nonzero(compliance > factor * compliance[0])[0]
    if not len(beyond):
        top = compliance.max() / compliance[0]
        raise ResultError(f"{curves.path}: no knee up to {load} = {loads[-1]:g}: compliance increased by a factor of {top:.3g}")
    return float(loads[beyond[0] + 1])


def limit_load(folder: Path, which: str = "knee") -> float:
    """Limit load of a phase with LIMIT COMPLIANCE [load]: its knee, or the last accepted or first rejected load factor.

    A run without a limit load is an error.
    """
    path = folder / "limit_load.json"
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ResultError(f"{path}: {error.strerror}: the run has found no limit load") from error
    if which not in ("carried", "refused", "knee"):
        raise ResultError(f"limit_load: '{which}' must be carried, refused or knee")
    return float(found[which])


def factor_of_safety(folder: Path, phase: str, which: str = "stable") -> float:
    """Factor of safety of a phase of TYPE=SAFETY [-]: the last stable one, the first at which no equilibrium is found, or their difference; the first rejected one
    is used if none is lost.

    A phase without a factor of safety is an error.
    """
    path = folder / "safety.json"
    try:
        phases = json.loads(path.read_text(encoding="utf-8"))["phases"]
    except OSError as error:
        raise ResultError(f"{path}: {error.strerror}: the run has found no factor of safety") from error
    if which not in ("stable", "lost", "width"):
        raise ResultError(f"factor_of_safety: '{which}' must be stable, lost or width")
    found = [row for row in phases if row["phase"] == phase]
    if not found:
        raise ResultError(f"{path}: unknown phase '{phase}'; known are {', '.join(row['phase'] for row in phases)}")
    stable, lost = found[0]["stable"], found[0]["lost"]
    if which == "width" and lost is None:
        lost = found[0].get("refused")
    if which != "stable" and lost is None:
        raise ResultError(f"{path}: phase '{phase}' found no factor without equilibrium: it is at least {stable}")
    return float({"stable": stable, "lost": lost}[which] if which != "width" else lost - stable)


def hold_growth(folder: Path, load_factor: float) -> float:
    """Increase of the first history in a constant load test, relative to it, from job.log [-].

    A test that is missing in the log or failed to reach equilibrium is an error.
    """
    path = folder / "job.log"
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise ResultError(f"{path}: {error.strerror}") from error
    tests = {float(hit[1]): hit for hit in HOLD.finditer(text)}
    for at, hit in tests.items():
        if abs(at - load_factor) <= 1e-3 * abs(load_factor):
            if hit[3]:
                raise ResultError(f"{path}: constant load test at {at:g} rejected at re-solve {hit[3]}")
            return float(hit[2]) / 100
    known = ", ".join(f"{at:g}" for at in tests) or "none"
    raise ResultError(f"{path}: no constant load test at load factor {load_factor:g}; available are {known}")


def jitter(folder: Path, column: str, along: str = "load_factor", beyond: float = 0.0) -> float:
    """Mean step-to-step jitter of a column, |y(k+1) - 2 y(k) + y(k-1)|, over the steps beyond a value of another column [column].

    A smooth curve contributes only its curvature, which decreases with the square of the step.
    """
    curves = read_curves(folder)
    x, y = curves.column(along), curves.column(column)
    bends = np.abs(np.diff(y, 2))[x[1:-1] > beyond]
    if not len(bends):
        raise ResultError(f"{curves.path}: no three consecutive steps beyond {along} = {beyond:g}")
    return float(bends.mean())


def cpu_seconds(folder: Path) -> float:
    """CPU seconds of a run [s]."""
    return read_cpu_seconds(folder)


def column_sum(folder: Path, column: str) -> float:
    """Sum of a column over the steps [column]."""
    return float(read_curves(folder).column(column).sum())


def log_lines(folder: Path, text: str) -> float:
    """Number of lines of job.log that contain a text [-]."""
    path = folder / "job.log"
    try:
        return float(sum(text in line for line in path.read_text(encoding="utf-8").splitlines()))
    except OSError as error:
        raise ResultError(f"{path}: {error.strerror}") from error


def hertz_error(folder: Path, radius: float, modulus: float, spacing: float) -> float:
    """Pressures p0, p1, ... at (i + 1/2) spacing from the centre compared with Hertz's under a rigid circle [-].

    Root mean square over the inner 0.8 of the contact, relative to the largest pressure; `force` is that of half of the scene,
    `modulus` E/(1 - nu^2).
    """
    curves = read_curves(folder)
    force = 2 * abs(float(curves.column("force")[-1]))
    half_width = np.sqrt(4 * force * radius / (np.pi * modulus))
    largest = 2 * force / (np.pi * half_width)
    places = np.arange(0.5 * spacing, 0.8 * half_width, spacing)
    if len(places) < 3:
        raise ResultError(f"hertz_error: {len(places)} pressures within the contact of half width {half_width:.3g}")
    found = np.array([float(curves.column(f"p{i}")[-1]) for i in range(len(places))])
    exact = largest * np.sqrt(1 - (places / half_width) ** 2)
    return float(np.sqrt(np.mean((found - exact) ** 2)) / largest)


def column_mean(folder: Path, column: str, along: str, beyond: float, until: float = np.inf) -> float:
    """Mean of a column over the steps between two values of another column [column]."""
    curves = read_curves(folder)
    places = curves.column(along)
    chosen = curves.column(column)[(places > beyond) & (places <= until)]
    if not len(chosen):
        raise ResultError(f"{curves.path}: no step with {along} beyond {beyond:g} and up to {until:g}")
    return float(chosen.mean())


def pressure_wave(folder: Path, count: int, order: int, scale: float) -> float:
    """Residual of pressures p0, p1, ... at `count` equally spaced points of a half circle, ends included, after fitting a cosine series [-].

    Root mean square over the points in the last step, divided by `scale`; `order` is that of the last fitted cosine.
    """
    curves = read_curves(folder)
    found = np.array([float(curves.column(f"p{i}")[-1]) for i in range(count)])
    angles = np.pi * np.arange(count) / (count - 1)
    waves = np.cos(np.outer(angles, np.arange(order + 1)))
    fitted = waves @ np.linalg.lstsq(waves, found, rcond=None)[0]
    return float(np.sqrt(np.mean((found - fitted) ** 2)) / scale)


TRACES: dict[str, Trace] = {
    f.__name__: f
    for f in (
        knee,
        limit_load,
        factor_of_safety,
        hold_growth,
        jitter,
        cpu_seconds,
        column_sum,
        column_mean,
        log_lines,
        hertz_error,
        pressure_wave,
    )
}
"""The functions that a case file may name."""
