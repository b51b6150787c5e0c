"""The panels of a point test: which are drawn, units of measurements, refusals; and the command of a case."""

import contextlib
import io
import tempfile
import unittest
from pathlib import Path

from qsmpm_verify.cases import CaseError, load_file
from qsmpm_verify.cli import main
from qsmpm_verify.point import factor, panels
from qsmpm_verify.results import ResultError, read_curves

HEAD = "phase,step,yields,axial_strain,lateral_strain,volumetric_strain,shear_strain,p [kPa],q [kPa],s12 [kPa],s22 [kPa]"
TRIAXIAL = HEAD + "\n1,0,0,0,0,0,0,100,0,0,-100\n1,1,1,0.01,-0.004,0.002,0,150,150,0,-250\n"
OEDOMETER = HEAD + "\n1,0,0,0,0,0,0,1,0,0,-1\n1,1,0,0.01,0,0.01,0,6,3,0,-10\n"
SHEAR = HEAD + "\n1,0,0,0,0,0,0,100,0,0,-100\n1,1,1,0,0,0,0.1,100,60,43,-100\n"


def call(*words: str) -> tuple[int, str]:
    """Exit code and all output of the command."""
    text = io.StringIO()
    with contextlib.redirect_stdout(text), contextlib.redirect_stderr(text):
        return main(list(words)), text.getvalue()


class Panels(unittest.TestCase):
    """What is drawn."""

    def setUp(self) -> None:
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))

    def table(self, text: str, name: str = "curves.csv") -> Path:
        path = self.folder / name
        path.write_text(text, encoding="utf-8")
        return path

    def test_the_panels_follow_what_moves(self) -> None:
        for text, first in ((TRIAXIAL, ("axial_strain", "q")), (OEDOMETER, ("axial_stress", "axial_strain")),
                            (SHEAR, ("shear_strain", "s12"))):  # fmt: skip
            panel = panels(read_curves(self.table(text)))[0]
            self.assertEqual((panel.x, panel.y), first)

    def test_units_of_a_measurement_become_those_of_the_result(self) -> None:
        self.assertAlmostEqual(factor("kN/m^2", "MPa", "q"), 1000.0)
        self.assertAlmostEqual(factor("kPa", "kN/m2", "q"), 1.0)
        self.assertAlmostEqual(factor("", "%", "axial_strain"), 0.01)
        with self.assertRaises(ResultError):
            factor("kPa", "%", "q")

    def test_a_picture_is_drawn_over_a_measurement(self) -> None:
        self.table(TRIAXIAL)
        measured = self.table("axial_strain [%],q [MPa]\n0,0\n1,0.14\n", "lab.csv")
        code, text = call("point", str(self.folder), "--against", str(measured))
        self.assertEqual((code, text.strip()), (0, str(self.folder / "point.png")))
        self.assertGreater((self.folder / "point.png").stat().st_size, 1000)

    def test_a_measurement_without_a_pair_is_refused(self) -> None:
        self.table(TRIAXIAL)
        measured = self.table("time [s],q [kPa]\n0,0\n1,2\n", "lab.csv")
        code, text = call("point", str(self.folder), "--against", str(measured))
        self.assertEqual(code, 2)
        self.assertIn("none of the plotted pairs", text)


class Command(unittest.TestCase):
    """The command of a case."""

    def test_the_file_names_it_and_others_are_refused(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "x.toml"
            body = 'title = "t"\ndeck = "d"\ncommand = "{}"\n[[case]]\nname = "a"\n'
            path.write_text(body.format("point"), encoding="utf-8")
            self.assertEqual(load_file(path, Path(folder))[0].command, "point")
            path.write_text(body.format("plan"), encoding="utf-8")
            with self.assertRaises(CaseError):
                load_file(path, Path(folder))
