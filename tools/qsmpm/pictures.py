"""Results of a run as objects of PyVista, which is asked for when they are."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pyvista


def to_pyvista(results: str | os.PathLike[str], step: int | None = None) -> pyvista.PolyData:
    """The material points of a written step as a point cloud with all their fields.

    `results` is the folder of a run or its results.h5; `step` is the number of a step that was written, the last one when it is not given.
    Needs the packages h5py and pyvista; FileNotFoundError without results, KeyError for a step that was not written, which names those that were.
    """
    import h5py
    import pyvista

    path = os.fspath(results)
    path = os.path.join(path, "results.h5") if os.path.isdir(path) else path
    with h5py.File(path, "r") as file:
        steps: dict[int, Any] = {int(name): group for name, group in file.get("steps", {}).items()}
        number = max(steps, default=-1) if step is None else step
        if number not in steps:
            raise KeyError(f"step {number} was not written; {', '.join(map(str, sorted(steps))) or 'none'} were")
        group = steps[number]["points"]
        cloud = pyvista.PolyData(group["position"][...])
        for name in sorted(set(group) - {"position"}):
            cloud.point_data[name] = group[name][...]
        for key, value in steps[number].attrs.items():
            cloud.field_data[key] = value
    return cloud
