"""`partial`: convert a deck with characteristic values into one with design values, by a table of partial factors (Eurocode 7 by default)."""

from __future__ import annotations

import argparse
import math
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from qsmpm_verify.study.cards import Card, Deck, items, read_deck
from qsmpm_verify.study.strength import OTHER_STRENGTHS
from qsmpm_verify.trouble import Trouble

TABLE = """# EN 1997-1:2004, annex A, tables A.3, A.4 and A.14 (recommended values; a national annex may differ: --table FILE).
[DA1-1]
permanent = 1.35
variable = 1.5
[DA1-2]
variable = 1.3
friction = 1.25
cohesion = 1.25
undrained = 1.4
[DA2]
permanent = 1.35
variable = 1.5
resistance = 1.1
[DA3]
variable = 1.3
friction = 1.25
cohesion = 1.25
undrained = 1.4
"""
KINDS = ("permanent", "variable", "friction", "cohesion", "undrained", "weight", "resistance")
LOADS = {"PRESSURE": "SURFACE", "TRACTION": "SURFACE", "LOAD": "BODY"}
"""Keywords of loads, and the parameter that names the loaded object."""


def add_words(verbs: argparse._SubParsersAction) -> None:
    """Arguments of the subcommand."""
    verb = verbs.add_parser("partial", help="apply partial factors (Eurocode 7) to a deck of characteristic values and report the changes")
    verb.add_argument("deck", type=Path, help="deck of characteristic values")
    verb.add_argument("approach", help="DA1-1, DA1-2, DA2 or DA3, or a set of --table")
    verb.add_argument("--variable", action="append", default=[], metavar="NAME", help="surface or body whose loads are variable; may be repeated")
    verb.add_argument("--table", type=Path, help="factors of another code or national annex (TOML)")
    verb.add_argument("--to", type=Path, metavar="DECK", help="deck to write (default DECK with the set appended to its name)")
    verb.set_defaults(act=act)


def read_factors(approach: str, path: Path | None) -> dict[str, float]:
    """The factors of a set; the default of each is 1."""
    try:
        table: Mapping[str, Any] = tomllib.loads(path.read_text(encoding="utf-8") if path else TABLE)
    except (OSError, tomllib.TOMLDecodeError) as error:
        raise Trouble(f"{path}: {error}") from error
    if approach not in table:
        raise Trouble(f"unknown set '{approach}' of partial factors; known are {', '.join(table)}")
    for key, value in table[approach].items():
        if key not in KINDS or not isinstance(value, int | float) or not 0.0 < value < 10.0:
            raise Trouble(f"set '{approach}': {key} = {value} must be one of {', '.join(KINDS)} with a value in (0, 10)")
    return dict.fromkeys(KINDS, 1.0) | {key: float(value) for key, value in table[approach].items()}


def changed(card: Card, change: Callable[[list[float]], list[float]]) -> Card:
    """A keyword block with other numbers in its first data line; words are kept."""
    for place, line in enumerate(card.lines):
        if not line.strip() or line.lstrip().startswith("**"):
            continue
        words = items(line)
        card.refuse_names(words)
        numbers = [i for i, word in enumerate(words) if is_number(word)]
        for i, value in zip(numbers, change([float(words[i]) for i in numbers]), strict=True):
            words[i] = f"{value:.10g}"
        return replace(card, lines=(*card.lines[:place], ", ".join(words), *card.lines[place + 1 :]))
    return card


def is_number(word: str) -> bool:
    """Whether an item of a data line is a number."""
    try:
        return math.isfinite(float(word))
    except ValueError:
        return False


def design_strength(numbers: Sequence[float], factors: Mapping[str, float]) -> list[float]:
    """c and tan phi divided by their factors, phi = 0: c is an undrained strength; dilatancy at most the friction."""
    cohesion, friction, flow, *rest = numbers
    if friction == 0.0:
        return [cohesion / factors["undrained"], friction, flow, *rest]
    angle = math.degrees(math.atan(math.tan(math.radians(friction)) / factors["friction"]))
    return [cohesion / factors["cohesion"], angle, min(flow, angle), *(value / factors["cohesion"] for value in rest)]


def times(factor: float, count: int) -> Callable[[list[float]], list[float]]:
    """Factors on the first numbers of a line: on forces and pressures, not on coordinates."""
    return lambda numbers: [value * factor if i < count else value for i, value in enumerate(numbers)]


def factored(deck: Deck, factors: Mapping[str, float], variable: Sequence[str]) -> tuple[Deck, list[str]]:
    """The deck of design values, and a line for each keyword that is changed or possibly should be."""
    told: list[str] = []
    cards: list[Card] = []
    material, left = "", [name.upper() for name in variable]
    for card in deck.cards:
        material = card.value("NAME") or "" if card.keyword == "MATERIAL" else material
        new = card
        if card.keyword == "MOHR COULOMB":
            new = changed(card, lambda numbers: design_strength(numbers, factors))
        elif card.keyword == "UNIT WEIGHT":
            new = changed(card, lambda numbers: [value * factors["weight"] for value in numbers])
        elif card.keyword in LOADS and card.value("LEVEL") is None:
            name = card.value(LOADS[card.keyword]) or ""
            kind = "variable" if name in [word.upper() for word in variable] else "permanent"
            left = [word for word in left if word != name]
            count = 1 if card.keyword == "LOAD" else 2 if card.keyword == "PRESSURE" else 3
            new = changed(card, times(factors[kind], count))
        elif card.keyword in OTHER_STRENGTHS - {"CONTACT"}:
            told.append(f"unchanged: *{card.keyword} of '{material}': its strength is still characteristic")
        elif card.keyword == "CONTACT":
            told.append("unchanged: *CONTACT: its friction and adhesion are still characteristic")
        if new != card:
            what = f"of '{material}'" if card.keyword in ("MOHR COULOMB", "UNIT WEIGHT") else f"on '{card.value(LOADS[card.keyword])}'"
            told.append(f"*{card.keyword} {what}: {first_line(card)} becomes {first_line(new)}")
        cards.append(new)
    if left:
        raise Trouble(f"--variable {left[0]}: no load of the deck acts on it")
    return deck.with_cards(cards), told


def first_line(card: Card) -> str:
    """The first data line of a keyword."""
    return next((line.strip() for line in card.lines if line.strip() and not line.lstrip().startswith("**")), "")


def act(words: argparse.Namespace) -> int:
    """Write the deck, report the changes and the value with which the result is to be compared."""
    factors = read_factors(words.approach, words.table)
    deck, told = factored(read_deck(words.deck), factors, words.variable)
    out = words.to or words.deck.with_name(f"{words.deck.stem}_{words.approach.lower().replace('-', '_')}.inp")
    out.write_text(deck.text(), encoding="utf-8")
    for line in told:
        print(line)
    if factors["permanent"] != 1.0:
        print("unchanged: the weight of the ground: it acts on both sides of a slide and is not factored; the factor of safety of such ground is to be compared with "
              f"{factors['permanent'] * factors['resistance']:.4g}")
    elif factors["resistance"] != 1.0:
        print(f"the factor of safety is to be compared with {factors['resistance']:.4g}")
    else:
        print("the factor of safety is to be compared with 1")
    print(f"deck {out}")
    return 0
