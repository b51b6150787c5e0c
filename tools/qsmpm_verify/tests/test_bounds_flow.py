"""Bounds of ground that water flows through: where its pressure is known, those of that pressure; a flow that is not found is told."""

import unittest
from unittest import mock

import numpy as np
from scipy.spatial import Delaunay

from qsmpm_verify.bounds.flow import Flow
from qsmpm_verify.bounds.heads import Heads, shares
from qsmpm_verify.bounds.layout import first_triangles
from qsmpm_verify.bounds.lines import closed
from qsmpm_verify.bounds.model import model_of
from qsmpm_verify.bounds.phases import read_scene
from qsmpm_verify.bounds.scene import Scene
from qsmpm_verify.bounds.search import Search
from qsmpm_verify.bounds.verb import note_of
from qsmpm_verify.places import PROGRAM
from qsmpm_verify.study.cards import read_deck
from qsmpm_verify.tests import test_bounds
from qsmpm_verify.tests.test_bounds import SLOPE, STRIP, TOP
from qsmpm_verify.trouble import RunFailed

SOIL = "\n18, 20\n*PERMEABILITY\n1\n*BODY"
WET = SLOPE.replace("\n20\n*BODY", SOIL).replace("*MATERIAL", "*SURFACE, NAME=all, TYPE=OUTLINE, BODY=ground\n*MATERIAL")
FLOW = "*WATER LEVEL, TYPE=SEEPAGE, UNIT WEIGHT=10\n"
# A strip on a column that water comes up through, which a phase before the load has brought.
HEAD, LOAD = STRIP.format(strength="1, 25, 25").replace("\n0\n*BODY", SOIL).replace(
    "*MATERIAL", "*SURFACE, NAME=top, TYPE=BOX\n0, 6, 3, 3\n*MATERIAL").split("*PHASE")  # fmt: skip
COLUMN = HEAD + "*PHASE, NAME=water\n*FIX\nbase, ALL\nleft, X\nright, X\n*GRAVITY\n0, -1\n{water}*END PHASE\n*PHASE" + LOAD
FALLS = (TOP / "input/dam_seepage.inp").read_text(encoding="utf-8")
DAM = FALLS[: FALLS.index("*PHASE, NAME=drawdown")].replace("0, 42, 42", "0, 42, 84").replace("0, 9, 9", "0, 9, 18")


@unittest.skipUnless(PROGRAM.is_file(), "the program is not built")
class Flows(unittest.TestCase):
    setUp, ask, bracket = test_bounds.Bounds.setUp, test_bounds.Bounds.ask, test_bounds.Bounds.bracket  # type: ignore[assignment]
    known = test_bounds.Bounds.known

    def scene(self, deck: str) -> Scene:
        """The last phase of a deck."""
        (self.folder / "scene.inp").write_text(deck)
        return read_scene(read_deck(self.folder / "scene.inp"), None, True)

    def same(self, flowing: str, resting: str, *words: str) -> None:
        """Bounds of one deck and of another."""
        np.testing.assert_allclose(self.bracket(flowing, *words), self.bracket(resting, *words), rtol=5e-4)

    def test_water_that_stands_is_that_below_a_line(self) -> None:
        # The level lies on the slope: free water presses on it, and the line is one of the triangles.
        flowing, resting = (WET.replace("*GRAVITY\n", water + "*GRAVITY\n") for water in (
            FLOW + "left, 8\nright, 8\nall, 8\n", "*WATER LEVEL, UNIT WEIGHT=10\n0, 8\n40, 8\n"))  # fmt: skip
        self.same(flowing, resting, "--factor", "--triangles", "100", "--passes", "1")

    def test_water_that_rises_in_a_column_is_heavier_water(self) -> None:
        # Head 4.2 at the base and 3 at the top: u = 10 (4.2/3) (3 - y); the phase of the load inherits it.
        self.same(COLUMN.format(water=FLOW + "base, 4.2\ntop, 3\n"), COLUMN.format(water="*WATER LEVEL, UNIT WEIGHT=14\n0, 3\n6, 3\n"))

    def test_a_dam_whose_water_leaves_by_its_face(self) -> None:
        low, high = self.bracket(DAM, "--triangles", "300", "--passes", "1")
        self.assertLess(low, 1.5869)
        self.assertGreater(high, 1.5869)
        self.assertLess(high / low - 1.0, 0.03)
        scene = self.scene(DAM)
        outlines = np.vstack([closed(outline) for outline in scene.bodies.values()])
        surface = np.vstack(list(scene.after.water[""].lines(outlines)))  # type: ignore[union-attr]
        ends = surface[[0, -1], [0, 1]]
        # From the face below the lake to less than a cell before the one that water leaves by, and no sliver along that.
        np.testing.assert_allclose(ends, [[16.9, 6.95], [31.8, 3.48]], atol=0.25)
        mesh = first_triangles(scene, 500)
        self.assertGreater(mesh.areas().min(), 1e-3)
        # The lake pushes by gamma_w h^2/2; no water presses on the face that it leaves by.
        model = model_of(scene, mesh)
        middle = mesh.places[model.edges].mean(axis=1)
        faces = (model.sides[:, 1] < 0) & (middle[:, 1] > 2.01) & (np.abs(model.normal[:, 0]) > 0.1)
        thrust = model.after.traction.mean(axis=1) * model.length[:, None]
        self.assertAlmostEqual(float(thrust[faces & (middle[:, 0] < 20), 0].sum()), 9.81 * 5**2 / 2, delta=0.3)
        self.assertAlmostEqual(float(np.abs(thrust[faces & (middle[:, 0] > 20)]).max()), 0.0, delta=1e-6)

    def test_a_flow_in_time_goes_on_from_the_one_before(self) -> None:
        # In the dam behind the face, as the lake falls from 7 to 3: from an hour to long after, and where it falls for ever.
        decks = [FALLS.replace("TIME=86400", f"TIME={time}") for time in (3600, 86400, 86400000)]
        waters = [self.scene(deck).after.water[""] for deck in (*decks, FALLS.replace("FLOW=TRANSIENT, ", ""))]
        hour, day, ever, steady = (float(water.at(np.array([[21.0, 3.0]]))[0]) for water in waters if water is not None)
        self.assertGreater(hour, day + 0.1)
        self.assertGreater(day, ever + 1.0)
        # k_r upwards differs between the two by half a cell's suction (docs/methods/seepage.md): 0.050 kPa of the 39 that the lake falls.
        self.assertAlmostEqual(ever, steady, delta=0.06)
        berm = FALLS.replace("*HISTORY, NAME=crest_x", "*BODY, NAME=berm, MATERIAL=fill, SHAPE=BOX, ACTIVE=NO\n36, 38, 2, 3\n*HISTORY, NAME=crest_x")
        with self.assertRaisesRegex(RunFailed, "flow continues from one through other bodies"):
            self.scene(berm.replace("*RESET DISPLACEMENTS", "*ACTIVATE\nberm")).after.water[""].at(np.zeros((1, 2)))  # type: ignore[union-attr]

    def test_heads_of_the_program_are_told_as_such(self) -> None:
        _, said = self.ask(DAM, "--triangles", "60", "--passes", "0")
        self.assertIn("pore pressures of the flow computed by the program", said)
        self.assertNotIn("pore pressures", self.ask(SLOPE, "--factor", "--triangles", "60", "--passes", "0")[1])
        self.scene(DAM.replace("12, 28, 0", "12, 28, 28"))
        with mock.patch("qsmpm_verify.bounds.verb.Search", lambda scene: Search(scene, 200, 0)):
            text, bounds = note_of(read_deck(self.folder / "scene.inp"), True, 2.0)
        self.assertIn("with the flow computed on the grid of the deck", text)
        self.assertIsNone(bounds)

    def test_a_flow_that_is_not_found_is_told(self) -> None:
        berm = "*BODY, NAME=berm, MATERIAL=fill, SHAPE=POLYGON, ACTIVE=NO\n29, 5\n35, 2\n38, 2\n32, 5\n*HISTORY, NAME=crest_x"
        last = "*PHASE, NAME=berm\n*ACTIVATE\nberm\n{}*END PHASE\n*PHASE, NAME=factor full"
        for (before, after), code, word in (
            (("lake, 7\nland, 2", "lake, 1\nland, 1"), 3, "phase 'impounded': the program found no flow (exit code 2): *WATER LEVEL: every level is below"),
            (("*PHASE, NAME=factor full", last.format("")), 2, "phase 'berm' changes bodies with groundwater flow: repeat"),
        ):
            told = self.ask(DAM.replace("*HISTORY, NAME=crest_x", berm).replace(before, after))
            self.assertEqual(told[0], code, told[1])
            self.assertIn(word, told[1])
        again = DAM.replace("*HISTORY, NAME=crest_x", berm).replace("*PHASE, NAME=factor full", last.format(FLOW + "lake, 7\nberm, 2.5\n")).replace(
            "*MATERIAL", "*SURFACE, NAME=berm, TYPE=OUTLINE, BODY=berm\n*MATERIAL", 1)  # fmt: skip
        water = self.scene(again).after.water[""]
        assert water is not None
        # In the berm at the toe, which is there in the later phase only.
        self.assertAlmostEqual(float(water.at(np.array([[36.9, 2.3]]))[0]), 2.5, delta=0.15)

    def test_places_outside_have_what_the_border_has(self) -> None:
        own, share = shares(np.array([[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], [[1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]]), np.array([[0.25, 0.5], [1.2, 1.1]]))
        self.assertEqual(own.tolist(), [0, 1])
        np.testing.assert_allclose(share, [[0.25, 0.25, 0.5], [0.0, 1.0, 0.0]])

    def test_a_place_is_found_in_a_large_triangle_beside_small_ones(self) -> None:
        x, y = np.meshgrid(np.append(np.linspace(0.0, 1.0, 17), [1.5, 3.0]), np.linspace(0.0, 1.0, 17))
        corners = np.stack([x.ravel(), y.ravel()], 1)[Delaunay(np.stack([x.ravel(), y.ravel() * (1.0 + 0.01 * x.ravel())], 1)).simplices]
        places = np.random.default_rng(1).uniform(0.0, [1.4, 1.0], (200, 2))
        own, share = shares(corners, places)
        np.testing.assert_allclose(np.einsum("nk,nkj->nj", share, corners[own]), places, atol=1e-12)

    def test_two_ponds_have_a_surface_each(self) -> None:
        x, y = np.meshgrid(np.arange(11.0), [0.0, 1.0])
        places = np.stack([x.ravel(), y.ravel()], 1)
        heads = Heads(places, Delaunay(places).simplices, np.where(np.abs(places[:, 0] - 5.0) > 2.5, 0.5, -1.0))
        lines = [line for line in heads.surface(np.array([[[0.0, -1.0], [10.0, -1.0]]])) if len(line)]
        self.assertEqual([line[0, 0, 0] < 5.0 for line in lines], [line[-1, 1, 0] < 5.0 for line in lines])
        np.testing.assert_allclose(sorted([*lines[0][[0, -1], [0, 1], 0], *lines[1][[0, -1], [0, 1], 0]]), [0.0, 2.33, 7.67, 10.0], atol=0.1)

    def test_the_program_is_given_the_bodies_as_they_are_in_the_phase(self) -> None:
        clay = "*MATERIAL, NAME=clay\n*ELASTIC\n10000, 0.3\n*MOHR COULOMB\n9, 20, 20\n*UNIT WEIGHT\n18\n*PERMEABILITY\n1e-9\n*BODY"
        flow = self.scene(WET.replace("*BODY", clay).replace(
            "*GRAVITY", "*CHANGE MATERIAL\nground, clay\n*SUPPORT, SURFACE=all\n" + FLOW + "left, 8\n*GRAVITY")).after.water[""]  # fmt: skip
        assert isinstance(flow, Flow)
        self.assertRegex(flow.text(), r"\*BODY, NAME=ground, SHAPE=POLYGON, MATERIAL=clay, ACTIVE=YES(?s:.*)\*SUPPORT, SURFACE=all, TYPE=NORMAL\n")
        with mock.patch("qsmpm_verify.bounds.flow.PROGRAM", self.folder / "none"), self.assertRaisesRegex(RunFailed, "cannot be started"):
            flow.at(np.zeros((1, 2)))


if __name__ == "__main__":
    unittest.main()
