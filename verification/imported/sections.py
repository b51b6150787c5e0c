"""Three sections of this project in numbers, and as files: a drawing, a project of GeoStudio, a model of Slide2.

The files beside are what the writers here make (`imported.py` compares); Bishop's circles and xslope take the numbers, not what the import read.
"""

from __future__ import annotations

import pathlib
import zipfile
from dataclasses import dataclass

Point = tuple[float, float]
GAMMA_WATER = 9.81


@dataclass(frozen=True)
class Soil:
    """kN and m: unit weights above and below the water, c, phi in degrees."""

    name: str
    weight: float
    saturated: float
    cohesion: float
    friction: float


@dataclass(frozen=True)
class Drawn:
    """A section in metres: regions of (number of a soil, corners), water, loads (x1, x2, height, kPa)."""

    file: str
    what: str
    soils: tuple[Soil, ...]
    regions: tuple[tuple[int, tuple[Point, ...]], ...]
    water: tuple[Point, ...]
    loads: tuple[tuple[float, float, float, float], ...]


EMBANKMENT = Drawn(
    "embankment.dxf", "embankment on clay over sand, drawn in mm",
    (Soil("fill", 20, 20, 5, 33), Soil("clay", 17, 18, 12, 20), Soil("sand", 19, 20, 2, 35)),
    ((0, ((0, 9), (29, 9), (20, 15), (0, 15))), (1, ((0, 5), (45, 5), (45, 9), (29, 9), (0, 9))), (2, ((0, 0), (45, 0), (45, 5), (0, 5)))),
    ((0, 9), (29, 9), (45, 8.5)), ((8, 17, 15, 15),),
)  # fmt: skip
FIVE_LAYERS = Drawn(
    "five_layers.gsz", "slope of five layers with a berm, GeoStudio",
    (Soil("fill", 19, 19, 4, 32), Soil("silty clay", 18, 18, 10, 24), Soil("soft clay", 17, 17, 15, 17), Soil("silt", 19, 19, 8, 28),
     Soil("marl", 21, 21, 40, 34)),
    ((0, ((0, 16), (15.5, 15), (11, 18), (0, 18))), (1, ((0, 12), (21.5, 11.5), (20, 12), (15.5, 15), (0, 16))),
     (2, ((0, 9), (33, 8.5), (30, 10), (26, 11.5), (21.5, 11.5), (0, 12))), (3, ((0, 5), (50, 4), (50, 7), (36, 7), (33, 8.5), (0, 9))),
     (4, ((0, 0), (50, 0), (50, 4), (0, 5)))),
    ((0, 13), (14, 12), (24, 10.5), (36, 7), (50, 7)), ((2, 9, 18, 20), (22, 26, 11.5, 10)),
)  # fmt: skip
CUT = Drawn(
    "cut.sli", "cut in clay of phi = 0 with water in it, Slide2",
    (Soil("crust", 18, 19, 35, 0), Soil("clay", 17, 18, 24, 0), Soil("gravel", 20, 21, 1, 38)),
    ((0, ((0, 9), (20, 9), (14, 12), (0, 12))), (1, ((0, 3), (45, 3), (45, 5), (28, 5), (20, 9), (0, 9))), (2, ((0, 0), (45, 0), (45, 3), (0, 3)))),
    ((0, 8), (22, 8), (45, 8)), ((5, 11, 12, 25),),
)  # fmt: skip
SECTIONS = (EMBANKMENT, FIVE_LAYERS, CUT)


def write_dxf(drawn: Drawn, path: pathlib.Path) -> None:
    """A drawing in mm: closed lines on a layer a soil, lines of water and loads; its soils are a table beside."""
    rows = ["0", "SECTION", "2", "HEADER", "9", "$ACADVER", "1", "AC1009", "9", "$INSUNITS", "70", "4", "0", "ENDSEC", "0", "SECTION", "2", "ENTITIES"]
    lines = [(drawn.soils[soil].name, corners, 1) for soil, corners in drawn.regions]
    lines += [("water", drawn.water, 0), *((f"load {size:g}", ((a, y), (b, y)), 0) for a, b, y, size in drawn.loads)]
    for layer, corners, closed in lines:
        rows += ["0", "POLYLINE", "8", layer, "66", "1", "70", str(closed)]
        for x, y in corners:
            rows += ["0", "VERTEX", "8", layer, "10", f"{1000 * x:g}", "20", f"{1000 * y:g}", "30", "0"]
        rows += ["0", "SEQEND", "8", layer]
    path.write_text("\n".join([*rows, "0", "ENDSEC", "0", "EOF", ""]), encoding="utf-8")
    table = ["name,weight,saturated_weight,cohesion,friction"] + [f"{s.name},{s.weight},{s.saturated},{s.cohesion},{s.friction}" for s in drawn.soils]
    path.with_suffix(".soils.csv").write_text("\n".join([*table, ""]), encoding="utf-8")


def write_gsz(drawn: Drawn, path: pathlib.Path) -> None:
    """A project; a load is a metre of fill as heavy as its pressure."""
    place = {corner: i for i, corner in enumerate(dict.fromkeys(c for _, corners in drawn.regions for c in corners), start=1)}
    local = [*drawn.water, *((x, y + 1.0) for a, b, y, _ in drawn.loads for x in (a, b))]

    def points(first: int, count: int) -> str:
        return f"<DataPoints>{''.join(f'<DataPoint>{i}</DataPoint>' for i in range(first, first + count))}</DataPoints>"

    soils = "".join(
        f"<Material><ID>{i}</ID><Name>{s.name}</Name><SlopeModel>MohrCoulomb</SlopeModel><StressStrain><UnitWeight>{s.weight}</UnitWeight>"
        f"<CohesionPrime>{s.cohesion}</CohesionPrime><PhiPrime>{s.friction}</PhiPrime></StressStrain></Material>\n"
        for i, s in enumerate(drawn.soils, start=1)
    )  # fmt: skip
    regions = "".join(f"<Region><ID>{i}</ID><PointIDs>{','.join(str(place[c]) for c in corners)}</PointIDs></Region>\n"
                      for i, (_, corners) in enumerate(drawn.regions, start=1))  # fmt: skip
    use = "".join(f'<GeometryUsesMaterial ID="Regions-{i}" Entry="{soil + 1}"/>' for i, (soil, _) in enumerate(drawn.regions, start=1))
    fills = "".join(f"<Surcharge><ID>{i + 1}</ID>{points(len(drawn.water) + 2 * i + 1, 2)}<Pressure>{load[3]}</Pressure></Surcharge>"
                    for i, load in enumerate(drawn.loads))  # fmt: skip
    text = f"""<?xml version="1.0" encoding="UTF-8"?>
<GSIData Version="11.05">
<Analyses Len="1"><Analysis><ID>1</ID><Name>{path.stem}</Name><GeometryId>1</GeometryId></Analysis></Analyses>
<Geometries Len="1"><Geometry><Points>{"".join(f'<Point ID="{i}" X="{x}" Y="{y}"/>' for (x, y), i in place.items())}</Points>
<Regions>{regions}</Regions></Geometry></Geometries>
<Materials>{soils}</Materials>
<Contexts><Context><AnalysisID>1</AnalysisID><GeometryUsesMaterials>{use}</GeometryUsesMaterials></Context></Contexts>
<WaterItems><WaterItem><AnalysisID>1</AnalysisID><Entry><UnitWaterWeight>{GAMMA_WATER}</UnitWaterWeight></Entry></WaterItem></WaterItems>
<StabilityItems><StabilityItem><AnalysisID>1</AnalysisID><Entry>
<DataPoints>{"".join(f'<DataPoint Number="{i}" X="{x}" Y="{y}"/>' for i, (x, y) in enumerate(local, start=1))}</DataPoints>
<PiezometricSurfaces><PiezometricSurface><ID>1</ID>{points(1, len(drawn.water))}</PiezometricSurface></PiezometricSurfaces>
<Surcharges>{fills}</Surcharges></Entry></StabilityItem></StabilityItems>
</GSIData>
"""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(zipfile.ZipInfo(path.stem + ".xml", (2020, 1, 1, 0, 0, 0)), text)


def write_sli(drawn: Drawn, path: pathlib.Path) -> None:
    """A model."""
    place = {c: i for i, c in enumerate(dict.fromkeys([*(c for _, corners in drawn.regions for c in corners), *drawn.water]), start=1)}

    def numbers(corners: tuple[Point, ...]) -> str:
        return ",".join(str(place[c]) for c in corners)

    path.write_text("\n".join([
        "model description:", "  version: 9.027", "  units: metric", "  water: hu", f"  gammaw: {GAMMA_WATER}", "", "material types:",
        *(f"  soil{i} = type: 0 c: {s.cohesion} phi: {s.friction} uw: {s.weight} uwbwt: {s.saturated} water: 1 wtable: 1,"
          for i, s in enumerate(drawn.soils, start=1)),
        "", "vertices:", *(f"  {i} x: {x} y: {y}" for (x, y), i in place.items()),
        "", "cells:", *(f"  {i} vertices: [{numbers(corners)}] material: soil{soil + 1}" for i, (soil, corners) in enumerate(drawn.regions, start=1)),
        "", "water table:", f"  vertices: [{numbers(drawn.water)}]",
        "", "forces:", *(f"  {i} type: 0 x1: {b} y1: {y} x2: {a} y2: {y} angle: 270 load: {p} load2: {p} stage2: 0"
                         for i, (a, b, y, p) in enumerate(drawn.loads, start=1)),
        "", "material properties:", *(f"  {s.name} red: 1 green: 2 blue: 3 hatch: 0" for s in drawn.soils), "",
    ]), encoding="utf-8")  # fmt: skip


WRITERS = {".dxf": write_dxf, ".gsz": write_gsz, ".sli": write_sli}
