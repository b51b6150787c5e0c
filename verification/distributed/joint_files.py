"""Checks of files that ranks write together: who reads pictures and results sees those of one process, what one rank cannot
write is the error of all, with the former file still good, and a restart file that is damaged anywhere is refused."""

from __future__ import annotations

import os
import pathlib
import shutil
import signal
import subprocess

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
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

    reader = vtkXMLUnstructuredGridReader()
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
    one, other = (read_grid(run.folder / f"points_{step:06d}.vtu")[0] for run in (alone, shared))
    expect_same_points(one, other, f"picture {step}")
    one, other = (read_grid(run.folder / f"mesh_{step:06d}.vtu")[0] for run in (alone, shared))
    expect(len(np.unique(other["centre"].round(9), axis=0)) == len(other["centre"]), "a cell is in two pieces")
    for cells in (one, other):
        filled = np.flatnonzero(cells["active"])
        order = filled[np.lexsort(cells["centre"][filled].round(9).T)]
        cells |= {name: values[order] for name, values in cells.items()}
    for name, values in one.items():
        expect(apart(values, other[name]) <= NEAR, f"mesh: {name} is another one")


def names(run: Run) -> list[str]:
    """Names of the files of a run."""
    return sorted(str(p.relative_to(run.folder)).replace(run.folder.name, "run") for p in run.folder.rglob("*"))


def pictures(place: Place) -> None:
    """Pictures and results of three ranks are files of the same names with the points, fields and filled cells of one process."""
    deck = plane("0, 1, 0, 1.5", phase=CARRIED.replace("{way}", "0.8"), steps=8, more="*FIELD, EVERY=4\n")
    alone = place.run("qsmpm", deck, "alone")
    shared = place.run("qsmpm-mpi", deck, "shared", ranks=3)
    expect(names(alone) == names(shared), f"{names(alone)} and {names(shared)}")
    pieces = (shared.folder / "mesh_000004.vtu").read_bytes().count(b"<Piece ")
    expect(pieces == 3, f"{pieces} pieces")
    expect_same_results(alone, shared)
    expect_same_pictures(alone, shared, 4)


def without_room(place: Place, file: str) -> pathlib.Path:
    """A program of which the last of three ranks finds the disk full in a file of the folder `out`, and the others do not; the
    file is there before the run."""
    (place.work / file).parent.mkdir(parents=True)
    (place.work / file).touch()
    program = place.work / "program"
    program.write_text(f'#!/bin/sh\nfile={place.work / file}\nif [ "$OMPI_COMM_WORLD_RANK" != 2 ]; then exec {place.build / "qsmpm-mpi"} "$@"; fi\n'
                       f'exec unshare --mount sh -c \'mount --bind /dev/full "$0" && exec {place.build / "qsmpm-mpi"} "$@"\' $file "$@"\n')  # fmt: skip
    program.chmod(0o755)
    return program


def no_room(place: Place) -> None:
    """No room for the rows of the last rank alone ends all in ten seconds with exit code 1 and leaves no file that is half written."""
    if os.geteuid() != 0 or subprocess.run(["unshare", "--mount", "true"], capture_output=True, check=False).returncode != 0:
        print("left out: a disk that is full for one rank (needs root for a name space of its own)")
        return
    deck = plane("0, 2, 0, 1.5", more="*FIELD, EVERY=1\n*RESTART, EVERY=1\n")
    for name in ("restart.h5", "results/000002.h5", "points_000003.vtu"):
        at = Place(place.build, place.work / pathlib.Path(name).stem)
        run = at.run(str(without_room(at, f"out/{name}.tmp")), deck, "out", ranks=3, code=1, wall=SECONDS)
        expect("No space left" in run.said and name in run.said and run.said.count("cannot write") == 1, run.said)
        # The state that was last accepted is written once more, where there is room then.
        left = [n for n in names(run) if n.endswith(".tmp") or n == name != "restart.h5"]
        expect(not left, f"{left} are left")


def damaged(place: Place) -> None:
    """A restart file of ranks that is missing or cut is refused on ranks and in one process, and one that is changed in the piece
    that any of the ranks reads."""
    deck = plane("0, 2, 0, 1.5", more="*RESTART, EVERY=1\n")
    whole = (place.run("qsmpm-mpi", deck, "good", ranks=3).folder / "restart.h5").read_bytes()
    wrong = [("cannot be opened", None), ("it is cut", whole[:-2000]), ("it is cut", b"")]
    wrong += [("damaged", whole[:at] + bytes([whole[at] ^ 16]) + whole[at + 1 :]) for at in (100, len(whole) // 2, len(whole) - 100)]
    for number, (words, content) in enumerate(wrong):
        path = place.work / f"wrong-{number}.h5"
        if content is not None:
            path.write_bytes(content)
        for program, ranks in (("qsmpm-mpi", 3), ("qsmpm", 0))[number % 2 :] if words != "damaged" else (("qsmpm-mpi", 3),):
            run = place.run(program, deck, "refused", ranks=ranks, code=1, restart=path, wall=SECONDS)
            expect(words in run.said and path.name in run.said and run.said.count("cannot read") == 1, f"{words}: {run.said}")


def refused_names(place: Place) -> None:
    """No room for a file of all ranks, and a name that it cannot get, end all alike with exit code 1."""
    deck = plane("0, 2, 0, 1.5", more="*RESTART, EVERY=1\n").replace("STEPS=5", "STEPS=30")
    full = place.work / "full"
    full.mkdir()
    (full / "restart.h5.tmp").symlink_to("/dev/full")
    run = place.run("qsmpm-mpi", deck, "full", ranks=3, code=1, wall=3 * SECONDS)
    expect(run.said.count("No space left") == 1, run.said)
    begun = end_one(place, deck, 3, 3, signal.SIGKILL).folder
    shutil.move(begun / "restart.h5", place.work / "last.h5")
    (begun / "restart.h5" / "taken").mkdir(parents=True)
    run = place.run("qsmpm-mpi", deck, begun.name, ranks=3, code=1, restart=place.work / "last.h5", wall=3 * SECONDS)
    # The state that was last accepted is written once more.
    expect(run.said.count(f"cannot write '{begun}/restart.h5': Is a directory") == 2 == run.said.count("cannot write"), run.said)


CHECKS: list[Check] = [pictures, no_room, damaged]
LONG_CHECKS: list[Check] = [refused_names]
