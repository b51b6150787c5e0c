"""Factors below 1: ground that is not stable in its initial geometry deforms to a stable shape, and the program finds the factor of that shape.

With twice the strength it is stable, and half of the resulting factor is that of the ground in its initial geometry (docs/methods/safety.md).
"""

from __future__ import annotations

import math
import re
from pathlib import Path

from qsmpm_verify.study.cards import items, plain

STRONGER = 2.0
"""Factor on c and tan phi."""
GAVE_WAY = "the ground failed under the loads of earlier phases and found equilibrium"
"""Message of the program when it searches the factor of ground that was not stable."""
OTHER_STRENGTHS = {
    "CAM CLAY", "HARDENING SOIL", "USER MATERIAL", "STRENGTH PROFILE", "FIELD OF VALUES", "SOFTENING", "DRUCKER PRAGER", "HOEK BROWN", "CONTACT", "NGI ADP",
    "SOFT SOIL CREEP",
}  # fmt: skip
"""Keywords of strengths that are not multiplied here."""


PUSHES = re.compile(r"^\*(PRESCRIBE|MOVE|LOAD|CONTRACTION)\b", re.MULTILINE | re.IGNORECASE)
"""Keywords that shear the soil intentionally: the factor that follows is that of the remaining strength."""


def gave_way(folder: Path, text: str) -> bool:
    """Whether the ground of a run of this deck failed under its own loads before its factor was searched."""
    log = folder / "job.log"
    return not PUSHES.search(text) and log.is_file() and GAVE_WAY in log.read_text(encoding="utf-8", errors="replace")


def stronger(text: str) -> str:
    """A deck with twice the strength; empty if it has strengths other than Mohr-Coulomb.

    Associated flow remains associated, other flow is unchanged, as in the search for a factor.
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
