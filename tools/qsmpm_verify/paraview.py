"""`paraview`: rigid bodies, contact pressures and water levels as files for ParaView, and a script that opens a run with them."""

from __future__ import annotations

import argparse
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from qsmpm_verify.bodies import is_flat
from qsmpm_verify.fields import AXES, COMPONENTS
from qsmpm_verify.plane_picture import BAR
from qsmpm_verify.results import Array, Points, ResultError, read_points, written_steps
from qsmpm_verify.surroundings import RigidBody
from qsmpm_verify.trouble import Trouble
from qsmpm_verify.vtkhdf import write_vtkhdf

BODY, PRESSURE, WATER = 1, 2, 3
SCRIPT = '''"""ParaView: `paraview --script=view.py`, or Tools, Python Shell, Run Script. Written by `qsmpm-verify paraview`."""
import os
from paraview.simple import *

HERE = {here!r}
FIELD = {field!r}
view = GetActiveViewOrCreate("RenderView")
points = PVDReader(registrationName="material points", FileName=os.path.join(HERE, "points.pvd"))
shown = Show(points, view)
shown.Representation = "Surface"
ColorBy(shown, FIELD)
shown.RescaleTransferFunctionToDataRange(True, False)
shown.SetScalarBarVisibility(view, True)
if os.path.exists(os.path.join(HERE, "mesh.pvd")):
    mesh = PVDReader(registrationName="mesh", FileName=os.path.join(HERE, "mesh.pvd"))
    edges = Show(mesh, view)
    edges.Representation = "Wireframe"
    ColorBy(edges, None)
    edges.AmbientColor = edges.DiffuseColor = [0.6, 0.6, 0.6]
    edges.Opacity = 0.4
around = PVDReader(registrationName="rigid bodies, pressures, water", FileName=os.path.join(HERE, "around.pvd"))
beside = Show(around, view)
beside.Representation = "Surface"
beside.LineWidth = 2.0
ColorBy(beside, ("CELLS", "colour"))
beside.MapScalars = 0
beside.Opacity = {opacity}
view.InteractionMode = {mode!r}
view.OrientationAxesVisibility = 1
GetAnimationScene().UpdateAnimationUsingDataTimeSteps()
GetAnimationScene().GoToLast()
ResetCamera(view)
Render(view)
'''
COLOURS = {BODY: (200, 200, 200), PRESSURE: (194, 49, 79), WATER: (31, 111, 208)}


@dataclass
class Cell:
    """A line or face: numbers of its corners, its type, pressure and slip."""

    nodes: list[int]
    kind: int
    pressure: float = 0.0
    slip: float = 0.0


@dataclass
class Pieces:
    """Lines and faces with their types; positions in 3D."""

    places: list[Array] = field(default_factory=list)
    lines: list[Cell] = field(default_factory=list)
    faces: list[Cell] = field(default_factory=list)

    def add(self, corners: Array, kind: int, pressure: float = 0.0, slip: float = 0.0, line: bool = False) -> None:
        """A face or a line with its own corners; those of plane models get a third coordinate that depends on the type."""
        first = sum(map(len, self.places))
        self.places.append(corners)
        (self.lines if line else self.faces).append(Cell(list(range(first, first + len(corners))), kind, pressure, slip))


def _deep(corners: Array, height: float) -> Array:
    """Corners of the plane at a third coordinate."""
    return np.column_stack([corners[:, :2], np.full(len(corners), height)])


def _ball(place: Array, radius: float) -> list[Array]:
    """Faces of a sphere."""
    around, up = np.linspace(0, 2 * np.pi, 25), np.linspace(-np.pi / 2, np.pi / 2, 13)
    grid = place + radius * np.stack([np.outer(np.cos(up), np.cos(around)), np.outer(np.sin(up), np.ones(25)),
                                      np.outer(np.cos(up), np.sin(around))], axis=-1)  # fmt: skip
    return [np.array([grid[i, j], grid[i, j + 1], grid[i + 1, j + 1], grid[i + 1, j]]) for i in range(12) for j in range(24)]


def _square(plane: Array, reach: float) -> Array:
    """A square part of a plane in 3D around its point."""
    first = np.cross(plane[1], np.eye(3)[int(np.argmin(np.abs(plane[1])))])
    first *= reach / np.linalg.norm(first)
    second = np.cross(plane[1], first)
    return np.array([plane[0] + first, plane[0] + second, plane[0] - first, plane[0] - second])


def add_body(pieces: Pieces, body: RigidBody, flat: bool, size: float) -> None:
    """A rigid body: behind the soil in the plane."""
    area = body.area(0.2 * size) if flat else None
    if area is not None:
        pieces.add(_deep(area, -1e-3 * size), BODY)
    elif body.ball is not None:
        for face in _ball(body.ball[:3], float(body.ball[3])):
            pieces.add(face, BODY)
    elif body.plane is not None:
        pieces.add(_square(body.plane, size), BODY)


def pieces_of(points: Points, largest: float) -> Pieces:
    """The objects beside the points of a state; pressures are scaled by the largest of the run."""
    flat, places = is_flat([points]), points.field("position")
    low, high = places.min(axis=0), places.max(axis=0)
    size, found = float((high - low).max()), Pieces()
    for body in points.around.bodies:
        add_body(found, body, flat, size)
    if flat and points.around.pressure > 0:
        contacts = points.around.contacts
        pressed = contacts["pressure"] > 0
        slips = np.linalg.norm(contacts.get("slip", np.zeros((len(pressed), 3))), axis=1)
        bars = points.around.bars(BAR * size / largest)
        for bar, pressure, slip in zip(bars, contacts["pressure"][pressed], slips[pressed]):
            found.add(_deep(bar, 1e-3 * size), PRESSURE, float(pressure), float(slip))
    for line in points.around.water:
        if flat:
            found.add(_deep(line, 2e-3 * size), WATER, line=True)
        else:
            for a, b in zip(line[:-1], line[1:]):
                found.add(np.array([[*a[:2], low[2]], [*b[:2], low[2]], [*b[:2], high[2]], [*a[:2], high[2]]]), WATER)
    return found


def _array(name: str, kind: str, values: Sequence[object], components: int = 1) -> str:
    """An array of VTK's XML."""
    shown = " ".join(f"{v:.17g}" if isinstance(v, float) else str(v) for v in values)
    return f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{components}" format="ascii">{shown}</DataArray>\n'


def _cells(name: str, cells: list[Cell]) -> str:
    """Lines or faces of VTK's XML."""
    numbers = [n for cell in cells for n in cell.nodes]
    ends = np.cumsum([len(cell.nodes) for cell in cells]).tolist()
    return f"<{name}>\n{_array('connectivity', 'Int64', numbers)}{_array('offsets', 'Int64', ends)}</{name}>\n"


def polydata(pieces: Pieces) -> str:
    """The pieces as VTK's XML; `kind` is 1 for rigid bodies, 2 for pressures, 3 for water."""
    cells = [*pieces.lines, *pieces.faces]
    places = [float(x) for corners in pieces.places for x in corners.ravel()]
    colours = [c for cell in cells for c in COLOURS[cell.kind]]
    return (
        '<?xml version="1.0"?>\n<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian">\n<PolyData>\n'
        f'<Piece NumberOfPoints="{len(places) // 3}" NumberOfVerts="0" NumberOfLines="{len(pieces.lines)}" NumberOfStrips="0" '
        f'NumberOfPolys="{len(pieces.faces)}">\n<CellData>\n' + _array("kind", "Int32", [cell.kind for cell in cells])
        + _array("contact_pressure", "Float64", [cell.pressure for cell in cells])
        + _array("contact_slip", "Float64", [cell.slip for cell in cells]) + _array("colour", "UInt8", colours, 3)
        + f"</CellData>\n<Points>\n{_array('Points', 'Float64', places, 3)}</Points>\n"
        + _cells("Lines", pieces.lines) + _cells("Polys", pieces.faces) + "</Piece>\n</PolyData>\n</VTKFile>\n"
    )  # fmt: skip


def times_of(folder: Path) -> dict[int, str]:
    """Time of every state of points.pvd."""
    path = folder / "points.pvd"
    if not path.is_file():
        raise Trouble(f"{path} not found: *FIELD, VTK=YES in the deck writes it")
    found = re.findall(r'timestep="([^"]*)"[^>]*file="points_(\d+)\.p?vtu"', path.read_text(encoding="utf-8"))
    return {int(step): time for time, step in found}


def write_around(folder: Path) -> bool:
    """Write around_NNNNNN.vtp for every state, and around.pvd; returns whether the bodies are plane."""
    steps = [step for step in times_of(folder).items() if step[0] in written_steps(folder)]
    if not steps:
        raise ResultError(f"{folder}: no step is both in points.pvd and in results.h5")
    states = [read_points(folder, step) for step, _ in steps]
    largest = max(state.around.pressure for state in states)
    lines = []
    for state, (step, time) in zip(states, steps):
        name = f"around_{step:06d}.vtp"
        (folder / name).write_text(polydata(pieces_of(state, largest)), encoding="utf-8")
        lines.append(f'    <DataSet timestep="{time}" group="" part="0" file="{name}"/>\n')
    (folder / "around.pvd").write_text('<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n  <Collection>\n'
                                       f'{"".join(lines)}  </Collection>\n</VTKFile>\n', encoding="utf-8")  # fmt: skip
    return is_flat(states)


def colour_of(points: Points, name: str) -> tuple[str, ...]:
    """Name by which ParaView colours cells: a field, the magnitude of a vector, or a component such as `stress_xy`."""
    kind, _, part = name.rpartition("_")
    if name in points.fields:
        return ("CELLS", name) if points.fields[name].ndim == 1 else ("CELLS", name, "Magnitude")
    if kind in points.fields and points.fields[kind].ndim == 2 and part in (AXES if points.fields[kind].shape[1] == 3 else COMPONENTS):
        return "CELLS", kind, part.upper()
    raise ResultError(f"{points.path}: no field '{name}'; available are {', '.join(points.fields)}")


def add_words(verbs: argparse._SubParsersAction) -> None:
    """Arguments of the subcommand."""
    verb = verbs.add_parser("paraview", help="write files of rigid bodies, pressures and water for ParaView, and a script that opens a run")
    verb.add_argument("result", type=Path, help="folder of a run")
    verb.add_argument("--field", default="displacement", help="field by which the material points are coloured (default displacement)")
    verb.set_defaults(act=act)


def act(words: argparse.Namespace) -> int:
    """Write the files and report how to open them."""
    if not words.result.is_dir():
        raise Trouble(f"{words.result} is not the folder of a run")
    colour = colour_of(read_points(words.result), words.field)
    flat = write_around(words.result)
    script = words.result / "view.py"
    script.write_text(SCRIPT.format(here=str(words.result.resolve()), field=colour, opacity=1.0 if flat else 0.5,
                                    mode="2D" if flat else "3D"), encoding="utf-8")  # fmt: skip
    print(f"paraview --script={script}")
    print(f"or all steps in one file: {write_vtkhdf(words.result)}")
    return 0
