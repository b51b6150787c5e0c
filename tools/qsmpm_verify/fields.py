"""Scalar fields of material points as `view` names them: displacement, stress_xx, pressure, mises, plastic ..."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from qsmpm_verify.results import Array, Points, ResultError
from qsmpm_verify.told import units

AXES = {"x": 0, "y": 1, "z": 2}
COMPONENTS = {"xx": 0, "yy": 1, "zz": 2, "xy": 3, "xz": 4, "yz": 5}
NAMES = (
    "displacement", *(f"displacement_{a}" for a in AXES), *(f"stress_{c}" for c in COMPONENTS), "pressure", "mises",
    "plastic", "material", "volume_ratio", *(f"strain_{c}" for c in COMPONENTS),
    "volume_strain", "shear_strain", "accumulated_plastic_shear_strain",
)  # fmt: skip


def mises(stress: Array) -> Array:
    """Von Mises stress of rows 11, 22, 33, 12, 13, 23."""
    normal, shear = stress[:, :3] - stress[:, :3].mean(axis=1, keepdims=True), stress[:, 3:]
    return np.sqrt(1.5 * (np.sum(normal**2, axis=1) + 2 * np.sum(shear**2, axis=1)))


def scalar_field(points: Points, name: str) -> Array:
    """One value a point. Pressure is the mean stress, compression positive; displacement is its size."""
    if name == "displacement":
        return np.linalg.norm(points.field("displacement"), axis=1)
    if name == "pressure":
        return -points.field("stress")[:, :3].mean(axis=1)
    if name == "mises":
        return mises(points.field("stress"))
    if name == "volume_ratio":
        return points.field("volume") / points.field("initial_volume")
    kind, _, part = name.partition("_")
    places = AXES if kind == "displacement" else COMPONENTS if kind in ("stress", "strain") else {}
    if part in places:
        values = points.field(kind)
        if places[part] >= values.shape[1]:
            raise ResultError(f"{points.path}: {kind} has {values.shape[1]} components, no {part}")
        return values[:, places[part]]
    if name in points.fields and points.fields[name].ndim == 1:
        return points.fields[name].astype(float)
    more = [n for n, v in points.fields.items() if v.ndim == 1 and n not in NAMES]
    raise ResultError(f"{points.path}: no field '{name}'; there are {', '.join([*NAMES, *more])}")


def title_of(name: str) -> str:
    """A field as a legend names it: displacement y, stress xx, plastic shear strain."""
    return {"volume_ratio": "volume over that of the start", "mises": "von Mises stress", "plastic": "state",
            "pressure": "mean stress, compression positive"}.get(name, name.replace("_", " "))  # fmt: skip


def unit_of(folder: Path, name: str) -> str:
    """Unit of a field, from *UNITS of the echoed deck in the folder; empty when it says none."""
    words = units(folder)
    if name.startswith("displacement"):
        return words.get("LENGTH", "")
    if name == "stress_error":
        return ""
    if name.startswith(("stress", "pressure", "mises")) and {"LENGTH", "FORCE"} <= words.keys():
        return f"{words['FORCE']}/{words['LENGTH']}2"
    return ""
