"""Reading curves, judging figures, counting."""

import math
import tempfile
import unittest
from dataclasses import replace
from pathlib import Path

from qsmpm_verify.cases import Case, CaseError, Quantity, load_file
from qsmpm_verify.judge import judge, judge_quantity
from qsmpm_verify.report import closing_line, counts, verdict_table
from qsmpm_verify.results import ResultError, read_curves
from qsmpm_verify.runner import Run, write_deck

CURVES = "phase,step,load_factor,push [m]\n1,1,1,0.5\n1,2,2,1.5\n1,3,3,2.0\n"


def run_of(folder: Path, **case: object) -> Run:
    """A finished run whose curves are in the folder."""
    (folder / "curves.csv").write_text(CURVES)
    (folder / "timing.json").write_text('{"cpu_seconds": 0.3, "wall_seconds": 0.4}')
    return Run(Case("a/b", "title", folder / "deck.inp", (), **case), folder, 0, 1.0)  # type: ignore[arg-type]


class Judging(unittest.TestCase):
    """What a quantity says of a run."""

    def setUp(self) -> None:
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.folder = Path(self.temporary.name)

    def verdict(self, **quantity: object):
        run = run_of(self.folder)
        return judge_quantity(run, Quantity("q", column="push", **quantity), {"a/b": run})  # type: ignore[arg-type]

    def test_units_are_split_from_names(self) -> None:
        run_of(self.folder)
        self.assertEqual(read_curves(self.folder).units["push"], "m")

    def test_a_value_between_two_rows_is_linear(self) -> None:
        self.assertAlmostEqual(self.verdict(at={"load_factor": 1.5}, reference=1.0, tolerance=1e-12).value, 1.0)

    def test_a_value_beyond_the_curve_is_a_miss(self) -> None:
        self.assertFalse(self.verdict(at={"load_factor": 9.0}, reference=1.0, tolerance=1.0).held)

    def test_a_phase_that_a_run_did_not_reach_is_a_miss(self) -> None:
        verdict = self.verdict(phase="up", reference=1.0, tolerance=1.0)
        self.assertFalse(verdict.held)
        self.assertIn("no phase 'up'", verdict.note)

    def test_a_miss_is_a_miss(self) -> None:
        self.assertFalse(self.verdict(reference=2.1, tolerance=0.01).held)
        self.assertTrue(self.verdict(reference=2.01, tolerance=0.01).held)

    def test_below_the_reference_another_tolerance_may_hold(self) -> None:
        """The rows are 0.5, 1.5 and 2."""
        self.assertTrue(self.verdict(reference=1.95, tolerance=0.04, tolerance_below=0.01).held)
        self.assertFalse(self.verdict(reference=2.05, tolerance=0.04, tolerance_below=0.01).held)
        below = self.verdict(reference=2.01, tolerance=0.04, tolerance_below=0.01)
        self.assertEqual((below.held, below.tolerance), (True, "1.0e-02"))
        every = self.verdict(at="every", reference=1.9, tolerance=0.9, tolerance_below=0.22)
        self.assertEqual((every.held, every.value), (False, 0.5))

    def test_bounds_look_at_the_worst_row(self) -> None:
        self.assertFalse(self.verdict(at="max", at_most=1.9).held)
        self.assertTrue(self.verdict(at="max", at_most=2.0).held)

    def test_printed_figures_count_in_neither(self) -> None:
        self.assertEqual(counts([self.verdict(print=True)]), (0, 0))

    def test_a_wrong_exit_code_is_a_miss(self) -> None:
        run = run_of(self.folder, exit_code=3)
        self.assertEqual(closing_line(judge(run.case, {"a/b": run})), "0 passed, 1 failed")

    def test_a_truncated_file_is_told_with_its_line(self) -> None:
        (self.folder / "curves.csv").write_text(CURVES + "1,4\n")
        with self.assertRaisesRegex(ResultError, ":5:"):
            read_curves(self.folder)

    def test_the_table_names_the_case(self) -> None:
        verdict = self.verdict(reference=2.0, tolerance=0.1)
        self.assertIn("a/b", verdict_table([verdict]))
        self.assertEqual(verdict.cpu_seconds, 0.3)
        self.assertFalse(math.isnan(verdict.value))


class ExpectedToFail(unittest.TestCase):
    """What is known to miss passes while it misses."""

    def setUp(self) -> None:
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.folder = Path(self.temporary.name)

    def marked(self, mark: str = "", exit_code: int = 0, **quantity: object):
        asked = Quantity("q", **{"column": "push", "tolerance": 0.01, **quantity})  # type: ignore[arg-type]
        run = run_of(self.folder, exit_code=exit_code, expected_to_fail=mark)
        run = replace(run, case=replace(run.case, quantities=(asked,)))
        return judge(run.case, {"a/b": run})

    def test_a_figure_that_misses_passes_and_shows_its_reason(self) -> None:
        verdicts = self.marked(reference=2.1, expected_to_fail="5 % too low")
        self.assertEqual(closing_line(verdicts), "2 passed, 0 failed")
        self.assertRegex(verdict_table(verdicts), r"(?s)expected .*5 % too low")

    def test_a_figure_that_holds_fails(self) -> None:
        verdicts = self.marked(reference=2.0, expected_to_fail="5 % too low")
        self.assertEqual(closing_line(verdicts), "1 passed, 1 failed")
        self.assertIn("passes now: remove expected_to_fail", verdict_table(verdicts))

    def test_a_figure_that_is_not_there_is_no_expected_failure(self) -> None:
        self.assertEqual(closing_line(self.marked(reference=2.1, column="no", expected_to_fail="5 % off")), "1 passed, 1 failed")

    def test_a_case_passes_while_its_exit_code_or_a_figure_misses(self) -> None:
        for exit_code, reference in ((3, 2.0), (0, 2.1), (3, 2.1)):
            verdicts = self.marked("stops at 2", exit_code, reference=reference)
            self.assertEqual(closing_line(verdicts), "2 passed, 0 failed")
        self.assertEqual(closing_line(self.marked("stops at 2", column="no", reference=2.0)), "2 passed, 0 failed")

    def test_a_case_that_holds_fails(self) -> None:
        verdicts = self.marked("stops at 2", reference=2.0)
        self.assertEqual(closing_line(verdicts), "1 passed, 1 failed")
        self.assertIn("remove expected_to_fail", verdict_table(verdicts))


class Cases(unittest.TestCase):
    """Case files are read strictly."""

    def load(self, text: str):
        with tempfile.TemporaryDirectory() as name:
            path = Path(name) / "x.toml"
            path.write_text(text)
            return load_file(path, Path(name))

    def test_a_tolerance_below_wants_one_above(self) -> None:
        with self.assertRaisesRegex(CaseError, "tolerance_below"):
            self.load('title="t"\ndeck="d"\nsource="s"\n[[case]]\nname="n"\n[[case.quantity]]\nname="q"\ncolumn="c"\nat_most=1.0\n'
                      'tolerance_below=0.1\nreason="r"\n')

    def test_an_unknown_key_is_an_error(self) -> None:
        with self.assertRaisesRegex(CaseError, "tolerence"):
            self.load('title="t"\ndeck="d"\n[[case]]\nname="n"\n[[case.quantity]]\nname="q"\ncolumn="c"\ntolerence=1\n')

    def test_a_mark_names_a_figure(self) -> None:
        for mark in ('"it fails"', "true"):
            with self.assertRaisesRegex(CaseError, "expected_to_fail"):
                self.load(f'title="t"\ndeck="d"\nsource="s"\n[[case]]\nname="n"\nexpected_to_fail={mark}\n')

    def test_an_assertion_needs_a_reason(self) -> None:
        with self.assertRaisesRegex(CaseError, "reason"):
            self.load('title="t"\ndeck="d"\nsource="s"\n[[case]]\nname="n"\n[[case.quantity]]\nname="q"\ncolumn="c"\nreference=1.0\ntolerance=0.1\n')

    def test_a_replacement_that_hits_nothing_is_an_error(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            (folder / "deck.inp").write_text("*HEADING\n")
            case = Case("a/b", "t", folder / "deck.inp", (), replace=(("STEPS", "X"),))
            (folder / "copy").mkdir()
            with self.assertRaisesRegex(ValueError, "STEPS"):
                write_deck(case, folder / "copy")


if __name__ == "__main__":
    unittest.main()
