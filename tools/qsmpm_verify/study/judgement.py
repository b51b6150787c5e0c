"""The answer of all runs of a study with its band, the error of each, and the cheapest run that is close enough."""

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
    """What a study found: value and half width of its band, what they rest on, and what stands against them."""

    value: float
    half: float
    grids: float
    steps: float | None
    methods: tuple[str, ...]
    notes: tuple[str, ...]

    def error(self, trial: Trial) -> float:
        """Error of a run, a share of the answer."""
        return abs(trial.figure - self.value) / (abs(self.value) or 1.0)

    @property
    def share(self) -> float:
        """Half width as a share of the answer."""
        return self.half / (abs(self.value) or 1.0)


def figures_by_method(trials: Sequence[Trial]) -> dict[str, list[Trial]]:
    """Good runs in the deck's own steps by method, on the grids that follow one another up to the finest; what is refined starts from the deck's own grid."""
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
    """Width of the figures that a method's band rests on: those of its three finest grids."""
    return max(t.width for t in own[-3:])


def bands_by_method(trials: Sequence[Trial]) -> dict[str, Band | None]:
    """The band of each method that has two grids or more; none where its figures go nowhere."""
    return {
        method: of_grids([t.figure for t in own], width_of(own))
        for method, own in figures_by_method(trials).items() if len(own) >= 2
    }  # fmt: skip


def change_by_steps(trials: Sequence[Trial]) -> float | None:
    """What twice the steps changed, on the finest grid that was run so; none without such a run."""
    for doubled in sorted((t for t in trials if t.good and t.steps == 2), key=lambda t: -t.level):
        single = [t for t in trials if t.good and (t.method, t.level, t.steps) == (doubled.method, doubled.level, 1)]
        if single:
            return doubled.figure - single[0].figure
    return None


def answer_of(trials: Sequence[Trial]) -> Answer | None:
    """The answer; none where no method converges. Two grids count only while no method converges over three, and where one goes nowhere over
    three only if two methods agree."""
    counts = {method: len(own) for method, own in figures_by_method(trials).items()}
    bands = bands_by_method(trials).items()
    seen = any(band is not None and counts[m] >= 3 for m, band in bands)
    trusted = {m: band for m, band in bands if band is not None and (counts[m] >= 3 or not seen)}
    if not seen and any(count >= 3 for count in counts.values()):
        trusted = {m: a for m, a in trusted.items() if any(a.apart(b) == 0 for n, b in trusted.items() if n != m)}
    if not trusted:
        return None
    band, stretched = agreed(list(trusted.values()))
    notes = [] if seen else ["no method converges over three grids: the order is assumed, not seen"]
    lost = [m for m, b in bands if b is None and counts[m] >= 3]
    if lost:
        notes.append(f"no limit in sight on these grids: {', '.join(lost)}")
    if stretched:
        notes.append("methods disagree beyond their bands: the band was stretched until they meet")
    change = change_by_steps(trials)
    shift, half = of_steps(change) if change is not None else (0.0, 0.0)
    figures = figures_by_method(trials)
    half += max(width_of(figures[method]) for method in trusted)
    if change is None:
        notes.append("no run in twice the steps: what the steps cost is not in the band")
    return Answer(band.value + shift, band.half + half, band.half, change, tuple(trusted), tuple(notes))


def within_bounds(answer: Answer | None, bounds: tuple[float, float] | None) -> Answer | None:
    """The answer, whose band holds all that limit analysis leaves open where it does not lie within it."""
    if answer is None or bounds is None or bounds[0] <= answer.value <= bounds[1]:
        return answer
    half = max(answer.half, *(abs(bound - answer.value) for bound in bounds))
    return replace(answer, half=half, notes=(*answer.notes, "the band was stretched to the bounds of limit analysis"))


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
    """Cost of the choice so far; infinite while no method has three grids or no run is close enough."""
    if all(len(own) < 3 for own in figures_by_method(trials).values()):
        return math.inf
    choice = choice_of(trials, answer_of(trials), target)
    return math.inf if choice is None else choice.cost


def warnings_of(deck: Deck) -> list[str]:
    """What in the deck makes an answer depend on the grid by its nature."""
    found = []
    for card in deck.all("SOFTENING"):
        if card.value("REGULARISATION") == "NONE":
            found.append("softening without REGULARISATION=CELL: the work of a slip surface falls with the cells, "
                         "no grid is the last one")
    davis = [card for card in deck.all("SAFETY") if (card.value("FLOW") or "").startswith("DAVIS")]
    for card in [] if davis else deck.all("MOHR COULOMB"):
        rows = card.data()
        try:
            phi, psi = float(rows[0][1]), float(rows[0][2])
        except (IndexError, ValueError):
            continue
        if psi < phi - 1.0:
            found.append(f"phi = {phi:g}, psi = {psi:g}: past the limit load flow that is not associated localises in "
                         "bands of a cell's width, and figures there may go on changing with the grid")
    return list(dict.fromkeys(found))
