"""Simple shear and rigid turns against integrations and updates with matrices."""

import math
import unittest

import numpy as np
from scipy import linalg

from qsmpm_verify.reference import shear as ref
from qsmpm_verify.tests.routes import Array, runge_kutta

STRAIN = np.array([[0, 0.5], [0.5, 0]])
SPIN = np.array([[0, 0.5], [-0.5, 0]])
GAMMAS = (0.3, 1.0, 2.0, math.pi, 4.0)


def jaumann(gamma: float) -> Array:
    """Stress by Runge-Kutta, d s = 2 G d + w s - s w a unit of shear."""

    def rate(_: float, flat: Array) -> Array:
        s = flat.reshape(2, 2)
        return (2 * STRAIN + SPIN @ s - s @ SPIN).ravel()

    return runge_kutta(rate, np.zeros(4), 0, gamma, 400).reshape(2, 2)


def green_naghdi(gamma: float) -> Array:
    """Stress by Simpson's rule in the axes that turn with R of F = R U."""

    def turn(g: float) -> Array:
        return linalg.polar(np.array([[1, g], [0, 1]]))[0]

    places = np.linspace(0, gamma, 401)
    rates = np.array([turn(g).T @ (2 * STRAIN) @ turn(g) for g in places])
    weights = np.ones(401)
    weights[1:-1:2], weights[2:-1:2] = 4, 2
    turned = np.tensordot(weights, rates, 1) * gamma / 400 / 3
    return turn(gamma) @ turned @ turn(gamma).T


def logarithmic(gamma: float) -> Array:
    """G ln(F F^T)."""
    f = np.array([[1, gamma], [0, 1]])
    return linalg.logm(f @ f.T).real


class SimpleShear(unittest.TestCase):
    def compare(self, route, tangential, normal, digits: int) -> None:
        for gamma in GAMMAS:
            for sign in (1, -1):
                stress = 3 * route(sign * gamma)
                self.assertAlmostEqual(tangential(sign * gamma, 3.0), stress[0, 1], digits)
                self.assertAlmostEqual(normal(sign * gamma, 3.0), stress[0, 0], digits)
                self.assertAlmostEqual(stress[0, 0], -stress[1, 1], 9)

    def test_jaumann_is_the_integral_of_its_rate(self):
        # Runge-Kutta 4, step 0.01: 1e-9
        self.compare(jaumann, ref.shear_jaumann, ref.shear_jaumann_normal, 8)

    def test_green_naghdi_is_the_integral_in_turned_axes(self):
        self.compare(green_naghdi, ref.shear_green_naghdi, ref.shear_green_naghdi_normal, 8)

    def test_logarithmic_is_the_matrix_logarithm(self):
        self.compare(logarithmic, ref.shear_logarithmic, ref.shear_logarithmic_normal, 11)

    def test_printed_figures(self):
        table = {
            ref.shear_jaumann: (0.841471, 0.909297, 0, -0.756802),
            ref.shear_jaumann_normal: (0.459698, 1.416147, 2, 1.653644),
            ref.shear_green_naghdi: (0.869784, 1.386294, 1.883288, 2.317944),
            ref.shear_green_naghdi_normal: (0.415900, 1.141593, 1.844244, 2.274201),
            ref.shear_logarithmic: (0.860818, 1.246450, 1.324747, 1.291227),
            ref.shear_logarithmic_normal: (0.430409, 1.246450, 2.080908, 2.582454),
        }
        for function, figures in table.items():
            for gamma, figure in zip((1, 2, math.pi, 4), figures):
                self.assertAlmostEqual(function(gamma), figure, 6)
        self.assertAlmostEqual(ref.shear_logarithmic(3.01776), 1.325487, 6)
        for near in (2.9, 3.1):
            self.assertLess(ref.shear_logarithmic(near), ref.shear_logarithmic(3.01776))


class Steps(unittest.TestCase):
    @staticmethod
    def stepped(gamma: float, steps: int, halves: bool) -> float:
        """s12 (G = 1) by the update with matrices."""
        h, s = gamma / steps, np.zeros((2, 2))
        half = linalg.sqrtm(np.linalg.solve(np.eye(2) - h * SPIN / 2, np.eye(2) + h * SPIN / 2)).real
        for _ in range(steps):
            if halves:
                s = half @ (half @ s @ half.T + 2 * h * STRAIN) @ half.T
            else:
                s = s + h * (2 * STRAIN + SPIN @ s - s @ SPIN)
        return float(s[0, 1])

    def test_steps_are_the_update_with_matrices(self):
        for gamma, steps in ((2.0, 10), (2.0, 100), (-1.0, 7), (0.5, 1)):
            self.assertAlmostEqual(ref.shear_jaumann_paper_steps(gamma, steps), self.stepped(gamma, steps, False), 12)
            self.assertAlmostEqual(ref.shear_jaumann_midpoint_steps(gamma, steps), self.stepped(gamma, steps, True), 12)
        self.assertEqual(ref.shear_jaumann_midpoint_steps(0.0, 3), 0.0)

    def test_printed_errors_and_orders(self):
        def error(function, steps: int) -> float:
            return abs(function(2.0, steps) / math.sin(2.0) - 1)

        # printed to two figures as error over G
        scale = math.sin(2.0)
        self.assertAlmostEqual(error(ref.shear_jaumann_paper_steps, 100) * scale, 1.85e-2, delta=1.5e-4)
        self.assertAlmostEqual(error(ref.shear_jaumann_midpoint_steps, 100) * scale, 3.0e-5, delta=1e-6)
        for function, order in ((ref.shear_jaumann_paper_steps, 1), (ref.shear_jaumann_midpoint_steps, 2)):
            self.assertAlmostEqual(math.log2(error(function, 200) / error(function, 400)), order, 1)

    def test_steps_that_are_none_are_refused(self):
        self.assertRaises(ValueError, ref.shear_jaumann_paper_steps, 1.0, 0)
        self.assertRaises(ValueError, ref.shear_jaumann_midpoint_steps, 1.0, 1.5)


class RigidTurn(unittest.TestCase):
    @staticmethod
    def stepped(steps: int, shear: float, lame: float) -> tuple[float, float, float, float]:
        """Strain sum, size of the deviator, mean stress and volume of the update with strain sym(R) - I."""
        a = 2 * math.pi / steps
        gradient = np.array([[math.cos(a) - 1, -math.sin(a)], [math.sin(a), math.cos(a) - 1]])
        strain, spin = (gradient + gradient.T) / 2, (gradient - gradient.T) / 2
        stress, total, volume = np.diag([1.0, -1.0]), 0.0, 1.0
        for _ in range(steps):
            hooke = 2 * shear * strain + lame * np.trace(strain) * np.eye(2)
            stress = stress + hooke + spin @ stress - stress @ spin - stress * np.trace(strain)
            total += strain[0, 0]
            volume *= 1 + np.trace(strain)
        mean = np.trace(stress) / 2
        return total, float(np.linalg.norm(stress - mean * np.eye(2)) / math.sqrt(2)), float(mean), volume

    def test_all_four_figures_are_the_update_with_matrices(self):
        for steps, shear, lame in ((36, 1.0, 1.0), (90, 0.5, 2.0), (360, 1.0, 1.0)):
            strain, deviator, mean, volume = self.stepped(steps, shear, lame)
            self.assertAlmostEqual(ref.rigid_turn_false_strain(steps), strain, 12)
            self.assertAlmostEqual(ref.rigid_turn_false_deviator(steps) / deviator, 1, 11)
            self.assertAlmostEqual(ref.rigid_turn_false_mean_stress(steps, shear=shear, lame=lame), mean, 10)
            self.assertAlmostEqual(ref.rigid_turn_false_volume(steps), volume, 12)

    def test_printed_figures(self):
        for steps, strain, deviator, mean in (
            (36, -0.5469, 20.377, -3.875), (90, -0.2192, 3.657, -1.097), (360, -0.0548, 1.389, -0.232),
            (3600, -0.0055, 1.033, -0.022),
        ):  # fmt: skip
            self.assertAlmostEqual(ref.rigid_turn_false_strain(steps), strain, 4)
            self.assertAlmostEqual(ref.rigid_turn_false_deviator(steps), deviator, 3)
            self.assertAlmostEqual(ref.rigid_turn_false_mean_stress(steps), mean, 3)
        limit = math.exp(12 * math.pi**2 / 36000)
        # second term of the logarithm: of the order of a^2
        self.assertAlmostEqual(ref.rigid_turn_false_deviator(36000) / limit, 1, 6)

    def test_too_large_a_step_has_no_volume(self):
        self.assertRaises(ValueError, ref.rigid_turn_false_volume, 6)


if __name__ == "__main__":
    unittest.main()
