"""Strength that scatters from place to place: a random field of the cohesion of a material, one for each run.

z, standard normal, has the correlation exp(-2 |dx|/theta_x - 2 |dy|/theta_y) (Markov; Vanmarcke 1983), theta the scales of fluctuation;
c = F^-1(Phi(z)). It is drawn on a lattice, z = L_y N L_x^T with the factors of the two correlations, and reaches the program as samples
(*STRENGTH PROFILE, TYPE=FIELD). Run i of a seed has the same field on any number of processors.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from qsmpm_verify.reliability.variables import Variable, read_variable
from qsmpm_verify.results import Array
from qsmpm_verify.study.cards import Deck
from qsmpm_verify.trouble import Trouble

SPACING, MOST = 0.25, 20_000
"""Distance of samples, the same along both axes, in the smaller scale of fluctuation, and the most of them."""
COARSEST = 0.5
"""Width of cells in scales of fluctuation, at the most."""
LEAST = 1.0e-6
"""Cohesion on the card of the law, below which no sample counts, as a share of the mean."""


@dataclass(frozen=True)
class Field:
    """The cohesion of a material as a random field: its distribution and its scales along x and y."""

    variable: Variable
    scales: tuple[float, float]

    def mark(self) -> str:
        """Comment that stands where the card of the samples will."""
        return f"** field '{self.variable.name}'"

    def samples(self, xs: Array, ys: Array, seed: int, run: int) -> Array:
        """Cohesions on a lattice, (ys, xs)."""
        noise = np.random.default_rng([seed, run, *self.variable.name.encode()]).standard_normal((len(ys), len(xs)))
        return self.variable.value(factor(ys, self.scales[1]) @ noise @ factor(xs, self.scales[0]).T)


def factor(places: Array, scale: float) -> Array:
    """L of the correlation along an axis, C = L L^T."""
    return np.linalg.cholesky(np.exp(-2.0 * np.abs(places[:, None] - places[None, :]) / scale))


def read_field(table: Mapping[str, Any]) -> Field:
    """A `[[field]]` of the file: a variable of the cohesion, and `scales`."""
    words = dict(table)
    scales = words.pop("scales", None)
    name = words.get("name", "")
    if not (isinstance(scales, list) and len(scales) == 2 and all(isinstance(s, int | float) and s > 0.0 for s in scales)):
        raise Trouble(f"field '{name}': scales are two lengths, along x and along y: scales = [20, 2]")
    if "card" in words or "column" in words:
        raise Trouble(f"field '{name}': it is the cohesion of a material, which `of` names")
    return Field(read_variable({**words, "card": "MOHR COULOMB", "column": "c"}), (float(scales[0]), float(scales[1])))


def lattice(deck: Deck, field: Field) -> tuple[Array, Array]:
    """Places of the samples over the *GRID of the deck, whose cells must be fine enough to see the scatter."""
    axes, step, name = [], SPACING * min(field.scales), field.variable.name
    for axis, scale in zip("XY", field.scales, strict=True):
        rows = [row for card in deck.cards if card.keyword == "GRID" for row in card.data() if row[0].upper() == axis]
        ends = [float(word) for row in rows for word in (row[2:] if row[1].upper() == "LINES" else row[1:3])]
        if not ends:
            raise Trouble(f"field '{name}': the deck has no *GRID whose bounds say where it is")
        cells = sum(len(row) - 3 if row[1].upper() == "LINES" else int(row[3]) for row in rows)
        width = (max(ends) - min(ends)) / max(1, cells)
        if width > COARSEST * scale:
            raise Trouble(f"field '{name}': cells of the *GRID are {width:g} wide along {axis.lower()}, and a scale of {scale:g} wants {COARSEST * scale:g} "
                          "at the most: the runs would not see how it scatters")
        axes.append(np.linspace(min(ends), max(ends), max(2, math.ceil((max(ends) - min(ends)) / step) + 1)))
    if len(axes[0]) * len(axes[1]) > MOST:
        raise Trouble(f"field '{name}': a scale of {min(field.scales):g} wants {len(axes[0])} x {len(axes[1])} samples, and {MOST} are the most")
    return axes[0], axes[1]


def written(fields: Sequence[Field], deck: Deck, text: str, root: Path, seed: int, run: int, times: float = 1.0) -> str:
    """The deck with the fields of a run, whose samples are written to files; `times` as strong."""
    for field in fields:
        xs, ys = lattice(deck, field)
        values = times * field.samples(xs, ys, seed, run)
        rows = [f"{x:.9g},{y:.9g},{values[j, i]:.9g}" for j, y in enumerate(ys) for i, x in enumerate(xs)]
        content = "\n".join(["x,y,s_u", *rows]) + "\n"
        path = root.resolve() / "fields" / f"{hashlib.sha256(content.encode()).hexdigest()[:16]}.csv"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content, encoding="utf-8")
        text = text.replace(field.mark(), f'*STRENGTH PROFILE, TYPE=FIELD, INPUT="{path}"')
    return text
