#!/usr/bin/env python3
"""Limit equilibrium, or steady seepage, of a plane scene by xslope.

    xslope_run.py SCENE.json

SCENE.json contains outlines of the ground with the numbers of their materials, materials, a water level and the method, or heads at parts of
the outline, seepage faces, and the size of the cells. Circles are searched from xslope's own starting circles, and from a grid of
centres if `grid` requests it, with its defaults. The last line printed is a JSON object.
"""

from __future__ import annotations

import contextlib
import io
import json
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from shapely.geometry import Polygon
from xslope.fileio import build_ground_surface_from_polygons
from xslope.generators import generate_starting_circles
from xslope.search import run_lem_analysis
from xslope.seep import build_seep_data, run_seepage_analysis


def model_of(scene: dict[str, Any]) -> dict[str, Any]:
    """The scene in the format of xslope."""
    polygons = [{"coords": p["outline"], "polygon": Polygon(p["outline"]), "mat_id": p["material"]} for p in scene["grounds"]]
    ground, domain = build_ground_surface_from_polygons(polygons)
    wet = "piezo" if scene["level"] else "none"
    return {
        "gamma_water": scene["water"], "tcrack_depth": 0.0, "tcrack_water": 0.0, "k_seismic": 0.0, "polygons": polygons,
        "max_depth": domain.bounds[1], "domain_polygon": domain, "ground_surface": ground, "circular": True, "circles": [],
        "materials": [{"option": "mc", "d": 0.0, "psi": 0.0, "u": wet, **material} for material in scene["materials"]],
        "piezo_line": scene["level"], "non_circ": [], "dloads": [], "water_loads": "auto", "template_version": 26,
        "seepage_bc": {"specified_heads": scene["heads"], "exit_face": scene["exit"]},
    }


def factor(scene: dict[str, Any], model: dict[str, Any]) -> dict[str, Any]:
    """The lowest factor of circles by a method, and the number of circles that it could not solve."""
    model["circles"] = generate_starting_circles(model)
    found = run_lem_analysis(model, scene["method"], grid_seed=scene["grid"])
    counts = found["search"]["unsolved"]
    return {"factor": float(found["results"]["FS"]), "circles": counts["attempted"], "unsolved": counts["unsolved"]}


def discharge(scene: dict[str, Any], model: dict[str, Any]) -> dict[str, Any]:
    """The flow rate, with quadrilaterals in columns from the base to the ground surface."""
    low_x, low_y, high_x, high_y = model["domain_polygon"].bounds
    ground, size = np.array(model["ground_surface"].coords), scene["size"]
    across, up = (1 + round((high - low) / size) for low, high in ((low_x, high_x), (low_y, high_y)))
    x = np.linspace(low_x, high_x, across)
    share = np.linspace(0.0, 1.0, up)
    nodes = np.array([(a, low_y + s * (top - low_y)) for a, top in zip(x, np.interp(x, *ground.T)) for s in share])
    corners = np.add.outer(np.arange(across - 1) * up, np.arange(up - 1)).ravel()
    cells = corners[:, None] + [0, up, up + 1, 1] + np.zeros((1, 4), int)
    cells = np.pad(cells, ((0, 0), (0, 5)))
    mesh = {"nodes": nodes, "elements": cells, "element_types": np.full(len(cells), 4), "element_materials": np.ones(len(cells), int)}
    found = run_seepage_analysis(build_seep_data(mesh, model))
    return {"discharge": float(found["flowrate"]), "converged": bool(found["converged"]), "cells": len(cells)}


def main() -> int:
    """Compute and print."""
    scene = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    warnings.simplefilter("ignore")
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        model = model_of(scene)
        figures = discharge(scene, model) if scene["method"] == "seepage" else factor(scene, model)
    warned = [line.partition("] ")[2] for line in said.getvalue().splitlines() if "⚠" in line or "WARNING" in line]
    figures["said"] = [line.rstrip(".") for line in warned]
    print(json.dumps(figures))
    return 0


if __name__ == "__main__":
    sys.exit(main())
