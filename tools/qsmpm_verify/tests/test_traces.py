"""Figures of whole runs: knees, constant load tests, jitter; scatter of pressures inside cells."""

import math
import tempfile
import unittest
from pathlib import Path

import numpy as np

from qsmpm_verify.cases import Case, Quantity
from qsmpm_verify.judge import judge_quantity
from qsmpm_verify.measures import pressure_scatter
from qsmpm_verify.results import Points, ResultError
from qsmpm_verify.runner import Run
from qsmpm_verify.traces import factor_of_safety, hold_growth, jitter, knee, limit_load, log_lines

LOG = """qsmpm
constant load test at load factor  3.000E+01: after 10 re-solves crest_settlement has grown by     0.932 %
constant load test at load factor  1.000E+02: rejected at re-solve 4 (no convergence)
"""


class Traces(unittest.TestCase):
    """What is read from curves and logs."""

    def setUp(self) -> None:
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.folder = Path(self.temporary.name)
        (self.folder / "job.log").write_text(LOG)

    def curves(self, *rows: tuple[float, float]) -> None:
        body = "".join(f"1,{k},{load},{push}\n" for k, (load, push) in enumerate(rows, 1))
        (self.folder / "curves.csv").write_text("phase,step,load_factor,push [m]\n" + body)

    def test_the_knee_is_the_end_of_the_first_step_ten_times_as_compliant(self) -> None:
        self.curves((1, 0.5), (2, 1.5), (2.5, 3.5), (2.75, 5.0), (3, 6.0))
        # compliances 0.5, 1, 4, 6, 4: beyond 5 in the step that ends at 2.75
        self.assertEqual(knee(self.folder, "push"), 2.75)
        self.assertEqual(knee(self.folder, "push", factor=7.0), 2.5)

    def test_a_curve_without_a_knee_gives_no_figure(self) -> None:
        self.curves((1, 0.5), (2, 1.5))
        with self.assertRaisesRegex(ResultError, "no knee up to load_factor = 2: compliance increased by a factor of 2"):
            knee(self.folder, "push")
        verdict = judge_quantity(
            Run(Case("a/b", "", self.folder, ()), self.folder, 0, 1.0),
            Quantity("q", trace="knee", arguments={"column": "push"}, at_least=0.0),
            {},
        )
        self.assertFalse(verdict.held)

    def test_a_limit_load_is_what_the_run_has_found(self) -> None:
        with self.assertRaisesRegex(ResultError, "has found no limit load"):
            limit_load(self.folder)
        (self.folder / "limit_load.json").write_text('{"phase": 1, "carried": 2, "refused": 4, "knee": 3}\n')
        self.assertEqual([limit_load(self.folder), limit_load(self.folder, "carried")], [3.0, 2.0])
        with self.assertRaisesRegex(ResultError, "'last' must be carried, refused or knee"):
            limit_load(self.folder, "last")

    def test_a_factor_of_safety_is_that_of_its_phase(self) -> None:
        with self.assertRaisesRegex(ResultError, "has found no factor of safety"):
            factor_of_safety(self.folder, "dry")
        (self.folder / "safety.json").write_text(
            '{"phases": [{"phase": "dry", "stable": 1.25, "lost": 1.5}, {"phase": "wet", "stable": 10, "lost": null},'
            '{"phase": "ice", "stable": 2, "lost": null, "refused": 2.5}]}\n'
        )
        self.assertEqual([factor_of_safety(self.folder, "dry", w) for w in ("stable", "lost", "width")], [1.25, 1.5, 0.25])
        self.assertEqual(factor_of_safety(self.folder, "wet"), 10.0)
        with self.assertRaisesRegex(ResultError, "'wet' found no factor without equilibrium: it is at least 10"):
            factor_of_safety(self.folder, "wet", "lost")
        self.assertEqual(factor_of_safety(self.folder, "ice", "width"), 0.5)
        with self.assertRaisesRegex(ResultError, "'ice' found no factor without equilibrium: it is at least 2"):
            factor_of_safety(self.folder, "ice", "lost")
        with self.assertRaisesRegex(ResultError, "unknown phase 'damp'; known are dry, wet"):
            factor_of_safety(self.folder, "damp")
        with self.assertRaisesRegex(ResultError, "'knee' must be stable, lost or width"):
            factor_of_safety(self.folder, "dry", "knee")

    def test_a_knee_needs_a_load_that_grows_and_a_first_step_that_yields(self) -> None:
        self.curves((1, 0.5), (1, 1.5))
        with self.assertRaisesRegex(ResultError, "does not increase in every step"):
            knee(self.folder, "push")
        self.curves((1, -0.5), (2, 1.5))
        with self.assertRaisesRegex(ResultError, "does not increase with"):
            knee(self.folder, "push")

    def test_the_growth_in_a_hold_test_is_read_from_the_log(self) -> None:
        self.assertAlmostEqual(hold_growth(self.folder, 30.0), 0.00932, places=12)

    def test_a_hold_test_lost_or_not_made_is_an_error(self) -> None:
        with self.assertRaisesRegex(ResultError, "rejected at re-solve 4"):
            hold_growth(self.folder, 100.0)
        with self.assertRaisesRegex(ResultError, "available are 30, 100"):
            hold_growth(self.folder, 50.0)

    def test_lines_of_the_log_are_counted_by_what_they_hold(self) -> None:
        (self.folder / "job.log").write_text("warning: cells hold no point: 1\nwarning: stresses differ\n", encoding="utf-8")
        self.assertEqual(log_lines(self.folder, "hold no point"), 1.0)
        self.assertEqual(log_lines(self.folder, "equilibrium"), 0.0)
        (self.folder / "job.log").unlink()
        with self.assertRaises(ResultError):
            log_lines(self.folder, "stresses")

    def test_jitter_is_the_mean_second_difference_beyond_a_place(self) -> None:
        self.curves((0.1, 9.0), (0.2, 1.0), (0.3, 2.0), (0.4, 2.5), (0.5, 3.5))
        # second differences at 0.2, 0.3, 0.4: 9, -0.5, 0.5
        self.assertAlmostEqual(jitter(self.folder, "push", beyond=0.25), 0.5)
        self.assertAlmostEqual(jitter(self.folder, "push"), 10 / 3)
        with self.assertRaisesRegex(ResultError, "no three consecutive steps"):
            jitter(self.folder, "push", beyond=0.4)


class Scatter(unittest.TestCase):
    """Pressures of points in the cells of a grid that follows a plate."""

    def points(self, height: list[float], pressure: list[float], pushed: float) -> Points:
        nodes = np.array([[x, y, 0.0] for y in (-2, -1, 0, 1) for x in (0, 1)], float)
        count = len(height)
        fields = {
            "position": np.array([[0.5, y, 0.0] for y in height]),
            "volume": np.array([1.0, 3.0, 1.0, 1.0][:count]),
            "stress": np.array([[p, p, p, 9.0, 0.0, 0.0] for p in pressure]),
        }
        return Points(Path("x"), 1, 1, pushed, fields, nodes)

    def test_scatter_counts_inside_cells_only(self) -> None:
        points = self.points([-1.5, -1.2, -0.5, -0.2], [1.0, 5.0, 7.0, 7.0], 0.0)
        # lower cell: mean 4, variance (9 + 3)/4 = 3 on volume 4; upper cell: none on volume 2
        self.assertAlmostEqual(pressure_scatter(points, 2.0, -2.0, 0.0), math.sqrt(4 * 3 / 6) / 2)

    def test_rows_follow_the_plate(self) -> None:
        # pushed by 1: rows at -2, -1.5, -1, 0; the third point is now beyond the plate
        points = self.points([-1.6, -1.4, -0.9], [1.0, 5.0, 7.0], 1.0)
        self.assertRaises(ResultError, pressure_scatter, points, 1.0, -2.0, 0.0)
        points = self.points([-1.6, -1.4, -1.2], [1.0, 5.0, 7.0], 1.0)
        # first cell one point; second cell 5 on 3 and 7 on 1: mean 5.5, variance 0.75 on volume 4 of 5
        self.assertAlmostEqual(pressure_scatter(points, 1.0, -2.0, 0.0), math.sqrt(4 * 0.75 / 5))

    def test_a_point_outside_the_grid_is_an_error(self) -> None:
        with self.assertRaisesRegex(ResultError, "outside"):
            pressure_scatter(self.points([-1.5, -1.4, 1.2], [1.0, 1.0, 1.0], 0.0), 1.0, -2.0, 0.0)


if __name__ == "__main__":
    unittest.main()
