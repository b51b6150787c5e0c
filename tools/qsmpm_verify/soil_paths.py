"""Chart of laboratory tests on hardening soils against closed forms: `python3 -m qsmpm_verify.soil_paths DIR CHART`.

DIR contains the results of `build/qsmpm point input/point_clay_*.inp input/point_sand_*.inp --out DIR`.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from qsmpm_verify.reference.cam_clay import cam_clay_undrained_pressure

Columns = dict[str, np.ndarray]


CLAYS = {
    "undrained": "point_clay_undrained",
    "drained": "point_clay_drained",
    "confined": "point_clay_confined",
    "undrained OCR 8": "point_clay_overconsolidated",
}


def read_path(folder: Path, test: str) -> Columns:
    """Columns of a test, without units."""
    with (folder / test / "curves.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    return {key.split(" ")[0]: np.array([float(row[key]) for row in rows]) for key in rows[0]}


def from_stage(path: Columns, first: int) -> Columns:
    """The rows from the end of the stage before the first listed one, with strains relative to that state."""
    start = int(np.argmax(path["phase"] >= first)) - 1
    rows = {key: values[start:] for key, values in path.items()}
    rows["axial_strain"] = rows["axial_strain"] - rows["axial_strain"][0]
    return rows


def draw_clay(axes: plt.Axes, folder: Path) -> None:
    """Stress paths of the clay in p and q."""
    eta = np.linspace(0.0, 1.0, 60)
    closed = np.array([100.0 * cam_clay_undrained_pressure(e, 1.0, 0.2, 0.04) for e in eta])
    axes.plot([0, 200], [0, 200], color="0.6", lw=0.8, label="critical state, q = M p")
    for label, test in CLAYS.items():
        path = read_path(folder, test)
        axes.plot(path["p"], path["q"], label=label)
    axes.plot(closed[::6], (eta * closed)[::6], "k.", label="undrained, closed form")
    axes.set(xlabel="p [kPa]", ylabel="q [kPa]", xlim=(0, 170), ylim=(0, 170), title="Modified Cam-Clay")
    axes.legend(fontsize=7)


def draw_triaxial(axes: plt.Axes, path: Columns) -> None:
    """Deviator and axial strain of the sand, with the hyperbola of E50."""
    sine = np.sin(np.radians(35.0))
    failure = 100.0 * 2.0 * sine / (1.0 - sine)
    q = np.linspace(0.0, 0.99 * failure, 16)
    axes.plot(path["axial_strain"], path["deviator"], label="sand, cap out of reach")
    axes.plot(q * 1.1 / (2.0 * 30000.0) / (1.0 - 0.9 * q / failure), q, "k.", label="hyperbola")
    axes.axhline(failure, color="0.6", lw=0.8, label="strength")
    axes.set(xlabel="axial strain", ylabel="q [kPa]", title="Hardening soil, drained triaxial test")
    axes.legend(fontsize=7)


def draw_confined(axes: plt.Axes, path: Columns) -> None:
    """Vertical stress and strain of the sand in one-dimensional compression, with Eoed."""
    strain = np.linspace(0.0, 0.009, 10)
    closed = (np.sqrt(20.0) + 0.5 * 30000.0 * strain / np.sqrt(100.0)) ** 2
    axes.plot(path["axial_strain"], -path["s22"], label="sand")
    axes.plot(strain, closed, "k.", label="first loading with Eoed")
    axes.set(xlabel="axial strain", ylabel="vertical stress [kPa]", title="Hardening soil, confined compression")
    axes.legend(fontsize=7)


def main(arguments: list[str]) -> int:
    """Read the results, write the chart."""
    folder, chart = Path(arguments[0]), Path(arguments[1])
    plt.rcParams["svg.hashsalt"] = "qsmpm"
    figure, axes = plt.subplots(1, 3, figsize=(13.5, 4.3), constrained_layout=True)
    draw_clay(axes[0], folder)
    draw_triaxial(axes[1], from_stage(read_path(folder, "point_sand_triaxial"), 3))
    draw_confined(axes[2], read_path(folder, "point_sand_confined"))
    figure.savefig(chart, metadata={"Date": None} if chart.suffix == ".svg" else None)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
