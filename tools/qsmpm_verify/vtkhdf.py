"""All steps of a run in one file for ParaView: VTKHDF whose points and fields are views of the step files, not copies.

The format (VTK, "VTKHDF file format", unstructured grid with steps) requires the steps one after another in one array; virtual datasets of
HDF5 provide this without copying the data. Material points are vertices. The file requires `results.h5` and the folder `results` beside it;
without them it is empty.
"""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np

from qsmpm_verify.results import ResultError, state_file

VERTEX = 1
"""VTK number of the cell type."""
VERSION = (2, 2)


def write_vtkhdf(folder: Path) -> Path:
    """Write `points.vtkhdf` into the folder of a run."""
    out = folder / "points.vtkhdf"
    try:
        with h5py.File(state_file(folder), "r") as results, h5py.File(out, "w") as file:
            groups = [group for _, group in sorted(results.get("steps", {}).items())]
            if not groups:
                raise ResultError(f"{folder}: no step has been written")
            put_steps(file, groups)
    except (OSError, KeyError) as error:
        raise ResultError(f"{folder}: truncated, or not the states of a run ({error})") from error
    return out


def put_steps(file: h5py.File, groups: list[h5py.Group]) -> None:
    """Points, cells and fields of all steps, and the offset of each step."""
    counts = np.array([group["points/position"].shape[0] for group in groups], dtype=np.int64)
    most, begins = int(counts.max()), np.concatenate([[0], np.cumsum(counts)[:-1]])
    root = file.create_group("VTKHDF")
    root.attrs["Version"] = np.array(VERSION, dtype=np.int64)
    root.attrs["Type"] = np.bytes_("UnstructuredGrid")
    for name in ("NumberOfPoints", "NumberOfCells", "NumberOfConnectivityIds"):
        root[name] = counts
    # Every point is its own cell: the steps share the nodes of cells of the largest one, not where cells end.
    root["Connectivity"] = np.arange(most, dtype=np.int64)
    ends = np.concatenate([np.arange(count + 1, dtype=np.int64) for count in counts])
    root.create_dataset("Offsets", data=ends, compression="gzip", shuffle=True)
    root.create_dataset("Types", data=np.full(counts.sum(), VERTEX, dtype=np.uint8), compression="gzip")
    common = set.intersection(*(set(group["points"]) for group in groups)) - {"position"}
    put_view(root, "Points", groups, "position", counts)
    for name in sorted(common):
        put_view(root.require_group("PointData"), name, groups, name, counts)
    steps = root.create_group("Steps")
    steps.attrs["NSteps"] = np.int64(len(groups))
    steps["Values"] = np.array([float(np.ravel(group.attrs["step"])[0]) for group in groups])
    steps["PartOffsets"] = np.arange(len(groups), dtype=np.int64)
    steps["NumberOfParts"] = np.ones(len(groups), dtype=np.int64)
    steps["PointOffsets"] = begins
    steps["CellOffsets"] = begins[:, None]
    steps["ConnectivityIdOffsets"] = np.zeros((len(groups), 1), dtype=np.int64)
    for name in sorted(common):
        steps.require_group("PointDataOffsets")[name] = begins


def put_view(root: h5py.Group, name: str, groups: list[h5py.Group], field: str, counts: np.ndarray) -> None:
    """One array over all steps, mapped to those of the step files, which are named relative to the folder of the run."""
    sets = [group[f"points/{field}"] for group in groups]
    shape = (int(counts.sum()), *sets[0].shape[1:])
    layout = h5py.VirtualLayout(shape=shape, dtype=sets[0].dtype)
    first = 0
    for dataset in sets:
        path = Path(dataset.file.filename)
        source = h5py.VirtualSource(f"{path.parent.name}/{path.name}", dataset.name, shape=dataset.shape)
        layout[first : first + dataset.shape[0]] = source
        first += dataset.shape[0]
    root.create_virtual_dataset(name, layout)
