"""Runs of a deck with modified parameters: writing the deck, reading the result."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from qsmpm_verify.cases import Case
from qsmpm_verify.editor.table import Table
from qsmpm_verify.reliability.fields import LEAST, Field, lattice, written
from qsmpm_verify.reliability.variables import Space, Variable
from qsmpm_verify.results import Array, ResultError, read_curves
from qsmpm_verify.runner import run_case
from qsmpm_verify.study.cards import Card, Deck, items, plain
from qsmpm_verify.study.strength import STRONGER, gave_way, stronger
from qsmpm_verify.trouble import Trouble

NAMING = ("NAME", "BODY", "MATERIAL", "SURFACE", "NSET")
"""Parameters that identify a keyword among several of the same name."""


@dataclass(frozen=True)
class Response:
    """Requested result of a run: a factor of safety or a history, its limit and the side that fails."""

    quantity: str
    at: str
    limit: float
    fails_below: bool

    def margin(self, value: float) -> float:
        """Positive if safe."""
        return value - self.limit if self.fails_below else self.limit - value


def read_response(table: Mapping[str, object]) -> Response:
    """`[response]` of the file."""
    words = dict(table)
    quantity, at = str(words.pop("quantity", "factor")), str(words.pop("at", "last"))
    fails, limit = str(words.pop("fails", "below")), words.pop("limit", 1.0 if quantity == "factor" else None)
    if words:
        raise Trouble(f"response: unknown word '{next(iter(words))}'")
    if at not in ("last", "max", "min") or fails not in ("below", "above"):
        raise Trouble("response: at must be last, max or min; fails must be below or above")
    if not isinstance(limit, int | float):
        raise Trouble("response: the limit of a history is missing")
    return Response(quantity, at, float(limit), fails == "below")


def place_of(deck: Deck, variable: Variable, table: Table) -> tuple[int, int, int]:
    """Keyword block, its line and the item of that line that contain a variable."""
    keyword, material = plain(variable.card), ""
    entry = table.keywords.get(keyword)
    if entry is None:
        raise Trouble(f"variable '{variable.name}': there is no keyword *{keyword}")
    names = [column["name"] for data in entry["data"] for column in data["columns"]]
    columns = {plain(name): i for i, name in reversed(list(enumerate(names)))}
    if plain(variable.column) not in columns:
        raise Trouble(f"variable '{variable.name}': *{keyword} has no column '{variable.column}'; known are {', '.join(names)}")
    found = []
    for number, card in enumerate(deck.cards):
        if card.keyword == "MATERIAL":
            material = card.value("NAME") or ""
        own = material if entry["section"] == "material" else next((card.value(key) for key in NAMING if card.value(key)), "") or ""
        if card.keyword == keyword and variable.of.upper() in ("", own):
            found.append(number)
    if len(found) != 1:
        raise Trouble(f"variable '{variable.name}': {len(found) or 'no'} keywords *{keyword}{' of ' + variable.of if variable.of else ''} in {deck.path}; "
                      "`of` names the material, body or surface")
    lines = [i for i, line in enumerate(deck.cards[found[0]].lines) if line.strip() and not line.lstrip().startswith("**")]
    if not 1 <= variable.line <= len(lines):
        raise Trouble(f"variable '{variable.name}': *{keyword} has {len(lines)} data lines")
    line = lines[variable.line - 1]
    deck.cards[found[0]].refuse_names(items(deck.cards[found[0]].lines[line]))
    if columns[plain(variable.column)] >= len(items(deck.cards[found[0]].lines[line])):
        raise Trouble(f"variable '{variable.name}': the deck does not give '{variable.column}' of *{keyword}")
    return found[0], line, columns[plain(variable.column)]


def with_number(card: Card, line: int, item: int, value: float) -> Card:
    """A keyword block with another number."""
    words = items(card.lines[line])
    words[item] = f"{value:.12g}"
    lines = (*card.lines[:line], ", ".join(words), *card.lines[line + 1 :])
    return replace(card, lines=lines)


class Runs:
    """The results of a deck for values of its variables; a run that is available is not repeated."""

    def __init__(
        self, deck: Deck, space: Space, response: Response, table: Table, program: Path, root: Path, jobs: int, fields: Sequence[Field] = (), seed: int = 1
    ) -> None:
        self.deck, self.space, self.response = deck, space, response
        self.program, self.root, self.jobs = program, root, jobs
        self.fields, self.seed = fields, seed
        self.places = [place_of(deck, variable, table) for variable in space.variables]
        self.field_places = [place_of(deck, field.variable, table) for field in fields]
        for field, place in zip(fields, self.field_places, strict=True):
            lattice(deck, field)
            if (self.places + self.field_places).count(place) > 1:
                raise Trouble(f"field '{field.variable.name}': {field.variable.column} of '{field.variable.of}' is also a variable or another field")
        self.made = self.failed = 0
        self.reasons: list[str] = []

    def text_of(self, values: Sequence[float]) -> str:
        """The deck with these values."""
        cards = list(self.deck.cards)
        for (card, line, item), value in zip(self.places, values, strict=True):
            cards[card] = with_number(cards[card], line, item, value)
        marked: set[str] = set()
        for field, (card, line, item) in zip(self.fields, self.field_places, strict=True):
            if field.variable.column == "c":
                cards[card] = with_number(cards[card], line, item, LEAST * float(field.variable.law.mean()))
            if field.mark() not in marked:
                cards[card] = replace(cards[card], lines=(*cards[card].lines, field.mark()))
                marked.add(field.mark())
        return self.deck.with_cards(cards).text()

    def answer(self, values: Sequence[float], number: int = 0) -> float:
        """The result for these values, with the fields of the run of this number; NaN if there is none."""
        text = self.text_of(values)
        value, stands = self.run(self.with_fields(text, number))
        if self.response.quantity == "factor" and not stands and (strong := stronger(text)):
            # Below 1 the ground does not carry its loads as drawn: with more strength it does, and the factor is as much larger.
            value = self.run(self.with_fields(strong, number, STRONGER))[0] / STRONGER
        if math.isnan(value):
            self.failed += 1
        return value

    def with_fields(self, text: str, number: int, times: float = 1.0) -> str:
        """A deck with the samples of its fields."""
        return written(self.fields, self.deck, text, self.root, self.seed, number, times)

    def run(self, text: str) -> tuple[float, bool]:
        """The result of a deck, and whether its initial state is in equilibrium."""
        name = hashlib.sha256(text.encode()).hexdigest()[:16]
        original = self.deck.path.read_text(encoding="utf-8")
        case = Case(name, self.deck.path.name, self.deck.path, (), replace=((original, text),))
        run = run_case(case, self.program, self.root)
        self.made += 1
        try:
            if run.exit_code == 0:
                return answer_in(run.directory, self.response), not gave_way(run.directory, text)
            self.reasons.append(run.message)
        except ResultError as trouble:
            if "no column" in str(trouble):
                raise
            self.reasons.append(str(trouble))
        return math.nan, False

    def margins(self, u: Array) -> Array:
        """Margins for rows of standard normal numbers, run in parallel."""
        rows = self.space.values(np.atleast_2d(u))
        with ThreadPoolExecutor(self.jobs) as pool:
            return np.array([self.response.margin(value) for value in pool.map(self.answer, rows.tolist(), range(len(rows)))])


def answer_in(folder: Path, response: Response) -> float:
    """The midpoint of the bracket of the factor, or a history."""
    if response.quantity == "factor":
        phases = json.loads((folder / "safety.json").read_text(encoding="utf-8"))["phases"]
        stable, lost = phases[-1]["stable"], phases[-1]["lost"]
        if lost is None:
            raise ResultError(f"no factor was found: it is at least {stable}")
        return 0.5 * (float(stable) + float(lost))
    values = read_curves(folder).column(response.quantity)
    return float({"last": values[-1], "max": values.max(), "min": values.min()}[response.at])
