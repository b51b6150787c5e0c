"""The scene of limit analysis: bodies, strengths, and loads, water and supports at both ends of a phase."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from qsmpm_verify.bounds.strength import Strength
from qsmpm_verify.results import Array


@dataclass(frozen=True)
class Surface:
    """SEGMENT: pieces of start and end. BOX: lower and upper corner. OUTLINE: of a body, or of the part inside the box if there is one."""

    kind: str
    places: Array
    body: str = ""


@dataclass(frozen=True)
class Push:
    """A pressure that increases downwards from a height, not negative if it is a water pressure."""

    value: float
    gradient: float
    height: float
    water: bool


@dataclass(frozen=True)
class Level:
    """A water level: its corners, the unit weight of water."""

    corners: Array
    weight: float

    def at(self, places: Array) -> Array:
        """Its height at positions."""
        return np.asarray(np.interp(places[..., 0], *self.corners.T))

    def lines(self, outlines: Array) -> Iterable[Array]:
        """The level from end to end of the outlines, and verticals downwards from its corners."""
        low, high = outlines.min(axis=(0, 1)), outlines.max(axis=(0, 1))
        every = np.unique(np.concatenate([np.clip(self.corners[:, 0], low[0], high[0]), [low[0], high[0]]]))
        heights = np.interp(every, self.corners[:, 0], self.corners[:, 1])
        line = np.stack([every, heights], 1)
        yield np.stack([line[:-1], line[1:]], axis=1)
        for place in line[1:-1]:
            yield np.array([[place, (place[0], min(low[1], place[1]))]])


@dataclass(frozen=True)
class Prop:
    """A spring between two points, or between a point and a fixed one; largest compression and tension."""

    ends: Array
    fixed: bool
    limits: tuple[float, float]


@dataclass(frozen=True)
class State:
    """Loads and constraints at the end of a phase."""

    gravity: tuple[float, float] = (0.0, 0.0)
    tractions: dict[str, tuple[float, float]] = field(default_factory=dict)
    pushes: dict[str, Push] = field(default_factory=dict)
    water: dict[str, Level | None] = field(default_factory=dict)
    held: dict[str, str] = field(default_factory=dict)
    supports: dict[str, str] = field(default_factory=dict)
    active: frozenset[str] = frozenset()
    materials: dict[str, str] = field(default_factory=dict)
    props: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Material:
    """Strength and unit weights of a material; `refused` is the keyword that limit analysis does not support."""

    strength: Strength | None = None
    weight: float = 0.0
    saturated: float = 0.0
    refused: str = ""


@dataclass(frozen=True)
class Wall:
    """A rigid body in contact: its sides as pieces of start and end with the body on their left, the soil surface that may be in contact with it
    (empty: any), tangent of friction and adhesion, or the share of the soil strength that defines both; its velocity."""

    sides: Array
    surface: str = ""
    friction: float = 0.0
    adhesion: float = 0.0
    share: float | None = None
    velocity: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True)
class Scene:
    """A deck at one of its phases: the ground, the loads before and after, and the requested result."""

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
    """Grid lines along x and y."""
    walls: dict[str, Wall] = field(default_factory=dict)
    props: tuple[Prop, ...] = ()
    said: tuple[str, ...] = ()
    """Notes on data that were interpreted differently from the deck."""

    @property
    def pushes(self) -> bool:
        """Whether nodes or rigid bodies have a prescribed motion: the result is then the force on them."""
        return bool(self.pushed) or any(wall.velocity != (0.0, 0.0) for wall in self.walls.values())
