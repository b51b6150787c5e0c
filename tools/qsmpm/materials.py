"""Soil models written in Python: for trying an idea; every point of every iteration is one call."""
from __future__ import annotations

import ctypes
from dataclasses import dataclass

import numpy as np

from .library import START, UPDATE, ModelOptions

OK, CUT, FAILED, UNRECOVERABLE = 0, 1, 2, 3
Array = np.ndarray


@dataclass(frozen=True)
class Increment:
    """What a model gets of a step of a point; components 11, 22, 33, 12, 13, 23, shear gamma = 2 eps."""

    strain: Array
    strain_start: Array
    rotation: Array
    gradient_start: Array
    gradient_end: Array
    phase: int
    step: int
    start: float
    duration: float
    point: int
    cell: int
    place: Array
    cell_size: float
    wants_tangent: bool
    elastic_tangent: bool
    time: float
    time_increment: float


@dataclass
class Update:
    """What a model answers: stress (6), state, tangent d stress / d strain (6, 6)."""

    stress: Array
    state: Array
    tangent: Array
    plastic: bool = False


class SoilModel:
    """A soil model. Extend it and write `update`; raise an exception to end the run with its text."""

    state_count = 0
    symmetric = False
    reads_strain = False
    reads_gradient = False
    stiffness_scale = 0.0
    shear_scale = 0.0
    fault: Exception | None = None
    """What `start` or `update` has raised."""

    def start(self, stress: Array) -> Array:
        """State of a point with a given stress."""
        return np.zeros(self.state_count)

    def update(self, increment: Increment, stress: Array, state: Array) -> Update:
        """One step of one point; stress and state are those of the start, the stress turned with the material."""
        raise NotImplementedError

    def options(self) -> ModelOptions:
        """As C sees it."""
        return ModelOptions(self.state_count, self.symmetric, False, self.reads_strain, self.reads_gradient,
                            self.stiffness_scale, self.shear_scale)

    def callbacks(self) -> tuple[object, object]:
        """The two procedures for C; they must be kept as long as the library may call them."""
        n = self.state_count

        def start(_user, stress, state):
            # An exception cannot pass through the library: a state that is none ends the call, which raises it.
            try:
                begun = self.start(np.ctypeslib.as_array(stress, (6,)).copy())
                if n:
                    np.ctypeslib.as_array(state, (n,))[:] = begun
            except Exception as fault:  # noqa: BLE001 - whatever the model raises is reported by the call
                self.fault = fault
                if n:
                    np.ctypeslib.as_array(state, (n,))[:] = np.nan

        def update(_user, step, stress, state, answer):
            try:
                return self._update(step.contents, stress, state, answer.contents)
            except Exception as fault:  # noqa: BLE001 - whatever the model raises is its message
                self.fault = fault
                answer.contents.message = f"{type(fault).__name__}: {fault}".encode()[:255]
                return UNRECOVERABLE

        return START(start), UPDATE(update)

    def _update(self, step, stress, state, answer) -> int:
        """Call the model and copy its answer."""
        matrix = lambda values: np.array(values).reshape(3, 3).T  # noqa: E731 - column by column in C
        increment = Increment(np.array(step.strain), np.array(step.strain_start), matrix(step.rotation),
                          matrix(step.gradient_start), matrix(step.gradient_end), step.phase, step.step, step.start,
                          step.duration, step.point, step.cell, np.array(step.place), step.cell_size,
                          bool(step.wants_tangent), bool(step.elastic_tangent), step.time,
                          step.time_increment)
        old = np.ctypeslib.as_array(stress, (6,))
        n = self.state_count
        old_state = np.ctypeslib.as_array(state, (n,)) if n else np.zeros(0)
        new = self.update(increment, old.copy(), old_state.copy())
        old[:] = new.stress
        if n:
            old_state[:] = new.state
        answer.plastic = int(new.plastic)
        tangent = np.asarray(new.tangent, dtype=float)
        if tangent.shape != (6, 6):
            raise ValueError(f"the tangent is {tangent.shape}, not (6, 6)")
        ctypes.memmove(answer.tangent, np.asfortranarray(tangent).ravel(order="F").ctypes.data, 36 * 8)
        return OK
