"""xslope: limit equilibrium with slip circles, and steady seepage, for the ground, strengths and water of a deck; and the bounds of the same deck.

The scene is that of limit analysis of a deck (docs/methods/bounds.md), with the same strengths: those of the deck where
psi = phi, otherwise after Davis. It runs in the environment of tools/setup --peers, as a separate process.
"""

from __future__ import annotations

import json
import subprocess
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from qsmpm_verify.bounds.flow import Flow
from qsmpm_verify.bounds.phases import read_scene
from qsmpm_verify.bounds.scene import Scene
from qsmpm_verify.bounds.words import name_of
from qsmpm_verify.peers_kratos import PYTHON, SCRIPTS
from qsmpm_verify.peers_runs import Finished, run_peer
from qsmpm_verify.places import TOP
from qsmpm_verify.results import Array
from qsmpm_verify.runner import last_line
from qsmpm_verify.study.cards import Deck, read_deck
from qsmpm_verify.trouble import RunFailed, Trouble

METHODS = ("bishop", "spencer", "mprice", "janbu", "oms", "seepage")
SCRIPT = SCRIPTS / "xslope_run.py"


@lru_cache(maxsize=1)
def version() -> str:
    """`xslope 1.0.5`; empty when it is not installed."""
    ask = "from importlib.metadata import version; print(version('xslope'))"
    try:
        answer = subprocess.run([str(PYTHON), "-c", ask], capture_output=True, text=True, timeout=60, check=True).stdout
    except (OSError, subprocess.SubprocessError):
        return ""
    return f"xslope {answer.strip()}"


def _material(name: str, scene: Scene, k: float, gravity: float) -> dict[str, Any]:
    """Effective strength, unit weights and permeability; suction law as in QSMPM: linear down to a thousandth over half a cell."""
    material = scene.materials[name]
    strength = material.strength
    if strength is None or strength.profile is not None:
        raise Trouble(f"xslope: material '{name}' has no *MOHR COULOMB with uniform cohesion")
    share, phi = (1.0, np.radians(strength.friction)) if not strength.reduced() else strength.at(1.0, scene.flow)
    suction = 0.5 * min(float(np.diff(lines).min()) for lines in scene.steps)
    return {
        "name": name, "gamma": gravity * material.weight, "gamma_sat": gravity * material.saturated,
        "c": share * strength.cohesion, "phi": float(np.degrees(phi)),
        "k1": k, "k2": k, "alpha": 0.0, "unsat": "lf", "kr0": 1e-3, "h0": -suction,
    }  # fmt: skip


def _in_air(outline: Array, steps: tuple[Array, Array]) -> list[list[float]]:
    """The outline without the parts on the base and the sides of the grid, as one line."""
    (x, y), after = steps, np.roll(outline, -1, axis=0)
    on_grid = [
        all(abs(place[axis] - bound) < 1e-9 * np.ptp(x) for place in pair)
        for pair in zip(outline, after) for axis, bound in ((0, x[0]), (0, x[-1]), (1, y[0]))
    ]  # fmt: skip
    closed = np.array(on_grid).reshape(-1, 3).any(axis=1)
    starts = np.flatnonzero(closed & ~np.roll(closed, -1))
    if len(starts) != 1:
        raise Trouble("xslope: the ground must have one exposed surface, from end to end")
    count = int((~closed).sum())
    return [after[(starts[0] + i) % len(outline)].tolist() for i in range(count + 1)]


def _heads(flow: Flow, scene: Scene, air: list[list[float]]) -> list[dict[str, Any]]:
    """Levels at the parts of the surface inside the boxes of these parts."""
    found = []
    for row in flow.card.data():
        name = row[0].strip('"')
        low, high = scene.sets[name] if name in scene.sets else scene.surfaces[name].places
        for start, end in zip(np.array(air), np.array(air[1:])):
            if (np.minimum(start, end) >= low - 1e-9).all() and (np.maximum(start, end) <= high + 1e-9).all():
                found.append({"coords": [start.tolist(), end.tolist()], "head": float(row[1]), "kind": "reservoir"})
    return found


def scene_text(deck: Deck, phase: str | None, method: str, size: float = 0.0, grid: bool = True) -> str:
    """The scene in the format of xslope_run.py."""
    if method not in METHODS:
        raise Trouble(f"xslope: unknown method '{method}'; known are {', '.join(METHODS)}")
    scene = read_scene(deck, phase, True)
    state, water = scene.after, scene.after.water.get("")
    if set(state.tractions) | set(state.pushes) or set(state.water) - {""} or state.gravity[0] != 0.0:
        raise Trouble("xslope: only ground under self-weight with one water level is supported")
    permeability, now = {}, ""
    for card in deck.cards:
        now = name_of(card, "NAME") if card.keyword == "MATERIAL" else now
        if card.keyword == "PERMEABILITY":
            permeability[now] = float(card.data()[0][0])
    names = sorted({state.materials[body] for body in state.active})
    grounds = [{"outline": scene.bodies[b].tolist(), "material": names.index(state.materials[b])} for b in sorted(state.active)]
    content: dict[str, Any] = {
        "grounds": grounds, "materials": [_material(name, scene, permeability.get(name, 0.0), -state.gravity[1]) for name in names],
        "water": water.weight if water else 9.81, "level": [], "heads": [], "exit": [], "method": method, "size": size, "grid": grid,
    }  # fmt: skip
    if method == "seepage":
        if not isinstance(water, Flow) or len(grounds) != 1:
            raise Trouble("xslope: seepage requires one body with *WATER LEVEL, TYPE=SEEPAGE")
        air = _in_air(np.array(grounds[0]["outline"]), scene.steps)
        content |= {"exit": air, "heads": _heads(water, scene, air)}
    elif isinstance(water, Flow):
        raise Trouble("xslope: circles require a water level defined by a line, or none")
    elif water:
        low, high = scene.steps[0][0], scene.steps[0][-1]
        inner = [place for place in water.corners.tolist() if low < place[0] < high]
        content["level"] = [[low, float(water.at(np.array([low, 0.0])))], *inner, [high, float(water.at(np.array([high, 0.0])))]]
    return json.dumps(content)


def solve(deck: Path, folder: Path, words: dict[str, Any], fresh: bool = False) -> tuple[dict[str, Any], Finished]:
    """Run xslope on a deck."""
    text = scene_text(read_deck(deck), words.get("phase"), words["method"], float(words.get("size", 0.0)), words.get("grid", True))
    command = [str(PYTHON), str(SCRIPT), "scene.json"]
    run = run_peer(command, version() + SCRIPT.read_text(encoding="utf-8"), {"scene.json": text}, ["terminal.txt"], folder, fresh=fresh)
    figures = dict(json.loads(last_line(folder / "terminal.txt")))
    if figures.get("converged") is False:
        raise RunFailed(f"{folder.name}: xslope: the flow did not converge")
    return figures, run


def said(figures: dict[str, Any]) -> str:
    """Remarks of the programs on a factor: bounds, or circles without a solution and warnings."""
    if "lower" in figures:
        return f"between {figures['lower']:.4f} and {figures['upper']:.4f}"
    if "circles" in figures:
        warned = "".join(f"; {line}" for line in figures["said"] if "could not solve" not in line)
        return f"{figures['unsolved']} of {figures['circles']} circles without a solution{warned}"
    return f"stable at {figures['factor']:.4f}, no equilibrium at {figures['upper']:.4f}" if "factor" in figures else ""


def bounds(deck: Path, folder: Path, words: dict[str, Any], fresh: bool = False) -> tuple[dict[str, Any], Finished]:
    """Bounds of QSMPM for the factor of a phase; `factor` is between them."""
    command = [str(TOP / "tools" / "qsmpm-verify"), "bounds", "scene.inp", "--phase", words["phase"], "--json", "bounds.json"]
    program = "".join(path.read_text(encoding="utf-8") for path in sorted((TOP / "tools/qsmpm_verify/bounds").glob("*.py")))
    run = run_peer(command, program, {"scene.inp": deck.read_text(encoding="utf-8")}, ["bounds.json"], folder, fresh=fresh)
    found = json.loads((folder / "bounds.json").read_text(encoding="utf-8"))
    lower, upper = (float(found[side]["value"]) for side in ("lower", "upper"))
    return {"factor": 0.5 * (lower + upper), "lower": lower, "upper": upper}, run
