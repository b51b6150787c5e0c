"""Mohr-Coulomb element tests against searches over planes, stepped Hooke's law and an integrated flow rule."""

import math
import unittest

import numpy as np
from scipy import optimize

from qsmpm_verify.reference import element_tests as ref
from qsmpm_verify.tests.routes import Array, runge_kutta, stiffness

SOIL = (1.0, 25.0)


def utilisation(first: float, third: float, friction: float) -> float:
    """Largest tau - sigma tan(phi) over all planes between the two principal stresses."""
    centre, radius = (first + third) / 2, (first - third) / 2

    def on_plane(turn: float) -> float:
        return -(radius * math.sin(turn) - (centre + radius * math.cos(turn)) * math.tan(math.radians(friction)))

    return -optimize.minimize_scalar(on_plane, bounds=(0, math.pi), method="bounded", options={"xatol": 1e-10}).fun


def compressed(minor: float, poisson: float, plane: bool) -> tuple[float, float]:
    """Strain and intermediate stress at failure: stress follows Hooke's law until a plane reaches c."""
    moduli = stiffness(5e4, poisson)

    def stress(strain: float) -> Array:
        free = [2] if plane else [1, 2]
        strains = np.zeros(3)
        strains[0] = strain
        strains[free] = np.linalg.solve(moduli[np.ix_(free, free)], -moduli[free, 0] * strain)
        return minor + moduli @ strains

    failing = optimize.brentq(lambda e: utilisation(stress(e)[0], minor, SOIL[1]) - SOIL[0], 1e-6, 1.0, xtol=1e-15)
    return failing, stress(failing)[1]


def sheared(normal: float, earth_pressure: float, dilatancy: float) -> float:
    """Shear stress after elastic-plastic simple shear under a constant normal stress, compression positive.

    State: lateral stress, shear stress. No lateral strain; the vertical strain rate keeps the normal stress.
    """
    cohesion, friction, young, poisson = 1.0, 25.0, 1e4, 0.3
    shear_modulus = young / (2 * (1 + poisson))
    lame = young * poisson / ((1 + poisson) * (1 - 2 * poisson))
    sine, dilation = math.sin(math.radians(friction)), math.sin(math.radians(dilatancy))
    moduli = np.array([[lame + 2 * shear_modulus, lame, 0], [lame, lame + 2 * shear_modulus, 0], [0, 0, shear_modulus]])

    def gradient(lateral: float, tau: float, angle_sine: float) -> Array:
        half = (lateral - normal) / 2
        radius = math.hypot(half, tau)
        mobilised = np.array([half / (2 * radius), -half / (2 * radius), tau / radius])
        return mobilised - np.array([0.5, 0.5, 0]) * angle_sine

    def rate(_: float, state: Array) -> list[float]:
        f, g = gradient(*state, sine), gradient(*state, dilation)
        # unknown rates: vertical strain and plastic multiplier; stress rate D (e - mu g), shear strain rate 1
        unit, shear = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])
        matrix = np.array([[(moduli @ unit)[1], -(moduli @ g)[1]], [f @ moduli @ unit, -f @ moduli @ g]])
        vertical, multiplier = np.linalg.solve(matrix, -np.array([(moduli @ shear)[1], f @ moduli @ shear]))
        stress = moduli @ (unit * vertical + shear - multiplier * g)
        return [stress[0], stress[2]]

    lateral = earth_pressure * normal
    radius = (lateral + normal) / 2 * sine + cohesion * math.cos(math.radians(friction))
    first = math.sqrt(radius**2 - ((lateral - normal) / 2) ** 2)
    return float(runge_kutta(rate, [lateral, first], 0.0, 0.4, 800)[1])


class Failure(unittest.TestCase):
    def test_no_plane_is_beyond_the_strength(self):
        for minor, cohesion, friction in ((100.0, 1.0, 25.0), (0.0, 5.0, 0.0), (-1.0, 1.0, 25.0), (3.0, 0.0, 40.0)):
            major = ref.major_stress_at_failure(minor, cohesion, friction)
            # flat maximum of the search
            self.assertAlmostEqual(utilisation(major, minor, friction), cohesion, 9)
        self.assertAlmostEqual(utilisation(ref.flow_number(30.0), 1.0, 30.0), 0, 10)

    def test_yield_strains_and_intermediate_stress_are_stepped_hooke(self):
        strain, _ = compressed(100.0, 0.33, plane=False)
        self.assertAlmostEqual(ref.triaxial_yield_strain(100, *SOIL, 5e4) / strain, 1, 8)
        strain, between = compressed(100.0, 0.33, plane=True)
        self.assertAlmostEqual(ref.biaxial_yield_strain(100, *SOIL, 5e4, 0.33) / strain, 1, 8)
        self.assertAlmostEqual(ref.biaxial_intermediate_stress(100, *SOIL, 0.33) / between, 1, 8)

    def test_printed_figures(self):
        self.assertAlmostEqual(ref.major_stress_at_failure(100, *SOIL), 249.531, 3)
        self.assertAlmostEqual(ref.biaxial_intermediate_stress(100, *SOIL, 0.33), 149.345, 3)
        self.assertAlmostEqual(ref.triaxial_yield_strain(100, *SOIL, 5e4), 0.00299061, 8)
        self.assertAlmostEqual(ref.biaxial_yield_strain(100, *SOIL, 5e4, 0.33), 0.00266494, 8)
        self.assertAlmostEqual(ref.apex_tension(*SOIL), 2.14451, 5)

    def test_dilation_is_the_gradient_of_the_potential(self):
        for dilatancy in (0.0, 10.0, 30.0):
            def potential(stress: Array) -> float:
                first, third = stress[0], stress[2]
                return (first - third) / 2 - (first + third) / 2 * math.sin(math.radians(dilatancy))

            flow = optimize.approx_fprime(np.array([5.0, 3.0, 1.0]), potential, 1e-6)
            self.assertAlmostEqual(ref.dilation_rate(dilatancy), flow.sum() / flow[0], 7)

    def test_at_the_apex_the_strength_of_all_planes_is_used_up(self):
        tension = ref.apex_tension(3.0, 30.0)
        self.assertAlmostEqual(utilisation(-tension, -tension, 30.0), 3.0, 12)

    def test_soils_that_are_none_are_refused(self):
        self.assertRaises(ValueError, ref.major_stress_at_failure, -3.0, *SOIL)
        self.assertRaises(ValueError, ref.major_stress_at_failure, 1.0, -1.0, 25.0)
        self.assertRaises(ValueError, ref.flow_number, 90.0)
        self.assertRaises(ValueError, ref.apex_tension, 1.0, 0.0)
        self.assertRaises(ValueError, ref.biaxial_yield_strain, 1.0, 1.0, 25.0, 1.0, -0.1)
        self.assertRaises(ValueError, ref.biaxial_intermediate_stress, 1.0, 1.0, 25.0, 0.5)


class SimpleShear(unittest.TestCase):
    def test_any_earth_pressure_ends_at_davis_strength(self):
        for dilatancy in (0.0, 10.0):
            for earth_pressure in (0.5, 1.0, 2.0):
                # the rest of the way to failure decays as exp(-G gamma / tau), 40 % shear is 30 times that
                own = ref.simple_shear_strength(100.0, *SOIL, dilatancy)
                self.assertAlmostEqual(own / sheared(100.0, earth_pressure, dilatancy), 1, 6)

    def test_printed_figures(self):
        self.assertAlmostEqual(ref.simple_shear_strength(100, *SOIL, 0.0), 43.1681, 4)
        self.assertAlmostEqual(ref.davis_cohesion(1.0, 25.0, 0.0), 0.906308, 6)
        self.assertAlmostEqual(ref.davis_friction(25.0, 0.0), 22.9098, 4)

    def test_associated_flow_keeps_the_strengths(self):
        self.assertAlmostEqual(ref.davis_factor(25.0, 25.0), 1, 14)
        self.assertAlmostEqual(ref.davis_friction(25.0, 25.0), 25.0, 12)

    def test_more_dilatancy_than_friction_is_refused(self):
        self.assertRaises(ValueError, ref.davis_factor, 25.0, 26.0)
        self.assertRaises(ValueError, ref.davis_cohesion, -1.0, 25.0, 0.0)


class EarthPressure(unittest.TestCase):
    def test_it_is_hookes_law_without_lateral_strain(self):
        axial, lateral, _ = stiffness(1.0, 0.33)[0]
        self.assertAlmostEqual(ref.elastic_earth_pressure(0.33), lateral / axial, 12)
        self.assertAlmostEqual(ref.elastic_earth_pressure(0.33), 0.4925, 4)
        self.assertGreater(ref.elastic_earth_pressure(0.33), 1 / ref.flow_number(25.0))
        self.assertRaises(ValueError, ref.elastic_earth_pressure, 0.5)


if __name__ == "__main__":
    unittest.main()
