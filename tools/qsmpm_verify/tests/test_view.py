"""Fields of points, and pictures and films of a small state written as the program writes it."""

import contextlib
import io
import json
import math
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import h5py
import numpy as np
from matplotlib.collections import PolyCollection
from PIL import Image

from qsmpm_verify.bodies import frame_of
from qsmpm_verify.cli import main
from qsmpm_verify.fields import mises, scalar_field, unit_of
from qsmpm_verify.plane_picture import plane_picture
from qsmpm_verify.results import Points, ResultError, read_mesh, read_points, written_steps


def write_state(folder: Path, steps: tuple[int, ...]) -> None:
    """A block of 4 x 2 points on 2 x 1 cells that moves to the right by 0.1 a step."""
    x, y = np.meshgrid(np.arange(4) + 0.5, np.arange(2) + 0.5)
    start = np.stack([x.ravel(), y.ravel(), np.zeros(8)], axis=1) / 2
    with h5py.File(folder / "results.h5", "w") as file:
        mesh = file.create_group("mesh")
        mesh["coordinates"] = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [1, 1, 0], [2, 1, 0.0]]
        mesh["cell_offsets"], mesh["cell_types"] = [0, 4, 8], [9, 9]
        mesh["cell_nodes"] = [0, 1, 4, 3, 1, 2, 5, 4]
        for step in steps:
            group = file.create_group(f"steps/{step:06d}")
            group.attrs.update({"step": step, "phase": 1, "load_factor": float(step)})
            moved = np.tile([0.1 * step, 0.0, 0.0], (8, 1))
            stress = np.zeros((8, 6))
            stress[:, 0] = step * np.arange(8)
            points = group.create_group("points")
            points["position"], points["displacement"], points["stress"] = start + moved, moved, stress
            points["volume"] = points["initial_volume"] = np.full(8, 0.25)
            points["plastic"] = np.arange(8) % 2
            points["material"] = np.ones(8, dtype=int)
    (folder / "block.echo.inp").write_text('*UNITS, LENGTH=m, FORCE=kN\n*MATERIAL, NAME="soft clay"\n')


def write_surroundings(folder: Path) -> None:
    """Step 5 has a wall at its left, pressed by 20 and 60 kN/m2 on two halves of the soil's height, and water over it."""
    with h5py.File(folder / "results.h5", "a") as file:
        step = file["steps/000005"]
        step["rigid_bodies/000001/outline"] = [[0.5, -2.0, 0], [0.5, 3.0, 0], [0.2, 3.0, 0], [0.2, -2.0, 0]]
        step["rigid_bodies/000002/outline"], step["rigid_bodies/000002/plane"] = [[9, 0, 0], [-9, 0, 0]], [[0, 0, 0], [0, 1, 0]]
        step["contacts/position"], step["contacts/normal"] = [[0.5, 0.25, 0], [0.5, 0.75, 0]], [[-1, 0, 0], [-1, 0, 0]]
        step["contacts/extent"], step["contacts/pressure"] = [0.5, 0.5], [60.0, 20.0]
        step["contacts/slip"] = [[0, 0.03, 0.04], [0, -0.01, 0]]
        step["water/000001"] = [[0.0, 0.8, 0], [2.0, 1.4, 0]]


def write_safety(folder: Path) -> None:
    """Step 5 is the last one of a safety phase, which has a mechanism, and the phases have names."""
    with h5py.File(folder / "results.h5", "a") as file:
        file["steps/000005"].attrs["phase"] = 2
        file.copy("steps/000005", "mechanisms/000002")
        file["mechanisms/000002/points/displacement"][...] = np.outer(np.arange(8), [1e-3, 0.0, 0.0])
    phases = [{"name": "built"}, {"name": "weaker", "factor": [1.25, 1.26]}]
    (folder / "summary.json").write_text(json.dumps({"phases": phases}))


class Fields(unittest.TestCase):
    """One value a point."""

    def test_fields_are_what_their_names_say(self) -> None:
        stress = np.array([[-3.0, -2.0, -1.0, 0.5, 0.6, 0.7]])
        move = np.array([[3.0, 4.0, 0.0]])
        points = Points(
            Path("r"),
            1,
            1,
            1.0,
            {
                "stress": stress,
                "strain": 0.1 * stress,
                "shear_strain": np.array([0.3]),
                "displacement": move,
                "plastic": np.array([1]),
                "volume": np.array([0.5]),
                "initial_volume": np.array([1.0]),
            },
        )
        for name, value in (
            ("displacement", 5.0),
            ("displacement_y", 4.0),
            ("pressure", 2.0),
            ("stress_xy", 0.5),
            ("stress_yz", 0.7),
            ("plastic", 1.0),
            ("volume_ratio", 0.5),
            ("strain_yy", -0.2),
            ("shear_strain", 0.3),
        ):
            self.assertAlmostEqual(scalar_field(points, name)[0], value, msg=name)
        self.assertAlmostEqual(mises(np.array([[1.0, 0, 0, 0, 0, 0]]))[0], 1.0)
        self.assertAlmostEqual(mises(np.array([[0, 0, 0, 1.0, 0, 0]]))[0], math.sqrt(3))
        for wrong in ("stress_ab", "displacement_", "colour"):
            with self.assertRaisesRegex(ResultError, "no field"):
                scalar_field(points, wrong)


class View(unittest.TestCase):
    """The verb from the command line."""

    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        write_state(self.folder, (0, 2, 5))

    def call(self, *words: str) -> tuple[int, str]:
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = main(["view", str(self.folder), *words])
        return code, out.getvalue() + err.getvalue()

    def test_steps_mesh_and_units_are_read(self) -> None:
        self.assertEqual(written_steps(self.folder), [0, 2, 5])
        self.assertEqual([list(c) for c in read_mesh(self.folder).cells], [[0, 1, 4, 3], [1, 2, 5, 4]])
        self.assertEqual((unit_of(self.folder, "stress_xx"), unit_of(self.folder, "plastic")), ("kN/m2", ""))

    def test_a_picture_shows_the_field_the_outline_and_the_body_where_it_is(self) -> None:
        out = self.folder / "p.png"
        self.assertEqual(self.call("--field", "plastic", "--mesh", "--out", str(out)), (0, f"{out}\n"))
        image = np.asarray(Image.open(out).convert("RGB")).astype(int)
        red, green, blue = image[..., 0], image[..., 1], image[..., 2]
        yellow = (red > 240) & (green > 220) & (blue < 60)
        purple = (red < 80) & (green < 20) & (blue > 70)
        # four points of each colour; the bar at the right has both colours too
        self.assertGreater(yellow[:, :-200].sum(), 4 * 2000)
        self.assertGreater(purple[:, :-200].sum(), 4 * 2000)
        self.assertEqual(self.call("--field", "plastic", "--mesh", "--no-outline", "--out", str(self.folder / "q.png"))[0], 0)
        bare = np.asarray(Image.open(self.folder / "q.png").convert("RGB")).astype(int)
        self.assertGreater(int((np.abs(image - bare).max(axis=2) > 60).sum()), 700)

    def test_bodies_pressures_and_water_are_drawn_where_they_are(self) -> None:
        write_surroundings(self.folder)
        around = read_points(self.folder, 5).around
        self.assertEqual((len(around.bodies), around.pressure, len(around.water)), (2, 60.0, 1))
        np.testing.assert_allclose(around.bars(0.01), [
            [[0.5, 0.5], [0.5, 0.0], [-0.1, 0.0], [-0.1, 0.5]], [[0.5, 1.0], [0.5, 0.5], [0.3, 0.5], [0.3, 1.0]]])
        # Of a plane what is behind it, away from its normal.
        self.assertEqual(np.ptp(around.bodies[1].area(3.0), axis=0).tolist(), [18.0, 3.0])
        self.assertEqual(around.bodies[1].area(3.0)[:, 1].max(), 0.0)
        self.assertEqual(read_points(self.folder, 2).around.pressure, 0.0)
        with mock.patch("qsmpm_verify.plane_picture.PolyCollection", wraps=PolyCollection) as drawn:
            self.assertEqual(self.call("--out", str(self.folder / "p.png"))[0], 0)
        bodies, bars = drawn.call_args_list
        self.assertEqual((len(bodies.args[0]), bars.kwargs["label"]), (2, "contact pressure, largest 60 kN/m2"))
        # The view holds the bars, and a part of the bodies that go on far beyond it.
        frame = frame_of([read_points(self.folder, 5)], [np.zeros(8)], "plastic", "")
        self.assertLess(frame.low[0], bars.args[0][0][:, 0].min())
        self.assertGreater(frame.low[1], -1.0)
        self.assertGreater(frame.high[1], 1.4)

    def test_tensors_have_a_mean_and_components_and_units(self) -> None:
        with h5py.File(self.folder / "results.h5", "a") as file:
            points = file["steps/000005/points"]
            points["total_stress"] = points["stress"][...] - 30.0 * np.array([1, 1, 1, 0, 0, 0])
            points["strain"], points["load"] = np.zeros((8, 6)), np.tile([3.0, 4.0, 0.0], (8, 1))
        state = read_points(self.folder, 5)
        np.testing.assert_allclose(scalar_field(state, "total_stress"), 30 - 5 / 3 * np.arange(8))
        np.testing.assert_allclose(scalar_field(state, "total_stress_xx"), 5 * np.arange(8) - 30)
        self.assertEqual(set(scalar_field(state, "load")), {5.0})
        with self.assertRaisesRegex(ResultError, "strain has components: use strain_xx"):
            scalar_field(state, "strain")
        for name, unit in (("total_stress", "kN/m2"), ("pore_pressure", "kN/m2"), ("load_y", "kN"), ("strain_xx", "")):
            self.assertEqual(unit_of(self.folder, name), unit, name)
        (self.folder / "block.echo.inp").write_text("*UNITS, LENGTH=-, FORCE=-\n")
        self.assertEqual((unit_of(self.folder, "stress"), unit_of(self.folder, "displacement")), ("", ""))
        self.assertEqual(self.call("--field", "total_stress", "--out", str(self.folder / "p.png"))[0], 0)

    def test_a_film_has_a_picture_a_step_in_the_same_colours(self) -> None:
        out = self.folder / "f.gif"
        self.assertEqual(self.call("--field", "stress_xx", "--film", "--out", str(out))[0], 0)
        with Image.open(out) as film:
            self.assertEqual(film.n_frames, 3)
        code, said = self.call("--field", "stress_xx", "--film", "--out", str(self.folder / "s.png"))
        self.assertEqual((code, len(list(self.folder.glob("s_*.png")))), (0, 3))
        self.assertIn("s_0000.png to s_0002.png", said)

    def test_the_way_a_body_fails_is_drawn_as_a_share_with_its_factor(self) -> None:
        write_safety(self.folder)
        out = self.folder / "m.png"
        with mock.patch("qsmpm_verify.view.plane_picture", wraps=plane_picture) as drawn:
            self.assertEqual(self.call("--mechanism", "--out", str(out))[0], 0)
        body, frame, caption = drawn.call_args.args[:3]
        self.assertEqual(caption, "block: phase 'weaker', failure mechanism, factor of safety 1.25 to 1.26")
        np.testing.assert_allclose(body.values, np.arange(8) / 7)
        self.assertEqual((frame.title, frame.most, frame.length), ("displacement / largest value", 1.0, "m"))
        self.assertEqual(self.call("--mechanism", "--phase", "weaker", "--out", str(out))[0], 0)
        for words, text in ((("--phase", "built"), "no mechanism of phase built; available are: 'weaker'"),
                            (("--film",), "cannot be combined with --film or --step"), (("--phase", "built up"), "no phase 'built up'")):
            code, said = self.call("--mechanism", *words)
            self.assertEqual(code, 2, words)
            self.assertIn(text, said)

    def test_without_a_safety_phase_there_is_no_mechanism(self) -> None:
        code, said = self.call("--mechanism")
        self.assertEqual(code, 2)
        self.assertIn("no mechanism of any phase; available are: none", said)

    def test_a_phase_is_named_by_name_or_number_and_told_in_the_title(self) -> None:
        write_safety(self.folder)
        for phase, step, name in (("built", 2, "'built', step 2, load factor 2"), ("1", 2, "'built'"),
                                  ("weaker", 5, "'weaker', step 5, load factor 5, factor of safety 1.25 to 1.26")):
            with mock.patch("qsmpm_verify.view.plane_picture", wraps=plane_picture) as drawn:
                self.assertEqual(self.call("--phase", phase, "--out", str(self.folder / "p.png"))[0], 0)
            self.assertIn(f"phase {name}", drawn.call_args.args[2])
        self.assertIn("no step of phase 3 has been written", self.call("--phase", "3")[1])

    def test_materials_are_named_and_one_class_alone_has_its_bar(self) -> None:
        with mock.patch("matplotlib.colorbar.Colorbar.set_ticks") as ticks:
            self.assertEqual(self.call("--field", "material", "--out", str(self.folder / "c.png"))[0], 0)
        self.assertEqual((ticks.call_args.args, ticks.call_args.kwargs), (([1],), {"labels": ["soft clay"]}))

    def test_a_picture_for_paraview_is_refused(self) -> None:
        for name in ("points_000005.vtu", "points.pvd"):
            out, err = io.StringIO(), io.StringIO()
            with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
                self.assertEqual(main(["view", str(self.folder / name)]), 2)
            self.assertIn("open this file in ParaView", err.getvalue())

    def test_what_is_not_there_is_told_with_code_2(self) -> None:
        for words, text in (
            (("--step", "3"), "step 3 have not been written; available are 0, 2, 5"),
            (("--field", "heat"), "no field 'heat'; available are displacement"),
            (("--out", "a.jpg"), "a figure must be a .png file"),
            (("--range", "2", "1"), "lower value first"),
        ):
            code, said = self.call("--out", str(self.folder / "n.png"), *words)
            self.assertEqual(code, 2, words)
            self.assertIn(text, said)
        (self.folder / "results.h5").write_bytes(b"cut")
        self.assertEqual(self.call()[0], 2)


if __name__ == "__main__":
    unittest.main()
