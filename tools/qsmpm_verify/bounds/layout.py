"""The lines of a scene that edges of triangles follow, and the initial triangles.

Weight, pore pressure, cohesion, loads and supports are then linear or constant on every triangle and edge, so that the bounds are rigorous: outlines,
water levels and the verticals through their corners, levels of strength profiles, constrained planes, ends of loads.
"""

from __future__ import annotations

import math

import numpy as np

from qsmpm_verify.bounds.lines import area_of, closed, crossings, inside, plane_graph
from qsmpm_verify.bounds.scene import Scene, State
from qsmpm_verify.bounds.words import rectangle
from qsmpm_verify.bounds.triangles import Triangles, triangulate
from qsmpm_verify.results import Array
from qsmpm_verify.trouble import Trouble


def extent_of(scene: Scene) -> tuple[Array, Array]:
    """Lower and upper corner of the ground."""
    every = np.vstack(list(scene.bodies.values()))
    return every.min(axis=0), every.max(axis=0)


def body_of(scene: Scene, places: Array) -> Array:
    """Number of the body that contains each point, -1 outside; overlapping bodies are an error."""
    found = np.full(len(places), -1)
    for number, (name, outline) in enumerate(scene.bodies.items()):
        own = inside(places, outline)
        if np.any(own & (found >= 0)):
            other = list(scene.bodies)[int(found[own & (found >= 0)][0])]
            raise Trouble(f"*BODY, NAME={name}: overlaps '{other}'")
        found[own] = number
    return found


def _pieces(low: Array, high: Array, ends: tuple[Array, Array]) -> Array:
    """Sides of a box within the scene; planes and lines have one."""
    low, high = np.maximum(low, ends[0]), np.minimum(high, ends[1])
    if np.any(low > high):
        return np.empty((0, 2, 2))
    if np.any(low == high):
        return np.array([[low, high]])
    return closed(rectangle(low, high))


def _inner_lines(scene: Scene, outlines: Array) -> list[Array]:
    """All lines except the outlines."""
    ends = extent_of(scene)
    found: list[Array] = [_pieces(*scene.sets[name], ends) for name, held in scene.after.held.items() if held]
    for state in (scene.before, scene.after):
        for level in state.water.values():
            if level is not None:
                found += level.lines(outlines)
    for name in scene.bodies:
        strength = scene.materials[scene.after.materials[name]].strength
        assert strength is not None
        for at in strength.levels():
            low, high = ends[0].copy(), ends[1].copy()
            if low[strength.axis] < at < high[strength.axis]:
                low[strength.axis] = high[strength.axis] = at
                found.append(np.array([[low, high]]))
    return found


def _ends_of_loads(scene: Scene, outlines: Array) -> Array:
    """Points on outlines where a load or support begins."""
    ends = extent_of(scene)
    found: list[Array] = [np.empty((0, 2))]
    state: State
    for state in (scene.before, scene.after):
        for name in {*state.tractions, *state.pushes, *state.supports}:
            surface = scene.surfaces[name]
            if surface.kind == "SEGMENT":
                found.append(surface.places.reshape(-1, 2))
            else:
                sides = _pieces(surface.places[0], surface.places[1], ends)
                found += [sides.reshape(-1, 2), crossings(np.vstack([sides, outlines]))]
        for wall in scene.walls.values():
            found += [wall.sides.reshape(-1, 2), crossings(np.vstack([wall.sides, outlines]))]
        for push in state.pushes.values():
            level = np.array([[(ends[0][0], push.height), (ends[1][0], push.height)]])
            found.append(crossings(np.vstack([level, outlines])))
    return np.vstack(found)


def first_triangles(scene: Scene, count: int) -> Triangles:
    """A triangulation of about the given number of triangles, or more where the geometry requires it."""
    outlines = np.vstack([closed(outline) for outline in scene.bodies.values()])
    area = sum(area_of(outline) for outline in scene.bodies.values())
    size = math.sqrt(area / count * 4.0 / math.sqrt(3.0)) * 1.1
    corners, edges = plane_graph(np.vstack([outlines, *_inner_lines(scene, outlines)]), _ends_of_loads(scene, outlines))
    middle = corners[edges].mean(axis=1)
    along = corners[edges[:, 1]] - corners[edges[:, 0]]
    aside = 1e-4 * np.stack([-along[:, 1], along[:, 0]], 1)
    used = edges[(body_of(scene, middle + aside) >= 0) | (body_of(scene, middle - aside) >= 0)]
    kept, numbers = np.unique(used, return_inverse=True)
    mesh = triangulate(corners[kept], numbers.reshape(-1, 2), lambda places: body_of(scene, places) >= 0, size)
    areas, own = mesh.areas(), body_of(scene, mesh.places[mesh.corners].mean(axis=1))
    for number, (name, outline) in enumerate(scene.bodies.items()):
        if abs(areas[own == number].sum() / area_of(outline) - 1.0) > 1e-6:
            raise Trouble(f"*BODY, NAME={name}: no triangular mesh can be generated inside its outline; does it intersect itself?")
    return mesh
