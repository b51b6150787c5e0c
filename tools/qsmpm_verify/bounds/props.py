"""Props: forces along the line between two points of bodies that do not fail, unknowns after the stresses, within their capacity."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from qsmpm_verify.bounds.model import Model
from qsmpm_verify.bounds.rigid import body_at
from qsmpm_verify.bounds.scene import Prop
from qsmpm_verify.results import Array
from qsmpm_verify.trouble import Trouble


def limits_of(props: tuple[Prop, ...]) -> Array:
    """Largest compression and tension of each (n, 2)."""
    return np.array([prop.limits for prop in props]).reshape(-1, 2)


def columns_of(model: Model, body: Array, rows: int, work: Callable[[int, Array, Array], tuple[Array, Array]]) -> Array:
    """Coefficients of a unit tension of each prop in the equations (rows, n): `work` gives the rows of a body for a force at a position, and their coefficients."""
    found = np.zeros((rows, len(model.props)))
    for number, prop in enumerate(model.props):
        along = (prop.ends[1] - prop.ends[0]) / np.linalg.norm(prop.ends[1] - prop.ends[0])
        for place, pull in [(prop.ends[0], along)] + ([] if prop.fixed else [(prop.ends[1], -along)]):
            on = body_at(model, body, place)
            if on < 0:
                raise Trouble(f"*PROP: its end at ({place[0]:g}, {place[1]:g}) is not in a body without *MOHR COULOMB; bounds support props between such bodies only")
            own, values = work(on, place, pull)
            found[own, number] += values
    return found
