"""All steps of a run in one file, read back by VTK: places, fields and numbers of points of every step, from any folder."""

import os
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
from vtkmodules.vtkIOHDF import vtkHDFReader

from qsmpm_verify.places import PROGRAM
from qsmpm_verify.results import read_points, written_steps
from qsmpm_verify.trouble import Trouble
from qsmpm_verify.vtkhdf import write_vtkhdf

# A lift that comes later: steps have different numbers of points.
LIFTS = """*MODEL, TYPE=PLANE STRAIN
*GRID, ELEMENT=QUAD4
X, 0, 1, 2
Y, 0, 2, 4
*NSET, NSET=base, PLANE=Y
0
*MATERIAL, NAME=soil
*ELASTIC
1000, 0.3
*UNIT WEIGHT
20
*BODY, NAME=ground, MATERIAL=soil, SHAPE=BOX
0, 1, 0, 1
*BODY, NAME=lift, MATERIAL=soil, SHAPE=BOX, ACTIVE=NO
0, 1, 1, 2
*PHASE, NAME=weight
*FIX
base, ALL
*GRAVITY
0, -1
*CONTROLS, STEPS=1
*END PHASE
*PHASE, NAME=more
*ACTIVATE
lift
*CONTROLS, STEPS=1
*END PHASE
"""


@unittest.skipUnless(PROGRAM.is_file(), "the program is not built")
class VtkHdf(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name) / "run"

    def test_every_step_is_read_as_it_was_written(self) -> None:
        deck = self.folder.with_name("lifts.inp")
        deck.write_text(LIFTS)
        subprocess.run([PROGRAM, "run", deck, "--out", self.folder, "--quiet"], check=True, capture_output=True, timeout=120)
        write_vtkhdf(self.folder)
        moved = self.folder.with_name("moved")
        shutil.move(self.folder, moved)
        steps = written_steps(moved)
        counts = set()
        here = os.getcwd()
        self.addCleanup(os.chdir, here)
        os.chdir(tempfile.gettempdir())
        reader = vtkHDFReader()
        reader.SetFileName(str(moved / "points.vtkhdf"))
        reader.UpdateInformation()
        times = reader.GetOutputInformation(0).Get(vtkStreamingDemandDrivenPipeline.TIME_STEPS())
        self.assertEqual([int(t) for t in times], steps)
        for step in steps:
            reader.UpdateTimeStep(step)
            shown, written = reader.GetOutput(), read_points(moved, step)
            counts.add(shown.GetNumberOfPoints())
            self.assertEqual(shown.GetNumberOfCells(), len(written.field("position")))
            np.testing.assert_array_equal(vtk_to_numpy(shown.GetPoints().GetData()), written.field("position"))
            for name in ("stress", "displacement", "volume", "material"):
                np.testing.assert_array_equal(vtk_to_numpy(shown.GetPointData().GetArray(name)), written.field(name))
        self.assertGreater(len(counts), 1)

    def test_a_folder_without_states_is_refused(self) -> None:
        self.folder.mkdir()
        with self.assertRaisesRegex(Trouble, "not found"):
            write_vtkhdf(self.folder)


if __name__ == "__main__":
    unittest.main()
