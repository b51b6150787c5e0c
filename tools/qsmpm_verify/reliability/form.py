"""The design point: its distance beta from the mean in standard normal space, and the probability from a response surface there.

The margin g is evaluated at a centre and on both sides of it along each variable; the next centre is the point of the plane through them
that is nearest to the origin (Hasofer and Lind 1974, Rackwitz and Fiessler 1978). Differences are as wide as half a standard deviation
or more, so that the bracket of a factor does not act as noise. After convergence, failures are counted by importance sampling on the quadratic
surface without mixed terms through the last values (Bucher and Bourgund 1990).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from qsmpm_verify.results import Array
from qsmpm_verify.trouble import RunFailed

Answers = Callable[[Array], Array]
"""Margins for rows of standard normal numbers; NaN without result."""

SPREADS = (1.0, 0.7, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5)
"""Distance of the sampled values from the centre, by iteration."""
FURTHEST, STRIDE = 8.0, 2.5
"""Limit of the search for the design point, and of its distance from the centre of an iteration."""
SETTLED, NEAR = 0.05, 0.3
"""Change of beta and of the centre at which the search ends."""
SAMPLES = 100_000
SEED = 20_260_101


@dataclass(frozen=True)
class Surface:
    """g(u) = constant + slope u + bend u^2."""

    constant: float
    slope: Array
    bend: Array

    def at(self, u: Array) -> Array:
        """Values at rows of u."""
        return self.constant + np.asarray(u) @ self.slope + (np.asarray(u) ** 2) @ self.bend

    def gradient(self, u: Array) -> Array:
        """Gradient at a place."""
        return self.slope + 2.0 * self.bend * u


@dataclass(frozen=True)
class Form:
    """Result of the search."""

    beta: float
    design: Array
    """Standard normal numbers of the design point."""
    alpha: Array
    """Direction of the design point: its squares are the importance of the variables."""
    surface: Surface
    probability: float
    """From importance sampling on the surface."""
    answers: int
    settled: bool

    @property
    def first_order(self) -> float:
        """First-order probability."""
        return float(stats.norm.cdf(-self.beta))


def around(centre: Array, spread: float) -> Array:
    """The centre and its neighbours."""
    steps = spread * np.eye(len(centre))
    return np.vstack([centre, centre + steps, centre - steps])


def fit(places: Array, values: Array) -> Surface:
    """The surface through the values."""
    matrix = np.hstack([np.ones((len(places), 1)), places, places**2])
    found = np.linalg.lstsq(matrix, values, rcond=None)[0]
    n = places.shape[1]
    return Surface(float(found[0]), found[1 : n + 1], found[n + 1 :])


def taken(answers: Answers, centre: Array, spread: float) -> tuple[Array, Array, int]:
    """Results around a centre, closer to it where there is none, and the number of evaluations."""
    places = around(centre, spread)
    values = answers(places)
    asked = len(places)
    lost = ~np.isfinite(values)
    if lost[0]:
        raise RunFailed("the run at the centre has no result: its initial state is not stable, or the deck does not run")
    if lost.any():
        places[lost] = 0.5 * (places[lost] + centre)
        values[lost] = answers(places[lost])
        asked += int(lost.sum())
    if not np.isfinite(values).all():
        raise RunFailed("runs beside the centre have no result, nor at half the distance")
    return places, values, asked


def find_design(answers: Answers, count: int) -> Form:
    """Search for the design point of `count` variables."""
    centre, before, asked, settled, middle = np.zeros(count), math.inf, 0, False, math.nan
    for spread in SPREADS:
        places, values, more = taken(answers, centre, spread)
        asked += more
        surface = fit(places, values)
        middle = float(values[0]) if math.isnan(middle) else middle
        slope = surface.gradient(centre)
        steepness = float(slope @ slope)
        if not steepness > 0.0:
            raise RunFailed("the result does not depend on any of the variables")
        wanted = (slope @ centre - float(values[0])) / steepness * slope
        way = wanted - centre
        design = centre + way * min(1.0, STRIDE / max(float(np.linalg.norm(way)), 1.0e-12))
        design *= min(1.0, FURTHEST / max(float(np.linalg.norm(design)), 1.0e-12))
        beta = math.copysign(float(np.linalg.norm(design)), middle)
        settled = abs(beta - before) < SETTLED and float(np.linalg.norm(way)) < NEAR
        if settled:
            break
        before, centre = beta, design
    probability = sampled(surface, design, beta) if settled else float(stats.norm.cdf(-beta))
    return Form(beta, design, design / beta if beta else np.zeros(count), surface, probability, asked, settled)


def sampled(surface: Surface, design: Array, beta: float) -> float:
    """Probability of g < 0 by importance sampling around the design point."""
    rng = np.random.default_rng(SEED)
    u = design + rng.standard_normal((SAMPLES, len(design)))
    weights = np.exp(0.5 * ((u - design) ** 2).sum(axis=1) - 0.5 * (u**2).sum(axis=1))
    # Of what is rare: failures for a safe mean, survival for one that fails.
    rare = surface.at(u) < 0.0 if beta >= 0.0 else surface.at(u) >= 0.0
    share = float(np.mean(np.where(rare, weights, 0.0)))
    return min(1.0, share) if beta >= 0.0 else max(0.0, 1.0 - share)


@dataclass(frozen=True)
class Sample:
    """Random runs: their numbers and margins, NaN for a run that counts as failed."""

    values: Array
    margins: Array

    @property
    def probability(self) -> float:
        """Share of failures."""
        return float(np.mean(~(self.margins >= 0.0)))

    @property
    def error(self) -> float:
        """Its standard error."""
        p = self.probability
        return math.sqrt(p * (1.0 - p) / len(self.margins))


def hypercube(count: int, runs: int, seed: int) -> Array:
    """Standard normal numbers of a Latin hypercube."""
    rng = np.random.default_rng(seed)
    cells = np.array([rng.permutation(runs) for _ in range(count)]).reshape(count, runs).T
    return np.asarray(stats.norm.ppf((cells + rng.random((runs, count))) / runs))


def shares(alpha: Array, names: Sequence[str]) -> dict[str, float]:
    """Sensitivities by name: a negative one means that the margin grows with the variable."""
    return {name: float(value) for name, value in zip(names, alpha, strict=True)}
