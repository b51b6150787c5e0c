"""Reductions of scenes: files, costs, the change of a figure, page and verb."""

import contextlib
import csv
import io
import tempfile
import unittest
from pathlib import Path
from unittest import mock

from qsmpm_verify import scene
from qsmpm_verify.cases import CaseError
from qsmpm_verify.cli import main
from qsmpm_verify.pages import marks, write_between
from qsmpm_verify.places import SCENES, TOP
from qsmpm_verify.reductions import largest_change, load_reductions
from qsmpm_verify.results import ResultError, read_curves
from qsmpm_verify.trouble import Trouble

REDUCTIONS = """
[[reduction]]
name = "half"
title = "half for a whole"
scene = "a block"
deck = "b.inp"
both = [["Y", "2.0"]]
whole = [["SECONDS", "4.0 100"]]
reduced = [["SECONDS", "0.5 50"], ["2.0", "2.1"]]
column = "y"
what = "settlement"
note = "Half of it."
"""
PROGRAM = """#!/bin/sh
# the deck says CPU seconds, equations and the settlement at full load
mkdir -p "$4"
read seconds equations y < "$2"
[ "$y" = 9.0 ] && { echo "equilibrium lost"; exit 3; }
printf 'phase,step,load_factor,y [m]\\n1,1,0.5,1\\n1,2,1,%s\\n' $y > "$4/curves.csv"
printf '{"cpu_seconds": %s, "peak_memory_bytes": 2097152, "equations": %s, "points": 8}\\n' $seconds $equations \\
  > "$4/profile.json"
"""


class Scene(unittest.TestCase):
    """From a small tree with a program whose figures are in its deck."""

    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        (self.folder / "scenes").mkdir()
        (self.folder / "scenes" / "r.toml").write_text(REDUCTIONS)
        (self.folder / "b.inp").write_text("SECONDS Y\n")
        (self.folder / "program").write_text(PROGRAM)
        (self.folder / "program").chmod(0o755)

    def call(self, *words: str) -> tuple[int, str]:
        said = io.StringIO()
        places = {"SCENES": self.folder / "scenes", "TOP": self.folder}
        with (
            mock.patch.multiple(scene, **places), contextlib.redirect_stdout(said), contextlib.redirect_stderr(said),
        ):  # fmt: skip
            code = main(["scene", "--program", str(self.folder / "program"), "--out", str(self.folder / "o"),
                         "--charts", str(self.folder / "c"), *words])  # fmt: skip
        return code, said.getvalue()

    def test_costs_and_the_change_are_those_of_the_runs(self) -> None:
        code, said = self.call()
        self.assertEqual(code, 0, said)
        rows = list(csv.reader((self.folder / "c" / "scene.csv").read_text().splitlines()))
        self.assertEqual(rows[1], ["half", "whole", "4", "2.0", "100", "8", "settlement", ""])
        self.assertEqual(rows[2], ["half", "reduced", "0.5", "2.0", "50", "8", "settlement", "0.05"])
        self.assertIn("4 -> 0.5 (8.0x)", said)
        self.assertIn("<svg", (self.folder / "c" / "scene.svg").read_text()[:500])
        self.assertIn("half/whole: already available", self.call()[1])

    def test_the_page_has_the_table_between_its_marks_and_nothing_else_changes(self) -> None:
        page = self.folder / "page.md"
        page.write_text("before\n" + "\n".join(marks("scene")) + "\nafter\n")
        for _ in range(2):
            self.assertEqual(self.call("--page", str(page))[0], 0)
            text = page.read_text()
            self.assertTrue(text.startswith("before\n") and text.endswith("\nafter\n"))
            self.assertEqual(text.count("settlement: 5.0e-02"), 1)
        page.write_text("no marks\n")
        code, said = self.call("--page", str(page))
        self.assertEqual((code, page.read_text()), (2, "no marks\n"), said)
        with self.assertRaisesRegex(Trouble, "No such file"):
            write_between(self.folder / "none.md", "scene", [])

    def test_a_model_that_fails_is_told_with_exit_code_3(self) -> None:
        text = REDUCTIONS.replace('["2.0", "2.1"]', '["2.0", "9.0"]')
        (self.folder / "scenes" / "r.toml").write_text(text)
        code, said = self.call()
        self.assertEqual(code, 3)
        self.assertIn("half/reduced: exit 3: equilibrium lost", said)

    def test_the_change_is_the_largest_between_all_steps(self) -> None:
        head = "phase,load_factor,y\n"
        (self.folder / "a.csv").write_text(head + "1,0.5,1\n1,1,2\n2,1,4\n")
        (self.folder / "b.csv").write_text(head + "1,0.25,0.5\n1,1,2\n2,1,3\n")
        (self.folder / "c.csv").write_text(head + "1,1,2\n")
        a, b, c = (read_curves(self.folder / f"{name}.csv") for name in "abc")
        self.assertAlmostEqual(largest_change(a, b, "y"), 0.25)
        self.assertEqual(largest_change(a, a, "y"), 0.0)
        with self.assertRaises(ResultError):
            largest_change(a, c, "y")

    def test_wrong_files_and_names_are_told_in_a_sentence(self) -> None:
        for old, new, text in (
            ('note = "Half of it."', "", "requires the key note"),
            ('name = "half"', 'name = "half"\nsize = 3', "unknown key 'size'"),
            ('name = "half"', 'name = "half"\neffort = "tiny"', "effort must be one of"),
            ('[["Y", "2.0"]]', '[["Y"]]', "pairs of texts"),
            ('reduced = [["SECONDS", "0.5 50"], ["2.0", "2.1"]]', 'reduced = [["SECONDS", "4.0 100"]]', "the same deck"),
            (REDUCTIONS, REDUCTIONS + REDUCTIONS, "two reductions"),
            (REDUCTIONS, "x = ", "Invalid value"),
            (REDUCTIONS, "", "no reductions found"),
        ):
            (self.folder / "scenes" / "r.toml").write_text(REDUCTIONS.replace(old, new))
            with self.assertRaisesRegex(CaseError, text):
                load_reductions(self.folder / "scenes", self.folder, [], ("quick",))
        (self.folder / "scenes" / "r.toml").write_text(REDUCTIONS)
        self.assertEqual(self.call("third")[0], 2)
        self.assertEqual(self.call("--effort", "small")[0], 2)
        self.assertEqual(self.call("--repeat", "0")[0], 2)

    def test_the_reductions_of_the_tree_hit_their_decks(self) -> None:
        found = load_reductions(SCENES, TOP, [], ("small", "quick", "long"))
        self.assertGreaterEqual(len(found), 6)
        for reduction in found:
            for case in (reduction.whole, reduction.reduced):
                text = case.deck.read_text()
                for old, new in case.replace:
                    self.assertIn(old, text, case.name)
                    text = text.replace(old, new)


if __name__ == "__main__":
    unittest.main()
