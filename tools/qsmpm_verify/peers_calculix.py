"""CalculiX (ccx): write its input from a model, run it, read displacements and reactions.

Plane cells are converted to CPE elements, which ccx expands to solids of unit thickness. Its `*ELASTIC` is linear between
Lagrange strain and second Piola-Kirchhoff stress in a step with NLGEOM; its neo-Hooke law is selectable. ccx prints
seven digits. It is run as a separate program; no part of it is linked or distributed (docs/licences.md).
"""

from __future__ import annotations

import re
import shutil
import subprocess
from functools import lru_cache
from pathlib import Path

import numpy as np

from qsmpm_verify.peers_loads import weight_forces
from qsmpm_verify.peers_model import Model, Solution
from qsmpm_verify.peers_runs import Finished, run_peer
from qsmpm_verify.trouble import RunFailed, Trouble

ELEMENTS = {5: "CPE3", 9: "CPE4", 22: "CPE6", 23: "CPE8"}
"""Default element of a VTK type; CPE8R and CPE4R have reduced integration."""
NODES = {"CPE3": 3, "CPE4": 4, "CPE4R": 4, "CPE6": 6, "CPE8": 8, "CPE8R": 8}
LAWS = ("ELASTIC", "NEO HOOKE")
TIGHT = "*CONTROLS, PARAMETERS=FIELD\n1.E-7, 1.E-7"
"""Largest residual and correction of the last iteration; the defaults of ccx are 5E-3 and 1E-2."""


@lru_cache(maxsize=1)
def version() -> str:
    """`CalculiX 2.20`; empty when it is not installed."""
    program = shutil.which("ccx")
    if program is None:
        return ""
    try:
        answer = subprocess.run([program, "-v"], capture_output=True, text=True, timeout=20, check=False).stdout
    except (OSError, subprocess.TimeoutExpired):
        return ""
    hit = re.search(r"[Vv]ersion\s+(\S+)", answer)
    return f"CalculiX {hit[1]}" if hit else ""


def _law(model: Model, law: str) -> list[str]:
    if law == "ELASTIC":
        return ["*ELASTIC", f"{model.young:.12G}, {model.poisson:.12G}"]
    if law == "NEO HOOKE":
        shear = model.young / (2 * (1 + model.poisson))
        bulk = model.young / (3 * (1 - 2 * model.poisson))
        return ["*HYPERELASTIC, NEO HOOKE", f"{shear / 2:.12G}, {2 / bulk:.12G}"]
    raise Trouble(f"CalculiX: unknown law '{law}'; known are {', '.join(LAWS)}")


def _step(model: Model, increments: int) -> list[str]:
    """The only step: linear if `increments` is 0, otherwise with NLGEOM in at least that many increments."""
    lines = ["*STEP", "*STATIC"]
    if increments:
        lines = ["*STEP, NLGEOM, INC=10000", "*STATIC", f"{1 / increments:.9G}, 1., 1.E-6, {1 / increments:.9G}", TIGHT]
    size = float(np.hypot(*model.weight))
    if size > 0:
        x, y = np.array(model.weight) / size
        lines += ["*DLOAD", f"body, GRAV, 1., {x:.12G}, {y:.12G}, 0."]
    loads = [(node, axis) for node, axis in np.argwhere(model.forces)]
    if loads:
        lines += ["*CLOAD", *(f"{node + 1}, {axis + 1}, {model.forces[node, axis]:.12E}" for node, axis in loads)]
    often = ", FREQUENCY=10000" if increments else ""
    return [*lines, f"*NODE PRINT, NSET=all{often}", "U", f"*NODE PRINT, NSET=held, TOTALS=ONLY{often}", "RF", "*END STEP"]


def input_text(model: Model, element: str = "", law: str = "ELASTIC", increments: int = 0) -> str:
    """The input of ccx for a model."""
    element = element or ELEMENTS[model.vtk_type]
    if NODES.get(element) != model.cells.shape[1]:
        raise Trouble(f"CalculiX: {element} is not an element with {model.cells.shape[1]} nodes; known are {', '.join(NODES)}")
    size = float(np.hypot(*model.weight))
    held = sorted({node for node, _ in model.held})
    return "\n".join([
        "*NODE, NSET=all", *(f"{i}, {x:.12E}, {y:.12E}, 0." for i, (x, y) in enumerate(model.nodes, 1)),
        f"*ELEMENT, TYPE={element}, ELSET=body",
        *(f"{i}, " + ", ".join(str(node + 1) for node in cell) for i, cell in enumerate(model.cells, 1)),
        "*NSET, NSET=held", *(f"{node + 1}," for node in held),
        "*MATERIAL, NAME=elastic", *_law(model, law), *(["*DENSITY", f"{size:.12G}"] if size > 0 else []),
        "*SOLID SECTION, ELSET=body, MATERIAL=elastic", "1.",
        "*BOUNDARY", *(f"{node + 1}, {axis + 1}, {axis + 1}" for node, axis in model.held),
        *_step(model, increments), "",
    ])  # fmt: skip


def read_dat(text: str) -> tuple[np.ndarray, np.ndarray, float]:
    """Displacements (nodes, 2), total force (2) and time of the last increment printed in a .dat file."""
    number = r"[-+]?\d+\.\d+(?:[EeDd][-+]?\d+)?"
    parts = re.split(rf"^ *(displacements|total force) .*?time +({number}) *$", text, flags=re.MULTILINE)
    last = {what: (float(time), body) for what, time, body in zip(parts[1::3], parts[2::3], parts[3::3])}
    if set(last) != {"displacements", "total force"}:
        raise RunFailed("CalculiX printed no displacements or no forces")
    time, body = last["displacements"]
    rows = np.array([[float(word) for word in line.split()] for line in body.splitlines() if line.strip()])
    if not np.array_equal(rows[:, 0], np.arange(1, len(rows) + 1)):
        raise RunFailed("CalculiX printed other nodes than those of the model")
    force = np.array([float(word) for word in last["total force"][1].split()])
    return rows[:, 1:3], force[:2], time


def loads_of_supports(model: Model) -> np.ndarray:
    """Loads on supported nodes themselves (2).

    ccx prints the internal forces of these nodes, which do not include loads and weights that act on them directly.
    """
    held = sorted({node for node, _ in model.held})
    loads = model.forces + weight_forces(model.nodes, model.cells, model.vtk_type, model.weight)
    return loads[held].sum(axis=0)


def solve(
    model: Model, folder: Path, element: str = "", law: str = "ELASTIC", increments: int = 0, fresh: bool = False
) -> tuple[Solution, Finished]:
    """Run ccx on a model."""
    program = shutil.which("ccx")
    if program is None:
        raise Trouble("CalculiX is not installed")
    files = {"model.inp": input_text(model, element, law, increments)}
    run = run_peer([program, "model"], version(), files, ["model.dat"], folder, fresh=fresh)
    moved, force, time = read_dat((folder / "model.dat").read_text(encoding="utf-8", errors="replace"))
    if abs(time - 1) > 1e-6:
        raise RunFailed(f"{folder.name}: CalculiX ended at load fraction {time:g}")
    return Solution(moved, force - loads_of_supports(model)), run
