"""Figure of the mechanism of the upper bound: dissipation, and velocities as displaced outlines of the triangles."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure

from qsmpm_verify.bounds.search import Found
from qsmpm_verify.bounds.scene import Scene
from qsmpm_verify.plots import save

# Largest displacement drawn, over the size of the scene.
MOVED = 0.06


def draw_mechanism(scene: Scene, found: Found, path: Path) -> Path:
    """Triangles displaced by the mechanism, coloured by the dissipation per area."""
    mechanism = found.mechanism
    mesh = mechanism.model.mesh
    low, high = mesh.places.min(axis=0), mesh.places.max(axis=0)
    moved = mesh.places + MOVED * float((high - low).max()) * mechanism.velocity[: len(mesh.places)]
    worth = np.maximum(mechanism.density, 0.0)
    top = float(np.quantile(worth, 0.98)) or float(worth.max()) or 1.0
    figure = Figure(figsize=(9.6, 9.6 * float(np.clip((high[1] - low[1]) / (high[0] - low[0]), 0.3, 1.0)) + 0.8), layout="constrained")
    axes = figure.subplots()
    axes.add_collection(PolyCollection(list(moved[mesh.corners]), array=np.minimum(worth / top, 1.0), cmap="YlOrRd", edgecolors="0.75", lw=0.2))
    axes.add_collection(LineCollection([np.vstack([body, body[:1]]) for body in scene.bodies.values()], colors="k", linewidths=0.8))
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.set_xlabel(f"x [{scene.units[0]}]" if scene.units[0] else "x")
    axes.set_ylabel(f"y [{scene.units[0]}]" if scene.units[0] else "y")
    both = [f"{name} {bound.value:.4g}" for name, bound in (("upper", found.upper), ("lower", found.lower)) if bound.solved]
    axes.set_title(f"phase {scene.phase}: {', '.join(both) or 'no bound'}; {found.triangles} triangles", fontsize=9, loc="left")
    return save(figure, path)
