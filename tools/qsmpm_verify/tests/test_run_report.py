"""The report of one run: a page that fetches nothing, a document, and what they hold, of a run that the test makes."""

import contextlib
import html
import io
import re
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path
from unittest import mock

from docx import Document

from qsmpm_verify.bounds.search import Search
from qsmpm_verify.cli import main
from qsmpm_verify.places import PROGRAM
from qsmpm_verify.run_report.content import phase_table
from qsmpm_verify.run_report.word import HEIGHT, WIDTH
from qsmpm_verify.tests.test_document import Tags
from qsmpm_verify.told import factor_text

DECK = """*HEADING
A slope of 10 m at 1:2 <that stands>
*UNITS, LENGTH=m, FORCE=kN
*MODEL, TYPE=PLANE STRAIN
*GRID
X, 0, 50, 20
Y, 0, 15, 6
*NSET, NSET=base, PLANE=Y
0
*NSET, NSET=left, PLANE=X
0
*NSET, NSET=right, PLANE=X
50
*MATERIAL, NAME=clay
*ELASTIC
20000, 0.3
*MOHR COULOMB
10, 20, 20
*UNIT WEIGHT
18
*BODY, NAME=slope, MATERIAL=clay, SHAPE=POLYGON
0, 0
50, 0
50, 5
35, 5
15, 15
0, 15
*HISTORY, NAME=crest, QUANTITY=DISPLACEMENT, COMPONENT=Y, SCALE=-1
15, 15
*PHASE, NAME=weight
*FIX
base, ALL
left, X
right, X
*GRAVITY
0, -1
*CONTROLS, STEPS=3
*END PHASE
*PHASE, NAME=factor, TYPE=SAFETY
*SAFETY, TOLERANCE=0.05
*END PHASE
"""


@unittest.skipUnless(PROGRAM.is_file(), "the program is not built")
class RunReport(unittest.TestCase):
    folder: Path

    @classmethod
    def setUpClass(cls) -> None:
        cls.folder = Path(tempfile.mkdtemp())
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        (cls.folder / "slope.inp").write_text(DECK)
        subprocess.run([PROGRAM, "run", cls.folder / "slope.inp", "--out", cls.folder / "out", "--quiet"], check=True, capture_output=True)
        with (cls.folder / "out" / "job.log").open("a") as log:
            log.write("warning: a thin body\nwarning: a thin body\n")
        with mock.patch("qsmpm_verify.run_report.content.Search", lambda scene: Search(scene, 100, 1)):
            cls.told(0, str(cls.folder / "out" / "results.h5"), "--bounds", "--docx", str(cls.folder / "slope.docx"))

    @staticmethod
    def told(code: int, *words: str) -> str:
        output, errors = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(output), contextlib.redirect_stderr(errors):
            given = main(["report", *words])
        if given != code:
            raise AssertionError(f"exit code {given}: {errors.getvalue()}")
        return output.getvalue() + errors.getvalue()

    def test_the_page_holds_the_run_and_fetches_nothing(self) -> None:
        page = (self.folder / "out" / "report.html").read_text(encoding="utf-8")
        tags = Tags()
        tags.feed(page)
        self.assertEqual((tags.fetched, tags.wrong), ([], []))
        self.assertIn("A slope of 10 m at 1:2 &lt;that stands&gt;", page)
        factor = re.search(r"factor of safety between ([\d.]+) \(stable\) and ([\d.]+)", (self.folder / "out" / "job.log").read_text())
        self.assertIn(f"<td>{float(factor[1]):.4g} to {float(factor[2]):.4g}</td>", page)
        self.assertEqual(page.count("<img"), 5)
        # Three increments of the first phase, each a mark that tells its value.
        self.assertGreaterEqual(len(re.findall(r'data-tip="increment \d+, load factor', page)), 3)
        self.assertTrue(re.search(r"for the initial geometry, psi = phi: at least 1\.\d+, at most 1\.\d+", page))
        self.assertEqual(page.count("<p class=warning>a thin body</p>"), 1)
        self.assertIn("*MOHR COULOMB", page)

    def test_the_document_has_the_same_pieces(self) -> None:
        document = Document(str(self.folder / "slope.docx"))
        headings = [p.text for p in document.paragraphs if p.style.name == "Heading 1"]
        self.assertEqual(headings, ["Phases", "Factor of safety", "Warnings", "Curves", "Pictures", "Deck", "Run"])
        self.assertEqual([cell.text for cell in document.tables[0].rows[1].cells][:2], ["weight", "whole load"])
        self.assertGreaterEqual(len(document.inline_shapes), 4)
        self.assertTrue(all(shape.height <= HEIGHT and shape.width <= WIDTH for shape in document.inline_shapes))
        widths = [column.width for column in document.tables[0].columns]
        self.assertAlmostEqual(sum(widths) / WIDTH, 1.0, places=3)
        self.assertGreater(widths[6], widths[0])

    def test_the_run_is_told_whole_and_the_deck_in_lines_that_fit(self) -> None:
        page = (self.folder / "out" / "report.html").read_text(encoding="utf-8")
        log = (self.folder / "out" / "job.log").read_text().splitlines()
        first = [line for line in log[: next(i for i, line in enumerate(log) if line.startswith("phase "))] if line.strip() and not line.startswith("warning:")]
        for line in first:
            self.assertIn(f"<p>{html.escape(line)}</p>", page)
        deck = html.unescape(re.search(r"<pre>(.*?)</pre>", page, re.DOTALL)[1]).splitlines()
        self.assertRegex("\n".join(deck), r"\n X, LINES, 0, [\d.]+, [\d.]+, ")
        self.assertLess(max(map(len, deck)), 110)
        echo = next((self.folder / "out").glob("*.echo.inp")).read_text()
        self.assertEqual(" ".join(deck).split(), echo.split())

    def test_a_factor_that_no_mechanism_bounds_is_at_least_that(self) -> None:
        folder = self.folder / "least"
        folder.mkdir(exist_ok=True)
        (folder / "deck.echo.inp").write_text("*UNITS, LENGTH=m, FORCE=kN\n")
        for factor, told in (("[1.25, null]", "at least 1.25"), ("[1.25, 1.5]", "1.25 to 1.5")):
            (folder / "summary.json").write_text('{"phases": [{"name": "one", "factor": %s}, {"name": "two"}]}' % factor)
            self.assertEqual([row[-1] for row in phase_table(folder).rows], [told, ""])
            self.assertEqual(factor_text(folder, 1), "factor of safety " + told)

    def test_a_folder_without_a_run_is_refused(self) -> None:
        self.assertIn("the folder contains no finished run", self.told(2, str(self.folder)))
        self.assertIn("no such folder", self.told(2, str(self.folder / "none")))


if __name__ == "__main__":
    unittest.main()
