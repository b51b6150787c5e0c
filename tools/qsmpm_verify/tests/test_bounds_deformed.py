"""Bounds of what has deformed: an outline goes with the material points, and a cut that has sunk carries more."""

import contextlib
import io
import json
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np

from qsmpm_verify.bounds.deformed import broken, displacements, pieces, thinned
from qsmpm_verify.cli import main
from qsmpm_verify.tests.test_bounds import CUT

LOWERED = 0.9


def write_run(folder: Path) -> None:
    """A step whose points have gone down by a tenth of their height, in an h5 file as a run writes it."""
    x, y = np.meshgrid(np.arange(0.1, 6.0, 0.2), np.arange(0.1, 3.0, 0.2))
    inside = (y < 2.0) | (x < 3.0)
    start = np.stack([x[inside], y[inside], np.zeros(inside.sum())], 1)
    now = start * [1.0, LOWERED, 1.0]
    with h5py.File(folder / "results.h5", "w") as file:
        file["mesh/coordinates"] = np.zeros((1, 3))
        group = file.create_group("steps/000001")
        group.attrs["step"], group.attrs["phase"], group.attrs["load_factor"] = 1, 1, 1.0
        group["points/position"], group["points/displacement"], group["points/volume"] = now, now - start, np.full(len(now), 0.04)


class Deformed(unittest.TestCase):
    """Outlines and bounds."""

    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)

    def bracket(self, *words: str) -> tuple[float, float]:
        """Lower and upper bound of the vertical cut."""
        (self.folder / "cut.inp").write_text(CUT)
        with contextlib.redirect_stdout(io.StringIO()) as said:
            code = main(["bounds", str(self.folder / "cut.inp"), "--json", str(self.folder / "bounds.json"), "--triangles", "200", "--passes", "2", *words])
        self.assertEqual(code, 0, said.getvalue())
        found = json.loads((self.folder / "bounds.json").read_text())
        return found["lower"]["value"], found["upper"]["value"]

    def test_a_linear_field_moves_an_outline_exactly(self) -> None:
        start = np.random.default_rng(3).random((60, 2))
        moved = start @ np.array([[0.1, 0.2], [-0.3, 0.05]]) + [0.4, -0.1]
        places = pieces(np.array([0.0, 0.0]), np.array([1.0, 1.0]), 0.3)
        self.assertEqual(len(places), 6)
        exact = places @ np.array([[0.1, 0.2], [-0.3, 0.05]]) + [0.4, -0.1]
        np.testing.assert_allclose(displacements(places, start, moved), exact, atol=1e-12)

    def test_vertices_that_bend_nothing_go(self) -> None:
        line = pieces(np.array([0.0, 0.0]), np.array([1.0, 0.0]), 0.1)
        self.assertEqual(thinned(line, 1e-3).tolist(), [[0.0, 0.0], [1.0, 0.0]])
        line[5, 1] = -0.1
        self.assertIn([0.5, -0.1], thinned(line, 1e-3).tolist())

    def test_an_edge_is_cut_where_another_body_begins(self) -> None:
        square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
        edges = broken(square, np.vstack([square, [[0.4, 1.0], [0.5, 0.5]]]), 1e-9)
        self.assertEqual([[a.tolist(), b.tolist()] for a, b in edges][2:4], [[[1.0, 1.0], [0.4, 1.0]], [[0.4, 1.0], [0.0, 1.0]]])
        self.assertEqual(len(edges), 5)

    def test_a_cut_that_has_sunk_carries_more(self) -> None:
        write_run(self.folder)
        low, high = self.bracket("--run", str(self.folder), "--step", "1")
        # N_s between 3.7776 and 3.7794 (Pastor and others, 2000), the height of the cut a tenth less.
        self.assertLessEqual(low, 3.7776 / LOWERED * 1.0005)
        self.assertGreaterEqual(high, 3.7776 / LOWERED * 0.9995)
        self.assertGreater(low, self.bracket()[1])

    def test_what_cannot_be_moved_is_refused(self) -> None:
        write_run(self.folder)
        for deck, words, told in (
            (CUT, ("--step", "1"), "--run DIR"), (CUT, ("--run", str(self.folder), "--step", "7"), "step 7 not found"),
            (CUT.replace("*GRAVITY", "*RESET DISPLACEMENTS\n*GRAVITY"), ("--run", str(self.folder)), "RESET DISPLACEMENTS"),
        ):
            (self.folder / "cut.inp").write_text(deck)
            with contextlib.redirect_stderr(io.StringIO()) as said:
                self.assertEqual(main(["bounds", str(self.folder / "cut.inp"), *words]), 2)
            self.assertIn(told, said.getvalue())


if __name__ == "__main__":
    unittest.main()
