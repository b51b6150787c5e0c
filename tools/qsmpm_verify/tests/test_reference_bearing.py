"""Bearing capacity compared with mechanisms, and the integration along slip lines with a similarity solution."""

import math
import unittest

import numpy as np
from scipy import integrate, optimize

from qsmpm_verify.reference import bearing as ref
from qsmpm_verify.reference.characteristics import Soil, march
from qsmpm_verify.tests.routes import Array, runge_kutta


class Similarity:
    """Cohesionless soil with unit weight 1 and no surcharge around the edge of a footing: s = r S(w), t(w).

    Polar angle w from the vertical, base at -90 degrees, passive zone beyond w = 45 + phi/2. The two
    characteristic equations are two linear equations for dS/dw and dt/dw, singular where a ray is a slip line; the
    time of the integration is chosen so that they are regular there. The stress S on the base is found by letting
    the solution end on the boundary of the passive zone.
    """

    def __init__(self, degrees: float, base_angle: float | None = None) -> None:
        phi = math.radians(degrees)
        self.sine, self.tan, self.spread = math.sin(phi), math.tan(phi), math.pi / 4 - phi / 2
        self.start = -(math.pi / 4 + phi / 2) if base_angle is None else base_angle

    def rates(self, _: float, state: Array) -> list[float]:
        w, t, s = state[:3]
        first, second = t + self.spread, t - self.spread
        on_first = (math.cos(first) - self.tan * math.sin(first) - s * math.cos(first - w)) / math.sin(first - w)
        sine = math.sin(second - w)
        on_second = math.cos(second) + self.tan * math.sin(second) - s * math.cos(second - w)
        return [sine, (on_first * sine - on_second) / (4 * s * self.tan), (on_first * sine + on_second) / 2]

    def end(self, stress: float) -> float:
        """Polar angle at which the solution from a stress on the base becomes a straight slip line."""

        def apart(_: float, state: Array) -> float:
            return state[1] - self.spread - state[0] - 1e-6

        apart.terminal, apart.direction = True, -1
        start = [-math.pi / 2, self.start, stress]
        found = integrate.solve_ivp(self.rates, (0, 100), start, "DOP853", events=apart, rtol=1e-9, atol=1e-11)
        return float(found.y[0, -1])

    def base_stress(self, guess: float) -> float:
        passive = math.pi / 2 - self.spread
        bracket = (0.99 * guess, 1.01 * guess)
        return optimize.brentq(lambda s: self.end(s) - passive, *bracket, xtol=1e-7 * guess)

    def wedge(self, stress: float) -> float:
        """Ngamma by vertical equilibrium of the soil above the slip line that leaves the base at distance 1."""

        def rates(time: float, state: Array) -> list[float]:
            w, t, s, r = state[:4]
            turn, *others = self.rates(time, state)
            out = r * math.cos(t - self.spread - w)
            dx = out * math.sin(w) + r * math.cos(w) * turn
            dz = out * math.cos(w) - r * math.sin(w) * turn
            radius = r * s * self.sine
            force = -(r * s + radius * math.cos(2 * t)) * dx + radius * math.sin(2 * t) * dz
            return [turn, *others, out, force + r * math.cos(w) * dx]

        def upright(_: float, state: Array) -> float:
            return state[1]

        upright.terminal = True
        sliding = stress * (1 + self.sine * math.cos(2 * self.start)) / 2
        start = [-math.pi / 2, self.start, stress, 1.0, sliding]
        found = integrate.solve_ivp(rates, (0, 100), start, "DOP853", events=upright, rtol=1e-10, atol=1e-12)
        w, _, _, r, force = found.y[:, -1]
        return float(force / (r * math.sin(w)) ** 2)


class WithoutWeight(unittest.TestCase):
    def test_prandtl_is_the_dissipation_of_his_mechanism(self):
        """Wedge, fan of thin rigid sectors and passive block on either side; width 1, speed 1, strength 1."""
        sectors = 2000
        side = speed = math.sqrt(0.5)
        angle = math.pi / 2 / sectors
        bases = sectors * 2 * side * math.tan(angle / 2) * speed / math.cos(angle / 2)
        rays = sectors * 2 * speed * math.sin(angle / 2) * side
        # outscribed sectors: their excess falls as the square of the angle
        self.assertAlmostEqual(ref.prandtl_footing(), 2 * (2 * side * speed + bases + rays), 5)
        self.assertAlmostEqual(ref.prandtl_footing(3.0), 15.42478, 5)

    def test_surcharge_factor_is_the_fan_between_two_mohr_circles(self):
        for degrees in (10.0, 25.0, 40.0):
            sine = math.sin(math.radians(degrees))
            first = 1 / (1 - sine)
            rate = 2 * math.tan(math.radians(degrees))
            last = runge_kutta(lambda _, s: rate * s, [first], 0, math.pi / 2, 200)[0]
            self.assertAlmostEqual(ref.bearing_nq(degrees) / (last * (1 + sine)), 1, 8)

    def test_march_without_weight_gives_both_factors(self):
        for degrees in (0.0, 25.0):
            soil = Soil(math.radians(degrees), 1.0, 2.0, 0.0)
            base = march(soil, np.linspace(0.1, 1, 6), 8, 0.0).base
            # no weight: exact but for the means of the radius, of second order in the fan's first sector
            expected = ref.bearing_nc(degrees) + 2 * ref.bearing_nq(degrees)
            np.testing.assert_allclose(soil.vertical(base)[0], expected, rtol=1e-12)
            np.testing.assert_allclose(soil.vertical(base), expected, rtol=1e-2)

    def test_printed_factors(self):
        for degrees, cohesion, surcharge in (
            (20, 14.834712, 6.399394), (25, 20.720531, 10.662142), (30, 30.139628, 18.401122),
            (35, 46.123599, 33.296091), (40, 75.313114, 64.195206),
        ):  # fmt: skip
            self.assertAlmostEqual(ref.bearing_nc(degrees), cohesion, 6)
            self.assertAlmostEqual(ref.bearing_nq(degrees), surcharge, 6)

    def test_no_friction_is_prandtl(self):
        self.assertAlmostEqual(ref.bearing_nc(0.0), ref.prandtl_footing(), 12)
        self.assertAlmostEqual(ref.bearing_nc(1e-4), ref.prandtl_footing(), 4)

    def test_friction_that_is_none_is_refused(self):
        for function in (ref.bearing_nc, ref.bearing_nq, ref.bearing_ngamma_smooth, ref.bearing_ngamma_rough):
            self.assertRaises(ValueError, function, 90.0)
            self.assertRaises(ValueError, function, -1.0)


class WithWeight(unittest.TestCase):
    def test_smooth_factor_is_the_similarity_solution(self):
        for degrees in (10.0, 30.0, 45.0):
            own = ref.bearing_ngamma_smooth(degrees)
            field = Similarity(degrees, 0.0)
            factor = field.base_stress(2 * own / (1 + field.sine)) * (1 + field.sine) / 2
            # march extrapolated from two spacings
            self.assertAlmostEqual(own / factor, 1, delta=2e-5)

    def test_rough_factor_is_the_similarity_solution(self):
        for degrees, stress in ((20.0, 7.572962), (30.0, 60.030729), (40.0, 701.490595)):
            field = Similarity(degrees)
            factor = field.wedge(field.base_stress(stress))
            # march extrapolated from two spacings, slip lines touch the base: not quite second order
            self.assertAlmostEqual(ref.bearing_ngamma_rough(degrees) / factor, 1, delta=5e-5)

    def test_printed_factors(self):
        for degrees, smooth, rough in (
            (20, 1.57862, 2.83894), (25, 3.46108, 6.49131), (30, 7.65300, 14.7543), (35, 17.5771, 34.4761),
            (40, 43.1866, 85.5656),
        ):  # fmt: skip
            self.assertAlmostEqual(ref.bearing_ngamma_smooth(degrees) / smooth, 1, delta=1e-5)
            self.assertAlmostEqual(ref.bearing_ngamma_rough(degrees) / rough, 1, delta=5e-5)

    def test_all_together_tends_to_its_parts(self):
        without = ref.bearing_capacity_smooth(25.0, 1.0, 1.0, 0.0, 1.0)
        self.assertAlmostEqual(without / (ref.bearing_nc(25.0) + ref.bearing_nq(25.0)), 1, 5)
        # the fan of 45 degrees reaches farther beside the footing than its width
        without = ref.bearing_capacity_smooth(45.0, 1.0, 0.0, 0.0, 1.0)
        self.assertAlmostEqual(without / ref.bearing_nc(45.0), 1, 5)
        heavy = ref.bearing_capacity_smooth(30.0, 0.0, 1.0, 2e4, 1.0)
        # the surcharge adds a few times Nq = 18 to 76530
        self.assertAlmostEqual(heavy / (1e4 * ref.bearing_ngamma_smooth(30.0)), 1, delta=2e-3)

    def test_weight_does_not_matter_without_friction(self):
        self.assertAlmostEqual(ref.bearing_capacity_smooth(0.0, 1.0, 0.5, 10.0, 2.0), 2.5 + math.pi, 6)

    def test_printed_figure_of_all_together(self):
        own = ref.bearing_capacity_smooth(25.0, 1.0, 1.0, 10.0, 0.91660)
        self.assertAlmostEqual(own, 56.195, delta=2e-3)
        self.assertGreater(own, ref.bearing_nc(25) + ref.bearing_nq(25) + 5 * 0.9166 * ref.bearing_ngamma_smooth(25))

    def test_soils_that_are_none_are_refused(self):
        self.assertRaises(ValueError, ref.bearing_capacity_smooth, 25.0, 0.0, 0.0, 10.0, 1.0)
        self.assertRaises(ValueError, ref.bearing_capacity_smooth, 50.0, 1.0, 0.0, 10.0, 1.0)
        self.assertRaises(ValueError, ref.bearing_capacity_smooth, 25.0, 1.0, 0.0, 10.0, 0.0)


def work_slope(width: float) -> float:
    """Growth of the limit load with k at k = 0: work of z over a mechanism with a wedge of this width under B = 1.

    Velocity 1 of the footing, sqrt(2) on two straight lines, an arc and the fan between, per width of the wedge.
    """
    radius = width / math.sqrt(2)
    angle = np.linspace(math.pi / 4, 3 * math.pi / 4, 20001)
    arc = float(np.sum(np.sin(angle[1:]) + np.sin(angle[:-1])) / 2 * (angle[1] - angle[0]))
    straight = radius * width / 4
    return math.sqrt(2) * (2 * straight + radius**2 * arc + radius**2 / 2 * arc) / width


class StrengthWithDepth(unittest.TestCase):
    def test_slope_at_constant_strength_is_the_work_of_the_mechanism(self):
        for function, width in ((ref.bearing_profile_smooth, 0.5), (ref.bearing_profile_rough, 1.0)):
            grown = function(0.02) - (2 + math.pi)
            self.assertAlmostEqual(grown / 0.02, work_slope(width), delta=0.02 * work_slope(width))
            self.assertLess(grown / 0.02, work_slope(width))

    def test_davis_and_booker(self):
        for ratio, rough, smooth in ((4.0, 1.487, 1.273), (8.0, 1.622, 1.370)):
            known = 2 + math.pi + ratio / 4
            self.assertAlmostEqual(ref.bearing_profile_rough(ratio) / known, rough, 3)
            self.assertAlmostEqual(ref.bearing_profile_smooth(ratio) / known, smooth, 3)

    def test_refuses(self):
        self.assertRaises(ValueError, ref.bearing_profile_rough, 0.0)
        self.assertRaises(ValueError, ref.bearing_profile_smooth, 100.0)


if __name__ == "__main__":
    unittest.main()
