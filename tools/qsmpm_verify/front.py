"""Efficient runs of a study: front of error against cost, orders of convergence, and the choice for a requested error."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Sample:
    """One run of a study: its cost and its error; NaN if it failed, with the reason."""

    study: str
    method: str
    size: float
    error: float
    seconds: float
    name: str = ""
    message: str = ""
    at_floor: bool = False

    @property
    def good(self) -> bool:
        """Whether it can be plotted."""
        return math.isfinite(self.error) and math.isfinite(self.seconds) and self.error > 0 and self.seconds > 0


def lasting_errors(samples: Sequence[Sample]) -> list[float]:
    """The error attributed to each run: its own or that of a finer run of the same method, whichever is larger.

    An error that changes sign during refinement may be small on one grid by coincidence.
    """
    claims: dict[int, float] = {}
    for method in dict.fromkeys(s.method for s in samples):
        worst = 0.0
        own = [i for i, s in enumerate(samples) if s.method == method and s.good]
        for i in sorted(own, key=lambda i: -samples[i].size):
            worst = max(worst, samples[i].error)
            claims[i] = worst
    return [claims.get(i, math.nan) for i in range(len(samples))]


def front(samples: Sequence[Sample]) -> list[int]:
    """Indices of the runs for which no other run is both cheaper and more accurate, from the cheapest on."""
    errors = lasting_errors(samples)
    best, found = math.inf, []
    usable = [i for i, s in enumerate(samples) if s.good]
    for i in sorted(usable, key=lambda i: (samples[i].seconds, errors[i])):
        if errors[i] < best:
            best = errors[i]
            found.append(i)
    return found


def order(samples: Sequence[Sample]) -> float | None:
    """Order of convergence of a method, the slope of log(error) over log(size), of two or more runs above the floor."""
    usable = [s for s in samples if s.good and not s.at_floor]
    if len(usable) < 2:
        return None
    slope = np.polyfit(np.log([s.size for s in usable]), np.log([s.error for s in usable]), 1)[0]
    return -float(slope)


@dataclass(frozen=True)
class Choice:
    """The cheapest run whose error does not exceed the requested one."""

    asked: float
    sample: Sample
    error: float


def choices(samples: Sequence[Sample]) -> list[Choice]:
    """The cheapest run for every 1, 2 and 5 times a power of ten within the range of the front, and the most accurate run.

    A run that applies to several of them is listed once, for the smallest.
    """
    errors = lasting_errors(samples)
    along = front(samples)
    if not along:
        return []
    low, high = errors[along[-1]], errors[along[0]]
    ladder = [
        m * 10.0**k for k in range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1) for m in (1, 2, 5)
    ]
    found: dict[int, Choice] = {}
    for asked in sorted(ladder, reverse=True):
        hits = [i for i in along if errors[i] <= asked]
        if hits:
            found[hits[0]] = Choice(asked, samples[hits[0]], errors[hits[0]])
    last = along[-1]
    if last not in found:
        digits = 10.0 ** math.floor(math.log10(errors[last]) - 1)
        found[last] = Choice(math.ceil(errors[last] / digits) * digits, samples[last], errors[last])
    return list(found.values())
