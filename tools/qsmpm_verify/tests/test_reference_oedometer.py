"""The oedometer against integrated rates, energies and steps carried out one by one."""

import math
import unittest

import numpy as np

from qsmpm_verify.reference import oedometer as ref
from qsmpm_verify.tests.routes import runge_kutta, slope_of, stiffness


def integrated(strain: float, young: float = 1.0, poisson: float = 0.0) -> np.ndarray:
    """Three normal stresses of d sigma_i = (D_i1 - sigma_i) d lambda / lambda, compression positive."""
    column = stiffness(young, poisson)[:, 0]
    return -runge_kutta(lambda lam, sigma: (column - sigma) / lam, np.zeros(3), 1.0, 1.0 - strain, 1000)


def energy(stretches: tuple[float, float, float], young: float, poisson: float) -> float:
    """Strain energy of the logarithmic law per unit of initial volume."""
    logarithms = np.log(stretches)
    return float(logarithms @ stiffness(young, poisson) @ logarithms / 2)


def stepped(strain: float, steps: int) -> float:
    """Stress after equal strain steps of the first-order update, compression positive, M = 1."""
    lam, sigma, d = 1.0, 0.0, strain / steps
    for _ in range(steps):
        sigma += (1 - sigma) * (-d / lam)
        lam -= d
    return -sigma


class Moduli(unittest.TestCase):
    def test_both_moduli_are_hookes_law_without_lateral_strain(self):
        for poisson in (-0.4, 0.0, 0.33, 0.49):
            axial, lateral, _ = stiffness(7.0, poisson)[0]
            # a 3 x 3 inverse, condition below 100
            self.assertAlmostEqual(ref.constrained_modulus(7.0, poisson) / axial, 1, 12)
            self.assertAlmostEqual(ref.lateral_modulus(7.0, poisson), lateral, 11)

    def test_printed_figure(self):
        self.assertAlmostEqual(ref.constrained_modulus(1, 0.33), 1.48165, 5)

    def test_a_material_that_is_none_is_refused(self):
        for young, poisson in ((0, 0.2), (-1, 0.2), (1, 0.5), (1, -1), (math.nan, 0.2)):
            self.assertRaises(ValueError, ref.constrained_modulus, young, poisson)


class RateLaw(unittest.TestCase):
    def test_axial_and_lateral_stress_are_the_integral_of_the_rate(self):
        for strain in (-0.5, 0.1, 0.5, 0.9):
            axial, lateral, _ = integrated(strain, 3.0, 0.33)
            # Runge-Kutta 4 with 1000 steps: (0.9/1000)^4 / 0.1^4 is 7e-9, its factor 1/120
            self.assertAlmostEqual(ref.van_langen(strain, ref.constrained_modulus(3.0, 0.33)) / axial, 1, 8)
            self.assertAlmostEqual(ref.van_langen_lateral(strain, 3.0, 0.33) / lateral, 1, 8)

    def test_it_is_the_papers_exponential(self):
        for strain in (0.1, 0.5, 0.9):
            logarithmic = -math.log(1 - strain)
            self.assertAlmostEqual(ref.van_langen(strain, 3.0), 3 * (math.exp(logarithmic) - 1), 12)

    def test_printed_figures(self):
        for strain, stress in ((0.1, 0.111111), (0.3, 0.428571), (0.5, 1.0), (0.8, 4.0), (0.9, 9.0)):
            self.assertAlmostEqual(ref.van_langen(strain), stress, 6)
        self.assertAlmostEqual(ref.van_langen(0.9, ref.constrained_modulus(1, 0.33)), 13.3348, 4)
        self.assertAlmostEqual(ref.van_langen_lateral(0.9, 1, 0.33), 6.56789, 5)

    def test_full_compression_is_refused(self):
        for function in (ref.van_langen, ref.hencky_oedometer, ref.linear_oedometer):
            self.assertRaises(ValueError, function, 1.0)


class Steps(unittest.TestCase):
    def test_strain_steps_match_the_update_step_by_step(self):
        for strain, steps in ((0.9, 10), (0.9, 100), (0.3, 1), (-1.0, 7)):
            # rounding of at most 100 steps
            self.assertAlmostEqual(ref.van_langen_paper_steps(strain, steps), stepped(strain, steps), 11)

    def test_error_of_strain_steps_is_step_by_step_against_the_integral(self):
        for strain, steps in ((0.9, 10), (0.5, 100)):
            error = stepped(strain, steps) / integrated(strain)[0] - 1
            self.assertAlmostEqual(ref.van_langen_paper_steps_error(strain, steps), error, 8)

    def test_strain_steps_printed_figures(self):
        for steps, stress in ((10, 4.73684), (100, 8.25688), (1000, 8.91972)):
            self.assertAlmostEqual(ref.van_langen_paper_steps(0.9, steps), stress, 5)
        self.assertAlmostEqual(100 * ref.van_langen_paper_steps_error(0.9, 100), -8.26, 2)

    def test_load_steps_match_the_update_step_by_step(self):
        for stress, steps in ((1.0, 10), (9.0, 10), (-0.5, 4)):
            length, sigma, change = 1.0, 0.0, stress / steps
            for _ in range(steps):
                length *= 1 - change / (1 + sigma)
                sigma += change
            self.assertAlmostEqual(ref.van_langen_load_steps(stress, steps), length, 13)

    def test_load_steps_printed_figure_and_limit(self):
        self.assertAlmostEqual(ref.van_langen_load_steps(1.0, 10), 0.473684, 6)
        # first order: the difference to the exact length is below ds
        self.assertAlmostEqual(ref.van_langen_load_steps(3.0, 10**6), 0.25, 5)

    def test_steps_that_turn_the_specimen_inside_out_or_are_none_are_refused(self):
        self.assertRaises(ValueError, ref.van_langen_load_steps, 9.0, 9)
        self.assertRaises(ValueError, ref.van_langen_load_steps, -1.0, 9)
        self.assertRaises(ValueError, ref.van_langen_paper_steps, 0.5, 2.5)
        self.assertRaises(ValueError, ref.van_langen_paper_steps, 0.5, 0)
        self.assertRaises(ValueError, ref.van_langen_paper_steps_error, 1.5, 10)


class OtherLaws(unittest.TestCase):
    def test_hencky_is_the_derivative_of_its_energy(self):
        young, poisson = 2.0, 0.3
        for strain in (0.1, 0.5, 0.8):
            lam = 1 - strain
            axial = -slope_of(lambda x: energy((x, 1, 1), young, poisson), lam, 1e-5)
            lateral = -slope_of(lambda x: energy((lam, x, 1), young, poisson), 1.0, 1e-5) / lam
            modulus = ref.constrained_modulus(young, poisson)
            # central differences, 1e-10 times the third derivative (up to 1e3 at lambda = 0.2)
            self.assertAlmostEqual(ref.hencky_oedometer(strain, modulus), axial, 6)
            self.assertAlmostEqual(ref.hencky_oedometer_lateral(strain, young, poisson), lateral, 6)

    def test_hencky_printed_figures(self):
        for strain, stress in ((0.1, 0.117067), (0.3, 0.509536), (0.5, 1.38629), (0.7, 4.01324), (0.9, 23.0259)):
            self.assertAlmostEqual(ref.hencky_oedometer(strain) / stress, 1, 5)

    def test_linear_law_is_the_slope_of_both_others(self):
        for law in (ref.van_langen, ref.hencky_oedometer):
            self.assertAlmostEqual(slope_of(lambda e: law(e, 5.0), 0.0), ref.linear_oedometer(1e-3, 5.0) * 1e3, 7)

    def test_linear_law_is_hookes(self):
        strains = np.array([0.02, 0, 0])
        stress = (stiffness(4.0, 0.3) @ strains)[0]
        self.assertAlmostEqual(ref.linear_oedometer(0.02, ref.constrained_modulus(4.0, 0.3)), stress, 12)


if __name__ == "__main__":
    unittest.main()
