#!/usr/bin/env python3
"""Hand values of the week's scenes that no function of the library has: limit equilibrium and upper bounds by a search.

    verification/week/hand_values.py

prints each with the scene it belongs to; the case files quote them.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.optimize import brentq, minimize

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools"))

from qsmpm_verify.reference import REFERENCES  # noqa: E402
from qsmpm_verify.reference.rotation import Scene, _factor, _line  # noqa: E402

Array = np.ndarray


def area(corners: list[Array]) -> float:
    """Area of a polygon."""
    x, y = np.array(corners).T
    return 0.5 * abs(float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))))


def turned(vector: Array, degrees: float) -> Array:
    """A vector turned counter-clockwise."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return np.array([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]])


def unit(vector: Array) -> Array:
    """Its direction."""
    return vector / np.linalg.norm(vector)


def seam_excess(place: Array, factor: float) -> float:
    """Work of the weight less what is spent, over the speed, for three rigid blocks on the seam's foot, associated.

    The first slides down a back scarp through the top layer, the second along the foot of the seam to the toe, the third
    up through the metre of cover beyond it. Places: where the scarp meets the seam, its angle, the angles of both joints and
    of the way out.
    """
    x1, scarp, joint, second, out = place
    if not 2.0 < x1 < 29.0 or not 25.0 < scarp < 85.0 or not 5.0 < out < 60.0 or not 45.0 < joint < 135.0 or not 45.0 < second < 135.0:
        return -1e3
    soil = (9.0 / factor, math.degrees(math.atan(math.tan(math.radians(29.0)) / factor)))
    seam = (2.0 / factor, math.degrees(math.atan(math.tan(math.radians(11.0)) / factor)))

    def foot(x: float) -> float:
        return 11.0 - 0.1 * x if x < 30 else 8.0

    def surface(start: Array, direction: Array) -> Array:
        """Where a ray from below meets the ground."""
        def above(s: float) -> float:
            x, y = start + s * direction
            return float(y - (20.0 if x < 10 else 10.0 if x > 30 else 20.0 - (x - 10) / 2))
        return np.asarray(start + brentq(above, 0.0, 200.0) * direction)

    a, b = np.array([x1, foot(x1)]), np.array([30.0, 8.0])
    back = surface(a, turned(np.array([1.0, 0.0]), 180.0 - scarp))
    top1 = surface(a, turned(np.array([1.0, 0.0]), joint))
    top2 = surface(b, turned(np.array([1.0, 0.0]), second))
    end = surface(b, turned(np.array([1.0, 0.0]), out))
    if not back[0] < top1[0] < top2[0] < end[0]:
        return -1e3
    def crust(left: Array, right: Array) -> list[Array]:
        return [np.array(p) for p in ((30.0, 10.0), (10.0, 20.0)) if left[0] < p[0] < right[0]]

    # Each block moves at phi off its slip line, away from the ground; across a joint the next one moves at phi off it, away from the last.
    directions = [turned(unit(a - back), soil[1]), turned(unit(b - a), seam[1]), turned(unit(end - b), soil[1])]
    spent, work, speed = 0.0, 0.0, 1.0
    shapes = [[a, top1, *crust(back, top1), back], [a, b, top2, *crust(top1, top2), top1], [b, end, *crust(top2, end), top2]]
    slips = [(np.linalg.norm(a - back), soil), (np.linalg.norm(b - a), seam), (np.linalg.norm(end - b), soil)]
    joints = [None, top1 - a, top2 - b]
    before = np.zeros(2)
    for block, direction in enumerate(directions):
        if block:
            along = unit(np.asarray(joints[block]))
            normal = np.array([along[1], -along[0]])
            best = None
            for sign in (1.0, -1.0):
                angle = math.radians(soil[1])
                jump = sign * math.cos(angle) * along + math.sin(angle) * normal
                matrix = np.column_stack([direction, -jump])
                if abs(np.linalg.det(matrix)) < 1e-9:
                    continue
                speed_here, size = np.linalg.solve(matrix, before)
                if speed_here > 0 and size >= 0:
                    best = (float(speed_here), float(size))
            if best is None:
                return -1e3
            speed = best[0]
            spent += soil[0] * math.cos(math.radians(soil[1])) * best[1] * float(np.linalg.norm(np.asarray(joints[block])))
        before = speed * direction
        length, (cohesion, friction) = slips[block]
        spent += cohesion * math.cos(math.radians(friction)) * speed * float(length)
        work += 19.0 * area(shapes[block]) * -before[1]
    return work - spent


def seam() -> float:
    """Factor of the slope on the seam: the least at which some mechanism moves."""
    def needed(place: Array) -> float:
        try:
            return float(brentq(lambda f: seam_excess(place, f), 0.3, 4.0, xtol=1e-6))
        except ValueError:
            return 9.0
    best = 9.0
    for x1 in (6.0, 10.0, 14.0):
        for scarp in (55.0, 65.0):
            for joint in (70.0, 90.0, 110.0):
                found = minimize(needed, [x1, scarp, joint, 90.0, 25.0], method="Nelder-Mead", options={"maxiter": 1500, "xatol": 1e-3, "fatol": 1e-6})
                best = min(best, float(found.fun))
    return best


def pit(rough: bool) -> float:
    """Factor of a cantilever wall in the pit: moments of active and passive pressure about its foot, water level on both sides."""
    def moment(factor: float) -> float:
        phi = math.degrees(math.atan(math.tan(math.radians(33.0)) / factor))
        cohesion = 2.0 / factor
        active = 1 / REFERENCES["flow_number"](friction=phi)
        passive = REFERENCES["passive_wall"](friction=phi, wall=0.999 * phi) if rough else 1 / active
        heights = np.linspace(4.0, 12.0, 4001)

        def vertical(top: float) -> Array:
            return 18.0 * np.clip(top - np.maximum(heights, 8.5), 0, None) + 10.0 * np.clip(8.5 - heights, 0, None)

        push = np.clip(active * vertical(12.0) - 2 * cohesion * math.sqrt(active), 0, None)
        hold = np.where(heights < 9.0, passive * vertical(9.0) + 2 * cohesion * math.sqrt(passive), 0.0)
        return float(np.trapezoid((hold - push) * (heights - 4.0), heights))
    return float(brentq(moment, 0.8, 4.0, xtol=1e-5))


def slide(strength: float) -> float:
    """Factor of the bank of soft clay on rock: the best circle, phi = 0, none below the rock."""
    ground = _line((-60.0, 5.0), (-5.0, 5.0), (0.0, 0.0), (60.0, 0.0))
    water = _line((-60.0, -40.0), (60.0, -40.0))
    return float(_factor(Scene(ground, water, 1.0, 18.0, 18.0, 0.0, lambda y: strength + 0 * y, 0.0, 0.0)))


def dam(drawn: bool) -> float:
    """Factor of the dam: the less safe face, best logarithmic spiral, associated."""
    ground = [(0.0, 3.0), (8.0, 3.0), (24.0, 11.0), (28.0, 11.0), (44.0, 3.0), (52.0, 3.0)]
    water = [(0.0, 4.0), (10.0, 4.0), (20.0, 9.0), (32.0, 9.0), (42.0, 4.0), (52.0, 4.0)] if drawn else [(0.0, 9.0), (52.0, 9.0)]
    slope = math.tan(math.radians(26.0))
    return float(_factor(Scene(_line(*ground), _line(*water), 10.0, 18.5, 20.0, 0.0, lambda y: 12.0 + 0 * y, slope, 0.0)))


def tunnel() -> float:
    """Inward displacement of a cavity in Tresca soil from which the pressure is taken, plane strain, small strain, held all around.

    Elastic beyond the radius c of yield: u = B/r - A r inward, A = B/R^2 for no displacement at R, that of the circle with the area of the
    square. 2 s_u at c gives B; equilibrium with sigma_r = 0 at the wall gives c; the volume change up to c is elastic.
    """
    radius, pressure, strength, young, poisson, side = 2.0, 100.0, 50.0, 20000.0, 0.49, 40.0
    shear, outer = young / 2 / (1 + poisson), 2 * side / math.sqrt(math.pi)

    def unloading(c: float) -> float:
        return 2 * strength * math.log(c / radius) + strength + strength * (c / outer) ** 2 / (1 - 2 * poisson) - pressure
    c = float(brentq(unloading, radius, outer))
    b = strength * c * c / 2 / shear
    r = np.linspace(radius, c, 20001)
    change = (1 - 2 * poisson) * (1 + poisson) / young * (4 * strength * np.log(radius / r) - 2 * strength + 2 * pressure)
    return (b - b / outer**2 * c * c + float(np.trapezoid(change * r, r))) / radius


def main() -> int:
    """Print them."""
    values: list[tuple[str, Callable[[], float]]] = [
        ("dam, full", lambda: dam(False)), ("dam, drawn down", lambda: dam(True)),
        ("pit, smooth wall", lambda: pit(False)), ("pit, rough wall", lambda: pit(True)),
        ("slide, strength of before", lambda: slide(24.0)), ("slide, strength that is left", lambda: slide(8.0)),
        ("seam", seam), ("tunnel, crown", tunnel),
    ]  # fmt: skip
    for name, value in values:
        print(f"{name:32s}{value():.4f}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
