"""Lower bound: stresses linear on each triangle, in equilibrium inside and across edges; they may jump along edges (Sloan 1988).

The cone constraints hold at the corners, and therefore everywhere if cohesion and pore pressure are linear. Equations at a corner may be dependent: around a
crossing of two straight lines one of eight is, and at corners of the outline. Dependent equations are omitted; where equations are inconsistent (a load that ends in
a triangle has two tractions at one place) the triangles there are bisected.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg
import scipy.sparse as sparse

from qsmpm_verify.bounds.cone import Balance
from qsmpm_verify.bounds.model import Loads, Model
from qsmpm_verify.bounds.props import columns_of, limits_of
from qsmpm_verify.bounds.rigid import Motions, bodies_of, motions_of
from qsmpm_verify.results import Array

# Pivots below this share of the largest are none.
SMALL = 1e-9


@dataclass(frozen=True)
class Traction:
    """Equations at ends of edges: positions of three or six coefficients, right-hand sides, the corner of the mesh they belong to."""

    columns: Array
    values: Array
    dead: Array
    live: Array
    corner: Array


def traction_part(model: Model, edges: Array, unit: Array, end: int, side: int) -> tuple[Array, Array]:
    """Columns and coefficients of the traction along unit vectors at an end of edges, in one of their triangles."""
    triangle = model.sides[edges, side]
    corner = np.argmax(model.mesh.corners[triangle] == model.edges[edges, end][:, None], axis=1)
    n = model.normal[edges]
    values = np.stack([(unit * n).sum(1), unit[:, 0] * n[:, 0] - unit[:, 1] * n[:, 1], unit[:, 0] * n[:, 1] + unit[:, 1] * n[:, 0]], 1)
    return 3 * (3 * triangle + corner)[:, None] + np.arange(3), values


def tractions(model: Model, before: Loads, live: Loads, body: Array) -> Traction:
    """Equations of all edges between soil triangles along the free directions."""
    parts: list[tuple[Array, Array, Array, Array, Array]] = []
    for edges, unit in model.free_axes():
        soil = (np.where(model.sides[edges] < 0, -1, body[model.sides[edges]]) < 0).all(axis=1)
        edges, unit = edges[soil], unit[soil]
        inner = model.sides[edges, 1] >= 0
        for end in range(2):
            columns, values = traction_part(model, edges, unit, end, 0)
            other, minus = traction_part(model, edges, unit, end, 1)
            minus = np.where(inner[:, None], -minus, 0.0)
            other = np.where(inner[:, None], other, columns)
            dead, more = ((unit * loads.traction[edges, end]).sum(1) for loads in (before, live))
            parts.append((np.hstack([columns, other]), np.hstack([values, minus]), dead, more, model.edges[edges, end]))
    columns, values, dead, more, corner = (np.concatenate(part) for part in zip(*parts))
    return Traction(columns, values, dead, more, corner)


def _local(traction: Traction, rows: Array) -> Array:
    """Dense equations at one corner, followed by both right-hand sides."""
    used, place = np.unique(traction.columns[rows], return_inverse=True)
    found = np.zeros((len(rows), len(used) + 2))
    place = place.reshape(len(rows), -1)
    for k in range(place.shape[1]):
        np.add.at(found, (np.arange(len(rows)), place[:, k]), traction.values[rows, k])
    found[:, -2], found[:, -1] = traction.dead[rows], traction.live[rows]
    return found


def independent(model: Model, traction: Traction, scale: tuple[float, float]) -> tuple[Array, Array]:
    """Equations to keep, and corners where equations are inconsistent; `scale` is the magnitude of both right-hand sides."""
    keep = np.ones(len(traction.corner), dtype=bool)
    torn: list[int] = []
    order = np.argsort(traction.corner, kind="stable")
    starts = np.searchsorted(traction.corner[order], np.arange(len(model.mesh.places) + 1))
    degree = np.bincount(model.edges.ravel(), minlength=len(model.mesh.places))
    special = np.zeros(len(model.mesh.places), dtype=bool)
    special[model.edges[(model.sides[:, 1] < 0) | (model.held > 0)].ravel()] = True
    for corner in np.flatnonzero(special | (degree == 4)):
        rows = order[starts[corner] : starts[corner + 1]]
        if len(rows) < 2:
            continue
        dense = _local(traction, rows)
        r, pivots = scipy.linalg.qr(dense[:, :-2].T, mode="r", pivoting=True)
        size = np.abs(np.diag(r))
        rank = int(np.sum(size > SMALL * size[0]))
        if rank == len(rows):
            continue
        kept, left = pivots[:rank], pivots[rank:]
        keep[rows[left]] = False
        weights = np.linalg.lstsq(dense[kept, :-2].T, dense[left, :-2].T, rcond=None)[0]
        miss = np.abs(dense[left, -2:] - weights.T @ dense[kept, -2:])
        if np.any(miss > 1e-6 * np.array(scale)):
            torn.append(int(corner))
    return keep, np.array(torn, dtype=int)


@dataclass(frozen=True)
class Resultants:
    """Equilibrium of bodies that do not fail, one equation for each motion: coefficients of the surrounding stresses, right-hand sides; the motions of each
    body and the first of its rows."""

    matrix: sparse.csr_matrix
    dead: Array
    live: Array
    motions: list[tuple[int, Motions]]


def resultants(model: Model, before: Loads, live: Loads, body: Array) -> Resultants:
    """Loads on the bodies, divided by the length of the scene."""
    rows, columns, values, motions = [], [], [], []
    sides: list[list[float]] = [[], []]
    first, whole = 0, float(np.ptp(model.mesh.places))
    there = np.where(model.sides < 0, -1, body[model.sides])
    ends = model.mesh.places[model.edges]
    for number in range(int(body.max(initial=-1)) + 1):
        own, border = body == number, (there == number).any(axis=1) & (there[:, 0] != there[:, 1])
        held = np.flatnonzero(border & (model.held > 0))
        axes = np.concatenate([model.direction[held]] + [np.where((model.held[held] == 2)[:, None], np.eye(2)[k], model.direction[held]) for k in range(2)])
        at = np.concatenate([np.tile(ends[held, end], (3, 1)) for end in range(2)])
        free = motions_of(model.mesh.places[model.mesh.corners[own]].reshape(-1, 2), at, np.tile(axes, (2, 1)))
        centres = model.mesh.places[model.mesh.corners[own]].mean(axis=1)
        for j, of in enumerate(free.at(centres)):
            edges = np.flatnonzero(border)
            a, b = free.at(ends[edges, 0])[j], free.at(ends[edges, 1])[j]
            shares = [model.length[edges, None] / 6.0 * part for part in (2.0 * a + b, a + 2.0 * b)]
            for place, loads in zip(sides, (before, live)):
                force = np.sum(loads.weight[own] * model.area[own, None] * of)
                outer = model.sides[edges, 1] < 0
                force += sum(float(np.sum((loads.traction[edges, end] * shares[end])[outer])) for end in range(2))
                place.append(-force / whole)
            for end in range(2):
                for side, sign in ((0, -1.0), (1, 1.0)):
                    soil = (there[edges, side] < 0) & (model.sides[edges, side] >= 0) & (there[edges, 1 - side] == number)
                    column, value = traction_part(model, edges[soil], shares[end][soil], end, side)
                    rows.append(np.full(column.size, first + j))
                    columns.append(column.ravel())
                    values.append(sign * value.ravel() / whole)
        motions.append((first, free))
        first += len(free.free)
    shape = (first, 9 * len(model.area))
    parts = [np.concatenate(part) if part else np.empty(0) for part in (values, rows, columns)]
    return Resultants(sparse.csr_matrix((parts[0], (parts[1].astype(int), parts[2].astype(int))), shape), np.array(sides[0]), np.array(sides[1]), motions)


def lower_balance(model: Model, before: Loads, live: Loads) -> tuple[Balance, Array]:
    """Equilibrium in triangles, across edges and of bodies that do not fail; the objective is the power of the prescribed velocities. Also the corners to be
    bisected, if any."""
    count, body = len(model.area), bodies_of(model, by_corners=False)
    slopes = model.gradients() * np.sqrt(model.area)[:, None, None]
    number = np.arange(count)
    rows, columns, values = [], [], []
    for k in range(3):
        x, y = slopes[:, k].T
        first = 3 * (3 * number + k)
        for row, column, value in ((2 * number, first, x), (2 * number, first + 1, x), (2 * number, first + 2, y), (2 * number + 1, first, y),
                                   (2 * number + 1, first + 1, -y), (2 * number + 1, first + 2, x)):  # fmt: skip
            rows.append(row)
            columns.append(column)
            values.append(value)
    sides = [(-loads.weight * np.sqrt(model.area)[:, None]).ravel() for loads in (before, live)]
    traction = tractions(model, before, live, body)
    scale = (max(float(np.abs(before.traction).max()), 1e-30), max(float(np.abs(live.traction).max()), 1e-30))
    keep, torn = independent(model, traction, scale)
    kept = int(keep.sum())
    rows.append(2 * count + np.repeat(np.arange(kept), 6))
    columns.append(traction.columns[keep].ravel())
    values.append(traction.values[keep].ravel())
    matrix = sparse.csr_matrix((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), (2 * count + kept, 9 * count))
    acting = resultants(model, before, live, body)
    used = np.concatenate([np.repeat(body < 0, 2), np.ones(kept, dtype=bool)])
    start = int(used.sum())

    def work(on: int, place: Array, force: Array) -> tuple[Array, Array]:
        first, motions = acting.motions[on]
        return start + first + np.arange(len(motions.free)), motions.at(place[None])[:, 0] @ force / float(np.ptp(model.mesh.places))

    whole = sparse.vstack([matrix[used], acting.matrix])
    whole = sparse.hstack([whole, columns_of(model, body, whole.shape[0], work)])
    dead, more = (np.concatenate([np.append(side, given[keep])[used], last]) for side, given, last in zip(
        sides, (traction.dead, traction.live), (acting.dead, acting.live)))  # fmt: skip
    figure = _figure(model)
    figure = None if figure is None else np.concatenate([figure, np.zeros(len(model.props))])
    return Balance(sparse.csr_matrix(whole), dead, more, figure, limits_of(model.props), body >= 0), torn


def _figure(model: Model) -> Array | None:
    """Power of the tractions on edges with prescribed velocity."""
    edges = np.flatnonzero(model.pushed.any(axis=1))
    if not len(edges):
        return None
    found = np.zeros(9 * len(model.area))
    for end in range(2):
        columns, values = traction_part(model, edges, model.pushed[edges], end, 0)
        np.add.at(found, columns.ravel(), (values * model.length[edges, None] / 2.0).ravel())
    return found
