"""The report: one file that needs nothing beside itself, with every figure's command."""

import contextlib
import io
import json
import re
import tempfile
import unittest
from html.parser import HTMLParser
from pathlib import Path
from unittest import mock

from qsmpm_verify import chart, document, scene, stability_map
from qsmpm_verify.cli import main
from qsmpm_verify.hypertext import with_tips
from qsmpm_verify.machine import describe
from qsmpm_verify.places import TOP
from qsmpm_verify.tests import test_chart, test_map, test_scene
from qsmpm_verify.tests.test_view import write_state

CASE = """
title = "Case"
deck = "a.inp"
[[case]]
name = "good"
replace = [["METHOD", "BASIS=A"]]
[[case.quantity]]
name = "y"
column = "y"
reference = 2.0
tolerance = 0.01
reason = "r"
source = "s"
[[case]]
name = "off"
replace = [["METHOD", "BASIS=C"]]
[[case.quantity]]
name = "y"
column = "y"
reference = 2.0
tolerance = 0.01
reason = "r <&>"
source = "s"
"""


class Tags(HTMLParser):
    """Counts tags and gathers what the page would fetch."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.wrong: list[str] = []
        self.fetched: list[str] = []
        self.ids: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        words = dict(attrs)
        for name in ("src", "href", "xlink:href"):
            if words.get(name) and not words[name].startswith(("#", "data:")):
                self.fetched.append(words[name])
        if words.get("id"):
            self.ids.append(words["id"])
        if tag not in ("meta", "img", "path", "use", "rect"):
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        if self.open and self.open[-1] == tag:
            self.open.pop()

    def handle_endtag(self, tag: str) -> None:
        if tag in ("path", "use", "rect"):
            return
        if tag == "html" or self.open[-1:] == [tag]:
            self.open = self.open[:-1]
        else:
            self.wrong.append(tag)


class Report(unittest.TestCase):
    """From a small tree with a program whose outcome is known."""

    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        (self.folder / "a.inp").write_text("METHOD")
        for name, files in (
            ("rows", {"methods.toml": test_map.METHODS.split("[[method]]\nname = \"E\"")[0],
                      "S01.toml": test_map.ROW}),
            ("studies", {"s.toml": test_chart.STUDY.replace('["N", "{n}"]', '["METHOD", "BASIS={n}"]')
                         .replace("n = 1,", 'n = "A", s = 1,').replace("n = 2,", 'n = "B", s = 2,')
                         .replace("n = 9,", 'n = "C", s = 9,').replace("{n = 7}", '{n = "D", s = 7}')
                         .replace('size = "{n}"', 'size = "{s}"')}),
            ("cases", {"c.toml": CASE}),
            ("scenes", {"r.toml": test_scene.REDUCTIONS}),
        ):  # fmt: skip
            (self.folder / name).mkdir()
            for file, text in files.items():
                (self.folder / name / file).write_text(text)
        (self.folder / "b.inp").write_text("SECONDS Y\n")
        # decks that begin with a number are scenes, the others runs of a method
        scenes = test_scene.PROGRAM.replace("#!/bin/sh\n", "").rstrip()
        (self.folder / "program").write_text(test_map.PROGRAM.replace(
            "#!/bin/sh\n", f'#!/bin/sh\nif grep -q "^[0-9]" "$2"; then\n{scenes}\nexit 0\nfi\n'))
        (self.folder / "program").chmod(0o755)

    def call(self, *words: str) -> tuple[int, str]:
        said = io.StringIO()
        rows = {"STABILITY": self.folder / "rows", "TOP": self.folder}
        with (
            mock.patch.multiple(stability_map, **rows),
            mock.patch.multiple(scene, SCENES=self.folder / "scenes", TOP=self.folder),
            mock.patch.multiple(chart, STUDIES=self.folder / "studies", TOP=self.folder),
            mock.patch.multiple(document, CASES=self.folder / "cases", **rows),
            contextlib.redirect_stdout(said), contextlib.redirect_stderr(said),
        ):  # fmt: skip
            code = main(["report", "--program", str(self.folder / "program"), "--out", str(self.folder / "o"), *words])
        return code, said.getvalue()

    def test_the_page_is_whole_and_fetches_nothing(self) -> None:
        code, said = self.call()
        self.assertEqual(code, 1, said)
        page = (self.folder / "o" / "qsmpm_report.html").read_text()
        tags = Tags()
        tags.feed(page)
        self.assertEqual((tags.fetched, tags.wrong), ([], []))
        self.assertEqual(len(set(tags.ids)), len(tags.ids), "drawings share names of parts")
        self.assertEqual(page.count("<svg"), 3)
        self.assertIn("4 -&gt; 0.5 (8.0x)", page)
        self.assertIn("<h3>Which method for which error</h3>", page)
        # Marks of the chart and fields of the map have their values, each its own.
        self.assertRegex(page, r'<use data-tip="one, cells 1: error 1.00e-03, 1 CPU s"')
        self.assertRegex(page, r'<use data-tip="theirs: error 5.00e-01, ')
        self.assertRegex(page, r'<g id="stability_field-0-0" data-tip="S1 A: pass')
        self.assertIn("name=viewport", page)
        for word in ("qsmpm-verify chart s", "qsmpm-verify map", "qsmpm-verify run --effort quick", "3 results of the"):
            self.assertIn(word, page)
        self.assertIn("3 results of the verification cases passed, 1 missed", said)
        # the case that missed stands in front, by name and class
        self.assertRegex(page.replace("\n", ""), r"<tr class=missed><td>c/off</td><td>y</td><td class=n>3</td>")
        self.assertLess(len(page), document.LARGEST)

    def test_a_part_that_cannot_be_made_is_marked_and_the_rest_is_there(self) -> None:
        (self.folder / "scenes" / "r.toml").unlink()
        code, said = self.call()
        self.assertEqual(code, 3, said)
        page = (self.folder / "o" / "qsmpm_report.html").read_text()
        self.assertIn("This part is missing: ", page)
        self.assertIn("Missing: The smallest model of a scene.", said)
        for part in ("id=charts", "id=map", "id=cases"):
            self.assertIn(part, page)

    def test_a_second_report_runs_nothing(self) -> None:
        self.call()
        _, said = self.call()
        told = [line for line in said.splitlines() if re.match(r"\[\d", line)]
        self.assertTrue(told)
        self.assertTrue(all(line.endswith("already available") for line in told), told)

    def test_pictures_of_states_are_in_the_page(self) -> None:
        results = self.folder / "state"
        results.mkdir()
        write_state(results, (0, 3))
        run = mock.Mock(exit_code=0, directory=results)
        words = mock.Mock(folder=self.folder)
        (self.folder / "charts").mkdir()
        part = document.view_part(words, {document.VIEWS[1][0]: run})
        self.assertIn("data:image/png;base64,iVBOR", part)
        self.assertEqual(document.view_part(words, {}), "")

    def test_studies_of_the_users_own_scenes_are_in_the_page(self) -> None:
        with mock.patch.object(document, "TOP", self.folder):
            self.assertEqual(document.study_part(), "")
            study = self.folder / "output" / "study" / "dam"
            study.mkdir(parents=True)
            told = {"deck": "a<b.inp", "history": "F", "told": ["F = 1.2 +- 0.1", "cheapest within 1 %: GIMP & more"]}
            (study / "figures.json").write_text(json.dumps(told))
            part = document.study_part()
            self.assertIn("<h2 id=studies>", part)
            self.assertIn("<h3>a&lt;b.inp: F</h3>\n<ul><li>F = 1.2 +- 0.1</li><li>cheapest within 1 %: GIMP &amp; more</li></ul>", part)
            self.assertNotIn("<svg", part)
            (study / "study.svg").write_text('<svg xmlns="http://www.w3.org/2000/svg"><g/></svg>')
            self.assertIn("<svg", document.study_part())
            (study / "figures.json").write_text("{")
            gaps: list[str] = []
            self.assertIn("This part is missing: ", document.or_gap("Your scenes", document.study_part, gaps))
            self.assertEqual(gaps, ["Your scenes"])

    def test_tips_go_to_their_marks_and_none_where_the_count_differs(self) -> None:
        drawing = '<g id="a_runs-1"><g><use x="1"/><use x="2"/></g></g><g id="a_runs-2"><use x="3"/></g><g id="a_cell-1"><path/></g>'
        told = with_tips(drawing, {"runs-1": ["p", "q<"], "runs-2": ["r", "s"], "cell-1": ["t"], "cell-2": ["u"]})
        self.assertEqual(told, '<g id="a_runs-1"><g><use data-tip="p" x="1"/><use data-tip="q&lt;" x="2"/></g></g>'
                               '<g id="a_runs-2"><use x="3"/></g><g id="a_cell-1" data-tip="t"><path/></g>')

    def test_the_machine_is_described(self) -> None:
        facts = dict(describe(Path("/bin/true"), TOP))
        for name in ("date", "processor", "Python", "system"):
            self.assertTrue(facts[name])
        self.assertIn("numpy", facts["Python"])


if __name__ == "__main__":
    unittest.main()
