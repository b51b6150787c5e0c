"""A result against a formula or a table: norms, units, and everything that is refused."""

import contextlib
import io
import json
import tempfile
import unittest
from pathlib import Path

from qsmpm_verify.cli import main
from qsmpm_verify.plots import parts_of
from qsmpm_verify.results import read_curves
from qsmpm_verify.units import kind_of, mismatch, read_unit, wrong_kind


class Units(unittest.TestCase):
    """What headings mean."""

    def test_units_are_read_to_newton_metre_and_second(self) -> None:
        for text, factor, powers in (
            ("kN/m2", 1e3, (1, -2, 0)),
            ("kPa", 1e3, (1, -2, 0)),
            ("kN m", 1e3, (1, 1, 0)),
            ("kN/m^3", 1e3, (1, -3, 0)),
            ("mm", 1e-3, (0, 1, 0)),
            ("kg/m3", 1.0, (1, -4, 2)),
        ):
            unit = read_unit(text)
            self.assertIsNotNone(unit, text)
            self.assertAlmostEqual(unit.factor, factor)
            self.assertEqual(unit.powers, powers)
        self.assertIsNone(read_unit("furlong"))

    def test_units_that_differ_are_told_and_the_same_ones_pass(self) -> None:
        self.assertEqual(mismatch("kPa", "kN/m2"), "")
        self.assertEqual(mismatch("", "kN/m2"), "")
        self.assertIn("factor of 1000", mismatch("MPa", "kPa"))
        self.assertIn("different kinds", mismatch("m", "kPa"))
        self.assertIn("furlong", mismatch("m", "furlong"))
        self.assertIn("not a unit of [stress]", wrong_kind("m", "stress"))
        self.assertEqual(wrong_kind("kN/m2", "stress"), "")
        self.assertEqual(wrong_kind("kN/m3", "force/volume"), "")


    def test_the_kind_of_a_formula_is_read_from_either_form_of_its_text(self) -> None:
        def entries() -> float:
            """Stress.

            Units: strain [-], modulus [stress]
              and more; result [kN/m2], over [area]
            """
            return 0.0

        def first() -> float:
            """Load of a column [length], or its height [force]."""
            return 0.0

        def silent() -> float:
            """No word of it.

            Units: as another
            """
            return 0.0

        self.assertEqual([kind_of(f) for f in (entries, first, silent)], ["kN/m2", "force", ""])


class Curve(unittest.TestCase):
    """The verb from the command line."""

    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        self.run_folder = self.folder / "results"
        self.run_folder.mkdir()
        self.curves = self.run_folder / "curves.csv"
        # M e/(1 - e) for M = 10 at e = 0.2 and 0.5 is 2.5 and 10; the second row is 2 too small
        self.curves.write_text("phase,step,load_factor,strain [-],stress [kPa]\n1,1,1,0.2,-2.5\n1,2,2,0.5,-8\n")
        (self.run_folder / "job.log").write_text("phase 1/1 a, load factor 2\nqsmpm: finished\n")

    def call(self, *words: str) -> tuple[int, str, str]:
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = main(["curve", str(self.run_folder), *words])
        return code, out.getvalue(), err.getvalue()

    def refused(self, text: str, *words: str) -> None:
        code, out, err = self.call(*words)
        self.assertEqual((code, out), (2, ""), err)
        self.assertIn(text, err)
        self.assertEqual(err.count("\n"), 1)

    FORMULA = ("--against", "function:van_langen(modulus=10, strain=strain)", "--y=-stress")

    def test_norms_against_a_formula(self) -> None:
        picture, figures = self.folder / "p.svg", self.folder / "n.json"
        code, out, _ = self.call(*self.FORMULA, "--out", str(picture), "--json", str(figures))
        self.assertEqual(code, 0)
        norms = json.loads(figures.read_text())
        self.assertAlmostEqual(norms["largest"], 2.0)
        self.assertAlmostEqual(norms["largest_share"], 0.2)
        self.assertAlmostEqual(norms["largest_at"], 0.5)
        self.assertAlmostEqual(norms["rms"], 2**0.5)
        self.assertAlmostEqual(norms["end"], 2.0)
        self.assertIn("<svg", picture.read_text()[:500])
        self.assertIn("max error  2 kPa", out)

    def test_without_a_reference_the_values_themselves_are_told(self) -> None:
        picture = self.folder / "alone.svg"
        code, out, err = self.call("--y=-stress", "--x", "strain", "--out", str(picture))
        self.assertEqual(code, 0, err)
        self.assertEqual(out.splitlines()[1:4], ["end        8 at strain = 0.5", "least      2.5 at strain = 0.2",
                                                 "largest    8 at strain = 0.5"])
        self.assertIn("-stress [kPa]", picture.read_text())
        self.refused("require --against", "--tolerance", "0.1")

    def test_a_phase_is_named_as_the_deck_names_it(self) -> None:
        self.curves.write_text("phase,step,load_factor,strain [-],stress [kPa]\n1,1,1,0.2,-2.5\n2,2,2,0.5,-8\n")
        (self.run_folder / "summary.json").write_text('{"phases": [{"name": "rest"}, {"name": "push"}]}')
        self.assertIn("end        -2.5", self.call("--phase", "rest", "--y", "stress")[1])
        self.assertIn("end        -8", self.call("--phase", "push", "--y", "stress")[1])
        self.refused("no phase 'pull'; available are rest, push", "--phase", "pull")
        out = self.folder / "phase.svg"
        self.assertEqual(main(["plot", str(self.run_folder), "--phase", "push", "--y", "stress", "--out", str(out)]), 0)
        # Over the load factor, which begins anew, a line a phase; over another column one line.
        curves = read_curves(self.run_folder)
        parts = [(name, rows.tolist()) for name, rows in parts_of(curves, self.run_folder, "load_factor", None, True)]
        self.assertEqual(parts, [("phase 'rest'", [0]), ("phase 'push'", [1])])
        self.assertEqual([len(rows) for _, rows in parts_of(curves, self.run_folder, "strain", None, True)], [2])
        self.assertIn("phase 'push'", out.read_text())

    def test_a_tolerance_decides_the_exit_code(self) -> None:
        self.assertEqual(self.call(*self.FORMULA, "--tolerance", "0.21")[0], 0)
        self.assertEqual(self.call(*self.FORMULA, "--tolerance", "0.19")[0], 1)

    def test_the_first_history_stands_behind_the_columns_of_every_run(self) -> None:
        """The head is that of the program, asserted in verification/unit/test_output.f90."""
        self.curves.write_text("phase,step,load_factor,iterations,out_of_balance,damping_share,stabilisation_share,inaccurate_points,"
                               "step_error,compliance,soil_inside_bodies [m],soil_away_from_bodies [m],top [kPa],external_work,internal_work\n"
                               "1,1,1,3,0,0,0,0,0.5,0,0,0,-2,0,0\n1,2,2,3,0,0,0,0,0.5,0,0,0,-4,0,0\n")
        table = self.folder / "t.csv"
        table.write_text("load_factor,top [kPa]\n0,0\n2,-4\n")
        code, out, err = self.call("--against", str(table))
        self.assertEqual((code, out.splitlines()[0][:3]), (0, "top"), err)

    def test_norms_against_a_table_between_its_rows(self) -> None:
        table = self.folder / "t.csv"
        table.write_text("strain [-],stress [kN/m2]\n0,0\n0.4,-4\n")
        code, out, _ = self.call("--against", str(table), "--x", "strain", "--y", "stress")
        # the table has -2 at 0.2; the row at 0.5 lies outside of it
        self.assertEqual(code, 0)
        self.assertIn("rows       1, 1 outside", out)
        self.assertIn("max error  0.5 kPa, 2.500e-01", out)

    def test_units_of_another_size_or_kind_are_refused_unless_settled(self) -> None:
        table = self.folder / "t.csv"
        table.write_text("strain [-],stress [MPa]\n0,0\n1,-0.01\n")
        words = ("--against", str(table), "--x", "strain", "--y", "stress")
        self.refused("differ by a factor of 0.001", *words)
        self.assertIn("rms error", self.call(*words, "--scale", "0.001")[1])
        self.curves.write_text("phase,step,load_factor,strain [-],push [m]\n1,1,1,0.2,2.5\n")
        self.refused("not a unit of [stress]", "--against", "function:van_langen(strain=strain)")

    def test_an_unfinished_run_is_refused_unless_taken_as_it_is(self) -> None:
        (self.run_folder / "job.log").write_text("phase 1/1 a, load factor 2\nqsmpm: not converged\n")
        self.refused("did not finish (qsmpm: not converged)", *self.FORMULA)
        self.assertEqual(self.call(*self.FORMULA, "--unfinished")[0], 0)

    def test_a_finish_before_the_last_step_does_not_count(self) -> None:
        (self.run_folder / "job.log").write_text("qsmpm: finished\nphase 1/1 a, load factor 2\n")
        self.refused("did not finish", *self.FORMULA)

    def test_cut_files_missing_files_and_wrong_names_are_told_in_one_sentence(self) -> None:
        whole = self.curves.read_text()
        self.curves.write_text(whole[:-3])
        self.refused("the last line is incomplete", *self.FORMULA)
        self.curves.write_text(whole + "1,3,3\n")
        self.refused("3 values under 5 headings", *self.FORMULA)
        self.curves.write_text(whole + "1,3,3,nan,1\n")
        self.refused("row 3 is not a finite number", *self.FORMULA)
        self.curves.write_text(whole)
        self.refused("no column of numbers 'nowhere'", *self.FORMULA, "--x", "nowhere")
        self.refused("unknown function 'nobody'", "--against", "function:nobody(x=1)")
        self.refused("missing argument strain", "--against", "function:van_langen(modulus=1)")
        self.refused("must be one of its arguments", "--against", "function:van_langen(stran=strain)")
        self.refused(
            "function van_langen: ",
            "--against",
            "function:van_langen(strain=load_factor)",
            "--y=-stress",
        )
        self.refused("No such file", "--against", str(self.folder / "none.csv"))
        self.refused("a figure must be a .png", *self.FORMULA, "--out", "p.bmp")
        self.curves.unlink()
        self.refused("No such file", *self.FORMULA)

    def test_a_table_with_one_place_twice_or_outside_of_the_result_is_refused(self) -> None:
        table = self.folder / "t.csv"
        words = ("--against", str(table), "--x", "strain", "--y", "stress")
        table.write_text("strain [-],stress [kPa]\n0,0\n0,1\n1,2\n")
        self.refused("a repeated value", *words)
        table.write_text("strain [-],stress [kPa]\n5,0\n6,1\n")
        self.refused("is within its range", *words)


if __name__ == "__main__":
    unittest.main()
