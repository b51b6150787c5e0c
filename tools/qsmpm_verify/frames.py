"""A deck in another frame: translated, mirrored, rotated by 90 degrees, in other units, with its keywords in another order.

Every history of the deck is converted so that the run in the new frame gives the values of the old one: components and signs are those of
the frame, SCALE reverts the units. A keyword that is not supported here is an error, so that nothing remains in the old frame.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from qsmpm_verify.study.cards import Card, Deck, plain
from qsmpm_verify.trouble import Trouble

AXES = ("X", "Y")
POINT_QUANTITIES = ("DISPLACEMENT", "POSITION", "STRESS", "STRAIN", "STATE", "PORE PRESSURE", "CONTACT PRESSURE")
# What a number of a history is, as powers of length and force.
KINDS = {
    "DISPLACEMENT": (1, 0), "POSITION": (1, 0), "STRESS": (-2, 1), "STRAIN": (0, 0), "PORE PRESSURE": (-2, 1), "CONTACT PRESSURE": (-2, 1),
    "REACTION": (-1, 1), "CONTACT FORCE": (-1, 1), "CONTACT MOMENT": (0, 1), "BODY MOVE": (1, 0), "BODY ROTATION": (0, 0), "RUNOUT": (1, 0),
    "CONTACT SLIP": (1, 0),
}  # fmt: skip
AS_IT_STANDS = {
    "HEADING", "UNITS", "FIELD", "RESTART", "METHOD", "SOLVER", "POINTS", "VOLUMETRIC LOCKING", "CONTROLS", "SAFETY", "PHASE", "END PHASE",
    "RESET DISPLACEMENTS", "ACTIVATE", "DEACTIVATE", "CHANGE MATERIAL", "MATERIAL", "MODEL", "UNDRAINED",
}  # fmt: skip


@dataclass(frozen=True)
class Frame:
    """x' = length (A x + shift), A a rotation by multiples of 90 degrees with or without a mirror; forces times `force`."""

    matrix: tuple[tuple[int, int], tuple[int, int]] = ((1, 0), (0, 1))
    shift: tuple[float, float] = (0.0, 0.0)
    length: float = 1.0
    force: float = 1.0
    axisymmetric: bool = False

    @property
    def stress(self) -> float:
        """Factor on stresses."""
        return self.force / self.length**2

    @property
    def mirrors(self) -> bool:
        """Whether left and right are exchanged."""
        (a, b), (c, d) = self.matrix
        return a * d - b * c < 0

    def vector(self, v: Sequence[float]) -> list[float]:
        """A direction."""
        return [float(sum(self.matrix[i][j] * v[j] for j in range(2))) for i in range(2)]

    def point(self, p: Sequence[float]) -> list[float]:
        """A place."""
        turned = self.vector(p)
        return [self.length * (turned[i] + self.shift[i]) for i in range(2)]

    def axis(self, old: int) -> tuple[int, int]:
        """The new axis of an old one, and its sign."""
        new = next(i for i in range(2) if self.matrix[i][old])
        return new, self.matrix[new][old]

    def along(self, old: int, value: float) -> float:
        """Transform a coordinate along an axis."""
        new, sign = self.axis(old)
        return self.length * (sign * value + self.shift[new])

    def box(self, box: Sequence[float]) -> list[float]:
        """xmin, xmax, ymin, ymax."""
        a, b = self.point([box[0], box[2]]), self.point([box[1], box[3]])
        return [min(a[0], b[0]), max(a[0], b[0]), min(a[1], b[1]), max(a[1], b[1])]


def numbers(row: Sequence[str]) -> list[float]:
    """A data line as numbers."""
    return [float(item) for item in row]


def line(*values: object) -> str:
    """A data line."""
    return ", ".join(repr(v + 0.0) if isinstance(v, float) else str(v) for v in values)


def _axis_number(word: str | None) -> int:
    return AXES.index(str(word))


def _places(card: Card, frame: Frame) -> Card:
    """Rows of points."""
    return replace(card, lines=tuple(line(*frame.point(numbers(row))) for row in card.data()))


def _boxes(card: Card, frame: Frame) -> Card:
    return replace(card, lines=tuple(line(*frame.box(numbers(row))) for row in card.data()))


def _grid(card: Card, frame: Frame) -> Card:
    """Lines of the grid; an axis that is reversed goes from its end to its start."""
    rows = []
    for row in card.data():
        if plain(row[1]) == "LINES":
            raise Trouble("*GRID with LINES in another frame")
        old = _axis_number(plain(row[0]))
        new, sign = frame.axis(old)
        first, last = frame.along(old, float(row[1])), frame.along(old, float(row[2]))
        ratio = float(row[4]) if len(row) > 4 else 1.0
        if sign < 0:
            first, last, ratio = last, first, 1 / ratio
        rows.append((new, first, line(AXES[new], first, last, row[3], *([ratio] if ratio != 1 else []))))
    return replace(card, lines=tuple(text for _, _, text in sorted(rows)))


def _node_set(card: Card, frame: Frame) -> Card:
    plane = card.value("PLANE")
    if plane is None:
        return _boxes(card, frame)
    old = _axis_number(plane)
    value = frame.along(old, float(card.data()[0][0]))
    return replace(card.with_value("PLANE", AXES[frame.axis(old)[0]]), lines=(line(value),))


def _surface(card: Card, frame: Frame) -> Card:
    """Segments have the body on their left, which a mirror exchanges."""
    if card.value("TYPE") != "SEGMENT":
        return _boxes(card, frame) if card.data() else card
    rows = []
    for row in card.data():
        ends = [frame.point(numbers(row[:2])), frame.point(numbers(row[2:]))]
        rows.append(line(*(sum(ends[::-1] if frame.mirrors else ends, []))))
    return replace(card, lines=tuple(rows))


def _body(card: Card, frame: Frame) -> Card:
    shape = card.value("SHAPE")
    if shape == "ALL":
        return card
    return _boxes(card, frame) if shape == "BOX" else _places(card, frame)


def _rigid_body(card: Card, frame: Frame) -> Card:
    shape = card.value("SHAPE")
    if card.value("ROUND") is not None:
        card = card.with_value("ROUND", repr(float(str(card.value("ROUND"))) * frame.length))
    rows = [numbers(row) for row in card.data()]
    if shape == "CIRCLE":
        return replace(card, lines=(line(*frame.point(rows[0]), frame.length * rows[0][2]),))
    if shape == "PLANE":
        return replace(card, lines=(line(*frame.point(rows[0]), *frame.vector(rows[0][2:])),))
    if shape == "CONE":
        raise Trouble("a cone in another frame")
    return _boxes(card, frame) if shape == "BOX" else _places(card, frame)


def _history(card: Card, frame: Frame) -> Card:
    """The same values: component and sign of the frame, units reverted."""
    quantity = str(card.value("QUANTITY"))
    component, scale = card.value("COMPONENT"), float(card.value("SCALE") or 1.0)
    if component in AXES:
        new, sign = frame.axis(AXES.index(component))
        component, scale = AXES[new], scale * sign
    elif component == "XY":
        scale *= frame.axis(0)[1] * frame.axis(1)[1]
    elif component in ("XX", "YY"):
        component = 2 * AXES[frame.axis(AXES.index(component[0]))[0]]
    if quantity in ("CONTACT MOMENT", "BODY ROTATION") and frame.mirrors:
        scale = -scale
    powers = KINDS.get(quantity, (0, 0))
    whole = 1 if frame.axisymmetric and powers == (-1, 1) else 0
    scale /= frame.length ** (powers[0] + whole) * frame.force ** powers[1]
    card = card.with_value("SCALE", repr(scale)).with_value("UNIT", "u")
    if component is not None:
        card = card.with_value("COMPONENT", component)
    return _places(card, frame) if quantity in POINT_QUANTITIES else card


def _strength(card: Card, frame: Frame) -> Card:
    """Stresses are first and, for a tension cut-off, fourth."""
    rows = []
    for row in card.data():
        values = numbers(row)
        rows.append(line(*(v * frame.stress if i in (0, 3) else v for i, v in enumerate(values))))
    return replace(card, lines=tuple(rows))


def _elastic(card: Card, frame: Frame) -> Card:
    rows = [numbers(row) for row in card.data()]
    return replace(card, lines=tuple(line(row[0] * frame.stress, *row[1:]) for row in rows))


def _weights(card: Card, frame: Frame) -> Card:
    return replace(card, lines=tuple(line(*(v * frame.stress / frame.length for v in numbers(row))) for row in card.data()))


def _vector(card: Card, frame: Frame, factor: float = 1.0) -> Card:
    return replace(card, lines=tuple(line(*(factor * v for v in frame.vector(numbers(row)))) for row in card.data()))


def _held(card: Card, frame: Frame) -> Card:
    """Names of components after that of a set."""
    rows = []
    for row in card.data():
        words = [AXES[frame.axis(AXES.index(plain(w)))[0]] if plain(w) in AXES else w for w in row[1:]]
        rows.append(line(row[0], *words))
    return replace(card, lines=tuple(rows))


def _prescribed(card: Card, frame: Frame) -> Card:
    rows = []
    for name, component, value in card.data():
        new, sign = frame.axis(AXES.index(plain(component)))
        rows.append(line(name, AXES[new], sign * frame.length * float(value)))
    return replace(card, lines=tuple(rows))


def _water(card: Card, frame: Frame) -> Card:
    weight = card.value("UNIT WEIGHT")
    if weight is not None:
        card = card.with_value("UNIT WEIGHT", repr(float(weight) * frame.stress / frame.length))
    # A corner is a place along the horizontal and a height, whatever axis gravity acts along; corners go along the horizontal.
    upright = frame.axis(1)[0]
    corners = sorted((p[1 - upright], p[upright]) for p in (frame.point(numbers(row)) for row in card.data()))
    return replace(card, lines=tuple(line(*corner) for corner in corners))


def _contact(card: Card, frame: Frame) -> Card:
    adhesion = card.value("ADHESION")
    return card if adhesion is None else card.with_value("ADHESION", repr(float(adhesion) * frame.stress))


def _pressure(card: Card, frame: Frame) -> Card:
    return replace(card, lines=tuple(line(*(v * frame.stress for v in numbers(row[:1]))) for row in card.data()))


def _initial(up: int) -> Callable[[Card, Frame], Card]:
    """Stresses by height, along the old axis of gravity."""

    def changed(card: Card, frame: Frame) -> Card:
        kind = card.value("TYPE")
        rows = [numbers(row) for row in card.data()]
        if kind == "K0":
            return replace(card, lines=tuple(line(frame.along(up, row[0]), *row[1:]) for row in rows))
        if kind == "ISOTROPIC" and len(rows) == 1:
            return replace(card, lines=(line(frame.along(up, rows[0][0]), rows[0][1] * frame.stress),))
        raise Trouble(f"*INITIAL, TYPE={kind} in another frame")

    return changed


def _loads(card: Card, frame: Frame) -> Card:
    component = str(card.value("COMPONENT"))
    if component not in AXES:
        raise Trouble(f"*LOAD, COMPONENT={component} in another frame")
    new, sign = frame.axis(AXES.index(component))
    factor = sign * frame.stress * frame.length ** (2 if frame.axisymmetric else 1)
    return replace(card.with_value("COMPONENT", AXES[new]), lines=tuple(line(*(factor * v for v in numbers(row))) for row in card.data()))


CHANGES: dict[str, Callable[[Card, Frame], Card]] = {
    "GRID": _grid, "NSET": _node_set, "SURFACE": _surface, "BODY": _body, "RIGID BODY": _rigid_body, "HISTORY": _history,
    "MOHR COULOMB": _strength, "SOFTENING": _strength, "ELASTIC": _elastic, "UNIT WEIGHT": _weights, "GRAVITY": _vector, "FIX": _held,
    "FREE": _held, "PRESCRIBE": _prescribed, "WATER LEVEL": _water, "CONTACT": _contact, "PRESSURE": _pressure, "INITIAL": _initial(1), "LOAD": _loads,
    "TRACTION": lambda card, frame: _vector(card, frame, frame.stress), "MOVE": lambda card, frame: _vector(card, frame, frame.length),
}  # fmt: skip


def in_frame(deck: Deck, frame: Frame) -> Deck:
    """The deck in another frame."""
    cards = []
    model = deck.find("MODEL")
    frame = replace(frame, axisymmetric=model is not None and model.value("TYPE") == "AXISYMMETRIC")
    for card in deck.cards:
        if card.keyword in CHANGES:
            card = CHANGES[card.keyword](card, frame)
        elif card.keyword not in AS_IT_STANDS:
            raise Trouble(f"*{card.keyword} in another frame")
        cards.append(card)
    return deck.with_cards(cards)


def translated(deck: Deck, size: float, chance: random.Random) -> Deck:
    """Translated by about a distance along both axes, by values that are not round; in axisymmetry only along the axis."""
    model = deck.find("MODEL")
    shift = [chance.choice((-1, 1)) * round(size * chance.uniform(0.7, 1.3), 4) for _ in range(2)]
    if model is not None and model.value("TYPE") == "AXISYMMETRIC":
        shift[0] = 0.0
    return in_frame(deck, Frame(shift=(shift[0], shift[1])))


def mirrored(deck: Deck) -> Deck:
    """Left and right exchanged."""
    return in_frame(deck, Frame(matrix=((-1, 0), (0, 1))))


def turned(deck: Deck, sense: int) -> Deck:
    """Rotated by 90 degrees, counter-clockwise for 1, clockwise for -1."""
    return in_frame(deck, Frame(matrix=((0, -sense), (sense, 0))))


def in_units(deck: Deck) -> Deck:
    """From kN and m to N and mm."""
    return in_frame(deck, Frame(length=1e3, force=1e3))


def _groups(cards: Sequence[Card]) -> list[list[Card]]:
    """Keyword groups before the first phase that must remain together: a material with its properties; all others are single."""
    groups: list[list[Card]] = []
    properties = ("ELASTIC", "MOHR COULOMB", "SOFTENING", "UNIT WEIGHT", "VOLUMETRIC LOCKING", "UNDRAINED", "K0")
    for card in cards:
        if card.keyword in properties and groups:
            groups[-1].append(card)
        else:
            groups.append([card])
    return groups


def reordered(deck: Deck, chance: random.Random) -> Deck:
    """The keywords before the phases in another order, and the keywords of every phase."""
    first = next(i for i, card in enumerate(deck.cards) if card.keyword == "PHASE")
    head = [card for card in deck.cards[:first] if card.keyword == "HEADING"]
    groups = _groups([card for card in deck.cards[:first] if card.keyword != "HEADING"])
    chance.shuffle(groups)
    cards = head + [card for group in groups for card in group]
    inner: list[Card] = []
    for card in deck.cards[first:]:
        if card.keyword == "END PHASE":
            chance.shuffle(inner)
            cards += [*inner, card]
            inner = []
        elif card.keyword == "PHASE":
            cards.append(card)
        else:
            inner.append(card)
    return deck.with_cards(cards)


def split(deck: Deck) -> Deck:
    """Every phase of loads in two halves with half of its steps: loads up to half, then the rest; bodies and nodes by half each."""
    cards: list[Card] = []
    block: list[Card] = []
    before = 0.0
    for card in deck.cards:
        if card.keyword != "PHASE" and not block:
            cards.append(card)
            continue
        block.append(card)
        if card.keyword != "END PHASE":
            continue
        steps = next((int(c.value("STEPS") or 10) for c in block if c.keyword == "CONTROLS"), 10)
        moves = any(c.keyword in ("MOVE", "PRESCRIBE") for c in block)
        if steps % 2 or block[0].value("TYPE") == "SAFETY" or not (moves or before == 0.0) or any(c.keyword in ("WATER LEVEL", "INITIAL") for c in block):
            cards += block
        else:
            cards += _halves(block, moves)
        before = 1.0
        block = []
    return deck.with_cards(cards)


def _halves(block: Sequence[Card], moves: bool) -> list[Card]:
    """A phase of motions, or the first phase of loads, in two."""
    phase = block[0]
    factor = float(phase.value("LOAD FACTOR") or 1.0)
    name = str(next(value for key, value in phase.parameters if plain(key) == "NAME"))
    halves = []
    for part in (1, 2):
        for card in block:
            if card.keyword == "PHASE":
                card = card.with_value("NAME", name if part == 2 else f"{name}, half".replace(",", ""))
                if not moves:
                    card = card.with_value("LOAD FACTOR", repr(factor * part / 2))
            elif card.keyword == "CONTROLS":
                card = card.with_value("STEPS", str(int(card.value("STEPS") or 10) // 2))
            elif card.keyword in ("RESET DISPLACEMENTS", "ACTIVATE", "DEACTIVATE") and part == 2:
                continue
            elif card.keyword == "MOVE":
                card = replace(card, lines=tuple(line(*(v / 2 for v in numbers(row))) for row in card.data()))
            elif card.keyword == "PRESCRIBE":
                card = replace(card, lines=tuple(line(row[0], row[1], float(row[2]) / 2) for row in card.data()))
            halves.append(card)
    return halves


def enlarged(deck: Deck) -> Deck:
    """Additional rows of empty cells on each side of the grid that carries no node set."""
    grid = deck.find("GRID")
    if grid is None:
        raise Trouble("a larger grid of a mesh file")
    planes = {(card.value("PLANE"), float(card.data()[0][0])) for card in deck.all("NSET") if card.value("PLANE")}
    rows: list[str] = []
    for axis in AXES:
        own = [row for row in grid.data() if plain(row[0]) == axis]
        rows += [line(*row) for row in own]
        last = own[-1]
        if (axis, float(last[2])) not in planes:
            width = (float(last[2]) - float(last[1])) / int(last[3])
            if len(last) > 4 and not math.isclose(float(last[4]), 1.0):
                raise Trouble("a larger grid with graded cells")
            rows.append(line(axis, float(last[2]), float(last[2]) + 7 * width, 7))
    if len(rows) == len(grid.data()):
        raise Trouble("a grid with node sets on all of its sides")
    return deck.with_card(replace(grid, lines=tuple(rows)))


def whole_as_auto(deck: Deck) -> Deck:
    """The smallest model of the scene instead of the scene as written."""
    model = deck.find("MODEL")
    if model is None or model.value("TYPE") != "PLANE STRAIN":
        raise Trouble("AUTO for a scene that is not plane")
    return deck.with_card(model.with_value("TYPE", "AUTO").with_value("MIRROR", "YES"))
