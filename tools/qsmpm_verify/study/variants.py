"""The same scene on a finer or coarser grid, with another method, or with more steps.

A grid of level k has 2**k times as many cells along every axis as that of the deck, with the same grading; an axis of one
cell (the width of a column, the thickness of a slice) keeps its single cell. Levels decrease as long as every number of
cells can be halved and every line with a node set remains a grid line.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from qsmpm_verify.study.cards import Card, Deck, items
from qsmpm_verify.trouble import Trouble

# Two cells across the whole are no grid any more.
FEWEST_CELLS = 2
DEEPEST_LEVEL = -3
FINEST_LEVEL = 4


@dataclass(frozen=True)
class Method:
    """A method by its keywords; that of the deck has none."""

    label: str
    words: tuple[tuple[str, str], ...] = ()
    element: str = ""


OWN = Method("as in the deck")
PLANE_METHODS = (
    Method("SPLINE2G CELL", (("BASIS", "SPLINE2G"), ("INTEGRATION", "CELL")), "QUAD4"),
    Method("SPLINE2 CELL", (("BASIS", "SPLINE2"), ("INTEGRATION", "CELL")), "QUAD4"),
    Method("GIMP", (("BASIS", "GIMP"), ("INTEGRATION", "POINTS")), "QUAD4"),
    Method("TRI6 CELL", (("BASIS", "STANDARD"), ("INTEGRATION", "CELL")), "TRI6"),
)
SPACE_METHODS = (
    Method("SPLINE2G CELL", (("BASIS", "SPLINE2G"), ("INTEGRATION", "CELL")), "HEX8"),
    Method("GIMP", (("BASIS", "GIMP"), ("INTEGRATION", "POINTS")), "HEX8"),
    Method("HEX20 CELL", (("BASIS", "STANDARD"), ("INTEGRATION", "CELL")), "HEX20"),
)
MOVING_METHODS = (
    Method("SPLINE2, points", (("BASIS", "SPLINE2"), ("INTEGRATION", "POINTS"), ("FACTOR", "5E-4")), "QUAD4"),
    Method("GIMP, points", (("BASIS", "GIMP"), ("INTEGRATION", "POINTS"), ("FACTOR", "5E-4")), "QUAD4"),
)
PLANE_ELEMENTS = ("TRI3", "TRI6", "QUAD4", "QUAD8", "QUAD9")
METHOD_WORDS = ("BASIS", "INTEGRATION", "STABILISATION", "FACTOR")


def methods_of(deck: Deck) -> list[Method]:
    """The method of the deck and useful alternatives; a deck with a mesh file or elements allows no other."""
    grid, own = deck.find("GRID"), deck.find("METHOD")
    if grid is None:
        return [OWN]
    plane = is_plane(deck, grid)
    others: tuple[Method, ...] = PLANE_METHODS if plane else SPACE_METHODS
    if deck.find("MOVING MESH"):
        others = MOVING_METHODS if plane else ()
    return [OWN, *(m for m in others if not same_method(m, grid, own))]


def is_plane(deck: Deck, grid: Card) -> bool:
    """Whether the cells of a grid are plane, with or without an element name."""
    element = grid.value("ELEMENT")
    return element in PLANE_ELEMENTS or (element is None and len(axis_lines(deck, "Z")) == 0)


def same_method(method: Method, grid: Card, own: Card | None) -> bool:
    """Whether the deck uses this method already; a deck without a basis has the recommended one, the first of each list."""
    if grid.value("ELEMENT") != method.element:
        return False
    if own is None or own.value("BASIS") in (None, "AUTO"):
        return method in (PLANE_METHODS[0], SPACE_METHODS[0], MOVING_METHODS[0])
    return all(own.value(key) == value for key, value in method.words)


def with_method(deck: Deck, method: Method) -> Deck:
    """The deck with another method and the points it requires; the kinematics are unchanged."""
    grid = deck.find("GRID")
    if not method.words or grid is None:
        return deck
    card = (deck.find("METHOD") or Card("METHOD")).without(*METHOD_WORDS)
    for key, value in method.words:
        card = card.with_value(key, value)
    if grid.value("ELEMENT") != method.element:
        grid = grid.with_value("ELEMENT", method.element)
        if method.element in ("QUAD4", "HEX8", "HEX20"):
            grid = grid.without("DIAGONAL", "PERTURB", "SEED")
    changed = deck.with_card(card).with_card(grid.without("FIT", "REFIT"))
    return changed.with_cards(
        [c.with_value("PER ELEMENT", "DEFAULT") if c.keyword == "POINTS" else c for c in changed.cards if c.keyword != "REFINE"]
    )


def _rows(grid: Card) -> dict[str, list[list[str]]]:
    """Data lines of a grid by axis."""
    rows: dict[str, list[list[str]]] = {}
    for row in grid.data():
        rows.setdefault(row[0].upper(), []).append(row)
    return rows


def _piece(row: list[str], where: str) -> np.ndarray:
    """Grid lines of one data line of a grid."""
    try:
        if row[1].upper() == "LINES":
            return np.array([float(v.lower().replace("d", "e")) for v in row[2:]])
        first, last, count = float(row[1]), float(row[2]), int(row[3])
        ratio = float(row[4]) if len(row) > 4 else 1.0
        powers = ratio ** (np.arange(count) / max(count - 1, 1))
        return first + (last - first) * np.concatenate([[0.0], np.cumsum(powers) / powers.sum()])
    except (ValueError, IndexError):
        raise Trouble(f"{where}: an invalid data line of *GRID: {', '.join(row)}") from None


def axis_lines(deck: Deck, axis: str) -> np.ndarray:
    """Grid lines along an axis."""
    grid = deck.find("GRID")
    rows = _rows(grid).get(axis, []) if grid else []
    return np.unique(np.concatenate([_piece(row, str(deck.path)) for row in rows])) if rows else np.zeros(0)


def _scaled_row(row: list[str], level: int, where: str) -> list[str] | None:
    """A data line of a grid at a level; None if it cannot be halved."""
    lines = _piece(row, where)
    if row[1].upper() != "LINES":
        scaled = int(row[3]) * 2**level if level >= 0 else int(row[3]) / 2**-level
        return None if scaled != int(scaled) else [*row[:3], str(int(scaled)), *row[4:]]
    for _ in range(abs(level)):
        if level > 0:
            lines = np.sort(np.concatenate([lines, (lines[1:] + lines[:-1]) / 2]))
        elif len(lines) % 2 == 0:
            return None
        else:
            lines = lines[::2]
    return [*row[:2], *(f"{v:.15g}" for v in lines)]


def at_level(deck: Deck, level: int) -> Deck | None:
    """The deck on the grid of a level; None if there is no such grid."""
    grid = deck.find("GRID")
    if grid is None or level == 0:
        return deck if level == 0 else None
    lines = []
    for line in grid.lines:
        row = items(line)
        if not line.strip() or line.lstrip().startswith("**"):
            lines.append(line)
            continue
        alone = len(axis_lines(deck, row[0].upper())) <= 2
        scaled = row if alone else _scaled_row(row, level, str(deck.path))
        if scaled is None:
            return None
        lines.append(" " + ", ".join(scaled))
    changed = deck.with_card(Card("GRID", grid.parameters, tuple(lines)))
    return changed if level > 0 or _keeps_sets(deck, changed) else None


def _keeps_sets(deck: Deck, coarse: Deck) -> bool:
    """Whether a coarser grid has the lines with node sets, and enough cells along every axis."""
    for axis in "XYZ":
        own, left = axis_lines(deck, axis), axis_lines(coarse, axis)
        if len(own) > 2 and len(left) - 1 < FEWEST_CELLS:
            return False
        for place in _places_of_sets(deck, axis):
            if _near(own, place) and not _near(left, place):
                return False
    return True


def _near(lines: np.ndarray, place: float) -> bool:
    """Whether a coordinate is on a grid line."""
    return bool(len(lines)) and bool(np.min(np.abs(lines - place)) <= 1e-6 * (lines[-1] - lines[0]))


def _places_of_sets(deck: Deck, axis: str) -> list[float]:
    """Coordinates along an axis named in node sets by planes and boxes."""
    found: list[float] = []
    for card in deck.all("NSET"):
        rows = card.data()
        try:
            if card.value("PLANE") == axis:
                found += [float(row[0]) for row in rows[:1]]
            elif card.value("BOX") is not None:
                found += [float(v) for row in rows[:1] for v in row["XYZ".index(axis) * 2 :][:2]]
        except (ValueError, IndexError):
            continue
    return found


# Width of the bracket of a search for a factor of safety that the program takes, and the narrowest it allows.
BRACKET, NARROWEST = 0.005, 1e-4


def with_steps(deck: Deck, factor: int) -> Deck:
    """Every phase with a multiple of the steps; a tolerance of the step error is changed accordingly.

    A search for a factor of safety has no steps: its bracket is reduced by the factor instead. Its STEPS are those of
    the run-out, if there is one.
    """
    cards: list[Card] = []
    for phase in _phases(deck.cards):
        cards += _searched(phase, factor) if phase[0].value("TYPE") == "SAFETY" else _stepped(phase, factor)
    return deck.with_cards(cards)


def _phases(cards: Sequence[Card]) -> list[list[Card]]:
    """The keywords grouped by *PHASE; those of the model are first."""
    parts: list[list[Card]] = []
    for card in cards:
        if card.keyword == "PHASE" or not parts:
            parts.append([])
        parts[-1].append(card)
    return parts


def _stepped(phase: list[Card], factor: int) -> list[Card]:
    """A phase with a multiple of the steps; the keywords of the model are unchanged."""
    cards = [_more_steps(card, factor) if card.keyword == "CONTROLS" else card for card in phase]
    if phase[0].keyword == "PHASE" and all(card.keyword != "CONTROLS" for card in phase):
        end = next((i for i, card in enumerate(phase) if card.keyword == "END PHASE"), len(phase))
        cards.insert(end, Card("CONTROLS", (("STEPS", str(10 * factor)),)))
    return cards


def _more_steps(controls: Card, factor: int) -> Card:
    """*CONTROLS with a multiple of the steps."""
    card = controls.with_value("STEPS", str(factor * int(controls.value("STEPS") or 10)))
    share = float(controls.value("STEP ERROR") or 0.0)
    return card.with_value("STEP ERROR", f"{share / factor**2:.6g}") if share > 0 else card


def _searched(phase: list[Card], factor: int) -> list[Card]:
    """A safety phase with a narrower bracket; its run-out with a multiple of the steps."""
    own = next((card for card in phase if card.keyword == "SAFETY"), None)
    safety = own or Card("SAFETY")
    width = max(float(safety.value("TOLERANCE") or BRACKET) / factor, NARROWEST)
    narrower = safety.with_value("TOLERANCE", f"{width:.6g}")
    cards = [narrower if card is own else card for card in phase] if own else [phase[0], narrower, *phase[1:]]
    return _stepped(cards, factor) if safety.value("RUNOUT") not in (None, "NO") else cards


def dimension(deck: Deck) -> int:
    """Axes of the grid with more than one cell; 2 without a grid."""
    counted = sum(len(axis_lines(deck, axis)) > 2 for axis in "XYZ")
    return counted or 2


def levels_of(deck: Deck) -> list[int]:
    """Levels of grids from the coarsest one that preserves the scene."""
    if deck.find("GRID") is None:
        return [0]
    down = []
    for level in range(-1, DEEPEST_LEVEL - 1, -1):
        if at_level(deck, level) is None:
            break
        down.append(level)
    return [*reversed(down), *range(FINEST_LEVEL + 1)]
