"""Skins of bodies in space: closed, on the boundary, apart for bodies that are apart; pictures are filled by them."""

import contextlib
import io
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import h5py
import numpy as np

from qsmpm_verify import stage
from qsmpm_verify.cli import main
from qsmpm_verify.solid_skin import Skin, skin_of, skins_of


def lattice(nx: int, ny: int, nz: int, spacing: float = 0.5) -> np.ndarray:
    """Points in the middle of the cells of a box from the origin on."""
    axes = [(np.arange(n) + 0.5) * spacing for n in (nx, ny, nz)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


def volume(skin: Skin) -> float:
    """What a skin holds, positive where its faces look outwards."""
    a, b, c = (skin.places[skin.faces[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->i", np.cross(a, b), c).sum() / 6)


class Skins(unittest.TestCase):
    """Of a box, of two, and of one that was torn."""

    def test_a_box_has_its_whole_volume(self) -> None:
        points = lattice(6, 4, 5)
        skin = skin_of(points, points, np.arange(len(points)))
        assert skin is not None
        self.assertAlmostEqual(volume(skin), 3.0 * 2.0 * 2.5, delta=0.01 * 15)
        np.testing.assert_allclose(skin.places.max(axis=0), [3.0, 2.0, 2.5], atol=0.01)
        # Every edge belongs to two faces: the skin has no hole.
        edges = np.sort(np.concatenate([skin.faces[:, [0, 1]], skin.faces[:, [1, 2]], skin.faces[:, [2, 0]]]), axis=1)
        self.assertEqual(set(np.unique(edges, axis=0, return_counts=True)[1].tolist()), {2})
        self.assertEqual(len(skin.inside), len(points))

    def test_a_gap_stays_open_and_what_is_torn_is_no_part(self) -> None:
        two = np.concatenate([lattice(4, 4, 4), lattice(4, 4, 4) + [4.0, 0, 0]])
        skin = skin_of(two, two, np.arange(len(two)))
        assert skin is not None
        self.assertAlmostEqual(volume(skin), 16.0, delta=0.2)
        one = lattice(8, 4, 4)
        moved = one + np.where(one[:, :1] > 2.0, [[5.0, 0, 0]], [[0.0, 0, 0]])
        torn = skin_of(one, moved, np.arange(len(one)))
        assert torn is not None
        self.assertAlmostEqual(volume(torn), 16.0, delta=0.3)

    def test_materials_are_apart_and_a_few_points_have_no_skin(self) -> None:
        points = lattice(6, 4, 4)
        self.assertEqual(len(skins_of(points, points, points[:, 0] > 1.5)), 2)
        self.assertIsNone(skin_of(points, points, np.arange(4)))
        self.assertIsNone(skin_of(points, points, np.flatnonzero(points[:, 2] < 0.3)))

    def test_a_picture_is_filled(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            folder, points = Path(name), lattice(4, 3, 3)
            with h5py.File(folder / "results.h5", "w") as file:
                file["mesh/coordinates"] = np.zeros((4, 3))
                group = file.create_group("steps/000001")
                group.attrs.update({"step": 1, "phase": 1, "load_factor": 1.0})
                group["points/position"], group["points/displacement"] = points, np.zeros_like(points)
                group["points/volume"] = group["points/initial_volume"] = np.full(len(points), 0.125)
                group["rigid_bodies/000001/ball"] = [1.0, 2.0, 0.7, 0.5]
            with mock.patch.object(stage, "cloud", wraps=stage.cloud) as dots, mock.patch.object(stage, "beside", wraps=stage.beside) as bodies:
                with contextlib.redirect_stdout(io.StringIO()):
                    self.assertEqual(main(["view", name, "--field", "volume", "--out", str(folder / "p.png")]), 0)
            self.assertEqual((dots.call_count, bodies.call_count), (0, 1))


if __name__ == "__main__":
    unittest.main()
