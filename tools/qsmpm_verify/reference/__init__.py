"""Reference solutions: closed forms, quadratures and own numerical solutions, one module for each family.

Every public function is pure, takes and returns plain numbers in consistent units and rejects arguments outside
its range with a ValueError. Its docstring has the entries Formula, Units, Range, Assumes, Source and
Check; `page.markdown()` writes them to docs/references.md. The check is a separate test by an independent method, in
tests/test_reference_<family>.py. A case file names a function as {function = "van_langen", ...}.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from types import ModuleType

from qsmpm_verify.reference import (
    bar, beam, bearing, cam_clay, cavity, column, consolidation, earth_pressure, element_tests, indentation, iteration, oedometer, penetration, points, rotation,
    shear, slope, suction, undrained, upsetting,
)  # fmt: skip
from qsmpm_verify.reference.beam import cantilever_tip
from qsmpm_verify.reference.column import column_position_hencky, lambert_w
from qsmpm_verify.reference.oedometer import van_langen

Reference = Callable[..., float]
FAMILIES: tuple[ModuleType, ...] = (
    oedometer, column, beam, bar, shear, element_tests, cam_clay, cavity, bearing, earth_pressure, slope, rotation, indentation, penetration, upsetting,
    undrained, consolidation, suction, points, iteration,
)  # fmt: skip
"""The modules, in the order of the page."""


def functions(family: ModuleType) -> dict[str, Callable[..., object]]:
    """Public functions of a family by name, in the order of the file."""
    return {
        name: thing
        for name, thing in vars(family).items()
        if inspect.isfunction(thing) and thing.__module__ == family.__name__ and not name.startswith("_")
    }


def _is_figure(function: Callable[..., object]) -> bool:
    """Whether a function returns one number, as a case requires."""
    return inspect.signature(function).return_annotation in (float, "float")


REFERENCES: dict[str, Reference] = {
    name: function  # type: ignore[misc]
    for family in FAMILIES
    for name, function in functions(family).items()
    if _is_figure(function)
}
"""The functions that a case file may name."""
__all__ = ["FAMILIES", "REFERENCES", "Reference", "cantilever_tip", "column_position_hencky", "functions", "lambert_w",
           "van_langen"]  # fmt: skip


def __getattr__(name: str) -> Reference:
    """Every function by its bare name: `reference.column_height_rate`."""
    if name in REFERENCES:
        return REFERENCES[name]
    raise AttributeError(f"unknown reference {name}")
