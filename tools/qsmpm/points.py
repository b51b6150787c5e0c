"""The material points: arrays that show the present state without a copy, and copies of what is made on request."""
from __future__ import annotations

import ctypes
from ctypes import POINTER, c_double, c_int
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from .simulation import Simulation


class _Memory:
    """A place in the library's memory that keeps the analysis it belongs to alive."""

    def __init__(self, owner: object, address: int, shape: tuple[int, ...]) -> None:
        self._owner = owner
        self.__array_interface__ = {"shape": shape, "typestr": np.dtype(float).str, "data": (address, True),
                                    "version": 3}


class Points:
    """Material points of an analysis: one row a point.

    `position`, `initial_position`, `stress`, `state`, `volume`, `initial_volume` and `weight` are views: not copied,
    read-only, always those of the last accepted step, good as long as they are referred to and no phase begins in which
    bodies come or go: then ask for them anew. The others are copies.
    """

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation

    def __len__(self) -> int:
        return self._simulation._shape("point_volume")[1]

    def _view(self, name: str) -> np.ndarray:
        run = self._simulation
        place, rows, columns = POINTER(c_double)(), c_int(), c_int()
        run._call("view", name.encode(), ctypes.byref(place), ctypes.byref(rows), ctypes.byref(columns))
        shape = (columns.value, rows.value)
        if not place:
            return np.zeros(shape)
        address = ctypes.addressof(place.contents)
        return np.asarray(_Memory(run._handle, address, shape))

    @property
    def position(self) -> np.ndarray:
        """Positions (n, dimension)."""
        return self._view("point_position")

    @property
    def initial_position(self) -> np.ndarray:
        """Positions that displacements count from (n, dimension)."""
        return self._view("point_initial_position")

    @property
    def displacement(self) -> np.ndarray:
        """Displacements (n, dimension)."""
        return self._simulation.get("point_displacement")

    @property
    def stress(self) -> np.ndarray:
        """Cauchy stresses 11, 22, 33, 12[, 13, 23] (n, 4 or 6), tension positive."""
        return self._view("point_stress")

    @stress.setter
    def stress(self, values: np.ndarray) -> None:
        self._simulation.set("point_stress", values)

    @property
    def state(self) -> np.ndarray:
        """State variables of the laws (n, largest number of all laws)."""
        return self._view("point_state")

    @state.setter
    def state(self, values: np.ndarray) -> None:
        self._simulation.set("point_state", values)

    @property
    def volume(self) -> np.ndarray:
        """Volumes (n), per radian in axisymmetry."""
        return self._view("point_volume")[:, 0]

    @property
    def initial_volume(self) -> np.ndarray:
        """Volumes at the start (n)."""
        return self._view("point_initial_volume")[:, 0]

    @property
    def weight(self) -> np.ndarray:
        """Weights per unit gravity (n)."""
        return self._view("point_weight")[:, 0]

    @property
    def force(self) -> np.ndarray:
        """Forces that the program has put on the points (n, dimension)."""
        return self._simulation.get("point_force")

    @force.setter
    def force(self, values: np.ndarray) -> None:
        self._simulation.set("point_force", values)

    @property
    def plastic(self) -> np.ndarray:
        """Whether a point yielded in the last step (n)."""
        return self._simulation.get("point_plastic")[:, 0] > 0

    @property
    def strain(self) -> np.ndarray:
        """Logarithmic strains in the order of the stresses, shear components engineering strains (n, 4 or 6).

        Strains are carried unless *FIELD, STRAIN=NO.
        """
        return self._simulation.get("point_strain")

    @property
    def volume_strain(self) -> np.ndarray:
        """Volume strains ln J (n)."""
        return self._simulation.get("point_volume_strain")[:, 0]

    @property
    def shear_strain(self) -> np.ndarray:
        """Shear strains (2 e:e)^1/2 of the deviator e of the strain (n)."""
        return self._simulation.get("point_shear_strain")[:, 0]

    @property
    def accumulated_plastic_shear_strain(self) -> np.ndarray:
        """Plastic shear strains, summed over the steps (n)."""
        return self._simulation.get("point_accumulated_plastic_shear_strain")[:, 0]

    @property
    def body(self) -> np.ndarray:
        """Number of the body, from 1 (n)."""
        return self._simulation.get("point_body")[:, 0].astype(int)

    @property
    def material(self) -> np.ndarray:
        """Number of the material, from 1 (n)."""
        return self._simulation.get("point_material")[:, 0].astype(int)
