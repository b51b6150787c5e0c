"""Units of columns: meaning of `kN/m2` in a header, and whether two units can be compared.

A unit is a factor and powers of force, length and time. Angles, percentages and plain numbers have no powers.
Formulas state the kind of their value at the end of the first line of their docstring, such as `[stress]`.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from dataclasses import dataclass

Powers = tuple[int, ...]
"""Powers of force, length and time."""

_FORCE, _LENGTH, _TIME, _STRESS = (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, -2, 0)

ATOMS: dict[str, tuple[float, Powers]] = {
    "-": (1.0, (0, 0, 0)), "1": (1.0, (0, 0, 0)), "%": (1e-2, (0, 0, 0)), "rad": (1.0, (0, 0, 0)),
    "N": (1.0, _FORCE), "kN": (1e3, _FORCE), "MN": (1e6, _FORCE), "GN": (1e9, _FORCE),
    "m": (1.0, _LENGTH), "mm": (1e-3, _LENGTH), "cm": (1e-2, _LENGTH), "km": (1e3, _LENGTH),
    "Pa": (1.0, _STRESS), "kPa": (1e3, _STRESS), "MPa": (1e6, _STRESS), "GPa": (1e9, _STRESS),
    "J": (1.0, (1, 1, 0)), "kJ": (1e3, (1, 1, 0)), "kg": (1.0, (1, -1, 2)), "t": (1e3, (1, -1, 2)),
    "s": (1.0, _TIME), "min": (60.0, _TIME), "h": (3600.0, _TIME), "d": (86400.0, _TIME),
}  # fmt: skip

KINDS: dict[str, Powers] = {
    "-": (0, 0, 0), "force": _FORCE, "length": _LENGTH, "area": (0, 2, 0), "volume": (0, 3, 0),
    "stress": _STRESS, "time": _TIME,
}  # fmt: skip


@dataclass(frozen=True)
class Unit:
    """A factor to N, m and s, and powers of force, length and time."""

    factor: float
    powers: Powers


def _product(text: str, atoms: dict[str, tuple[float, Powers]]) -> Unit | None:
    """The unit of `kN m/s2`; None if it contains an unknown word."""
    factor = 1.0
    powers: Powers = (0, 0, 0)
    for place, part in enumerate(text.replace("^", "").split("/")):
        sign = 1 if place == 0 else -1
        for word in re.split(r"[\s*.]+", part.strip()):
            hit = re.fullmatch(r"(.*?)(-?\d?)", word)
            name, power = (word, 1) if word in atoms else (hit[1], int(hit[2] or 1)) if hit else (word, 1)
            if name not in atoms:
                return None
            factor *= atoms[name][0] ** (sign * power)
            powers = tuple(p + sign * power * own for p, own in zip(powers, atoms[name][1]))
    return Unit(factor, powers)


def read_unit(text: str) -> Unit | None:
    """The unit of a header; None if it is empty or unknown."""
    return _product(text.strip(), ATOMS) if text.strip() else None


def mismatch(own: str, other: str) -> str:
    """Reason why values in two units cannot be compared directly; empty if they can or if one is unknown."""
    if not own or not other or own == other:
        return ""
    first, second = read_unit(own), read_unit(other)
    if first is None or second is None:
        return f"[{own}] against [{other}]"
    if first.powers != second.powers:
        return f"[{own}] against [{other}] are units of different kinds"
    ratio = first.factor / second.factor
    if abs(ratio - 1) > 1e-12:
        return f"[{own}] against [{other}] differ by a factor of {ratio:g}"
    return ""


def kind_of(function: Callable[..., object]) -> str:
    """Kind or unit of a formula's value, `stress` or `kN/m3`; empty if its docstring does not state it.

    The docstring states it in its entry `Units: ...; result [stress]`, or at the end of its first paragraph.
    """
    text = inspect.getdoc(function) or ""
    entry = re.search(r"^Units:(.*(?:\n[ \t]+.*)*)", text, re.MULTILINE)
    sentence = entry[1].rpartition("result")[2] if entry else text.split("\n\n")[0].replace("\n", " ")
    found = re.findall(r"\[([^\[\]]+)\]", sentence)
    return found[0 if entry else -1] if found else ""


def wrong_kind(unit: str, kind: str) -> str:
    """Reason why a column in this unit is not a value of a formula of this kind; empty if it is, or if either is unknown."""
    own = read_unit(unit)
    wanted = _product(kind, {**ATOMS, **{k: (1.0, p) for k, p in KINDS.items()}}) if kind else None
    if own is None or wanted is None or own.powers == wanted.powers:
        return ""
    return f"[{unit}] is not a unit of [{kind}]"
