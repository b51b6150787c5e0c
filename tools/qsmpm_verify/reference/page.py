"""docs/references.md from the docstrings: name, formula, range, source and check of every reference."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable

from qsmpm_verify.reference import FAMILIES, functions

ENTRIES = ("Formula", "Units", "Range", "Assumes", "Source", "Check")
"""Entries of a docstring, in their order."""
HEAD = """# References: exact and independent solutions

Written by `qsmpm-verify references --markdown` from `tools/qsmpm_verify/reference/`; do not edit. Each function can be
named in a case file, `reference = {function = "van_langen", strain = 0.5}`. It rejects arguments outside its range
and is verified by an independent method in `tools/qsmpm_verify/tests/test_reference_*.py`, which the column *check* states.
Any consistent set of units can be used; sign conventions are given for each family.
"""


def entries(function: Callable[..., object]) -> dict[str, str]:
    """First sentence (key `What`) and the entries of a function's docstring; ValueError if one is missing."""
    text = inspect.getdoc(function) or ""
    pattern = "|".join(ENTRIES)
    parts = re.split(rf"^({pattern}): ", text, flags=re.M)
    found = {"What": " ".join(parts[0].split())}
    for name, value in zip(parts[1::2], parts[2::2]):
        found[name] = " ".join(value.split())
    missing = [name for name in ("What", *ENTRIES) if not found.get(name)]
    if missing:
        raise ValueError(f"the docstring of {function.__name__} has no {', '.join(missing)}")
    return found


def _cell(text: str) -> str:
    """Text with the special characters of a Markdown table escaped."""
    return text.replace("|", "\\|").replace("*", "\\*")


def _row(name: str, function: Callable[..., object]) -> str:
    """One row of the table."""
    said = entries(function)
    arguments = ", ".join(inspect.signature(function).parameters)
    limits = f"{said['Range']}. {said['Assumes']}"
    cells = (said["What"], said["Formula"], said["Units"], limits, said["Source"], said["Check"])
    return " | ".join((f"| `{name}({arguments})`", *map(_cell, cells))) + " |"


def markdown() -> str:
    """The page."""
    lines = [HEAD.rstrip()]
    for family in FAMILIES:
        said = inspect.getdoc(family) or ""
        title = family.__name__.rsplit(".", 1)[-1].replace("_", " ").capitalize()
        lines += ["", f"## {title}", "", said, ""]
        lines += ["| name | what | formula | units | range and assumptions | source | check |", "|---" * 7 + "|"]
        lines += [_row(name, function) for name, function in functions(family).items()]
    return "\n".join(lines) + "\n"
