"""A flow net in the figure of heads: equipotential lines and flow lines."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.interpolate import griddata
from scipy.spatial import cKDTree

from qsmpm_verify.results import Array

# Lines of equal head; places across the longer side of the view; flow below this share of the largest draws no line; heads as even as this are one.
HEADS, ACROSS, LEAST, EVEN = 12, 160, 1e-2, 1e-9


def draw_net(axes: Any, place: Array, head: Array, flow: Array) -> None:
    """Draw both where there is water: heads and velocities (n, 2) at points (n, 2), NaN where it is dry."""
    low, high = place.min(axis=0), place.max(axis=0)
    x, y = (np.linspace(a, b, max(2, round(ACROSS * (b - a) / max(high - low)))) for a, b in zip(low, high))
    grid = np.stack(np.meshgrid(x, y), axis=-1)
    near, own = cKDTree(place).query(grid)
    # Beside the ground no place is nearer than points are to their neighbours.
    gap = 1.5 * np.median(cKDTree(place).query(place, k=4)[0][:, 3])
    wet = (near < gap) & ~np.isnan(flow[own, 0])
    speed = np.hypot(*np.nan_to_num(flow).T)
    level, across, up = (griddata(place, values, grid) for values in (head, *np.nan_to_num(flow).T))
    wet &= ~np.isnan(level)
    if not wet.any() or np.ptp(level[wet]) <= EVEN * np.abs(level[wet]).max() or not speed.any():
        return
    axes.contour(x, y, np.where(wet, level, np.nan), HEADS, colors="white", linewidths=0.7, zorder=2.6)
    still = ~wet | (np.hypot(across, up) < LEAST * speed.max())
    lines = axes.streamplot(x, y, np.where(still, np.nan, across), np.where(still, np.nan, up), density=0.7, arrowsize=0.7,
                            broken_streamlines=False, color="white", linewidth=0.7, zorder=2.6)  # fmt: skip
    lines.arrows.set_zorder(2.6)
