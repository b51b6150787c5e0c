"""Undrained strength against stepped elasticity at constant volume, the layer against its energy."""

import math
import unittest

import numpy as np

from qsmpm_verify.reference import undrained as ref

COHESION, FRICTION = 7.0, 27.0


def mobilised(stress: list[float], planes: int = 200001) -> float:
    """Largest of tau - sigma tan phi over all planes, less c."""
    major, minor = max(stress), min(stress)
    angle = np.linspace(0, math.pi / 2, planes)
    normal = (major + minor) / 2 + (major - minor) / 2 * np.cos(2 * angle)
    shear = (major - minor) / 2 * np.sin(2 * angle)
    return float(np.max(shear - normal * math.tan(math.radians(FRICTION))) - COHESION)


class Strength(unittest.TestCase):
    def test_triaxial_deviator_touches_the_strength(self):
        q = ref.undrained_triaxial_deviator(100.0, COHESION, FRICTION)
        self.assertAlmostEqual(mobilised([100 + 2 * q / 3, 100 - q / 3, 100 - q / 3]), 0.0, 6)
        self.assertAlmostEqual(ref.undrained_triaxial_deviator(100.0, 0.0, 30.0), 120.0, 12)

    def test_plane_strength_is_that_of_stepped_elasticity(self):
        major, minor, shear = 90.0, 60.0, 1000.0
        along, step = 0.5 * (major + minor), 1e-5
        while mobilised([major, minor, along], 2001) < 0:
            major, minor = major + 2 * shear * step, minor - 2 * shear * step
        self.assertAlmostEqual((major - minor) / 2, ref.undrained_plane_strength(90.0, 60.0, COHESION, FRICTION), 1)

    def test_refuses(self):
        self.assertRaises(ValueError, ref.undrained_triaxial_deviator, 0.0, 1.0, 30.0)
        self.assertRaises(ValueError, ref.undrained_plane_strength, 90.0, 60.0, -1.0, 30.0)


class Column(unittest.TestCase):
    def test_load_is_the_slope_of_the_energy(self):
        young, poisson, undrained, load = 1000.0, 0.3, 0.495, 100.0
        stretch = ref.undrained_column_stretch(load, young, poisson, undrained)
        lame = [young * nu / ((1 + nu) * (1 - 2 * nu)) for nu in (poisson, undrained)]
        shear = [young / (2 * (1 + nu)) for nu in (poisson, undrained)]
        confined = lame[0] + 2 * shear[0]
        bulk_u = shear[0] * (2 / 3) * (1 + undrained) / (1 - 2 * undrained)
        water = bulk_u - (lame[0] + 2 * shear[0] / 3)

        def energy(ratio: float) -> float:
            return confined * math.log(ratio) ** 2 / 2 + water * (ratio * math.log(ratio) - ratio)

        step = 1e-6
        slope = (energy(stretch + step) - energy(stretch - step)) / (2 * step)
        self.assertAlmostEqual(slope, -load, 4)
        pressure = ref.undrained_column_pressure(load, young, poisson, undrained)
        self.assertAlmostEqual(pressure, -water * math.log(stretch), 8)

    def test_refuses(self):
        self.assertRaises(ValueError, ref.undrained_column_stretch, 100.0, 1000.0, 0.3, 0.3)
        self.assertRaises(ValueError, ref.undrained_column_pressure, -1.0, 1000.0, 0.3, 0.4)


if __name__ == "__main__":
    unittest.main()
