"""Uncertain parameters: their distributions, their correlation, and the transformation to independent standard normal variables.

x_i = F_i^-1(Phi(z_i)), z = L u, L L^T the correlation of z. The correlation of z that gives the correlation of x follows from the distributions
(Nataf; Liu and Der Kiureghian 1986), for lognormal pairs in closed form and otherwise by quadrature.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import optimize, stats

from qsmpm_verify.results import Array
from qsmpm_verify.trouble import Trouble

KINDS = {"normal": ("mean", "sd"), "lognormal": ("mean", "sd"), "gumbel": ("mean", "sd"), "uniform": ("low", "high")}
QUADRATURE = 24
"""Gauss-Hermite points in each direction."""


@dataclass(frozen=True)
class Variable:
    """An uncertain number of the deck: its position and its distribution."""

    name: str
    card: str
    of: str
    column: str
    line: int
    law: Any
    kind: str

    def value(self, z: Array | float) -> Array:
        """The value for a standard normal number."""
        tail = np.asarray(z, dtype=float)
        # The smaller tail keeps its digits.
        return np.where(tail < 0.0, self.law.ppf(stats.norm.cdf(tail)), self.law.isf(stats.norm.sf(tail)))


def law_of(kind: str, numbers: Mapping[str, float], name: str) -> Any:
    """A distribution by mean and standard deviation, or by its bounds."""
    if kind == "uniform":
        if not numbers["low"] < numbers["high"]:
            raise Trouble(f"variable '{name}': low must be below high")
        return stats.uniform(numbers["low"], numbers["high"] - numbers["low"])
    mean, sd = numbers["mean"], numbers["sd"]
    if not sd > 0.0:
        raise Trouble(f"variable '{name}': sd must be above 0")
    if kind == "normal":
        return stats.norm(mean, sd)
    if kind == "gumbel":
        scale = sd * math.sqrt(6.0) / math.pi
        return stats.gumbel_r(mean - np.euler_gamma * scale, scale)
    if not mean > 0.0:
        raise Trouble(f"variable '{name}': the mean of a lognormal distribution must be above 0")
    spread = math.sqrt(math.log1p((sd / mean) ** 2))
    return stats.lognorm(spread, scale=mean * math.exp(-0.5 * spread**2))


def read_variable(table: Mapping[str, Any]) -> Variable:
    """A `[[variable]]` of the file; unknown words are errors."""
    words = dict(table)
    name = str(words.pop("name", ""))
    if not name:
        raise Trouble("a variable requires a name")
    kind = str(words.pop("distribution", "lognormal"))
    if kind not in KINDS:
        raise Trouble(f"variable '{name}': distribution '{kind}' must be one of {', '.join(KINDS)}")
    if "cov" in words and "mean" in words:
        words["sd"] = float(words.pop("cov")) * abs(float(words["mean"]))
    missing = [key for key in (*KINDS[kind], "card", "column") if key not in words]
    if missing:
        raise Trouble(f"variable '{name}': {missing[0]} is missing")
    numbers = {key: float(words.pop(key)) for key in KINDS[kind]}
    place = str(words.pop("card")).lstrip("*"), str(words.pop("of", "")), str(words.pop("column")), int(words.pop("line", 1))
    if words:
        raise Trouble(f"variable '{name}': unknown word '{next(iter(words))}'")
    return Variable(name, *place, law_of(kind, numbers, name), kind)


def normal_correlation(one: Variable, other: Variable, rho: float) -> float:
    """Correlation of the standard normal numbers for a correlation of the variables."""
    if one.kind == other.kind == "normal":
        return rho
    if one.kind == other.kind == "lognormal":
        a, b = (law.std() / law.mean() for law in (one.law, other.law))
        if rho * a * b <= -1.0:
            raise Trouble(f"variables '{one.name}' and '{other.name}' cannot have a correlation of {rho:g}")
        return math.log1p(rho * a * b) / math.sqrt(math.log1p(a * a) * math.log1p(b * b))
    places, weights = np.polynomial.hermite_e.hermegauss(QUADRATURE)
    weights = weights / weights.sum()
    first = (one.value(places) - one.law.mean()) / one.law.std()

    def miss(normal: float) -> float:
        inner = normal * places[:, None] + math.sqrt(max(0.0, 1.0 - normal**2)) * places[None, :]
        second = (other.value(inner) - other.law.mean()) / other.law.std()
        return float(np.einsum("i,j,i,ij->", weights, weights, first, second)) - rho

    low, high = -0.9999, 0.9999
    if miss(low) > 0.0 or miss(high) < 0.0:
        raise Trouble(f"variables '{one.name}' and '{other.name}' cannot have a correlation of {rho:g}")
    return float(optimize.brentq(miss, low, high, xtol=1.0e-10))


@dataclass(frozen=True)
class Space:
    """All variables, and the factor of their correlation matrix."""

    variables: tuple[Variable, ...]
    factor: Array

    def values(self, u: Array) -> Array:
        """Values of the variables for independent standard normal numbers, (..., variables)."""
        z = np.asarray(u) @ self.factor.T
        if not self.variables:
            return np.asarray(u)
        return np.stack([variable.value(z[..., i]) for i, variable in enumerate(self.variables)], axis=-1)


def make_space(variables: Sequence[Variable], correlations: Sequence[tuple[str, str, float]]) -> Space:
    """The space of variables and the correlations of pairs."""
    names = [variable.name for variable in variables]
    if len(set(names)) < len(names):
        raise Trouble("two variables have the same name")
    matrix = np.eye(len(names))
    for first, second, rho in correlations:
        for name in (first, second):
            if name not in names:
                raise Trouble(f"a correlation names '{name}', which is not a variable; known are {', '.join(names)}")
        i, j = names.index(first), names.index(second)
        if i == j or not -1.0 < rho < 1.0:
            raise Trouble(f"the correlation of '{first}' and '{second}' must be between -1 and 1, and of two different variables")
        matrix[i, j] = matrix[j, i] = normal_correlation(variables[i], variables[j], rho)
    try:
        return Space(tuple(variables), np.linalg.cholesky(matrix))
    except np.linalg.LinAlgError:
        raise Trouble("the correlations are inconsistent: their matrix is not positive definite") from None
