"""The model of a completed finite element run in the form another program requires: mesh, material, constraints, loads.

Everything is read from the output of the run: the fully resolved deck, the mesh of results.h5 and the nodes at the end in
restart.h5. The scene is therefore defined once, in the deck, and the other program uses the same nodes and cells.
A keyword that is not supported here is an error: nothing is omitted silently.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from qsmpm_verify.peers_loads import EDGES, outer_edges, traction_forces
from qsmpm_verify.results import Array, read_mesh
from qsmpm_verify.trouble import Trouble

UNDERSTOOD = {
    "HEADING", "UNITS", "MODEL", "METHOD", "SOLVER", "FIELD", "RESTART", "GRID", "MESH", "NSET", "SURFACE", "MATERIAL",
    "ELASTIC", "UNIT WEIGHT", "VOLUMETRIC LOCKING", "BODY", "POINTS", "HISTORY", "PHASE", "INITIAL", "FIX", "TRACTION",
    "GRAVITY", "PERMEABILITY", "CONSOLIDATION",
    "CONTROLS", "END PHASE",
}  # fmt: skip
"""Supported keywords of an elastic scene of one body and one phase."""


@dataclass(frozen=True)
class Block:
    """A keyword of a deck with its parameters and its data lines."""

    keyword: str
    parameters: dict[str, str]
    lines: list[list[str]]


@dataclass(frozen=True)
class Flow:
    """Transient groundwater flow: permeability over the unit weight of water, drained nodes, time and steps of the ramp."""

    mobility: float
    open: Array
    duration: float
    steps: int


@dataclass(frozen=True)
class Model:
    """An elastic plane-strain model on a mesh of one cell type. Node and cell numbers start at 0."""

    nodes: Array
    cells: Array
    vtk_type: int
    young: float
    poisson: float
    #: Weight of a unit volume times the factor of gravity, along x and y.
    weight: tuple[float, float]
    #: Node and direction (0 or 1) of what is held.
    held: list[tuple[int, int]]
    #: Dead loads of nodes (nodes, 2).
    forces: Array
    #: Places whose displacement the run records, by the name of the column: node, direction, scale.
    places: dict[str, tuple[int, int, float]]
    flow: Flow | None = None


@dataclass(frozen=True)
class Solution:
    """Displacements (nodes, 2), total reactions of the supports (nan if not available) and excess pore pressures of all nodes."""

    displacement: Array
    reaction: Array
    pressure: Array | None = None


def read_blocks(text: str) -> list[Block]:
    """Blocks of a resolved deck; a line that ends in a comma continues on the next line."""
    text = re.sub(r",[ \t]*\n", ", ", text)
    blocks: list[Block] = []
    for line in text.splitlines():
        if not line.strip() or line.startswith("**"):
            continue
        words = [word.strip() for word in line.split(",")]
        if line.startswith("*"):
            pairs = (word.partition("=") for word in words[1:])
            blocks.append(Block(words[0][1:].upper(), {key.strip().upper(): value.strip() for key, _, value in pairs}, []))
        elif blocks:
            blocks[-1].lines.append(words)
    return blocks


def _one(blocks: list[Block], keyword: str) -> Block:
    found = [block for block in blocks if block.keyword == keyword]
    if len(found) != 1:
        raise Trouble(f"a scene for another program requires one *{keyword}, not {len(found)}")
    return found[0]


def _named(blocks: list[Block], keyword: str, key: str, name: str) -> Block:
    for block in blocks:
        if block.keyword == keyword and block.parameters.get(key, "").lower() == name.lower():
            return block
    raise Trouble(f"*{keyword}, {key}={name} is not in the deck")


def _inside_box(points: Array, words: list[str]) -> Array:
    """Marks the points in a box x1, x2, y1, y2, boundary included."""
    limits = np.array([float(word) for word in words[:4]]).reshape(2, 2)
    slack = 1e-9 * np.ptp(points, axis=0).max()
    return ((points >= limits[:, 0] - slack) & (points <= limits[:, 1] + slack)).all(axis=1)


def node_set(blocks: list[Block], name: str, nodes: Array) -> Array:
    """Nodes of a set defined by a plane or a box."""
    block = _named(blocks, "NSET", "NSET", name)
    if "PLANE" in block.parameters:
        axis = "XY".index(block.parameters["PLANE"].upper())
        place = float(block.lines[0][0])
        return np.flatnonzero(np.abs(nodes[:, axis] - place) < 1e-9 * np.ptp(nodes, axis=0).max())
    if "BOX" in block.parameters:
        return np.flatnonzero(_inside_box(nodes, block.lines[0]))
    raise Trouble(f"node set {name}: only sets by PLANE and BOX are supported for another program")


def _held(blocks: list[Block], nodes: Array) -> list[tuple[int, int]]:
    held: set[tuple[int, int]] = set()
    for block in blocks:
        for words in block.lines if block.keyword == "FIX" else ():
            for node in node_set(blocks, words[0], nodes):
                held |= {(int(node), "XY".index(axis.upper())) for axis in words[1:]}
    return sorted(held)


def _forces(blocks: list[Block], nodes: Array, cells: Array, vtk_type: int, factor: float) -> Array:
    forces = np.zeros_like(nodes)
    for block in blocks:
        if block.keyword != "TRACTION":
            continue
        surface = _named(blocks, "SURFACE", "NAME", block.parameters["SURFACE"])
        if surface.parameters.get("TYPE", "").upper() != "BOX":
            raise Trouble(f"surface {block.parameters['SURFACE']}: only TYPE=BOX is supported for another program")
        inside = set(np.flatnonzero(_inside_box(nodes, surface.lines[0])).tolist())
        edges = [edge for edge in outer_edges(cells, vtk_type) if inside.issuperset(edge)]
        if not edges:
            raise Trouble(f"surface {block.parameters['SURFACE']}: it contains no edge of a cell")
        forces += traction_forces(nodes, edges, factor * np.array([float(word) for word in block.lines[0][:2]]))
    return forces


def _weight(blocks: list[Block], factor: float) -> tuple[float, float]:
    gravity = [block for block in blocks if block.keyword == "GRAVITY"]
    if not gravity:
        return 0.0, 0.0
    unit = float(_one(blocks, "UNIT WEIGHT").lines[0][0])
    x, y = (float(word) for word in gravity[-1].lines[0][:2])
    return factor * unit * x, factor * unit * y


def _places(blocks: list[Block], nodes: Array) -> dict[str, tuple[int, int, float]]:
    places = {}
    for block in blocks:
        if block.keyword != "HISTORY" or block.parameters["QUANTITY"].upper() != "DISPLACEMENT":
            continue
        place = np.array([float(word) for word in block.lines[0][:2]])
        distance = np.linalg.norm(nodes - place, axis=1)
        node = int(distance.argmin())
        if distance[node] > 1e-9 * np.ptp(nodes, axis=0).max():
            raise Trouble(f"history {block.parameters['NAME']}: there is no node of the mesh at its position")
        axis = "XY".index(block.parameters["COMPONENT"].upper())
        places[block.parameters["NAME"]] = (node, axis, float(block.parameters.get("SCALE", "1")))
    return places


def _flow(blocks: list[Block], nodes: Array) -> Flow | None:
    if not any(block.keyword == "CONSOLIDATION" for block in blocks):
        return None
    card, phase = _one(blocks, "CONSOLIDATION"), _one(blocks, "PHASE").parameters
    along, up = (float(word) for word in _one(blocks, "PERMEABILITY").lines[0][:2])
    if along != up or float(card.parameters.get("STORAGE", "0")) or any(row[1] != "OPEN" for row in card.lines):
        raise Trouble("for another program only a single permeability, no storage and OPEN sets are supported")
    chosen = np.unique(np.concatenate([node_set(blocks, row[0], nodes) for row in card.lines]))
    steps = int(_one(blocks, "CONTROLS").parameters["STEPS"])
    return Flow(along / float(card.parameters["UNIT WEIGHT"]), chosen, float(phase["TIME"]), steps)


def _used_mesh(results: Path) -> tuple[Array, Array, int, Array]:
    """Nodes, cells, VTK type of the cells of the body, and the numbers of their nodes in the mesh of the run."""
    mesh = read_mesh(results)
    with h5py.File(results / "restart.h5", "r") as file:
        used = np.unique(file["points/cell"][...]) - 1
    if len(set(mesh.types[used].tolist())) != 1:
        raise Trouble(f"{results}: cells of more than one type")
    kind = int(mesh.types[used[0]])
    if kind not in EDGES:
        raise Trouble(f"{results}: cells of VTK type {kind} are not supported for another program")
    labels = np.array([mesh.cells[cell] for cell in used])
    kept, renumbered = np.unique(labels, return_inverse=True)
    return mesh.nodes[kept, :2], renumbered.reshape(labels.shape), kind, kept


def _check_scene(blocks: list[Block]) -> None:
    for block in blocks:
        if block.keyword not in UNDERSTOOD:
            raise Trouble(f"*{block.keyword} is not supported for another program")
    if _one(blocks, "MODEL").parameters.get("TYPE", "").upper() != "PLANE STRAIN":
        raise Trouble("only plane strain is supported for another program")
    if _one(blocks, "METHOD").parameters.get("BASIS", "").upper() != "FEM":
        raise Trouble("only a run with BASIS=FEM has a body-fitted mesh")


def read_model(results: Path) -> Model:
    """The model of a run folder."""
    echoes = sorted(results.glob("*.echo.inp"))
    if len(echoes) != 1:
        raise Trouble(f"{results}: no resolved deck")
    blocks = read_blocks(echoes[0].read_text(encoding="utf-8"))
    _check_scene(blocks)
    nodes, cells, kind, _ = _used_mesh(results)
    factor = float(_one(blocks, "PHASE").parameters.get("LOAD FACTOR", "1"))
    young, poisson = (float(word) for word in _one(blocks, "ELASTIC").lines[0][:2])
    return Model(
        nodes, cells, kind, young, poisson, _weight(blocks, factor), _held(blocks, nodes),
        _forces(blocks, nodes, cells, kind, factor), _places(blocks, nodes), _flow(blocks, nodes),
    )  # fmt: skip


def read_own(results: Path) -> Solution:
    """The results of the run itself at the nodes of its model."""
    nodes, _, _, kept = _used_mesh(results)
    with h5py.File(results / "restart.h5", "r") as file:
        now, reactions = file["mesh/coordinates"][...], file["mesh/reactions"][...]
        water = file["terms/excess_pore_pressure"][...].ravel()[kept] if "terms/excess_pore_pressure" in file else None
    if len(now) <= kept.max():
        raise Trouble(f"{results}: restart.h5 contains {len(now)} nodes, the mesh more")
    return Solution(now[kept] - nodes, reactions.sum(axis=0), water)
