"""The package against the library of the build folder: stepping, views, loads, errors, materials."""
from __future__ import annotations

import ctypes
import gc
import pathlib
import tempfile
import unittest

import numpy as np

import qsmpm

DECKS = pathlib.Path(__file__).resolve().parents[3] / "verification" / "embedding"
BLOCK, PULL = DECKS / "block.inp", DECKS / "pull.inp"


class Hooke(qsmpm.SoilModel):
    """Isotropic elasticity, which may be told to fail."""

    state_count = 1
    symmetric = True
    stiffness_scale = 1000.0
    shear_scale = 1000.0 / 2.6

    def __init__(self, fails: bool = False) -> None:
        self.fails = fails
        self.rotations = 0.0

    def update(self, increment: qsmpm.Increment, stress: np.ndarray, state: np.ndarray) -> qsmpm.Update:
        if self.fails:
            raise ValueError("no stress for you")
        shear = 1000.0 / 2.6
        tangent = np.diag([2 * shear] * 3 + [shear] * 3)
        tangent[:3, :3] += 2 * shear * 0.3 / 0.4
        self.rotations = max(self.rotations, float(np.abs(increment.rotation @ increment.rotation.T - np.eye(3)).max()))
        return qsmpm.Update(stress + tangent @ increment.strain, state + increment.strain[1], tangent)


class Stepping(unittest.TestCase):
    """Decks and steps."""

    def test_steps_and_histories(self) -> None:
        heard: list[str] = []
        with qsmpm.Simulation(BLOCK, logger=heard.append, verbosity=2) as run:
            self.assertEqual(run.names("history"), ["settlement"])
            settled = [run.histories["settlement"] for _ in run.steps()]
            self.assertEqual(len(settled), 5)
            self.assertTrue(all(a < b for a, b in zip(settled, settled[1:])))
            self.assertEqual((run.stage, run.step, run.share, run.load_factor), (1, 5, 1.0, 1.0))
        self.assertEqual(sum("step" in line for line in heard), 5)

    def test_text_is_the_file(self) -> None:
        with qsmpm.Simulation(BLOCK) as one, qsmpm.Simulation.from_text(BLOCK.read_text(), "block") as two:
            one.run()
            while not two.finished:
                two.advance()
            self.assertEqual(one.points.stress.tobytes(), two.points.stress.tobytes())

    def test_save_and_load(self) -> None:
        with tempfile.TemporaryDirectory() as folder, qsmpm.Simulation(BLOCK) as one, qsmpm.Simulation(BLOCK) as two:
            one.advance_to(0.6)
            one.save(pathlib.Path(folder) / "state.h5")
            one.run()
            two.load(pathlib.Path(folder) / "state.h5")
            self.assertAlmostEqual(two.share, 0.6, places=12)
            two.run()
            self.assertEqual(one.points.position.tobytes(), two.points.position.tobytes())

    def test_stages_last_as_long_as_they_are_told(self) -> None:
        times: list[tuple[float, float]] = []

        class Timed(Hooke):
            def update(self, increment: qsmpm.Increment, stress: np.ndarray, state: np.ndarray) -> qsmpm.Update:
                times.append((increment.time, increment.time_increment))
                return super().update(increment, stress, state)

        with qsmpm.Simulation(BLOCK, materials={"soil": Timed()}) as run:
            run.set_time(8.0)
            run.run()
            self.assertEqual(run.time, 8.0)
            run.add_stage("later", steps=2)
            run.set_time(4.0, start=20.0)
            times.clear()
            run.run()
            self.assertEqual(run.time, 24.0)
            self.assertEqual((times[0], times[-1]), ((20.0, 2.0), (22.0, 2.0)))
            run.add_stage("never")
            with self.assertRaisesRegex(qsmpm.Error, "lasts longer than 0"):
                run.set_time(0.0)

    def test_versions(self) -> None:
        self.assertIn("qsmpm", qsmpm.version())
        self.assertEqual(qsmpm.api_version() // 100, 2)
        self.assertTrue(qsmpm.has("openmp"))
        self.assertFalse(qsmpm.has("teleportation"))


class Refused(unittest.TestCase):
    """What would be taken in silence for something else."""

    def test_components_that_are_none_do_not_free_a_set(self) -> None:
        with qsmpm.Simulation(BLOCK) as run:
            run.add_stage("more")
            for wrong in ((7,), (-1,), (0, 3), (0.5,)):
                with self.assertRaisesRegex(ValueError, "components are 0, 1 and 2"):
                    run.set_fixity("base", wrong)
            with self.assertRaisesRegex(qsmpm.Error, "component 3"):
                run.set_fixity("base", (2,))
            run.set_fixity("base", (0, 1))

    def test_a_level_that_is_not_there_is_not_moved(self) -> None:
        with qsmpm.Simulation(BLOCK) as run:
            run.add_stage("more")
            with self.assertRaisesRegex(qsmpm.Error, "no level of 'lake' is in force"):
                run.set_water_level("lake", 1.0)

    def test_vectors_stay_in_the_plane(self) -> None:
        with qsmpm.Simulation(BLOCK) as run:
            run.add_stage("more")
            with self.assertRaisesRegex(qsmpm.Error, "along z"):
                run.set_traction("any", (0.0, -1.0, 1.0))
            with self.assertRaisesRegex(qsmpm.Error, "along z"):
                run.set_gravity((0.0, -1.0, 1.0))
            with self.assertRaisesRegex(qsmpm.Error, "finite"):
                run.set_load_factor(float("inf"))
            run.set_gravity((0.0, -1.0, 0.0))

    def test_what_start_raises_is_raised_by_the_call(self) -> None:
        class Wrong(Hooke):
            def start(self, stress: np.ndarray) -> np.ndarray:
                raise KeyError("no void ratio")

        with self.assertRaisesRegex(qsmpm.UserMaterialError, "no void ratio") as caught:
            qsmpm.Simulation(BLOCK, materials={"soil": Wrong()})
        self.assertIsInstance(caught.exception.__cause__, KeyError)

    def test_a_material_that_comes_too_late_or_is_not_there_is_an_error(self) -> None:
        with qsmpm.Simulation(BLOCK) as run:
            start, update = Hooke().callbacks()
            words = (ctypes.byref(Hooke().options()), start, update, None)
            with self.assertRaisesRegex(qsmpm.Error, "too late"):
                run._call("set_material", b"soil", *words)
        with self.assertRaisesRegex(qsmpm.Error, "none of that name.*did you mean soil"):
            qsmpm.Simulation(BLOCK, materials={"soils": Hooke()})

    def test_no_address_is_a_status_and_not_a_crash(self) -> None:
        library = qsmpm.library.load()
        self.assertEqual(library.qsmpm_create(None), 7)
        with qsmpm.Simulation(BLOCK) as run:
            run.add_stage("more")
            pointer = run._handle.pointer
            skipped = {"api_version", "version", "has", "create", "destroy", "error", "messages", "name", "finished", "set_logger"}
            for name, types in qsmpm.library.SIGNATURES.items():
                if name in skipped or not any(hasattr(t, "contents") or t is ctypes.c_char_p for t in types):
                    continue
                words = [0 if t is ctypes.c_int else 0.0 if t is ctypes.c_double else t() if hasattr(t, "_flags_") else None
                         for t in types[1:]]
                self.assertNotEqual(getattr(library, "qsmpm_" + name)(None, *words), 0, name)
                if name not in ("read_deck", "parse_deck"):
                    self.assertNotEqual(getattr(library, "qsmpm_" + name)(pointer, *words), 0, name)
            self.assertEqual(library.qsmpm_name(pointer, None, 1, None, 0), -1)
            rows = ctypes.c_int()
            self.assertNotEqual(library.qsmpm_shape(pointer, b"point_stress", ctypes.byref(rows), None), 0)
            self.assertNotEqual(library.qsmpm_set_gravity(pointer, None), 0)
            for name in ("read_deck", "parse_deck"):
                self.assertNotEqual(getattr(library, "qsmpm_" + name)(pointer, *[None] * (len(qsmpm.library.SIGNATURES[name]) - 1)), 0)


class Clay(unittest.TestCase):
    """A law with history: Modified Cam-Clay, whose state is the preconsolidation pressure."""

    DECK = DECKS.parents[1] / "input" / "footing_clay.inp"

    def test_history_is_put_back_with_the_stress(self) -> None:
        with qsmpm.Simulation(self.DECK) as run:
            for _ in range(3):
                run.advance()
            run.checkpoint()
            stress, state = run.points.stress.copy(), run.points.state.copy()
            run.advance()
            ahead = run.points.state.copy()
            self.assertTrue((ahead >= state).all() and (ahead > state).any())
            run.restore_checkpoint()
            self.assertEqual(run.points.stress.tobytes(), stress.tobytes())
            self.assertEqual(run.points.state.tobytes(), state.tobytes())
            run.advance()
            self.assertEqual(run.points.state.tobytes(), ahead.tobytes())

    def test_a_new_stress_has_a_new_history(self) -> None:
        with qsmpm.Simulation(self.DECK) as run:
            run.advance()
            stress = np.tile([-60.0, -120.0, -60.0, 0.0], (run.points.stress.shape[0], 1))
            run.set("point_stress", stress)
            # OCR (p + q^2/(M^2 p)) with OCR = 1.5, M = 1, p = 80, q = 60.
            np.testing.assert_allclose(run.points.state[:, 0], 1.5 * (80.0 + 60.0**2 / 80.0), rtol=1e-12)


class Pressures(unittest.TestCase):
    """Pore pressures of consolidation, at nodes."""

    DECK = DECKS.parents[0] / "cases" / "decks" / "consolidation_layer.inp"

    def test_pressures_are_read_and_set(self) -> None:
        with qsmpm.Simulation(self.DECK) as run:
            run.advance()
            height, pressure = run.get("node_position").reshape(-1, 2)[:, 1], run.get("node_pressure").ravel()
            self.assertEqual(pressure.shape, height.shape)
            corner = (pressure != 0) & (height < 0.45)
            self.assertTrue(corner.any())
            np.testing.assert_allclose(pressure[corner], 1.0, atol=0.02)
            run.set("node_pressure", 0.5 * run.get("node_pressure"))
            np.testing.assert_allclose(run.get("node_pressure").ravel(), 0.5 * pressure)
            low = run.get("point_position").reshape(-1, 2)[:, 1] < 0.35
            np.testing.assert_allclose(run.get("point_pore_pressure").ravel()[low], 0.5, atol=0.01)
            run.advance()
            # Nothing but the water can carry the load yet.
            np.testing.assert_allclose(run.get("node_pressure").ravel()[corner], 1.0, atol=0.02)

    def test_none_where_nothing_consolidates(self) -> None:
        with qsmpm.Simulation(BLOCK) as run:
            self.assertEqual(run.get("node_pressure").size, 0)


class Views(unittest.TestCase):
    """Arrays of the points."""

    def test_views_follow_and_stay(self) -> None:
        run = qsmpm.Simulation(BLOCK)
        stress = run.points.stress
        self.assertFalse(stress.flags.writeable)
        self.assertEqual(stress.shape, (len(run.points), 4))
        self.assertEqual(float(np.abs(stress).max()), 0.0)
        run.advance()
        self.assertGreater(float(np.abs(stress).max()), 0.0)
        run.checkpoint()
        at = stress.copy()
        run.run()
        self.assertFalse(np.array_equal(stress, at))
        run.restore_checkpoint()
        self.assertTrue(np.array_equal(stress, at))
        self.assertEqual(stress.ctypes.data, run.points.stress.ctypes.data)
        self.assertTrue(np.array_equal(stress, run.get("point_stress")))
        # The memory is there as long as somebody looks at it.
        run.close()
        del run
        gc.collect()
        self.assertTrue(np.array_equal(stress, at))

    def test_sums(self) -> None:
        with qsmpm.Simulation(BLOCK) as run:
            run.run()
            points = run.points
            # 0.8 m high and 1 m wide; small strains of soft ground change the volume by some per mille.
            self.assertAlmostEqual(float(points.initial_volume.sum()), 0.8, places=12)
            self.assertAlmostEqual(float(points.weight.sum()), 0.8 * 18.0, places=10)
            self.assertTrue(np.allclose(points.displacement, points.position - points.initial_position, atol=0))
            self.assertEqual(set(points.material), {1})
            # Weight over base, averaged: half of what the base carries.
            mean = float((points.stress[:, 1] * points.volume).sum() / points.volume.sum())
            self.assertAlmostEqual(mean / (-0.5 * 0.8 * 18.0), 1.0, delta=0.02)

    def test_setting(self) -> None:
        with qsmpm.Simulation(BLOCK) as run:
            wanted = np.tile([-5.0, -10.0, -5.0, 0.0], (len(run.points), 1))
            run.points.stress = wanted
            self.assertTrue(np.array_equal(run.points.stress, wanted))
            with self.assertRaises(ValueError):
                run.points.stress = wanted[1:]
            with self.assertRaises(qsmpm.Error):
                run.points.stress = wanted * np.nan
            run.points.force = np.zeros((len(run.points), 2))
            self.assertEqual(run.points.force.shape, (len(run.points), 2))


class Loads(unittest.TestCase):
    """Stages from results."""

    def test_stop_at_a_displacement(self) -> None:
        with qsmpm.Simulation(PULL) as run:
            run.run()
            load = 1.0
            while run.histories["lift"] < 5e-4:
                load += 1.0
                run.add_stage(f"load {load}", steps=1)
                run.set_traction("top", (0, load))
                run.run()
            # Plane strain: lift = load (1 - nu^2) / E on a height of 1: 5.49 for 5e-4.
            self.assertEqual(load, 6.0)
            self.assertEqual(len(run.names("stage")), 6)

    def test_beyond_the_limit(self) -> None:
        with qsmpm.Simulation(PULL) as run:
            run.run()
            run.checkpoint()
            run.add_stage("too much", steps=2)
            run.set_traction("top", (0, 20))
            with self.assertRaises(qsmpm.NotConvergedError) as caught:
                run.run()
            self.assertIn("too much", str(caught.exception))
            reached = run.load_factor
            self.assertTrue(0.0 <= reached < 1.0)
            run.end_stage()
            run.add_stage("back", steps=1)
            run.set_traction("top", (0, 1))
            run.run()
            self.assertTrue(run.finished)
            run.restore_checkpoint()
            self.assertEqual(run.names("stage"), ["seat"])


class Errors(unittest.TestCase):
    """Statuses as exceptions."""

    def test_deck(self) -> None:
        with self.assertRaises(qsmpm.DeckError) as caught:
            qsmpm.Simulation.from_text("*MODDEL, TYPE=PLANE STRAIN\n", "bad")
        self.assertIn("did you mean", caught.exception.messages)
        with self.assertRaises(qsmpm.DeckError):
            qsmpm.Simulation("no such deck.inp")

    def test_names(self) -> None:
        with qsmpm.Simulation(BLOCK) as run:
            with self.assertRaisesRegex(qsmpm.Error, "did you mean point_stress"):
                run.get("point_stres")
            with self.assertRaisesRegex(qsmpm.Error, "no surface"):
                run.set_traction("roof", (0, 1))
        with self.assertRaisesRegex(qsmpm.Error, "closed"):
            run.advance()
        with self.assertRaisesRegex(qsmpm.Error, "closed"):
            run.histories
        run.close()


class Cards(unittest.TestCase):
    """Materials and phases that are added as cards."""

    GROUT = ("*MATERIAL, NAME=stiff\n*ELASTIC\n5000, 0.3\n*MOHR COULOMB\n2, 30, 0\n*UNIT WEIGHT\n20\n"
             "*PHASE, NAME=grout\n*CHANGE MATERIAL\nblock, stiff\n*END PHASE\n")
    SAFETY = "*PHASE, NAME=factor, TYPE=SAFETY\n*SAFETY, TOLERANCE=0.1\n*END PHASE\n"

    def test_results_of_phases(self) -> None:
        with qsmpm.Simulation(BLOCK) as run:
            run.run()
            run.add_cards(self.GROUT + self.SAFETY)
            self.assertEqual(run.names("material"), ["soil", "stiff"])
            self.assertEqual([r.ended_by for r in run.phase_results], ["whole load", "not ended", "not ended"])
            run.run()
            weight, grout, factor = run.phase_results
            self.assertEqual((weight.name, grout.share, weight.factor_of_safety), ("weight", 1.0, None))
            stable, lost = factor.factor_of_safety
            self.assertTrue(1.0 <= stable < lost <= stable + 0.1)
            self.assertEqual(run.strength_factor, stable)

    def test_faults(self) -> None:
        with qsmpm.Simulation(BLOCK) as run:
            with self.assertRaisesRegex(qsmpm.DeckError, r"added cards:10: \*CHANGE MATERIAL: there is no body 'black'"):
                run.add_cards(self.GROUT.replace("block", "black"))
            self.assertEqual(run.names("stage"), ["weight"])
            self.assertEqual(run.names("material"), ["soil"])


PLATE = """*MODEL, TYPE=PLANE STRAIN
*GRID, ELEMENT=QUAD4
X, 0, 2, 8
Y, 0, 2, 8
*NSET, NSET=base, PLANE=Y
0
*SURFACE, NAME=top, TYPE=SEGMENT
2, 1.1, 0, 1.1
*MATERIAL, NAME=soil
*ELASTIC
1000, 0.3
*BODY, NAME=ground, MATERIAL=soil, SHAPE=BOX
0, 2, 0, 1.1
*METHOD, BASIS=GIMP, INTEGRATION=CELL
*RIGID BODY, NAME=plate, SHAPE=PLANE
0, 1.1, 0, -1
*CONTACT, BODY=plate, SURFACE=top
*HISTORY, NAME=push, QUANTITY=BODY MOVE, COMPONENT=Y, BODY=plate
*HISTORY, NAME=force, QUANTITY=CONTACT FORCE, COMPONENT=Y, BODY=plate
*PHASE, NAME=push
*FIX
base, ALL
*MOVE, BODY=plate
0, -0.01
*CONTROLS, STEPS=2, TOLERANCE=1e-8
*END PHASE
"""


class RigidBodies(unittest.TestCase):
    """A host moves and loads a rigid body by cards, step by step, and reads its place and its force."""

    def test_moved_then_loaded(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            deck = pathlib.Path(folder) / "plate.inp"
            deck.write_text(PLATE)
            with qsmpm.Simulation(deck) as run:
                run.run()
                self.assertAlmostEqual(run.histories["push"], -0.01, 12)
                pushed = run.histories["force"]
                self.assertGreater(pushed, 1.0)
                run.add_cards("*PHASE, NAME=load\n*LOAD, BODY=plate, COMPONENT=Y\n-40\n*CONTROLS, STEPS=2, TOLERANCE=1e-8\n*END PHASE\n")
                forces = [run.histories["force"] for _ in run.steps()]
                self.assertAlmostEqual(forces[0], 0.5 * (pushed + 40), 5)
                self.assertAlmostEqual(forces[1], 40.0, 5)
                self.assertLess(run.histories["push"], -0.01)
                down = run.histories["push"]
                run.add_cards("*PHASE, NAME=lift\n*MOVE, BODY=plate\n0, 0.002\n*CONTROLS, STEPS=1, TOLERANCE=1e-8\n*END PHASE\n")
                run.run()
                self.assertAlmostEqual(run.histories["push"], down + 0.002, 12)
                self.assertLess(run.histories["force"], 40.0)
                with self.assertRaisesRegex(qsmpm.DeckError, r"\*LOAD: there is no rigid body 'plat'"):
                    run.add_cards("*PHASE, NAME=wrong\n*LOAD, BODY=plat, COMPONENT=Y\n-1\n*END PHASE\n")


class Materials(unittest.TestCase):
    """Models in Python."""

    def test_runs_like_the_library(self) -> None:
        model = Hooke()
        with qsmpm.Simulation(BLOCK, materials={"soil": model}) as own, qsmpm.Simulation(BLOCK) as theirs:
            own.run()
            theirs.run()
            # Rates of Cauchy and Kirchhoff stress differ by the volume strain, 1 % here.
            self.assertAlmostEqual(own.histories["settlement"] / theirs.histories["settlement"], 1.0, delta=0.02)
            self.assertLess(float(own.points.state[:, 0].min()), 0.0)
        self.assertLess(model.rotations, 1e-12)

    def test_fails_with_its_words(self) -> None:
        with qsmpm.Simulation(BLOCK, materials={"soil": Hooke(fails=True)}) as run:
            with self.assertRaisesRegex(qsmpm.UserMaterialError, "ValueError: no stress for you"):
                run.run()


if __name__ == "__main__":
    unittest.main()
