"""The scene in its deformed geometry: outlines moved with the material points of a step written by a run.

An edge of an outline is divided into pieces of one cell length and where other bodies begin; each end moves by a linear fit of the displacements of the material points around it, of any
body, so that bodies in contact remain in contact. Points on planes of constrained nodes remain on them. Vertices that change the outline negligibly are removed.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from qsmpm_verify.bounds.lines import distance
from qsmpm_verify.bounds.scene import Scene
from qsmpm_verify.results import Array, read_points
from qsmpm_verify.study.cards import Deck
from qsmpm_verify.trouble import Trouble

# Points that a fit takes, and by how much of a cell an outline may be off where a vertex is left out.
AROUND, SLACK = 12, 0.02
# Share of a cell from which on the ground lies on a plane that is held.
REACH = 0.25
NEAR = 1e-6


def pieces(a: Array, b: Array, size: float) -> Array:
    """Points from one end of a line to the other, at most one size apart."""
    count = max(1, int(np.ceil(np.linalg.norm(b - a) / size - NEAR)))
    return np.asarray(a + np.arange(count + 1)[:, None] / count * (b - a))


def broken(outline: Array, corners: Array, near: float) -> list[tuple[Array, Array]]:
    """The edges of an outline, divided where corners of other bodies are on them."""
    found = []
    for a, b in zip(outline, np.roll(outline, -1, axis=0)):
        on = corners[distance(corners, a[None], b[None])[:, 0] <= near]
        along = np.unique(np.round(np.append(on @ (b - a) - a @ (b - a), [0.0, (b - a) @ (b - a)]) / ((b - a) @ (b - a)), 9))
        ends = [a if t <= NEAR else b if t >= 1.0 - NEAR else on[np.argmin(np.abs((on - a) @ (b - a) / ((b - a) @ (b - a)) - t))] for t in along]
        found += [(c, d) for c, d in zip(ends[:-1], ends[1:]) if np.linalg.norm(d - c) > near]
    return found


def displacements(places: Array, start: Array, moved: Array) -> Array:
    """Displacements of positions from the surrounding points: a linear function fitted to the nearest ones."""
    count = min(AROUND, len(start))
    if count < 3:
        raise Trouble("the step has too few material points to move an outline")
    apart, nearest = cKDTree(start).query(places, k=count)
    found = np.zeros_like(places)
    for i, place in enumerate(places):
        weight = 1.0 / (apart[i] + apart[i].mean())
        base = np.column_stack([np.ones(count), start[nearest[i]] - place]) * weight[:, None]
        found[i] = np.linalg.lstsq(base, moved[nearest[i]] * weight[:, None], rcond=None)[0][0]
    return found


def thinned(line: Array, slack: float) -> Array:
    """The line without points that are nearer than the tolerance to the straight line between the remaining ones (Douglas and Peucker 1973)."""
    kept, spans = {0, len(line) - 1}, [(0, len(line) - 1)]
    while spans:
        first, last = spans.pop()
        if last - first < 2:
            continue
        off = distance(line[first + 1 : last], line[first : first + 1], line[last : last + 1])[:, 0]
        worst = int(np.argmax(off))
        if off[worst] > slack:
            kept.add(first + 1 + worst)
            spans += [(first, first + 1 + worst), (first + 1 + worst, last)]
    return np.asarray(line[sorted(kept)])


def deformed(scene: Scene, deck: Deck, folder: Path, step: int | None) -> Scene:
    """The scene with the outlines of a written step, default the last one."""
    if scene.walls:
        raise Trouble("--run: bounds of the deformed geometry do not support rigid bodies")
    if deck.find("RESET DISPLACEMENTS"):
        raise Trouble("--run: *RESET DISPLACEMENTS: the initial geometry is no longer known")
    for state in (scene.before, scene.after):
        for name in {*state.tractions, *state.pushes, *state.supports}:
            surface = scene.surfaces[name]
            if surface.kind != "OUTLINE" or np.all(np.isfinite(surface.places)):
                raise Trouble(f"--run: *SURFACE, NAME={name}: the deformed geometry supports loads on whole outlines only")
    points = read_points(folder, step)
    moved = points.field("displacement")[:, :2]
    start = points.field("position")[:, :2] - moved
    size = float(np.mean([np.diff(lines).mean() for lines in scene.steps]))
    every = np.vstack(list(scene.bodies.values()))

    def side(a: Array, b: Array) -> Array:
        """The deformed edge without its last point; identical from both sides."""
        turned = tuple(b) < tuple(a)
        places = pieces(b, a, size) if turned else pieces(a, b, size)
        line = thinned(places + held_back(places, displacements(places, start, moved), scene, size), SLACK * size)
        return line[::-1][:-1] if turned else line[:-1]

    bodies = {name: np.vstack([side(a, b) for a, b in broken(outline, every, NEAR * size)]) for name, outline in scene.bodies.items()}
    return replace(scene, bodies=bodies)


def held_back(places: Array, shift: Array, scene: Scene, size: float) -> Array:
    """Displacements of points; points that reach the planes of constrained nodes, or were on them, are on these planes."""
    for name, held in scene.after.held.items():
        low, high = scene.sets[name]
        for axis in (k for k in range(2) if "XY"[k] in held and low[k] == high[k]):
            beside = np.minimum(np.abs(places[:, axis] + shift[:, axis] - low[axis]), np.abs(places[:, axis] - low[axis]) / NEAR * REACH)
            shift[beside <= REACH * size, axis] = (low[axis] - places[:, axis])[beside <= REACH * size]
    return shift
