"""Cantilever and column that buckles against quadratures of the first integral, eigenvalues, other integrations."""

import math
import unittest

import numpy as np
from scipy import integrate, optimize

from qsmpm_verify.reference import beam as ref
from qsmpm_verify.tests.routes import runge_kutta

AMPLE = dict(force=100.0, length=10.0, depth=1.0, young=12000.0, poisson=0.2)


def by_first_integral(load: float, axial: float = 0.0, shear: float = 0.0) -> tuple[float, float, float]:
    """Shortening, deflection and slope of the tip: M(theta) from the energy integral, then quadrature over theta.

    M^2 = 2 k (sin a - sin t) + k^2 (axial - shear)(sin^2 a - sin^2 t), a the tip slope; t = a (1 - v^2) makes
    dt / M regular at the tip. The slope follows from the length one.
    """

    def over_the_slope(tip: float, part) -> float:
        def integrand(v: float) -> float:
            t = tip * (1 - v * v)
            step = 2 * math.sin(tip * v * v / 2) * math.cos(tip * (1 - v * v / 2))
            squared = step * (2 * load + load**2 * (axial - shear) * (math.sin(tip) + math.sin(t)))
            return part(t) * 2 * tip * v / math.sqrt(squared)

        return integrate.quad(integrand, 0, 1, epsabs=1e-13, epsrel=1e-12)[0]

    tip = optimize.brentq(lambda a: over_the_slope(a, lambda t: 1.0) - 1, 1e-9, math.pi / 2 - 1e-5, xtol=1e-13)

    def forward(t: float) -> float:
        stretch, slide = 1 + load * math.sin(t) * axial, load * math.cos(t) * shear
        return stretch * math.cos(t) - slide * math.sin(t)

    def sideways(t: float) -> float:
        stretch, slide = 1 + load * math.sin(t) * axial, load * math.cos(t) * shear
        return stretch * math.sin(t) + slide * math.cos(t)

    return 1 - over_the_slope(tip, forward), over_the_slope(tip, sideways), tip


class Cantilever(unittest.TestCase):
    def test_tip_is_the_quadrature_of_the_first_integral(self):
        for load, axial, shear in ((0.5, 0, 0), (10, 0, 0), (40, 0, 0), (9.6, 1 / 1200, 0.0025), (3, 0.05, 0.01)):
            shortening, deflection, slope = by_first_integral(load, axial, shear)
            own = ref.cantilever_tip(load, axial, shear)
            # Runge-Kutta 4 with 400 steps at k = 40: 1e-8
            self.assertAlmostEqual(own[0], shortening, 7)
            self.assertAlmostEqual(own[1], deflection, 7)
            self.assertAlmostEqual(ref.cantilever_slope(load, axial, shear), slope, 7)

    def test_elastica_of_mattiasson(self):
        for k, u, w, slope in (
            (0.5, 0.015919, 0.162144, 0.244534),
            (1, 0.056433, 0.301721, 0.461352),
            (2, 0.160642, 0.493457, 0.781750),
            (3, 0.254420, 0.603253, 0.986017),
            (5, 0.387628, 0.713792, 1.215368),
            (10, 0.554996, 0.810609, 1.430286),
        ):
            shortening, deflection = ref.cantilever_tip(k)
            self.assertAlmostEqual(shortening, u, 6)
            self.assertAlmostEqual(deflection, w, 6)
            self.assertAlmostEqual(ref.cantilever_slope(k), slope, 6)

    def test_small_load_is_beam_theory(self):
        self.assertAlmostEqual(ref.cantilever_tip(1e-4)[1], 1e-4 / 3, 11)
        self.assertAlmostEqual(ref.cantilever_tip(1e-4, shear=0.5)[1], 1e-4 * (1 / 3 + 0.5), 10)

    def test_amples_beam(self):
        self.assertAlmostEqual(ref.beam_deflection(**AMPLE), 8.1754, 4)
        self.assertAlmostEqual(ref.beam_shortening(**AMPLE), 5.4804, 4)
        self.assertAlmostEqual(ref.beam_deflection(**AMPLE, elastica=True), 8.0624, 4)
        self.assertAlmostEqual(ref.beam_shortening(**AMPLE, elastica=True), 5.4613, 4)

    def test_slender_beam_of_the_table(self):
        """L/d = 10, nu = 0.2: the columns u/L and w/L at two loads."""
        for k, u, w in ((1, 0.056842, 0.303893), (10, 0.556942, 0.822308)):
            beam = dict(force=k / 12 / 0.96 / 100, length=10.0, depth=1.0, young=1.0, poisson=0.2)
            self.assertAlmostEqual(ref.beam_shortening(**beam) / 10, u, 6)
            self.assertAlmostEqual(ref.beam_deflection(**beam) / 10, w, 6)

    def test_small_load_on_a_beam_is_bending_and_shear(self):
        beam = dict(force=1e-4, length=10.0, depth=2.0, young=50.0, poisson=0.25)
        bending = 1e-4 * 1000 / (3 * 50 / (1 - 0.25**2) * 8 / 12)
        shear = 1e-4 * 10 / (5 / 6 * 20 * 2)
        # second order in the load, which bends the beam by 1e-4 of its length
        self.assertAlmostEqual(ref.beam_deflection(**beam) / (bending + shear), 1, 6)

    def test_beams_that_are_none_are_refused(self):
        self.assertRaises(ValueError, ref.cantilever_tip, 0.0)
        self.assertRaises(ValueError, ref.cantilever_tip, 1.0, -0.1)
        self.assertRaises(ValueError, ref.cantilever_tip, 10.0, 0.0, 0.2)
        self.assertRaises(ValueError, ref.beam_deflection, 1.0, 1.0, 0.1, 1.0, 0.5)


class Buckling(unittest.TestCase):
    def test_buckling_load_is_the_smallest_eigenvalue_of_differences(self):
        cells = 400
        matrix = 2 * np.eye(cells) - np.eye(cells, k=1) - np.eye(cells, k=-1)
        matrix[-1, -2] = -2
        eigenvalue = np.sort(np.linalg.eigvals(matrix).real)[0] * cells**2
        # second order: pi^2 / 4 * h^2 / 12 * eigenvalue, 1.3e-6 of it
        self.assertAlmostEqual(ref.euler_load(3.0, 2.0) / (3.0 / 4 * eigenvalue), 1, 5)
        self.assertAlmostEqual(ref.euler_load(1.0, 1.0), 2.467401, 6)

    def test_bent_column_fits_its_clamp(self):
        """From the free head with its slope down to the foot, where the slope must be zero."""
        for slope in (5.0, 60.0, 120.0, 160.0):
            load = ref.post_buckling_load(slope) * math.pi**2 / 4
            foot = runge_kutta(
                lambda s, y: [y[1], -load * math.sin(y[0]), math.sin(y[0]), math.cos(y[0])],
                [math.radians(slope), 0, 0, 0], 0, 1, 2000,
            )  # fmt: skip
            self.assertAlmostEqual(foot[0], 0, 9)
            self.assertAlmostEqual(foot[2], ref.post_buckling_deflection(slope), 9)
            self.assertAlmostEqual(foot[3], ref.post_buckling_height(slope), 9)

    def test_timoshenkos_sixty_degrees(self):
        self.assertAlmostEqual(ref.post_buckling_load(60), 1.15172, 5)
        self.assertAlmostEqual(ref.post_buckling_height(60), 0.741, 3)
        self.assertAlmostEqual(ref.post_buckling_deflection(60), 0.593, 3)

    def test_columns_that_are_none_are_refused(self):
        self.assertRaises(ValueError, ref.post_buckling_load, 0.0)
        self.assertRaises(ValueError, ref.post_buckling_height, 180.0)
        self.assertRaises(ValueError, ref.euler_load, 1.0, 0.0)


if __name__ == "__main__":
    unittest.main()
