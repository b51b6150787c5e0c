"""Checks of points that go from rank to rank: corners, faces of cells, steps that are cut back, ranks without a point."""

from __future__ import annotations

import numpy as np
from many_ranks import CARRIED, ELASTIC, agrees, plane
from qsmpm_verify.results import read_points, written_steps
from support import Check, Place, Run, expect

def carried(steps: int, way: float, every: int = 1000) -> str:
    """A block of four by six cells on its way, with a picture of its end."""
    return plane("0, 1, 0, 1.5", phase=CARRIED.replace("{way}", f"{way}"), steps=steps, more=f"*FIELD, EVERY={every}\n")


def keeps_all(name: str, alone: Run, shared: Run) -> None:
    """The points at the end are those of one process, each of them once, with its volume."""
    rows = []
    for run in (alone, shared):
        end = read_points(run.folder)
        began = np.round(end.field("position") - end.field("displacement"), 9)
        order = np.lexsort(began.T)
        rows.append((began[order], np.ravel(end.field("initial_volume"))[order], np.ravel(end.field("volume"))[order]))
    (places, first, last), (other_places, other_first, other_last) = rows
    expect(len(np.unique(places, axis=0)) == len(places), f"{name}: points that began at one place")
    expect(places.shape == other_places.shape and np.allclose(places, other_places, rtol=0.0, atol=1.0e-7), f"{name}: other points")
    expect(np.array_equal(first, other_first), f"{name}: other volumes at the start")
    apart = float(np.max(np.abs(last - other_last)) / np.max(last))
    expect(apart < 1.0e-9, f"{name}: volumes {apart:.1e} apart")


def travels(place: Place, name: str, deck: str, ranks: int) -> tuple[Run, Run]:
    """One process and several: the same curves, and no point lost."""
    agrees(place, name, deck, (ranks,), ELASTIC)
    alone, shared = (Run(place.work / f"{name}-{end}", 0, "", 0.0) for end in ("alone", str(ranks)))
    keeps_all(name, alone, shared)
    return alone, shared


def soft(steps: int, every: int) -> str:
    """A soft block that settles by more than a cell while it is carried, and does not buckle, which would turn rounding into figures."""
    return carried(steps, 1.5, every).replace("*ELASTIC\n200, 0.3", "*ELASTIC\n40, 0.3")


def corners(place: Place) -> None:
    """Points that cross cells along both axes in one step, where four boxes meet, arrive once, with what they carry."""
    watched = place.run("qsmpm", soft(5, 1), "watched").folder
    cells = []
    for step in written_steps(watched):
        end = read_points(watched, step)
        order = np.lexsort(np.round(end.field("position") - end.field("displacement"), 9).T)
        cells.append(np.floor(end.field("position")[order, :2] / 0.25))
    both = sum(int(np.sum(np.all(one != other, axis=1))) for one, other in zip(cells[1:], cells, strict=False))
    expect(both > 20, f"{both} points have crossed cells along both axes")
    travels(place, "corner", soft(5, 1000), 7)


def faces(place: Place) -> None:
    """Points of a stiff block that come to lie on faces of cells, to five digits, where boxes meet, belong to one rank."""
    travels(place, "faces", carried(8, 0.5).replace("*ELASTIC\n200, 0.3", "*ELASTIC\n2E6, 0.3"), 4)


def cut_back(place: Place) -> None:
    """A step that is cut back, after points have gone to other ranks, begins again from the points of the step before."""
    for run in travels(place, "cut", carried(3, 1.6), 2):
        expect("increment cut back" in run.log, "no step was cut back")


def strides(place: Place) -> None:
    """A step of sixteen cells, beyond the part of the grid that a rank looks at, is taken as on one process, with its reactions."""
    deck = carried(1, 4.0).replace("*CONTROLS, ", "*CONTROLS, MAX DISPLACEMENT=30, ").replace("X, 0, 3, 12", "X, 0, 8, 32")
    _, shared = travels(place, "stride", deck, 2)
    expect("cut back" not in shared.log, "the step was cut back")


CHECKS: list[Check] = [faces, cut_back, strides]
LONG_CHECKS: list[Check] = [corners]
