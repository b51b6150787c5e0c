"""The stability map: its files, how fields come out, and what is written."""

import contextlib
import csv
import io
import tempfile
import unittest
from pathlib import Path
from unittest import mock

from qsmpm_verify import stability_map
from qsmpm_verify.cases import CaseError
from qsmpm_verify.cli import main
from qsmpm_verify.mapping import DEGRADED, PASS, SILENT, TOLD, outcome_of, stated_error, warns_of_stress
from qsmpm_verify.places import STABILITY, TOP
from qsmpm_verify.stability import load_rows

METHODS = "".join(
    f'[[method]]\nname = "{name}"\nmethod = "BASIS={name}"\npoints = 4\nbasis = "{name}"\nintegration = "POINTS"\n'
    for name in ("A", "B", "C", "D", "E")
)

ROW = """
id = "S1"
title = "T"
asks = "y is 2"
deck = "a.inp"
replace = [["METHOD", "{method}"]]
good = 0.01
fair = 0.1
time_limit = 1
[figure]
name = "error of y"
column = "y"
reference = 2.0
"""

STOPS = """
id = "S2"
title = "U"
asks = "it stops"
deck = "a.inp"
replace = [["METHOD", "{method}"]]
ends = [3]
skip = ["E"]
skip_reason = "slow"
"""

READ = """
id = "S3"
title = "V"
asks = "few"
command = ["teller"]
pattern = '{basis} {integration} (?P<figure>\\d+)'
good = 1
fair = 2
only = ["A", "B", "C", "D"]
skip_reason = "n"
[figure]
name = "count"
"""

PROGRAM = """#!/bin/sh
# A: right; B: 5 % off; C: half off, nothing said; D: half off with a warning in the log, or a stop
mkdir -p "$4"
y() { printf 'y\\n%s\\n' "$2" > "$1/curves.csv"; printf 'qsmpm: finished\\n' > "$1/job.log"
  printf '{"cpu_seconds": 1}' > "$1/timing.json"; }
case $(cat "$2") in
  BASIS=A) y "$4" 2.001 ;;
  BASIS=B) y "$4" 2.1; echo "equilibrium lost"; exit 3 ;;
  BASIS=C) y "$4" 3 ;;
  BASIS=D) y "$4" 3; echo "warning: far off" >> "$4/job.log" ;;
  BASIS=E) while :; do :; done ;;
esac
"""


class Map(unittest.TestCase):
    """With a program whose outcome is known."""

    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        (self.folder / "a.inp").write_text("METHOD")
        self.rows = self.folder / "rows"
        self.rows.mkdir()
        (self.rows / "methods.toml").write_text(METHODS)
        (self.rows / "S01.toml").write_text(ROW)
        (self.rows / "S02.toml").write_text(STOPS)
        (self.rows / "S03.toml").write_text(READ)
        for name, text in (
            ("program", PROGRAM),
            ("teller", "#!/bin/sh\nprintf 'A POINTS 1\\nB POINTS 2\\nC POINTS 3\\n'\n"),
        ):
            (self.folder / name).write_text(text)
            (self.folder / name).chmod(0o755)

    def call(self, *words: str) -> tuple[int, str]:
        out = io.StringIO()
        patch = mock.patch.multiple(stability_map, STABILITY=self.rows, TOP=self.folder)
        with patch, contextlib.redirect_stdout(out), contextlib.redirect_stderr(out):
            code = main(["map", *words, "--program", str(self.folder / "program"), "--out", str(self.folder / "o"),
                         "--charts", str(self.folder / "c")])  # fmt: skip
        return code, out.getvalue()

    def fields(self) -> dict[tuple[str, str], dict[str, str]]:
        with (self.folder / "c" / "stability.csv").open() as file:
            return {(row["test"], row["method"]): row for row in csv.DictReader(file)}

    def test_every_field_is_what_the_run_was(self) -> None:
        code, said = self.call("--markdown", str(self.folder / "page.md"))
        self.assertEqual(code, 0, said)
        fields = self.fields()
        wanted = {
            ("S1", "A"): PASS, ("S1", "B"): TOLD, ("S1", "C"): SILENT, ("S1", "D"): TOLD, ("S1", "E"): TOLD,
            ("S2", "A"): SILENT, ("S2", "B"): PASS, ("S2", "C"): SILENT, ("S2", "D"): SILENT,
            ("S3", "A"): PASS, ("S3", "B"): DEGRADED, ("S3", "C"): SILENT, ("S3", "D"): TOLD,
        }  # fmt: skip
        self.assertEqual({key: row["outcome"] for key, row in fields.items()}, wanted)
        self.assertEqual(fields["S1", "E"]["said"], "stopped after 1 CPU s")
        self.assertEqual(fields["S1", "B"]["said"], "equilibrium lost")
        self.assertIn("warning: far off", fields["S1", "D"]["said"])
        self.assertIn("fails silently: S1 C: 0.5", said)
        self.assertIn("3 pass, 1 degraded, 4 fails and says so, 5 fails silently", said)
        page = (self.folder / "page.md").read_text()
        self.assertIn("| S1 T | 5.0e-04 | ! exit 3 | X 0.5 | ! 0.5 | ! not finished |", page)
        self.assertIn("<svg", (self.folder / "c" / "stability.svg").read_text()[:500])

    def test_strict_makes_a_silent_failure_a_miss(self) -> None:
        self.assertEqual(self.call("S3", "--strict")[0], 1)
        self.assertEqual(self.call("S3")[0], 0)
        self.assertEqual(self.call("S9")[0], 2)

    def test_limits_decide_and_a_word_in_the_log_turns_silence_into_telling(self) -> None:
        test = load_rows(self.rows, self.folder, ["S1"])[1][0]
        for figure, told, outcome in (
            (0.01, "", PASS),
            (-0.1, "", DEGRADED),
            (0.2, "", SILENT),
            (0.2, "warning", TOLD),
        ):
            self.assertEqual(outcome_of(test, figure, told), outcome)
        self.assertEqual(outcome_of(test, float("nan"), ""), SILENT)

    def test_a_stress_error_is_told_only_by_a_warning_with_an_honest_estimate(self) -> None:
        line = "stress error, estimated: mean 4 %, largest 30 % at material point 2 at (1, 2)"
        surface = "; on loaded surface 'top' mean 1 %, largest 45 % at (1, 2)"
        warning = "warning: stresses of neighbouring material points differ by 4 %"
        for case, (log, kind, stated) in enumerate(
            (
                (line, "largest", 0.3), (line, "mean", 0.04), (line + surface, "mean", 0.04), (line + surface, "largest", 0.45), (line, "", None),
                ("nothing", "largest", None), (line + surface + "\n" + line, "largest", 0.3),
            )
        ):  # fmt: skip
            with self.subTest(case):
                self.assertEqual(str(stated_error(log, kind)), str(float("nan") if stated is None else stated))
        self.assertTrue(warns_of_stress(line + "\n" + warning))
        self.assertFalse(warns_of_stress(line + "\nwarning: increment cut back"))
        (self.rows / "S01.toml").write_text(ROW.replace("good", 'states = "largest"\ngood'))
        test = load_rows(self.rows, self.folder, ["S1"])[1][0]
        for figure, told, stated, outcome in (
            (0.2, warning, 0.1, TOLD), (0.2, warning, 0.09, SILENT), (0.2, "", 0.3, SILENT),
            (0.2, warning, float("nan"), SILENT), (0.1, "", 0.0, DEGRADED),
        ):  # fmt: skip
            self.assertEqual(outcome_of(test, figure, told, stated), outcome)

    def test_the_estimate_of_a_run_is_read_and_shown(self) -> None:
        (self.rows / "S01.toml").write_text(ROW.replace("good", 'states = "mean"\ngood'))
        program = self.folder / "program"
        said = "stress error, estimated: mean 30 %, largest 31 % at material point 1 at (0, 0)"
        old = 'echo "warning: far off" >> "$4/job.log"'
        self.assertIn(old, PROGRAM)
        program.write_text(PROGRAM.replace(old, f'echo "{said}" >> "$4/job.log"; echo "warning: stresses off" >> "$4/job.log"'))
        self.call("S1")
        fields = self.fields()
        self.assertEqual(fields["S1", "D"]["stated"], "0.3")
        self.assertEqual(fields["S1", "D"]["outcome"], TOLD)
        self.assertEqual(fields["S1", "C"]["outcome"], SILENT)

    def test_wrong_files_are_told_in_a_sentence(self) -> None:
        for old, new, text in (
            ("good = 0.01", "good = 0.2", "good must not exceed"),
            ("fair = 0.1", "", "requires good and fair"),
            ('deck = "a.inp"', "", "a deck, or a command"),
            ("{method}", "{meth}", "meth"),
            ('id = "S1"', 'id = "S2"', "two tests"),
            ('asks = "y is 2"', "", "'asks' is missing"),
            ("time_limit", 'only = ["A"]\ntime_limit', "skip_reason"),
            ("time_limit", 'only = ["Z"]\ntime_limit', "unknown method 'Z'"),
        ):
            (self.rows / "S01.toml").write_text(ROW.replace(old, new))
            with self.assertRaisesRegex(CaseError, text):
                load_rows(self.rows, self.folder, [])

    def test_the_rows_of_the_tree_are_numbered_and_hit_their_decks(self) -> None:
        methods, tests = load_rows(STABILITY, TOP, [])
        self.assertEqual([test.id for test in tests], [f"S{n}" for n in range(1, 42)])
        self.assertEqual(len(methods), 7)
        for test in tests:
            for trial in test.trials if not test.command else ():
                text = trial.case.deck.read_text()
                for old, new in trial.case.replace:
                    self.assertIn(old, text, trial.case.name)
                    text = text.replace(old, new)


if __name__ == "__main__":
    unittest.main()
