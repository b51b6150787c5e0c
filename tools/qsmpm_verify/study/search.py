"""Runs of a study in order of their cost, within a budget of CPU time.

Body-fitted triangles are run first, refined repeatedly where their own run has sheared: no other method is as accurate for its
cost. Every other method starts on the coarsest grid; the cheapest remaining run is next, with its cost predicted from the previous run
of the same method. A method that failed twice in succession is abandoned. After the finest runs, one run with twice the number of
steps gives the error of the steps. The search ends when no run remains, when the budget does not suffice for the next run, or
when a run is sufficiently close to the result and no remaining run could be cheaper.
"""

from __future__ import annotations

import json
import math
import re
import resource
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from qsmpm_verify.cases import Case
from qsmpm_verify.results import Array, ResultError, read_cpu_seconds, read_curves
from qsmpm_verify.runner import run_case
from qsmpm_verify.study.cards import Deck
from qsmpm_verify.study.refined import COST, LEVELS, REFINED, can_refine, refined
from qsmpm_verify.study.strength import STRONGER, gave_way, stronger
from qsmpm_verify.study.variants import OWN, Method, at_level, dimension, levels_of, methods_of, with_method, with_steps

# Cost of a halved grid over that of the grid before, beyond the number of its cells: longer equations, more iterations.
GROWTH = 1.4
MISSES = 2
# Seconds below which runs are not told apart: they are the start of the program and noise.
NOISE = 0.3
# Share of the budget that is kept for the run in twice the steps.
KEPT_FOR_STEPS = 0.25


@dataclass(frozen=True)
class Trial:
    """One run: its trial, its result (NaN with the reason if it has none), its seconds, and by how much the true value of its grid may exceed the result."""

    method: str
    level: int
    steps: int
    deck: str
    figure: float = math.nan
    seconds: float = math.nan
    reason: str = ""
    width: float = 0.0
    again: str = ""

    @property
    def good(self) -> bool:
        """Whether it has a result."""
        return math.isfinite(self.figure)

    @property
    def cost(self) -> float:
        """Its seconds, at least the resolution of the timing."""
        return max(self.seconds, NOISE)

    @property
    def name(self) -> str:
        """Name of its folder."""
        short = re.sub(r"\W+", "_", self.method.lower()).strip("_")
        return f"{short}/grid_{2.0**self.level:g}_steps_{self.steps}{self.again}"


@dataclass(frozen=True)
class Wish:
    """The request: the column and where it is read, the error, the CPU seconds; the folder of the runs."""

    history: str
    place: str
    target: float
    budget: float
    program: Path
    root: Path
    fresh: bool = False


FACTOR = "F"


def stable_factor(folder: Path) -> tuple[float, float]:
    """Last stable factor of the last safety phase of a run, and the distance to the first one without equilibrium; None if no failure of the body was found."""
    found = json.loads((folder / "safety.json").read_text(encoding="utf-8"))["phases"][-1]
    if found.get("refused") is not None:
        raise ResultError(f"at least {found['stable']:.5g}: neither equilibrium nor a mechanism was found above it")
    return float(found["stable"]), float(found["lost"] or found["stable"]) - float(found["stable"])


def waves(values: Array) -> float:
    """Smaller of the total rise and the total fall of a curve in its second half: zero for a monotonic curve."""
    changes = np.diff(values[len(values) // 2 :])
    return float(min(changes[changes > 0].sum(), -changes[changes < 0].sum()))


def figure_of(folder: Path, wish: Wish) -> tuple[float, float]:
    """The column of a run at the requested position, and its width; for a factor of safety the last stable one, regardless of any run-out that follows.

    For an oscillating curve the width is the amplitude of its oscillation in the last phase.
    """
    if wish.history == FACTOR and (folder / "safety.json").is_file():
        return stable_factor(folder)
    curves = read_curves(folder)
    values = curves.column(wish.history)
    phases = np.array(curves.text.get("phase") or curves.columns.get("phase", np.zeros(len(values))))
    own = values[phases == phases[-1]]
    return float({"last": values[-1], "max": values.max(), "min": values.min()}[wish.place]), waves(own) if wish.place == "last" else 0.0


def cpu_of_children() -> float:
    """CPU seconds of all child processes that were waited for."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def run_trial(deck: Deck, trial: Trial, wish: Wish, limit: float) -> tuple[Trial, float]:
    """Run a trial, or reuse an available run; the CPU seconds of its process, 0 for a reused run."""
    original = deck.path.read_text(encoding="utf-8")
    case = Case(trial.name, deck.path.name, deck.path, (), time_limit=max(limit, 1.0), replace=((original, trial.deck),))
    before = cpu_of_children()
    run = run_case(case, wish.program, wish.root, fresh=wish.fresh)
    spent = cpu_of_children() - before
    if run.exit_code != 0:
        reason = run.message if run.exit_code is None else f"exit {run.exit_code}: {run.message}"
        return replace(trial, reason=reason), spent
    try:
        if wish.history == FACTOR and gave_way(run.directory, trial.deck):
            return as_drawn(deck, trial, wish, limit, spent)
        figure, width = figure_of(run.directory, wish)
        return replace(trial, figure=figure, width=width, seconds=read_cpu_seconds(run.directory)), spent
    except ResultError as trouble:
        if "no column" in str(trouble):
            raise
        return replace(trial, reason=str(trouble)), spent


def as_drawn(deck: Deck, trial: Trial, wish: Wish, limit: float, spent: float) -> tuple[Trial, float]:
    """The factor of ground that was unstable before the search: of the same deck with a higher strength."""
    strong = stronger(trial.deck)
    if not strong or strong == trial.deck or trial.again:
        return replace(trial, reason="the ground failed before the search: its factor is below 1"), spent
    again, more = run_trial(deck, replace(trial, deck=strong, again="_strong"), wish, limit)
    return replace(trial, figure=again.figure / STRONGER, width=again.width / STRONGER, seconds=again.seconds, reason=again.reason), spent + more


class Search:
    """The runs of a study: remaining trials, results, time used."""

    def __init__(self, deck: Deck, wish: Wish, tell: Callable[[Trial, float], None]) -> None:
        self.deck, self.wish, self.tell = deck, wish, tell
        self.levels = levels_of(deck)
        self.methods = methods_of(deck) + ([REFINED] if can_refine(deck) else [])
        self.trials: list[Trial] = []
        self.spent = 0.0
        self.ending = ""

    def of(self, method: Method) -> list[Trial]:
        """Trials of a method on its grids, from the coarsest, with the steps of the deck."""
        return [t for t in self.trials if t.method == method.label and t.steps == 1]

    def next_level(self, method: Method) -> int | None:
        """The next grid of a method; None if all have been run, or too many failed."""
        own = self.of(method)
        if method == REFINED and own and not own[-1].good:
            return None
        if len(own) >= MISSES and not any(t.good for t in own[-MISSES:]):
            return None
        levels = self.levels_for(method)
        return levels[len(own)] if len(own) < len(levels) else None

    def levels_for(self, method: Method) -> Sequence[int]:
        """Grids of a method; none to be refined before the grid of the deck has been run."""
        if method != REFINED:
            return self.levels
        return LEVELS if any(t.level == 0 and t.good for t in self.of(OWN)) else ()

    def goes_first(self, method: Method) -> bool:
        """Whether the next run of a method uses body-fitted triangles refined by its strain, or those from which they start."""
        return REFINED in self.methods and (method == REFINED or (method == OWN and all(t.level != 0 for t in self.of(OWN))))

    def before(self, level: int) -> Trial:
        """The run whose strain is used for refinement to a level."""
        return next(t for t in self.of(REFINED if level > LEVELS[0] else OWN) if t.level == level - 1)

    def foretold(self, method: Method) -> float:
        """Predicted CPU seconds of the next run of a method, at least the resolution of the timing; those of the method of the deck if it has no run."""
        known = [t for t in self.of(method) if t.good] or [t for t in self.trials if t.good and t.steps == 1]
        if not known:
            return 0.0
        level = self.next_level(method)
        if method == REFINED and level is not None:
            last = self.before(level)
            return max(NOISE, COST * last.seconds) if last.good else self.wish.budget
        last = known[-1]
        return max(NOISE, last.seconds * (2 ** dimension(self.deck) * GROWTH) ** ((level or 0) - last.level))

    def try_one(self, method: Method, level: int, steps: int) -> None:
        """Run one variant and store its result."""
        if method == REFINED:
            changed = refined(self.deck, level, self.wish.root / self.before(level).name / "results")
            if changed is self.deck:
                self.trials.append(Trial(method.label, level, steps, "", reason="no shear strain for refinement"))
                self.tell(self.trials[-1], self.spent)
                return
        else:
            gridded = at_level(self.deck, level)
            assert gridded is not None, "only existing levels"
            changed = with_method(gridded, method)
        text = (with_steps(changed, steps) if steps > 1 else changed).text()
        left = self.wish.budget - self.spent
        trial, spent = run_trial(self.deck, Trial(method.label, level, steps, text), self.wish, left)
        self.spent += spent
        self.trials.append(trial)
        self.tell(trial, self.spent)

    def go(self, close_enough: Callable[[Sequence[Trial]], float]) -> None:
        """Search; `close_enough` returns the seconds of the cheapest sufficiently accurate run, infinite without one."""
        while True:
            waiting = [m for m in self.methods if self.next_level(m) is not None]
            if not waiting:
                self.ending = "all grids have been run"
                break
            limit = (1.0 - KEPT_FOR_STEPS) * self.wish.budget - self.spent
            held = [m for m in waiting if self.foretold(m) <= limit]
            method = min(held or waiting, key=lambda m: (not self.goes_first(m), self.foretold(m), self.next_level(m)))
            cost = self.foretold(method)
            if cost > close_enough(self.trials):
                self.ending = "no remaining run could be cheaper than the selected one"
                break
            if not held:
                self.ending = f"the budget of {self.wish.budget:.0f} s does not suffice for the next run (about {cost:.0f} s)"
                break
            self.try_one(method, self.next_level(method) or 0, 1)
        self.double_steps()

    def double_steps(self) -> None:
        """Twice the number of steps, on the finest grid for which the budget suffices, with the method of that run."""
        good = [t for t in self.trials if t.good and t.steps == 1]
        for trial in sorted(good, key=lambda t: (-t.level, t.seconds)):
            if self.spent + 2.2 * trial.seconds <= self.wish.budget:
                method = next(m for m in self.methods if m.label == trial.method)
                self.try_one(method, trial.level, 2)
                if self.trials[-1].good:
                    return
