"""Output of a run: the curves and the material points."""

from __future__ import annotations

import csv
import json
import re
from dataclasses import dataclass, field
from pathlib import Path

import h5py
import numpy as np

from qsmpm_verify.surroundings import NOTHING, Surroundings, read_surroundings
from qsmpm_verify.told import phase_number
from qsmpm_verify.trouble import Trouble

Array = np.ndarray


class ResultError(Trouble):
    """A result file is missing or invalid."""


@dataclass(frozen=True)
class Curves:
    """Columns of curves.csv, one value for each accepted step. Columns that are not numbers remain text."""

    path: Path
    columns: dict[str, Array]
    units: dict[str, str]
    text: dict[str, list[str]]

    def __len__(self) -> int:
        return max((len(values) for values in self.columns.values()), default=0)

    def column(self, name: str) -> Array:
        """A column of numbers; for an unknown name the known ones are listed."""
        if name not in self.columns:
            known = ", ".join(self.columns)
            raise ResultError(f"{self.path}: no column of numbers '{name}'; available are {known}")
        return self.columns[name]

    def rows_of_phase(self, phase: int | str) -> Array:
        """Indices of the rows of a phase, given by number (the first is 1) or by name."""
        if "phase" in self.text:
            labels = self.text["phase"]
            names = list(dict.fromkeys(labels))
            if isinstance(phase, int):
                if not 1 <= phase <= len(names):
                    raise ResultError(f"{self.path}: no phase {phase}; available are {', '.join(names)}")
                phase = names[phase - 1]
            rows = [i for i, label in enumerate(labels) if label == phase]
        else:
            wanted = phase_number(self.path.parent, phase)
            rows = [i for i, number in enumerate(self.column("phase")) if number == wanted]
        if not rows:
            raise ResultError(f"{self.path}: no row of phase {phase!r}")
        return np.array(rows)


def split_header(cell: str) -> tuple[str, str]:
    """Name and unit of a header cell `name [unit]`; the unit is empty if there is none."""
    name, bracket, unit = cell.strip().partition("[")
    return name.strip(), unit.rstrip("] ").strip() if bracket else ""


def read_curves(path: Path) -> Curves:
    """Read curves.csv; a row with another length than the header, or no row, is an error."""
    if path.is_dir():
        path = path / "curves.csv"
    try:
        with path.open(newline="", encoding="utf-8") as file:
            rows = [row for row in csv.reader(file, skipinitialspace=True) if row]
    except OSError as error:
        raise ResultError(f"{path}: {error.strerror}") from error
    if len(rows) < 2:
        raise ResultError(f"{path}: no accepted step")
    header, body = [split_header(cell) for cell in rows[0]], rows[1:]
    for number, row in enumerate(body, 2):
        if len(row) != len(header):
            raise ResultError(f"{path}:{number}: {len(row)} values under {len(header)} headings")
    columns: dict[str, Array] = {}
    text: dict[str, list[str]] = {}
    for index, (name, _) in enumerate(header):
        cells = [row[index].strip() for row in body]
        try:
            columns[name] = np.array([float(cell) for cell in cells])
        except ValueError:
            text[name] = cells
    return Curves(path, columns, dict(header), text)


def read_cpu_seconds(folder: Path) -> float:
    """CPU seconds of a run and of those it continued, from timing.json."""
    path = folder / "timing.json"
    try:
        return float(json.loads(path.read_text(encoding="utf-8"))["cpu_seconds"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ResultError(f"{path}: not the seconds of a run ({error!r})") from error


def how_it_ended(folder: Path) -> str | None:
    """Empty if the run of a folder finished, else the last message of its log; None without a log."""
    path = folder / "job.log"
    if not path.exists():
        return None
    lines = [line.strip() for line in path.read_text(encoding="utf-8", errors="replace").splitlines() if line.strip()]
    for line in reversed(lines):
        if line == "qsmpm: finished":
            return ""
        if re.match(r"phase \d+/\d+", line):
            break
    return lines[-1] if lines else "the log is empty"


@dataclass(frozen=True)
class Points:
    """Material points of one written step, one row for each point."""

    path: Path
    step: int
    phase: int
    load_factor: float
    fields: dict[str, Array]
    nodes: Array = field(default_factory=lambda: np.zeros((0, 3)))
    """Coordinates of the mesh at the start of the run, one row for each node."""
    around: Surroundings = NOTHING

    def field(self, name: str) -> Array:
        """A field; for an unknown name the known ones are listed."""
        if name not in self.fields:
            raise ResultError(f"{self.path}: no field '{name}'; available are {', '.join(self.fields)}")
        return self.fields[name]


def _rows_first(values: Array, count: int) -> Array:
    """A dataset with one row for each point, for either storage order."""
    if values.shape[0] != count and values.ndim == 2 and values.shape[1] == count:
        return values.T
    return values


def state_file(path: Path) -> Path:
    """results.h5 of a run folder, or the file itself; it must exist."""
    path = path / "results.h5" if path.is_dir() else path
    if not path.is_file():
        raise ResultError(f"{path} not found")
    return path


def written_steps(path: Path) -> list[int]:
    """Numbers of the steps whose points are in results.h5, in ascending order."""
    path = state_file(path)
    try:
        with h5py.File(path, "r") as file:
            return sorted(int(name) for name in file.get("steps", {}))
    except OSError as error:
        raise ResultError(f"{path}: truncated, or not the states of a run ({error})") from error


@dataclass(frozen=True)
class Mesh:
    """The background mesh at the start of a run: nodes and the nodes of each cell, with its VTK type."""

    nodes: Array
    cells: list[Array]
    types: Array


def read_mesh(path: Path) -> Mesh:
    """The mesh of results.h5."""
    path = state_file(path)
    try:
        with h5py.File(path, "r") as file:
            mesh = file["mesh"]
            nodes, ends = mesh["coordinates"][...], mesh["cell_offsets"][...]
            labels, types = mesh["cell_nodes"][...], mesh["cell_types"][...]
    except (OSError, KeyError) as error:
        raise ResultError(f"{path}: truncated, or not the states of a run ({error})") from error
    return Mesh(nodes, np.split(labels, ends[1:-1]), types)


def phase_of_steps(path: Path) -> dict[int, int]:
    """Phase number of every step whose points are in results.h5."""
    path = state_file(path)
    try:
        with h5py.File(path, "r") as file:
            return {int(name): int(np.ravel(group.attrs["phase"])[0]) for name, group in sorted(file.get("steps", {}).items())}
    except (OSError, KeyError) as error:
        raise ResultError(f"{path}: truncated, or not the states of a run ({error})") from error


def written_mechanisms(path: Path) -> list[int]:
    """Numbers of the phases whose failure mechanism is in results.h5, in ascending order."""
    path = state_file(path)
    try:
        with h5py.File(path, "r") as file:
            return sorted(int(name) for name in file.get("mechanisms", {}))
    except OSError as error:
        raise ResultError(f"{path}: truncated, or not the states of a run ({error})") from error


def read_points(path: Path, step: int | None = None) -> Points:
    """Read the points of a step from results.h5; default the last step written."""
    return _read_group(path, "steps", "step", step)


def read_mechanism(path: Path, phase: int | None = None) -> Points:
    """Read the failure mechanism of a safety phase; default the last one."""
    return _read_group(path, "mechanisms", "mechanism of phase", phase)


def _read_group(path: Path, folder: str, what: str, number: int | None) -> Points:
    """Read the points of the group with a number, or of the last group."""
    path = state_file(path)
    try:
        with h5py.File(path, "r") as file:
            names = sorted(file.get(folder, {}))
            wanted = names[-1:] if number is None else [n for n in names if int(n) == number]
            if not wanted:
                raise ResultError(f"{path}: {what}{'' if number is None else f' {number}'} not found; {len(names)} available")
            group = file[f"{folder}/{wanted[0]}"]
            points = group["points"]
            count = points["volume"].shape[0]
            fields = {name: _rows_first(points[name][...], count) for name in points}
            nodes, around = file["mesh/coordinates"][...], read_surroundings(group)
            attributes = {name: np.ravel(value)[0] for name, value in group.attrs.items()}
    except (OSError, KeyError) as error:
        raise ResultError(f"{path}: truncated, or not the states of a run ({error})") from error
    return Points(
        path,
        int(attributes.get("step", int(wanted[0]))),
        int(attributes.get("phase", 0)),
        float(attributes.get("load_factor", np.nan)),
        fields,
        nodes,
        around,
    )
