"""The deck with smaller triangles where its run has sheared: `*REFINE` over the cells of the grid that the slip surface crosses.

Level k uses the strain of the run of level k - 1, level 1 that of the run of the deck: of the failure mechanism if a factor of safety was searched,
otherwise of the last step. A cell of the grid is refined, to its width over 2**k, if its largest plastic shear strain is at least a tenth of the strain that
2 % of the cells exceed, together with the surrounding cells that contain soil.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from qsmpm_verify.results import Points, read_mechanism, read_points, written_mechanisms
from qsmpm_verify.study.cards import Card, Deck
from qsmpm_verify.study.variants import Method, axis_lines

REFINED = Method("refined by strain")
# The finest triangle of *REFINE is an eighth of a cell.
LEVELS = (1, 2, 3)
# Of a cell halved along both axes in the shear zones: three times the cells, and longer searches.
COST = 3.0
SHARE, HIGHEST = 0.1, 98.0
STRAIN = "accumulated_plastic_shear_strain"


def can_refine(deck: Deck) -> bool:
    """Whether a deck may use body-fitted triangles: a plane grid without named cells, and no displacement-controlled objects that move through it."""
    grid = deck.find("GRID")
    if grid is None or len(axis_lines(deck, "Z")) > 0 or deck.find("MOVING MESH") or deck.find("RIGID BODY"):
        return False
    named = deck.find("METHOD")
    return (grid.value("ELEMENT") is None or grid.value("FIT") == "YES") and (named is None or named.value("BASIS") in (None, "AUTO", "FEM"))


def sheared_points(folder: Path) -> Points:
    """Points of the failure mechanism, or of the last step of a run."""
    return read_mechanism(folder) if written_mechanisms(folder) else read_points(folder)


def sheared_cells(x: np.ndarray, y: np.ndarray, place: np.ndarray, strain: np.ndarray) -> np.ndarray:
    """Cells of the grid that are refined, one row for each cell along y."""
    i = np.clip(np.searchsorted(x, place[:, 0], side="right") - 1, 0, len(x) - 2)
    j = np.clip(np.searchsorted(y, place[:, 1], side="right") - 1, 0, len(y) - 2)
    largest = np.full((len(y) - 1, len(x) - 1), -1.0)
    np.maximum.at(largest, (j, i), strain)
    full = largest >= 0.0
    marked = full & (largest > 0.0) & (largest >= SHARE * np.percentile(largest[full], HIGHEST))
    around = np.pad(marked, 1)
    near = [around[1 + b : around.shape[0] - 1 + b, 1 + a : around.shape[1] - 1 + a] for a in (-1, 0, 1) for b in (-1, 0, 1)]
    return np.any(near, axis=0) & full


def boxes_of(x: np.ndarray, y: np.ndarray, cells: np.ndarray, level: int) -> list[str]:
    """Data lines of *REFINE over cells of a grid; adjacent cells of equal width form one box."""
    rows = []
    for j, row in enumerate(cells):
        start = 0
        for i in range(1, len(row) + 1):
            width = np.sqrt((x[start + 1] - x[start]) * (y[j + 1] - y[j]))
            if i < len(row) and row[i] == row[start] and np.isclose(x[i + 1] - x[i], x[start + 1] - x[start]):
                continue
            if row[start]:
                rows.append(f" {x[start]:.9g}, {x[i]:.9g}, {y[j]:.9g}, {y[j + 1]:.9g}, {width / 2**level:.6g}")
            start = i
    return rows


def refined(deck: Deck, level: int, folder: Path) -> Deck:
    """The deck with smaller triangles where the run of a folder has sheared, with its own boxes kept; unchanged if nothing has sheared."""
    x, y = axis_lines(deck, "X"), axis_lines(deck, "Y")
    points = sheared_points(folder)
    rows = boxes_of(x, y, sheared_cells(x, y, points.field("position"), points.field(STRAIN)), level)
    own = deck.find("REFINE") or Card("REFINE")
    return deck.with_card(Card("REFINE", own.parameters, (*own.lines, *rows))) if rows else deck
