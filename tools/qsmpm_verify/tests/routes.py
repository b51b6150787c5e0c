"""Other routes to a figure, for the tests of the references: Runge-Kutta, differences, Hooke's law as a matrix."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Rate = Callable[[float, Array], ArrayLike]


def runge_kutta(rate: Rate, start: ArrayLike, low: float, high: float, steps: int) -> Array:
    """The state at `high` of d state / dt = rate(t, state), classical fourth order."""
    state, h = np.asarray(start, dtype=float), (high - low) / steps
    for i in range(steps):
        t = low + i * h
        k1 = np.asarray(rate(t, state))
        k2 = np.asarray(rate(t + h / 2, state + h / 2 * k1))
        k3 = np.asarray(rate(t + h / 2, state + h / 2 * k2))
        k4 = np.asarray(rate(t + h, state + h * k3))
        state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return state


def slope_of(function: Callable[[float], float], place: float, step: float = 1e-5) -> float:
    """Central difference, error of the order of step squared."""
    return (function(place + step) - function(place - step)) / (2 * step)


def stiffness(young: float, poisson: float) -> Array:
    """Normal stresses over normal strains: the inverse of Hooke's law in flexibility form."""
    flexibility = (np.eye(3) * (1 + poisson) - poisson * np.ones((3, 3))) / young
    return np.linalg.inv(flexibility)
