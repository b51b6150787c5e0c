"""T-bar, plate, upsetting, loads on points, crossed cells, iterations: each by carrying the thing out."""

import math
import unittest

import numpy as np
from scipy import integrate

from qsmpm_verify.reference import iteration, penetration, points, upsetting
from qsmpm_verify.tests.routes import runge_kutta


class TBar(unittest.TestCase):
    @staticmethod
    def by_tractions(roughness: float) -> float:
        """Force of the slip-line field on the front half, doubled, over s_u times the diameter (radius 1).

        A slip line meets the surface at the angle m, alpha = cos 2m. From the far equator, where the stress is the
        one at rest, it turns by pi/2 - m to the equator of the cylinder, on by pi/2 - place to a place on the
        front, 2 s_u a radian. A cap of dead soil with straight slip lines at 45 degrees sits
        on the nose up to the place pi/4 - m.
        """
        m = math.acos(roughness) / 2
        nose = math.pi / 4 - m

        def mean(place: float) -> float:
            return 2 * (math.pi / 2 - m) + 2 * (math.pi / 2 - place)

        def traction(place: float) -> float:
            normal = mean(place) + math.sin(2 * m)
            return normal * math.cos(place) + roughness * math.sin(place)

        # the cap's sides run at 45 degrees over the height sin(nose), pressure and shear on each
        cap = (mean(nose) + 1) * math.sin(nose)
        return 2 * (cap + integrate.quad(traction, nose, math.pi / 2)[0])

    def test_factor_is_the_sum_of_the_tractions(self):
        for roughness in (0.0, 0.3, 0.5, 0.9, 1.0):
            self.assertAlmostEqual(penetration.t_bar_factor(roughness), self.by_tractions(roughness), 10)

    def test_printed_figures(self):
        for roughness, factor in ((0, 9.14159), (0.5, 10.81982), (1, 11.94004)):
            self.assertAlmostEqual(penetration.t_bar_factor(roughness), factor, 5)
        self.assertRaises(ValueError, penetration.t_bar_factor, 1.1)


class Plate(unittest.TestCase):
    def test_factor_is_the_dissipation_of_wedges_and_fans(self):
        """Width 1, speed 1: two wedges with sides sqrt(1/2), a fan of 270 degrees around each edge in thin sectors."""
        sectors = 6000
        side = speed = math.sqrt(0.5)
        angle = 1.5 * math.pi / sectors
        base = 2 * side * math.tan(angle / 2) * speed / math.cos(angle / 2)
        fan = sectors * (base + 2 * speed * math.sin(angle / 2) * side)
        sides = 4 * side * speed
        # outscribed sectors, second order in the angle
        self.assertAlmostEqual(penetration.deep_plate_factor(), sides + 2 * fan, 5)
        self.assertAlmostEqual(penetration.deep_plate_factor(), 11.42478, 5)


class Upsetting(unittest.TestCase):
    def test_force_is_strength_times_the_width_of_kept_volume(self):
        """dW / dH = -W / H by Runge-Kutta to H/H0 = 0.3."""
        width = runge_kutta(lambda height, width: -width / height, [1.0], 1.0, 0.3, 400)[0]
        self.assertAlmostEqual(upsetting.upsetting_force(0.3), width, 9)

    def test_force_is_the_plastic_work_rate_over_the_speed(self):
        """Largest shear strain rate 2/H per speed in a volume of 1, strength 1/2 of the unit 2 s_u."""
        for ratio in (1.0, 0.6, 0.2):
            stretching = np.diag([1 / ratio, -1 / ratio])
            largest_shear = np.ptp(np.linalg.eigvalsh(stretching))
            self.assertAlmostEqual(upsetting.upsetting_force(ratio), largest_shear / 2, 12)

    def test_work_is_the_quadrature_of_the_force(self):
        work = integrate.quad(upsetting.upsetting_force, 0.3, 1.0)[0]
        self.assertAlmostEqual(upsetting.upsetting_work(0.3), work, 11)

    def test_blocks_that_grow_or_vanish_are_refused(self):
        self.assertRaises(ValueError, upsetting.upsetting_force, 1.1)
        self.assertRaises(ValueError, upsetting.upsetting_work, 0.0)


def solved_bar(places: np.ndarray, volumes: np.ndarray, cells: int, loads: np.ndarray) -> np.ndarray:
    """Stresses of cells of unit length of a bar fixed at 0: assembled from the points, E = 1, small strain."""
    matrix = np.zeros((cells + 1, cells + 1))
    for place, volume in zip(places, volumes):
        c = int(place)
        matrix[c : c + 2, c : c + 2] += volume * np.array([[1, -1], [-1, 1]])
    displacement = np.zeros(cells + 1)
    displacement[1:] = np.linalg.solve(matrix[1:, 1:], loads[1:])
    return np.diff(displacement)


class Points(unittest.TestCase):
    def test_load_on_points_is_an_assembled_bar(self):
        for per_cell in (1, 2, 3, 4):
            places = (np.arange(4 * per_cell) + 0.5) / per_cell
            loads = np.zeros(5)
            loads[3], loads[4] = 4 - places[-1], places[-1] - 3
            stresses = solved_bar(places, np.full(len(places), 1 / per_cell), 4, loads)
            self.assertAlmostEqual(points.surface_load_share(per_cell), stresses[-1], 12)
            np.testing.assert_allclose(stresses[:-1], 1, rtol=1e-12)

    def test_crossed_cells_are_an_assembled_bar(self):
        for per_cell, stretch in ((2, 0.75), (2, 0.9), (4, 0.9), (3, 1.2)):
            cells = 60
            places = (np.arange(cells * per_cell) + 0.5) / per_cell * stretch
            cells = int(places[-1])
            inside = places[places < cells]
            loads = np.zeros(cells + 1)
            loads[-1] = 1.0
            stresses = solved_bar(inside, np.full(len(inside), stretch / per_cell), cells, loads)
            for cell, count in enumerate(np.bincount(inside.astype(int))):
                self.assertAlmostEqual(points.crossed_cell_stress(count, per_cell, stretch), stresses[cell], 9)
            self.assertAlmostEqual(points.crossed_cell_highest(per_cell, stretch), stresses.max(), 9)
            self.assertAlmostEqual(points.crossed_cell_lowest(per_cell, stretch), stresses.min(), 9)

    def test_printed_figures(self):
        for per_cell, stretch, high, low in ((2, 0.75, 33.3, -11.1), (2, 0.9, 11.1, -25.9), (4, 0.9, 11.1, -11.1)):
            self.assertAlmostEqual(100 * points.crossed_cell_highest(per_cell, stretch) - 100, high, 1)
            self.assertAlmostEqual(100 * points.crossed_cell_lowest(per_cell, stretch) - 100, low, 1)
        self.assertEqual(points.surface_load_share(2), 0.75)

    def test_bars_that_are_none_are_refused(self):
        self.assertRaises(ValueError, points.surface_load_share, 1.5)
        self.assertRaises(ValueError, points.crossed_cell_stress, 0, 2, 0.9)
        self.assertRaises(ValueError, points.crossed_cell_highest, 2, 2.0)
        self.assertRaises(ValueError, points.crossed_cell_lowest, 2, -1.0)


class FrozenStiffness(unittest.TestCase):
    @staticmethod
    def spring(ratio: float, tolerance: float) -> int:
        """Iterations of u += (1 - k u) on a spring k until the error is below the tolerance times the first."""
        place, count = 0.0, 0
        while abs(1 - ratio * place) > tolerance * (1 + 1e-12):
            place, count = place + (1 - ratio * place), count + 1
        return count

    def test_count_is_the_iteration_on_a_spring(self):
        for ratio, tolerance in ((0.05, 1e-2), (0.5, 1e-9), (1.0, 1e-9), (1.7, 1e-6), (1e-3, 0.1)):
            self.assertEqual(iteration.frozen_stiffness_iterations(ratio, tolerance), self.spring(ratio, tolerance))
        self.assertEqual(iteration.frozen_stiffness_iterations(0.05, 1e-2), 90)

    def test_outside_of_0_to_2_it_does_not_converge(self):
        for ratio in (-0.1, 0.0, 2.0, 3.0):
            self.assertEqual(iteration.frozen_stiffness_iterations(ratio, 0.1), math.inf)
        self.assertRaises(ValueError, iteration.frozen_stiffness_iterations, 0.5, 1.0)

    def test_confined_step_contracts_as_its_tangent_says(self):
        for stretch in (0.8, 0.72, 1.5):
            count = [iteration.frozen_stiffness_confined_iterations(stretch, t) for t in (1e-6, 1e-13)]
            expected = iteration.frozen_stiffness_iterations(1 / stretch**2, 1e-7)
            # both counts are whole numbers
            self.assertAlmostEqual(count[1] - count[0], expected, delta=1)

    def test_printed_counts(self):
        self.assertEqual(iteration.frozen_stiffness_confined_iterations(0.80), 37)
        self.assertEqual(iteration.frozen_stiffness_confined_iterations(0.72), 290)

    def test_least_stretch_parts_convergence_from_divergence(self):
        least = iteration.frozen_stiffness_least_stretch()
        self.assertAlmostEqual(least, 0.7071, 4)
        self.assertLess(iteration.frozen_stiffness_confined_iterations(least + 1e-3), math.inf)
        self.assertEqual(iteration.frozen_stiffness_confined_iterations(least - 1e-3), math.inf)
        self.assertEqual(iteration.frozen_stiffness_confined_iterations(0.3), math.inf)
        self.assertRaises(ValueError, iteration.frozen_stiffness_confined_iterations, 0.0)


if __name__ == "__main__":
    unittest.main()
