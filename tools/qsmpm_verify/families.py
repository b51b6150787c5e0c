"""Families of cases: one [[case]] with `each` defines one case for each entry.

    each = [{n = 16, h = 3.125}, {n = 64, h = 0.78125}]
    name = "cells_{n}"
    replace = [["Y, 0, 50, 16", "Y, 0, 50, {n}"]]

A word in braces is replaced in every text of the case, including its quantities. A text that consists
of one word in braces becomes the value itself, so that numbers of the case may differ too:
`tolerance = "{t}"`.
"""

from __future__ import annotations

import re
from typing import Any

Table = dict[str, Any]

WORD = re.compile(r"\{(\w+)\}")


class FamilyError(Exception):
    """Error in a family of cases."""


def _members(each: Any) -> list[Table]:
    """The entries of `each`, checked: tables of texts and numbers with the same words."""
    if not isinstance(each, list) or not each or not all(isinstance(e, dict) and e for e in each):
        raise FamilyError("each must be a list of at least one table, {WORD = VALUE, ...}")
    for entry in each:
        if set(entry) != set(each[0]):
            raise FamilyError(f"every entry of each must have the same words; {', '.join(each[0])} against {', '.join(entry)}")
        for word, value in entry.items():
            if not re.fullmatch(r"\w+", word):
                raise FamilyError(f"'{word}' of each must be one word of letters, digits and _")
            if isinstance(value, bool) or not isinstance(value, (int, float, str)):
                raise FamilyError(f"'{word}' of each must be a number or a text")
    return each


def fill(value: Any, member: Table, used: set[str]) -> Any:
    """A value with the words of a member inserted; `used` collects them."""
    if isinstance(value, dict):
        return {key: fill(inner, member, used) for key, inner in value.items()}
    if isinstance(value, list):
        return [fill(inner, member, used) for inner in value]
    if not isinstance(value, str):
        return value
    for word in WORD.findall(value):
        if word not in member:
            raise FamilyError(f"{{{word}}} is not in each; it has {', '.join(member)}")
        used.add(word)
    whole = WORD.fullmatch(value)
    if whole:
        return member[whole[1]]
    return WORD.sub(lambda hit: str(member[hit[1]]), value)


def expand(case: Table) -> list[Table]:
    """The cases that a [[case]] defines: itself, or one for each entry of `each`."""
    if "each" not in case:
        return [case]
    members = _members(case["each"])
    rest = {key: value for key, value in case.items() if key != "each"}
    used: set[str] = set()
    cases = [fill(rest, member, used) for member in members]
    for word in members[0]:
        if word not in used:
            raise FamilyError(f"'{word}' of each is not used: no {{{word}}} in the case")
    names = [one.get("name") for one in cases]
    if len(set(names)) != len(names):
        raise FamilyError("the name does not distinguish the entries of each")
    for one in cases:
        if "name" in one:
            one["name"] = str(one["name"])
    return cases
