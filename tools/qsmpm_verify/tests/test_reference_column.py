"""The column against quadratures of stretches found another way, and steps carried out one by one."""

import math
import unittest

import numpy as np
from scipy import integrate, special

from qsmpm_verify.reference import column as ref
from qsmpm_verify.tests.routes import runge_kutta, slope_of

SCENE = (50.0, 10.0, 0.8)


def by_quadrature(stretch, low: float, high: float) -> float:
    """Length of a part of the column from its stretch at reference height X."""
    return integrate.quad(stretch, low, high, epsabs=1e-9)[0]


def hencky_stretch(stress: float) -> float:
    """Bisection of stress = -ln(lambda) / lambda on the branch that starts at one (E = 1)."""
    low, high = (1e-9, 1.0) if stress > 0 else (1.0, math.e)
    for _ in range(70):
        middle = (low + high) / 2
        too_long = -math.log(middle) / middle < stress
        low, high = (low, middle) if too_long else (middle, high)
    return (low + high) / 2


def rate_stretch(stress: float) -> float:
    """Runge-Kutta integration of d lambda / d sigma = lambda / (1 - sigma), tension positive (E = 1)."""
    return float(runge_kutta(lambda s, lam: lam / (1 - s), [1.0], 0.0, -stress, 60)[0])


class LambertW(unittest.TestCase):
    def test_it_inverts_and_is_scipys(self):
        for x in (-0.3678, -0.3, -0.1, 0.0, 1e-8, 0.5, 4.0, 1e6):
            w = ref.lambert_w(x)
            self.assertAlmostEqual(w * math.exp(w), x, delta=1e-14 * (1 + abs(x)))
            # near the branch point the root is nearly double: rounding 1e-16 becomes 1e-14
            self.assertAlmostEqual(w, float(special.lambertw(x).real), delta=1e-13 * (1 + abs(w)))

    def test_at_the_branch_point_it_is_minus_one_and_below_there_is_none(self):
        self.assertAlmostEqual(ref.lambert_w(-math.exp(-1)), -1, 7)
        self.assertRaises(ValueError, ref.lambert_w, -0.4)


class Heights(unittest.TestCase):
    def test_hencky_is_the_quadrature_of_bisected_stretches(self):
        for height, young, weight in (SCENE, (3.0, 10.0, -0.8)):
            own = by_quadrature(lambda x: hencky_stretch(weight * (height - x) / young), 0, height)
            self.assertAlmostEqual(ref.column_height_hencky(height, young, weight), own, 8)

    def test_rate_is_the_quadrature_of_the_integrated_rate(self):
        for height, young, weight in (SCENE, (8.0, 10.0, -0.8)):
            own = by_quadrature(lambda x: rate_stretch(weight * (height - x) / young), 0, height)
            # Runge-Kutta of the stretch, 1e-7
            self.assertAlmostEqual(ref.column_height_rate(height, young, weight), own, 5)

    def test_printed_figures(self):
        self.assertAlmostEqual(ref.column_height_hencky(*SCENE), 24.059646, 6)
        self.assertAlmostEqual(ref.column_height_rate(*SCENE), 20.117974, 6)
        self.assertAlmostEqual(ref.column_base_stretch_hencky(*SCENE), 0.300542, 6)
        self.assertAlmostEqual(ref.column_base_stretch_rate(*SCENE), 0.2, 12)
        self.assertAlmostEqual(ref.column_height_shrinking_mass(*SCENE), 25.0, 12)

    def test_base_stretches_are_bisected_and_integrated_ones(self):
        for load in (0.3, 2.0, -0.3):
            self.assertAlmostEqual(ref.column_base_stretch_hencky(1.0, 1.0, load), hencky_stretch(load), 12)
            self.assertAlmostEqual(ref.column_base_stretch_rate(1.0, 1.0, load), rate_stretch(load), 6)

    def test_without_weight_nothing_moves(self):
        for function in (ref.column_height_hencky, ref.column_height_rate, ref.column_height_shrinking_mass):
            self.assertEqual(function(3.0, 1.0, 0.0), 3.0)
            # and a small weight shortens by g l0^2 / (2 E)
            self.assertAlmostEqual((3.0 - function(3.0, 1.0, 1e-6)) / 1e-6, 4.5, 4)
        for function in (ref.column_position_hencky, ref.column_position_rate):
            self.assertEqual(function(2.0, 3.0, 1.0, 0.0), 2.0)

    def test_shrinking_mass_is_the_iteration_of_a_stack_of_slices(self):
        height, young, weight = 5.0, 10.0, 3.0
        slices = 4000
        stretch = np.ones(slices)
        for _ in range(80):
            weights = weight * stretch * height / slices
            below = np.cumsum(weights[::-1])[::-1] - weights / 2
            stretch = 1 / (1 + below / young)
        # slices of 1/4000, second order
        self.assertAlmostEqual(ref.column_height_shrinking_mass(height, young, weight), height * stretch.mean(), 6)

    def test_columns_that_cannot_hang_are_refused(self):
        self.assertRaises(ValueError, ref.column_height_rate, 1.0, 1.0, -1.0)
        self.assertRaises(ValueError, ref.column_height_hencky, 1.0, 1.0, -0.37)
        self.assertRaises(ValueError, ref.column_height_shrinking_mass, 1.0, 1.0, -0.6)
        self.assertRaises(ValueError, ref.column_height_rate, 1.0, 0.0, 1.0)


class Positions(unittest.TestCase):
    def test_positions_are_quadratures_from_the_foot(self):
        for place in (0.0, 11.0, 37.0, 50.0):
            own = by_quadrature(lambda x: hencky_stretch(0.08 * (50 - x)), 0, place)
            self.assertAlmostEqual(ref.column_position_hencky(place, *SCENE), own, 8)
            own = by_quadrature(lambda x: rate_stretch(0.08 * (50 - x)), 0, place)
            self.assertAlmostEqual(ref.column_position_rate(place, *SCENE), own, 5)

    def test_slope_of_the_positions_balances_the_weight_above(self):
        for place in (1.0, 20.0, 49.0):
            stretch = slope_of(lambda x: ref.column_position_hencky(x, *SCENE), place, 1e-4)
            self.assertAlmostEqual(-10 * math.log(stretch) / stretch, 0.8 * (50 - place), 5)
            stretch = slope_of(lambda x: ref.column_position_rate(x, *SCENE), place, 1e-4)
            self.assertAlmostEqual(10 * (1 / stretch - 1), 0.8 * (50 - place), 5)

    def test_places_outside_are_refused(self):
        self.assertRaises(ValueError, ref.column_position_hencky, 51.0, *SCENE)
        self.assertRaises(ValueError, ref.column_position_rate, -1.0, *SCENE)


class Steps(unittest.TestCase):
    def test_printed_figures(self):
        for steps, height in ((10, 17.994696), (40, 19.615190), (100, 19.918959), (1000, 20.098196)):
            self.assertAlmostEqual(ref.column_height_paper_steps(*SCENE, steps), height, 6)

    def test_steps_carried_out(self):
        def stretch(x: float) -> float:
            lam, sigma, weight = 1.0, 0.0, 0.08 * (50 - x)
            for step in range(10):
                target = -weight * (step + 1) / 10
                lam *= 1 + (target - sigma) / (1 - sigma)
                sigma = target
            return lam

        self.assertAlmostEqual(ref.column_height_paper_steps(*SCENE, 10), by_quadrature(stretch, 0, 50), 8)

    def test_one_step_is_linear_elasticity(self):
        # stretch 1 - q with q = 0.08 (5 - X): 5 - 0.08 * 25 / 2
        self.assertAlmostEqual(ref.column_height_paper_steps(5, 10, 0.8, 1), 4.0, 12)

    def test_a_step_that_turns_the_foot_inside_out_is_refused(self):
        self.assertRaises(ValueError, ref.column_height_paper_steps, *SCENE, 4)


class Stress(unittest.TestCase):
    def test_stress_is_the_sum_of_the_weights_above(self):
        weights = np.full(1000, 0.8 * 0.05)
        self.assertAlmostEqual(ref.column_base_stress(50, 0.8), weights.sum(), 10)
        self.assertAlmostEqual(ref.column_stress(20.0, 50, 0.8), weights[400:].sum(), 10)

    def test_a_place_outside_is_refused(self):
        self.assertRaises(ValueError, ref.column_stress, 60.0, 50, 0.8)


if __name__ == "__main__":
    unittest.main()
