"""Scalar fields of material points by the names that `view` accepts: displacement, stress_xx, pressure, mises, plastic ..."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from qsmpm_verify.results import Array, Points, ResultError
from qsmpm_verify.told import units

AXES = {"x": 0, "y": 1, "z": 2}
COMPONENTS = {"xx": 0, "yy": 1, "zz": 2, "xy": 3, "xz": 4, "yz": 5}
# Names that the program does not write, and the field that is meant.
SHORT = {"pressure": "stress"}
NAMES = (
    "displacement", *(f"displacement_{a}" for a in AXES), "stress", *(f"stress_{c}" for c in COMPONENTS), "pressure", "mises",
    "total_stress", "pore_pressure", "head", "darcy_velocity", "plastic", "material", "volume_ratio", *(f"strain_{c}" for c in COMPONENTS),
    "volume_strain", "shear_strain", "accumulated_plastic_shear_strain",
)  # fmt: skip


def mises(stress: Array) -> Array:
    """Von Mises stress of rows 11, 22, 33, 12, 13, 23."""
    normal, shear = stress[:, :3] - stress[:, :3].mean(axis=1, keepdims=True), stress[:, 3:]
    return np.sqrt(1.5 * (np.sum(normal**2, axis=1) + 2 * np.sum(shear**2, axis=1)))


def scalar_field(points: Points, name: str) -> Array:
    """One value for each point: a scalar field, the magnitude of a vector, the mean of a stress (compression positive), a component."""
    if name in SHORT:
        return scalar_field(points, SHORT[name])
    if name == "mises":
        return mises(points.field("stress"))
    if name == "volume_ratio":
        return points.field("volume") / points.field("initial_volume")
    if name in points.fields:
        return _whole(points, name)
    kind, _, part = name.rpartition("_")
    values = points.fields.get(kind, np.zeros(0))
    places = {3: AXES, 6: COMPONENTS}.get(values.shape[-1], {}) if values.ndim == 2 else {}
    if part in places:
        return values[:, places[part]]
    more = [n for n, v in points.fields.items() if v.ndim == 1]
    tensors = [f"{n}_{'x' if v.shape[1] == 3 else 'xx'} ..." for n, v in points.fields.items() if v.ndim == 2]
    raise ResultError(f"{points.path}: no field '{name}'; available are {', '.join(dict.fromkeys([*NAMES, *more, *tensors]))}")


def _whole(points: Points, name: str) -> Array:
    """One value for all components of a field."""
    values = points.fields[name]
    if values.ndim == 1:
        return values.astype(float)
    if values.shape[1] == 3:
        return np.linalg.norm(values, axis=1)
    if name in ("stress", "total_stress"):
        return -values[:, :3].mean(axis=1)
    raise ResultError(f"{points.path}: {name} has components: use {name}_xx, {name}_xy ..., shear_strain or volume_strain")


def title_of(name: str) -> str:
    """Title of a field in a legend: displacement y, stress xx, plastic shear strain."""
    name = SHORT.get(name, name)
    return {"volume_ratio": "volume / initial volume", "mises": "von Mises stress", "plastic": "state",
            "stress": "mean stress, compression positive", "total_stress": "mean total stress, compression positive",
            "pore_pressure": "pore pressure, compression positive"}.get(name, name.replace("_", " "))  # fmt: skip


def unit_of(folder: Path, name: str) -> str:
    """Unit of a field, from *UNITS of the echoed deck in the folder; empty if not defined."""
    words = units(folder)
    if name.startswith(("displacement", "position", "head")):
        return words.get("LENGTH", "")
    if name == "stress_error":
        return ""
    if name.startswith("load"):
        return words.get("FORCE", "")
    stress = name.startswith(("stress", "total_stress", "mises")) or name.endswith("pressure")
    return f"{words['FORCE']}/{words['LENGTH']}2" if stress and {"LENGTH", "FORCE"} <= words.keys() else ""
