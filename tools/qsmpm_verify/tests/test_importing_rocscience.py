"""Models of Slide2 and RS2 as decks: text of their layout that the tests write, what is taken, asked for, left and refused."""

import contextlib
import io
import re
import tempfile
import unittest
import zipfile
from pathlib import Path

from shapely.geometry import Polygon

from qsmpm_verify.cli import main
from qsmpm_verify.importing.rs2 import read_rs2
from qsmpm_verify.importing.section import Section, area_of
from qsmpm_verify.importing.slide import read_slide
from qsmpm_verify.trouble import Trouble

# The slope of verification/week/decks/seam.inp; its three soils cut into cells, the top one in two.
CELLS = {
    1: [[(0, 12), (10, 11), (10, 20), (0, 20)], [(10, 11), (30, 9), (44, 9), (44, 10), (30, 10), (10, 20)]],
    2: [[(0, 11), (30, 8), (44, 8), (44, 9), (30, 9), (10, 11), (0, 12)]],
    3: [[(0, 0), (44, 0), (44, 8), (30, 8), (0, 11)]],
}
WATER = [(0, 15), (20, 12), (44, 10)]
SOILS = {1: ("top, dense", "type: 0 c: 9 phi: 29 uw: 19 uwbwt: 20"), 2: ("seam", "type: 0 c: 2 phi: 11 uw: 19"), 3: ("rock", "type: 0 c: 40 phi: 36 uw: 21")}


def slide_text(units: str = "metric", third: str = SOILS[3][1], more: str = "") -> str:
    """A model of Slide2."""
    corners = sorted({corner for cells in CELLS.values() for cell in cells for corner in cell} | set(WATER))
    place = {corner: i for i, corner in enumerate(corners, start=1)}
    rows = [(soil, cell) for soil, cells in CELLS.items() for cell in cells]
    words = {**{k: v[1] for k, v in SOILS.items()}, 3: third}
    return "\n".join([
        "model description:", "  version: 9.027", f"  units: {units}", "  water: hu", "  gammaw: 9.81", "  seismic: 0.1", "",
        "material types:", *(f"  soil{k} = {text} water: 1 wtable: 1," for k, text in words.items()), "",
        "anchor types:", "", "vertices:", *(f"  {i} x: {x} y: {y}" for (x, y), i in place.items()), "",
        "cells:", *(f"  {i} vertices: [{','.join(str(place[c]) for c in cell)}] material: soil{soil}" for i, (soil, cell) in enumerate(rows, start=1)), "",
        "anchors:", "  1 x1: 1 y1: 2 x2: 3 y2: 4 type: anchor1", "", "water table:", f"  vertices: [{','.join(str(place[c]) for c in WATER)}]", "",
        "material properties:", *(f"  {name} red: 1 green: 2 blue: 3 hatch: 0" for name, _ in SOILS.values()), "  wall red: 1 green: 2 blue: 3", more, "",
    ])  # fmt: skip


def points(corners: list[tuple[float, float]]) -> list[str]:
    """An array of points of RS2."""
    return ["vertices start:", "dpoint array start:", f"num points: {len(corners)}", *(f"{i}: {x}, {y}" for i, (x, y) in enumerate(corners)),
            "dpoint array end:", "vertices end:"]  # fmt: skip


def rs2_text(units: str = "Metric kPa", model: str = "MohrCoulomb", mode: int = 3, ru: float = 0.0, seeds: int = 3) -> str:
    """A model of RS2."""
    lines = [("external", [(0, 0), (44, 0), (44, 10), (30, 10), (10, 20), (0, 20)]), ("material", [(0, 12), (30, 9), (44, 9)]),
             ("material", [(0, 11), (30, 8), (44, 8)]), ("pile_geotextile", [(1, 1), (2, 2)])]  # fmt: skip
    inside = {1: (5, 15), 2: (15, 10), 3: (15, 4)}
    soils = {1: ("top, dense", 9, 29, 19), 2: ("seam", 2, 11, 19), 3: ("rock", 40, 36, 21)}
    return "\n".join([
        "model description:", "version:", "11.028", f'RFCunits: "{units}"', "seismic: 0 0 1 1 1", "",
        "material types:", *(row for i, (name, c, phi, _) in soils.items() for row in (
            f"material {i}: {name}", "Elastic Properties: LinearElastic", "nu: 0.3 E: 20000", f"Plasticity Specifications: {model}",
            f"C: {c} phi: {phi} dil: 1 T: {0.5 if i == 1 else 0} Cr: 1")), "",
        "material properties:", *(row for name, _, _, weight in soils.values() for row in (
            f"  {name}", "  " + " ".join(["1", str(weight), *["0"] * 66, str(ru)]))), "",
        "piezos:", "1", "1", str(len(WATER)), *(f"{x} {y}" for x, y in WATER), "",
        *(row for i in soils for row in (f"newmaterialsprop {i} start:", f"  iStaticWaterMode: {mode}", "  piezo_to_use: 1", f"newmaterialsprop {i} end:")),
        "v6 geometry start:", *(row for kind, corners in lines for row in (f'type: "{kind}"', *points(corners))), "v6 geometry end:",
        "materials mesh start:", *(row for i, (x, y) in list(inside.items())[:seeds] for row in (
            f"P1: {x}, {y}", f"P2: {x + 0.1}, {y}", f"P3: {x}, {y + 0.1}", f"stage 1: {i}")), "materials mesh end:",
        "bolts start:", "bolt 1 start:", "bolt 1 end:", "bolts end:", "",
    ])  # fmt: skip


def areas(section: Section) -> dict[str, float]:
    """Area of each soil."""
    return {soil: sum(abs(area_of(r.outline)) for r in section.regions if r.soil == soil) for soil in section.soils}


class Rocscience(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)

    def told(self, code: int, *words: str) -> str:
        output, errors = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(output), contextlib.redirect_stderr(errors):
            self.assertEqual(main(["import", *words, "--program", str(self.folder / "none")]), code, errors.getvalue())
        return output.getvalue() + errors.getvalue()

    def write(self, name: str, text: str) -> Path:
        """A file, in an archive where its name is one of an archive."""
        path = self.folder / name
        if path.suffix in (".slim", ".fez"):
            with zipfile.ZipFile(path, "w") as archive:
                archive.writestr("model" + (".sli" if path.suffix == ".slim" else ".fea"), text)
                archive.writestr("view.txt", "nothing")
        else:
            path.write_text(text)
        return path

    def check(self, section: Section) -> None:
        """Regions, areas, numbers and water are those of the slope."""
        self.assertEqual({r.name for r in section.regions}, {"top dense", "seam", "rock"})
        exact = {SOILS[i][0].replace(",", ""): sum(Polygon(cell).area for cell in cells) for i, cells in CELLS.items()}
        for soil, area in areas(section).items():
            self.assertAlmostEqual(area, exact[soil], places=6)
        top = section.soils["top dense"]
        self.assertEqual((top.weight, top.cohesion, top.friction), (19.0, 9.0, 29.0))
        self.assertEqual((section.water, section.water_weight), ([tuple((float(x), float(y)) for x, y in WATER)], 9.81))

    def test_slide_text_and_archive(self) -> None:
        for name in ("slope.sli", "slope.slim"):
            section = read_slide(self.write(name, slide_text()), None)
            self.check(section)
            self.assertEqual(section.soils["top dense"].saturated_weight, 20.0)
            self.assertIsNone(section.soils["seam"].saturated_weight)
            self.assertEqual(section.left, ["1 x anchors", "seismic = 0.1"])

    def test_loads_of_slide_that_are_even_and_straight_down(self) -> None:
        row = "  {} type: {} x1: 8 y1: 20 x2: 2 y2: 20 angle: {} load: 15 load2: {} stage2: 0"
        rows = "\n".join(["forces:", row.format(1, 0, 270, 15), row.format(2, 0, 270, 30), row.format(3, 0, 260, 15), row.format(4, 1, 270, 15)])
        for units, metres, kilopascals in (("metric", 1.0, 1.0), ("imperial", 0.3048, 0.0478803)):
            section = read_slide(self.write("slope.sli", slide_text(units, more=rows)), None)
            self.assertEqual([load.name for load in section.loads], ["load 1"])
            for (x, size), wanted in zip(section.loads[0].points, (2.0, 8.0), strict=True):
                self.assertAlmostEqual(x, wanted * metres)
                self.assertAlmostEqual(size, 15.0 * kilopascals)
            self.assertEqual([what.split(":")[0] for what in section.left if what.startswith("load")], ["load 2", "load 3", "load 4"])

    def test_loads_of_rs2_that_are_even_and_straight_down(self) -> None:
        def load(number: int, *more: str) -> str:
            return "\n".join([f"distributed load {number} start:", *points([(8, 20), (2, 20)]), *more, "magnitude1: 15", "magnitude2: 0",
                              f"distributed load {number} end:"])  # fmt: skip

        rows = [load(1, 'type: "vertical"'), load(2), load(3, "triangular: yes"), load(4, 'type: "global angle"'), load(5, "is_groundwater: yes")]
        text = rs2_text() + "\n".join(["new distributed loads start:", "5", *rows, "new distributed loads end:", ""])
        section = read_rs2(self.write("slope.fez", text))
        self.assertEqual([load.points for load in section.loads], [((2.0, 15.0), (8.0, 15.0))] * 2)
        self.assertEqual([what.split(":")[0] for what in section.left if what.startswith("distributed")], [f"distributed load {i}" for i in (3, 4, 5)])

    def test_scenarios_share_their_soils(self) -> None:
        path = self.folder / "slope.slmd"
        own, model = slide_text().split("material types:")[1].split("anchor types:")[0], slide_text()
        flags = "\n  soil1 = water: 1 wtable: 1,\n"
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("p/shared.slsp", "shared model description:\n  version: 9.027\nmaterial types:" + own)
            archive.writestr("p/a.slsc", model.replace(own, flags))
            archive.writestr("p/b.slsc", model.replace(own, flags).replace("water: hu", "water: none"))
            archive.writestr("p/index.slmm", 'sc_filename: "p/b.slsc"\n sc_name: "dry"\nsc_filename: "p/a.slsc"\n sc_name: "wet"\n')
        self.check(read_slide(path, "wet"))
        self.check(read_slide(path, "2"))
        self.assertEqual(read_slide(path, None).water, [])
        with self.assertRaisesRegex(Trouble, "no scenario 'damp'; available are dry, wet"):
            read_slide(path, "damp")

    def test_soils_that_the_water_is_not_for_are_dry(self) -> None:
        path = self.write("slope.sli", slide_text(third="type: 0 c: 40 phi: 36 uw: 21 wtable: 0 other: 1").replace("other: 1 water: 1 wtable: 1", "other: 1"))
        self.assertIn("the water line does not apply to rock: no pore pressure there", self.told(0, str(path)))
        self.assertIn("*WATER LEVEL, BODY=rock, TYPE=NONE\n*CONTROLS", (self.folder / "slope.inp").read_text())

    def test_units(self) -> None:
        feet = read_slide(self.write("slope.sli", slide_text("imperial")), None)
        metres = read_slide(self.write("slope.sli", slide_text()), None)
        self.assertAlmostEqual(areas(feet)["rock"], areas(metres)["rock"] * 0.3048**2, places=6)
        self.assertAlmostEqual(feet.soils["rock"].cohesion or 0.0, 40 * 0.0478803)
        self.assertAlmostEqual(feet.soils["rock"].weight or 0.0, 21 * 0.157087)
        large = read_rs2(self.write("slope.fez", rs2_text("Metric MPa")))
        self.assertEqual((large.soils["rock"].cohesion, large.soils["rock"].young, large.soils["rock"].weight), (40000.0, 2.0e7, 21000.0))
        with self.assertRaisesRegex(Trouble, "units 'cubits' are not supported"):
            read_slide(self.write("slope.sli", slide_text("cubits")), None)

    def test_rs2_archive_and_text(self) -> None:
        for name in ("slope.fez", "slope.fea"):
            section = read_rs2(self.write(name, rs2_text()))
            self.check(section)
            rock = section.soils["rock"]
            self.assertEqual((rock.young, rock.poisson, rock.dilation), (20000.0, 0.3, 1.0))
            self.assertEqual(section.left, [
                "a boundary of kind 'pile_geotextile' from (1, 1)",
                "soil 'top dense': tensile strength 0.5, a deck of the import has no tension cut-off", "1 x bolt"])  # fmt: skip

    def test_what_has_no_counterpart_is_left_or_asked_for(self) -> None:
        section = read_rs2(self.write("slope.fez", rs2_text(model="GeneralizedHoekBrown", mode=0, ru=0.2, seeds=2)))
        left = "\n".join(section.left)
        for words in ("soil 'seam' is of model 'GeneralizedHoekBrown'", "iStaticWaterMode 0", "ru = 0.2", "has no material: treated as empty"):
            self.assertIn(words, left)
        self.assertNotIn("rock", section.soils)
        found = self.told(2, str(self.write("slope.sli", slide_text(third="type: 8 sigc: 5 uw: 21", more="pore pressures:\n  1 x: 1 y: 1 v: 3"))))
        self.assertIn("soil parameters are missing, rock: cohesion, friction", found)
        self.assertIn("strength type 8", found)
        self.assertIn("1 x pore pressures", found)

    def test_the_deck_is_written(self) -> None:
        self.told(0, str(self.write("slope.fez", rs2_text())))
        text = (self.folder / "slope.inp").read_text()
        self.assertIn("*MATERIAL, NAME=rock\n*ELASTIC\n20000, 0.3\n*MOHR COULOMB\n40, 36, 1\n*UNIT WEIGHT\n21, 21\n", text)
        self.assertIn("*WATER LEVEL, UNIT WEIGHT=9.81\n0, 15\n20, 12\n44, 10\n", text)

    def test_what_is_no_model_is_refused(self) -> None:
        self.assertIn("no such file", self.told(2, str(self.folder / "none.fez")))
        self.assertIn("not a model of Slide2", self.told(2, str(self.write("slope.sli", "nothing"))))
        self.assertIn("no section 'model description'", self.told(2, str(self.write("slope.fea", "nothing"))))
        with zipfile.ZipFile(self.folder / "empty.fez", "w") as archive:
            archive.writestr("other.txt", "nothing")
        self.assertIn("no file that ends with .fea", self.told(2, str(self.folder / "empty.fez")))
        self.assertIn("this scenario has no cells", self.told(2, str(self.write("slope.sli", slide_text().split("cells:")[0]))))
        self.assertIn("no external boundary", self.told(2, str(self.write("slope.fea", rs2_text().replace('"external"', '"other"')))))
        damaged = self.write("slope.fea", rs2_text().replace("num points: 6", "num points: six"))
        self.assertIn("damaged, or of an unsupported version", self.told(2, str(damaged)))
        crossed = slide_text().replace("vertices: [1,", "vertices: [1,1,", 1)
        crossed = re.sub(r"vertices: \[1,1,(\d+),(\d+)", r"vertices: [1,\2,\1", crossed, count=1)
        self.assertIn("not a simple polygon", self.told(2, str(self.write("slope.sli", crossed))))
        self.assertIn("not a vertex", self.told(2, str(self.write("slope.sli", slide_text().replace("vertices: [1,", "vertices: [99,", 1)))))


if __name__ == "__main__":
    unittest.main()
