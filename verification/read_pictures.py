#!/usr/bin/env python3
"""Does VTK read what a run writes, and does it say the same as the HDF5 results? Do rigid bodies, contacts and water levels
in them agree with the curves and the points?

Usage: read_pictures.py BINARY
"""
import pathlib
import sys
import tempfile

import h5py
import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

DECKS = {"input/oedometer.inp": 3, "input/slope_e50_plane.inp": 2}
TOP = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(TOP / "tools"))
from qsmpm_verify.cpu_limit import run_limited  # noqa: E402

passed = failed = 0


def check(name: str, held: bool) -> None:
    global passed, failed
    passed, failed = passed + bool(held), failed + (not held)
    print(("ok     " if held else "FAILED ") + name)


def read(path: pathlib.Path):
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    return reader.GetOutput()


for deck, dimension in DECKS.items():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        text = (TOP / deck).read_text().replace("STEPS=100", "STEPS=5").replace("LOAD FACTOR=100", "LOAD FACTOR=5").replace("30, 100", "5")
        (folder / "deck.inp").write_text(text)
        run = run_limited([sys.argv[1], "run", folder / "deck.inp", "--out", folder / "out"], 100.0)
        check(f"{deck} runs", run.code == 0)
        pictures = sorted((folder / "out").glob("points_*.vtu"))
        meshes = sorted((folder / "out").glob("mesh_*.vtu"))
        check(f"{deck}: there are pictures of points and mesh", bool(pictures) and bool(meshes))
        if not pictures or not meshes:
            continue
        grid, mesh = read(pictures[-1]), read(meshes[-1])
        with h5py.File(folder / "out" / "results.h5") as file:
            last = file["steps"][sorted(file["steps"])[-1]]["points"]
            place, stress = last["position"][...], last["stress"][...]
            start, now = last["initial_volume"][...], last["volume"][...]
        check(f"{deck}: VTK reads every point as a box", grid.GetNumberOfCells() == len(place) > 0)
        corners = vtk_to_numpy(grid.GetPoints().GetData()).reshape(len(place), 2**dimension, 3)
        check(f"{deck}: boxes are where HDF5 has the points", np.allclose(corners.mean(axis=1), place, rtol=0, atol=1e-12 * np.ptp(place)))
        sides = np.ptp(corners, axis=1)[:, :dimension]
        check(f"{deck}: boxes are as large as the points", np.allclose(sides.prod(axis=1), now, rtol=1e-12))
        if dimension == 3:
            ends = corners[:, :, 2].min(), corners[:, :, 2].max()
            check(f"{deck}: boxes fill the squeezed column from its base on", 0 <= ends[0] < 0.01 * ends[1])
        check(f"{deck}: positions agree with HDF5", np.array_equal(vtk_to_numpy(grid.GetCellData().GetArray("position")), place))
        names = [grid.GetCellData().GetArray("stress").GetComponentName(i) for i in range(6)]
        check(f"{deck}: components of a stress have their names", names == ["XX", "YY", "ZZ", "XY", "XZ", "YZ"])
        read_stress = vtk_to_numpy(grid.GetCellData().GetArray("stress"))
        check(f"{deck}: stresses agree with HDF5", np.array_equal(read_stress, stress))
        read_start = vtk_to_numpy(grid.GetCellData().GetArray("initial_volume"))
        check(f"{deck}: initial volumes agree with HDF5 and are not the present ones", np.array_equal(read_start, start) and start.min() > 0 and not np.array_equal(start, now))
        check(f"{deck}: VTK reads the mesh", mesh.GetNumberOfCells() > 0 and mesh.GetNumberOfPoints() > 0)


def run_tutorial(name: str, folder: pathlib.Path) -> h5py.Group:
    """The last step of a deck of the tutorial."""
    run = run_limited([sys.argv[1], "run", TOP / f"docs/tutorial/{name}.inp", "--out", folder / name, "--quiet"], 100.0)
    check(f"{name} runs", run.code == 0)
    steps = h5py.File(folder / name / "results.h5")["steps"]
    return steps[sorted(steps)[-1]]


with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    step = run_tutorial("10_wall", folder)
    rows = [line.split(",") for line in (folder / "10_wall/curves.csv").read_text().splitlines()]
    last = {heading.split(" [")[0]: value for heading, value in zip(rows[0], rows[-1])}
    push, force = float(last["push"]), float(last["force"])
    body, contacts = step["rigid_bodies/000001"], step["contacts"]
    pressures = contacts["pressure"][...] * contacts["extent"][...]
    check("wall: its pose is its move", np.allclose(body["pose"], [push, 0, 0, 0, 0, 0]) and push > 0.01)
    check("wall: its outline is where it has moved to", np.isclose(body["outline"][:, 0].max(), push) and
          np.isclose(np.ptp(body["outline"][:, 1]), 1.4))
    check("wall: its force is the one of the curves", np.isclose(-body["force"][0], force))
    # The force is on the lengths of the start of the step, which the step has stretched by 0.14 %.
    check("wall: the pressures are its force", abs(np.sum(pressures) / force - 1) < 2e-3)
    rest = h5py.File(folder / "10_wall/results.h5")["steps/000001"]
    resting = np.sum(rest["contacts/pressure"][...] * rest["contacts/extent"][...])
    check("wall: at rest too, where nothing stretches", abs(resting + rest["rigid_bodies/000001/force"][0]) < 1e-7)
    check("wall: the soil looks at it, from where it is", bool(np.all(contacts["normal"][:, 0] < -0.9)) and
          np.allclose(contacts["position"][:, 0], push, atol=2e-3))
    check("wall: numbers of body and surface", set(contacts["body"][...]) == {1} == set(contacts["surface"][...]))
    step = run_tutorial("9_drawdown", folder)
    level = step["water/000001"][...]
    check("water: the level as drawn, from end to end", np.allclose(level[:, :2], [[0, 4.5], [7.833333, 4.5], [11.166667, 2.5], [16, 2.5]]))
    pore, place = step["points/pore_pressure"][...], step["points/position"][...]
    wanted = 10 * np.maximum(0, np.interp(place[:, 0], level[:, 0], level[:, 1]) - place[:, 1])
    check("water: the pressure below it is that of its height", np.allclose(pore, wanted, atol=1e-9))
print(f"{passed} passed, {failed} failed")
sys.exit(1 if failed or not passed else 0)
