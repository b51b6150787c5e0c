"""Files for ParaView: VTK reads them, and the script asks ParaView for files and fields that are there."""

import contextlib
import io
import sys
import tempfile
import types
import unittest
from pathlib import Path
from unittest import mock

import h5py
import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader

from qsmpm_verify.cli import main
from qsmpm_verify.paraview import BODY, PRESSURE, WATER, Pieces, add_body, colour_of, pieces_of
from qsmpm_verify.results import Points, ResultError, read_points
from qsmpm_verify.surroundings import RigidBody, Surroundings
from qsmpm_verify.tests.test_view import write_state, write_surroundings


class Shown(mock.MagicMock):
    """Whatever ParaView gives back."""


class ForParaView(unittest.TestCase):
    """A small run with a wall, pressures and water."""

    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        write_state(self.folder, (0, 5))
        write_surroundings(self.folder)
        lines = "".join(f'<DataSet timestep="{t}" group="" part="0" file="points_{s:06d}.vtu"/>\n' for t, s in ((0, 0), (0.5, 5)))
        (self.folder / "points.pvd").write_text(f"<Collection>\n{lines}</Collection>\n")

    def call(self, *words: str) -> tuple[int, str]:
        said = io.StringIO()
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            code = main(["paraview", str(self.folder), *words])
        return code, said.getvalue()

    def test_vtk_reads_what_stands_beside_the_points(self) -> None:
        self.assertEqual(self.call()[0], 0)
        reader = vtkXMLPolyDataReader()
        reader.SetFileName(str(self.folder / "around_000005.vtp"))
        reader.Update()
        data = reader.GetOutput()
        kinds = vtk_to_numpy(data.GetCellData().GetArray("kind")).tolist()
        self.assertEqual(kinds, [WATER, BODY, BODY, PRESSURE, PRESSURE])
        self.assertEqual(vtk_to_numpy(data.GetCellData().GetArray("contact_pressure")).tolist(), [0, 0, 0, 60, 20])
        np.testing.assert_allclose(vtk_to_numpy(data.GetCellData().GetArray("contact_slip")), [0, 0, 0, 0.05, 0.01])
        self.assertEqual((data.GetNumberOfLines(), data.GetNumberOfPolys()), (1, 4))
        wall = data.GetCell(1).GetBounds()
        np.testing.assert_allclose(wall[:4], [0.2, 0.5, -2, 3])
        self.assertLess(wall[5], 0.0)
        # The larger bar is a tenth of the soil long.
        np.testing.assert_allclose(np.diff(data.GetCell(3).GetBounds()[:2]), 0.1 * np.ptp(read_points(self.folder).field("position")[:, 0]))
        collection = (self.folder / "around.pvd").read_text()
        self.assertIn('timestep="0.5" group="" part="0" file="around_000005.vtp"', collection)

    def test_the_script_opens_files_that_are_there_by_a_field_that_is_there(self) -> None:
        self.assertEqual(self.call("--field", "stress_xz")[0], 0)
        simple = types.ModuleType("paraview.simple")
        calls: dict[str, mock.Mock] = {}
        for name in ("GetActiveViewOrCreate", "PVDReader", "Show", "ColorBy", "GetAnimationScene", "ResetCamera", "Render"):
            calls[name] = Shown()
            setattr(simple, name, calls[name])
        package = types.ModuleType("paraview")
        with mock.patch.dict(sys.modules, {"paraview": package, "paraview.simple": simple}):
            exec(compile((self.folder / "view.py").read_text(), "view.py", "exec"), {})
        opened = [Path(call.kwargs["FileName"]) for call in calls["PVDReader"].call_args_list]
        self.assertEqual([path.name for path in opened], ["points.pvd", "around.pvd"])
        self.assertTrue(all(path.is_file() for path in opened))
        self.assertEqual(calls["ColorBy"].call_args_list[0].args[1], ("CELLS", "stress", "XZ"))
        self.assertEqual(calls["GetActiveViewOrCreate"].return_value.InteractionMode, "2D")

    def test_fields_are_named_as_paraview_does(self) -> None:
        points = read_points(self.folder)
        for name, wanted in (("displacement", ("displacement", "Magnitude")), ("displacement_y", ("displacement", "Y")), ("volume", ("volume",))):
            self.assertEqual(colour_of(points, name), ("CELLS", *wanted))
        for wrong in ("heat", "volume_x", "displacement_xx"):
            with self.assertRaisesRegex(ResultError, "no field"):
                colour_of(points, wrong)

    def test_balls_planes_and_water_have_faces_in_space(self) -> None:
        places = np.array([[0, 0, 0], [2, 2, 2.0]])
        water = np.array([[0, 1, 0], [1, 1, 0], [2, 1.5, 0]])
        around = Surroundings((RigidBody(ball=np.array([1, 3, 1, 0.5])),), {}, (water,))
        found = pieces_of(Points(Path("r"), 1, 1, 1.0, {"position": places}, around=around), 0.0)
        kinds = [cell.kind for cell in found.faces]
        self.assertEqual((kinds.count(BODY), kinds.count(WATER), found.lines), (288, 2, []))
        ball = np.concatenate(found.places[:288])
        np.testing.assert_allclose(np.linalg.norm(ball - [1, 3, 1], axis=1), 0.5)
        square = Pieces()
        plane = np.array([[1.0, 2, 3], [0, 0.6, 0.8]])
        add_body(square, RigidBody(plane=plane), False, 2.0)
        np.testing.assert_allclose((square.places[0] - plane[0]) @ plane[1], 0, atol=1e-12)
        np.testing.assert_allclose(np.linalg.norm(square.places[0] - plane[0], axis=1), 2.0)

    def test_what_is_missing_is_told(self) -> None:
        (self.folder / "points.pvd").unlink()
        code, said = self.call()
        self.assertEqual(code, 2)
        self.assertIn("VTK=YES", said)
        with h5py.File(self.folder / "results.h5", "a") as file:
            del file["steps/000005"]
        (self.folder / "points.pvd").write_text('<DataSet timestep="1" group="" part="0" file="points_000007.vtu"/>')
        self.assertIn("no step is both", self.call()[1])


if __name__ == "__main__":
    unittest.main()
