"""Scenes of other programs: what is read of a scene, what is written for CalculiX and read back, what is judged."""

import contextlib
import io
import json
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import numpy as np

from qsmpm_verify import peers_calculix, peers_compute, peers_kratos
from qsmpm_verify.cases import CaseError
from qsmpm_verify.cli import main
from qsmpm_verify.peers_compute import Outcome
from qsmpm_verify.peers_judge import chart_point, judge_check, limit
from qsmpm_verify.peers_loads import outer_edges, shares_of_area, traction_forces, weight_forces
from qsmpm_verify.peers_model import Model, Solution, _check_scene, node_set, read_blocks
from qsmpm_verify.peers_runs import run_peer
from qsmpm_verify.peers_scenes import load_scene, load_scenes
from qsmpm_verify.places import PEERS, PROGRAM, TOP
from qsmpm_verify.trouble import RunFailed, Trouble

SQUARE = np.array([(0, 0), (1, 0), (1, 1), (0, 1), (0.5, 0), (1, 0.5), (0.5, 1), (0, 0.5)], dtype=float)
DECK = """*MODEL, TYPE=PLANE STRAIN
*METHOD, BASIS=FEM,
 KINEMATICS=LOGARITHMIC
*NSET, NSET=base, PLANE=Y
 0
*NSET, NSET=corner, BOX
 0.9, 1.1, 0.9, 1.1
"""
DAT = """
 displacements (vx,vy,vz) for set ALL and time  0.5000000E+00

         1  9.000000E+00  0.000000E+00  0.000000E+00
         2  9.000000E+00  0.000000E+00  0.000000E+00

 total force (fx,fy,fz) for set HELD and time  0.5000000E+00

        9.000000E+00  9.000000E+00  0.000000E+00

 displacements (vx,vy,vz) for set ALL and time  0.1000000E+01

         1  1.500000E-02 -2.500000E-03  0.000000E+00
         2 -1.000000E+00  0.000000E+00  7.000000E+00

 total force (fx,fy,fz) for set HELD and time  0.1000000E+01

       -5.000000E-01  1.666667E+00  2.428613E-17
"""


def confined(weight: float = 0.0, push: float = 0.0) -> Model:
    """A square of one cell between rollers on three sides, E = 100 and nu = 0.3."""
    held = [(n, 1) for n in (0, 1, 4)] + [(n, 0) for n in (0, 3, 7, 1, 2, 5)]
    forces = traction_forces(SQUARE, [(2, 3, 6)], np.array([0.0, -push]))
    places = {"top": (6, 1, -1.0)}
    return Model(SQUARE, np.arange(8)[None, :], 23, 100.0, 0.3, (0.0, -weight), sorted(held), forces, places)


class Loads(unittest.TestCase):
    def test_a_square_shares_its_area_as_the_8_node_cell_does(self) -> None:
        """-1/12 a corner and 1/3 a middle, exactly."""
        shares = shares_of_area(SQUARE, 23)
        np.testing.assert_allclose(shares, [-1 / 12] * 4 + [1 / 3] * 4, atol=1e-15)

    def test_first_moments_of_a_slanting_cell_are_those_of_its_polygon(self) -> None:
        """The sum of the shares times the places of the nodes is the area times the centroid (isoparametric)."""
        corners = np.array([(0, 0), (2, 0.5), (1.8, 2), (0.1, 1)])
        places = np.vstack([corners, (corners + np.roll(corners, -1, axis=0)) / 2])
        x, y = corners.T
        cross = x * np.roll(y, -1) - np.roll(x, -1) * y
        moment = ((corners + np.roll(corners, -1, axis=0)) * cross[:, None]).sum(axis=0) / 6
        np.testing.assert_allclose(shares_of_area(places, 23) @ places, moment, rtol=1e-13)
        np.testing.assert_allclose(shares_of_area(places[:4], 9) @ places[:4], moment, rtol=1e-13)

    def test_triangles_put_their_weight_on_the_middles(self) -> None:
        nodes = np.array([(0, 0), (2, 0), (0, 1), (1, 0), (1, 0.5), (0, 0.5)], dtype=float)
        weight = weight_forces(nodes, np.arange(6)[None, :], 22, (0.0, -3.0))
        np.testing.assert_allclose(weight[:, 1], [0, 0, 0, -1, -1, -1], atol=1e-15)

    def test_only_sides_that_one_cell_has_are_outer_and_tractions_balance(self) -> None:
        cells = np.array([[0, 1, 4, 3], [1, 2, 5, 4]])
        edges = outer_edges(cells, 9)
        self.assertEqual(len(edges), 6)
        self.assertNotIn(frozenset((1, 4)), {frozenset(edge) for edge in edges})
        nodes = np.array([(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (2, 1)], dtype=float)
        forces = traction_forces(nodes, [edge for edge in edges if set(edge) <= {3, 4, 5}], np.array([1.0, -2.0]))
        np.testing.assert_allclose(forces.sum(axis=0), [2.0, -4.0])
        np.testing.assert_allclose(forces[4], [1.0, -2.0])


class Decks(unittest.TestCase):
    def test_blocks_go_on_behind_a_comma(self) -> None:
        blocks = read_blocks(DECK)
        self.assertEqual([block.keyword for block in blocks], ["MODEL", "METHOD", "NSET", "NSET"])
        self.assertEqual(blocks[1].parameters, {"BASIS": "FEM", "KINEMATICS": "LOGARITHMIC"})

    def test_sets_by_plane_and_box(self) -> None:
        blocks = read_blocks(DECK)
        self.assertEqual(node_set(blocks, "BASE", SQUARE).tolist(), [0, 1, 4])
        self.assertEqual(node_set(blocks, "corner", SQUARE).tolist(), [2])
        self.assertRaisesRegex(Trouble, "is not in the deck", node_set, blocks, "left", SQUARE)

    def test_what_is_not_understood_is_an_error(self) -> None:
        for more, told in (("*MOHR COULOMB\n 1, 25, 0\n", "MOHR COULOMB"), ("", "BASIS=FEM"), ("", "plane strain")):
            text = DECK + more
            if told == "BASIS=FEM":
                text = text.replace("BASIS=FEM", "BASIS=GIMP")
            if told == "plane strain":
                text = text.replace("PLANE STRAIN", "AXISYMMETRIC")
            self.assertRaisesRegex(Trouble, told, _check_scene, read_blocks(text))
        _check_scene(read_blocks(DECK))


class Calculix(unittest.TestCase):
    def test_the_input_has_the_cell_the_supports_and_fields_of_twenty_characters_at_most(self) -> None:
        text = peers_calculix.input_text(confined(weight=2.0, push=1.0))
        lines = text.splitlines()
        self.assertEqual(lines[lines.index("*ELEMENT, TYPE=CPE8, ELSET=body") + 1], "1, 1, 2, 3, 4, 5, 6, 7, 8")
        self.assertIn("body, GRAV, 1., 0, -1, 0.", lines)
        self.assertIn("2", lines[lines.index("*DENSITY") + 1])
        self.assertEqual(sum(line.endswith(", 2, 2") for line in lines), 3)
        self.assertTrue(all(len(word.strip()) <= 20 for line in lines if line[0] != "*" for word in line.split(",")))
        self.assertIn("*STATIC", lines)
        self.assertNotIn("NLGEOM", text)

    def test_finite_deformation_laws_and_elements(self) -> None:
        text = peers_calculix.input_text(confined(), "CPE8R", "NEO HOOKE", 4)
        self.assertIn("*STEP, NLGEOM, INC=10000", text)
        shear, bulk = 100 / 2.6, 100 / 1.2
        self.assertIn(f"*HYPERELASTIC, NEO HOOKE\n{shear / 2:.12G}, {2 / bulk:.12G}\n", text)
        self.assertRaisesRegex(Trouble, "CPE6 is not an element with 8", peers_calculix.input_text, confined(), "CPE6")
        self.assertRaisesRegex(Trouble, "unknown law", peers_calculix.input_text, confined(), "", "OGDEN")

    def test_the_last_increment_is_read(self) -> None:
        moved, force, time = peers_calculix.read_dat(DAT)
        np.testing.assert_allclose(moved, [(0.015, -0.0025), (-1.0, 0.0)])
        np.testing.assert_allclose(force, (-0.5, 1.666667))
        self.assertEqual(time, 1.0)

    def test_a_print_without_forces_or_with_other_nodes_is_an_error(self) -> None:
        self.assertRaises(RunFailed, peers_calculix.read_dat, DAT.split(" total force")[0])
        self.assertRaisesRegex(RunFailed, "other nodes", peers_calculix.read_dat, DAT.replace("         2 ", "         3 "))

    @unittest.skipUnless(peers_calculix.version(), "not installed: calculix-ccx")
    def test_confined_compression_by_the_program_is_the_closed_form(self) -> None:
        """Seven digits are printed. Settlement p H / M + w H^2 / (2 M), M = E (1 - nu) / ((1 + nu) (1 - 2 nu))."""
        modulus = 100 * 0.7 / (1.3 * 0.4)
        with tempfile.TemporaryDirectory() as folder:
            solution, run = peers_calculix.solve(confined(2.0, 1.0), Path(folder) / "ccx")
            _, again = peers_calculix.solve(confined(2.0, 1.0), Path(folder) / "ccx")
        self.assertAlmostEqual(-solution.displacement[6, 1] * modulus, 1.0 + 1.0, 5)
        self.assertAlmostEqual(solution.reaction[1], 3.0, 5)
        self.assertFalse(run.reused)
        self.assertTrue(again.reused)


class Kratos(unittest.TestCase):
    def test_the_scene_has_loads_cells_and_the_element_of_the_cells(self) -> None:
        scene = json.loads(peers_kratos.scene_text(confined(2.0, 1.0), "TotalLagrangianElement", 5))
        self.assertEqual((scene["element"], scene["steps"]), ("TotalLagrangianElement2D8N", 5))
        self.assertEqual([entry[0] for entry in scene["forces"]], [2, 3, 6])
        self.assertAlmostEqual(sum(entry[2] for entry in scene["forces"]), -1.0, 15)
        self.assertEqual(len(scene["held"]), 9)

    @unittest.skipUnless(peers_kratos.version(), "not installed: Kratos")
    def test_confined_compression_by_the_program_is_the_closed_form(self) -> None:
        """Settlement and force as with CalculiX, to the round-off of JSON and a direct solution."""
        modulus = 100 * 0.7 / (1.3 * 0.4)
        with tempfile.TemporaryDirectory() as folder:
            solution, _ = peers_kratos.solve(confined(2.0, 1.0), Path(folder) / "kratos")
        self.assertAlmostEqual(-solution.displacement[6, 1] * modulus, 2.0, 11)
        self.assertAlmostEqual(solution.reaction[1], 3.0, 11)


class Runs(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name) / "run"

    def go(self, text: str = "print(1)", version: str = "1", fresh: bool = False) -> bool:
        command = [sys.executable, "a.py"]
        return run_peer(command, version, {"a.py": text}, ["terminal.txt"], self.folder, fresh=fresh).reused

    def test_a_run_is_kept_until_its_input_or_program_changes(self) -> None:
        self.assertEqual([self.go(), self.go(), self.go(fresh=True)], [False, True, False])
        self.assertEqual([self.go("print(2)"), self.go("print(2)", "2"), self.go("print(2)", "2")], [False, False, True])
        (self.folder / "terminal.txt").unlink()
        self.assertFalse(self.go("print(2)", "2"))

    def test_a_run_that_fails_or_writes_nothing_is_told(self) -> None:
        self.assertRaisesRegex(RunFailed, "exit code 3", self.go, "import sys; print('it broke'); sys.exit(3)")
        self.assertFalse((self.folder / "peer.json").exists())
        with self.assertRaisesRegex(RunFailed, "no result.json"):
            run_peer([sys.executable, "a.py"], "1", {"a.py": ""}, ["result.json"], self.folder)


SCENE = """title = "t"
deck = "verification/peers/slope.inp"
note = "n"
[[run]]
name = "own"
[[run]]
name = "ccx"
program = "calculix"
of = "own"
[[check]]
of = "own"
against = "ccx"
quantity = "field"
tolerance = 1e-6
reason = "r"
[[check]]
of = "own"
reference = 2.0
quantity = "crest"
tolerance = 0.1
reason = "r"
[[point]]
study = "slope_settlement"
label = "CalculiX"
run = "ccx"
quantity = "crest"
reference = 2.0
size = 8
"""


class Judging(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.path = Path(temporary.name) / "small.toml"

    def scene(self, text: str = SCENE):  # noqa: ANN201
        self.path.write_text(text)
        return load_scene(self.path, TOP)

    def outcomes(self, by: float, crest: float = 2.1) -> dict[str, Outcome]:
        moved = np.array([(0.0, -2.0), (1.0, 0.0)])
        other = Solution(moved + [(0, 0), (by, 0)], np.zeros(2))
        return {"own": Outcome("QSMPM", 1.0, False, {"crest": crest}, Solution(moved, np.zeros(2))),
                "ccx": Outcome("CalculiX 2.20", 2.0, False, {"crest": 1.9}, other)}  # fmt: skip

    def test_fields_are_judged_by_the_largest_displacement(self) -> None:
        scene = self.scene()
        near, far = (judge_check(scene, scene.checks[0], self.outcomes(by)) for by in (1.9e-6, 2.1e-6))
        self.assertTrue(near.held)
        self.assertAlmostEqual(near.difference, 0.95e-6, 12)
        self.assertIs(far.held, False)

    def test_pressures_are_judged_by_the_largest_one_and_what_was_said_is_kept(self) -> None:
        scene = self.scene(SCENE.replace('quantity = "field"', 'quantity = "pressure field"'))
        own, other = (Solution(np.ones((2, 2)), np.zeros(2), np.array(p)) for p in ([4.0, 1.0], [4.0, 1.000003]))
        outcomes = {"own": Outcome("QSMPM", solution=own, said="so"), "ccx": Outcome("OpenGeoSys", solution=other)}
        found = judge_check(scene, scene.checks[0], outcomes)
        self.assertTrue(found.held)
        self.assertAlmostEqual(found.difference, 0.75e-6, 12)
        self.assertEqual(found.said, ("own: so",))
        without = judge_check(scene, scene.checks[0], self.outcomes(0.0))
        self.assertIs(without.held, False)
        self.assertIn("with groundwater flow", without.note)

    def test_a_figure_is_judged_by_its_reference(self) -> None:
        scene = self.scene()
        self.assertTrue(judge_check(scene, scene.checks[1], self.outcomes(0.0)).held)
        self.assertIs(judge_check(scene, scene.checks[1], self.outcomes(0.0, 2.3)).held, False)
        self.assertIs(judge_check(scene, scene.checks[1], self.outcomes(0.0, float("nan"))).held, False)

    def test_what_is_absent_fails_nothing_and_what_broke_does(self) -> None:
        scene = self.scene()
        for absent, held in ((True, None), (False, False)):
            outcomes = {**self.outcomes(0.0), "ccx": Outcome("calculix", trouble="not there", absent=absent)}
            found = judge_check(scene, scene.checks[0], outcomes)
            self.assertIs(found.held, held)
            self.assertIn("not there", found.note)
        self.assertIsNone(judge_check(scene, scene.checks[0], {"own": self.outcomes(0.0)["own"]}))

    def test_points_have_an_error_and_seconds_or_tell_why_not(self) -> None:
        scene = self.scene()
        point = chart_point(scene, scene.points[0], self.outcomes(0.0))
        self.assertAlmostEqual(point["error"], 0.05, 12)
        self.assertEqual((point["seconds"], point["size"]), (2.0, 8.0))
        broken = {**self.outcomes(0.0), "ccx": Outcome("CalculiX 2.20", 3.0, trouble="it broke")}
        point = chart_point(scene, scene.points[0], broken)
        self.assertEqual((point["error"], point["seconds"], point["note"]), (None, None, "it broke"))

    def test_the_limit_of_a_geometric_sequence_is_exact(self) -> None:
        self.assertAlmostEqual(limit([3 + 0.5**k for k in (1, 2, 3)]), 3.0, 14)
        self.assertRaises(ValueError, limit, [1.0, 2.0, 4.0])
        self.assertRaises(ValueError, limit, [1.0, 1.0, 1.0])

    def test_scene_files_are_checked(self) -> None:
        for old, new, told in (
            ('of = "own"\nagainst', 'of = "other"\nagainst', "unknown run 'other'"),
            ('program = "calculix"', 'program = "ansys"', "program must be one of"),
            ('reason = "r"\n[[check]]', '[[check]]', "tolerance and reason"),
            ('of = "own"\n[[check]]', 'of = "ccx"\n[[check]]', "an earlier run of qsmpm"),
            ('reference = 2.0\nquantity', 'reference = {function = "x"}\nquantity', "name a function"),
            ('note = "n"', 'note = "n"\nnotes = "n"', "unknown key"),
        ):  # fmt: skip
            self.assertIn(old, SCENE)
            self.assertRaisesRegex(CaseError, told, self.scene, SCENE.replace(old, new, 1))

    def test_every_scene_of_the_tree_is_right_and_its_studies_exist(self) -> None:
        scenes = load_scenes(PEERS, TOP, [])
        self.assertTrue({"slope", "cantilever", "cook"} <= {scene.name for scene in scenes})
        for scene in scenes:
            self.assertTrue(scene.deck.is_file(), scene.name)
            for point in scene.points:
                self.assertTrue((TOP / "verification" / "studies" / f"{point.study}.toml").is_file(), point.study)
        self.assertRaisesRegex(CaseError, "unknown scene", load_scenes, PEERS, TOP, ["nothing"])


class Verb(unittest.TestCase):
    """The whole way, on the elastic slope; it takes seconds."""

    def go(self, *words: str) -> tuple[int, str, dict]:
        with tempfile.TemporaryDirectory() as folder, io.StringIO() as told:
            out = Path(folder)
            with contextlib.redirect_stdout(told), contextlib.redirect_stderr(io.StringIO()):
                code = main(["peers", "slope", "--json", str(out / "peers.json"), "--out", str(out / "runs"), *words])
            return code, told.getvalue(), json.loads((out / "peers.json").read_text())

    @unittest.skipUnless(peers_calculix.version() and PROGRAM.is_file(), "not installed: calculix-ccx, or not built")
    def test_the_slope_by_calculix_is_ours(self) -> None:
        code, told, content = self.go()
        self.assertEqual(code, 0, told)
        judged = [check for check in content["checks"] if check["peer"].startswith("CalculiX") and check["held"]]
        self.assertGreaterEqual(len(judged), 4)

    @unittest.skipUnless(PROGRAM.is_file(), "not built")
    def test_programs_that_are_not_there_are_told(self) -> None:
        nothing = dict.fromkeys(peers_compute.VERSIONS, lambda: "")
        with mock.patch.object(peers_compute, "VERSIONS", nothing):
            code, told, content = self.go()
        self.assertEqual(code, 0, told)
        self.assertIn("not installed: CalculiX", told)
        self.assertTrue(all(check["held"] is not False for check in content["checks"]))
        self.assertEqual(content["points"], [])


if __name__ == "__main__":
    unittest.main()
