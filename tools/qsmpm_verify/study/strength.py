"""Factors below 1: ground that does not stand as drawn slides to a shape that does, and the program finds the factor of that shape.

With twice the strength it stands, and half of the factor that is then found is that of the ground as it was drawn (docs/methods/safety.md).
"""

from __future__ import annotations

import math
import re
from pathlib import Path

from qsmpm_verify.study.cards import items, plain

STRONGER = 2.0
"""What c and tan phi are multiplied by."""
GAVE_WAY = "the ground gave way, and came to rest in another shape"
"""What the program says where it looks for the factor of ground that did not stand."""
OTHER_STRENGTHS = {
    "CAM CLAY", "HARDENING SOIL", "USER MATERIAL", "STRENGTH PROFILE", "SOFTENING", "DRUCKER PRAGER", "HOEK BROWN", "CONTACT", "NGI ADP",
    "SOFT SOIL CREEP",
}  # fmt: skip
"""Cards that hold a strength which is not multiplied here."""


PUSHES = re.compile(r"^\*(PRESCRIBE|MOVE|LOAD|CONTRACTION)\b", re.MULTILINE | re.IGNORECASE)
"""Cards by which soil is sheared on purpose: the factor that follows is of what the push has left."""


def gave_way(folder: Path, text: str) -> bool:
    """Whether the ground of a run of this deck gave way under its own loads before its factor was looked for."""
    log = folder / "job.log"
    return not PUSHES.search(text) and log.is_file() and GAVE_WAY in log.read_text(encoding="utf-8", errors="replace")


def stronger(text: str) -> str:
    """A deck of twice the strength; empty where it has strengths that are none of Mohr and Coulomb.

    Flow that goes with the friction does so still, other flow stays, as in the search for a factor.
    """
    lines, keyword = [], ""
    for line in text.split("\n"):
        if line.startswith("*") and not line.startswith("**"):
            keyword = plain(items(line[1:])[0])
            if keyword in OTHER_STRENGTHS:
                return ""
        elif keyword == "MOHR COULOMB" and line.strip() and not line.startswith("**"):
            words = items(line)
            if "=" in line:
                return ""
            phi, psi = float(words[1]), float(words[2])
            words[0] = f"{STRONGER * float(words[0]):.12g}"
            words[1] = f"{math.degrees(math.atan(STRONGER * math.tan(math.radians(phi)))):.12g}"
            words[2] = words[1] if psi == phi else words[2]
            # A cut-off in tension is a strength, too.
            words[3:] = [word if plain(word) == "NONE" else f"{STRONGER * float(word):.12g}" for word in words[3:]]
            line = ", ".join(words)
        lines.append(line)
    return "\n".join(lines)
