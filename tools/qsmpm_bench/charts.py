"""Charts of the measurements as small SVG files that are identical for identical values."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

from qsmpm_bench.measure import significant  # noqa: E402
from qsmpm_verify.plots import set_ticks  # noqa: E402

plt.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "qsmpm", "font.size": 9.0, "axes.grid": True,
                     "grid.alpha": 0.3})

Line = tuple[str, list[float], list[float], str]


def save(figure: plt.Figure, path: Path) -> Path:
    """Write a chart."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if figure.get_layout_engine() is None:
        figure.tight_layout()
    figure.savefig(path, metadata={"Date": None})
    plt.close(figure)
    return path


def log_lines(path: Path, lines: list[Line], x: str, y: str, title: str = "") -> Path:
    """Lines (label, xs, ys, format) in log-log axes; a line without a label has no entry in the legend."""
    figure, axes = plt.subplots(figsize=(6.0, 4.0))
    for label, xs, ys, style in lines:
        axes.loglog(xs, ys, style, label=label or None, markersize=4.5, linewidth=1.2)
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.set_title(title, fontsize=9)
    set_ticks(axes.xaxis, *axes.get_xlim())
    set_ticks(axes.yaxis, *axes.get_ylim())
    axes.legend(fontsize=8)
    return save(figure, path)


def stacked(path: Path, names: list[str], parts: dict[str, list[float]], x: str) -> Path:
    """One horizontal bar for each name, divided into parts."""
    figure, axes = plt.subplots(figsize=(7.0, 0.45 * len(names) + 1.5), layout="constrained")
    left = [0.0] * len(names)
    colours = [*(f"C{i}" for i in range(10)), "black"]
    for number, (part, values) in enumerate(parts.items()):
        axes.barh(names, values, left=left, label=part, color=colours[number % len(colours)])
        left = [start + value for start, value in zip(left, values)]
    axes.invert_yaxis()
    axes.set_xlabel(x)
    axes.grid(axis="y", visible=False)
    figure.legend(fontsize=7, ncol=6, loc="outside upper center")
    return save(figure, path)


def bars(path: Path, names: list[str], values: list[float], x: str, limit: tuple[float, str] | None = None) -> Path:
    """One horizontal bar for each name with its value, and the line of a target."""
    figure, axes = plt.subplots(figsize=(6.4, 0.32 * len(names) + 1.4), layout="constrained")
    drawn: Any = axes.barh(names, values, color="tab:blue")
    axes.bar_label(drawn, labels=[f" {significant(value)}" for value in values], fontsize=8)
    if limit is not None:
        axes.axvline(limit[0], color="tab:red", linewidth=1.0, label=limit[1])
        figure.legend(fontsize=8, frameon=False, loc="outside upper right")
    axes.invert_yaxis()
    axes.margins(x=0.15, y=0.5 / len(names))
    axes.set_xlabel(x)
    axes.grid(axis="y", visible=False)
    return save(figure, path)
