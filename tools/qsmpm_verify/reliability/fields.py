"""Spatially variable parameters: random fields of parameters of a material, generated for each run.

z, standard normal, has the correlation exp(-2 |dx|/theta_x - 2 |dy|/theta_y) (Markov; Vanmarcke 1983), theta the scales of fluctuation;
x = F^-1(Phi(z)). It is generated on a lattice, z = L_y N L_x^T with the factors of the two correlations, and passed to the program as samples
(*FIELD OF VALUES). Of two fields with a correlation the second has z = r z_1 + sqrt(1 - r^2) z_2. Run i of a seed has the same field on any
number of processors.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from qsmpm_verify.reliability.variables import Variable, normal_correlation, read_variable
from qsmpm_verify.results import Array
from qsmpm_verify.study.cards import Deck
from qsmpm_verify.trouble import Trouble

SPACING, MOST = 0.25, 20_000
"""Spacing of samples, equal along both axes, relative to the smaller scale of fluctuation, and their largest number."""
COARSEST = 0.5
"""Largest cell width relative to the scale of fluctuation."""
LEAST = 1.0e-6
"""Cohesion on the keyword of the law, the lower bound of the samples, relative to the mean."""
CARDS = {"c": "MOHR COULOMB", "phi": "MOHR COULOMB", "E": "ELASTIC", "gamma": "UNIT WEIGHT", "k": "PERMEABILITY"}
"""Parameters that may vary in space, and their keywords."""
STEEPEST, RARE = 90.0, 1.0e-6
"""Upper bound of friction angles, and the admissible probability of values outside the range of the parameter."""


@dataclass(frozen=True)
class Field:
    """A parameter of a material as a random field: its distribution, its scales along x and y, and the correlated field."""

    variable: Variable
    scales: tuple[float, float]
    partner: Field | None = None
    rho: float = 0.0
    """Correlation of the standard normal fields of this one and its partner."""

    def mark(self) -> str:
        """Comment at the position of the keyword for the samples of the material."""
        return f"** fields of '{self.variable.of}'"

    def normals(self, xs: Array, ys: Array, seed: int, run: int) -> Array:
        """z on a lattice, (ys, xs)."""
        noise = np.random.default_rng([seed, run, *self.variable.name.encode()]).standard_normal((len(ys), len(xs)))
        own = factor(ys, self.scales[1]) @ noise @ factor(xs, self.scales[0]).T
        return own if self.partner is None else self.rho * self.partner.normals(xs, ys, seed, run) + math.sqrt(1.0 - self.rho**2) * own

    def samples(self, xs: Array, ys: Array, seed: int, run: int) -> Array:
        """The parameter on a lattice, (ys, xs)."""
        return self.variable.value(self.normals(xs, ys, seed, run))


def factor(places: Array, scale: float) -> Array:
    """L of the correlation along an axis, C = L L^T."""
    return np.linalg.cholesky(np.exp(-2.0 * np.abs(places[:, None] - places[None, :]) / scale))


def read_field(table: Mapping[str, Any]) -> Field:
    """A `[[field]]` of the file: a variable of a material, and `scales`."""
    words = dict(table)
    scales = words.pop("scales", None)
    name = words.get("name", "")
    if not (isinstance(scales, list) and len(scales) == 2 and all(isinstance(s, int | float) and s > 0.0 for s in scales)):
        raise Trouble(f"field '{name}': scales must be two lengths, along x and along y: scales = [20, 2]")
    column = words.pop("parameter", "c")
    if "card" in words or "column" in words or column not in CARDS:
        raise Trouble(f"field '{name}': `parameter` must be one of {', '.join(CARDS)} of the material named by `of`; other parameters cannot vary in space")
    variable = read_variable({**words, "card": CARDS[column], "column": column})
    if variable.law.ppf(RARE) < 0.0 or (column == "phi" and variable.law.isf(RARE) >= STEEPEST):
        raise Trouble(f"field '{name}': {column} would be out of range at some points: use a smaller sd, or a lognormal or uniform distribution")
    return Field(variable, (float(scales[0]), float(scales[1])))


def with_partners(fields: Sequence[Field], correlations: Sequence[tuple[str, str, float]]) -> list[Field]:
    """Fields; the second field of a correlated pair refers to the first."""
    found = {field.variable.name: field for field in fields}
    if len(found) < len(fields):
        raise Trouble("two fields have the same name")
    for first, second, rho in correlations:
        one, other = found[first], found[second]
        if one is other or not -1.0 < rho < 1.0:
            raise Trouble(f"the correlation of '{first}' and '{second}' must be between -1 and 1, and of two different fields")
        if one.scales != other.scales:
            raise Trouble(f"fields '{first}' and '{second}' are correlated and must have the same scales")
        if other.partner is not None or one.partner is not None:
            raise Trouble(f"field '{second}' may be correlated with one other field only")
        found[second] = replace(other, partner=one, rho=normal_correlation(one.variable, other.variable, rho))
    return list(found.values())


def lattice(deck: Deck, field: Field) -> tuple[Array, Array]:
    """Positions of the samples over the *GRID of the deck, whose cells must be fine enough to resolve the variation."""
    axes, step, name = [], SPACING * min(field.scales), field.variable.name
    for axis, scale in zip("XY", field.scales, strict=True):
        rows = [row for card in deck.cards if card.keyword == "GRID" for row in card.data() if row[0].upper() == axis]
        ends = [float(word) for row in rows for word in (row[2:] if row[1].upper() == "LINES" else row[1:3])]
        if not ends:
            raise Trouble(f"field '{name}': the deck has no *GRID that defines its extent")
        cells = sum(len(row) - 3 if row[1].upper() == "LINES" else int(row[3]) for row in rows)
        width = (max(ends) - min(ends)) / max(1, cells)
        if width > COARSEST * scale:
            raise Trouble(f"field '{name}': cells of the *GRID are {width:g} wide along {axis.lower()}, and a scale of {scale:g} requires at most {COARSEST * scale:g} "
                          "to resolve the variation")
        axes.append(np.linspace(min(ends), max(ends), max(2, math.ceil((max(ends) - min(ends)) / step) + 1)))
    if len(axes[0]) * len(axes[1]) > MOST:
        raise Trouble(f"field '{name}': a scale of {min(field.scales):g} requires {len(axes[0])} x {len(axes[1])} samples; at most {MOST} are supported")
    return axes[0], axes[1]


def stronger_samples(values: Array, column: str, times: float) -> Array:
    """Samples of a strength multiplied by `times`: of cohesion and of tan phi; others are unchanged."""
    if column == "phi":
        return np.degrees(np.arctan(times * np.tan(np.radians(values))))
    return times * values if column == "c" else values


def written(fields: Sequence[Field], deck: Deck, text: str, root: Path, seed: int, run: int, times: float = 1.0) -> str:
    """The deck with the fields of a run, whose samples are written to files; the strength is multiplied by `times`."""
    cards: dict[str, list[str]] = {}
    for field in fields:
        column = field.variable.column
        xs, ys = lattice(deck, field)
        values = stronger_samples(field.samples(xs, ys, seed, run), column, times)
        rows = [f"{x:.9g},{y:.9g},{values[j, i]:.9g}" for j, y in enumerate(ys) for i, x in enumerate(xs)]
        content = "\n".join([f"x,y,{column}", *rows]) + "\n"
        path = root.resolve() / "fields" / f"{hashlib.sha256(content.encode()).hexdigest()[:16]}.csv"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content, encoding="utf-8")
        cards.setdefault(field.mark(), ["*FIELD OF VALUES"]).append(f'{column}, "{path}"')
    for mark, lines in cards.items():
        text = text.replace(mark, "\n".join(lines))
    return text
