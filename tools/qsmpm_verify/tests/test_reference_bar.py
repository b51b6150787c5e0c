"""The bar in tension against integrated rates and minimised energies."""

import math
import unittest

import numpy as np
from scipy import optimize

from qsmpm_verify.reference import bar as ref
from qsmpm_verify.tests.routes import Array, runge_kutta, slope_of, stiffness


def pulled(stretch: float, poisson: float, steps: int = 400) -> float:
    """Force over E A0 by integrating stress and area over ln(lambda), lateral stresses kept at zero."""
    moduli = stiffness(1.0, poisson)

    def rate(_: float, state: Array) -> list[float]:
        sigma, area = state
        lateral = np.linalg.solve(moduli[1:, 1:], -moduli[1:, 0])
        strain = np.array([1.0, *lateral])
        return [moduli[0] @ strain - sigma * strain.sum(), area * lateral.sum()]

    sigma, area = runge_kutta(rate, [0.0, 1.0], 0.0, math.log(stretch), steps)
    return sigma * area


class RateLaw(unittest.TestCase):
    def test_force_is_the_integral_of_the_rate_with_free_sides(self):
        for stretch, poisson in ((0.5, 0.3), (1.5, 0.0), (3.58610, 0.3), (8.0, 0.2), (2.0, 0.49)):
            # Runge-Kutta 4 over ln 8 in 400 steps
            self.assertAlmostEqual(ref.bar_force_rate(stretch, poisson), pulled(stretch, poisson), 9)

    def test_half_is_the_limit(self):
        for stretch in (0.7, 2.0):
            # first order in 0.5 - nu
            self.assertAlmostEqual(ref.bar_force_rate(stretch, 0.5), ref.bar_force_rate(stretch, 0.5 - 1e-6), 5)
        self.assertAlmostEqual(ref.bar_peak_stretch_rate(0.5), ref.bar_peak_stretch_rate(0.5 - 1e-6), 5)

    def test_peak_is_where_a_search_on_the_integral_finds_it(self):
        for poisson, high in ((0.3, 8.0), (0.45, 6.0)):
            found = optimize.minimize_scalar(
                lambda x: -pulled(x, poisson, 100), bounds=(1.5, high), method="bounded", options={"xatol": 1e-7}
            )
            # flat top: the place of a maximum is known to the root of the error of the force
            self.assertAlmostEqual(ref.bar_peak_stretch_rate(poisson), found.x, 3)
            self.assertAlmostEqual(ref.bar_peak_force_rate(poisson), -found.fun, 7)

    def test_printed_peak(self):
        self.assertAlmostEqual(ref.bar_peak_force_rate(0.3), 0.464758, 6)
        self.assertAlmostEqual(ref.bar_peak_stretch_rate(0.3), 3.58610, 5)

    def test_bars_that_are_none_are_refused(self):
        self.assertRaises(ValueError, ref.bar_force_rate, 0.0, 0.3)
        self.assertRaises(ValueError, ref.bar_force_rate, 1.1, 0.6)
        self.assertRaises(ValueError, ref.bar_peak_stretch_rate, 0.0)


class Hencky(unittest.TestCase):
    def test_force_is_the_slope_of_the_energy_minimised_over_the_width(self):
        moduli = stiffness(1.0, 0.3)

        def energy(stretch: float) -> float:
            def stored(width: float) -> float:
                e = np.array([math.log(stretch), width, width])
                return float(e @ moduli @ e / 2)

            return optimize.minimize_scalar(stored, bracket=(-1, 0), options={"xtol": 1e-10}).fun

        for stretch in (0.6, 1.3, 2.7):
            # difference of minimised energies, 1e-13 over 2e-4
            self.assertAlmostEqual(ref.bar_force_hencky(stretch), slope_of(energy, stretch, 1e-4), 7)

    def test_largest_force_is_where_a_search_finds_it(self):
        found = optimize.minimize_scalar(lambda x: -ref.bar_force_hencky(x), bounds=(1.5, 5), method="bounded")
        self.assertAlmostEqual(ref.bar_peak_force_hencky(), -found.fun, 9)
        self.assertAlmostEqual(found.x, math.e, 4)

    def test_a_bar_without_length_is_refused(self):
        self.assertRaises(ValueError, ref.bar_force_hencky, -1.0)


if __name__ == "__main__":
    unittest.main()
