"""Keywords of the phases: the loads at the end of each, and the scene of the requested phase."""

from __future__ import annotations

from collections.abc import Callable, Container
from dataclasses import dataclass, replace

import numpy as np

from qsmpm_verify.bounds.flow import Flow
from qsmpm_verify.bounds.reader import Reader
from qsmpm_verify.bounds.scene import Level, Material, Push, Scene, State
from qsmpm_verify.bounds.strength import Strength
from qsmpm_verify.bounds.words import PASSED, name_of, numbers, only, refuse
from qsmpm_verify.study.cards import Card, Deck, plain
from qsmpm_verify.trouble import Trouble

# Cohesion of what does not fail, over weight times the size of the scene: more than an arm of ten depths asks for.
UNFAILING = 30.0


@dataclass(frozen=True)
class Phase:
    """A phase as read: its state, its prescribed motions."""

    name: str
    state: State
    start: State
    factor: float
    safety: bool
    flow: str
    pushed: dict[tuple[str, str], float]
    initial: bool
    moved: dict[str, tuple[float, float]]


class Phases:
    """States of the phases, in the order of the deck."""

    def __init__(self, reader: Reader) -> None:
        self.reader = reader
        active = frozenset(name for name in reader.bodies if name not in reader.absent)
        self.none = State(active=active, materials=dict(reader.body_materials))
        self.done: dict[str, Phase] = {}

    def read(self, cards: list[Card]) -> Phase:
        """A phase from its keywords."""
        head = cards[0]
        only(head, TYPE=("LOADING", "SAFETY"))
        name = name_of(head, "NAME")
        last = list(self.done.values())[-1].state if self.done else self.none
        parent = next((v.strip('"') for k, v in head.parameters if plain(k) == "PARENT"), "")
        if parent and parent not in self.done:
            raise refuse(head, f"PARENT={parent} is not an earlier phase")
        start = self.done[parent].state if parent else last
        factor = float(head.value("LOAD FACTOR") or 1.0)
        self.state = replace(
            start, tractions=dict(start.tractions), pushes=dict(start.pushes), water=dict(start.water), held=dict(start.held),
            supports=dict(start.supports), materials=dict(start.materials),
        )  # fmt: skip
        self.factor, self.flow, self.initial = factor, "MATERIAL", False
        self.pushed: dict[tuple[str, str], float] = {}
        self.moved: dict[str, tuple[float, float]] = {}
        self.flowing: Card | None = None
        for card in cards[1:]:
            self.take(card)
        if self.flowing is not None:
            weight = float(self.flowing.value("UNIT WEIGHT") or "nan")
            water = start.water.get("") if self.flowing.value("FLOW") == "TRANSIENT" else None
            before = water if isinstance(water, Flow) else None
            self.state.water[""] = Flow(np.empty((0, 2)), weight, self.reader.deck, name, self.flowing, self.state, head.value("TIME") or "", before)
        elif self.state.active != start.active and isinstance(self.state.water.get(""), Flow):
            raise refuse(head, f"phase '{name}' changes bodies with groundwater flow: repeat *WATER LEVEL, TYPE=SEEPAGE in it")
        phase = Phase(name, self.state, start, factor, head.value("TYPE") == "SAFETY", self.flow, self.pushed, self.initial, self.moved)
        self.done[name] = phase
        return phase

    def take(self, card: Card) -> None:
        """A keyword of a phase."""
        words: dict[str, Callable[[Card], None]] = {
            "FIX": self.fix, "PRESCRIBE": self.prescribe, "GRAVITY": self.gravity, "TRACTION": self.traction, "PRESSURE": self.pressure,
            "WATER LEVEL": self.level, "SUPPORT": self.support, "ACTIVATE": self.activate, "DEACTIVATE": self.deactivate,
            "CHANGE MATERIAL": self.change, "SAFETY": self.safety, "INITIAL": self.stresses, "MOVE": self.move,
            "INSTALL": self.install, "REMOVE": self.remove,
        }  # fmt: skip
        if card.keyword in words:
            words[card.keyword](card)
        elif card.keyword not in PASSED:
            raise refuse(card, "not supported by limit analysis")

    def known(self, card: Card, name: str, table: Container[str]) -> str:
        """A name that must be defined."""
        if name not in table:
            raise refuse(card, f"'{name}' is not defined")
        return name

    def fix(self, card: Card) -> None:
        """Constrained components of node sets."""
        for row in card.data():
            name = self.known(card, row[0].strip('"'), self.reader.sets)
            held = self.state.held.get(name, "")
            for word in map(plain, row[1:]):
                held = "" if word == "FREE" else "XY" if word == "ALL" else "".join(sorted(set(held + word) & set("XY")))
            self.state.held[name] = held

    def prescribe(self, card: Card) -> None:
        """Displacement-controlled components of node sets: constrained, and the limit is that of the reaction force."""
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
        """A pressure on a surface, or a water pressure on it."""
        name = self.known(card, name_of(card, "SURFACE"), self.reader.surfaces)
        if card.value("LEVEL") is not None:
            gradient = self.factor * float(card.value("UNIT WEIGHT") or "nan")
            self.state.pushes[name] = Push(0.0, gradient, float(card.value("LEVEL") or "nan"), True)
        else:
            p, gradient, y = (numbers(card, card.data()[0], 1, 3) + [0.0, 0.0])[:3]
            self.state.pushes[name] = Push(self.factor * p, self.factor * gradient, y, False)

    def level(self, card: Card) -> None:
        """Groundwater and free water."""
        only(card, TYPE=("LINE", "NONE", "SEEPAGE"))
        body = name_of(card, "BODY") if card.value("BODY") is not None else ""
        if card.value("TYPE") == "NONE":
            self.state.water[body] = None
        elif card.value("TYPE") == "SEEPAGE":
            self.flowing = card
        else:
            corners = np.array([numbers(card, row, 2, 2) for row in card.data()])
            self.state.water[body] = Level(corners, float(card.value("UNIT WEIGHT") or "nan"))

    def support(self, card: Card) -> None:
        """A constrained surface."""
        only(card, TYPE=("FREE", "NORMAL", "ALL"))
        self.state.supports[self.known(card, name_of(card, "SURFACE"), self.reader.surfaces)] = card.value("TYPE") or "NORMAL"

    def activate(self, card: Card) -> None:
        """Activated bodies, in their initial geometry."""
        names = {self.known(card, row[0].strip('"'), self.reader.bodies) for row in card.data()}
        self.state = replace(self.state, active=self.state.active | names)

    def deactivate(self, card: Card) -> None:
        """Deactivated bodies."""
        names = {self.known(card, row[0].strip('"'), self.reader.bodies) for row in card.data()}
        self.state = replace(self.state, active=self.state.active - names)

    def install(self, card: Card) -> None:
        """Activated props: prestress does not change the limit."""
        names = {self.known(card, row[0].strip('"'), self.reader.props) for row in card.data()}
        self.state = replace(self.state, props=self.state.props | names)

    def remove(self, card: Card) -> None:
        """Deactivated props."""
        names = {self.known(card, row[0].strip('"'), self.reader.props) for row in card.data()}
        self.state = replace(self.state, props=self.state.props - names)

    def change(self, card: Card) -> None:
        """Bodies with another material."""
        for row in card.data():
            body = self.known(card, row[0].strip('"'), self.reader.bodies)
            self.state.materials[body] = self.known(card, row[1].strip('"'), self.reader.materials)

    def safety(self, card: Card) -> None:
        """The flow rule of a search for a factor of safety."""
        only(card, FLOW=("MATERIAL", "DAVIS A", "DAVIS B"))
        self.flow = card.value("FLOW") or "MATERIAL"

    def move(self, card: Card) -> None:
        """The motion of a rigid body in the phase."""
        body = self.known(card, name_of(card, "BODY"), self.reader.touching)
        if float(card.value("ROTATION") or 0.0) != 0.0:
            raise refuse(card, "bounds support bodies without rotation only")
        x, y = numbers(card, card.data()[0], 2, 2)
        self.moved[body] = (x, y)

    def stresses(self, card: Card) -> None:
        """Initial stresses do not change a limit load; the loads of their phase act from its start."""
        self.initial = card.value("TYPE") not in (None, "KEEP")


def phase_cards(deck: Deck) -> list[list[Card]]:
    """The keywords of each phase."""
    found: list[list[Card]] = []
    for card in deck.cards:
        if card.keyword == "PHASE":
            found.append([])
        if found:
            found[-1].append(card)
    return found


def unfailing(reader: Reader) -> dict[str, Material]:
    """The materials; those without a strength, such as concrete, get one that no load of the magnitude of the weight of the scene exhausts."""
    places = np.concatenate([np.asarray(body) for body in reader.bodies.values()])
    weight = max([material.weight for material in reader.materials.values()] + [material.saturated for material in reader.materials.values()])
    cohesion = max([material.strength.cohesion for material in reader.materials.values() if material.strength is not None] + [0.0])
    strong = Strength(UNFAILING * (weight * float(np.ptp(places, axis=0).max()) + cohesion), 0.0, 0.0, fails=False)
    return {name: material if material.strength else replace(material, strength=strong) for name, material in reader.materials.items()}


def read_scene(deck: Deck, asked: str | None = None, factor: bool = False) -> Scene:
    """The scene at a phase, default the last one; `factor` requests the factor of safety at its end."""
    reader = Reader(deck)
    phases, groups = Phases(reader), phase_cards(deck)
    names = [name_of(group[0], "NAME") for group in groups]
    if not names or (asked is not None and asked not in names):
        raise Trouble(f"{deck.path}: unknown phase {asked or ''}; known are {', '.join(names) or 'none'}")
    chosen = names.index(asked) if asked is not None else len(names) - 1
    phase = [phases.read(group) for group in groups[: chosen + 1]][-1]
    safety = phase.safety or factor
    if not safety and (phase.start.active != phase.state.active or phase.start.materials != phase.state.materials):
        raise Trouble(f"phase '{phase.name}': *ACTIVATE, *DEACTIVATE and *CHANGE MATERIAL are not loads; request its factor of safety (--factor)")
    used = {phase.state.materials[name] for name in phase.state.active}
    for name in sorted(used):
        if name not in reader.materials:
            raise Trouble(f"*BODY: material '{name}' is not defined")
        material = reader.materials[name]
        if material.refused:
            raise Trouble(f"{material.refused}: not supported by limit analysis")
    if all(reader.materials[name].strength is None for name in used):
        raise Trouble("no material has *MOHR COULOMB, so no body can fail")
    x, y = phase.state.gravity
    if (x != 0.0 or y > 0.0) and any(phase.state.water.values()):
        raise Trouble("*WATER LEVEL: bounds support water only if gravity is along -y; rotate the deck")
    start = phase.state if phase.initial else phase.start
    if reader.touching and safety:
        raise Trouble("*RIGID BODY: bounds support rigid bodies that a phase moves, not factors of safety with rigid bodies")
    fastest = max([abs(value) for value in phase.pushed.values()] + [float(np.hypot(*motion)) for motion in phase.moved.values()], default=1.0)
    walls = {name: replace(reader.walls[name], velocity=_over(phase.moved.get(name, (0.0, 0.0)), fastest)) for name in sorted(reader.touching)}
    pushed = {} if safety else {place: value / fastest for place, value in phase.pushed.items()}
    return Scene(
        {name: places for name, places in reader.bodies.items() if name in phase.state.active}, unfailing(reader), reader.surfaces,
        reader.sets, start, phase.state, phase.name, phase.factor, safety, phase.flow, pushed, reader.units,
        reader.steps, walls, tuple(prop for name, prop in reader.props.items() if name in phase.state.props), tuple(reader.said),
    )  # fmt: skip


def _over(motion: tuple[float, float], fastest: float) -> tuple[float, float]:
    """A motion divided by the largest one."""
    return (motion[0] / fastest, motion[1] / fastest) if fastest > 0.0 else motion
