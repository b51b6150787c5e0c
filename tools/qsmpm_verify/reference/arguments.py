"""Checks of arguments: a value outside the range of a formula is rejected with one sentence."""

from __future__ import annotations

import math


def within(name: str, value: float, low: float = -math.inf, high: float = math.inf) -> None:
    """Raise ValueError unless low <= value <= high."""
    if not low <= value <= high:
        raise ValueError(f"{name} = {value:g} must be between {low:g} and {high:g}")


def between(name: str, value: float, low: float = -math.inf, high: float = math.inf) -> None:
    """Raise ValueError unless low < value < high."""
    if not low < value < high:
        raise ValueError(f"{name} = {value:g} must be strictly between {low:g} and {high:g}")


def positive(**values: float) -> None:
    """Raise ValueError unless every value is above zero and finite."""
    for name, value in values.items():
        between(name, value, 0.0)


def not_negative(**values: float) -> None:
    """Raise ValueError unless every value is at least zero and finite."""
    for name, value in values.items():
        if not 0 <= value < math.inf:
            raise ValueError(f"{name} = {value:g} must not be negative")


def poisson_ratio(value: float) -> None:
    """Raise ValueError unless the ratio belongs to a compressible, stable material."""
    between("poisson", value, -1.0, 0.5)


def step_count(value: float) -> int:
    """The number of steps as an integer; ValueError if it is not one."""
    if value < 1 or value != math.floor(value):
        raise ValueError(f"steps = {value:g} must be an integer of at least 1")
    return int(value)


def friction_angle(name: str, degrees: float, low: float = 0.0) -> float:
    """The angle in radians; ValueError unless low <= angle < 90 degrees."""
    if not low <= degrees < 90:
        raise ValueError(f"{name} = {degrees:g} degrees must be at least {low:g} and below 90")
    return math.radians(degrees)


def dilatancy_angle(degrees: float, friction: float) -> float:
    """The angle in radians; ValueError unless 0 <= dilatancy <= friction (both in degrees)."""
    within("dilatancy", degrees, 0.0, friction)
    return math.radians(degrees)
