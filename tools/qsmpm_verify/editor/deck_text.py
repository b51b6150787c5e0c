"""Context of the cursor in a deck, and the completions that are valid there."""

from __future__ import annotations

import re
from dataclasses import dataclass

from qsmpm_verify.editor.table import Entry, Table
from qsmpm_verify.study.cards import items, plain

NAMED_BY = {"NSET": "NSET", "ELSET": "ELSET", "PARENT": "PHASE", "REGION": "ELSET"}
"""Parameters whose values are the names of entities defined by other keywords."""


@dataclass(frozen=True)
class Place:
    """The keyword block at the cursor, and the text before the cursor on its line."""

    keyword: str
    parameter: str
    on_card: bool
    typed: str


def place_at(lines: list[str], line: int, column: int) -> Place:
    """The context of the cursor; a keyword line continues where a line ends with a comma."""
    first = line
    while first > 0 and not lines[first].lstrip().startswith("*"):
        first -= 1
    head = lines[first] if lines else ""
    if not head.lstrip().startswith("*") or head.lstrip().startswith("**"):
        return Place("", "", False, "")
    on_card = all(lines[k].rstrip().endswith(",") for k in range(first, line))
    before = " ".join([*lines[first:line], lines[line][:column]]) if on_card else lines[line][:column]
    words = items(before.strip()[1:] if on_card else before)
    keyword = plain(items(head.strip()[1:])[0])
    last = words[-1] if len(words) > 1 or not on_card else ""
    name, equals, typed = last.partition("=")
    return Place(keyword if len(words) > 1 or not on_card else "", plain(name) if equals else "", on_card, typed.strip() if equals else name.strip())


def names_in(lines: list[str], parameter: str) -> list[str]:
    """Names that keywords of the deck define, as values of a parameter."""
    card = NAMED_BY.get(parameter, parameter)
    found = []
    for line in lines:
        if line.lstrip().startswith("**") or not line.lstrip().startswith("*"):
            continue
        words = items(line.strip()[1:])
        pairs = {plain(key): value.strip().strip('"') for key, _, value in (word.partition("=") for word in words[1:])}
        kind = plain(words[0])
        if kind == card or kind.endswith(f" {card}"):
            found += [pairs[key] for key in ("NAME", card) if key in pairs][:1]
    return sorted(set(found))


def offers(table: Table, lines: list[str], line: int, column: int) -> list[tuple[str, Entry | None]]:
    """Completions at the cursor: keywords, parameters not yet given, choices and names."""
    text = lines[line][:column] if line < len(lines) else ""
    if re.fullmatch(r"\s*\*?[^,*]*", text) and text.lstrip().startswith("*"):
        return list(table.keywords.items())
    place = place_at(lines, line, column)
    entry = table.keywords.get(place.keyword)
    if entry is None or not place.on_card:
        return []
    if place.parameter:
        item = table.parameter(place.keyword, place.parameter)
        if item is None:
            return []
        names = names_in(lines, place.parameter) if item["kind"] == "name" and place.parameter != "NAME" else []
        return [(word, None) for word in [*item.get("words", []), *names]]
    given = {plain(word.partition("=")[0]) for word in items(text)}
    return [(item["name"], item) for item in entry["parameters"] if item["name"] not in given]
