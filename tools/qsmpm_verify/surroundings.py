"""What stands beside the material points of a state: rigid bodies in their pose, pressures on them, water levels."""

from __future__ import annotations

from dataclasses import dataclass, field

import h5py
import numpy as np

Array = np.ndarray


@dataclass(frozen=True)
class RigidBody:
    """A body where it is: corners in the plane, counter-clockwise; a point and the normal of a plane; a ball in space."""

    outline: Array | None = None
    plane: Array | None = None
    ball: Array | None = None

    def area(self, reach: float) -> Array | None:
        """Corners of what is seen of it in the plane, (n, 2); of a plane what is within a reach behind it."""
        if self.outline is None:
            return None
        if self.plane is None:
            return self.outline[:, :2]
        back = self.outline[::-1, :2] - reach * self.plane[1, :2]
        return np.concatenate([self.outline[:, :2], back])


@dataclass(frozen=True)
class Surroundings:
    """All of them; contacts by the names they have in results.h5, one row a surface point; corners of water levels (n, 3)."""

    bodies: tuple[RigidBody, ...] = ()
    contacts: dict[str, Array] = field(default_factory=dict)
    water: tuple[Array, ...] = ()

    @property
    def pressure(self) -> float:
        """Largest pressure of a contact, 0 where nothing is pressed."""
        return float(self.contacts["pressure"].max(initial=0.0)) if self.contacts else 0.0

    def bars(self, scale: float) -> Array:
        """Bars of the pressure along the surface, (n, 4 corners, 2): from the soil into the body, `scale` long a unit."""
        if not self.contacts:
            return np.zeros((0, 4, 2))
        pressed = self.contacts["pressure"] > 0
        place, out = self.contacts["position"][pressed, :2], self.contacts["normal"][pressed, :2]
        half = 0.5 * self.contacts["extent"][pressed, None] * np.stack([-out[:, 1], out[:, 0]], axis=1)
        top = scale * self.contacts["pressure"][pressed, None] * out
        return np.stack([place - half, place + half, place + half + top, place - half + top], axis=1)


NOTHING = Surroundings()


def _body(group: h5py.Group) -> RigidBody:
    """One body."""
    return RigidBody(*(group[name][...] if name in group else None for name in ("outline", "plane", "ball")))


def read_surroundings(step: h5py.Group) -> Surroundings:
    """What the group of a step tells; nothing where it has none."""
    bodies, contacts, water = (step.get(name, {}) for name in ("rigid_bodies", "contacts", "water"))
    return Surroundings(
        tuple(_body(bodies[name]) for name in sorted(bodies)),
        {name: contacts[name][...] for name in contacts},
        tuple(water[name][...] for name in sorted(water)),
    )
