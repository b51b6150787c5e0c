"""Slopes against polygons, plain slices and searches by another method."""

import math
import unittest

import numpy as np
from scipy import optimize

from qsmpm_verify.reference import slope as ref
from qsmpm_verify.reference.element_tests import davis_cohesion, davis_friction

CHORDS = 400


def searched(number, bounds) -> float:
    """Smallest value over slip surfaces by differential evolution, then a simplex."""
    found = optimize.differential_evolution(number, bounds, seed=1, tol=1e-10, maxiter=120, popsize=12, polish=False)
    end = optimize.minimize(number, found.x, method="Nelder-Mead", options={"xatol": 1e-7, "fatol": 1e-11})
    return float(end.fun)


def spiral_by_polygon(place, friction: float, angle: float) -> float:
    """g H / c: dissipation along chords of the spiral over the moment of the polygon's weight about the pole."""
    start, end = place
    if end <= start + 1e-3:
        return 1e9 * (1 + start - end)
    turn = np.linspace(start, end, CHORDS + 1)
    radius = np.exp((turn - start) * math.tan(friction))
    x, depth = radius * np.cos(turn), radius * np.sin(turn)
    height = depth[-1] - depth[0]
    corner = x[-1] + height / math.tan(angle)
    if height <= 1e-6 or corner >= x[0]:
        return 1e8 * (1 + max(-height, 0) + max(corner - x[0], 0))
    # crest point, spiral to the toe, up the face to the crest corner
    px, py = np.append(x, corner), np.append(depth, depth[0])
    cross = px * np.roll(py, -1) - np.roll(px, -1) * py
    moment = float(np.sum((px + np.roll(px, -1)) * cross) / 6)
    middle = np.hypot(x[1:] + x[:-1], depth[1:] + depth[:-1]) / 2
    spent = float(np.sum(middle * np.hypot(np.diff(x), np.diff(depth)))) * math.cos(friction)
    return spent * height / moment if moment > 1e-9 else 1e9


def slices(place, angle: float, height: float):
    """Width, weight, sine and cosine of plain slices of the circle with centre `place` through the toe."""
    cx, cy = place
    radius = math.hypot(cx, cy)
    if cy < height or cx - radius > 0:
        return None
    far = cx + math.sqrt(radius**2 - (cy - height) ** 2)
    if far <= height / math.tan(angle):
        return None
    edges = np.linspace(0, far, CHORDS + 1)
    x, width = (edges[1:] + edges[:-1]) / 2, np.diff(edges)
    sine = (x - cx) / radius
    cosine = np.sqrt(1 - sine**2)
    weight = width * (np.minimum(x * math.tan(angle), height) - cy + radius * cosine)
    return (width, weight, sine, cosine) if np.sum(weight * sine) > 1e-9 else None


def bishop_by_slices(place, load, friction: float, angle: float) -> float:
    """Factor of safety of a circle, H = 1, load = g / c, by iterating on F."""
    cut = slices(place, angle, 1.0)
    if cut is None:
        return 1e9
    width, weight, sine, cosine = cut
    factor = 1.0
    for _ in range(200):
        share = cosine + sine * math.tan(friction) / factor
        if np.min(share) < 0.1:
            return 1e9
        held = np.sum((width / load + weight * math.tan(friction)) / share)
        new = float(held / np.sum(weight * sine))
        if abs(new - factor) < 1e-11:
            break
        factor = new
    return factor


class Spiral(unittest.TestCase):
    def by_polygons(self, friction: float, angle: float) -> float:
        return searched(
            lambda p: spiral_by_polygon(p, math.radians(friction), math.radians(angle)), [(0.05, 2.2), (0.2, 3.1)]
        )

    def test_unit_weight_is_the_best_polygon(self):
        for friction, angle in ((25.0, 45.0), (10.0, 70.0), (25.0, 90.0)):
            own = ref.slope_spiral_unit_weight(2.0, friction, angle, 4.0)
            # 400 chords, second order: 1e-5
            self.assertAlmostEqual(own / (0.5 * self.by_polygons(friction, angle)), 1, delta=5e-5)

    def test_printed_unit_weights(self):
        self.assertAlmostEqual(ref.slope_associated_unit_weight(), 22.896, 3)
        self.assertAlmostEqual(ref.slope_davis_unit_weight(), 17.787, 3)

    def test_safety_makes_the_reduced_strengths_critical(self):
        for load in (10.0, 20.0, 40.0):
            factor = ref.slope_spiral_safety(load, 1.0, 25.0, 45.0, 1.0)
            friction = math.degrees(math.atan(math.tan(math.radians(25.0)) / factor))
            reduced = self.by_polygons(friction, 45.0) / factor
            self.assertAlmostEqual(reduced / load, 1, delta=5e-5)

    def test_printed_safeties(self):
        for load, associated, davis in ((10, 1.4324, 1.2982), (15, 1.1855, 1.0744), (20, 1.0529, 0.9543)):
            self.assertAlmostEqual(ref.slope_spiral_safety(load, 1.0, 25.0, 45.0, 1.0), associated, delta=1e-4)
            strengths = davis_cohesion(1.0, 25.0, 0.0), davis_friction(25.0, 0.0)
            self.assertAlmostEqual(ref.slope_spiral_safety(load, *strengths, 45.0, 1.0), davis, delta=1e-4)
        self.assertAlmostEqual(ref.slope_spiral_safety(20.0, 1.0, 20.0, 26.57, 1.0), 1.3682, delta=2e-4)

    def test_davis_makes_the_reduced_strengths_critical(self):
        for load, dilatancy, davis in ((10.0, 0.0, ref.slope_davis_a_safety), (15.0, 8.0, ref.slope_davis_b_safety)):
            factor = davis(load, 1.0, 25.0, dilatancy, 45.0, 1.0)
            friction = math.degrees(math.atan(math.tan(math.radians(25.0)) / factor))
            phi = math.radians(friction if davis is ref.slope_davis_b_safety else 25.0)
            psi = math.radians(dilatancy)
            b = math.cos(psi) * math.cos(phi) / (1 - math.sin(psi) * math.sin(phi))
            lowered = math.degrees(math.atan(b * math.tan(math.radians(friction))))
            self.assertAlmostEqual(b * self.by_polygons(lowered, 45.0) / factor / load, 1, delta=1e-4)

    def test_printed_davis_safeties(self):
        for load, a, b in ((10, 1.2982, 1.3544), (15, 1.0744, 1.0900), (20, 0.9542, 0.9440)):
            self.assertAlmostEqual(ref.slope_davis_a_safety(load, 1.0, 25.0, 0.0, 45.0, 1.0), a, delta=1e-4)
            self.assertAlmostEqual(ref.slope_davis_b_safety(load, 1.0, 25.0, 0.0, 45.0, 1.0), b, delta=1e-4)

    def test_davis_of_associated_flow_is_the_spiral(self):
        spiral = ref.slope_spiral_safety(15.0, 1.0, 25.0, 45.0, 1.0)
        for davis in (ref.slope_davis_a_safety, ref.slope_davis_b_safety):
            self.assertAlmostEqual(davis(15.0, 1.0, 25.0, 25.0, 45.0, 1.0), spiral, delta=1e-7)

    def test_a_light_vertical_cut_is_very_safe(self):
        factor = ref.slope_spiral_safety(0.5, 1.0, 25.0, 90.0, 1.0)
        friction = math.degrees(math.atan(math.tan(math.radians(25.0)) / factor))
        self.assertGreater(factor, 4.0)
        self.assertAlmostEqual(self.by_polygons(friction, 90.0) / factor, 0.5, delta=5e-5)

    def test_steepest_slope_is_critical(self):
        for load, associated, davis in ((30, 40.6, 36.4), (50, 35.0, 31.6), (100, 30.7, 27.9)):
            angle = ref.slope_steepest_angle(load, 25.0)
            self.assertAlmostEqual(angle, associated, delta=0.05)
            self.assertAlmostEqual(self.by_polygons(25.0, angle) / load, 1, delta=2e-4)
            reduced = load / davis_cohesion(1.0, 25.0, 0.0)
            self.assertAlmostEqual(ref.slope_steepest_angle(reduced, davis_friction(25.0, 0.0)), davis, delta=0.05)

    def test_slopes_that_are_none_are_refused(self):
        self.assertRaises(ValueError, ref.slope_spiral_unit_weight, 1.0, 25.0, 25.5, 1.0)
        self.assertRaises(ValueError, ref.slope_spiral_unit_weight, 0.0, 25.0, 45.0, 1.0)
        self.assertRaises(ValueError, ref.slope_spiral_unit_weight, 1.0, 0.5, 45.0, 1.0)
        self.assertRaises(ValueError, ref.slope_bishop_safety, -1.0, 1.0, 25.0, 45.0, 1.0)
        self.assertRaises(ValueError, ref.slope_steepest_angle, 3.0, 25.0)


class Bishop(unittest.TestCase):
    @staticmethod
    def best(load: float, friction: float, angle: float) -> float:
        wide = 1 / math.tan(angle)
        return searched(
            lambda p: bishop_by_slices(p, load, friction, angle), [(-2.0, wide + 1.0), (1.0, 3.0 + 2 * wide)]
        )

    def test_safety_is_the_best_circle_of_plain_slices(self):
        for load, friction, angle in ((20.0, 25.0, 45.0), (20.0, 20.0, 26.57)):
            own = ref.slope_bishop_safety(2 * load, 4.0, friction, angle, 2.0)
            # 400 slices, second order but for the corner of the crest
            self.assertAlmostEqual(own / self.best(load, math.radians(friction), math.radians(angle)), 1, delta=5e-5)

    def test_unit_weight_has_a_safety_of_one(self):
        load = ref.slope_bishop_unit_weight(1.0, 25.0, 45.0, 1.0)
        self.assertAlmostEqual(self.best(load, math.radians(25.0), math.pi / 4), 1, delta=5e-5)
        self.assertAlmostEqual(ref.slope_bishop_unit_weight(3.0, 25.0, 45.0, 2.0), 1.5 * load, 9)

    def test_printed_figures(self):
        for load, factor in ((10, 1.4273), (15, 1.1836), (20, 1.0526)):
            # the printed ones are from coarser slices
            self.assertAlmostEqual(ref.slope_bishop_safety(load, 1.0, 25.0, 45.0, 1.0), factor, delta=4e-4)
        self.assertAlmostEqual(ref.slope_bishop_safety(20.0, 1.0, 20.0, 26.57, 1.0), 1.3684, delta=2e-4)
        self.assertAlmostEqual(ref.slope_bishop_unit_weight(1.0, 25.0, 45.0, 1.0), 22.900, delta=0.012)

    def test_a_vertical_cut_has_a_safety_of_one(self):
        load = ref.slope_bishop_unit_weight(1.0, 10.0, 90.0, 1.0)
        # the arc is steep behind the crest, where plain slices are coarse
        self.assertAlmostEqual(self.best(load, math.radians(10.0), math.pi / 2), 1, delta=2e-4)


class Searches(unittest.TestCase):
    def test_surfaces_that_do_not_exist_are_never_critical(self):
        slope, angle = math.tan(math.radians(25.0)), math.pi / 4
        for place in ((1.0, 0.5), (0.2, 0.21), (0.1, 0.3), (1.5, 3.1)):
            self.assertEqual(ref._spiral(place, slope, angle), ref.NEVER)
        for place in ((-1.0, 0.5), (0.5, 1e-9), (0.3, 1.5)):
            self.assertEqual(ref._circle(place, slope, angle), ref.NEVER)

    def test_a_slope_as_steep_as_its_friction_has_no_slip_surface(self):
        self.assertEqual(ref._spiral_number(math.radians(25.0), math.radians(25.01)), ref.NEVER)
        self.assertRaises(ArithmeticError, ref.slope_bishop_unit_weight, 1.0, 60.0, 61.0, 1.0)


class Elastic(unittest.TestCase):
    def test_settlement_is_the_source_figure_and_between_bounds(self):
        """3.04384 kPa m at 10 kN/m3; less than a free column of that height, more than a third of a confined one."""
        self.assertAlmostEqual(50 * ref.slope_elastic_settlement(10, 50), 3.04384, 5)
        free, confined = 0.5, 0.5 * (1.33 * 0.34) / 0.67
        self.assertLess(ref.slope_elastic_settlement(1.0), free)
        self.assertGreater(ref.slope_elastic_settlement(1.0), confined / 3)
        self.assertRaises(ValueError, ref.slope_elastic_settlement, 1.0, 0.0)


if __name__ == "__main__":
    unittest.main()
