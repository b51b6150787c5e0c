"""Props: forces along the line between two places of bodies that do not fail, unknowns behind the stresses, within what they bear."""

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
    """A tension of one in each prop on the equations (rows, n): of a body, a place and a force there `work` tells the rows and what they get."""
    found = np.zeros((rows, len(model.props)))
    for number, prop in enumerate(model.props):
        along = (prop.ends[1] - prop.ends[0]) / np.linalg.norm(prop.ends[1] - prop.ends[0])
        for place, pull in [(prop.ends[0], along)] + ([] if prop.fixed else [(prop.ends[1], -along)]):
            on = body_at(model, body, place)
            if on < 0:
                raise Trouble(f"*PROP: its end at ({place[0]:g}, {place[1]:g}) lies in no body without *MOHR COULOMB; bounds take props between such bodies")
            own, values = work(on, place, pull)
            found[own, number] += values
    return found
