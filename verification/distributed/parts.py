"""Checks of files in parts: who reads pictures and results sees those of one process, a restart file is read by any number
of ranks, and one that lacks a part or has a wrong one is refused by name, with the former one still good."""

from __future__ import annotations

import pathlib
import shutil
import signal

import h5py
import numpy as np
from many_ranks import CARRIED, SECONDS, end_one, plane
from support import Check, Place, Run, expect

from qsmpm_verify.results import read_mesh, read_points, written_steps  # noqa: E402  (support.py has set the path)

NEAR = 1.0e-9
"""Between numbers of ranks and one process where nothing yields, relative to the largest value of a field."""


def apart(one: np.ndarray, other: np.ndarray, least: float = 1e-300) -> float:
    """Largest difference over the largest value, or over the least one that is more than rounding."""
    expect(one.shape == other.shape, f"{one.shape} and {other.shape}")
    return float(np.max(np.abs(one - other), initial=0.0) / max(np.max(np.abs(one), initial=0.0), least))


def expect_same_points(alone: dict[str, np.ndarray], shared: dict[str, np.ndarray], what: str, near: float = NEAR) -> None:
    """Points of ranks, sorted by number, carry what those of one process do."""
    numbers = shared["number"]
    order = np.argsort(numbers)
    expect(np.array_equal(numbers[order], 1 + np.arange(order.size)), f"{what}: numbers {numbers[order]}")
    expect(set(shared) - set(alone) <= {"number"} and set(alone) <= set(shared), f"{what}: {sorted(set(shared) ^ set(alone))}")
    for name, values in alone.items():
        # What is estimated from a field is near where the field is; below a millionth of the stress it is rounding.
        far = apart(values, shared[name][order], 1e-6 if name == "stress_error" else 1e-300)
        expect(far <= (1e3 * near if name == "stress_error" else near), f"{what}: {name} is {far:.1e} from that of one process")


def centres(points: np.ndarray, cells: list[np.ndarray]) -> np.ndarray:
    """Middles of cells, in an order of their own."""
    found = np.array([points[cell].mean(axis=0) for cell in cells]).round(9)
    return found[np.lexsort(found.T)]


def expect_same_results(alone: Run, shared: Run) -> None:
    """The HDF5 results of ranks are those of one process, and no cell of their mesh is there twice."""
    expect(written_steps(alone.folder) == written_steps(shared.folder), "other steps have pictures")
    for step in written_steps(alone.folder):
        one, other = (read_points(run.folder, step) for run in (alone, shared))
        expect_same_points(one.fields, other.fields, f"step {step}")
        with h5py.File(alone.folder / "results.h5") as a, h5py.File(shared.folder / "results.h5") as b:
            for name, value in a[f"steps/{step:06d}"].attrs.items():
                expect(apart(value, b[f"steps/{step:06d}"].attrs[name], 1e-6 if name.startswith("stress_error") else 1e-300) < 1e3 * NEAR, f"step {step}: {name}")
    one, other = (read_mesh(run.folder) for run in (alone, shared))
    found = centres(other.nodes, other.cells)
    expect(len(np.unique(found, axis=0)) == len(found) == len(other.types), "a cell of the mesh is there twice")


def read_grid(path: pathlib.Path) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """What VTK reads of a picture, in pieces or not: the fields of its cells, and its points."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOXML import vtkXMLPUnstructuredGridReader, vtkXMLUnstructuredGridReader

    reader = vtkXMLPUnstructuredGridReader() if path.suffix == ".pvtu" else vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    grid = reader.GetOutput()
    data = grid.GetCellData()
    fields = {data.GetArrayName(i): vtk_to_numpy(data.GetArray(i)) for i in range(data.GetNumberOfArrays())}
    corners = vtk_to_numpy(grid.GetPoints().GetData())
    nodes = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(grid.GetNumberOfCells(), -1)
    fields["centre"] = corners[nodes].mean(axis=1)
    return fields, corners


def expect_same_pictures(alone: Run, shared: Run, step: int) -> None:
    """VTK reads the same points and the same filled cells from pieces, and no cell twice."""
    one, other = (read_grid(run.folder / f"points_{step:06d}.{end}")[0] for run, end in ((alone, "vtu"), (shared, "pvtu")))
    expect_same_points(one, other, f"picture {step}")
    one, other = (read_grid(run.folder / f"mesh_{step:06d}.{end}")[0] for run, end in ((alone, "vtu"), (shared, "pvtu")))
    expect(len(np.unique(other["centre"].round(9), axis=0)) == len(other["centre"]), "a cell is in two pieces")
    for cells in (one, other):
        filled = np.flatnonzero(cells["active"])
        order = filled[np.lexsort(cells["centre"][filled].round(9).T)]
        cells |= {name: values[order] for name, values in cells.items()}
    for name, values in one.items():
        expect(apart(values, other[name]) <= NEAR, f"mesh: {name} is another one")
    listed = (shared.folder / "points.pvd").read_text()
    expect(f'file="points_{step:06d}.pvtu"' in listed, listed)


def pictures(place: Place) -> None:
    """Pictures and results of three ranks hold the points, fields and filled cells of those of one process."""
    deck = plane("0, 1, 0, 1.5", phase=CARRIED.replace("{way}", "0.8"), steps=8, more="*FIELD, EVERY=4\n")
    alone = place.run("qsmpm", deck, "alone")
    shared = place.run("qsmpm-mpi", deck, "shared", ranks=3)
    expect(len(list((shared.folder / "parts").glob("*_4.*"))) == 0 < len(list((shared.folder / "parts").glob("*_3.*"))), "no three parts")
    expect_same_results(alone, shared)
    expect_same_pictures(alone, shared, 4)
    again = place.run("qsmpm", deck, "shared")
    left = [p for p in again.folder.rglob("*") if p.suffix == ".pvtu" or p.parent.name == "parts"]
    expect(not left, f"a run of one process leaves {left}")


def seals(folder: pathlib.Path) -> list[str]:
    """Names of the parts of the restart file; those of one that was being written are there too."""
    index = (folder / "restart.h5").read_bytes()
    return sorted(p.name for p in (folder / "parts").glob("restart_*.h5") if p.name.encode() in index)


def stopped_by_disk(place: Place, deck: str, name: str) -> Run:
    """A run on three ranks that finds no room for a file of its last rank."""
    folder = place.work / name / "out"
    (folder / "parts").mkdir(parents=True)
    (folder / "parts" / f"{name}.tmp").symlink_to("/dev/full")
    run = place.run("qsmpm-mpi", deck, f"{name}/out", ranks=3, code=1, wall=SECONDS)
    expect("No space left" in run.said and name in run.said and run.said.count("cannot write") == 1, run.said)
    return run


def full_part(place: Place) -> None:
    """No room for a part of the last rank ends all in ten seconds with exit code 1; a file without one of its parts, or with
    one that is cut, changed or of another state, is refused by name on ranks and in one process."""
    deck = plane("0, 2, 0, 1.5", more="*FIELD, EVERY=1\n*RESTART, EVERY=1\n")
    for name in ("restart_new_3.h5", "results_000002_3.h5", "points_000003_3.vtu"):
        left = stopped_by_disk(place, deck, name).folder / "parts"
        expect(not list(left.glob("restart_new_*.h5")) or not name.startswith("restart"), "parts of no state are left")
    folders = [place.work / "good", place.work / "other"]
    for folder, rows in zip(folders, (5, 12), strict=True):
        shutil.move(end_one(place, deck.replace("STEPS=5", "STEPS=300"), 3, rows, signal.SIGKILL).folder, folder)
    second = seals(folders[0])[1]
    whole = (folders[0] / "parts" / second).read_bytes()
    wrong = {"cannot be opened": None, "it is cut": whole[:-2000], "damaged": whole[:5000] + b"x" + whole[5001:],
             "part of another file": (folders[1] / "parts" / seals(folders[1])[1]).read_bytes()}  # fmt: skip
    for number, (words, content) in enumerate(wrong.items()):
        folder = place.work / "wrong"
        shutil.copytree(folders[0], folder, dirs_exist_ok=True)
        (folder / "parts" / second).unlink()
        if content is not None:
            (folder / "parts" / second).write_bytes(content)
        run = place.run(("qsmpm-mpi", "qsmpm")[number % 2], deck.replace("STEPS=5", "STEPS=300"), "refused", ranks=2 - number % 2 * 2, code=1,
                        restart=folder / "restart.h5", wall=SECONDS)  # fmt: skip
        expect(words in run.said and second in run.said and run.said.count("cannot read") == 1, f"{words}: {run.said}")


def refused_names(place: Place) -> None:
    """No room for the index of the first rank, and a name that the part of the last rank cannot get, end all alike with exit code 1."""
    deck = plane("0, 2, 0, 1.5", more="*RESTART, EVERY=1\n").replace("STEPS=5", "STEPS=30")
    full = place.work / "full"
    full.mkdir()
    (full / "restart.h5.tmp").symlink_to("/dev/full")
    run = place.run("qsmpm-mpi", deck, "full", ranks=3, code=1, wall=3 * SECONDS)
    expect(run.said.count("No space left") == 1, run.said)
    last = seals(place.run("qsmpm-mpi", deck, "good", ranks=3).folder)[2]
    begun = end_one(place, deck, 3, 3, signal.SIGKILL).folder
    (begun / "parts" / last / "taken").mkdir(parents=True)
    run = place.run("qsmpm-mpi", deck, begun.name, ranks=3, code=1, restart=begun / "restart.h5", wall=3 * SECONDS)
    expect(run.said.count("cannot rename") == 1, run.said)


CHECKS: list[Check] = [pictures, full_part]
LONG_CHECKS: list[Check] = [refused_names]
