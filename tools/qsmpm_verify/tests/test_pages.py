"""Pages: figures of a page and of the tables of docs/data."""

import unittest
from pathlib import Path

from qsmpm_verify.pages import figure_folder, link_to


class Figures(unittest.TestCase):
    """Where figures go and how pages name them."""

    def test_page(self) -> None:
        """Beside a page."""
        page = Path("docs/page.md")
        self.assertEqual(figure_folder(page), Path("docs/figures"))
        self.assertEqual(link_to(figure_folder(page) / "a.svg", page), "figures/a.svg")

    def test_data(self) -> None:
        """Beside the folder of tables."""
        page = Path("docs/data/table.md")
        self.assertEqual(figure_folder(page), Path("docs/figures"))
        self.assertEqual(link_to(figure_folder(page) / "a.svg", page), "../figures/a.svg")


if __name__ == "__main__":
    unittest.main()
