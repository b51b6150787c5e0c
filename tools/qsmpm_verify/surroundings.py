"""Objects beside the material points of a state: rigid bodies in their position, contact pressures, water levels."""

from __future__ import annotations

from dataclasses import dataclass, field

import h5py
import numpy as np

Array = np.ndarray

# A side of a body is flat that is so many times as long as a surface point; one belongs to it that is not further from it
# than so many times its length, with its normal turned by less than 60 degrees.
FLAT = 4.0
BESIDE = 2.0
TURNED = 0.5


@dataclass(frozen=True)
class RigidBody:
    """A body in its position: corners in the plane, counter-clockwise; a point and the normal of a plane; a sphere in 3D."""

    outline: Array | None = None
    plane: Array | None = None
    ball: Array | None = None

    def area(self, reach: float) -> Array | None:
        """Corners of its visible part in the plane, (n, 2); for a plane the part within a distance behind it."""
        if self.outline is None:
            return None
        if self.plane is None:
            return self.outline[:, :2]
        back = self.outline[::-1, :2] - reach * self.plane[1, :2]
        return np.concatenate([self.outline[:, :2], back])

    def upright(self, places: Array, normals: Array, extent: float) -> Array:
        """Normals of the soil (n, 2), on flat sides those of the side at each position: at a rounded corner the soil normal deviates."""
        if self.outline is None or len(self.outline) < 2:
            return normals
        first = self.outline[:, :2]
        along = np.roll(first, -1, axis=0) - first
        length = np.linalg.norm(along, axis=1)
        flat = length >= FLAT * extent
        if not flat.any():
            return normals
        first, along = first[flat], along[flat] / length[flat, None]
        way = places[:, None, :] - first
        share = np.clip(np.einsum("pfj,fj->pf", way, along), 0.0, length[flat])
        distance = np.linalg.norm(way - share[..., None] * along, axis=2)
        across = np.stack([-along[:, 1], along[:, 0]], axis=1)
        aligned = normals @ across.T
        fit = np.where(distance <= BESIDE * extent, np.abs(aligned), 0.0)
        side, row = fit.argmax(axis=1), np.arange(len(places))
        found = np.sign(aligned[row, side])[:, None] * across[side]
        return np.where((fit[row, side] > TURNED)[:, None], found, normals)


@dataclass(frozen=True)
class Surroundings:
    """All objects; contacts by their names in results.h5, one row for each surface point; corners of water levels (n, 3)."""

    bodies: tuple[RigidBody, ...] = ()
    contacts: dict[str, Array] = field(default_factory=dict)
    water: tuple[Array, ...] = ()

    @property
    def pressure(self) -> float:
        """Largest pressure of a contact, 0 without contact."""
        return float(self.contacts["pressure"].max(initial=0.0)) if self.contacts else 0.0

    def bars(self, scale: float) -> Array:
        """Bars of the pressure along the surface, (n, 4 corners, 2): from the soil into the body, with length `scale` for unit pressure.

        Their direction is the mean normal over the length of the longest bar to either side, less towards the
        ends: at a corner they neither cross nor diverge. Beside a flat side of the body the normal is that of the side.
        """
        if not self.contacts:
            return np.zeros((0, 4, 2))
        rows = np.flatnonzero(self.contacts["pressure"] > 0)
        owner = self.contacts.get("body", np.zeros(len(self.contacts["pressure"])))[rows]
        bars = np.zeros((len(rows), 4, 2))
        for body in np.unique(owner):
            mine = np.flatnonzero(owner == body)
            mine = mine[chain(self.contacts["position"][rows[mine], :2])]
            number = int(body) - 1
            bars[mine] = self._bars_of(rows[mine], scale, self.bodies[number] if 0 <= number < len(self.bodies) else RigidBody())
        return bars

    def _bars_of(self, rows: Array, scale: float, body: RigidBody) -> Array:
        """Points in contact with one body, in their order along the surface."""
        place, out, extent = self.contacts["position"][rows, :2], self.contacts["normal"][rows, :2], self.contacts["extent"][rows]
        height = scale * self.contacts["pressure"][rows]
        last = np.cumsum(extent)
        middle = last - 0.5 * extent
        half = 0.5 * extent[:, None] * np.stack([-out[:, 1], out[:, 0]], axis=1)
        way = np.gradient(place, axis=0) if len(rows) > 1 else half
        forth = np.where(np.sum(way * half, axis=1) < 0, -0.5, 0.5) * extent
        out = body.upright(place, out, float(extent.max()))
        feet, tops = [], []
        for sign in (-1, 1):
            along = middle + sign * forth
            reach = np.minimum(height.max(), np.minimum(along, last[-1] - along)) + 0.51 * extent.max()
            mean = (np.abs(along[:, None] - middle) <= reach[:, None]) @ (out * extent[:, None])
            feet.append(place + sign * half)
            tops.append(feet[-1] + height[:, None] * mean / np.maximum(np.linalg.norm(mean, axis=1, keepdims=True), 1e-300))
        return np.stack([feet[0], feet[1], tops[1], tops[0]], axis=1)


def chain(places: Array) -> Array:
    """Order of points along their line, from the end with the smaller x + y: the next one is the nearest remaining point."""
    first = int(np.argmax(np.linalg.norm(places - places.mean(axis=0), axis=1)))
    other = int(np.argmax(np.linalg.norm(places - places[first], axis=1)))
    order = [first if places[first].sum() <= places[other].sum() else other]
    left = np.ones(len(places), dtype=bool)
    left[order[0]] = False
    while left.any():
        rest = np.flatnonzero(left)
        order.append(int(rest[np.argmin(np.linalg.norm(places[rest] - places[order[-1]], axis=1))]))
        left[order[-1]] = False
    return np.array(order)


NOTHING = Surroundings()


def _body(group: h5py.Group) -> RigidBody:
    """One body."""
    return RigidBody(*(group[name][...] if name in group else None for name in ("outline", "plane", "ball")))


def read_surroundings(step: h5py.Group) -> Surroundings:
    """Data of the group of a step; empty if it has none."""
    bodies, contacts, water = (step.get(name, {}) for name in ("rigid_bodies", "contacts", "water"))
    return Surroundings(
        tuple(_body(bodies[name]) for name in sorted(bodies)),
        {name: contacts[name][...] for name in contacts},
        tuple(water[name][...] for name in sorted(water)),
    )
