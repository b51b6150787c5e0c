"""Stated and true errors side by side."""

import math
import unittest
from pathlib import Path

import numpy as np

from qsmpm_verify.effectivity import EXACT, Line, shown, true_errors
from qsmpm_verify.results import Points


def points(stress: list[list[float]], volume: list[float], y: float = 10.0) -> Points:
    count = len(volume)
    fields = {
        "stress": np.array(stress),
        "volume": np.array(volume),
        "position": np.tile([1.0, y, 0.0], (count, 1)),
        "displacement": np.tile([0.0, -2.0, 0.0], (count, 1)),
    }
    return Points(Path("results.h5"), 1, 1, 1.0, fields)


class Effectivity(unittest.TestCase):
    """True errors and the table."""

    def test_true_errors_are_of_the_tensor_over_the_root_mean_square(self) -> None:
        state = points([[3, 0, 0, 0, 0, 0], [3, 0, 0, 2, 0, 0]], [3.0, 1.0])
        mean, largest = true_errors(state, np.array([[3.0, 0, 0, 0, 0, 0]] * 2))
        scale = math.sqrt((3 * 9 + 1 * (9 + 2 * 4)) / 4)
        self.assertAlmostEqual(largest, math.sqrt(8) / scale, places=14)
        self.assertAlmostEqual(mean, 0.25 * math.sqrt(8) / scale, places=14)

    def test_the_column_carries_the_weight_above_where_a_point_started(self) -> None:
        self.assertAlmostEqual(EXACT["S2"](points([[0] * 6], [1.0]))[0, 1], -0.8 * (50 - 12), places=12)
        self.assertEqual(EXACT["S13"](points([[0] * 6] * 2, [1.0, 1.0])).tolist(), [[0, -1, 0, 0, 0, 0]] * 2)

    def test_a_line_has_ratios_where_there_is_an_error(self) -> None:
        line = Line("S1", "A", 0.2, 0.1, 0.5, 0.6, True)
        self.assertEqual(shown(line), ["S1", "A", "2.0e-01", "1.0e-01", "0.50", "5.0e-01", "6.0e-01", "1.20", "yes"])
        self.assertEqual(shown(Line("S1", "A", 1e-9, 1e-8, 1e-9, 1e-8, False))[4:8:3], ["-", "-"])
        self.assertEqual(shown(Line("field", "B", 0.1, 0.2))[5:], ["", "", "", ""])
