"""Earth pressure on rough walls: by bounds from both sides, and by a finer march."""

import math
import unittest
from unittest import mock

from qsmpm_verify.reference import earth_pressure
from qsmpm_verify.reference.earth_pressure import passive_wall


def coulomb(friction: float, wall: float) -> float:
    """The plane wedge."""
    phi, delta = math.radians(friction), math.radians(wall)
    root = math.sqrt(math.sin(phi + delta) * math.sin(phi) / math.cos(delta))
    return (math.cos(phi) / (1 - root)) ** 2 / math.cos(delta)


def lancellotta(friction: float, wall: float) -> float:
    """A field of stress with one fan of discontinuities (Lancellotta 2002), of the whole push."""
    phi, delta = math.radians(friction), math.radians(wall)
    turn = math.asin(math.sin(delta) / math.sin(phi)) + delta
    root = math.sqrt(math.sin(phi) ** 2 - math.sin(delta) ** 2)
    return (math.cos(delta) + root) / (1 - math.sin(phi)) * math.exp(turn * math.tan(phi))


class PassiveWall(unittest.TestCase):
    def test_lies_between_the_bounds(self) -> None:
        for friction, wall in ((20, 10), (30, 10), (30, 20), (35, 15), (40, 20)):
            found = passive_wall(friction, wall)
            self.assertGreater(found, lancellotta(friction, wall))
            self.assertLess(found, coulomb(friction, wall))

    def test_meets_rankine_at_a_smooth_wall(self) -> None:
        self.assertAlmostEqual(passive_wall(30, 0), 3.0, 12)
        self.assertAlmostEqual(passive_wall(30, 0.01), 3.0, 2)

    def test_a_finer_march_changes_little(self) -> None:
        coarse = passive_wall(30, 20)
        with mock.patch.object(earth_pressure, "STEPS", 4800):
            self.assertAlmostEqual(passive_wall(30, 20) / coarse, 1.0, 3)

    def test_rougher_than_the_sand_is_refused(self) -> None:
        self.assertRaises(ValueError, passive_wall, 30, 30)
