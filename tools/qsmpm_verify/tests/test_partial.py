"""Partial factors: design numbers of soils and loads, what is left and said, and a slope whose factor falls by the factor on its strength."""

import contextlib
import io
import json
import math
import subprocess
import tempfile
import unittest
from pathlib import Path

from qsmpm_verify.cli import main
from qsmpm_verify.places import PROGRAM, TOP
from qsmpm_verify.study.cards import read_deck

DECK = """*MATERIAL, NAME=sand
*MOHR COULOMB
10, 30, 25, 5
*UNIT WEIGHT
18, 20
*MATERIAL, NAME=clay
*MOHR COULOMB
70, 0, 0
*MATERIAL, NAME=silt
*CAM CLAY
0.1
*PHASE, NAME=one
*PRESSURE, SURFACE=road
20
*PRESSURE, SURFACE=bank, LEVEL=3, UNIT WEIGHT=10
*LOAD, BODY=plate, COMPONENT=Y
-50, 1, 2
*END PHASE
"""


class Partial(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        (self.folder / "a.inp").write_text(DECK)

    def told(self, code: int, *words: str) -> str:
        output, errors = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(output), contextlib.redirect_stderr(errors):
            self.assertEqual(main(["partial", *words]), code, errors.getvalue())
        return output.getvalue() + errors.getvalue()

    def lines(self, path: str) -> dict[str, list[str]]:
        cards: dict[str, list[str]] = {}
        for card in read_deck(self.folder / path).cards:
            cards.setdefault(card.keyword, []).extend(card.lines)
        return cards

    def test_strengths_are_divided_and_variable_loads_multiplied(self) -> None:
        told = self.told(0, str(self.folder / "a.inp"), "DA1-2", "--variable", "road")
        cards = self.lines("a_da1_2.inp")
        angle = math.degrees(math.atan(math.tan(math.radians(30.0)) / 1.25))
        self.assertEqual(cards["MOHR COULOMB"], [f"8, {angle:.10g}, {min(25.0, angle):.10g}, 4", "50, 0, 0"])
        self.assertEqual(cards["PRESSURE"][0], "26")
        self.assertEqual(cards["LOAD"], ["-50, 1, 2"])
        self.assertIn("unchanged: *CAM CLAY of 'SILT'", told)
        self.assertIn("compared with 1\n", told)

    def test_permanent_loads_are_multiplied_and_places_are_not(self) -> None:
        told = self.told(0, str(self.folder / "a.inp"), "DA2", "--variable", "road", "--to", str(self.folder / "b.inp"))
        cards = self.lines("b.inp")
        self.assertEqual((cards["LOAD"], cards["PRESSURE"][0], cards["MOHR COULOMB"][1]), (["-67.5, 1, 2"], "30", "70, 0, 0"))
        self.assertIn("compared with 1.485", told)

    def test_numbers_by_name_are_refused(self) -> None:
        deck = self.folder / "named.inp"
        deck.write_text((self.folder / "a.inp").read_text(encoding="utf-8").replace("70, 0, 0", "c=70, phi=0, psi=0"), encoding="utf-8")
        self.assertIn("*MOHR COULOMB: 'c=70, phi=0, psi=0' uses parameter names", self.told(2, str(deck), "DA1-2"))

    def test_another_table_counts_and_what_is_none_is_refused(self) -> None:
        (self.folder / "own.toml").write_text("[mine]\nfriction = 1.3\n")
        self.told(0, str(self.folder / "a.inp"), "mine", "--table", str(self.folder / "own.toml"))
        self.assertIn(f"{math.degrees(math.atan(math.tan(math.radians(30.0)) / 1.3)):.10g}", self.lines("a_mine.inp")["MOHR COULOMB"][0])
        self.assertIn("known are DA1-1, DA1-2, DA2, DA3", self.told(2, str(self.folder / "a.inp"), "DA4"))
        self.assertIn("--variable RAIL: no load", self.told(2, str(self.folder / "a.inp"), "DA2", "--variable", "rail"))
        (self.folder / "own.toml").write_text("[mine]\nfriction = 0\n")
        self.assertIn("friction = 0 must be one of", self.told(2, str(self.folder / "a.inp"), "mine", "--table", str(self.folder / "own.toml")))

    @unittest.skipUnless(PROGRAM.is_file(), "the program is not built")
    def test_the_factor_of_a_slope_falls_by_the_factor_on_its_strength(self) -> None:
        slope = (TOP / "verification/reliability/slope.inp").read_text().replace("7, 20, 20", "12, 24, 24")
        slope = slope.replace("X, 0, 50, 50", "X, 0, 50, 20").replace("Y, 0, 15, 15", "Y, 0, 15, 6")
        (self.folder / "slope.inp").write_text(slope)
        self.told(0, str(self.folder / "slope.inp"), "DA1-2")
        factors = []
        for name in ("slope", "slope_da1_2"):
            subprocess.run([PROGRAM, "run", self.folder / f"{name}.inp", "--out", self.folder / name, "--quiet"], check=True, capture_output=True)
            factors.append(json.loads((self.folder / name / "safety.json").read_text())["phases"][-1]["stable"])
        self.assertAlmostEqual(factors[0] / factors[1], 1.25, delta=0.01)


if __name__ == "__main__":
    unittest.main()
