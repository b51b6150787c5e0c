"""Information of a run in addition to its numbers: names of phases and materials, units, factors of safety.

Names of materials and units are from the echoed deck, phases and factors from summary.json; data that are not in
the folder are omitted.
"""

from __future__ import annotations

import json
import re
from pathlib import Path

from qsmpm_verify.trouble import Trouble


def echoed(folder: Path) -> str:
    """The echoed deck of a folder; empty without one."""
    decks = sorted(folder.glob("*.echo.inp"))
    return decks[0].read_text(encoding="utf-8") if decks else ""


def units(folder: Path) -> dict[str, str]:
    """LENGTH and FORCE of *UNITS; empty if the deck has none."""
    hit = re.search(r"^\*UNITS(.*)$", echoed(folder), re.MULTILINE | re.IGNORECASE)
    parts = (part.partition("=") for part in hit[1].split(",")) if hit else ()
    return {word.strip().upper(): value.strip() for word, _, value in parts if value.strip() not in ("", "-")}


def materials(folder: Path) -> dict[int, str]:
    """Names of the materials by their numbers, from 1."""
    cards = re.findall(r"^\*MATERIAL,(.*)$", echoed(folder), re.MULTILINE | re.IGNORECASE)
    names = (re.search(r'NAME\s*=\s*("[^"]*"|[^,]*)', card, re.IGNORECASE) for card in cards)
    return {number: hit[1].strip().strip('"') for number, hit in enumerate(names, 1) if hit}


def _phases(folder: Path) -> list[dict]:
    """The phases of summary.json; none without one."""
    try:
        return list(json.loads((folder / "summary.json").read_text(encoding="utf-8"))["phases"])
    except (OSError, ValueError, KeyError, TypeError):
        return []


def phase_name(folder: Path, number: int) -> str:
    """Text for a phase: its name in quotes, or its number if it has no name."""
    phases = _phases(folder)
    return f"'{phases[number - 1]['name']}'" if 1 <= number <= len(phases) else str(number)


def phase_number(folder: Path, phase: int | str) -> int:
    """Number of a phase given by its number, from 1, or its name."""
    if isinstance(phase, int):
        return phase
    names = [str(told["name"]) for told in _phases(folder)]
    if phase not in names:
        raise Trouble(f"{folder}: no phase '{phase}'; available are {', '.join(names) or 'no names'}")
    return names.index(phase) + 1


def factor(folder: Path, number: int) -> tuple[float, float] | None:
    """Factor of safety of a phase: last stable and first without equilibrium (0: not found); None if it has none."""
    phases = _phases(folder)
    found = phases[number - 1].get("factor") if 1 <= number <= len(phases) else None
    return (float(found[0]), float(found[1] or 0.0)) if found else None


def factor_text(folder: Path, number: int) -> str:
    """Factor of safety of a phase as text; empty if it has none."""
    found = factor(folder, number)
    if found is None:
        return ""
    stable, lost = found
    return f"factor of safety {stable:.4g} to {lost:.4g}" if lost > 0 else f"factor of safety at least {stable:.4g}"


def read_phase(word: str) -> int | str:
    """A phase as given on the command line: a number if it is one, otherwise a name."""
    return int(word) if word.isdigit() else word
