"""Figures of a reliability analysis: importance of the variables, and the histogram of the samples."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from qsmpm_verify.plots import save
from qsmpm_verify.results import Array


def draw(sensitivity: Mapping[str, float], margins: Array, limit: str, title: str, path: Path) -> Path:
    """Bars of the sensitivities beside the histogram of the margins."""
    figure = Figure(figsize=(10.0, 3.8), layout="constrained")
    left, right = figure.subplots(1, 2)
    names = sorted(sensitivity, key=lambda name: abs(sensitivity[name]))
    left.barh(names, [sensitivity[name] for name in names], color=["tab:red" if sensitivity[n] > 0 else "tab:blue" for n in names])
    left.axvline(0.0, color="0.3", lw=0.8)
    left.set_xlabel("alpha: design point in standard deviations, divided by beta")
    known = margins[np.isfinite(margins)]
    if known.size:
        right.hist(known, bins=min(60, max(10, known.size // 20)), color="0.7", edgecolor="0.4", lw=0.4)
    right.axvline(0.0, color="tab:red", lw=1.2)
    right.set_xlabel(limit)
    right.set_ylabel("samples")
    figure.suptitle(title, fontsize=9, x=0.01, ha="left")
    return save(figure, path)
