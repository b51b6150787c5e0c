"""Fronts, orders and choices; study files; a study run with a program that answers at once."""

import contextlib
import csv
import io
import math
import stat
import tempfile
import unittest
from dataclasses import replace
from pathlib import Path
from unittest import mock

from qsmpm_verify.bounds import points
from qsmpm_verify.cases import CaseError
from qsmpm_verify.chart import run_rows, write_csv
from qsmpm_verify.cli import main
from qsmpm_verify.drawing import name_ends, plt, shown_methods
from qsmpm_verify.front import Sample, choices, front, lasting_errors, order
from qsmpm_verify.places import STUDIES, TOP
from qsmpm_verify.sampling import sample_study
from qsmpm_verify.studies import load_studies, load_study
from qsmpm_verify.trouble import Trouble


def sample(method: str, size: float, error: float, seconds: float) -> Sample:
    return Sample("s", method, size, error, seconds)


class Front(unittest.TestCase):
    """Which runs are worth their cost."""

    def setUp(self) -> None:
        self.samples = [
            sample("a", 1, 0.1, 1.0), sample("a", 2, 0.025, 2.0), sample("a", 4, 0.00625, 4.0),
            sample("b", 1, 0.2, 1.5), sample("b", 2, 0.02, 3.0), sample("c", 1, math.nan, math.nan),
        ]  # fmt: skip

    def test_the_front_leaves_out_what_another_run_beats_in_both(self) -> None:
        self.assertEqual(front(self.samples), [0, 1, 4, 2])

    def test_a_lucky_error_does_not_reach_the_front(self) -> None:
        lucky = [*self.samples, sample("d", 1, 1e-6, 0.5), sample("d", 2, 0.3, 1.0)]
        self.assertEqual(lasting_errors(lucky)[6], 0.3)
        # it is still the cheapest run of all and claims 0.3, not 1e-6
        self.assertEqual(front(lucky), [6, 0, 1, 4, 2])

    def test_the_order_is_the_slope_over_the_size(self) -> None:
        self.assertAlmostEqual(order(self.samples[:3]) or 0.0, 2.0)
        self.assertIsNone(order(self.samples[:1]))
        floored = Sample("s", "a", 100, 0.00625, 9.0, at_floor=True)
        self.assertAlmostEqual(order([*self.samples[:3], floored]), 2.0)

    def test_the_choice_for_an_error_is_the_cheapest_run_that_has_it(self) -> None:
        found = {c.asked: c.sample.seconds for c in choices(self.samples)}
        self.assertEqual(found, {0.1: 1.0, 0.05: 2.0, 0.02: 3.0, 0.01: 4.0})
        # the best run is told even where no round number lies between it and the next
        close = choices([sample("a", 1, 0.19, 1.0), sample("b", 1, 0.12, 2.0)])
        self.assertEqual([(round(c.asked, 9), c.sample.method) for c in close], [(0.2, "a"), (0.12, "b")])
        self.assertEqual(choices([self.samples[-1]]), [])


STUDY = """
title = "T"
deck = "a.inp"
size = "cells"
source = "S"
floor = 1e-3
[error]
name = "error of y"
column = "y"
reference = 2.0
[[method]]
label = "one"
each = [{n = 1, e = "small"}, {n = 2, e = "quick"}, {n = 9, e = "long"}]
size = "{n}"
effort = "{e}"
replace = [["N", "{n}"]]
[[method]]
label = "fails"
each = [{n = 7}]
size = "{n}"
effort = "small"
replace = [["N", "{n}"]]
[[other]]
label = "theirs"
points = [[1, 0.5, 3.0]]
caveat = "Another machine."
source = "own runs"
"""

PROGRAM = """#!/bin/sh
# y is 2 + 1/N^2 in N/100 seconds; N = 7 loses equilibrium; the last line may be read too
n=$(cat "$2" 2>/dev/null || echo 3)
[ "$n" = 7 ] && { echo "not converged"; exit 3; }
mkdir -p "$4"
awk -v n="$n" 'BEGIN { print "y"; print 2 + 1/n^2 }' > "$4/curves.csv"
awk -v n="$n" 'BEGIN { print "{\\"cpu_seconds\\": " n/100 "}" }' > "$4/timing.json"
"""


class Studies(unittest.TestCase):
    """From the file to the table."""

    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        (self.folder / "a.inp").write_text("N")
        self.program = self.folder / "program"
        self.program.write_text(PROGRAM)
        self.program.chmod(self.program.stat().st_mode | stat.S_IXUSR)
        self.path = self.folder / "s.toml"
        self.path.write_text(STUDY)

    def take(self, *efforts: str) -> list[Sample]:
        study = load_study(self.path, self.folder)
        return sample_study(study, efforts, self.program, self.folder / "out", 1, 1, False, lambda *_: None)

    def test_limit_analysis_is_a_line_of_a_study_that_asks_for_it(self) -> None:
        (study,) = load_studies(STUDIES, TOP, ["slope_limit"])
        with mock.patch.object(points, "PASSES", range(2)):
            (line,) = points.bound_points(study, self.folder)
            self.assertEqual(points.bound_points(study, self.folder), [line])
        (coarse, first, seconds), (fine, second, _) = line.points
        self.assertLess(coarse, fine)
        self.assertTrue(0.0 < second < first < 0.3 and seconds > 0.0)
        (half,) = load_studies(STUDIES, TOP, ["footing"])
        with mock.patch.object(points, "PASSES", range(1)):
            self.assertLess(points.bound_points(half, self.folder)[0].points[0][1], 0.3)
        self.assertEqual(points.bound_points(replace(study, bounds=0.0), self.folder), [])
        with self.assertRaisesRegex(Trouble, "require a function as reference"):
            points.bound_points(replace(study, error=replace(study.error, reference=1.0)), self.folder)

    def test_runs_give_errors_seconds_and_reasons(self) -> None:
        found = self.take("small", "quick")
        self.assertEqual([s.size for s in found], [1, 2, 7])
        self.assertAlmostEqual(found[0].error, 0.5)
        self.assertAlmostEqual(found[1].error, 0.125)
        self.assertEqual(found[1].seconds, 0.02)
        self.assertFalse(found[2].good)
        self.assertIn("exit 3: not converged", found[2].message)

    def test_errors_below_the_floor_are_taken_for_it(self) -> None:
        self.path.write_text(STUDY.replace("floor = 1e-3", "floor = 0.2"))
        found = self.take("small", "quick")
        self.assertEqual((found[1].error, found[1].at_floor, found[0].at_floor), (0.2, True, False))

    def test_every_run_and_every_stored_point_is_in_the_csv(self) -> None:
        study, samples = load_study(self.path, self.folder), self.take("small", "quick")
        write_csv(study, samples, self.folder / "s.csv")
        rows = list(csv.reader((self.folder / "s.csv").read_text().splitlines()))
        self.assertEqual([row[1] for row in rows[1:]], ["one", "one", "fails", "theirs"])
        self.assertEqual([row[6] for row in rows[1:]], ["yes", "yes", "", ""])
        self.assertEqual(rows[4][3:], ["0.5", "", "3", "", "stored: Another machine."])
        self.assertEqual([row[4] for row in run_rows(study, samples)], ["best", "best", ""])

    def test_another_program_of_the_build_is_read_by_a_pattern_once(self) -> None:
        text = STUDY.split("[[method]]")[0].replace('column = "y"\nreference = 2.0\n', "")
        text = text.replace("floor = 1e-3", "pattern = 'error (?P<error>\\S+) in (?P<seconds>\\S+)'")
        self.path.write_text(text + '[[method]]\nlabel = "m"\nsize = 3\ncommand = ["teller", "3"]\n')
        teller = self.folder / "teller"
        teller.write_text('#!/bin/sh\necho x >> "$(dirname "$0")/calls"\necho "error 0.25 in $1"\n')
        teller.chmod(0o755)
        for _ in range(2):
            found = self.take("quick")[0]
            self.assertEqual((found.error, found.seconds), (0.25, 3.0))
        self.assertEqual((self.folder / "calls").read_text(), "x\n")
        # a record that was cut is no record
        record = next((self.folder / "out").rglob("line.json"))
        record.write_text(record.read_text()[:9])
        self.assertEqual(self.take("quick")[0].error, 0.25)
        self.assertEqual((self.folder / "calls").read_text(), "x\nx\n")
        # what a signal stopped is not kept
        teller.write_text("#!/bin/sh\necho half a line; kill -9 $$\n")
        self.assertEqual(self.take("quick")[0].message, "stopped by signal 9")
        self.assertFalse(record.exists())
        teller.write_text("#!/bin/sh\necho did not finish\n")
        self.assertEqual(self.take("quick")[0].message, "did not finish")

    def test_wrong_files_are_told_in_a_sentence(self) -> None:
        for old, new, text in (
            ('size = "cells"', "", "'size' is missing"),
            ("{n = 9", "{n = 1.5", "sizes must increase"),
            ('label = "fails"', 'label = "one"', "two runs have the same name|sizes"),
            ("[error]", "[error]\ntolerance = 1.0", "unknown key 'tolerance'"),
            ('caveat = "Another machine."', "", "require caveat"),
            ("[[1, 0.5, 3.0]]", "[[1, 0.0, 3.0]]", "all positive"),
            ('effort = "small"', 'effort = "tiny"', "effort must be one of"),
            ('column = "y"', 'column = "y"\nmeasure = "z"', "exactly one of column"),
        ):
            self.path.write_text(STUDY.replace(old, new))
            if 'label = "one"' in new:
                self.path.write_text(STUDY.replace(old, new).replace("{n = 7}", "{n = 1}"))
            with self.assertRaisesRegex(CaseError, text):
                load_study(self.path, self.folder)
        with self.assertRaisesRegex(CaseError, "unknown study 'nobody'"):
            load_studies(STUDIES, TOP, ["nobody"])

    def test_the_studies_of_the_tree_are_right_and_broad(self) -> None:
        studies = load_studies(STUDIES, TOP, [])
        self.assertGreaterEqual(len(studies), 7)
        for study in studies:
            self.assertGreaterEqual(len(study.methods), 4, study.name)
            for method in study.methods:
                for entry in method.entries:
                    text = entry.case.deck.read_text() if not entry.command else ""
                    for old, new in entry.case.replace:
                        self.assertIn(old, text, entry.case.name)
                        text = text.replace(old, new)

    def test_the_verb_draws_and_fails_with_3_when_nothing_ran(self) -> None:
        words = ["chart", str(self.path), "--program", str(self.program), "--out", str(self.folder / "o"),
                 "--charts", str(self.folder / "c"), "--effort", "small"]  # fmt: skip
        text = STUDY.replace('deck = "a.inp"', f'deck = "{self.folder}/a.inp"')
        self.path.write_text(text)
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = main([*words, "--markdown", str(self.folder / "page.md")])
        self.assertEqual(code, 0, err.getvalue())
        self.assertIn("<svg", (self.folder / "c" / "s.svg").read_text()[:500])
        page = (self.folder / "page.md").read_text()
        self.assertIn("| one | 1 | 5.00e-01 | 0.01 | best |", page)
        self.assertIn("theirs: Another machine. Source: own runs.", page)
        self.path.write_text(text.replace('["N", "{n}"]', '["N", "7"]').replace("{n = 1,", "{n = 1.0,"))
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            self.assertEqual(main(words), 3)
        self.assertIn("no run gave a result", err.getvalue())


class Named(unittest.TestCase):
    """Which lines have a name, and where the names stand."""

    def test_eight_lines_nearest_to_the_front_are_named(self) -> None:
        labels = [f"m{i}" for i in range(11)]
        study = mock.Mock(methods=[mock.Mock(label=label) for label in labels])
        samples = [Sample("s", label, 1.0, 0.1 * (i + 1), 1.0 + i) for i, label in enumerate(labels)]
        samples.append(Sample("s", "m10", 2.0, 0.01, 50.0))
        named = shown_methods(study, samples)
        self.assertEqual(len(named), 8)
        self.assertTrue({"m0", "m10"} <= set(named), "those of the front are named")
        self.assertNotIn("m9", named)

    def test_names_do_not_stand_on_each_other(self) -> None:
        figure, axes = plt.subplots()
        axes.loglog([1, 10], [1e-3, 1])
        name_ends(axes, [(10, 0.100, "a", "C0"), (10, 0.101, "b", "C1"), (10, 0.102, "c", "C2"), (10, 0.9, "d", "C3")])
        heights = sorted(text.xyann[1] for text in axes.texts)
        plt.close(figure)
        self.assertTrue(all(b - a >= 0.045 - 1e-12 for a, b in zip(heights, heights[1:])))


if __name__ == "__main__":
    unittest.main()
