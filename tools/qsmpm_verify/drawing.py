"""Chart of a study: error against CPU seconds, one line for each method, open symbols for other programs, a broad line for the front.

The front connects the runs that form it; at most eight methods are named, the others are grey (the tables contain all).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import matplotlib.pyplot as plt

from qsmpm_verify.front import Sample, front, lasting_errors, order
from qsmpm_verify.plots import save, set_ticks
from qsmpm_verify.studies import Study

MARKS = "osD^v<>pPX*h"
# More lines than this are not told apart.
MOST_SERIES = 8
# Height of a line of text, a share of the drawing.
LINE = 0.045


def label_of(method: str, samples: Sequence[Sample]) -> str:
    """Text of the legend: the method and its fitted order; with only two sizes this is stated, and an increasing error has no order."""
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


def shown_methods(study: Study, samples: Sequence[Sample]) -> list[str]:
    """Methods with a colour and a name, in the order of the study: those of the front, then those nearest to it."""
    errors = lasting_errors(samples)
    best = [(samples[i].seconds, errors[i]) for i in front(samples)]

    def distance(label: str) -> float:
        """Factor by which the best run of the method exceeds the front, in error and cost together; 0 on the front."""
        own = [(s.seconds, e) for s, e in zip(samples, errors) if s.method == label and s.good]
        return min((max(math.log(e / f) + math.log(t / u), 0.0) if (t, e) != (u, f) else 0.0
                    for t, e in own for u, f in best if u <= t and f <= e), default=math.inf)  # fmt: skip

    labels = [m.label for m in study.methods if any(s.good and s.method == m.label for s in samples)]
    nearest = sorted(labels, key=distance)[:MOST_SERIES]
    return [label for label in labels if label in nearest]


def draw_methods(axes: plt.Axes, study: Study, samples: Sequence[Sample]) -> list[tuple[float, float, str, str]]:
    """One line for each method, grey except for the eight nearest to the front; ends of the named lines with their names and colours."""
    shown = shown_methods(study, samples)
    ends = []
    for method in study.methods:
        drawn = [s for s in samples if s.method == method.label and s.good]
        if not drawn:
            continue
        seconds, errors = [s.seconds for s in drawn], [s.error for s in drawn]
        if method.label not in shown:
            axes.loglog(seconds, errors, "-", color="0.8", lw=0.8, zorder=1)
            continue
        place = shown.index(method.label)
        axes.loglog(seconds, errors, "-" + MARKS[place], color=f"C{place}", ms=5, lw=1.2, gid=f"runs-{place}")
        ends.append((seconds[-1], errors[-1], label_of(method.label, samples), f"C{place}"))
    return ends


def tips(study: Study, samples: Sequence[Sample]) -> dict[str, list[str]]:
    """Tooltips of the marks of the chart, by the names of their groups."""
    told = {
        f"runs-{place}": [f"{s.method}, {study.size} {s.size:g}: error {s.error:.2e}, {s.seconds:.3g} CPU s"
                          for s in samples if s.method == label and s.good]
        for place, label in enumerate(shown_methods(study, samples))
    }  # fmt: skip
    told |= {f"other-{k}": [f"{o.label}: error {error:.2e}, {seconds:.3g} CPU s" for _, error, seconds in o.points]
             for k, o in enumerate(study.others)}
    return told


def name_ends(axes: plt.Axes, ends: Sequence[tuple[float, float, str, str]]) -> None:
    """Names of lines in a column at the right, each as close to the end of its line as the other names permit."""
    heights: list[float] = []
    to_share = axes.transAxes.inverted()
    for x, y, name, colour in sorted(ends, key=lambda end: end[1]):
        at = to_share.transform(axes.transData.transform((x, y)))
        height = max(at[1], heights[-1] + LINE if heights else 0.0)
        heights.append(height)
        axes.annotate(name, (at[0], at[1]), (1.02, height), "axes fraction", "axes fraction", fontsize=7.5, color=colour, va="center",
                      arrowprops={"arrowstyle": "-", "relpos": (0.0, 0.5), "color": colour, "lw": 0.4, "alpha": 0.6},
                      annotation_clip=False)  # fmt: skip


def draw_others(axes: plt.Axes, study: Study) -> None:
    """Points of other programs: open symbols and dashed lines."""
    for place, other in enumerate(study.others):
        _, error, seconds = zip(*other.points)
        axes.loglog(
            seconds, error, "--" + MARKS[place % len(MARKS)], color="0.35" if other.how == "stored" else "black",
            mfc="white", ms=5, lw=0.9, gid=f"other-{place}", label=f"{other.label} ({'stored' if other.how == 'stored' else 'run here'})",
        )  # fmt: skip


def draw(study: Study, samples: Sequence[Sample], path: Path) -> Path:
    """Write the chart of a study to a file."""
    figure, axes = plt.subplots(figsize=(9.4, 5.2), layout="constrained")
    ends = draw_methods(axes, study, samples)
    errors, along = lasting_errors(samples), front(samples)
    axes.loglog([samples[i].seconds for i in along], [errors[i] for i in along], "o-", color="gold", lw=7, ms=11, alpha=0.5,
                zorder=0, label="front: no run is both cheaper and more accurate")  # fmt: skip
    draw_others(axes, study)
    set_ticks(axes.xaxis, *axes.get_xlim())
    set_ticks(axes.yaxis, *axes.get_ylim())
    axes.set_xlabel("CPU time of one core [s]")
    axes.set_ylabel(f"{study.error.name} [-]")
    axes.set_title(study.title, fontsize=10, loc="left")
    axes.grid(alpha=0.3, which="both", lw=0.5)
    axes.legend(fontsize=7.5, loc="best")
    name_ends(axes, ends)
    axes.text(1.02, -0.1, f"orders: per {study.size}", transform=axes.transAxes, fontsize=7.5, color="0.4")
    return save(figure, path)
