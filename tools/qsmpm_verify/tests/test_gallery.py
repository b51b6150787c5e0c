"""The gallery of the documentation names cases and figures that exist, has an error for each, and shows all of its scenes."""
from __future__ import annotations

import importlib.util
import pathlib
import sys
import unittest

from qsmpm_verify.cases import load_all

TOP = pathlib.Path(__file__).resolve().parents[3]


class Gallery(unittest.TestCase):
    """`verification/gallery.py` and `docs/gallery.md`."""

    def setUp(self) -> None:
        spec = importlib.util.spec_from_file_location("gallery", TOP / "verification/gallery.py")
        assert spec is not None and spec.loader is not None
        self.gallery = importlib.util.module_from_spec(spec)
        sys.modules["gallery"] = self.gallery
        spec.loader.exec_module(self.gallery)
        self.cases = load_all(TOP / "verification/cases", TOP)
        self.page = (TOP / "docs/gallery.md").read_text(encoding="utf-8")

    def test_scenes_have_an_exact_value(self) -> None:
        """Each is a quantity of a case with a reference and its source."""
        for scene in self.gallery.SCENES:
            named = [quantity for quantity in self.cases[scene.case].quantities if quantity.name == scene.quantity]
            self.assertEqual(len(named), 1, scene.title)
            self.assertTrue(named[0].reference is not None and named[0].source, scene.title)

    def test_page_shows_them(self) -> None:
        """Twelve scenes and more, in their order, each with its picture and its case."""
        self.assertGreaterEqual(len(self.gallery.SCENES), 12)
        blocks = self.page.split("\n## ")[1:]
        self.assertEqual([block.splitlines()[0] for block in blocks], [scene.title for scene in self.gallery.SCENES])
        for scene, block in zip(self.gallery.SCENES, blocks):
            self.assertIn(f"case `{scene.case}`", block)
            self.assertIn(f"figures/{scene.picture().name}", block)
            self.assertTrue(scene.picture().is_file(), scene.title)


if __name__ == "__main__":
    unittest.main()
