"""Finished runs are used again, others are not; progress; exit codes of a batch."""

import io
import stat
import tempfile
import unittest
from pathlib import Path

from qsmpm_verify.cache import named_files, recall, run_key
from qsmpm_verify.cases import Case
from qsmpm_verify.progress import Progress
from qsmpm_verify.runner import Run, run_all, run_case

PROGRAM = """#!/bin/sh
# run DECK --out DIR: counts its calls, writes curves, ends with the code the deck asks for
echo call >> "$(dirname "$0")/calls"
mkdir -p "$4"
printf 'step\\n1\\n' > "$4/curves.csv"
code=$(sed -n 's/^exit //p' "$2")
echo "ended with $code"
[ "$code" = slow ] && while :; do :; done
exit "$code"
"""


class Cache(unittest.TestCase):
    """With a program that counts how often it is called."""

    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        self.program = self.folder / "program"
        self.write_program(PROGRAM)
        (self.folder / "decks").mkdir()
        self.deck = self.folder / "decks" / "a.inp"
        self.deck.write_text("exit 0\n*INCLUDE, INPUT=part.txt\n")
        (self.folder / "decks" / "part.txt").write_text("one\n")

    def write_program(self, text: str) -> None:
        self.program.write_text(text)
        self.program.chmod(self.program.stat().st_mode | stat.S_IXUSR)

    def calls(self) -> int:
        path = self.folder / "calls"
        return path.read_text().count("call") if path.exists() else 0

    def go(self, fresh: bool = False, **changes: object) -> Run:
        case = Case(**{"name": "f/a", "title": "", "deck": self.deck, "quantities": (), **changes})
        return run_case(case, self.program, self.folder / "out", fresh=fresh)

    def test_the_same_run_is_used_again_and_fresh_runs_it_anew(self) -> None:
        self.assertFalse(self.go().reused)
        second = self.go()
        self.assertTrue(second.reused)
        self.assertEqual((second.exit_code, self.calls()), (0, 1))
        self.assertFalse(self.go(fresh=True).reused)
        self.assertEqual(self.calls(), 2)

    def test_another_deck_include_replacement_or_program_is_another_run(self) -> None:
        self.go()
        (self.folder / "decks" / "part.txt").write_text("two\n")
        self.assertFalse(self.go().reused)
        self.assertFalse(self.go(replace=(("exit 0", "exit 0\nmore"),)).reused)
        self.deck.write_text(self.deck.read_text() + "more\n")
        self.assertFalse(self.go().reused)
        self.write_program(PROGRAM + "# another build\n")
        self.assertFalse(self.go().reused)
        self.assertTrue(self.go().reused)
        self.assertEqual(self.calls(), 5)

    def test_a_rebuilt_library_is_another_run(self) -> None:
        library = self.folder / "decks" / "libsand.so"
        library.write_bytes(b"one build")
        self.deck.write_text("exit 0\n*USER MATERIAL, INTERFACE=UMAT, LIBRARY=libsand.so, STATE=2\n")
        self.go()
        self.assertTrue(self.go().reused)
        library.write_bytes(b"two build")
        self.assertFalse(self.go().reused)

    def test_a_run_that_failed_by_its_deck_is_kept_with_its_code_and_message(self) -> None:
        self.deck.write_text("exit 3\n")
        self.go()
        again = self.go()
        self.assertEqual((again.reused, again.exit_code, again.message), (True, 3, "ended with 3"))

    def test_stopped_runs_and_failures_from_outside_are_not_kept(self) -> None:
        for code in ("1", "130"):
            self.deck.write_text(f"exit {code}\n")
            self.go()
            self.assertFalse(self.go().reused, code)
        self.deck.write_text("exit slow\n")
        self.assertEqual(self.go(time_limit=0.2).message, "stopped after 1 CPU s")
        self.assertFalse(self.go(time_limit=0.2).reused)

    def test_results_that_were_touched_are_not_used(self) -> None:
        curves = self.go().directory / "curves.csv"
        curves.write_text("step\n1\n2\n")
        self.assertFalse(self.go().reused)
        curves.write_text("step\n7\n")
        self.assertFalse(self.go().reused, "another figure of the same length")
        (self.folder / "out" / "f" / "a" / "run.json").write_text("{")
        self.assertFalse(self.go().reused)

    def test_included_files_are_found_through_folders(self) -> None:
        (self.folder / "decks" / "sub").mkdir()
        (self.folder / "decks" / "sub" / "x.txt").write_text("*INCLUDE, INPUT=y.txt\n")
        (self.folder / "decks" / "sub" / "y.txt").write_text("end\n")
        found = named_files('*INCLUDE, input="sub/x.txt"\n*MESH, INPUT=none.msh', self.deck.parent)
        self.assertEqual([p.name for p in found], ["x.txt", "y.txt"])
        self.assertNotEqual(run_key("a", self.folder, self.program, 1), run_key("a", self.folder, self.program, 2))
        self.assertIsNone(recall(self.folder, "nobody"))

    def test_a_batch_tells_every_run_once(self) -> None:
        cases = [Case(f"f/{n}", "", self.deck, ()) for n in range(3)]
        out = io.StringIO()
        for _ in range(2):
            progress = Progress(3, out)
            runs = run_all(
                cases, self.program, self.folder / "out", 2, lambda r: progress.tell(r.case.name, 0.0, r.reused)
            )
        self.assertEqual(sorted(runs), ["f/0", "f/1", "f/2"])
        self.assertEqual(out.getvalue().count("already available"), 3)
        self.assertEqual(len(out.getvalue().splitlines()), 6)


if __name__ == "__main__":
    unittest.main()
