"""Pages of the site: what leaves docs/ is named, the rest is linked; every page has its place."""

import tempfile
import unittest
from pathlib import Path

from qsmpm_verify.site_pages import left_out, without_outer_links

TOP = Path(__file__).resolve().parents[3]


class SitePages(unittest.TestCase):
    """Links and contents."""

    def test_links_that_leave_the_pages_become_words(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder)
            page = root / "methods" / "a.md"
            page.parent.mkdir()
            text = "[in](../b.md#head) [out](../../src/x.f90) [far](https://a.b) [here](#c) `[code](../../x)` ![picture](../../x.png)"
            self.assertEqual(without_outer_links(text, page, root),
                             "[in](../b.md#head) out [far](https://a.b) [here](#c) `[code](../../x)` ![picture](../../x.png)")  # fmt: skip

    def test_every_page_is_in_the_contents(self) -> None:
        pages = sorted((TOP / "docs").rglob("*.md"))
        contents = (TOP / "mkdocs.yml").read_text(encoding="utf-8")
        self.assertEqual(left_out(pages, TOP / "docs", contents), [])
        self.assertEqual(left_out([TOP / "docs" / "new.md"], TOP / "docs", contents), ["new.md"])


if __name__ == "__main__":
    unittest.main()
