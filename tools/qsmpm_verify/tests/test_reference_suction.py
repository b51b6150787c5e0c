"""Water in suction: curves by hand, rain at its ends, a column at its start and at rest."""

from __future__ import annotations

import math
import unittest

from qsmpm_verify.reference import suction as ref


class Suction(unittest.TestCase):
    def test_curves(self) -> None:
        self.assertAlmostEqual(ref.held_water(1.0, 1.0, 2.0), math.sqrt(0.5), delta=1e-12)
        self.assertEqual(ref.held_water(-3.0, 1.0, 2.0), 1.0)
        self.assertAlmostEqual(ref.let_water(1.0, 1.0, 2.0), 0.5**0.25 * (1 - math.sqrt(0.5)) ** 2, delta=1e-12)
        with self.assertRaises(ValueError):
            ref.held_water(1.0, 1.0, 0.9)

    def test_rain(self) -> None:
        self.assertAlmostEqual(ref.rain_suction(2.0, 0.0, 1.5, 2.2), 2.0, delta=1e-9)
        high = ref.rain_suction(40.0, 0.1, 1.5, 2.2)
        self.assertAlmostEqual(ref.let_water(high, 1.5, 2.2), 0.1, delta=1e-6)

    def test_column(self) -> None:
        self.assertAlmostEqual(ref.draining_column(1e-5, 0.3, 0.5, 2.4), 1.0, delta=0.05)
        self.assertAlmostEqual(ref.draining_column(20.0, 0.3, 0.5, 2.4), 0.0, delta=1e-4)
        places = [(i + 0.5) / 1000 for i in range(1000)]
        held = sum(ref.held_water(z, 0.5, 2.4) * z for z in places) / 1000
        self.assertAlmostEqual(ref.draining_column(20.0, 0.3, 0.5, 2.4, modulus=200.0, settlement=True), held / 200, delta=2e-6)
        light = ref.draining_column(20.0, 0.3, 0.5, 2.4, modulus=200.0, loss=0.3, settlement=True)
        gone = sum(0.3 * (1 - ref.held_water(z, 0.5, 2.4)) * z for z in places) / 1000
        self.assertAlmostEqual(light, (held - gone) / 200, delta=2e-6)


if __name__ == "__main__":
    unittest.main()
