"""Sections of other programs as decks: drawings and projects that the tests make, what is asked for, what is left and said."""

import contextlib
import io
import json
import subprocess
import tempfile
import unittest
import zipfile
from pathlib import Path

import ezdxf

from qsmpm_verify.cli import main
from qsmpm_verify.importing.deck import deck_of
from qsmpm_verify.importing.dxf import read_dxf
from qsmpm_verify.importing.gsz import read_gsz
from qsmpm_verify.importing.checks import check_section, check_soils
from qsmpm_verify.importing.loads import add_even, add_fill, tractions_of
from qsmpm_verify.importing.section import Region, Section, Soil, area_of
from qsmpm_verify.places import PROGRAM, TOP
from qsmpm_verify.trouble import Trouble

# The slope of verification/week/decks/seam.inp.
OUTLINE = [(0, 0), (44, 0), (44, 10), (30, 10), (10, 20), (0, 20)]
UPPER, LOWER = [(0, 12), (30, 9), (44, 9)], [(0, 11), (30, 8), (44, 8)]
SOILS = """name,weight,young,poisson,cohesion,friction,dilation
top,19,20000,0.3,9,29,29
seam,19,9000,0.3,2,11,11
rock,21,60000,0.3,40,36,36
"""


def draw(path: Path, scale: float = 1.0, unit: int = 6, gap: float = 0.0, upright: bool = False) -> None:
    """The slope: a closed outline, two open lines, texts, a water line, a dimension that is of no use."""
    drawing = ezdxf.new()
    drawing.header["$INSUNITS"] = unit
    space = drawing.modelspace()

    def place(x: float, y: float) -> tuple[float, float, float]:
        return (x * scale, 0.0, y * scale) if upright else (x * scale, y * scale, 0.0)

    space.add_polyline3d([place(*p) for p in OUTLINE], close=True, dxfattribs={"layer": "outline"})
    block = drawing.blocks.new("interfaces")
    block.add_polyline3d([place(*p) for p in UPPER])
    block.add_polyline3d([place(*p) for p in [*LOWER[:-1], (44 - gap, 8)]])
    space.add_blockref("interfaces", (0, 0, 0), dxfattribs={"layer": "layers"})
    space.add_polyline3d([place(*p) for p in ((44, 10), (20, 12), (0, 15))], dxfattribs={"layer": "Water table"})
    for name, at in (("top", (5, 15)), ("seam", (15, 10)), ("rock", (15, 4))):
        space.add_text(name, dxfattribs={"insert": place(*at)})
    space.add_point((1, 1))
    drawing.layers.add("hidden").off()
    space.add_line((0, 0), (9, 9), dxfattribs={"layer": "hidden"})
    drawing.saveas(path)


PROJECT = """<?xml version="1.0" encoding="UTF-8"?>
<GSIData Version="11.05">
<Analyses Len="2"><Analysis><ID>1</ID><Name>dry</Name><GeometryId>1</GeometryId></Analysis>
<Analysis><ID>2</ID><Name>wet</Name><GeometryId>1</GeometryId></Analysis></Analyses>
<Geometries Len="1"><Geometry><Points>{points}</Points><Regions>{regions}</Regions></Geometry></Geometries>
<Materials>
<Material><ID>1</ID><Name>top, dense</Name><SlopeModel>MohrCoulomb</SlopeModel><StressStrain><UnitWeight>19</UnitWeight>
<CohesionPrime>9</CohesionPrime><PhiPrime>29</PhiPrime></StressStrain></Material>
<Material><ID>2</ID><Name>clay</Name><SlopeModel>UndrainedPhiZero</SlopeModel><StressStrain><UnitWeight>18</UnitWeight>
<Cohesion>30</Cohesion></StressStrain></Material>
<Material><ID>3</ID><Name>rock</Name><SlopeModel>HoekBrown</SlopeModel><StressStrain><UnitWeight>21</UnitWeight></StressStrain></Material>
</Materials>
<Contexts>{contexts}</Contexts>
<WaterItems><WaterItem><AnalysisID>2</AnalysisID><Entry><UnitWaterWeight>9.807</UnitWaterWeight>
<ResultInputInfo><Option>Parent</Option></ResultInputInfo></Entry></WaterItem></WaterItems>
<StabilityItems><StabilityItem><AnalysisID>2</AnalysisID><Entry><DataPoints><DataPoint Number="1" X="0" Y="15"/>
<DataPoint Number="2" X="44" Y="10"/><DataPoint Number="3" X="2" Y="20.5"/><DataPoint Number="4" X="6" Y="20.5"/></DataPoints><PiezometricSurfaces><PiezometricSurface><ID>1</ID><DataPoints>
<DataPoint>1</DataPoint><DataPoint>2</DataPoint></DataPoints></PiezometricSurface></PiezometricSurfaces>
<MaterialUsesPiezs><MaterialUsesPiez ID="1" UsesID="1"/></MaterialUsesPiezs><Surcharges Len="1"><Surcharge><ID>1</ID><DataPoints><DataPoint>3</DataPoint><DataPoint>4</DataPoint></DataPoints>
<Pressure>20</Pressure></Surcharge></Surcharges><Seismic Horizontal="0.1" Vertical="0"/></Entry></StabilityItem></StabilityItems>
</GSIData>"""


def project(path: Path, third: int = 2) -> None:
    """The same slope as a project; its lowest soil is of material `third`."""
    corners = [*OUTLINE, *UPPER, *LOWER]
    number = {corner: i for i, corner in enumerate(corners, start=1)}
    regions = ([(0, 12), (30, 9), (44, 9), (44, 10), (30, 10), (10, 20), (0, 20)],
               [(0, 11), (30, 8), (44, 8), (44, 9), (30, 9), (0, 12)], [(0, 0), (44, 0), (44, 8), (30, 8), (0, 11)])  # fmt: skip
    use = "".join(f'<GeometryUsesMaterial ID="Regions-{r}" Entry="{m}"/>' for r, m in ((1, 1), (2, 2), (3, third)))
    text = PROJECT.format(
        points="".join(f'<Point ID="{i}" X="{x}" Y="{y}"/>' for (x, y), i in number.items()),
        regions="".join(f"<Region><ID>{i}</ID><PointIDs>{','.join(str(number[p]) for p in region)}</PointIDs></Region>"
                        for i, region in enumerate(regions, start=1)),
        contexts="".join(f"<Context><AnalysisID>{a}</AnalysisID><GeometryUsesMaterials>{use}</GeometryUsesMaterials></Context>" for a in (1, 2)),
    )  # fmt: skip
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("slope.xml", text)


class Importing(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        self.drawing = self.folder / "slope.dxf"

    def told(self, code: int, *words: str) -> str:
        output, errors = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(output), contextlib.redirect_stderr(errors):
            self.assertEqual(main(["import", *words, "--program", str(self.folder / "none")]), code, errors.getvalue())
        return output.getvalue() + errors.getvalue()

    def test_lines_are_cut_into_the_regions_that_their_texts_name(self) -> None:
        draw(self.drawing)
        section = read_dxf(self.drawing, None, None, None)
        areas = {region.name: abs(area_of(region.outline)) for region in section.regions}
        # By the trapezoids under the lines: 402 = 44 times 8, 30 times 3/2 and what is left; the seam is 1 m over 44 m.
        self.assertAlmostEqual(areas["rock"], 44 * 8 + 30 * 3 / 2, places=6)
        self.assertAlmostEqual(areas["seam"], 44.0, places=6)
        self.assertAlmostEqual(areas["top"], 10 * 10 + 20 * 10 / 2 + 44 * 10 - 441.0, places=6)
        self.assertEqual(section.water, [((0.0, 15.0), (20.0, 12.0), (44.0, 10.0))])
        self.assertEqual(section.left, ["1 x POINT", "1 x on hidden layer 'hidden'"])

    def test_units_and_the_plane_of_the_drawing_change_nothing(self) -> None:
        draw(self.drawing)
        plain = read_dxf(self.drawing, None, None, None).regions
        for scale, unit, upright in ((1000.0, 4, False), (1.0, 6, True), (1.0 / 0.3048, 2, False)):
            draw(self.drawing, scale, unit, upright=upright)
            for one, other in zip(read_dxf(self.drawing, None, None, None).regions, plain, strict=True):
                self.assertEqual(one.name, other.name)
                self.assertAlmostEqual(abs(area_of(one.outline)), abs(area_of(other.outline)), delta=1.0e-4)
        draw(self.drawing, unit=0)
        self.assertIn("metres are assumed", " ".join(read_dxf(self.drawing, None, None, None).notes))

    def test_a_line_that_misses_another_is_told_and_joined_on_request(self) -> None:
        draw(self.drawing, gap=0.02)
        open_ended = read_dxf(self.drawing, None, None, None)
        self.assertEqual(len(open_ended.regions), 2)
        self.assertIn("has a free end at (43.98, 8)", " ".join(open_ended.left))
        self.assertEqual(len(read_dxf(self.drawing, None, None, 0.05).regions), 3)

    def test_a_region_with_a_hole_is_two_bodies_of_one_soil(self) -> None:
        drawing = ezdxf.new()
        drawing.header["$INSUNITS"] = 6
        drawing.modelspace().add_lwpolyline([(0, 0), (10, 0), (10, 10), (0, 10)], close=True, dxfattribs={"layer": "clay"})
        drawing.modelspace().add_circle((5, 5), 2, dxfattribs={"layer": "lens"})
        drawing.saveas(self.drawing)
        regions = read_dxf(self.drawing, None, None, None).regions
        self.assertEqual(sorted(region.name for region in regions), ["clay", "clay 2", "lens"])
        lens = next(abs(area_of(region.outline)) for region in regions if region.soil == "lens")
        self.assertAlmostEqual(lens, 12.566, delta=0.1)
        self.assertAlmostEqual(sum(abs(area_of(region.outline)) for region in regions), 100.0, places=6)

    def test_numbers_that_nobody_has_said_are_asked_for(self) -> None:
        draw(self.drawing)
        self.assertIn("rock: weight, cohesion, friction; seam: weight", self.told(2, str(self.drawing)))
        table = self.folder / "slope.soils.csv"
        self.assertEqual(len(table.read_text().splitlines()), 4)
        table.write_text(SOILS.replace("9000", "soft"))
        self.assertIn("slope.soils.csv:3: young 'soft' is not a number", self.told(2, str(self.drawing)))
        table.write_text(SOILS.replace("seam", "seem"))
        self.assertIn("slope.soils.csv:3: no soil 'seem' in the section", self.told(2, str(self.drawing)))
        table.write_text(SOILS.replace("poisson", "nu"))
        self.assertIn("unknown column 'nu'", self.told(2, str(self.drawing)))
        table.write_text(SOILS)
        self.assertIn("region     seam: soil 'seam', 6 corners", self.told(0, str(self.drawing)))
        self.assertGreater((self.folder / "slope.png").stat().st_size, 5000)

    def test_lines_on_a_layer_of_loads_are_loads(self) -> None:
        draw(self.drawing)
        drawing = ezdxf.readfile(self.drawing)
        drawing.modelspace().add_line((2, 20), (8, 20), dxfattribs={"layer": "Surcharge 12.5 kPa"})
        drawing.modelspace().add_lwpolyline([(0, 0), (44, 0), (44, 9), (0, 9)], close=True, dxfattribs={"layer": "loading dock"})
        drawing.saveas(self.drawing)
        section = read_dxf(self.drawing, None, None, None)
        self.assertEqual([(load.points, load.drawn_at) for load in section.loads], [(((2.0, 12.5), (8.0, 12.5)), 20.0)])
        drawing.modelspace().add_line((2, 20), (8, 20), dxfattribs={"layer": "load"})
        drawing.saveas(self.drawing)
        self.assertIn("layer 'load': its name contains no kPa", self.told(2, str(self.drawing)))

    def test_closed_lines_that_overlap_are_refused(self) -> None:
        drawing = ezdxf.new()
        for name, low, high in (("clay", 0, 5), ("fill", 4, 9)):
            drawing.modelspace().add_lwpolyline([(0, low), (20, low), (20, high), (0, high)], close=True, dxfattribs={"layer": name})
        drawing.saveas(self.drawing)
        self.assertIn("closed lines of layers 'clay' and 'fill' overlap around", self.told(2, str(self.drawing)))

    def test_what_is_no_drawing_is_refused(self) -> None:
        self.drawing.write_text("no drawing\n")
        self.assertIn("not a DXF drawing", self.told(2, str(self.drawing)))
        self.assertIn("no such file", self.told(2, str(self.folder / "other.dxf")))
        self.assertIn("save the drawing as DXF", self.told(2, str(self.folder / "slope.dwg")))
        (self.folder / "slope.gsz").write_bytes(b"PK")
        self.assertIn("no ZIP archive", self.told(2, str(self.folder / "slope.gsz")))
        ezdxf.new().saveas(self.drawing)
        self.assertIn("no lines in the model space", self.told(2, str(self.drawing)))

    def test_a_project_gives_soils_water_and_what_was_left(self) -> None:
        path = self.folder / "slope.gsz"
        project(path)
        section = read_gsz(path, "wet")
        self.assertEqual([(r.name, r.soil) for r in section.regions], [("top dense", "top dense"), ("clay", "clay"), ("clay 2", "clay")])
        top, clay = section.soils["top dense"], section.soils["clay"]
        self.assertEqual((top.weight, top.cohesion, top.friction), (19.0, 9.0, 29.0))
        self.assertEqual((clay.weight, clay.cohesion, clay.friction), (18.0, 30.0, 0.0))
        self.assertEqual((section.water, section.water_weight), ([((0.0, 15.0), (44.0, 10.0))], 9.807))
        self.assertEqual(section.left, ["water by 'Parent': *WATER LEVEL requires a line, or TYPE=SEEPAGE computes one", "Seismic of the analysis"])
        # Half a metre of fill of 20 kN/m3.
        self.assertEqual([load.points for load in section.loads], [((2.0, 10.0), (6.0, 10.0))])
        self.assertEqual(read_gsz(path, None).water, [])
        self.assertEqual(section.dry, {"clay"})
        with self.assertRaisesRegex(Trouble, "no analysis 'damp'; available are 1 'dry', 2 'wet'"):
            read_gsz(path, "damp")
        project(path, third=3)
        self.assertIn("soil 'rock' is of model 'HoekBrown'", self.told(2, str(path)))

    @unittest.skipUnless(PROGRAM.is_file(), "the program is not built")
    def test_the_drawn_slope_has_the_factor_of_the_written_one(self) -> None:
        draw(self.drawing)
        (self.folder / "slope.soils.csv").write_text(SOILS)
        self.told(0, str(self.drawing), "--cells", "11", "--water", "Water table")
        deck = self.folder / "slope.inp"
        text = deck.read_text()
        self.assertIn("*WATER LEVEL, UNIT WEIGHT=9.81\n0, 15\n20, 12\n44, 10\n", text)
        deck.write_text(text.replace("*WATER LEVEL, UNIT WEIGHT=9.81\n0, 15\n20, 12\n44, 10\n", ""))
        written = self.folder / "written.inp"
        fine = (TOP / "verification/week/decks/seam.inp").read_text()
        written.write_text(fine.replace("X, 0, 44, 44", "X, 0, 44, 25").replace("Y, 0, 22, 22", "Y, 0, 20, 11"))
        factors = [factor_of(path, self.folder / path.stem) for path in (deck, written)]
        self.assertAlmostEqual(factors[0], factors[1], delta=0.005)


def bank(*more: Region) -> Section:
    """Level ground, a slope of 1:2 from (10, 4) to (18, 0) and level ground, on a base of 2 m; further regions."""
    ground = Region("ground", "soil", ((0, -2), (30, -2), (30, 0), (18, 0), (10, 4), (0, 4)))
    return Section([ground, *more], {"soil": Soil("soil", 19.0, 20.0, None, None, 5.0, 30.0)})


class Loads(unittest.TestCase):
    def pushed(self, section: Section) -> float:
        """Force down of all tractions."""
        return sum(size * ((b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2) ** 0.5 for pieces, size in tractions_of(section) for a, b in pieces)

    def test_a_load_goes_down_on_the_ground_with_the_soil_to_its_left(self) -> None:
        section = bank()
        add_even(section, ((8, 4), (2, 4)), 15.0, "load 1")
        self.assertEqual(tractions_of(section), [([((8.0, 4.0), (2.0, 4.0))], 15.0)])
        text = deck_of(section, "file", 10)
        self.assertIn("*SURFACE, NAME=load 1, TYPE=SEGMENT\n8, 4, 2, 4\n", text)
        self.assertIn("*TRACTION, SURFACE=load 1\n0, -15\n", text)

    def test_over_a_slope_it_keeps_its_force(self) -> None:
        section = bank()
        add_even(section, ((8, 4), (14, 4)), 10.0, "load 1")
        self.assertAlmostEqual(self.pushed(section), 60.0, places=4)
        self.assertEqual([len(pieces) for pieces, _ in tractions_of(section)], [1, 1])
        check_section(section)
        self.assertIn("its line at y = 4 is not the ground, which is at 2 to 4 there", " ".join(section.notes))

    def test_fill_weighs_what_lies_above_the_ground(self) -> None:
        section = bank()
        add_fill(section, ((6, 5), (14, 5)), 20.0, "surcharge 1")
        # 1 m over 4 m, 1 to 3 m over 4 m.
        self.assertAlmostEqual(self.pushed(section), 20.0 * (4.0 + 8.0), places=3)
        add_fill(section, ((20, -1), (25, -1)), 20.0, "surcharge 2")
        self.assertIn("surcharge 2: below the ground between x = 20 and 25", " ".join(section.left))
        self.assertAlmostEqual(self.pushed(section), 240.0, places=3)

    def test_what_is_beside_the_section_or_on_no_level_line_is_told(self) -> None:
        section = bank()
        add_even(section, ((-4, 4), (2, 4)), 10.0, "load 1")
        add_even(section, ((10, 4), (18, 0)), 10.0, "load 2")
        check_section(section)
        self.assertAlmostEqual(self.pushed(section), 20.0, places=4)
        self.assertIn("load 1: 4 m of its 6 m from x = -4 to 2 are beside the section", section.left)
        self.assertIn("load 2 from (10, 4) to (18, 0): the reference area of a load", " ".join(section.left))

    def test_regions_are_simple_apart_and_hold_together(self) -> None:
        for outline, words in (
            (((0, 4), (4, 6), (4, 4), (0, 6)), "not a simple polygon"), (((0, 3), (8, 3), (8, 6), (0, 6)), "'ground' and 'fill' overlap by 8 m2"),
            (((0, 5), (8, 5), (8, 6), (0, 6)), "are not connected: 2 parts"), (((0, 4), (8, 4)), "fewer than three corners"),
        ):  # fmt: skip
            with self.assertRaisesRegex(Trouble, words):
                check_section(bank(Region("fill", "soil", outline)))
        section = bank(Region("fill", "soil", ((0, 4), (2, 4), (2, 5), (4, 5), (4, 4), (6, 4), (6, 7), (0, 7))))
        check_section(section)
        self.assertIn("an opening of 2 m2 around (3, 4.5)", " ".join(section.notes))

    def test_water_and_units_that_are_unlikely_are_told(self) -> None:
        section = bank()
        section.water = [((5.0, 1.0), (30.0, 0.0)), ((0.0, -5.0), (30.0, -5.0))]
        section.soils["soil"] = Soil("soil", 1900.0, 2000.0, None, None, 5.0, 0.5)
        check_section(section)
        check_soils(section)
        notes = " ".join(section.notes)
        for words in ("30 m wide, 6 m high", "ends at (5, 1), 5 m inside", "is below the section", "not in kg/m3", "check that it is in degrees"):
            self.assertIn(words, notes)
        self.assertNotIn("check the unit of the file", notes)
        section.soils["soil"] = Soil("soil", 19.0, 9.0)
        with self.assertRaisesRegex(Trouble, "saturated_weight 9 is less than weight 19"):
            check_soils(section)
        low = Section([Region("low", "soil", ((0, 0), (1, 0), (0, 0.1)))], {})
        check_section(low)
        self.assertIn("check the unit of the file", " ".join(low.notes))

    def test_an_uneven_floor_is_held_along_it(self) -> None:
        self.assertNotIn("*SUPPORT", deck_of(bank(), "file", 10))
        section = bank(Region("base", "soil", ((0, -4), (30, -3), (30, -2), (0, -2))))
        self.assertIn("*SUPPORT, SURFACE=floor, TYPE=ALL", deck_of(section, "file", 10))
        self.assertIn("*SURFACE, NAME=floor, TYPE=SEGMENT\n0, -4, 10, -3.666666667\n", deck_of(section, "file", 10))


def factor_of(deck: Path, out: Path) -> float:
    """The last stable factor of a deck."""
    done = subprocess.run([PROGRAM, "run", deck, "--out", out, "--quiet"], capture_output=True, text=True, check=False, timeout=300)
    if done.returncode:
        raise AssertionError(done.stderr)
    return float(json.loads((out / "safety.json").read_text())["phases"][0]["stable"])


if __name__ == "__main__":
    unittest.main()
