"""Bodies on elastic ground: fits, half spaces, and one profile by the route of another."""

import math
import unittest

from qsmpm_verify.reference.indentation import flat_punch, layer_integral, round_cone, sphere_indentation


class Indentation(unittest.TestCase):
    def test_base_is_that_of_the_published_fit(self) -> None:
        for nu in (0.3, 0.35, 0.4, 0.45, 0.4999):
            fit = (1.2876 - 1.4678 * nu + 1.3442 * nu * nu) / (1 - nu)
            self.assertLess(abs(layer_integral(nu) / fit - 1), 0.01)

    def test_deep_ground_is_a_half_space(self) -> None:
        modulus = 1000 / 0.91
        self.assertAlmostEqual(flat_punch(1000, 0.3, 1, 0.01, 1e9), 2 * modulus * 0.01, 6)
        self.assertAlmostEqual(sphere_indentation(1000, 0.3, 20, 0.05, 1e9), 4 / 3 * modulus * 20**0.5 * 0.05**1.5, 5)
        sharp = 2 / math.pi * modulus * 0.055**2 * math.tan(math.radians(88))
        self.assertAlmostEqual(round_cone(1000, 0.3, 176, 0.0, 0.055, 1e9), sharp, 5)

    def test_cone_that_is_touched_at_its_round_tip_alone_is_a_sphere(self) -> None:
        """The tip of the sharp cone lies deeper than that of the sphere by R (1/sin(angle/2) - 1)."""
        tip, angle, push = 5.0, 150.0, 0.002
        lower = tip * (1 / math.sin(math.radians(angle / 2)) - 1)
        found = round_cone(1000, 0.3, angle, tip, push + lower, 10.0)
        # a/R = 0.02: the sphere against the parabola, and second order in a/h
        self.assertLess(abs(found / sphere_indentation(1000, 0.3, tip, push, 10.0) - 1), 3e-4)

    def test_shallow_ground_is_stiffer(self) -> None:
        self.assertGreater(round_cone(1000, 0.3, 176, 5.0, 0.055, 20), round_cone(1000, 0.3, 176, 5.0, 0.055, 100))
        self.assertGreater(flat_punch(1000, 0.3, 1, 0.01, 20), flat_punch(1000, 0.3, 1, 0.01, 100))
