"""What of a deck limit analysis knows: bodies, strengths, loads, water and supports at both ends of a phase.

Cards that change no limit load (stiffness, method, steps, histories) are passed over; any other card is an error that names it.
"""

from __future__ import annotations

from collections.abc import Callable, Container
from dataclasses import dataclass, field, replace

import numpy as np

from qsmpm_verify.bounds.strength import Strength, profile_of
from qsmpm_verify.results import Array
from qsmpm_verify.study.cards import Card, Deck, plain
from qsmpm_verify.trouble import Trouble

# No limit load depends on them.
PASSED = {
    "HEADING", "UNITS", "METHOD", "SOLVER", "MOVING MESH", "POINTS", "HISTORY", "FIELD", "RESTART", "CONTROLS", "ELASTIC", "K0",
    "VOLUMETRIC LOCKING", "RESET DISPLACEMENTS", "CONSTANT LOAD TEST", "PROP", "ELSET", "END PHASE",
}  # fmt: skip
OTHER_LAWS = {
    "SOFTENING", "CAM CLAY", "HARDENING SOIL", "DRUCKER PRAGER", "USER MATERIAL", "USER STATE", "STRENGTH CONSTANTS",
}  # fmt: skip


@dataclass(frozen=True)
class Surface:
    """SEGMENT: pieces of start and end. BOX: low and high corner. OUTLINE: of a body, of what is in the box where there is one."""

    kind: str
    places: Array
    body: str = ""


@dataclass(frozen=True)
class Push:
    """A pressure that grows downwards from a height, not below zero where it is that of water."""

    value: float
    gradient: float
    height: float
    water: bool


@dataclass(frozen=True)
class Level:
    """A water level: its corners, the weight of water."""

    corners: Array
    weight: float


@dataclass(frozen=True)
class State:
    """What acts at the end of a phase."""

    gravity: tuple[float, float] = (0.0, 0.0)
    tractions: dict[str, tuple[float, float]] = field(default_factory=dict)
    pushes: dict[str, Push] = field(default_factory=dict)
    water: dict[str, Level | None] = field(default_factory=dict)
    held: dict[str, str] = field(default_factory=dict)
    supports: dict[str, str] = field(default_factory=dict)
    active: frozenset[str] = frozenset()
    materials: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Material:
    """Strength and weights of a material; `refused` is the card that limit analysis cannot take."""

    strength: Strength | None = None
    weight: float = 0.0
    saturated: float = 0.0
    refused: str = ""


@dataclass(frozen=True)
class Scene:
    """A deck at one of its phases: the ground, what acts before and after, and what is asked for."""

    bodies: dict[str, Array]
    materials: dict[str, Material]
    surfaces: dict[str, Surface]
    sets: dict[str, tuple[Array, Array]]
    before: State
    after: State
    phase: str
    load_factor: float
    safety: bool
    flow: str
    pushed: dict[tuple[str, str], float]
    units: tuple[str, str]
    steps: tuple[Array, Array]
    """Lines of the grid along x and y."""


def refuse(card: Card, why: str) -> Trouble:
    """An error that names a card."""
    return Trouble(f"*{card.keyword}: {why}")


def numbers(card: Card, row: list[str], least: int, most: int | None = None) -> list[float]:
    """Numbers of a data line."""
    words = [word for word in row if word != ""]
    try:
        found = [float(word.lower().replace("d", "e")) for word in words]
    except ValueError as error:
        raise refuse(card, f"'{', '.join(row)}' are no numbers") from error
    if len(found) < least or (most is not None and len(found) > most):
        raise refuse(card, f"'{', '.join(row)}' is no line of {least} numbers")
    return found


def name_of(card: Card, parameter: str) -> str:
    """A name, as it is written."""
    found = next((value.strip('"') for key, value in card.parameters if plain(key) == parameter), "")
    if not found:
        raise refuse(card, f"no {parameter}")
    return found


def only(card: Card, **allowed: tuple[str, ...]) -> None:
    """Refuse a word of a choice that limit analysis cannot take."""
    for key, words in allowed.items():
        name = key.replace("_", " ")
        value = card.value(name)
        if value is not None and value not in words:
            raise refuse(card, f"{name}={value}: bounds take {' or '.join(words)}")


def box_of(card: Card, row: list[str]) -> tuple[Array, Array]:
    """Low and high corner."""
    x = numbers(card, row, 4, 4)
    return np.array([x[0], x[2]]), np.array([x[1], x[3]])


def rectangle(low: Array, high: Array) -> Array:
    """Corners of a box, counter-clockwise."""
    return np.array([low, (high[0], low[1]), high, (low[0], high[1])], dtype=float)


def grid_lines(card: Card) -> tuple[Array, Array]:
    """Lines of the grid along x and y."""
    found: dict[str, list[float]] = {"X": [], "Y": []}
    for row in card.data():
        axis = plain(row[0])
        if axis not in found:
            raise refuse(card, f"axis {axis}: bounds are those of plane strain")
        if plain(row[1]) == "LINES":
            new = numbers(card, row[2:], 1)
        else:
            values = numbers(card, row[1:], 2, 4)
            first, last, count, ratio = values if len(values) == 4 else (found[axis][-1:] + values if len(values) == 2 else values) + [1.0]
            widths = ratio ** (np.arange(count) / max(count - 1.0, 1.0))
            new = list(first + (last - first) * np.append(0.0, np.cumsum(widths) / widths.sum()))
        found[axis] += [v for v in new if not found[axis] or v > found[axis][-1]]
    return np.array(found["X"]), np.array(found["Y"])


class Reader:
    """Cards of the model one after the other, then those of the phases up to the one asked for."""

    def __init__(self, deck: Deck) -> None:
        self.deck = deck
        self.bodies: dict[str, Array] = {}
        self.body_materials: dict[str, str] = {}
        self.absent: set[str] = set()
        self.materials: dict[str, Material] = {}
        self.surfaces: dict[str, Surface] = {}
        self.sets: dict[str, tuple[Array, Array]] = {}
        self.units = ("", "")
        grid = deck.find("GRID")
        if grid is None:
            raise Trouble("no *GRID: bounds take bodies that are drawn on one")
        self.steps = grid_lines(grid)
        self.material = ""
        words: dict[str, Callable[[Card], None]] = {
            "MODEL": self.model, "GRID": lambda card: None, "BODY": self.body, "MATERIAL": self.begin_material, "SURFACE": self.surface,
            "NSET": self.node_set, "MOHR COULOMB": self.mohr_coulomb, "UNIT WEIGHT": self.unit_weight, "UNDRAINED": self.undrained,
            "STRENGTH PROFILE": self.profile,
        }  # fmt: skip
        for card in deck.cards:
            if card.keyword == "PHASE":
                break
            if card.keyword == "UNITS":
                self.units = (name_of(card, "LENGTH"), name_of(card, "FORCE"))
            if card.keyword in OTHER_LAWS:
                self.now(refused=f"*{card.keyword} of material '{self.material}'")
            elif card.keyword in words:
                words[card.keyword](card)
            elif card.keyword not in PASSED:
                raise refuse(card, "limit analysis here does not know it")

    def now(self, **changes: object) -> None:
        """Change the material that is being read."""
        self.materials[self.material] = replace(self.materials[self.material], **changes)  # type: ignore[arg-type]

    def model(self, card: Card) -> None:
        """Plane strain."""
        only(card, TYPE=("PLANE STRAIN", "AUTO"))

    def body(self, card: Card) -> None:
        """A box, a polygon or the whole grid."""
        only(card, SHAPE=("BOX", "POLYGON", "ALL"))
        name, rows = name_of(card, "NAME"), card.data()
        x, y = self.steps
        shape = card.value("SHAPE")
        if shape == "POLYGON":
            places = np.array([numbers(card, row, 2, 2) for row in rows])
        else:
            places = rectangle(*(box_of(card, rows[0]) if shape == "BOX" else (np.array([x[0], y[0]]), np.array([x[-1], y[-1]]))))
        turn = np.roll(places, -1, axis=0)
        if float(np.sum(places[:, 0] * turn[:, 1] - turn[:, 0] * places[:, 1])) < 0.0:
            places = places[::-1]
        self.bodies[name], self.body_materials[name] = places, name_of(card, "MATERIAL")
        if card.value("ACTIVE") == "NO":
            self.absent.add(name)

    def begin_material(self, card: Card) -> None:
        """The properties that follow are its own."""
        self.material = name_of(card, "NAME")
        self.materials[self.material] = Material()

    def mohr_coulomb(self, card: Card) -> None:
        """c, phi, psi and a tension cut-off."""
        row = card.data()[0]
        cut = row[3] if len(row) > 3 and plain(row[3]) not in ("", "NONE") else None
        c, phi, psi = numbers(card, row[:3], 3)
        tension = numbers(card, [cut], 1)[0] if cut is not None else None
        self.now(strength=Strength(c, phi, psi, tension))

    def unit_weight(self, card: Card) -> None:
        """Above and below the water."""
        values = numbers(card, card.data()[0], 1, 2)
        self.now(weight=values[0], saturated=values[-1])

    def undrained(self, card: Card) -> None:
        """With phi = 0 the strength is that of total stresses."""
        if card.value("TYPE") not in ("B", "C"):
            self.now(refused=f"*UNDRAINED, TYPE=A of material '{self.material}'")

    def profile(self, card: Card) -> None:
        """Cohesion by place."""
        only(card, TYPE=("LINEAR", "TABLE"), ALONG=("X", "Y"))
        strength = self.materials[self.material].strength
        if strength is None:
            raise refuse(card, "stands above *MOHR COULOMB; bounds want it below")
        rows = [numbers(card, row, 2, 3) for row in card.data()]
        axis = 0 if card.value("ALONG") == "X" else 1
        levels = profile_of(card.value("TYPE") or "LINEAR", rows, strength.cohesion)
        self.now(strength=replace(strength, profile=levels, axis=axis))

    def surface(self, card: Card) -> None:
        """Where loads act or supports hold."""
        only(card, TYPE=("BOX", "SEGMENT", "OUTLINE"))
        rows, kind = card.data(), card.value("TYPE") or "BOX"
        if kind == "SEGMENT":
            places = np.array([numbers(card, row, 4, 4) for row in rows]).reshape(-1, 2, 2)
        else:
            places = np.array(box_of(card, rows[0])) if rows else np.array([[-np.inf] * 2, [np.inf] * 2])
        self.surfaces[name_of(card, "NAME")] = Surface(kind, places, name_of(card, "BODY") if kind == "OUTLINE" else "")

    def node_set(self, card: Card) -> None:
        """A plane or a box; a box ends at the last lines of the grid in it, as the nodes do."""
        name, rows = name_of(card, "NSET"), card.data()
        plane = card.value("PLANE")
        if plane in ("X", "Y"):
            axis, at = "XY".index(plane), numbers(card, rows[0], 1, 1)[0]
            low, high = np.full(2, -np.inf), np.full(2, np.inf)
            low[axis] = high[axis] = at
        elif card.value("BOX") is not None:
            low, high = box_of(card, rows[0])
            for axis, lines in enumerate(self.steps):
                slack = 1e-6 * (lines[-1] - lines[0])
                inside = lines[(lines >= low[axis] - slack) & (lines <= high[axis] + slack)]
                if len(inside):
                    low[axis], high[axis] = inside[0], inside[-1]
        else:
            raise refuse(card, f"'{name}' by labels of nodes; bounds take PLANE or BOX")
        self.sets[name] = (low, high)


@dataclass(frozen=True)
class Phase:
    """A phase as it was read: its state, what it pushes."""

    name: str
    state: State
    start: State
    factor: float
    safety: bool
    flow: str
    pushed: dict[tuple[str, str], float]
    initial: bool


class Phases:
    """States of the phases, in the order of the deck."""

    def __init__(self, reader: Reader) -> None:
        self.reader = reader
        active = frozenset(name for name in reader.bodies if name not in reader.absent)
        self.none = State(active=active, materials=dict(reader.body_materials))
        self.done: dict[str, Phase] = {}

    def read(self, cards: list[Card]) -> Phase:
        """A phase of its cards."""
        head = cards[0]
        only(head, TYPE=("LOADING", "SAFETY"))
        name = name_of(head, "NAME")
        last = list(self.done.values())[-1].state if self.done else self.none
        parent = next((v.strip('"') for k, v in head.parameters if plain(k) == "PARENT"), "")
        if parent and parent not in self.done:
            raise refuse(head, f"PARENT={parent} is no earlier phase")
        start = self.done[parent].state if parent else last
        factor = float(head.value("LOAD FACTOR") or 1.0)
        self.state = replace(
            start, tractions=dict(start.tractions), pushes=dict(start.pushes), water=dict(start.water), held=dict(start.held),
            supports=dict(start.supports), materials=dict(start.materials),
        )  # fmt: skip
        self.factor, self.flow, self.initial = factor, "MATERIAL", False
        self.pushed: dict[tuple[str, str], float] = {}
        for card in cards[1:]:
            self.take(card)
        phase = Phase(name, self.state, start, factor, head.value("TYPE") == "SAFETY", self.flow, self.pushed, self.initial)
        self.done[name] = phase
        return phase

    def take(self, card: Card) -> None:
        """A card of a phase."""
        words: dict[str, Callable[[Card], None]] = {
            "FIX": self.fix, "PRESCRIBE": self.prescribe, "GRAVITY": self.gravity, "TRACTION": self.traction, "PRESSURE": self.pressure,
            "WATER LEVEL": self.level, "SUPPORT": self.support, "ACTIVATE": self.activate, "DEACTIVATE": self.deactivate,
            "CHANGE MATERIAL": self.change, "SAFETY": self.safety, "INITIAL": self.stresses,
        }  # fmt: skip
        if card.keyword in words:
            words[card.keyword](card)
        elif card.keyword not in PASSED:
            raise refuse(card, "limit analysis here does not know it")

    def known(self, card: Card, name: str, table: Container[str]) -> str:
        """A name that is there."""
        if name not in table:
            raise refuse(card, f"'{name}' is not there")
        return name

    def fix(self, card: Card) -> None:
        """Components of node sets that are held."""
        for row in card.data():
            name = self.known(card, row[0].strip('"'), self.reader.sets)
            held = self.state.held.get(name, "")
            for word in map(plain, row[1:]):
                held = "" if word == "FREE" else "XY" if word == "ALL" else "".join(sorted(set(held + word) & set("XY")))
            self.state.held[name] = held

    def prescribe(self, card: Card) -> None:
        """Components of node sets that are pushed: held, and the limit is that of the force that pushes."""
        for row in card.data():
            name, axis = self.known(card, row[0].strip('"'), self.reader.sets), plain(row[1])
            value = numbers(card, row[2:], 1, 1)[0]
            self.state.held[name] = "".join(sorted(set(self.state.held.get(name, "") + axis)))
            if value != 0.0:
                self.pushed[name, axis] = value

    def gravity(self, card: Card) -> None:
        """Weight."""
        x, y = (self.factor * v for v in numbers(card, card.data()[0], 2, 2))
        self.state = replace(self.state, gravity=(x, y))

    def traction(self, card: Card) -> None:
        """A dead load on a surface."""
        x, y = (self.factor * v for v in numbers(card, card.data()[0], 2, 2))
        self.state.tractions[self.known(card, name_of(card, "SURFACE"), self.reader.surfaces)] = (x, y)

    def pressure(self, card: Card) -> None:
        """A pressure on a surface, or that of water against it."""
        name = self.known(card, name_of(card, "SURFACE"), self.reader.surfaces)
        if card.value("LEVEL") is not None:
            gradient = self.factor * float(card.value("UNIT WEIGHT") or "nan")
            self.state.pushes[name] = Push(0.0, gradient, float(card.value("LEVEL") or "nan"), True)
        else:
            p, gradient, y = (numbers(card, card.data()[0], 1, 3) + [0.0, 0.0])[:3]
            self.state.pushes[name] = Push(self.factor * p, self.factor * gradient, y, False)

    def level(self, card: Card) -> None:
        """Water in the ground and above it."""
        body = name_of(card, "BODY") if card.value("BODY") is not None else ""
        if card.value("TYPE") == "NONE":
            self.state.water[body] = None
        else:
            corners = np.array([numbers(card, row, 2, 2) for row in card.data()])
            self.state.water[body] = Level(corners, float(card.value("UNIT WEIGHT") or "nan"))

    def support(self, card: Card) -> None:
        """A surface that is held."""
        only(card, TYPE=("FREE", "NORMAL", "ALL"))
        self.state.supports[self.known(card, name_of(card, "SURFACE"), self.reader.surfaces)] = card.value("TYPE") or "NORMAL"

    def activate(self, card: Card) -> None:
        """Bodies put in place, as they are drawn."""
        names = {self.known(card, row[0].strip('"'), self.reader.bodies) for row in card.data()}
        self.state = replace(self.state, active=self.state.active | names)

    def deactivate(self, card: Card) -> None:
        """Bodies taken out."""
        names = {self.known(card, row[0].strip('"'), self.reader.bodies) for row in card.data()}
        self.state = replace(self.state, active=self.state.active - names)

    def change(self, card: Card) -> None:
        """Bodies of another material."""
        for row in card.data():
            body = self.known(card, row[0].strip('"'), self.reader.bodies)
            self.state.materials[body] = self.known(card, row[1].strip('"'), self.reader.materials)

    def safety(self, card: Card) -> None:
        """The flow rule of a search for a factor."""
        only(card, FLOW=("MATERIAL", "DAVIS A", "DAVIS B"))
        self.flow = card.value("FLOW") or "MATERIAL"

    def stresses(self, card: Card) -> None:
        """Stresses at the start change no limit load; the loads of their phase act from its start."""
        self.initial = card.value("TYPE") not in (None, "KEEP")


def phase_cards(deck: Deck) -> list[list[Card]]:
    """The cards of each phase."""
    found: list[list[Card]] = []
    for card in deck.cards:
        if card.keyword == "PHASE":
            found.append([])
        if found:
            found[-1].append(card)
    return found


def read_scene(deck: Deck, asked: str | None = None, factor: bool = False) -> Scene:
    """The scene at a phase, the last one when none is asked for; `factor` asks for the factor of safety at its end."""
    reader = Reader(deck)
    phases, groups = Phases(reader), phase_cards(deck)
    names = [name_of(group[0], "NAME") for group in groups]
    if not names or (asked is not None and asked not in names):
        raise Trouble(f"{deck.path}: no phase {asked or ''}; there are {', '.join(names) or 'none'}")
    chosen = names.index(asked) if asked is not None else len(names) - 1
    phase = [phases.read(group) for group in groups[: chosen + 1]][-1]
    safety = phase.safety or factor
    if not safety and (phase.start.active != phase.state.active or phase.start.materials != phase.state.materials):
        raise Trouble(f"phase '{phase.name}': *ACTIVATE, *DEACTIVATE and *CHANGE MATERIAL are no loads; ask for its factor of safety (--factor)")
    used = {phase.state.materials[name] for name in phase.state.active}
    for name in sorted(used):
        if name not in reader.materials:
            raise Trouble(f"*BODY: material '{name}' is not there")
        material = reader.materials[name]
        if material.refused:
            raise Trouble(f"{material.refused}: limit analysis here does not know it")
        if material.strength is None:
            raise Trouble(f"*MATERIAL, NAME={name}: no *MOHR COULOMB, so no limit")
    x, y = phase.state.gravity
    if (x != 0.0 or y > 0.0) and any(phase.state.water.values()):
        raise Trouble("*WATER LEVEL: bounds take water where gravity points along -y; turn the deck")
    start = phase.state if phase.initial else phase.start
    fastest = max((abs(value) for value in phase.pushed.values()), default=1.0)
    pushed = {} if safety else {place: value / fastest for place, value in phase.pushed.items()}
    return Scene(
        {name: places for name, places in reader.bodies.items() if name in phase.state.active}, reader.materials, reader.surfaces,
        reader.sets, start, phase.state, phase.name, phase.factor, safety, phase.flow, pushed, reader.units,
        reader.steps,
    )  # fmt: skip
