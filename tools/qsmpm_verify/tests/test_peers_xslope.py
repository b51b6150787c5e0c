"""xslope: what of a deck is given to it, what it said, and the discharge of a dam where it is installed; our bounds beside it."""

import json
import math
import tempfile
import unittest
from pathlib import Path
from unittest import mock

from qsmpm_verify import peers_xslope
from qsmpm_verify.peers_runs import Finished
from qsmpm_verify.places import PEERS, TOP
from qsmpm_verify.study.cards import read_deck
from qsmpm_verify.trouble import RunFailed, Trouble

LAYERS = PEERS / "layers.inp"
DAM = TOP / "verification/cases/decks/water_dam.inp"


def scene(path: Path, phase: str | None, method: str = "bishop", **words: float) -> dict:
    """The scene of a deck of the tree."""
    return json.loads(peers_xslope.scene_text(read_deck(path), phase, method, **words))


class Written(unittest.TestCase):
    def test_layers_have_their_strengths_weights_and_the_level_up_to_the_sides(self) -> None:
        found = scene(LAYERS, "factor")
        names = [found["materials"][ground["material"]]["name"] for ground in found["grounds"]]
        self.assertEqual(names, ["clay", "silt", "sand"])
        silt = next(entry for entry in found["materials"] if entry["name"] == "silt")
        self.assertEqual([round(silt[key], 12) for key in ("c", "phi", "gamma", "gamma_sat")], [5, 24, 18.5, 20])
        self.assertEqual(found["level"], [[0, 8.5], [12, 7.5], [20, 5], [32, 5]])
        self.assertEqual(found["grounds"][2]["outline"], [[0, 7], [16, 7], [10, 10], [0, 10]])

    def test_weights_grow_with_gravity_and_strength_is_lowered_after_davis(self) -> None:
        self.assertEqual(scene(TOP / "verification/cases/decks/slope_safety.inp", "factor")["materials"][0]["gamma"], 15.0)
        fill = scene(TOP / "input/dam_drawdown.inp", "factor drawn")["materials"][0]
        share = math.cos(math.radians(28))  # psi = 0
        self.assertAlmostEqual(fill["c"], 12 * share, 12)
        self.assertAlmostEqual(math.tan(math.radians(fill["phi"])), share * math.tan(math.radians(28)), 12)

    def test_a_dam_in_air_has_levels_at_its_sides_and_may_leak_all_around(self) -> None:
        found = scene(DAM, None, "seepage", size=0.1)
        self.assertEqual(found["exit"], [[0.5, 0.0], [0.5, 1.2], [0.0, 1.2], [0.0, 0.0]])
        heads = {entry["coords"][0][0]: entry["head"] for entry in found["heads"]}
        self.assertEqual(heads, {0.0: 1.0, 0.5: 0.0})
        self.assertEqual((found["materials"][0]["k1"], found["size"], found["grid"]), (1.0, 0.1, True))
        self.assertAlmostEqual(found["materials"][0]["h0"], -1 / 64, 12)

    def test_sides_of_the_grid_are_closed(self) -> None:
        found = scene(TOP / "input/dam_seepage.inp", "impounded", "seepage", size=1.0)
        self.assertEqual(sorted(place[0] for place in found["exit"]), [0, 7, 19, 23, 35, 42])
        lake = [entry["coords"] for entry in found["heads"] if entry["head"] == 7]
        self.assertEqual(sorted(min(a[0], b[0]) for a, b in lake), [0, 7])

    def test_what_is_not_taken_is_an_error(self) -> None:
        for path, phase, method, told in (
            (LAYERS, "factor", "fellenius", "unknown method"), (LAYERS, "factor", "seepage", "requires one body with"),
            (DAM, None, "bishop", "a water level defined by a line"), (PEERS / "consolidation.inp", "load", "bishop", "CONSOLIDATION"),
        ):  # fmt: skip
            self.assertRaisesRegex(Trouble, told, scene, path, phase, method)


class Said(unittest.TestCase):
    def test_brackets_circles_and_warnings(self) -> None:
        self.assertEqual(peers_xslope.said({"factor": 1.15, "lower": 1.1, "upper": 1.2}), "between 1.1000 and 1.2000")
        told = {"factor": 1.0, "circles": 9, "unsolved": 2, "said": ["Bishop could not solve 2", "Tension"]}
        self.assertEqual(peers_xslope.said(told), "2 of 9 circles without a solution; Tension")
        self.assertEqual(peers_xslope.said({"factor": 1.1, "upper": 1.2}), "stable at 1.1000, no equilibrium at 1.2000")
        self.assertEqual(peers_xslope.said({"discharge": 1.0}), "")

    def test_bounds_are_told_with_their_middle(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            (folder / "bounds.json").write_text('{"lower": {"value": 1.5}, "upper": {"value": 2.0}}')
            with mock.patch.object(peers_xslope, "run_peer", return_value=Finished(folder, 1.0)) as run:
                figures, _ = peers_xslope.bounds(LAYERS, folder, {"phase": "factor"})
        self.assertEqual(figures, {"factor": 1.75, "lower": 1.5, "upper": 2.0})
        self.assertEqual(run.call_args.args[0][1:5], ["bounds", "scene.inp", "--phase", "factor"])

    def test_a_flow_that_did_not_converge_is_no_figure(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            (folder / "terminal.txt").write_text('{"discharge": 1.0, "converged": false}\n')
            with mock.patch.object(peers_xslope, "run_peer", return_value=Finished(folder, 1.0)):
                self.assertRaisesRegex(RunFailed, "converge", peers_xslope.solve, DAM, folder, {"method": "seepage", "size": 0.1})


@unittest.skipUnless(peers_xslope.version(), "not installed: xslope")
class Computed(unittest.TestCase):
    def test_discharge_of_an_upright_dam(self) -> None:
        """(h1^2 - h2^2) / (2 L) = 1 (Dupuit, Charny), to half a per cent for what flows in suction."""
        with tempfile.TemporaryDirectory() as folder:
            figures, _ = peers_xslope.solve(DAM, Path(folder) / "run", {"method": "seepage", "size": 0.0625})
        self.assertAlmostEqual(figures["discharge"], 1.0, delta=6e-3)


if __name__ == "__main__":
    unittest.main()
