"""Results as a point cloud of PyVista: places, fields, the step; what is not there is an error that names what is."""
from __future__ import annotations

import pathlib
import tempfile
import unittest

import h5py
import numpy as np

import qsmpm


class Clouds(unittest.TestCase):
    """A state written as the program writes it."""

    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)
        with h5py.File(self.folder / "results.h5", "w") as file:
            for step, count in ((1, 2), (4, 3)):
                group = file.create_group(f"steps/{step:06d}")
                group.attrs["load_factor"] = 0.25 * step
                group["points/position"] = np.arange(3.0 * count).reshape(count, 3)
                group["points/stress"] = np.full((count, 6), -float(step))

    def test_the_last_step_is_shown_or_the_one_asked_for(self) -> None:
        cloud = qsmpm.to_pyvista(self.folder)
        self.assertEqual(cloud.n_points, 3)
        np.testing.assert_array_equal(cloud.points[2], [6.0, 7.0, 8.0])
        np.testing.assert_array_equal(cloud["stress"][0], np.full(6, -4.0))
        self.assertEqual(cloud.field_data["load_factor"][0], 1.0)
        self.assertEqual(qsmpm.to_pyvista(self.folder / "results.h5", step=1).n_points, 2)

    def test_what_is_not_there_is_told(self) -> None:
        with self.assertRaisesRegex(KeyError, "step 2 was not written; 1, 4 were"):
            qsmpm.to_pyvista(self.folder, step=2)
        with self.assertRaises(FileNotFoundError):
            qsmpm.to_pyvista(self.folder / "other.h5")


if __name__ == "__main__":
    unittest.main()
