"""Rotation of slopes with water against other formulas, and against sums over small squares."""

import math
import unittest
from unittest import mock

import numpy as np

from qsmpm_verify.reference import rotation as ref
from qsmpm_verify.reference.slope import slope_spiral_safety

SQUARES = 600
"""Squares a side of the sums."""


def by_squares(scene: ref.Scene, pole: tuple[float, float], leaves: float, factor: float) -> float:
    """The ratio of a mechanism with the water as the body force -grad u of all of the wet space, and a circle or spiral by its equation."""
    slope = scene.friction / factor
    height = float(np.interp(leaves, *scene.ground))
    end, radius = math.atan2(height - pole[1], leaves - pole[0]), math.hypot(leaves - pole[0], height - pole[1])
    edge = np.linspace(pole[0] - 1.2 * radius, leaves + 1e-9, SQUARES + 1)
    floor = np.linspace(pole[1] - 1.2 * radius, max(scene.ground[1].max(), scene.water[1].max()), SQUARES + 1)
    x, y = np.meshgrid((edge[1:] + edge[:-1]) / 2, (floor[1:] + floor[:-1]) / 2)
    size = (edge[1] - edge[0]) * (floor[1] - floor[0])
    turn = np.arctan2(y - pole[1], x - pole[0])
    turn = np.where(turn > 0, turn - 2 * math.pi, turn)
    inside = np.hypot(x - pole[0], y - pole[1]) < radius * np.exp((turn - end) * slope)
    ground, level = np.interp(x, *scene.ground), np.interp(x, *scene.water)
    soil, wet = inside & (y < ground), inside & (y < ground) & (y < level)
    weight = np.where(wet, scene.saturated, scene.moist) * soil
    piece = np.clip(np.searchsorted(scene.water[0], x) - 1, 0, scene.water.shape[1] - 2)
    fall = np.diff(scene.water[1])[piece] / np.diff(scene.water[0])[piece]
    right = scene.push * weight - scene.water_weight * fall * wet
    down = weight - scene.water_weight * wet
    work = size * float(np.sum(right * (pole[1] - y) - down * (x - pole[0])))
    # along the surface, from where it comes out of the ground
    turn = np.linspace(end, -math.pi, 4000)
    far = radius * np.exp((turn - end) * slope)
    along_x, along_y = pole[0] + far * np.cos(turn), pole[1] + far * np.sin(turn)
    stop = int(np.flatnonzero(along_y[5:] >= np.interp(along_x[5:], *scene.ground))[0]) + 5
    half = (turn[: stop - 1] + turn[1:stop]) / 2
    strength = scene.cohesion(pole[1] + radius * np.exp((half - end) * slope) * np.sin(half)) / factor
    spent = float(np.sum(strength * (radius * np.exp((half - end) * slope)) ** 2)) * (turn[0] - turn[1])
    return spent / work


def scene(water: list[tuple[float, float]], push: float, friction: float, gain: float) -> ref.Scene:
    """A slope of 1:2, 5 high, with its toe at 0, 0."""
    ground = np.array([(-60.0, 5.0), (-10.0, 5.0), (0.0, 0.0), (60.0, 0.0)]).T
    return ref.Scene(ground, np.array(water).T, 10.0, 17.0, 20.0, push, lambda y: 6 + gain * (5 - y),
                     math.tan(math.radians(friction)), -20.0)


class Mechanisms(unittest.TestCase):
    """One mechanism at a time."""

    def test_work_is_that_of_small_squares(self) -> None:
        drawn = [(-60.0, 4.0), (-8.0, 4.0), (-2.0, 1.0), (60.0, 1.0)]
        for water, push, friction, gain, leaves in (
            ([(-60.0, -9.0), (60.0, -9.0)], 0.0, 25.0, 0.0, 0.0),
            ([(-60.0, 6.0), (60.0, 6.0)], 0.2, 0.0, 1.5, 2.0),
            ([(-60.0, 3.0), (60.0, 3.0)], 0.1, 20.0, 0.0, 0.0),
            (drawn, 0.0, 28.0, 0.0, 0.0),
        ):
            land = scene(water, push, friction, gain)
            own = ref._ratio(land, (-4.0, 11.0), leaves, 1.3)
            # squares along a jagged edge, 1/600 of the width each
            self.assertAlmostEqual(own / by_squares(land, (-4.0, 11.0), leaves, 1.3), 1, delta=4e-3)

    def test_mechanisms_that_do_not_exist_are_never_critical(self) -> None:
        dry = scene([(-60.0, -9.0), (60.0, -9.0)], 0.0, 25.0, 0.0)
        for pole, leaves in (((-4.0, 3.0), 0.0), ((-4.0, -1.0), 0.0), ((30.0, 8.0), 0.0)):
            self.assertEqual(ref._ratio(dry, pole, leaves, 1.0), ref.NEVER)


class Factors(unittest.TestCase):
    """The best mechanism."""

    def test_dry_and_submerged_slopes_are_the_spiral(self) -> None:
        dry = ref.slope_water_safety(15.0, 15.0, 1.0, 25.0, 25.0, 45.0, 1.0, 0.0, 0.0, 0.0)
        self.assertAlmostEqual(dry, slope_spiral_safety(15.0, 1.0, 25.0, 45.0, 1.0), delta=1e-4)
        wet = ref.slope_water_safety(20.0, 20.0, 1.0, 25.0, 0.0, 45.0, 1.0, 1.5, 1.5, 10.0)
        self.assertAlmostEqual(wet, 1.2982, delta=2e-4)

    def test_the_factor_of_taylor(self) -> None:
        """gamma H/c = 5.24 of a slope of 60 degrees without friction (Taylor 1937, stability number 0.191)."""
        self.assertAlmostEqual(ref.slope_water_safety(5.24, 5.24, 1.0, 0.0, 0.0, 60.0, 1.0, 0.0, 0.0, 0.0), 1, delta=4e-3)

    def test_drawdown_costs_safety(self) -> None:
        drawn = ref.dam_safety(True)
        self.assertAlmostEqual(drawn, 1.4348, delta=1e-3)
        alone = ref.slope_water_safety(19.0, 20.5, 12.0, 28.0, 0.0, math.degrees(math.atan(0.5)), 6.0, 5.0, 1.0, 9.81, below=2.0)
        self.assertTrue(0.96 * drawn < alone < drawn, f"{alone} against {drawn}")

    def test_arguments_out_of_range_are_refused(self) -> None:
        for wrong in (
            (0.0, 20.0, 1.0, 25.0, 0.0, 45.0, 1.0, 0.0, 0.0, 10.0),
            (20.0, 20.0, 1.0, 25.0, 30.0, 45.0, 1.0, 0.0, 0.0, 10.0),
            (20.0, 20.0, 1.0, 25.0, 0.0, 45.0, 1.0, 0.5, 0.6, 10.0),
            (20.0, 20.0, 1.0, 25.0, 0.0, 45.0, 1.0, 2.0, 0.5, 10.0),
            (20.0, 20.0, 1.0, 25.0, 0.0, 90.0, 1.0, 0.0, 0.0, 10.0),
        ):
            self.assertRaises(ValueError, ref.slope_water_safety, *wrong)


class Lost(unittest.TestCase):
    """A search that finds nothing says so."""

    scene = ref.Scene(
        np.array([[0.0, 1, 2, 4], [1, 1, 0, 0]]), np.array([[0.0, 4], [-1, -1]]), 10.0, 20.0, 20.0, 0.0,
        lambda y: np.ones_like(y), 0.4, -1.0,
    )  # fmt: skip

    def test_no_mechanism(self) -> None:
        with mock.patch.object(ref, "_ratio", return_value=ref.NEVER):
            self.assertRaisesRegex(ArithmeticError, "no slip surface", ref._critical, self.scene, 1.0)

    def test_no_critical_factor(self) -> None:
        with mock.patch.object(ref, "_least", return_value=0.5), mock.patch.object(ref, "_coarse", return_value=[]):
            self.assertRaisesRegex(ArithmeticError, "no factor", ref._critical, self.scene, 1.0)

    def test_a_factor_that_keeps_falling(self) -> None:
        with mock.patch.object(ref, "_critical", side_effect=[0.9**i for i in range(20)]):
            self.assertRaisesRegex(ArithmeticError, "no factor", ref._factor, self.scene)


if __name__ == "__main__":
    unittest.main()
