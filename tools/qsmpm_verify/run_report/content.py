"""Content of a report of a run, as elements that are written to a page and a document."""

from __future__ import annotations

import argparse
import itertools
import json
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

from qsmpm_verify import view
from qsmpm_verify.bounds.search import Search
from qsmpm_verify.bounds.phases import read_scene
from qsmpm_verify.results import Curves, ResultError, how_it_ended, phase_of_steps, read_curves, read_points, written_mechanisms, written_steps
from qsmpm_verify.study.cards import read_deck
from qsmpm_verify.told import echoed, phase_name, units
from qsmpm_verify.trouble import Trouble

MOST_MARKS = 400
"""Maximum number of marks with values on a curve; on longer curves every second, third, ... point has a mark."""
NOT_CURVES = {"phase", "step", "load_factor", "iterations", "out_of_balance", "inaccurate_points", "compliance", "step_error",
              "damping_share", "stabilisation_share", "internal_work"}  # fmt: skip
"""Columns on the solution process, not on the ground."""
WIDEST = 100
"""Maximum length of a line of the deck."""
FIELDS = ("displacement", "shear_strain", "pore_pressure")


@dataclass(frozen=True)
class Heading:
    """A heading and its anchor."""

    text: str
    name: str


@dataclass(frozen=True)
class Lines:
    """Sentences; `warning` marks warnings, `deck` keeps blanks."""

    lines: tuple[str, ...]
    kind: str = ""


@dataclass(frozen=True)
class Rows:
    """A table."""

    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class Picture:
    """A figure: PNG for a document, SVG for a page if available, with texts at its marks."""

    png: Path
    caption: str
    svg: Path | None = None
    tips: dict[str, list[str]] = field(default_factory=dict)


Piece = Heading | Lines | Rows | Picture


def content_of(folder: Path, work: Path, with_bounds: bool) -> list[Piece]:
    """All elements of a run, with the figures written to `work`."""
    if not (folder / "summary.json").is_file():
        raise ResultError(f"{folder}: no summary.json: the folder contains no finished run")
    log = log_of(folder)
    quiet = [line for line in log if line.strip() and not line.startswith("warning:")]
    pieces: list[Piece] = [Lines(tuple(first_lines(folder, log)))]
    pieces += [Heading("Phases", "phases"), phase_table(folder), *factor_pieces(folder, work, with_bounds)]
    pieces += [Heading("Warnings", "warnings"), warning_lines(log)]
    pieces += [Heading("Curves", "curves"), *curve_pieces(folder, work)]
    pieces += [Heading("Pictures", "pictures"), *state_pieces(folder, work)]
    pieces += [Heading("Deck", "deck"), Lines(tuple(joined(echoed(folder).splitlines())), "deck")]
    pieces += [Heading("Run", "run"), Lines(tuple(itertools.takewhile(lambda line: not line.startswith(("phase ", "static")), quiet)))]
    return pieces


def joined(lines: Sequence[str]) -> list[str]:
    """Lines of a deck, with continuation lines joined up to the maximum length."""
    found: list[str] = []
    for line in lines:
        if found and found[-1].rstrip().endswith(",") and len(found[-1]) + len(line) < WIDEST and not line.startswith("*"):
            found[-1] = f"{found[-1].rstrip()} {line.strip()}"
        else:
            found.append(line)
    return found


def log_of(folder: Path) -> list[str]:
    """Lines of the log; none if it does not exist."""
    path = folder / "job.log"
    return path.read_text(encoding="utf-8", errors="replace").splitlines() if path.is_file() else []


def first_lines(folder: Path, log: Sequence[str]) -> list[str]:
    """Heading of the deck, and the end of the run."""
    head = re.search(r"^\*HEADING\s*\n((?:(?!\*).*\n)*)", echoed(folder), re.MULTILINE | re.IGNORECASE)
    ended = how_it_ended(folder)
    seconds = json.loads((folder / "timing.json").read_text())["cpu_seconds"] if (folder / "timing.json").is_file() else math.nan
    last = next((line for line in reversed(log) if line.startswith(("qsmpm:", "phase '"))), "")
    lines = [" ".join(head[1].split())] if head and head[1].strip() else []
    return [*lines, f"Ended: {ended or last.removeprefix('qsmpm: ') or 'unknown'}; {seconds:.3g} CPU s."]


def factor_text(factor: list[float | None]) -> str:
    """Last stable and first factor without equilibrium, or the lower limit."""
    return f"at least {number(factor[0])}" if factor[1] is None else " to ".join(number(value) for value in factor)


def phase_table(folder: Path) -> Rows:
    """One row for each phase."""
    length = units(folder).get("LENGTH", "-")
    rows = []
    for told in json.loads((folder / "summary.json").read_text(encoding="utf-8"))["phases"]:
        factor = told.get("factor")
        rows.append((str(told["name"]), str(told.get("ended_by", "")), number(told.get("load_factor")), number(told.get("steps")),
                     number(told.get("iterations")), number(told.get("out_of_balance"), 2), number(told.get("largest_displacement")),
                     factor_text(factor) if factor else ""))
    return Rows(("phase", "ended by", "load factor", "increments", "iterations", "out of balance", f"largest displacement [{length}]",
                 "factor of safety"), tuple(rows))


def number(value: Any, digits: int = 4) -> str:
    """A number with few digits, empty for None."""
    return "" if value is None else f"{float(value):.{digits}g}"


def factor_pieces(folder: Path, work: Path, with_bounds: bool) -> list[Piece]:
    """Failure mechanism of each safety phase, and bounds of limit analysis for its initial state."""
    pieces: list[Piece] = []
    for phase in written_mechanisms(folder):
        words = argparse.Namespace(result=folder, field="displacement", range=None, no_outline=False, mesh=False, mechanism=True, phase=phase)
        png = view.write_picture(view.mechanism(words), work / f"mechanism_{phase}.png")
        pieces.append(Picture(png, f"Failure mechanism in phase {phase_name(folder, phase)}: displacements relative to the largest"))
        if with_bounds:
            pieces.append(bounds_line(folder, phase))
    return [Heading("Factor of safety", "factor"), *pieces] if pieces else []


def bounds_line(folder: Path, phase: int) -> Lines:
    """Bounds of the factor for the initial geometry, or the reason why there are none."""
    deck = next(iter(sorted(folder.glob("*.echo.inp"))), None)
    if deck is None:
        return Lines(("No bounds: the run has no echoed deck.",))
    try:
        name = json.loads((folder / "summary.json").read_text(encoding="utf-8"))["phases"][phase - 1]["name"]
        scene = read_scene(read_deck(deck), name, True)
        found = Search(scene).run()
    except Trouble as trouble:
        return Lines((f"No bounds of limit analysis: {trouble}",))
    both = [f"{side} {bound.value:.4g}" for side, bound in (("at least", found.lower), ("at most", found.upper)) if bound.solved]
    return Lines((f"Bounds of limit analysis for the initial geometry, psi = phi: {', '.join(both) or 'none'} ({found.triangles} triangles).",))


def warning_lines(log: Sequence[str]) -> Lines:
    """Warnings, each once, in their order."""
    found = tuple(dict.fromkeys(line.removeprefix("warning: ") for line in log if line.startswith("warning:")))
    return Lines(found, "warning") if found else Lines(("None.",))


def curve_pieces(folder: Path, work: Path) -> list[Piece]:
    """Every history of the deck against the increments, with the phases distinguished."""
    curves = read_curves(folder)
    phases = np.array(curves.text.get("phase") or curves.columns["phase"], dtype=float)
    names = [name for name in curves.columns if name not in NOT_CURVES and np.ptp(curves.columns[name]) > 0.0]
    return [curve_picture(folder, curves, phases, name, work) for name in names]


def curve_picture(folder: Path, curves: Curves, phases: np.ndarray, name: str, work: Path) -> Picture:
    """One history."""
    values, load = curves.columns[name], curves.columns["load_factor"]
    figure, axes = plt.subplots(figsize=(8.0, 3.2), layout="constrained")
    tips: dict[str, list[str]] = {}
    stem = "curve_" + re.sub(r"\W+", "_", name)
    for phase in np.unique(phases):
        rows = np.flatnonzero(phases == phase)
        rows = rows[:: max(1, math.ceil(len(rows) / MOST_MARKS))]
        group = f"{stem}_{phase:g}"
        axes.plot(rows + 1, values[rows], "o-", ms=3, lw=1.0, gid=group, label=f"phase {phase_name(folder, int(phase))}")
        tips[group] = [f"increment {row + 1}, load factor {load[row]:.6g}: {values[row]:.6g}" for row in rows]
    axes.set_xlabel("increment")
    unit = curves.units.get(name, "")
    axes.set_ylabel(f"{name} [{unit}]" if unit and unit != "-" else name)
    axes.grid(color="0.9", lw=0.6)
    axes.legend(fontsize=8)
    svg, png = work / f"{stem}.svg", work / f"{stem}.png"
    figure.savefig(svg)
    figure.savefig(png, dpi=150)
    plt.close(figure)
    return Picture(png, f"{name}: last {values[-1]:.6g}, from {values.min():.6g} to {values.max():.6g}", svg, tips)


def state_pieces(folder: Path, work: Path) -> list[Piece]:
    """The state at the end of every phase."""
    if not written_steps(folder):
        return [Lines(("No state was written (*FIELD).",))]
    last = {phase: step for step, phase in sorted(phase_of_steps(folder).items())}
    pieces: list[Piece] = []
    for phase, step in last.items():
        there = read_points(folder, step).fields
        for name in FIELDS:
            if name != "displacement" and (name not in there or not np.ptp(there[name]) > 0.0):
                continue
            words = argparse.Namespace(result=folder, field=name, range=None, no_outline=False, mesh=False, mechanism=False)
            png = view.write_picture(view.frames(words, [step])[0], work / f"{name}_{phase}.png")
            pieces.append(Picture(png, f"End of phase {phase_name(folder, phase)}: {name.replace('_', ' ')}"))
    return pieces
