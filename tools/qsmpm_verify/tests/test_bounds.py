"""Bounds of limit analysis: closed forms lie between them, what they cannot take is refused, what is not solved is no bound."""

import contextlib
import io
import json
import math
import tempfile
import unittest
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import cast
from unittest import mock

from qsmpm_verify.bounds import cone
from qsmpm_verify.bounds.reader import Reader
from qsmpm_verify.bounds.search import Bound, Found, Mechanism, Search, Side, find_factor, next_guess
from qsmpm_verify.bounds.verb import note_of
from qsmpm_verify.cli import main
from qsmpm_verify.study.cards import read_deck

TOP = Path(__file__).resolve().parents[3]
HEAD = """*MODEL, TYPE=PLANE STRAIN
*UNITS, LENGTH=m, FORCE=kN
*GRID
X, 0, {width}, 8
Y, 0, {height}, 4
*NSET, NSET=base, PLANE=Y
0
*NSET, NSET=left, PLANE=X
0
*NSET, NSET=right, PLANE=X
{width}
*MATERIAL, NAME=soil
*ELASTIC
10000, 0.3
*MOHR COULOMB
{strength}
*UNIT WEIGHT
{weight}
*BODY, NAME=ground, MATERIAL=soil, SHAPE=POLYGON
{outline}
"""
PHASE = """*PHASE, NAME=load
*FIX
base, ALL
left, X
right, X
"""
CUT = HEAD.format(width=6, height=3, strength="1, 0, 0", weight=1, outline="0, 0\n6, 0\n6, 2\n3, 2\n3, 3\n0, 3") + PHASE + "*GRAVITY\n0, -1\n*END PHASE\n"
# Half of a strip of 2 m on soil without weight, the edge of its load at the first metre.
STRIP = HEAD.format(width=6, height=3, strength="{strength}", weight=0, outline="0, 0\n6, 0\n6, 3\n0, 3") + (
    "*SURFACE, NAME=footing, TYPE=SEGMENT\n1, 3, 0, 3\n") + PHASE + "*TRACTION, SURFACE=footing\n0, -1\n*END PHASE\n"
PUSHED = STRIP.format(strength="1, 0, 0").replace(
    "*SURFACE, NAME=footing, TYPE=SEGMENT\n1, 3, 0, 3", "*NSET, NSET=foot, BOX\n0, 1, 3, 3").replace(
    "*TRACTION, SURFACE=footing\n0, -1", "*FIX\nfoot, X\n*PRESCRIBE\nfoot, Y, -0.3")
# Half of a trapdoor of 2 m below 2 m of clay that goes down, beside a floor that begins {gap} from it.
DOOR = HEAD.format(width=5, height=2, strength="10, 0, 0", weight=0, outline="0, 0\n5, 0\n5, 2\n0, 2") + (
    "*NSET, NSET=door, BOX\n0, 1, 0, 0\n*NSET, NSET=floor, BOX\n{begin}, 5, 0, 0\n") + PHASE.replace("base", "floor") + "*PRESCRIBE\ndoor, Y, -0.02\n*END PHASE\n"
SLOPE = HEAD.format(width=40, height=15, strength="10, 20, 20", weight=20, outline="0, 0\n40, 0\n40, 5\n32, 5\n12, 15\n0, 15") + (
    PHASE + "*GRAVITY\n0, -1\n*END PHASE\n")

# Half of a concrete footing of 2 m under a load of its own width, and a prop below it that leans on rock.
FOOTING = HEAD.format(width=6, height=4, strength="1, 0, 0", weight=0, outline="0, 0\n6, 0\n6, 3\n0, 3") + (
    "*MATERIAL, NAME=concrete\n*ELASTIC\n1e6, 0.2\n*BODY, NAME=block, MATERIAL=concrete, SHAPE=BOX\n0, 1, 3, 3.5\n"
    "*SURFACE, NAME=top, TYPE=SEGMENT\n1, 3.5, 0, 3.5\n*PROP, NAME=prop, STIFFNESS=1000, COMPRESSION LIMIT=1.5, FIXED=YES\n0.3, 3.2, 0.3, 0\n") + (
    PHASE + "*TRACTION, SURFACE=top\n0, -1\n*END PHASE\n")
FEW = ("--triangles", "60", "--passes", "1")


class Bounds(unittest.TestCase):
    known: dict[tuple[str, ...], tuple[float, float]] = {}
    """Brackets that one test has found and others compare with."""

    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)

    def ask(self, deck: str, *words: str) -> tuple[int, str]:
        """Exit code and what is said of a deck."""
        (self.folder / "scene.inp").write_text(deck)
        said = io.StringIO()
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            code = main(["bounds", str(self.folder / "scene.inp"), "--json", str(self.folder / "bounds.json"), *words])
        return code, said.getvalue()

    def bracket(self, deck: str, *words: str) -> tuple[float, float]:
        """Lower and upper bound; FEW triangles are enough where what is shown does not depend on them."""
        if (deck, *words) not in self.known:
            code, said = self.ask(deck, "--triangles", "200", "--passes", "2", *words)
            self.assertEqual(code, 0, said)
            found = json.loads((self.folder / "bounds.json").read_text())
            self.known[deck, *words] = (found["lower"]["value"], found["upper"]["value"])
        return self.known[deck, *words]

    def between(self, exact: float, bracket: tuple[float, float], width: float) -> None:
        """The exact value between bounds that are as near as that."""
        low, high = bracket
        self.assertLessEqual(low, exact * 1.0005)
        self.assertGreaterEqual(high, exact * 0.9995)
        self.assertLess(high / low - 1.0, width)

    def test_vertical_cut(self) -> None:
        # N_s between 3.7776 and 3.7794 (Pastor and others, 2000).
        self.between(3.7776, self.bracket(CUT), 0.10)

    def test_strip_of_prandtl(self) -> None:
        self.between(2.0 + math.pi, self.bracket(STRIP.format(strength="1, 0, 0")), 0.04)

    def test_force_that_pushes_a_strip_is_that_of_its_load(self) -> None:
        self.between(2.0 + math.pi, self.bracket(PUSHED), 0.08)

    def test_strip_of_prandtl_with_friction(self) -> None:
        phi = math.radians(25.0)
        n_q = math.exp(math.pi * math.tan(phi)) * math.tan(math.pi / 4 + phi / 2) ** 2
        self.between((n_q - 1.0) / math.tan(phi), self.bracket(STRIP.format(strength="1, 25, 25")), 0.08)

    def test_factor_of_a_slope(self) -> None:
        # Below the log spiral through the toe, 1.3682, as the ground below the toe may fail too.
        low, high = self.bracket(SLOPE, "--factor")
        self.assertLess(low, 1.3682)
        self.assertGreater(low, 1.33)
        self.assertGreater(high, 1.36)
        self.assertLess(high, 1.40)

    def test_cut_without_tensile_strength_stands_by_half_of_what_it_has_with_it(self) -> None:
        # Drucker 1953: gamma H = 2 c; the thin slices of the mechanism want small triangles, the field of stresses none.
        low, high = self.bracket(CUT.replace("1, 0, 0", "1, 0, 0, 0"), "--factor")
        self.assertLess(low, 2.0)
        self.assertGreater(low, 1.99)
        self.assertGreater(high, 2.0)
        self.assertLess(high, 3.5)

    def test_weaker_flow_is_reduced_and_said(self) -> None:
        full = self.bracket(SLOPE, "--factor")
        low, high = self.bracket(SLOPE.replace("10, 20, 20", "10, 20, 0"), "--factor")
        self.assertLess(high, full[1])
        _, said = self.ask(SLOPE.replace("10, 20, 20", "10, 20, 0"), "--factor", "--triangles", "100", "--passes", "0")
        self.assertIn("Davis", said)

    def test_boxes_of_nodes_end_on_lines_of_the_grid_only_where_an_element_is_named(self) -> None:
        for words, end in (("*GRID", 1.0), ("*GRID, ELEMENT=TRI6, FIT=YES", 1.0), ("*GRID, ELEMENT=QUAD4", 0.75)):
            (self.folder / "scene.inp").write_text(PUSHED.replace("*GRID", words))
            self.assertEqual(Reader(read_deck(self.folder / "scene.inp")).sets["foot"][1][0], end)

    def test_slope_wholly_under_water_is_that_of_its_buoyant_weight(self) -> None:
        dry = self.bracket(SLOPE.replace("\n20\n*BODY", "\n10\n*BODY"), "--factor")
        water = SLOPE.replace("*GRAVITY\n", "*WATER LEVEL, UNIT WEIGHT=10\n0, 18\n40, 18\n*GRAVITY\n")
        wet = self.bracket(water.replace("\n20\n*BODY", "\n18, 20\n*BODY"), "--factor")
        # Other triangles, as the level is a line of them: the brackets meet, and are narrow beside what the water on the slope is worth.
        self.assertLess(max(dry[0], wet[0]), min(dry[1], wet[1]))
        self.assertLess(max(dry[1], wet[1]) / min(dry[0], wet[0]) - 1.0, 0.04)

    def test_constant_profile_is_that_cohesion(self) -> None:
        deck = STRIP.format(strength="7, 0, 0\n*STRENGTH PROFILE, TYPE=TABLE, ALONG=Y\n0, 1\n3, 1")
        self.between(2.0 + math.pi, self.bracket(deck), 0.04)

    def test_cut_off_of_tension_lowers_a_vertical_cut(self) -> None:
        full, cut = self.bracket(CUT), self.bracket(CUT.replace("1, 0, 0", "1, 0, 0, 0"))
        self.assertLess(cut[1], full[0])
        self.assertGreater(cut[0], 0.5 * full[0])

    def test_two_layers_lie_between_the_weak_and_the_strong(self) -> None:
        lower = "*MATERIAL, NAME=stiff\n*ELASTIC\n10000, 0.3\n*MOHR COULOMB\n2, 0, 0\n*UNIT WEIGHT\n0\n"
        body = "*BODY, NAME=below, MATERIAL=stiff, SHAPE=BOX\n0, 6, 0, 2.6\n*BODY, NAME=ground"
        deck = PUSHED.replace("*BODY, NAME=ground", lower + body).replace("0, 0\n6, 0\n6, 3\n0, 3", "0, 2.6\n6, 2.6\n6, 3\n0, 3")
        low, high = self.bracket(deck)
        self.assertGreater(low, 1.05 * (2.0 + math.pi))
        self.assertLess(high, 1.95 * (2.0 + math.pi))

    def test_a_body_without_a_strength_does_not_fail(self) -> None:
        """Clay of 0.4 m under half a rough strip of 1 m: as on a base a hundred times as strong, and more than in deep clay."""
        lower = "*MATERIAL, NAME=stiff\n*ELASTIC\n10000, 0.3\n{}*UNIT WEIGHT\n0\n"
        body = "*BODY, NAME=below, MATERIAL=stiff, SHAPE=BOX\n0, 6, 0, 2.6\n*BODY, NAME=ground"
        thin = PUSHED.replace("0, 0\n6, 0\n6, 3\n0, 3", "0, 2.6\n6, 2.6\n6, 3\n0, 3")
        elastic = self.bracket(thin.replace("*BODY, NAME=ground", lower.format("") + body), *FEW)
        strong = self.bracket(thin.replace("*BODY, NAME=ground", lower.format("*MOHR COULOMB\n100, 0, 0\n") + body), *FEW)
        self.assertAlmostEqual(elastic[0], strong[0], delta=0.02 * strong[0])
        self.assertAlmostEqual(elastic[1], strong[1], delta=0.02 * strong[1])
        self.assertGreater(elastic[0], 1.1 * (2.0 + math.pi))

    def test_a_footing_of_concrete_is_a_rough_one(self) -> None:
        self.between(2.0 + math.pi, self.bracket(FOOTING), 0.06)

    def test_a_prop_bears_its_limit(self) -> None:
        """Under a footing that its plane of symmetry does not let turn: one that bears more than the ground, one of tension alone, one taken out."""
        bare = self.bracket(FOOTING, *FEW)
        for cards, more in (("*INSTALL\nprop\n", 1.5), ("*INSTALL\nprop, -3\n", 1.5), ("*INSTALL\nprop\n*REMOVE\nprop\n", 0.0)):
            found = self.bracket(FOOTING.replace("*TRACTION", cards + "*TRACTION"), *FEW)
            self.assertAlmostEqual(found[0], bare[0] + more, delta=1e-3)
            self.assertAlmostEqual(found[1], bare[1] + more, delta=1e-3)
        pulled = FOOTING.replace("COMPRESSION LIMIT=1.5", "COMPRESSION LIMIT=0, TENSION LIMIT=9").replace("*TRACTION", "*INSTALL\nprop\n*TRACTION")
        self.assertAlmostEqual(self.bracket(pulled, *FEW)[1], bare[1], delta=1e-3)

    def test_a_beam_on_two_props_turns_about_the_one_that_holds(self) -> None:
        """Props of 1 kN at 1.25 and 2.75 m, 1 m of load about 1.5 m: the left one bears 5/6 of it."""
        props = "".join(f"*PROP, NAME={name}, STIFFNESS=1, COMPRESSION LIMIT=1, FIXED=YES\n{x}, 3.3, {x}, 0\n" for name, x in (("a", 1.25), ("b", 2.75)))
        deck = FOOTING.replace("0, 1, 3, 3.5", "1, 3, 3.2, 3.5").replace("1, 3.5, 0, 3.5", "2, 3.5, 1, 3.5").replace("*PHASE", props + "*PHASE")
        for value in self.bracket(deck.replace("*TRACTION", "*INSTALL\na\nb\n*TRACTION"), *FEW):
            self.assertAlmostEqual(value, 1.2, delta=1e-4)

    def test_a_strut_between_walls_holds_them_apart(self) -> None:
        """Clay of 2 m between two walls of concrete that slide on rock, pushed by 1 kN/m2: an active strut adds its limit over the height."""
        walls = "".join(f"*BODY, NAME={n}, MATERIAL=concrete, SHAPE=BOX\n{a}, {b}, 0.5, 2.5\n" for n, a, b in (("left wall", 1, 1.5), ("right wall", 4.5, 5)))
        deck = FOOTING[: FOOTING.index("*BODY, NAME=block")].replace("0, 0\n6, 0\n6, 3\n0, 3", "1.5, 0.5\n4.5, 0.5\n4.5, 2.5\n1.5, 2.5") + walls + (
            "*SURFACE, NAME=west, TYPE=SEGMENT\n1, 2.5, 1, 0.5\n*SURFACE, NAME=east, TYPE=SEGMENT\n5, 0.5, 5, 2.5\n"
            "*PROP, NAME=strut, STIFFNESS=1, COMPRESSION LIMIT=1.5\n1.2, 1.5, 4.8, 1.5\n*PHASE, NAME=load\n{}"
            "*TRACTION, SURFACE=west\n1, 0\n*TRACTION, SURFACE=east\n-1, 0\n*END PHASE\n")
        bare, found = self.bracket(deck.format(""), *FEW), self.bracket(deck.format("*INSTALL\nstrut\n"), *FEW)
        self.assertAlmostEqual(found[0], bare[0] + 0.75, delta=1e-3)
        self.assertAlmostEqual(found[1], bare[1] + 0.75, delta=1e-3)
        self.assertGreater(bare[0], 1.999)

    def test_bodies_that_miss_by_a_hair_touch(self) -> None:
        # Gap, overlap, a corner beside an edge: the ground is that of one body.
        drawn = "0, 0\n40, 0\n40, 5\n32, 5\n12, 15\n0, 15"
        few = ("--factor", "--triangles", "120", "--passes", "1")
        whole = self.bracket(SLOPE, *few)
        for low, up in (("40, 3\n0, 6", "0, 6.001\n20, 4.4995"), ("40, 3.0004\n0, 6", "0, 6\n20, 4.5")):
            body = f"0, 0\n40, 0\n{low}\n*BODY, NAME=up, MATERIAL=soil, SHAPE=POLYGON\n{up}\n40, 3\n40, 5\n32, 5\n12, 15\n0, 15"
            parts = self.bracket(SLOPE.replace(drawn, body), *few)
            self.between(whole[1], (parts[0], max(parts[1], whole[1])), 0.1)
            self.assertLess(abs(parts[1] / whole[1] - 1.0), 0.03)

    def test_a_step_of_newton_stays_near(self) -> None:
        self.assertAlmostEqual(next_guess(1.5, 0.1, -1.0), 1.6)
        # A slope that is next to nothing, or of the wrong sign.
        self.assertAlmostEqual(next_guess(1.5, -1.0, -1e-9), 0.75)
        self.assertAlmostEqual(next_guess(1.5, -1.0, 0.0), 3.0)

    def test_a_factor_that_is_nearly_a_bound_is_gone_beyond(self) -> None:
        """A margin of -1e-4 where the solver leaves 9e-4 open proves nothing; a factor that is larger by 1e-4 does."""
        for above, guess in ((True, 1.60001), (False, 1.59999)):
            side = SimpleNamespace(above=above, scale=900.0, slope=lambda answer, factor: -10.0, solve=lambda factor: SimpleNamespace(
                solved=True, status="Solved", value=10.0 * (1.6 - factor)))
            bound = find_factor(cast(Side, side), guess)[0]
            self.assertEqual(bound.status, "Solved")
            self.assertAlmostEqual(bound.value, 1.6 + (2e-4 if above else -2e-4), delta=1.2e-4)

    def test_a_pressure_is_the_traction_against_its_face(self) -> None:
        traction = STRIP.format(strength="1, 0, 0")
        pressure = traction.replace("*TRACTION, SURFACE=footing\n0, -1", "*PRESSURE, SURFACE=footing\n1")
        self.assertEqual(self.bracket(traction, *FEW), self.bracket(pressure, *FEW))

    def test_a_supported_face_does_not_fail(self) -> None:
        held = CUT.replace("*PHASE", "*SURFACE, NAME=face, TYPE=SEGMENT\n3, 2, 3, 3\n*PHASE").replace("*GRAVITY", "*SUPPORT, SURFACE=face, TYPE=NORMAL\n*GRAVITY")
        self.assertGreater(self.bracket(held, *FEW)[0], 1.3 * self.bracket(CUT)[1])

    def test_a_rigid_body_pushes_as_its_nodes_do(self) -> None:
        body = PUSHED.replace("*NSET, NSET=foot, BOX\n0, 1, 3, 3", "*RIGID BODY, NAME=foot, SHAPE=BOX\n-1, 1, 3, 4\n*CONTACT, BODY=foot, ADHESION=1").replace(
            "*FIX\nfoot, X\n*PRESCRIBE\nfoot, Y, -0.3", "*MOVE, BODY=foot\n0, -0.3")
        self.between(2.0 + math.pi, self.bracket(body), 0.08)

    def test_a_plate_slides_on_clay_by_its_adhesion(self) -> None:
        body = PUSHED.replace("*NSET, NSET=foot, BOX\n0, 1, 3, 3", "*RIGID BODY, NAME=foot, SHAPE=BOX\n2, 4, 3, 4\n*CONTACT, BODY=foot, ADHESION=0.5").replace(
            "*FIX\nfoot, X\n*PRESCRIBE\nfoot, Y, -0.3", "*MOVE, BODY=foot\n0.1, 0")
        for words in ("ADHESION=0.5", "INTERFACE=0.5"):
            self.between(1.0, self.bracket(body.replace("ADHESION=0.5", words)), 0.03)

    def test_walls_by_rankine_and_by_slip_lines(self) -> None:
        passive = (TOP / "verification/week/decks/wall_passive.inp").read_text(encoding="utf-8")
        self.between(117.877, self.bracket(passive), 0.03)
        # With friction, above ground that goes on below the wall: slip lines, 5.2559 gamma H^2/2 cos 20 and 0.63 for c (verification/cases/contact.toml).
        rough = (TOP / "input/wall_passive.inp").read_text(encoding="utf-8")
        for old, new in (("Y, 0, 1.5, 15", "Y, -0.3, 1.5, 18"), ("PLANE=Y\n0\n", "PLANE=Y\n-0.3\n*NSET, NSET=left, BOX\n0, 0, -0.3, 0\n"),
                         ("0, 4, 0, 1\n", "0, 4, -0.3, 1\n"), ("far, X\n*GRAVITY", "far, X\nleft, X\n*GRAVITY"),
                         ("SHAPE=PLANE\n0, 0, 1, 0", "SHAPE=BOX\n-1, 0, 0, 2")):  # fmt: skip
            self.assertIn(old, rough)
            rough = rough.replace(old, new)
        self.between(45.08, self.bracket(rough), 0.03)

    def test_a_study_is_told_where_a_contact_force_lies(self) -> None:
        deck = read_deck(TOP / "verification/week/decks/wall_passive.inp")
        with mock.patch("qsmpm_verify.bounds.verb.Search", lambda scene: Search(scene, 100, 1)):
            text = note_of(deck, False, 119.6, "force")[0]
        self.assertRegex(text, r"^limit analysis: between 117\.8\d* and 117\.8\d*; the result is 1\.\d+% above the upper bound$")
        self.assertEqual(note_of(deck, False, 119.6, "p1"), ("", None))

    def test_a_mechanism_is_drawn(self) -> None:
        picture = self.folder / "mechanism.png"
        code, said = self.ask(CUT, "--triangles", "100", "--passes", "0", "--out", str(picture))
        self.assertEqual(code, 0, said)
        self.assertGreater(picture.stat().st_size, 10000)

    def test_a_door_beside_a_floor(self) -> None:
        """Sets that touch, or miss by less than 0.05 of a cell of 0.5 m, are one scene; 0.03 m apart the ground between is free and bears a little less."""
        touching = self.bracket(DOOR.format(begin=1))
        self.assertLess(touching[1] / touching[0] - 1.0, 0.04)
        for begin in (1.0001, 1.02, 0.98):
            self.assertEqual(self.bracket(DOOR.format(begin=begin)), touching)
        code, said = self.ask(DOOR.format(begin=1.0001), "--triangles", "60", "--passes", "0")
        self.assertEqual((code, "set 'floor' ends 0.0001 from set 'door' along X: treated as touching" in said), (0, True), said)
        apart = self.bracket(DOOR.format(begin=1.03))
        self.assertLess(apart[1], touching[1])
        self.assertGreater(apart[1], touching[0] * 0.98)

    def test_a_door_in_a_corner(self) -> None:
        """Beside a wall that is held fully it moves as beside a floor: no triangle is asked for two velocities in its corner."""
        corner = DOOR.format(begin=4).replace("door, BOX\n0, 1", "door, BOX\n0, 4").replace("floor, BOX\n4, 5", "floor, BOX\n4, 5")
        corner = corner.replace("floor, ALL", "door, ALL\nright, ALL").replace("door, Y", "floor, Y")
        touching = self.bracket(corner)
        self.assertLess(touching[1] / touching[0] - 1.0, 0.05)

    def test_bounds_in_the_wrong_order_are_none(self) -> None:
        bound = Bound(3892.0, "Solved", 1.0)
        for low, code in ((3892.0, 1), (18.0, 1), (17.59, 0)):
            with mock.patch.object(Search, "run", lambda self: Found(self.kind, replace(bound, value=17.58), replace(bound, value=low), 9, False, cast(Mechanism, None))):
                found, said = self.ask(CUT)
            self.assertEqual((found, "bracket    none" in said), (code, code == 1), said)
            self.assertEqual(json.loads((self.folder / "bounds.json").read_text())["lower"]["value"] is None, code == 1)
            with mock.patch.object(Search, "run", lambda self: Found(self.kind, replace(bound, value=17.58), replace(bound, value=low), 9, False, cast(Mechanism, None))):
                self.assertEqual(note_of(read_deck(self.folder / "scene.inp"), False, None)[1] is None, code == 1)

    def test_what_is_not_solved_is_no_bound(self) -> None:
        honest = cone.largest

        def stopped(*given: object) -> cone.Answer:
            a = honest(*given)  # type: ignore[arg-type]
            return replace(a, status="AlmostSolved")

        with mock.patch("qsmpm_verify.bounds.search.largest", stopped):
            code, said = self.ask(CUT, "--triangles", "60", "--passes", "0")
        self.assertEqual(code, 1)
        self.assertIn("upper      none: solver status AlmostSolved", said)
        self.assertNotIn("bracket", said)
        self.assertIsNone(json.loads((self.folder / "bounds.json").read_text())["upper"]["value"])

    @mock.patch("qsmpm_verify.bounds.verb.Search", lambda scene: Search(scene, 300, 2))
    def test_a_study_is_told_where_its_answer_lies(self) -> None:
        deck = self.folder / "scene.inp"
        deck.write_text(CUT)
        text, bounds = note_of(read_deck(deck), False, 4.2)
        assert bounds is not None
        self.assertTrue(bounds[0] < 3.7776 < bounds[1])
        self.assertRegex(text, r"^limit analysis: between 3\.7\d+ and 3\.8\d+; the result is \d+\.\d+% above the upper bound$")
        self.assertNotIn("the result", note_of(read_deck(deck), False, 3.7776)[0])
        self.assertEqual(note_of(read_deck(deck), True, 4.2), ("", None))
        deck.write_text(CUT.replace("*GRAVITY", "*ROTATE\n*GRAVITY"))
        self.assertIn("ROTATE", note_of(read_deck(deck), False, None)[0])

    def test_what_bounds_cannot_take_is_refused_by_name(self) -> None:
        for before, after, word in (
            ("TYPE=PLANE STRAIN", "TYPE=AXISYMMETRIC", "TYPE=AXISYMMETRIC"),
            ("*MOHR COULOMB\n1, 0, 0", "*CAM CLAY\n1, 1, 1, 1", "CAM CLAY"),
            ("*PHASE", "*RIGID BODY, NAME=a, SHAPE=CIRCLE\n0, 1, 3\n*PHASE", "SHAPE=CIRCLE"),
            ("*BODY", "*FIELD OF VALUES\nE, e.csv\nC, c.csv\n*BODY", "C from samples is not linear"),
            ("*PHASE", "*RIGID BODY, NAME=a, SHAPE=BOX\n0, 1, 4, 5\n*CONTACT, BODY=a\n*PHASE", "not in contact with a face"),
            ("*PHASE", "*RIGID BODY, NAME=a, SHAPE=BOX\n0, 1, 3, 4\n*CONTACT, BODY=a, TENSION=YES\n*PHASE", "TENSION=YES"),
            ("*GRAVITY\n0, -1", "*GRAVITY\n1, 0\n*WATER LEVEL, UNIT WEIGHT=10\n0, 1\n6, 1", "WATER LEVEL"),
            ("*GRAVITY\n0, -1\n", "", "no load changes"),
            ("*MOHR COULOMB\n1, 0, 0\n", "", "no body can fail"),
            ("*GRAVITY", "*INSTALL\nprop\n*GRAVITY", "'prop' is not defined"),
        ):
            code, said = self.ask(CUT.replace(before, after))
            self.assertEqual(code, 2, said)
            self.assertIn(word, said)
        code, said = self.ask(FOOTING.replace("0.3, 3.2, 0.3, 0", "0.3, 2.9, 0.3, 0").replace("*TRACTION", "*INSTALL\nprop\n*TRACTION"))
        self.assertEqual((code, "its end at (0.3, 2.9) is not in a body without *MOHR COULOMB" in said), (2, True), said)
        self.assertEqual(self.ask(CUT, "--phase", "none")[0], 2)
        self.assertEqual(self.ask(CUT, "--triangles", "5")[0], 2)
        self.assertEqual(self.ask(CUT, "--out", "picture.bmp")[0], 2)
