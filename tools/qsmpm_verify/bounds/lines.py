"""Lines of the geometry intersected with each other: a plane graph whose edges meet only at their ends."""

from __future__ import annotations

import numpy as np

from qsmpm_verify.results import Array

# Places nearer than this share of the scene are one.
NEAR = 1e-7


def cross(a: Array, b: Array) -> Array:
    """Area spanned by vectors."""
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def inside(places: Array, outline: Array) -> Array:
    """Which points are inside a polygon."""
    x, y = places[:, 0][:, None], places[:, 1][:, None]
    a, b = outline, np.roll(outline, -1, axis=0)
    between = (a[:, 1] > y) != (b[:, 1] > y)
    with np.errstate(divide="ignore", invalid="ignore"):
        at = a[:, 0] + (y - a[:, 1]) * (b[:, 0] - a[:, 0]) / (b[:, 1] - a[:, 1])
    return np.asarray(np.sum(between & (x < at), axis=1) % 2 == 1)


def area_of(outline: Array) -> float:
    """Area of a polygon, counter-clockwise positive."""
    return float(np.sum(cross(outline, np.roll(outline, -1, axis=0))) / 2.0)


def closed(outline: Array) -> Array:
    """Edges of a polygon as pairs of ends."""
    return np.stack([outline, np.roll(outline, -1, axis=0)], axis=1)


def distance(places: Array, a: Array, b: Array) -> Array:
    """Distance of points (n, 2) from segments (m, 2): (n, m)."""
    along = b - a
    length = np.maximum(np.sum(along**2, axis=1), 1e-300)
    share = np.clip(((places[:, None] - a) * along).sum(-1) / length, 0.0, 1.0)
    foot = a + share[..., None] * along
    return np.asarray(np.linalg.norm(places[:, None] - foot, axis=-1))


def healed(outline: Array, others: list[Array], near: float) -> Array:
    """A polygon (n, 2) with its corners moved to those of others, or to their sides, where the distance is less than `near`, and with corners of
    others that are as near to its sides inserted: bodies whose outlines differ slightly are then in contact."""
    if not others:
        return outline
    corners, sides = np.vstack(others), np.vstack([closed(other) for other in others])
    along = sides[:, 1] - sides[:, 0]
    moved = []
    for place in outline:
        apart = np.linalg.norm(corners - place, axis=1)
        off = distance(place[None], sides[:, 0], sides[:, 1])[0]
        k = int(off.argmin())
        if apart.min() < near:
            place = corners[apart.argmin()]
        elif off[k] < near:
            place = sides[k, 0] + (place - sides[k, 0]) @ along[k] / (along[k] @ along[k]) * along[k]
        moved.append(place)
    kept: list[Array] = []
    for a, b in closed(np.array(moved)):
        between = corners[distance(corners, a[None], b[None])[:, 0] < near]
        between = between[np.minimum(np.linalg.norm(between - a, axis=1), np.linalg.norm(between - b, axis=1)) >= near]
        kept += [a, *between[np.argsort((between - a) @ (b - a))]]
    places = np.array(kept)
    return np.asarray(places[np.linalg.norm(places - np.roll(places, 1, axis=0), axis=1) > 0.0])


def crossings(segments: Array) -> Array:
    """Intersection points of segments."""
    a, d = segments[:, 0], segments[:, 1] - segments[:, 0]
    turn = cross(d[:, None], d[None])
    length = np.linalg.norm(d, axis=1)
    apart = a[None] - a[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        s = cross(apart, d[None]) / turn
        t = cross(apart, d[:, None]) / turn
    meet = (np.abs(turn) > 1e-9 * length[:, None] * length) & (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1)
    i, j = np.nonzero(np.triu(meet, 1))
    return np.asarray(a[i] + s[i, j][:, None] * d[i])


def merged(places: Array, near: float) -> tuple[Array, Array]:
    """Points without duplicates, and the number of each point among them."""
    kept: list[int] = []
    number = np.empty(len(places), dtype=int)
    for k, place in enumerate(places):
        apart = np.abs(places[kept] - place).max(axis=1) if kept else np.empty(0)
        hit = int(np.argmin(apart)) if len(apart) else -1
        if hit >= 0 and apart[hit] <= near:
            number[k] = hit
        else:
            number[k] = len(kept)
            kept.append(k)
    return places[kept], number


def plane_graph(segments: Array, further: Array) -> tuple[Array, Array]:
    """Corners and edges of segments (n, 2, 2), divided where they intersect and at further points on them."""
    size = float(np.ptp(segments.reshape(-1, 2), axis=0).max())
    near = NEAR * size
    segments = segments[np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1) > near]
    candidates = np.vstack([segments.reshape(-1, 2), crossings(segments)])
    corners, _ = merged(candidates, near)
    if len(further):
        on = distance(further, segments[:, 0], segments[:, 1]).min(axis=1) <= near
        corners, _ = merged(np.vstack([corners, further[on]]), near)
    edges: set[tuple[int, int]] = set()
    away = distance(corners, segments[:, 0], segments[:, 1])
    for k, (a, b) in enumerate(segments):
        on_it = np.flatnonzero(away[:, k] <= 2.0 * near)
        order = on_it[np.argsort((corners[on_it] - a) @ (b - a))]
        edges |= {(min(i, j), max(i, j)) for i, j in zip(order[:-1].tolist(), order[1:].tolist())}
    return corners, np.array(sorted(edges), dtype=int).reshape(-1, 2)
