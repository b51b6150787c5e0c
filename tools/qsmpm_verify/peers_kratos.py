"""Kratos Multiphysics: its structural application on the mesh of a model, and the scripts for its MPM application.

Both run in the environment of `tools/setup --peers` (.venv-peers), as separate processes;
the variable QSMPM_PEERS_PYTHON names another interpreter.
"""

from __future__ import annotations

import json
import os
import subprocess
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from qsmpm_verify.peers_model import Model, Solution
from qsmpm_verify.peers_runs import Finished, run_peer
from qsmpm_verify.places import TOP
from qsmpm_verify.runner import last_line
from qsmpm_verify.trouble import RunFailed, Trouble

PYTHON = Path(os.environ.get("QSMPM_PEERS_PYTHON", TOP / ".venv-peers" / "bin" / "python"))
"""The interpreter with Kratos."""
SCRIPTS = TOP / "tools" / "peers"
PACKAGES = ("KratosMultiphysics", "KratosMPMApplication", "KratosStructuralMechanicsApplication")
ELEMENTS = {5: "2D3N", 9: "2D4N", 22: "2D6N", 23: "2D8N"}
"""Suffixes of the element names, by VTK type."""


@lru_cache(maxsize=1)
def version() -> str:
    """`Kratos 10.4.4`; empty when it is not installed with both applications."""
    ask = "from importlib.metadata import version; print(*[version(name) for name in {!r}])".format(PACKAGES)
    try:
        answer = subprocess.run([str(PYTHON), "-c", ask], capture_output=True, text=True, timeout=60, check=True).stdout
    except (OSError, subprocess.SubprocessError):
        return ""
    return f"Kratos {answer.split()[0]}"


def scene_text(model: Model, element: str, steps: int) -> str:
    """The model in the format of kratos_fem.py; `element` is SmallDisplacementElement or TotalLagrangianElement."""
    loads = [[int(node), *model.forces[node].tolist()] for node in np.flatnonzero(np.abs(model.forces).sum(axis=1))]
    return json.dumps({
        "nodes": model.nodes.tolist(), "cells": model.cells.tolist(), "held": model.held, "forces": loads,
        "weight": model.weight, "young": model.young, "poisson": model.poisson, "steps": steps,
        "law": "LinearElasticPlaneStrain2DLaw", "element": element + ELEMENTS[model.vtk_type],
    })  # fmt: skip


def solve(
    model: Model, folder: Path, element: str = "SmallDisplacementElement", steps: int = 1, fresh: bool = False
) -> tuple[Solution, Finished]:
    """Run the structural application on a model."""
    _installed()
    files = {"model.json": scene_text(model, element, steps)}
    script = (SCRIPTS / "kratos_fem.py").read_text(encoding="utf-8")
    command = [str(PYTHON), str(SCRIPTS / "kratos_fem.py"), "model.json", "result.json"]
    run = run_peer(command, version() + script, files, ["result.json"], folder, fresh=fresh)
    result = json.loads((folder / "result.json").read_text(encoding="utf-8"))
    return Solution(np.array(result["displacement"]), np.array(result["reaction"])), run


def run_script(words: list[str], folder: Path, seconds: float, fresh: bool = False) -> tuple[dict[str, Any], Finished]:
    """Run a script of tools/peers; its last line is a JSON object."""
    _installed()
    texts = "".join((SCRIPTS / name).read_text(encoding="utf-8") for name in (words[0], "kratos_scene.py"))
    command = [str(PYTHON), str(SCRIPTS / words[0]), *words[1:]]
    run = run_peer(command, version() + texts, {}, ["terminal.txt"], folder, seconds, fresh)
    line = last_line(folder / "terminal.txt")
    try:
        return json.loads(line), run
    except ValueError as error:
        raise RunFailed(f"{words[0]}: its last line is not JSON: {line[:80]}") from error


def _installed() -> None:
    if not version():
        raise Trouble("Kratos is not installed")
