"""A deck as its keyword blocks: as much of the format as is needed to change grid, method and steps, everything else unchanged.

The program itself checks the deck; this module reads what is changed and leaves the rest as it is.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from qsmpm_verify.trouble import Trouble

# The program reads files that include each other no deeper.
DEEPEST = 20


def plain(word: str) -> str:
    """A word as compared by the reader: capitals, single blanks."""
    return " ".join(word.upper().split())


def items(line: str) -> list[str]:
    """A line divided at its commas, except those in double quotes."""
    return [item.strip() for item in re.findall(r'(?:^|(?<=,))((?:[^,"]|"[^"]*"?)*)', line)]


@dataclass(frozen=True)
class Card:
    """A keyword with its parameters and the lines below it, including comments."""

    keyword: str
    parameters: tuple[tuple[str, str], ...] = ()
    lines: tuple[str, ...] = ()

    def value(self, name: str) -> str | None:
        """Value of a parameter in capitals; None if not given, empty if it has no value."""
        return next((plain(value) for key, value in self.parameters if plain(key) == name), None)

    def data(self) -> list[list[str]]:
        """Items of the data lines."""
        rows = [items(line) for line in self.lines if line.strip() and not line.lstrip().startswith("**")]
        for row in rows:
            self.refuse_names(row)
        return rows

    def refuse_names(self, row: Sequence[str]) -> None:
        """Reject data lines with parameter names: only the program knows the order of the columns."""
        if any("=" in item and not item.startswith('"') for item in row):
            raise Trouble(
                f"*{self.keyword}: '{', '.join(row)}' uses parameter names: write the numbers in the order of the columns, as in NAME.echo.inp of a run"
            )

    def with_value(self, name: str, value: str) -> Card:
        """The keyword block with a parameter set."""
        kept = tuple((key, old) for key, old in self.parameters if plain(key) != name)
        return replace(self, parameters=(*kept, (name, value)))

    def without(self, *names: str) -> Card:
        """The keyword block without some parameters."""
        return replace(self, parameters=tuple(p for p in self.parameters if plain(p[0]) not in names))

    def text(self) -> str:
        """The keyword block as lines of a deck."""
        words = ", ".join([f"*{self.keyword}", *(f"{key}={value}" if value else key for key, value in self.parameters)])
        return "\n".join([words, *self.lines])


def _head(line: str) -> Card:
    """A keyword block from its first line."""
    keyword, *words = items(line.strip()[1:])
    pairs = tuple((key.strip(), value.strip()) for key, _, value in (word.partition("=") for word in words if word))
    return Card(plain(keyword), pairs)


def _lines_of(path: Path, depth: int = 0) -> list[str]:
    """Lines of a file, joined if one ends with a comma, with those of the files it includes."""
    if depth > DEEPEST:
        raise Trouble(f"{path}: includes nested deeper than {DEEPEST}")
    try:
        raw = path.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError as error:
        raise Trouble(f"{path}: {error.strerror}") from error
    lines: list[str] = []
    held = ""
    for line in raw:
        whole, held = (held + line.strip()) if held else line, ""
        if not whole.startswith("**") and whole.rstrip().endswith(","):
            held = whole.rstrip() + " "
            continue
        lines += _included(whole, path, depth)
    return lines + ([held] if held else [])


def _included(line: str, path: Path, depth: int) -> list[str]:
    """The line itself, or those of the file it includes; such a file must be in the folder of the deck."""
    if not line.startswith("*") or line.startswith("**") or _head(line).keyword != "INCLUDE":
        return [line]
    named = next((value for key, value in _head(line).parameters if plain(key) == "INPUT"), "").strip('"')
    other = path.parent / named
    if other.parent.resolve() != path.parent.resolve():
        raise Trouble(f"{path}: *INCLUDE of '{named}': a study supports only files in the folder of the deck")
    return _lines_of(other, depth + 1)


@dataclass(frozen=True)
class Deck:
    """The keyword blocks of a deck in their order; lines before the first one are kept."""

    path: Path
    before: tuple[str, ...]
    cards: tuple[Card, ...]

    def find(self, keyword: str) -> Card | None:
        """The first block of a keyword."""
        return next((card for card in self.cards if card.keyword == keyword), None)

    def all(self, keyword: str) -> list[Card]:
        """All blocks of a keyword."""
        return [card for card in self.cards if card.keyword == keyword]

    def with_cards(self, cards: Sequence[Card]) -> Deck:
        """The same deck with other keyword blocks."""
        return replace(self, cards=tuple(cards))

    def with_card(self, card: Card) -> Deck:
        """The first block of the keyword replaced; inserted before the first phase if there is none."""
        for place, old in enumerate(self.cards):
            if old.keyword == card.keyword:
                return self.with_cards((*self.cards[:place], card, *self.cards[place + 1 :]))
        first = next((i for i, old in enumerate(self.cards) if old.keyword == "PHASE"), len(self.cards))
        return self.with_cards((*self.cards[:first], card, *self.cards[first:]))

    def text(self) -> str:
        """The text of the deck."""
        return "\n".join([*self.before, *(card.text() for card in self.cards)]) + "\n"


def read_deck(path: Path) -> Deck:
    """Read a deck with what it includes."""
    before: list[str] = []
    cards: list[Card] = []
    for line in _lines_of(path):
        if line.startswith("*") and not line.startswith("**"):
            cards.append(_head(line))
        elif cards:
            cards[-1] = replace(cards[-1], lines=(*cards[-1].lines, line))
        else:
            before.append(line)
    if not cards:
        raise Trouble(f"{path}: no keyword in it; a deck begins with one, such as *HEADING")
    return Deck(path, tuple(before), tuple(cards))
