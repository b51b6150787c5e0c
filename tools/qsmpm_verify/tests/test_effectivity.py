"""Stated and true errors side by side."""

import math
import unittest
from pathlib import Path

import numpy as np

from qsmpm_verify.effectivity import EXACT, Line, counted, known_tests, mean_error, shown, sizes, true_errors
from qsmpm_verify.results import Points


def points(stress: list[list[float]], volume: list[float], y: float = 10.0) -> Points:
    count = len(volume)
    fields = {
        "stress": np.array(stress),
        "stress_scale": np.full(count, 4.0),
        "volume": np.array(volume),
        "position": np.tile([1.0, y, 0.0], (count, 1)),
        "displacement": np.tile([0.0, -2.0, 0.0], (count, 1)),
    }
    return Points(Path("results.h5"), 1, 1, 1.0, fields)


class Effectivity(unittest.TestCase):
    """True errors and the table."""

    def test_true_errors_are_of_the_tensor_over_the_stress_around(self) -> None:
        state = points([[3, 0, 0, 0, 0, 0], [3, 0, 0, 2, 0, 0]], [3.0, 1.0])
        mean, largest = true_errors(state, np.array([[3.0, 0, 0, 0, 0, 0]] * 2))
        self.assertAlmostEqual(largest, math.sqrt(8) / 4, places=14)
        self.assertAlmostEqual(mean, math.sqrt(8) / 4, places=14)

    def test_the_mean_is_taken_where_the_error_is(self) -> None:
        share, scale, volume = np.array([0.04, 0.01, 0.0]), np.array([1.0, 2.0, 5.0]), np.array([1.0, 1.0, 1.0])
        wanted = (0.2 * 0.04 + 4 * 0.1 * 0.01) / (0.2 + 4 * 0.1)
        self.assertAlmostEqual(mean_error(share, scale, volume), wanted, places=14)
        self.assertAlmostEqual(mean_error(share, scale, volume * [1, 1, 1000]), wanted, places=14)
        self.assertEqual(mean_error(np.zeros(3), scale, volume), 0.0)

    def test_the_column_carries_the_weight_above_where_a_point_started(self) -> None:
        self.assertAlmostEqual(EXACT["S2"](points([[0] * 6], [1.0]))[0, 1], -0.8 * (50 - 12), places=12)
        radius = points([[0] * 6], [1.0])
        radius.fields["position"][0, 0] = 2.0
        self.assertEqual(EXACT["T3"](radius).tolist(), [[-1.25, -0.6, -0.75, 0, 0, 0]])
        shortened = EXACT["S3"](points([[0] * 6], [1.0]))[0]
        self.assertAlmostEqual(shortened[0], -10 * (1 + 10 * 0.52e-6), places=9)
        self.assertAlmostEqual(shortened[2], 0.6 * shortened[0], places=13)
        self.assertEqual(EXACT["S13"](points([[0] * 6] * 2, [1.0, 1.0])).tolist(), [[0, -1, 0, 0, 0, 0]] * 2)

    def test_a_line_has_ratios_where_there_is_an_error(self) -> None:
        line = Line("S1", "A", 0.2, 0.1, 0.5, 0.6, True)
        self.assertEqual(shown(line), ["S1", "A", "2.0e-01", "1.0e-01", "0.50", "5.0e-01", "6.0e-01", "1.20", "yes"])
        self.assertEqual(shown(Line("S1", "A", 1e-9, 1e-8, 1e-9, 1e-8, False))[4:8:3], ["-", "-"])
        self.assertEqual(shown(Line("field", "B", 0.1, 0.2))[5:], ["", "", "", ""])

    def test_effectivities_are_counted(self) -> None:
        lines = [
            Line("T1", "A", 0.2, 0.1, 0.5, 0.6), Line("T1", "B", 0.2, 0.09, 0.5, 1.1),
            Line("T2", "A", 0.2, 0.11, 0.5, 0.6), Line("T2", "B", 0.2, 0.09, 1e-9, 1.1),
        ]  # fmt: skip
        self.assertEqual(
            counted(lines),
            "2 of 4 reported mean errors are between 0.5 and 2 times the true one; "
            "2 of 3 reported largest errors are between 0.5 and 2 times the true one",
        )
        self.assertTrue(sizes(lines).endswith("quiet body: mean by up to 10 %, largest by up to 0.0 %"))

    def test_every_known_test_has_an_exact_stress(self) -> None:
        self.assertEqual({test.id for test in known_tests()}, set(EXACT))
