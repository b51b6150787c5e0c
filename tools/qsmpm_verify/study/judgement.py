"""The result of all runs of a study with its band, the error of each, and the cheapest sufficiently accurate run."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from qsmpm_verify.front import Sample, lasting_errors
from qsmpm_verify.study.band import Band, agreed, of_grids, of_steps
from qsmpm_verify.study.cards import Deck
from qsmpm_verify.study.refined import REFINED
from qsmpm_verify.study.search import Trial
from qsmpm_verify.study.variants import OWN


@dataclass(frozen=True)
class Answer:
    """Result of a study: value and half width of its band, their basis, and notes on limitations."""

    value: float
    half: float
    grids: float
    steps: float | None
    methods: tuple[str, ...]
    notes: tuple[str, ...]

    def error(self, trial: Trial) -> float:
        """Relative error of a run."""
        return abs(trial.figure - self.value) / (abs(self.value) or 1.0)

    @property
    def share(self) -> float:
        """Relative half width."""
        return self.half / (abs(self.value) or 1.0)


def figures_by_method(trials: Sequence[Trial]) -> dict[str, list[Trial]]:
    """Successful runs with the steps of the deck by method, on consecutive grids up to the finest; refined meshes start from the grid of the deck."""
    found: dict[str, list[Trial]] = {}
    usual = [t for t in trials if t.good and t.steps == 1]
    starts = [replace(t, method=REFINED.label) for t in usual if (t.method, t.level) == (OWN.label, 0)]
    for trial in sorted(usual + (starts if any(t.method == REFINED.label for t in usual) else []), key=lambda t: t.level):
        own = found.setdefault(trial.method, [])
        if own and own[-1].level != trial.level - 1:
            own.clear()
        own.append(trial)
    return found


def width_of(own: Sequence[Trial]) -> float:
    """Width of the results on which the band of a method is based: those of its three finest grids."""
    return max(t.width for t in own[-3:])


def bands_by_method(trials: Sequence[Trial]) -> dict[str, Band | None]:
    """The band of each method with two grids or more; None if its results have no limit."""
    return {
        method: of_grids([t.figure for t in own], width_of(own))
        for method, own in figures_by_method(trials).items() if len(own) >= 2
    }  # fmt: skip


def change_by_steps(trials: Sequence[Trial]) -> float | None:
    """Change of the result with twice the steps, on the finest grid run in this way; None without such a run."""
    for doubled in sorted((t for t in trials if t.good and t.steps == 2), key=lambda t: -t.level):
        single = [t for t in trials if t.good and (t.method, t.level, t.steps) == (doubled.method, doubled.level, 1)]
        if single:
            return doubled.figure - single[0].figure
    return None


def answer_of(trials: Sequence[Trial]) -> Answer | None:
    """The result; None if no method converges. Two grids count only while no method converges over three, and if one diverges over
    three, only if two methods agree."""
    counts = {method: len(own) for method, own in figures_by_method(trials).items()}
    bands = bands_by_method(trials).items()
    seen = any(band is not None and counts[m] >= 3 for m, band in bands)
    trusted = {m: band for m, band in bands if band is not None and (counts[m] >= 3 or not seen)}
    if not seen and any(count >= 3 for count in counts.values()):
        trusted = {m: a for m, a in trusted.items() if any(a.apart(b) == 0 for n, b in trusted.items() if n != m)}
    if not trusted:
        return None
    band, stretched = agreed(list(trusted.values()))
    notes = [] if seen else ["no method converges over three grids: the order is assumed, not observed"]
    lost = [m for m, b in bands if b is None and counts[m] >= 3]
    if lost:
        notes.append(f"no convergence on these grids: {', '.join(lost)}")
    if stretched:
        notes.append("methods disagree beyond their bands: the band was extended to include them")
    change = change_by_steps(trials)
    shift, half = of_steps(change) if change is not None else (0.0, 0.0)
    figures = figures_by_method(trials)
    half += max(width_of(figures[method]) for method in trusted)
    if change is None:
        notes.append("no run with twice the steps: the error of the steps is not included in the band")
    return Answer(band.value + shift, band.half + half, band.half, change, tuple(trusted), tuple(notes))


def within_bounds(answer: Answer | None, bounds: tuple[float, float] | None) -> Answer | None:
    """The result; if it is outside the bounds of limit analysis, its band is extended to include them."""
    if answer is None or bounds is None or bounds[0] <= answer.value <= bounds[1]:
        return answer
    half = max(answer.half, *(abs(bound - answer.value) for bound in bounds))
    return replace(answer, half=half, notes=(*answer.notes, "the band was extended to the bounds of limit analysis"))


def choice_of(trials: Sequence[Trial], answer: Answer | None, target: float) -> Trial | None:
    """The cheapest run that is within the target even at the far end of the band, and whose finer runs are as well."""
    if answer is None:
        return None
    good = [t for t in trials if t.good]
    samples = [
        Sample("", f"{t.method}, {t.steps}", 2.0**t.level, max(answer.error(t), 1e-300), max(t.seconds, 1e-3)) for t in good
    ]
    errors = lasting_errors(samples)
    near = [t for t, error in zip(good, errors) if error + answer.share <= target]
    return min(near, key=lambda t: (t.cost, t.level, t.steps), default=None)


def seconds_of_choice(trials: Sequence[Trial], target: float) -> float:
    """Cost of the selected run so far; infinite while no method has three grids or no run is sufficiently accurate."""
    if all(len(own) < 3 for own in figures_by_method(trials).values()):
        return math.inf
    choice = choice_of(trials, answer_of(trials), target)
    return math.inf if choice is None else choice.cost


def warnings_of(deck: Deck) -> list[str]:
    """Properties of the deck by which a result inherently depends on the grid."""
    found = []
    for card in deck.all("SOFTENING"):
        if card.value("REGULARISATION") == "NONE":
            found.append("softening without REGULARISATION=CELL: the work of a slip surface decreases with the cell size, "
                         "no grid is converged")
    davis = [card for card in deck.all("SAFETY") if (card.value("FLOW") or "").startswith("DAVIS")]
    for card in [] if davis else deck.all("MOHR COULOMB"):
        rows = card.data()
        try:
            phi, psi = float(rows[0][1]), float(rows[0][2])
        except (IndexError, ValueError):
            continue
        if psi < phi - 1.0:
            found.append(f"phi = {phi:g}, psi = {psi:g}: after the limit load non-associated flow localises in "
                         "bands one cell wide, and results there may continue to depend on the grid")
    return list(dict.fromkeys(found))
