"""The picture of a study: error over CPU seconds, a line a method, other programs hollow, the front drawn broad."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import matplotlib.pyplot as plt
from matplotlib.axis import Axis
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from qsmpm_verify.front import Sample, front, lasting_errors, order
from qsmpm_verify.plots import save
from qsmpm_verify.studies import Study

MARKS = "osD^v<>pPX*h"


def label_of(method: str, samples: Sequence[Sample]) -> str:
    """Text of the legend: the method and its fitted order; of two sizes only it is said, a rise of the error has none."""
    own = [s for s in samples if s.method == method]
    fitted = order(own)
    if all(s.at_floor for s in own if s.good) and any(s.good for s in own):
        return f"{method}; at the floor"
    if fitted is None:
        return method
    if fitted < 0.2:
        return f"{method}; no order"
    counted = sum(s.good and not s.at_floor for s in own)
    return f"{method}; order {fitted:.1f}" + (" (2 sizes)" if counted == 2 else "")


def plain_number(value: float) -> str:
    """A tick's text: 0.02, 3 or 5e-5."""
    power = math.floor(math.log10(value) + 1e-9)
    if -3 <= power < 4:
        return f"{value:g}"
    return f"{value / 10.0**power:g}e{power}"


def set_ticks(axis: Axis, low: float, high: float) -> None:
    """Numbers at powers of ten; between them too where the axis has few of those."""
    decades = math.log10(high / low)
    axis.set_major_locator(LogLocator(base=10, subs=(1.0, 2.0, 5.0) if decades < 2.2 else (1.0,), numticks=20))
    axis.set_major_formatter(FuncFormatter(lambda value, place: plain_number(value)))
    axis.set_minor_formatter(NullFormatter())


def draw_methods(axes: plt.Axes, study: Study, samples: Sequence[Sample]) -> None:
    """A line a method, with the colour and mark of its place in the study."""
    for place, method in enumerate(study.methods):
        drawn = [s for s in samples if s.method == method.label and s.good]
        if drawn:
            axes.loglog(
                [s.seconds for s in drawn], [s.error for s in drawn], ("-" if place < 10 else "-.")
                + MARKS[place % len(MARKS)], color=f"C{place % 10}", ms=5, lw=1.2, label=label_of(method.label, samples),
            )  # fmt: skip


def draw_others(axes: plt.Axes, study: Study) -> None:
    """Points of other programs: hollow and dashed."""
    for place, other in enumerate(study.others):
        _, error, seconds = zip(*other.points)
        axes.loglog(
            seconds, error, "--" + MARKS[place % len(MARKS)], color="0.35" if other.how == "stored" else "black",
            mfc="white", ms=5, lw=0.9, label=f"{other.label} ({'stored' if other.how == 'stored' else 'run here'})",
        )  # fmt: skip


def draw(study: Study, samples: Sequence[Sample], path: Path) -> Path:
    """The picture of a study in a file."""
    figure, axes = plt.subplots(figsize=(9.4, 5.2))
    draw_methods(axes, study, samples)
    errors, along = lasting_errors(samples), front(samples)
    axes.loglog([samples[i].seconds for i in along], [errors[i] for i in along], "-", color="gold", lw=7, alpha=0.5,
                zorder=0, label="front: no run is cheaper and better")  # fmt: skip
    draw_others(axes, study)
    set_ticks(axes.xaxis, *axes.get_xlim())
    set_ticks(axes.yaxis, *axes.get_ylim())
    axes.set_xlabel("CPU time of one core [s]")
    axes.set_ylabel(f"{study.error.name} [-]")
    axes.set_title(study.title, fontsize=10, loc="left")
    axes.grid(alpha=0.3, which="both", lw=0.5)
    axes.legend(fontsize=7.5, loc="upper left", bbox_to_anchor=(1.01, 1.0), title=f"orders: per {study.size}",
                title_fontsize=7.5)  # fmt: skip
    return save(figure, path)
