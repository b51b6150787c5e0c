"""Figures of 3D bodies by VTK, off screen: the surface of the body coloured by a field, points that have separated from it, mesh edges."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from qsmpm_verify.paraview import COLOURS, WATER, Pieces
from qsmpm_verify.results import Array, Mesh
from qsmpm_verify.solid_skin import Skin

import vtkmodules.vtkRenderingFreeType  # noqa: F401  text
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  the renderer itself
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkLogger, vtkLookupTable, vtkObject, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData, vtkUnstructuredGrid
from vtkmodules.vtkFiltersCore import vtkDelaunay3D, vtkExtractEdges
from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter
from vtkmodules.vtkRenderingAnnotation import vtkScalarBarActor
from vtkmodules.vtkRenderingCore import (
    vtkActor, vtkPolyDataMapper, vtkRenderer, vtkRenderWindow, vtkTextActor, vtkWindowToImageFilter,
)  # fmt: skip

WIDTH = 1200

# No display is the rule here, and points on a lattice have no single net of tetrahedra: VTK warns of both.
vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
vtkObject.GlobalWarningDisplayOff()


@dataclass(frozen=True)
class Look:
    """Common properties of a series of figures, so that they can be superimposed."""

    low: Array
    high: Array
    least: float
    most: float
    height: int

    @staticmethod
    def around(low: Array, high: Array, least: float, most: float) -> Look:
        """A viewpoint for points between two corners."""
        return Look(low, high, least, most, int(np.clip(WIDTH * 0.7 + 190, 320, 1000)) // 2 * 2)


def colours(look: Look) -> vtkLookupTable:
    """Viridis, as in the other figures."""
    from matplotlib import colormaps

    table = vtkLookupTable()
    table.SetNumberOfTableValues(256)
    for i, (red, green, blue, _) in enumerate(colormaps["viridis"](np.linspace(0, 1, 256))):
        table.SetTableValue(i, red, green, blue, 1.0)
    table.SetTableRange(look.least, look.most if look.most > look.least else look.least + 1.0)
    return table


def _points_of(places: Array) -> vtkPoints:
    points = vtkPoints()
    points.SetData(numpy_to_vtk(np.ascontiguousarray(places, dtype=float), deep=True))
    return points


def cloud(places: Array, values: Array, table: vtkLookupTable, pixels: float) -> vtkActor:
    """The points as spheres."""
    data = vtkPolyData()
    data.SetPoints(_points_of(places))
    cells = vtkCellArray()
    ends = np.arange(len(places) + 1, dtype=np.int64)
    cells.SetData(numpy_to_vtkIdTypeArray(ends, deep=True), numpy_to_vtkIdTypeArray(ends[:-1].copy(), deep=True))
    data.SetVerts(cells)
    data.GetPointData().SetScalars(numpy_to_vtk(np.ascontiguousarray(values, dtype=float), deep=True))
    mapper = vtkPolyDataMapper()
    mapper.SetInputData(data)
    mapper.SetLookupTable(table)
    mapper.UseLookupTableScalarRangeOn()
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetPointSize(max(1.0, pixels))
    actor.GetProperty().SetRenderPointsAsSpheres(True)
    return actor


def _lines(data: vtkPolyData, colour: tuple[float, float, float], width: float, opacity: float = 1.0) -> vtkActor:
    mapper = vtkPolyDataMapper()
    mapper.SetInputData(data)
    mapper.ScalarVisibilityOff()
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(*colour)
    actor.GetProperty().SetLineWidth(width)
    actor.GetProperty().SetOpacity(opacity)
    actor.GetProperty().SetLighting(False)
    return actor


def hull(start: Array, spacing: float) -> vtkPolyData:
    """Surface of the points in their initial positions; gaps wider than 1.6 spacings remain open."""
    data = vtkPolyData()
    data.SetPoints(_points_of(start))
    net = vtkDelaunay3D()
    net.SetInputData(data)
    net.SetAlpha(1.6 * spacing)
    skin = vtkGeometryFilter()
    skin.SetInputConnection(net.GetOutputPort())
    skin.Update()
    return skin.GetOutput()


def filled(skin: Skin, values: Array, table: vtkLookupTable) -> vtkActor:
    """A surface with its field, interpolated between points, with lighting."""
    data = vtkPolyData()
    data.SetPoints(_points_of(skin.places))
    cells = vtkCellArray()
    ends = 3 * np.arange(len(skin.faces) + 1, dtype=np.int64)
    cells.SetData(numpy_to_vtkIdTypeArray(ends, deep=True), numpy_to_vtkIdTypeArray(skin.faces.astype(np.int64).ravel(), deep=True))
    data.SetPolys(cells)
    data.GetPointData().SetScalars(numpy_to_vtk(np.ascontiguousarray(values[skin.source], dtype=float), deep=True))
    mapper = vtkPolyDataMapper()
    mapper.SetInputData(data)
    mapper.SetLookupTable(table)
    mapper.UseLookupTableScalarRangeOn()
    mapper.InterpolateScalarsBeforeMappingOn()
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetInterpolationToFlat()
    actor.GetProperty().SetAmbient(0.55)
    actor.GetProperty().SetDiffuse(0.5)
    return actor


def beside(pieces: Pieces, kind: int) -> vtkActor:
    """Rigid bodies, or transparent water."""
    data = vtkPolyData()
    data.SetPoints(_points_of(np.concatenate(pieces.places)))
    faces = vtkCellArray()
    for cell in pieces.faces:
        if cell.kind == kind:
            faces.InsertNextCell(len(cell.nodes), cell.nodes)
    data.SetPolys(faces)
    mapper = vtkPolyDataMapper()
    mapper.SetInputData(data)
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(*(c / 255 for c in COLOURS[kind]))
    actor.GetProperty().SetOpacity(0.3 if kind == WATER else 0.6)
    return actor


def mesh_edges(mesh: Mesh) -> vtkActor:
    """Edges of the cells as thin grey lines."""
    grid = vtkUnstructuredGrid()
    grid.SetPoints(_points_of(mesh.nodes))
    for kind, nodes in zip(mesh.types, mesh.cells):
        grid.InsertNextCell(int(kind), len(nodes), [int(n) for n in nodes])
    edges = vtkExtractEdges()
    edges.SetInputData(grid)
    edges.Update()
    return _lines(edges.GetOutput(), (0.6, 0.6, 0.6), 0.7, 0.7)


def _caption(text: str, look: Look) -> vtkTextActor:
    actor = vtkTextActor()
    actor.SetInput(text)
    actor.GetTextProperty().SetColor(0, 0, 0)
    actor.GetTextProperty().SetFontSize(22)
    actor.SetPosition(20, look.height - 40)
    return actor


def _bar(table: vtkLookupTable, look: Look) -> vtkScalarBarActor:
    bar = vtkScalarBarActor()
    bar.SetLookupTable(table)
    bar.SetTitle("")
    bar.SetNumberOfLabels(5)
    bar.SetLabelFormat("%.3g")
    bar.SetOrientationToHorizontal()
    bar.SetUnconstrainedFontSize(True)
    for text in (bar.GetTitleTextProperty(), bar.GetLabelTextProperty()):
        text.SetColor(0, 0, 0)
        text.SetFontSize(18)
        text.BoldOff()
        text.ItalicOff()
        text.ShadowOff()
    bar.SetPosition(0.2, 0.01)
    bar.SetWidth(0.6)
    bar.SetHeight(60 / look.height)
    return bar


def _aim(renderer: vtkRenderer, look: Look) -> float:
    """Direct the camera at the box of the view; returns pixels per unit of length."""
    centre, size = (look.low + look.high) / 2, look.high - look.low
    camera = renderer.GetActiveCamera()
    camera.SetFocalPoint(*centre)
    camera.ParallelProjectionOn()
    reach = float(np.linalg.norm(size)) or 1.0
    camera.SetPosition(*(centre + 2 * reach * np.array([0.5, 0.42, 0.75])))
    camera.SetViewUp(0, 1, 0)
    scale = 1.15 * reach / min(WIDTH, look.height)
    camera.SetParallelScale(scale * look.height / 2)
    renderer.ResetCameraClippingRange()
    return 1 / scale


def picture(
    look: Look,
    places: Array,
    values: Array,
    spacing: float,
    caption: str,
    skins: Sequence[Skin],
    pieces: Pieces,
    before: vtkPolyData | None = None,
    mesh: Mesh | None = None,
) -> Array:
    """One image as rows of red, green and blue."""
    renderer = vtkRenderer()
    renderer.SetBackground(1, 1, 1)
    table = colours(look)
    if mesh is not None:
        renderer.AddActor(mesh_edges(mesh))
    if before is not None:
        renderer.AddActor(_lines(before, (0.45, 0.45, 0.45), 1.5, 0.12))
    pixels = _aim(renderer, look)
    for skin in skins:
        renderer.AddActor(filled(skin, values, table))
    for kind in sorted({cell.kind for cell in pieces.faces}):
        renderer.AddActor(beside(pieces, kind))
    alone = np.setdiff1d(np.arange(len(places)), np.concatenate([skin.inside for skin in skins]) if skins else [])
    if len(alone):
        renderer.AddActor(cloud(places[alone], values[alone], table, 0.9 * spacing * pixels))
    renderer.AddViewProp(_caption(caption, look))
    renderer.AddViewProp(_bar(table, look))
    renderer.ResetCameraClippingRange()
    window = vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(0)
    window.SetSize(WIDTH, look.height)
    window.AddRenderer(renderer)
    window.Render()
    taken = vtkWindowToImageFilter()
    taken.SetInput(window)
    taken.ReadFrontBufferOff()
    taken.Update()
    image = taken.GetOutput()
    columns, rows, _ = image.GetDimensions()
    pixels_read = vtk_to_numpy(image.GetPointData().GetScalars()).reshape(rows, columns, -1)[::-1, :, :3].copy()
    window.Finalize()
    return pixels_read
