"""The scene on triangles: weights, pressures and supports at both ends of a phase, and the cohesion, which is linear on each triangle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from qsmpm_verify.bounds.layout import body_of, extent_of
from qsmpm_verify.bounds.lines import distance
from qsmpm_verify.bounds.scene import Prop, Scene, State, Surface, Wall
from qsmpm_verify.bounds.strength import Strength
from qsmpm_verify.bounds.triangles import Triangles, numbered_edges
from qsmpm_verify.results import Array
from qsmpm_verify.trouble import Trouble

# Places nearer to a line than this share of the scene lie on it.
ON = 1e-6


@dataclass(frozen=True)
class Loads:
    """Weight per volume of triangles, pore pressure at their corners, tractions at both ends of edges."""

    weight: Array
    pore: Array
    traction: Array

    def __sub__(self, other: Loads) -> Loads:
        return Loads(self.weight - other.weight, self.pore - other.pore, self.traction - other.traction)

    def stress(self, size: float) -> float:
        """Magnitude of the stresses that the loads cause in a body of a given size."""
        return max(float(np.abs(self.weight).max(initial=0.0)) * size, float(np.abs(self.pore).max()), float(np.abs(self.traction).max()))

    def largest(self) -> float:
        """Magnitude of the loads; zero without loads."""
        return max(float(np.abs(part).max(initial=0.0)) for part in (self.weight, self.pore, self.traction))


@dataclass(frozen=True)
class Model:
    """Triangles with their gradients, edges, strengths, loads before and after, supports.

    `number` are the edges of a triangle, `sides` the triangles of an edge (-1: none), `normal` points out of the first. `held` counts the
    constrained directions of an edge, `direction` is the direction if there is one; `pushed` is its velocity, or that of the rigid body in contact
    (`touching`); `joint` contains tangent of friction and adhesion there, at both ends."""

    mesh: Triangles
    area: Array
    edges: Array
    number: Array
    sides: Array
    normal: Array
    length: Array
    material: Array
    strengths: list[Strength]
    cohesion: Array
    before: Loads
    after: Loads
    held: Array
    direction: Array
    pushed: Array
    touching: Array
    joint: Array
    props: tuple[Prop, ...] = ()

    def gradients(self) -> Array:
        """Gradients of the three linear functions of each triangle: (n, 3, 2)."""
        x, y = np.moveaxis(self.mesh.places[self.mesh.corners], 2, 0)
        b = np.stack([y[:, (k + 1) % 3] - y[:, (k + 2) % 3] for k in range(3)], 1)
        c = np.stack([x[:, (k + 2) % 3] - x[:, (k + 1) % 3] for k in range(3)], 1)
        return np.asarray(np.stack([b, c], 2) / (2.0 * self.area)[:, None, None])

    def free_axes(self) -> list[tuple[Array, Array]]:
        """Edges and unit vectors of their free directions: both axes of unconstrained edges, one of those constrained in one direction."""
        free, one = np.flatnonzero((self.held == 0) & ~self.touching), np.flatnonzero(self.held == 1)
        unit = np.eye(2)
        turned = np.stack([-self.direction[one, 1], self.direction[one, 0]], 1)
        return [(free, np.tile(unit[0], (len(free), 1))), (free, np.tile(unit[1], (len(free), 1))), (one, turned)]


def _triangles_of(number: Array, edges: int) -> Array:
    """Triangles on both sides of each edge; the second is -1 on the boundary."""
    sides = np.full((edges, 2), -1)
    flat = number.ravel()
    order = np.argsort(flat, kind="stable")
    first = np.searchsorted(flat[order], np.arange(edges))
    last = np.searchsorted(flat[order], np.arange(edges), side="right") - 1
    sides[:, 0] = order[first] // 3
    sides[:, 1] = np.where(last > first, order[last] // 3, -1)
    return sides


class _Placed:
    """Triangles of a scene with the bodies they belong to and the loaded faces."""

    def __init__(self, scene: Scene, mesh: Triangles) -> None:
        self.scene, self.mesh = scene, mesh
        self.edges, self.number = numbered_edges(mesh.corners)
        self.sides = _triangles_of(self.number, len(self.edges))
        low, high = extent_of(scene)
        self.near = ON * float((high - low).max())
        self.body = body_of(scene, mesh.places[mesh.corners].mean(axis=1))
        self.names = list(scene.bodies)
        self.ends = mesh.places[self.edges]
        along = self.ends[:, 1] - self.ends[:, 0]
        self.length = np.linalg.norm(along, axis=1)
        normal = np.stack([along[:, 1], -along[:, 0]], 1) / self.length[:, None]
        centre = mesh.places[mesh.corners[self.sides[:, 0]]].mean(axis=1)
        inwards = np.sum((centre - self.ends[:, 0]) * normal, axis=1) > 0
        self.normal = np.where(inwards[:, None], -normal, normal)
        self.outer = self.sides[:, 1] < 0

    def in_box(self, low: Array, high: Array) -> Array:
        """Edges with both ends in a box."""
        return np.asarray(np.all((self.ends >= low - self.near) & (self.ends <= high + self.near), axis=(1, 2)))

    def on(self, name: str) -> Array:
        """Boundary edges on a surface."""
        surface: Surface = self.scene.surfaces[name]
        if surface.kind == "SEGMENT":
            a, b = surface.places[:, 0], surface.places[:, 1]
            close = (distance(self.ends.reshape(-1, 2), a, b) <= self.near).reshape(-1, 2, len(a)).all(axis=1)
            ahead = b - a
            right = np.stack([ahead[:, 1], -ahead[:, 0]], 1)
            found = self.outer & np.any(close & (self.normal @ right.T > 0), axis=1)
        else:
            found = self.in_box(surface.places[0], surface.places[1])
            if surface.kind == "OUTLINE":
                if surface.body not in self.names:
                    raise Trouble(f"*SURFACE, NAME={name}: body '{surface.body}' is not active in this phase")
                own = self.body[self.sides] == self.names.index(surface.body)
                own[self.outer, 1] = False
                found &= own[:, 0] ^ own[:, 1]
                if np.any(found & ~self.outer):
                    raise Trouble(f"*SURFACE, NAME={name}: part of it is between two bodies; bounds support loads on outer faces only")
            found &= self.outer
        if not found.any():
            raise Trouble(f"*SURFACE, NAME={name}: it contains no outer face of the bodies")
        return found

    def pore(self, state: State) -> Array:
        """Pore pressure at the corners of triangles."""
        found = np.zeros(self.mesh.corners.shape)
        places = self.mesh.places[self.mesh.corners]
        for number, name in enumerate(self.names):
            level = state.water.get(name, state.water.get(""))
            if level is not None:
                own = self.body == number
                depth = level.at(places[own]) - places[own, :, 1]
                depth[np.abs(depth) < self.near] = 0.0
                found[own] = level.weight * abs(state.gravity[1]) * np.maximum(depth, 0.0)
        return found

    def loads(self, state: State) -> Loads:
        """Loads of a state; inactive bodies have none."""
        pore = self.pore(state)
        weight = np.zeros((len(self.body), 2))
        for number, name in enumerate(self.names):
            if name in state.active:
                own = self.body == number
                material = self.scene.materials[state.materials[name]]
                level = state.water.get(name, state.water.get(""))
                middle = self.mesh.places[self.mesh.corners[own]].mean(axis=1)
                wet = np.zeros(len(middle), bool) if level is None else middle[:, 1] < level.at(middle)
                weight[own] = np.where(wet, material.saturated, material.weight)[:, None] * np.array(state.gravity)
            elif name in self.scene.before.active or name in self.scene.after.active:
                pore[self.body == number] = 0.0
        return Loads(weight, pore, self.tractions(state, pore))

    def tractions(self, state: State, pore: Array) -> Array:
        """Tractions of dead loads, pressures and free water at both ends of edges; inner edges have none."""
        found = np.zeros((len(self.edges), 2, 2))
        for name, vector in state.tractions.items():
            found[self.on(name)] += np.array(vector)
        for name, push in state.pushes.items():
            edges = self.on(name)
            pressure = push.value + push.gradient * (push.height - self.ends[edges, :, 1])
            pressure = np.maximum(pressure, 0.0) if push.water else pressure
            found[edges] -= pressure[..., None] * self.normal[edges][:, None]
        first = self.sides[:, 0]
        for end in range(2):
            corner = np.argmax(self.mesh.corners[first] == self.edges[:, end][:, None], axis=1)
            free = np.where(self.outer, pore[first, corner], 0.0)
            found[:, end] -= free[:, None] * self.normal
        return found

    def supports(self) -> tuple[Array, Array, Array]:
        """Number of constrained directions of each edge, the direction if there is one, the prescribed velocity."""
        count = len(self.edges)
        first = np.zeros((count, 2))
        held = np.zeros(count, dtype=int)
        pushed = np.zeros((count, 2))

        def hold(edges: Array, direction: Array) -> None:
            """Add a constrained direction."""
            parallel = np.abs(first[:, 0] * direction[:, 1] - first[:, 1] * direction[:, 0]) < 1e-9
            held[edges & (held == 1) & ~parallel] = 2
            new = edges & (held == 0)
            first[new] = direction[new]
            held[new] = 1

        for name, axes in self.scene.after.held.items():
            edges = self.in_box(*self.scene.sets[name])
            for axis in axes:
                unit = np.eye(2)["XY".index(axis)]
                hold(edges, np.tile(unit, (count, 1)))
                pushed[edges, "XY".index(axis)] += self.scene.pushed.get((name, axis), 0.0)
        for name, kind in self.scene.after.supports.items():
            if kind != "FREE":
                edges = self.on(name)
                hold(edges, self.normal)
                if kind == "ALL":
                    hold(edges, np.stack([-self.normal[:, 1], self.normal[:, 0]], 1))
        return held, first, pushed


    def on_wall(self, wall: Wall) -> Array:
        """Boundary edges on the sides of a rigid body that face it."""
        a, b = wall.sides[:, 0], wall.sides[:, 1]
        close = (distance(self.ends.reshape(-1, 2), a, b) <= self.near).reshape(-1, 2, len(a)).all(axis=1)
        ahead = b - a
        right = np.stack([ahead[:, 1], -ahead[:, 0]], 1)
        found = self.outer & np.any(close & (self.normal @ right.T < 0), axis=1)
        return np.asarray(found & self.on(wall.surface) if wall.surface else found)


def touched(placed: _Placed, cohesion: Array, pore: Array, held: Array, pushed: Array) -> tuple[Array, Array]:
    """Edges in contact with rigid bodies, with tangent of friction and adhesion at both ends (edges, 2, 2); their velocity is stored in `pushed`."""
    touching, joint = np.zeros(len(held), dtype=bool), np.zeros((len(held), 2, 2))
    first = placed.sides[:, 0]
    for name, wall in placed.scene.walls.items():
        edges = placed.on_wall(wall)
        if not edges.any():
            raise Trouble(f"*RIGID BODY, NAME={name}: it is not in contact with a face of the bodies in their initial geometry")
        if np.any(edges & (held > 0)):
            raise Trouble(f"*RIGID BODY, NAME={name}: a face in contact with it is also constrained")
        for end in range(2):
            corner = np.argmax(placed.mesh.corners[first] == placed.edges[:, end][:, None], axis=1)
            if np.any(pore[first, corner][edges] > 0.0):
                raise Trouble(f"*RIGID BODY, NAME={name}: bounds do not support water behind rigid bodies")
            if wall.share is None:
                joint[edges, end] = wall.friction, wall.adhesion
            else:
                for number, of in enumerate(placed.names):
                    own = edges & (placed.body[first] == number)
                    strength = placed.scene.materials[placed.scene.after.materials[of]].strength
                    assert strength is not None
                    joint[own, end, 0] = wall.share * np.tan(np.radians(strength.friction))
                    joint[own, end, 1] = wall.share * cohesion[first, corner][own]
        pushed[edges] = wall.velocity
        touching |= edges
    return touching, joint


def model_of(scene: Scene, mesh: Triangles) -> Model:
    """The scene on triangles."""
    placed = _Placed(scene, mesh)
    names = sorted({scene.after.materials[name] for name in placed.names})
    strengths = []
    for name in names:
        strength = scene.materials[name].strength
        assert strength is not None
        strengths.append(strength)
    material = np.array([names.index(scene.after.materials[name]) for name in placed.names])[placed.body]
    places = mesh.places[mesh.corners]
    cohesion = np.zeros(mesh.corners.shape)
    for number, strength in enumerate(strengths):
        cohesion[material == number] = strength.cohesions(places[material == number])
    held, direction, pushed = placed.supports()
    after = placed.loads(scene.after)
    touching, joint = touched(placed, cohesion, after.pore, held, pushed)
    return Model(
        mesh, mesh.areas(), placed.edges, placed.number, placed.sides, placed.normal, placed.length, material, strengths, cohesion,
        placed.loads(scene.before), after, held, direction, pushed, touching, joint, scene.props,
    )  # fmt: skip
