"""Diagrams of the pressure on walls and bodies: the table, the order along the surface, the theory beside it."""

import contextlib
import csv
import io
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np

from qsmpm_verify.cli import main
from qsmpm_verify.surroundings import RigidBody, Surroundings, chain


def write_run(folder: Path) -> None:
    """A wall of 2 m with four points in contact, out of order, a fifth apart; pressures of 10 z and one that is 2 too high."""
    with h5py.File(folder / "results.h5", "w") as file:
        file["mesh/coordinates"] = np.zeros((4, 3))
        step = file.create_group("steps/000001")
        step.attrs.update(step=1, phase=1, load_factor=1.0)
        for name in ("position", "initial_position", "displacement"):
            step[f"points/{name}"] = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
        step["points/volume"] = np.ones(3)
        heights = np.array([0.25, 1.75, 1.25, 0.75, 1.0])
        step["contacts/position"] = np.stack([0 * heights, heights, 0 * heights], axis=1)
        step["contacts/normal"] = np.tile([-1.0, 0, 0], (5, 1))
        step["contacts/extent"] = np.full(5, 0.5)
        step["contacts/pressure"] = np.array([17.5, 2.5, 9.5, 12.5, 0.0])
        step["contacts/body"] = np.ones(5, dtype=int)
    (folder / "curves.csv").write_text("phase,step,load_factor\n1,1,1\n")
    (folder / "theory.csv").write_text("depth [m],pressure [kPa]\n0,0\n2,20\n")


class Pressures(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        write_run(self.folder)

    def told(self, *words: str) -> str:
        output = io.StringIO()
        with contextlib.redirect_stdout(output):
            self.assertEqual(main(["pressures", str(self.folder), "--out", str(self.folder / "p.png"), *words]), 0)
        self.assertTrue((self.folder / "p.png").stat().st_size > 1000)
        return output.getvalue()

    def test_a_table_and_a_function_are_the_same_theory(self) -> None:
        for theory in (str(self.folder / "theory.csv"),
                       "function:rankine_passive(depth=depth, unit_weight=10, cohesion=0, friction=0)"):
            told = self.told("--against", theory, "--csv", str(self.folder / "p.csv"))
            self.assertIn("force      21", told)
            self.assertIn("theory     20 , computed +5.000%", told)
            self.assertIn("difference rms 1, largest 2", told)
        with (self.folder / "p.csv").open() as file:
            rows = list(csv.DictReader(file))
        self.assertEqual([float(row["depth []"]) for row in rows], [1.75, 1.25, 0.75, 0.25])
        self.assertEqual([float(row["s []"]) for row in rows], [0.25, 0.75, 1.25, 1.75])

    def test_a_top_moves_the_depths(self) -> None:
        told = self.told("--top", "2.2", "--against", "function:rankine_passive(depth=depth, unit_weight=10, cohesion=0, friction=0)")
        self.assertIn("theory     24 ", told)

    def test_a_step_without_contacts_is_refused(self) -> None:
        with h5py.File(self.folder / "results.h5", "a") as file:
            del file["steps/000001/contacts"]
        with contextlib.redirect_stderr(io.StringIO()) as told:
            self.assertEqual(main(["pressures", str(self.folder)]), 2)
        self.assertIn("no contacts", told.getvalue())


class Bars(unittest.TestCase):
    def test_bars_longer_than_the_radius_of_a_corner_do_not_cross(self) -> None:
        # a quarter of a circle of 0.1 between straight sides, bars of 0.5 towards its centre
        angles = np.radians(np.linspace(0, 90, 19))
        arc = 0.1 * np.stack([np.sin(angles), 1 - np.cos(angles)], axis=1)
        flat = np.stack([np.linspace(-0.9, -0.01, 60), np.zeros(60)], axis=1)
        wall = np.stack([np.full(60, 0.1), np.linspace(0.11, 1.0, 60)], axis=1)
        place = np.concatenate([flat, arc, wall])
        out = np.concatenate([np.tile([0.0, 1], (60, 1)), np.stack([-np.sin(angles), np.cos(angles)], axis=1),
                              np.tile([-1.0, 0], (60, 1))])
        extent = np.concatenate([np.full(60, 0.015), np.full(19, 0.1 * np.pi / 38), np.full(60, 0.015)])
        mixed = np.random.default_rng(1).permutation(len(place))
        contacts = {"position": place[mixed], "normal": out[mixed], "extent": extent[mixed], "pressure": np.ones(len(place))}
        bars = Surroundings(contacts=contacts).bars(0.3)[np.argsort(mixed)]
        x, y = bars[..., 0], bars[..., 1]
        areas = 0.5 * np.sum(x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1), axis=1)
        self.assertTrue(np.all(areas > 0) or np.all(areas < 0))
        self.assertEqual(chain(place).tolist(), list(range(len(place))))

    def test_bars_of_a_flat_foot_stand_upright_where_soil_leans_round_its_corner(self) -> None:
        # a foot 2 wide and 1 high, its corners of radius 0.03; soil in reach of the corner has turned by up to 40 degrees
        angles = np.radians(np.linspace(0, 90, 8))
        round_off = 0.03 * np.stack([np.sin(angles), 1 - np.cos(angles)], axis=1) + [0.97, 0.0]
        foot = np.concatenate([round_off, [[1.0, 1.0], [-1.0, 1.0]], round_off[::-1] * [-1, 1]])
        lean = np.radians([0, 0, 0, 0, 0, 0, 2, -3, 12, 40])
        place = np.stack([np.linspace(0.55, 1.0, 10), [*[0.0] * 9, 0.02]], axis=1)
        contacts = {"position": place, "normal": np.stack([-np.sin(lean), np.cos(lean)], axis=1), "extent": np.full(10, 0.05),
                    "pressure": np.linspace(1, 2, 10), "body": np.ones(10, dtype=int)}
        turn = np.array([[0.8, -0.6], [0.6, 0.8]])
        for by in (np.eye(2), turn):
            turned = contacts | {"position": place @ by.T, "normal": contacts["normal"] @ by.T}
            bars = Surroundings((RigidBody((foot if by is turn else foot[::-1]) @ by.T),), turned).bars(0.3)
            ways = 0.5 * (bars[:, 2] + bars[:, 3] - bars[:, 0] - bars[:, 1])
            np.testing.assert_allclose(ways, 0.3 * contacts["pressure"][:, None] * by[:, 1], atol=1e-12)
        # Feet stay on the soil, and a body with no flat side beside the soil leaves its normals.
        np.testing.assert_allclose(bars[-1, 1] - bars[-1, 0], 0.05 * turn @ [-np.cos(lean[-1]), -np.sin(lean[-1])], atol=1e-12)
        for body in (RigidBody(foot + [0.0, 0.2]), RigidBody(10 * round_off / 0.03 * 0.01)):
            fan = Surroundings((body,), contacts).bars(0.3)
            self.assertGreater(float(np.abs(fan[-1, 3] - fan[-1, 0])[0]), 0.1)


if __name__ == "__main__":
    unittest.main()
