"""docs/extending.md and the pages of docs/howto: their excerpts are those of the sources, their files are there."""

import re
import unittest
from pathlib import Path

TOP = Path(__file__).resolve().parents[3]
FENCE = re.compile(r"^```(?P<head>[^\n]*)\n(?P<body>.*?)^```$", re.DOTALL | re.MULTILINE)
NAMED = re.compile(r"`((?:src|docs|tools|verification|cmake)/[\w./-]+)`")


def parts_of(body: str) -> list[list[str]]:
    """Runs of lines of an excerpt; a line `...` stands for lines left out."""
    return [part.strip("\n").split("\n") for part in re.split(r"^\.\.\.$", body, flags=re.MULTILINE)]


def first_missing(body: str, source: str) -> str:
    """First line of the first part that does not stand in the source behind the parts before it; empty for none."""
    lines, place = source.splitlines(), 0
    for part in parts_of(body):
        starts = range(place, len(lines) - len(part) + 1)
        found = next((i for i in starts if lines[i : i + len(part)] == part), None)
        if found is None:
            return part[0]
        place = found + len(part)
    return ""


class ExtendingPage(unittest.TestCase):
    """The pages and the tree."""

    text = (TOP / "docs" / "extending.md").read_text(encoding="utf-8")
    howto = "\n".join(page.read_text(encoding="utf-8") for page in sorted((TOP / "docs" / "howto").glob("*.md")))

    def test_excerpts(self) -> None:
        """Every excerpt names a file of the tree and stands in it."""
        for text, least in ((self.text, 10), (self.howto, 7)):
            self.check_excerpts(list(FENCE.finditer(text)), least)

    def check_excerpts(self, excerpts: list[re.Match[str]], least: int) -> None:
        """Those of some pages."""
        self.assertGreater(len(excerpts), least)
        for excerpt in excerpts:
            language, _, name = excerpt["head"].partition(" ")
            self.assertTrue(language and (TOP / name).is_file(), f"{excerpt['head']}: no file of the tree")
            source = (TOP / name).read_text(encoding="utf-8")
            self.assertEqual(first_missing(excerpt["body"], source), "", f"{name} has not these lines")

    def test_named_files(self) -> None:
        """Every file and folder that the page names is there."""
        names = set(NAMED.findall(self.text))
        self.assertGreater(len(names), 15)
        names |= set(NAMED.findall(self.howto))
        self.assertEqual([name for name in sorted(names) if not (TOP / name).exists()], [])

    def test_comparison(self) -> None:
        """A changed line, and parts out of order, are noticed."""
        source = "a\nb\nc\nd\n"
        self.assertEqual(first_missing("a\n...\nc\nd\n", source), "")
        self.assertEqual(first_missing("a\nc\n", source), "a")
        self.assertEqual(first_missing("c\n...\na\n", source), "a")
        self.assertEqual(first_missing("b \n", source), "b ")


if __name__ == "__main__":
    unittest.main()
