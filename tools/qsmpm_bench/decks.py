"""Decks of the measurements: those of input/ with replacements, and generated blocks of soil."""

from __future__ import annotations

from pathlib import Path

from qsmpm_bench.measure import Deck
from qsmpm_verify.places import TOP

INPUT = TOP / "input"
CASES = TOP / "verification" / "cases" / "decks"

#: The constant load tests of the slopes are no part of the curve; they come last before the end of the phase.
NO_HOLD = ("*CONSTANT LOAD TEST, REPEATS=10\n30, 100\n", "")

SOIL = "*ELASTIC\n1000, 0.3\n*MOHR COULOMB\n5, 30, 0\n*UNIT WEIGHT\n18\n"
ELASTIC = "*ELASTIC\n1000, 0.3\n*UNIT WEIGHT\n1\n"


def scene(name: str, *replace: tuple[str, str], folder: Path = INPUT, file: str = "") -> Deck:
    """A deck of the tree with replacements."""
    return Deck(name, folder / (file or f"{name}.inp"), tuple(replace))


def first_steps(name: str, file: str, steps: int, *replace: tuple[str, str]) -> Deck:
    """The first steps of a slope with 100 equal steps, without the constant load tests."""
    return scene(name, NO_HOLD, ("LOAD FACTOR=100", f"LOAD FACTOR={steps}"), ("STEPS=100", f"STEPS={steps}"),
                 *replace, file=file)


def block(name: str, model: str, cells: int, points: int, method: str, steps: int, *, material: str = SOIL,
          solver: str = "", wide: float = 1.5, output: bool = False) -> Deck:
    """A unit square or cube of soil under self-weight, `cells` cells along an edge, on rollers.

    The grid is `wide` times the block along every axis, with empty cells around it; the cell size is
    unchanged. The free faces are on grid lines. In axisymmetric models x is the radius. The steps are not checked: the block
    represents the cost of a step, not its accuracy.
    """
    axes = "XYZ" if model == "3D" else "XY"
    full = round(wide * cells)
    grid = "".join(f"{axis}, 0, {full / cells:.12g}, {full}\n" for axis in axes)
    sets = "".join(f"*NSET, NSET=low_{axis.lower()}, PLANE={axis}\n0\n" for axis in axes)
    held = "".join(f"low_{axis.lower()}, {'ALL' if axis == 'Y' else axis}\n" for axis in axes)
    text = (f"*HEADING\nA block of soil under self-weight\n*MODEL, TYPE={model}\n"
            f"*GRID, ELEMENT={'HEX8' if model == '3D' else 'QUAD4'}\n{grid}{sets}"
            f"*MATERIAL, NAME=soil\n{material}"
            f"*BODY, NAME=block, MATERIAL=soil, SHAPE=BOX\n{', '.join('0, 1' for _ in axes)}\n"
            f"*POINTS, BODY=block, PER ELEMENT={points}\n*METHOD, {method}\n{solver}"
            + ("" if output else "*FIELD, VTK=NO, HDF5=NO\n")
            + f"*PHASE, NAME=weight\n*FIX\n{held}*GRAVITY\n0, -1{', 0' if model == '3D' else ''}\n"
            f"*CONTROLS, STEPS={steps}, STABILISATION SHARE=1\n*END PHASE\n")
    return Deck(name, text=text)
