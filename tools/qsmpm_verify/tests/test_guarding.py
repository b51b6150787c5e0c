"""docs/guarding.md: the cases, rows of the map and files that hold the decks which once went wrong are there."""

import re
import tomllib
import unittest
from pathlib import Path

from qsmpm_verify.cases import load_all

TOP = Path(__file__).resolve().parents[3]
ROW = re.compile(r"^\| (?P<what>[^|]+) \| (?P<gave>[^|]+) \| (?P<held>[^|]+) \|$", re.MULTILINE)
MAP_ROW = re.compile(r"[ST]\d\d")


def rows_of_map() -> set[str]:
    """Names of the rows of the map and of the trust page."""
    files = [*(TOP / "verification" / "stability").glob("[ST]*.toml"), *(TOP / "verification" / "trust").glob("T*.toml")]
    return {tomllib.loads(file.read_text(encoding="utf-8"))["id"] for file in files} | {file.name.split("_")[0] for file in files}


class GuardingPage(unittest.TestCase):
    """The table of decks that went wrong."""

    def test_every_guard_is_there(self) -> None:
        """Each name is a case, a row of the map or a file."""
        text = (TOP / "docs" / "guarding.md").read_text(encoding="utf-8")
        table = text.split("## Decks that went wrong", 1)[1].split("\n## ", 1)[0]
        rows = [row for row in ROW.finditer(table) if row["what"] != "what" and not row["what"].startswith("--")]
        self.assertGreaterEqual(len(rows), 27)
        cases = {**load_all(TOP / "verification" / "cases", TOP), **load_all(TOP / "verification" / "week", TOP)}
        known = rows_of_map()
        for row in rows:
            for guard in re.sub(r"\(.*?\)", "", row["held"]).split(","):
                name = guard.strip()
                there = name in known if MAP_ROW.fullmatch(name) else name in cases or (TOP / name).is_file()
                self.assertTrue(there, f"{row['what']}: {name} is not there")


if __name__ == "__main__":
    unittest.main()
