"""Figures: curves in one diagram, material points by displacement, and the figures of the paper."""

from __future__ import annotations

import math
import re
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.axis import Axis  # noqa: E402
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter  # noqa: E402

from qsmpm_verify.bodies import body_of, frame_of  # noqa: E402
from qsmpm_verify.fields import unit_of  # noqa: E402
from qsmpm_verify.measures import column_stress_error  # noqa: E402
from qsmpm_verify.plane_picture import bar, draw_around, draw_body, label_axes, legend  # noqa: E402
from qsmpm_verify.reference import van_langen  # noqa: E402
from qsmpm_verify.results import Array, Curves, ResultError, read_cpu_seconds, read_curves, read_mesh, read_points  # noqa: E402
from qsmpm_verify.told import factor_text, phase_name, phase_number  # noqa: E402

# Text stays text and the same figures give the same file.
plt.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "qsmpm"})

#: Columns that are no history.
BOOKKEEPING = {
    "phase", "step", "load_factor", "iterations", "out_of_balance", "damping_share", "stabilisation_share",
    "inaccurate_points", "step_error", "compliance", "soil_inside_bodies", "soil_away_from_bodies", "external_work",
    "internal_work",
}  # fmt: skip


def first_history(curves: Curves, beside: str = "") -> str:
    """Name of the first column requested by the deck, other than `beside`."""
    for name in curves.columns:
        if name not in BOOKKEEPING and name != beside:
            return name
    raise ResultError(f"{curves.path}: no history")


def label(curves: Curves, name: str) -> str:
    """Axis label with the unit."""
    unit = curves.units.get(name, "")
    name = name.replace("_", " ")
    return f"{name} [{unit}]" if unit else name


def plain_number(value: float) -> str:
    """A tick's text: 0.02, 3 or 5e-5."""
    power = math.floor(math.log10(value) + 1e-9)
    if -3 <= power < 4:
        return f"{value:g}"
    return f"{value / 10.0**power:g}e{power}"


def set_ticks(axis: Axis, low: float, high: float) -> None:
    """Labels at powers of ten, and between them if the axis has few of those."""
    decades = math.log10(high / low)
    axis.set_major_locator(LogLocator(base=10, subs=(1.0, 2.0, 5.0) if decades < 2.2 else (1.0,), numticks=20))
    axis.set_major_formatter(FuncFormatter(lambda value, place: plain_number(value)))
    axis.set_minor_formatter(NullFormatter())


def save(figure: plt.Figure, path: Path) -> Path:
    """Write a figure."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if figure.get_layout_engine() is None:
        figure.tight_layout()
    figure.savefig(path, dpi=130, metadata={"Date": None} if path.suffix == ".svg" else None)
    plt.close(figure)
    return path


def parts_of(curves: Curves, folder: Path, x: str, phase: int | str | None, alone: bool) -> list[tuple[str, Array]]:
    """Lines of a run with their names: one, or one for each phase against the load factor, which starts again in each phase."""
    if phase is not None:
        return [(folder.name, curves.rows_of_phase(phase))]
    numbers = list(dict.fromkeys(curves.text["phase"] if "phase" in curves.text else curves.column("phase").astype(int).tolist()))
    if x != "load_factor" or not alone or len(numbers) < 2:
        return [(folder.name, np.arange(len(curves)))]
    home = curves.path.parent
    return [(f"phase {phase_name(home, n) if isinstance(n, int) else n}", curves.rows_of_phase(n)) for n in numbers]


def plot_columns(results: list[Path], x: str, y: str | None, out: Path, phase: int | str | None = None) -> Path:
    """One column against another for several runs, of all phases or of one."""
    figure, axes = plt.subplots(figsize=(6.4, 4.4))
    for folder in results:
        curves = read_curves(folder)
        name = y or first_history(curves)
        for part, rows in parts_of(curves, folder, x, phase, len(results) == 1):
            axes.plot(curves.column(x)[rows], curves.column(name)[rows], label=part)
        axes.set_xlabel(label(curves, x))
        axes.set_ylabel(label(curves, name))
    if phase is not None:
        folder = read_curves(results[0]).path.parent
        number = phase_number(folder, phase)
        factor = factor_text(folder, number) if len(results) == 1 else ""
        axes.set_title(", ".join(part for part in (f"phase {phase_name(folder, number)}", factor) if part), fontsize=10, loc="left")
    axes.grid(alpha=0.3)
    axes.legend()
    return save(figure, out)


def plot_points(results: list[Path], out: Path) -> Path:
    """Last written states of plane bodies one below the other, coloured by the magnitude of the displacement, on one scale."""
    states = [read_points(folder) for folder in results]
    values = [np.linalg.norm(points.field("displacement"), axis=1) for points in states]
    bodies = [body_of(points, value, read_mesh(folder)) for points, value, folder in zip(states, values, results)]
    unit = unit_of(results[0], "displacement")
    frame = frame_of(states, values, "displacement", f"displacement [{unit}]" if unit else "displacement")
    size = frame.high - frame.low
    figure, rows = plt.subplots(len(results), 1, figsize=(8.0, len(results) * (6.6 * size[1] / size[0] + 0.45)), squeeze=False,
                                sharex=True, layout="constrained")
    for axes, folder, points, body in zip(rows[:, 0], results, states, bodies):
        draw_body(axes, body, frame)
        draw_around(axes, body.around, frame)
        phase = phase_name(folder, points.phase)
        axes.set_title(f"{folder.name}: phase {phase}, load factor {points.load_factor:.4g}", fontsize=9, loc="left")
        axes.tick_params(labelsize=8)
        label_axes(axes, frame)
    bar(figure, list(rows[:, 0]), frame, shrink=0.6, pad=0.01)
    legend(figure, rows[0, 0])
    return save(figure, out)


def oedometer_figure(folder: Path, out: Path) -> Path:
    """Fig. 3 of the paper: stress against strain with van Langen's curve."""
    curves = read_curves(folder)
    strain, stress = curves.column("engineering_strain"), -curves.column("axial_stress")
    fine = np.linspace(0.0, float(strain.max()), 300)
    figure, axes = plt.subplots(figsize=(6.0, 4.4))
    axes.plot(fine, [van_langen(e, 1000.0) for e in fine], "k-", lw=1, label="van Langen, E e/(1 - e)")
    axes.plot(strain, stress, "o", ms=4, mfc="none", label="QSMPM, point at mid height")
    axes.set_xlabel("engineering strain")
    axes.set_ylabel("axial stress (compression) [kPa]")
    axes.grid(alpha=0.3)
    axes.legend()
    return save(figure, out)


def settle_axes(axes: plt.Axes, runs: dict[str, Path], kinds: tuple[tuple[str, str, str], ...]) -> int:
    """Draw unit weight against u E for both stiffnesses and the given kinds of run; returns the number of runs available."""
    count = 0
    for young, colour in ((50, "tab:blue"), (200, "tab:red")):
        for name, line, text in kinds:
            folder = runs.get("slope_grid" if (young, name) == (200, "grid") else f"slope_e{young}_{name}")
            if folder is None:
                continue
            count += 1
            curves = read_curves(folder)
            axes.plot(curves.column("crest_settlement") * young, curves.column("load_factor"), line,
                      color=colour, label=f"{text}, E = {young} kPa")
    axes.set_xlabel("u_A E [kPa m]")
    axes.set_ylabel("unit weight [kN/m$^3$]")
    axes.grid(alpha=0.3)
    if count:
        axes.legend(fontsize=8)
    return count


def slope_figure(runs: dict[str, Path], out: Path) -> Path:
    """Fig. 6 of the paper: load-displacement curves of the crest, MPM and updated Lagrangian FEM."""
    figure, axes = plt.subplots(figsize=(6.4, 4.6))
    kinds = (("grid", "-", "recommended method"), ("fem", "--", "FEM"), ("plane", ":", "method of the paper, triangles"),
             ("coarse", "-.", "method of the paper, wedges"))  # fmt: skip
    settle_axes(axes, runs, kinds)
    return save(figure, out)


def mesh_figure(runs: dict[str, Path], out: Path) -> Path | None:
    """Fig. 10 of the paper: the same curve on coarse, medium and fine meshes; None with fewer than three."""
    figure, axes = plt.subplots(figsize=(6.4, 4.6))
    if settle_axes(axes, runs, (("coarse", ":", "coarse"), ("medium", "--", "medium"), ("fine", "-", "fine"))) < 3:
        plt.close(figure)
        return None
    return save(figure, out)


COLUMN_KINDS = (
    ("standard", "s:", "STANDARD, 4 points a cell"),
    ("gimp", "o--", "GIMP, 4 points a cell"),
    ("spline", "D-", "SPLINE2G, CELL, 36 points a cell"),
)  # fmt: skip


def column_figure(runs: dict[str, Path], out: Path) -> Path | None:
    """Stress error of the self-weight column against cells and CPU seconds; runs are named KIND_CELLS."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 4.2), sharey=True)
    drawn = 0
    for kind, line, text in COLUMN_KINDS:
        cells = sorted(int(name[len(kind) + 1 :]) for name in runs if re.fullmatch(kind + r"_\d+", name))
        if not cells:
            continue
        drawn += 1
        folders = [runs[f"{kind}_{n}"] for n in cells]
        errors = [column_stress_error(read_points(folder), height=50.0, unit_weight=0.8) for folder in folders]
        seconds = [read_cpu_seconds(folder) for folder in folders]
        left.loglog(cells, errors, line, label=text)
        right.loglog(seconds, errors, line, label=text)
    if not drawn:
        plt.close(figure)
        return None
    left.set_xlabel("cells over the height")
    left.set_ylabel("stress error, share of the base stress")
    right.set_xlabel("CPU seconds, 40 steps")
    left.legend(fontsize=8)
    set_ticks(left.yaxis, *left.get_ylim())
    for axes in (left, right):
        set_ticks(axes.xaxis, *axes.get_xlim())
        axes.grid(alpha=0.3, which="both")
    return save(figure, out)


FOOTING_KINDS = (("spline", "-", "SPLINE2, 9 points"), ("gimp", "--", "GIMP, 4 points"))


def footing_figure(runs: dict[str, Path], out: Path) -> Path | None:
    """Load against settlement of the footing displaced by its width; runs are named KIND_CELLS."""
    figure, axes = plt.subplots(figsize=(6.4, 4.4))
    drawn = 0
    for kind, line, text in FOOTING_KINDS:
        cells = sorted(int(name[len(kind) + 1 :]) for name in runs if re.fullmatch(kind + r"_\d+", name))
        for n in cells:
            curves = read_curves(runs[f"{kind}_{n}"])
            shade = plt.get_cmap("viridis")(min(0.9, 0.3 * (np.log2(n) - 2)))
            axes.plot(curves.column("settlement"), curves.column("reaction"), line, color=shade, lw=1,
                      label=f"{text}, {n} cells on B/2")
            drawn += 1
    if not drawn:
        plt.close(figure)
        return None
    axes.axhline(2 + np.pi, color="k", lw=0.8, ls=":", label="2 + pi, small displacements")
    axes.set_xlabel("settlement / width B")
    axes.set_ylabel("mean pressure / strength")
    axes.set_ylim(bottom=0)
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)
    return save(figure, out)


def page_figures(runs: dict[str, Path], out: Path) -> list[Path]:
    """Figures beside the page of results, as far as the runs are available; runs are named FILE/NAME."""

    def of(file: str) -> dict[str, Path]:
        return {name.split("/")[1]: folder for name, folder in runs.items() if name.startswith(file + "/")}

    pictures = [
        column_figure(of("column_grid"), out / "column_error.png"),
        footing_figure(of("footing_deep"), out / "footing_deep.png"),
    ]
    return [picture for picture in pictures if picture]


def paper_figures(folder: Path, out: Path) -> list[Path]:
    """All figures for which a folder contains the runs."""
    runs = {path.parent.name: path.parent for path in sorted(folder.glob("*/curves.csv"))}
    pictures: list[Path] = []
    if "oedometer" in runs:
        pictures.append(oedometer_figure(runs["oedometer"], out / "oedometer.png"))
    if any(name.startswith("slope") for name in runs):
        pictures.append(slope_figure(runs, out / "slope_curves.png"))
        # The recommended method first, the paper's beside it; slices in space are too thin to be drawn as sections.
        undrawn = ("fem", "coarse", "medium", "fine")
        names = sorted((n for n in runs if n.startswith("slope") and not n.endswith(undrawn)), key=lambda n: n != "slope_grid")
        drawn = [runs[n] for n in names]
        if drawn:
            pictures.append(plot_points(drawn[:4], out / "slope_points.png"))
        picture = mesh_figure(runs, out / "slope_meshes.png")
        if picture:
            pictures.append(picture)
    if not pictures:
        raise ResultError(f"{folder}: it contains no run of the oedometer or the slope")
    return pictures
