"""Tests of the command with the program as it was built: a small study from deck to table, and what goes wrong."""

import contextlib
import io
import json
import tempfile
import unittest
from pathlib import Path

from qsmpm_bench import cli
from qsmpm_bench.decks import TOP, block, scene
from qsmpm_bench.measure import BenchError, process, run_deck
from qsmpm_bench.shares import PARTS, same_bytes
from qsmpm_bench.tables import section_marks

PROGRAM = TOP / "build" / "qsmpm"


class Command(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)

    def bench(self, *words: str) -> tuple[int, str, str]:
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = cli.main([*words, "--out", str(self.folder / "out")])
        return code, out.getvalue(), err.getvalue()

    def test_parts(self) -> None:
        page = self.folder / "page.md"
        page.write_text("\n".join(["prose", *section_marks("parts"), "more prose", ""]))
        code, out, err = self.bench("parts", "--quick", "--repeat", "1", "--json", str(self.folder / "f.json"),
                                    "--markdown", str(page), "--figures", str(self.folder))
        self.assertEqual(code, 0, err)
        self.assertIn("| oedometer | 128 |", out)
        self.assertIn("| oedometer | 128 |", page.read_text())
        rows = json.loads((self.folder / "f.json").read_text())["parts"]["tables"]["shares"]
        for row in rows:
            # Every part is rounded to a tenth of a percent.
            self.assertAlmostEqual(sum(float(row[f"{part} %"]) for part in PARTS), 100.0, delta=0.05 * len(PARTS))
        self.assertIn("CPU s", (self.folder / "out" / "parts_shares.csv").read_text())
        self.assertIn("<svg", (self.folder / "bench_parts.svg").read_text())

    def test_against(self) -> None:
        code, _, err = self.bench("against", "--quick", "--repeat", "1")
        self.assertEqual(code, 2)
        self.assertIn("requires --against PROGRAM", err)
        code, out, err = self.bench("against", "--quick", "--repeat", "2", "--against", str(PROGRAM))
        self.assertEqual(code, 0, err)
        row = [cell.strip() for cell in next(line for line in out.splitlines() if line.startswith("| oedometer")).split("|")]
        self.assertEqual(row[3], row[4])
        self.assertAlmostEqual(float(row[7]), float(row[6]) / float(row[5]), delta=0.02 * float(row[7]))

    def test_a_program_that_is_not_there(self) -> None:
        code, _, err = self.bench("parts", "--program", str(self.folder / "nothing"))
        self.assertEqual(code, 2)
        self.assertIn("not found", err)

    def test_a_deck_that_stops(self) -> None:
        deck = scene("oedometer", ("*END PHASE", "*END PHASES"))
        with self.assertRaisesRegex(BenchError, "exit code 2"):
            run_deck(deck, PROGRAM, self.folder)

    def test_a_replacement_that_hits_nothing(self) -> None:
        with self.assertRaisesRegex(BenchError, "nothing to replace"):
            run_deck(scene("oedometer", ("no such text", "")), PROGRAM, self.folder)

    def test_a_process_that_takes_too_long(self) -> None:
        with self.assertRaisesRegex(BenchError, "stopped after"):
            process(["sleep", "20"], self.folder / "log", timeout=0.2)

    def test_blocks_run_and_differ(self) -> None:
        runs = [run_deck(block(f"b {number}", model, 2, points, "BASIS=GIMP, INTEGRATION=POINTS", 1, output=True),
                         PROGRAM, self.folder)
                for number, (model, points) in enumerate([("PLANE STRAIN", 4), ("PLANE STRAIN", 4), ("3D", 8)])]
        self.assertEqual([run.figures["points"] for run in runs], [16, 16, 64])
        self.assertGreater(runs[0].memory, 2**20)
        self.assertTrue(same_bytes(runs[0].directory, runs[1].directory))
        self.assertFalse(same_bytes(runs[0].directory, runs[2].directory))


if __name__ == "__main__":
    unittest.main()
