"""Decks in other frames, and how a relation is judged."""

import random
import tempfile
import unittest
from pathlib import Path

from qsmpm_verify import frames, metamorphic
from qsmpm_verify.metamorphic import Finding, Scene, differences, load_scenes
from qsmpm_verify.places import METAMORPHIC
from qsmpm_verify.results import read_curves
from qsmpm_verify.study.cards import Deck, read_deck
from qsmpm_verify.trouble import Trouble

SLOPE = METAMORPHIC / "slope.inp"


def data(deck: Deck, keyword: str, number: int = 0) -> list[list[float]]:
    """Numbers of a card."""
    return [[float(item) for item in row] for row in deck.all(keyword)[number].data()]


class Frames(unittest.TestCase):
    """What a deck becomes."""

    def setUp(self) -> None:
        self.deck = read_deck(SLOPE)

    def test_a_quarter_to_the_left(self) -> None:
        """x goes up, y to the left: gravity looks along x, the foot of the slope is at (-0.7, 3.6)."""
        turned = frames.turned(self.deck, 1)
        self.assertEqual(data(turned, "GRAVITY"), [[1.0, 0.0]])
        self.assertIn([-0.7, 3.6], data(turned, "BODY"))
        self.assertEqual([card.value("PLANE") for card in turned.all("NSET")], ["X", "Y", "Y"])
        crest, toe, upright, shear = turned.all("HISTORY")[:4]
        self.assertEqual((crest.value("COMPONENT"), crest.value("SCALE")), ("X", "-1.0"))
        self.assertEqual((toe.value("COMPONENT"), toe.value("SCALE")), ("Y", "1.0"))
        self.assertEqual((upright.value("COMPONENT"), shear.value("SCALE")), ("XX", "-1.0"))

    def test_four_quarters_are_none(self) -> None:
        deck = self.deck
        for _ in range(4):
            deck = frames.turned(deck, 1)
        self.assertEqual(data(deck, "BODY"), data(self.deck, "BODY"))
        self.assertEqual(data(deck, "GRAVITY"), data(self.deck, "GRAVITY"))

    def test_units(self) -> None:
        """A stress of kN/m2 is a thousandth of N/mm2, a weight of kN/m3 a millionth of N/mm3."""
        other = frames.in_units(self.deck)
        self.assertAlmostEqual(data(other, "ELASTIC")[0][0], 3.0)
        self.assertAlmostEqual(data(other, "UNIT WEIGHT")[0][0], 18e-6)
        self.assertAlmostEqual(float(other.all("HISTORY")[0].value("SCALE") or 0), 1e-3)
        self.assertAlmostEqual(float(other.all("HISTORY")[4].value("SCALE") or 0), 1.0)

    def test_graded_cells_turn_round(self) -> None:
        """A row that widens by three narrows by three from the other side."""
        grid = self.deck.find("GRID")
        assert grid is not None
        wider = self.deck.with_card(frames.replace(grid, lines=("X, 0, 2, 4", "X, 2, 6, 6, 3", "Y, 0, 3, 9")))
        rows = frames.mirrored(wider).all("GRID")[0].data()
        self.assertEqual([float(v) for v in rows[0][1:4]], [-6.0, -2.0, 6.0])
        self.assertAlmostEqual(float(rows[0][4]), 1 / 3)
        self.assertEqual([float(v) for v in rows[1][1:3]], [-2.0, 0.0])

    def test_an_unknown_card_is_refused(self) -> None:
        with self.assertRaisesRegex(Trouble, r"\*INCLUDE OF"):
            frames.mirrored(self.deck.with_cards([*self.deck.cards, frames.Card("INCLUDE OF")]))

    def test_order_keeps_materials_whole_and_phases_in_their_order(self) -> None:
        layers = read_deck(METAMORPHIC / "layers.inp")
        other = frames.reordered(layers, random.Random(3))
        words = [card.keyword for card in other.cards]
        self.assertNotEqual(words, [card.keyword for card in layers.cards])
        self.assertCountEqual(words, [card.keyword for card in layers.cards])
        for i, word in enumerate(words):
            if word == "MATERIAL":
                self.assertEqual(words[i : i + 4], ["MATERIAL", "ELASTIC", "MOHR COULOMB", "UNIT WEIGHT"])
        self.assertEqual([c.parameters for c in other.all("PHASE")], [c.parameters for c in layers.all("PHASE")])

    def test_a_split_phase_goes_half_way_twice(self) -> None:
        other = frames.split(read_deck(METAMORPHIC / "footing.inp"))
        self.assertEqual([data(other, "MOVE", i) for i in (0, 1)], [[[0.001, -0.005]], [[0.001, -0.005]]])
        self.assertEqual([card.value("STEPS") for card in other.all("CONTROLS")], ["3", "3"])

    def test_a_larger_grid_grows_where_no_set_stands(self) -> None:
        rows = frames.enlarged(self.deck).all("GRID")[0].data()
        self.assertEqual([row[0] for row in rows], ["X", "Y", "Y"])
        self.assertEqual(rows[2][3], "7")


class Judging(unittest.TestCase):
    """Differences and marks."""

    def curves(self, folder: Path, rows: str):
        folder.mkdir()
        (folder / "curves.csv").write_text(f"phase,step,load_factor,iterations,a [m],b [m],soil_away_from_bodies [m]\n{rows}")
        return read_curves(folder)

    def test_histories_are_measured_by_the_largest_of_their_unit(self) -> None:
        deck = read_deck(SLOPE)
        with tempfile.TemporaryDirectory() as name:
            base = self.curves(Path(name) / "x", "1,1,1,3,4,0.1,0\n1,2,1,3,8,0.2,0\n")
            other = self.curves(Path(name) / "y", "1,1,1,9,4,0.1,1\n1,2,1,9,8,0.3,1\n")
            found = differences(base, deck, other, deck)
        self.assertEqual(set(found), {"a", "b"})
        self.assertAlmostEqual(found["b"], 0.1 / 8)

    def test_a_mark_passes_while_it_misses(self) -> None:
        scene = Scene("s", SLOPE, 1e-8, expected_to_fail={"mirror": "3 % off"})
        missed = Finding("s", "mirror", "a", 0.03, 1e-8, False)
        self.assertTrue(metamorphic._marked(scene, missed).held)
        held = metamorphic._marked(scene, frames.replace(missed, held=True))
        self.assertEqual((held.held, held.note), (False, "passes now: remove expected_to_fail"))

    def test_the_list_is_right_and_every_deck_is_there(self) -> None:
        scenes = load_scenes(METAMORPHIC / "scenes.toml")
        self.assertGreaterEqual(len(scenes), 6)
        for scene in scenes:
            for relation in set(metamorphic.RELATIONS) - set(scene.skip):
                self.assertTrue(metamorphic.changed_deck(relation, read_deck(scene.deck), 1).text())


if __name__ == "__main__":
    unittest.main()
