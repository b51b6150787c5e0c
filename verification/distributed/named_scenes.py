"""Checks of scenes of input/ on 1, 2, 3, 4 and 7 ranks, which is more than some of them have columns of cells."""

from __future__ import annotations

import re

from many_ranks import ELASTIC, PLASTIC, agrees
from one_rank import shortened
from shared_scenes import SAME
from support import TOP, Check, Place

RANKS = (1, 2, 3, 4, 7)


def beginnings() -> dict[str, tuple[str, float]]:
    """A column and a block on its way whole, the first steps of slopes and of a beam; and the bounds of their curves."""
    column = (TOP / "input/column_logarithmic.inp").read_text()
    beam = (TOP / "input/cantilever_paper.inp").read_text().replace("0, -100\n*CONTROLS, STEPS=50", "0, -10\n*CONTROLS, STEPS=5")
    block = (TOP / "verification/cases/decks/carried_block.inp").read_text()
    slope, slice_ = (shortened(f"{name}.inp", 15).replace("TYPE={solver}", "TYPE=AUTO") for name in ("slope_grid", "slope_e50_coarse"))
    return {"column": (column, ELASTIC), "beam": (beam, ELASTIC), "block": (block, ELASTIC), "slope": (slope, PLASTIC),
            "slice": (slice_, PLASTIC)}  # fmt: skip


def named_scenes(place: Place) -> None:
    """Column, beam and block agree to 1e-6, a slope and a slice of one, which yield, to 1e-3."""
    for name, (deck, bound) in beginnings().items():
        agrees(place, name, deck, RANKS, bound)


def small_residuals(place: Place) -> None:
    """With MUMPS and TOLERANCE=1E-10 all of them agree to 1e-9."""
    for name, (deck, _) in beginnings().items():
        deck = re.sub(r"\*SOLVER.*\n", "", re.sub(r"TOLERANCE=[^,\n]+", "TOLERANCE=1E-10", deck))
        agrees(place, name, deck.replace("*METHOD", "*SOLVER, TYPE=MUMPS\n*METHOD"), RANKS, SAME)


CHECKS: list[Check] = []
LONG_CHECKS: list[Check] = [named_scenes, small_residuals]
