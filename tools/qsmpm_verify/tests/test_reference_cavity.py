"""Cavities against quadratures, each other and the governing equations in differences."""

import math
import unittest

import numpy as np
from scipy import integrate

from qsmpm_verify.reference import cavity as ref
from qsmpm_verify.tests.routes import stiffness

SAND = dict(young=1e4, poisson=0.33, cohesion=1.0, friction=25.0, dilatancy=0.0, pressure=100.0)
DENSE = dict(young=2e4, poisson=0.2, cohesion=5.0, friction=38.0, dilatancy=12.0, pressure=50.0)


def tresca(expansion: float, rigidity: float, sphere: bool) -> float:
    """Integral of k (s_r - s_t) / r from the wall, soil elastic where G (a^m - a0^m) / r^m is below the strength."""
    power, factor = (3, 4.0) if sphere else (2, 2.0)
    first = expansion**power - 1

    def gradient(r: float) -> float:
        return factor * min(1.0, rigidity * first / r**power) / r

    front = (rigidity * first) ** (1 / power)
    inside = integrate.quad(gradient, expansion, front, epsabs=1e-12)[0]
    return inside + integrate.quad(lambda u: gradient(front / u) * front / u**2, 0, 1, epsabs=1e-12)[0]


class Tresca(unittest.TestCase):
    def test_pressure_is_the_quadrature_of_the_equilibrium(self):
        for expansion in (1.01, 1.1, 2.0, 30.0):
            for sphere in (False, True):
                own = ref.cavity_tresca(expansion, 100.0, sphere)
                self.assertAlmostEqual(own, tresca(expansion, 100.0, sphere), 9)

    def test_limit_is_a_cavity_without_bound(self):
        for sphere in (False, True):
            # (a0/a)^2 of the rest, 1e-12
            self.assertAlmostEqual(ref.cavity_tresca_limit(50.0, sphere), tresca(1e6, 50.0, sphere), 9)

    def test_printed_figures(self):
        self.assertAlmostEqual(ref.cavity_tresca_limit(100.0), 5.60517, 5)
        self.assertAlmostEqual(ref.cavity_tresca_limit(100.0, True), 7.47356, 5)
        self.assertAlmostEqual(ref.cavity_tresca(2.0, 100.0), 5.31749, 5)
        self.assertAlmostEqual(ref.cavity_tresca(2.0, 100.0, True), 7.29552, 5)

    def test_elastic_walls_are_refused(self):
        self.assertRaises(ValueError, ref.cavity_tresca, 1.001, 100.0)
        self.assertRaises(ValueError, ref.cavity_tresca, 1.0, 100.0)
        self.assertRaises(ValueError, ref.cavity_tresca_limit, 0.5)


class MohrCoulomb(unittest.TestCase):
    def test_series_and_quadrature_agree(self):
        for soil in (SAND, DENSE, SAND | {"dilatancy": 25.0}):
            for sphere in (False, True):
                for expansion in (1.02, 1.5, 4.0):
                    series = ref.cavity_mohr_coulomb(expansion, **soil, sphere=sphere)
                    self.assertAlmostEqual(
                        series / ref.cavity_mohr_coulomb_quadrature(expansion, **soil, sphere=sphere), 1, 9
                    )

    def test_a_whole_exponent_takes_its_logarithm(self):
        """gamma = alpha (beta + k) / (k (alpha - 1) beta) = 3 for alpha = 3, beta = 1, cylinder."""
        soil = SAND | {"friction": 30.0}
        whole = ref.cavity_mohr_coulomb(2.0, **soil)
        self.assertAlmostEqual(whole / ref.cavity_mohr_coulomb_quadrature(2.0, **soil), 1, 9)

    def test_limit_is_a_cavity_without_bound(self):
        for soil in (SAND, DENSE):
            for sphere in (False, True):
                far = ref.cavity_mohr_coulomb_quadrature(1e4, **soil, sphere=sphere)
                # (a0/a) to the power 1 + k/beta, which is 1.65 at least, times a slope of a few limits
                self.assertAlmostEqual(ref.cavity_mohr_coulomb_limit(**soil, sphere=sphere) / far, 1, 5)

    def test_field_obeys_the_flow_rule(self):
        """Each point of the plastic zone sees the pressure of a wall of its own expansion.

        With x = r / r0 the radius follows from equilibrium, r ~ S^(-alpha / (k (alpha - 1))); differences give
        dr / dr0, hence both logarithmic strains; less Hooke's elastic ones they must flow.
        """
        for soil, sphere in ((SAND, False), (DENSE, False), (DENSE, True)):
            k = 2 if sphere else 1
            phi, psi = math.radians(soil["friction"]), math.radians(soil["dilatancy"])
            alpha = (1 + math.sin(phi)) / (1 - math.sin(phi))
            beta = (1 + math.sin(psi)) / (1 - math.sin(psi))
            strength = 2 * soil["cohesion"] * math.cos(phi) / (1 - math.sin(phi))
            cap = strength / (alpha - 1)

            def place(x: float) -> tuple[float, float]:
                pressure = ref.cavity_mohr_coulomb(x, **soil, sphere=sphere)
                return (pressure + cap) ** (-alpha / (k * (alpha - 1))), pressure

            for x in (1.05, 1.3, 3.0):
                r, radial = place(x)
                hoop = (radial - strength) / alpha
                h = 1e-4 * x
                (low, _), (high, _) = place(x - h), place(x + h)
                change = (high - low) / (high / (x + h) - low / (x - h))
                total = np.array([math.log(change), math.log(x)])
                moduli = stiffness(soil["young"], soil["poisson"])
                drop = soil["pressure"] - np.array([radial, hoop])
                if sphere:
                    rows = np.array([moduli[0], moduli[1]]) @ np.array([[1, 0], [0, 1], [0, 1]])
                else:
                    rows = moduli[:2, :2]
                elastic = np.linalg.solve(rows, drop)
                flow = (total - elastic) @ np.array([beta, k])
                # differences of second order, 1e-8 of strains up to 1
                self.assertAlmostEqual(flow, 0, 6)

    def test_hardly_frictional_and_compressible_soil_is_tresca_soil(self):
        soil = SAND | {"friction": 0.2, "poisson": 0.4999, "cohesion": 10.0, "pressure": 0.0}
        rigidity = soil["young"] / (2 * 1.4999) / 10.0
        for sphere in (False, True):
            own = (ref.cavity_mohr_coulomb(2.0, **soil, sphere=sphere)) / 10
            # friction 0.2 degrees on up to 70 kPa adds 0.1 kPa on average to 10
            self.assertAlmostEqual(own / ref.cavity_tresca(2.0, rigidity, sphere), 1, delta=0.02)

    def test_printed_figures(self):
        for expansion, pressure in ((1.1, 305.655), (1.5, 426.284), (2, 465.016), (4, 496.200)):
            self.assertAlmostEqual(ref.cavity_mohr_coulomb(expansion, **SAND), pressure, 3)
        self.assertAlmostEqual(ref.cavity_mohr_coulomb_limit(**SAND), 505.621, 3)

    def test_soils_and_expansions_that_are_none_are_refused(self):
        wrong = {"friction": 0.0, "dilatancy": 26.0, "cohesion": -1.0, "pressure": -50.0, "poisson": 0.5}
        for change in ({name: value} for name, value in wrong.items()):
            self.assertRaises(ValueError, ref.cavity_mohr_coulomb, 2.0, **(SAND | change))
        self.assertRaises(ValueError, ref.cavity_mohr_coulomb, 1.001, **SAND)
        self.assertRaises(ValueError, ref.cavity_mohr_coulomb_quadrature, 1.001, **SAND)
        self.assertRaises(ValueError, ref.cavity_mohr_coulomb, 2.0, **(SAND | {"young": 1.0}))

    def test_a_series_that_does_not_converge_is_refused(self):
        soil = ref._Soil(**SAND, sphere=False)
        self.assertRaises(ArithmeticError, ref._lambda_one, soil, 1.5, 2.5, 1e5)
        self.assertRaises(ArithmeticError, ref.cavity_mohr_coulomb, 2.0, **(SAND | {"friction": 0.01}))


class Hencky(unittest.TestCase):
    def test_a_stiff_soil_expands_as_by_the_series(self):
        # stresses are 1/20000 of the modulus: strains of that size are what the series leaves out; a cohesion of
        # c + p0 tan(phi) stands for the pressure p0 of the start
        phi = math.radians(30.0)
        series = ref.cavity_mohr_coulomb(1.5, 1e6, 0.3, 1.0, 30.0, 0.0, 10.0) - 10.0
        growth = ref.cavity_growth_hencky(series, 1e6, 0.3, 1.0 + 10.0 * math.tan(phi), 30.0, 1e4)
        self.assertAlmostEqual(growth / 0.5, 1, 2)

    def test_a_small_pressure_is_lame(self):
        young, nu, far, pressure = 1e4, 0.3, 3.0, 1e-3
        # u = (1 + nu) p/E a (1 - 1/far^2) (1 - 2 nu)/(1 - 2 nu + 1/far^2) with the rim held
        shear, plane = young / 2 / (1 + nu), young / 2 / (1 + nu) / (1 - 2 * nu)
        slope = pressure / (2 * (plane / far**2 + shear))
        own = ref.cavity_growth_hencky(pressure, young, nu, 10.0, 30.0, far)
        self.assertAlmostEqual(own / (slope * (1 - 1 / far**2)), 1, 5)

    def test_a_tube_under_a_small_pressure_is_lame(self):
        # (1 + nu) p/E/(b^2 - 1) ((1 - 2 nu) + b^2), b = 2
        self.assertAlmostEqual(ref.tube_growth_hencky(1e-3, 1e3, 0.3, 2.0) / (1.3e-6 / 3 * 4.4), 1, 5)

    def test_a_tube_that_grows_by_a_fifth_is_softer(self):
        # the same equations as a boundary value problem by collocation (scipy.integrate.solve_bvp)
        self.assertAlmostEqual(ref.tube_growth_hencky(80.0, 1e3, 0.3, 2.0), 0.2080252, 6)


if __name__ == "__main__":
    unittest.main()
