"""Names, numbers and boxes of keywords; what limit analysis does not support is an error that names the keyword."""

from __future__ import annotations

import numpy as np

from qsmpm_verify.results import Array
from qsmpm_verify.study.cards import Card, plain
from qsmpm_verify.trouble import Trouble

# No limit load depends on them.
PASSED = {
    "HEADING", "UNITS", "METHOD", "SOLVER", "MOVING MESH", "POINTS", "HISTORY", "FIELD", "RESTART", "CONTROLS", "ELASTIC", "K0",
    "VOLUMETRIC LOCKING", "RESET DISPLACEMENTS", "CONSTANT LOAD TEST", "ELSET", "STOP", "END PHASE",
}  # fmt: skip
OTHER_LAWS = {
    "SOFTENING", "CAM CLAY", "HARDENING SOIL", "DRUCKER PRAGER", "HOEK BROWN", "NGI ADP", "SOFT SOIL CREEP", "USER MATERIAL", "USER STATE",
    "STRENGTH CONSTANTS",
}  # fmt: skip


def refuse(card: Card, why: str) -> Trouble:
    """An error that names a keyword."""
    return Trouble(f"*{card.keyword}: {why}")


def numbers(card: Card, row: list[str], least: int, most: int | None = None) -> list[float]:
    """Numbers of a data line."""
    words = [word for word in row if word != ""]
    try:
        found = [float(word.lower().replace("d", "e")) for word in words]
    except ValueError as error:
        raise refuse(card, f"'{', '.join(row)}' are not numbers") from error
    if len(found) < least or (most is not None and len(found) > most):
        raise refuse(card, f"'{', '.join(row)}' is not a line of {least} numbers")
    return found


def name_of(card: Card, parameter: str) -> str:
    """A name as it is written in the deck."""
    found = next((value.strip('"') for key, value in card.parameters if plain(key) == parameter), "")
    if not found:
        raise refuse(card, f"no {parameter}")
    return found


def only(card: Card, **allowed: tuple[str, ...]) -> None:
    """Reject a value of a choice that limit analysis does not support."""
    for key, words in allowed.items():
        name = key.replace("_", " ")
        value = card.value(name)
        if value is not None and value not in words:
            raise refuse(card, f"{name}={value}: bounds support {' or '.join(words)}")


def box_of(card: Card, row: list[str]) -> tuple[Array, Array]:
    """Lower and upper corner."""
    x = numbers(card, row, 4, 4)
    return np.array([x[0], x[2]]), np.array([x[1], x[3]])


def rectangle(low: Array, high: Array) -> Array:
    """Corners of a box, counter-clockwise."""
    return np.array([low, (high[0], low[1]), high, (low[0], high[1])], dtype=float)


def grid_lines(card: Card) -> tuple[Array, Array]:
    """Grid lines along x and y."""
    found: dict[str, list[float]] = {"X": [], "Y": []}
    for row in card.data():
        axis = plain(row[0])
        if axis not in found:
            raise refuse(card, f"axis {axis}: bounds support plane strain only")
        if plain(row[1]) == "LINES":
            new = numbers(card, row[2:], 1)
        else:
            values = numbers(card, row[1:], 2, 4)
            first, last, count, ratio = values if len(values) == 4 else (found[axis][-1:] + values if len(values) == 2 else values) + [1.0]
            widths = ratio ** (np.arange(count) / max(count - 1.0, 1.0))
            new = list(first + (last - first) * np.append(0.0, np.cumsum(widths) / widths.sum()))
        found[axis] += [v for v in new if not found[axis] or v > found[axis][-1]]
    return np.array(found["X"]), np.array(found["Y"])
