"""Modified Cam-Clay paths against the integrated elastic-plastic rate."""

import unittest

import numpy as np

from qsmpm_verify.reference import cam_clay as ref
from qsmpm_verify.tests.routes import Array, runge_kutta

SLOPE, LAM, KAPPA, POISSON, VOLUME = 1.0, 0.2, 0.04, 0.3, 2.2
SOIL = (SLOPE, LAM, KAPPA)


def rates(state: Array, drive: Array, drive_rate: float, path: Array) -> Array:
    """Rates of p, q, p_c, eps_v, eps_q under two linear conditions on the first, second, fourth and fifth.

    Unknown are dp, dq, the multiplier and the two strains; rows: elasticity and flow, consistency, conditions.
    """
    p, q, size = state[:3]
    bulk = VOLUME * p / KAPPA
    shear = 3 * bulk * (1 - 2 * POISSON) / (2 * (1 + POISSON))
    f_p, f_q = SLOPE**2 * (2 * p - size), 2 * q
    hardening = size * VOLUME / (LAM - KAPPA) * f_p
    matrix = np.array([
        [1 / bulk, 0, f_p, -1, 0],
        [0, 1 / (3 * shear), f_q, 0, -1],
        [f_p, f_q, -(SLOPE**2) * p * hardening, 0, 0],
        [drive[0], drive[1], 0, drive[2], drive[3]],
        [path[0], path[1], 0, path[2], path[3]],
    ])  # fmt: skip
    found = np.linalg.solve(matrix, [0, 0, 0, drive_rate, 0])
    return np.array([found[0], found[1], hardening * found[2], found[3], found[4]])


def walked(ratio: float, path: Array) -> Array:
    """The state at a stress ratio, driven by that ratio from p = p_c = 1, q = 0."""

    def rate(eta: float, state: Array) -> Array:
        return rates(state, np.array([-eta / state[0], 1 / state[0], 0, 0]), 1.0, path)

    return runge_kutta(rate, [1.0, 0.0, 1.0, 0.0, 0.0], 0.0, ratio, 400)


class Undrained(unittest.TestCase):
    def test_path_is_the_integral_at_constant_volume(self):
        for ratio in (0.3, 0.6, 0.95):
            state = walked(ratio, np.array([0, 0, 1, 0]))
            self.assertAlmostEqual(ref.cam_clay_undrained_pressure(ratio, *SOIL), state[0], 9)

    def test_strength_is_the_integral_close_to_the_critical_state(self):
        state = walked(0.9999, np.array([0, 0, 1, 0]))
        # 1e-4 short of the critical ratio
        self.assertAlmostEqual(ref.cam_clay_undrained_strength(*SOIL), state[1] / 2, 4)

    def test_printed_figures(self):
        self.assertAlmostEqual(100 * ref.cam_clay_undrained_pressure(1.0, *SOIL), 57.434918, 6)
        self.assertAlmostEqual(ref.cam_clay_undrained_strength(*SOIL), 0.287175, 6)

    def test_soils_that_are_none_are_refused(self):
        self.assertRaises(ValueError, ref.cam_clay_undrained_pressure, 1.1, *SOIL)
        self.assertRaises(ValueError, ref.cam_clay_undrained_pressure, 0.5, 1.0, 0.2, 0.2)
        self.assertRaises(ValueError, ref.cam_clay_undrained_strength, 1.0, 0.2, -0.1)


class Drained(unittest.TestCase):
    def test_pressure_and_strains_are_the_integral_along_dq_3_dp(self):
        for ratio in (0.2, 0.6, 0.9):
            state = walked(ratio, np.array([3, -1, 0, 0]))
            self.assertAlmostEqual(ref.cam_clay_drained_pressure(ratio, SLOPE), state[0], 10)
            self.assertAlmostEqual(ref.cam_clay_drained_volume_strain(ratio, *SOIL, VOLUME), state[3], 9)
            self.assertAlmostEqual(ref.cam_clay_drained_shear_strain(ratio, *SOIL, VOLUME, POISSON), state[4], 8)

    def test_printed_figures(self):
        for ratio, pressure, volumetric, deviatoric in (
            (0.6, 125, 0.042648, 0.043608), (0.9, 142.857, 0.075576, 0.174206),
        ):  # fmt: skip
            self.assertAlmostEqual(100 * ref.cam_clay_drained_pressure(ratio, SLOPE), pressure, 3)
            self.assertAlmostEqual(ref.cam_clay_drained_volume_strain(ratio, *SOIL, VOLUME), volumetric, 6)
            self.assertAlmostEqual(ref.cam_clay_drained_shear_strain(ratio, *SOIL, VOLUME, POISSON), deviatoric, 6)
        self.assertAlmostEqual(ref.cam_clay_drained_volume_strain(1.0, *SOIL, VOLUME), 0.087271, 6)
        self.assertAlmostEqual(ref.cam_clay_drained_pressure(1.0, SLOPE), 1.5, 12)

    def test_paths_that_are_none_are_refused(self):
        self.assertRaises(ValueError, ref.cam_clay_drained_pressure, 0.5, 3.0)
        self.assertRaises(ValueError, ref.cam_clay_drained_pressure, -0.5, 1.0)
        self.assertRaises(ValueError, ref.cam_clay_drained_volume_strain, 0.5, *SOIL, 1.0)
        self.assertRaises(ValueError, ref.cam_clay_drained_shear_strain, 1.0, *SOIL, VOLUME, POISSON)
        self.assertRaises(ValueError, ref.cam_clay_drained_shear_strain, 0.5, *SOIL, VOLUME, 0.5)


class Confined(unittest.TestCase):
    def test_ratio_is_where_confined_compression_settles(self):
        def rate(_: float, state: Array) -> Array:
            return rates(state, np.array([0, 0, 1, 0]), 1.0, np.array([0, 0, 1, -1.5]))

        state = runge_kutta(rate, [1.0, 0.0, 1.0, 0.0, 0.0], 0.0, 0.6, 3000)
        # settles as p^-(a power above 2), p has grown by exp(0.6 * 2.2 / 0.2) = 735
        self.assertAlmostEqual(ref.cam_clay_confined_ratio(*SOIL, POISSON), state[1] / state[0], 5)

    def test_earth_pressure_is_the_definition_of_the_ratio(self):
        k0 = ref.cam_clay_confined_k0(*SOIL, POISSON)
        axial, lateral = 1.0, k0
        ratio = (axial - lateral) / ((axial + 2 * lateral) / 3)
        self.assertAlmostEqual(ref.cam_clay_confined_ratio(*SOIL, POISSON), ratio, 12)

    def test_printed_figures(self):
        self.assertAlmostEqual(ref.cam_clay_confined_ratio(*SOIL, POISSON), 0.341008, 6)
        self.assertAlmostEqual(ref.cam_clay_confined_k0(*SOIL, POISSON), 0.722156, 6)

    def test_soils_that_are_none_are_refused(self):
        self.assertRaises(ValueError, ref.cam_clay_confined_ratio, *SOIL, 0.5)


if __name__ == "__main__":
    unittest.main()
