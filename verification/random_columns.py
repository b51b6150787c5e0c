#!/usr/bin/env python3
"""Random layered columns that consolidate by default settings: are settlement and pore pressure those of the theory?

    verification/random_columns.py [--count 20] [--seed 1] [--only N ...] [--program build/qsmpm] [--keep DIR] [--markdown FILE]

Two to five layers of clay and sand, permeabilities over six powers of ten, thin seams in a third of the scenes, the base open or closed, water at the surface;
a load in one to three phases over some time, each followed by a wait, the last one removed in a third of the scenes. The deck names no element, no method and
no steps. The theory is Terzaghi's with layers: finite volumes in space (at least 40 a layer), exact in time by eigenvectors.

A scene passes if the settlement at the end of each phase is within 3 % of the largest one, and the excess pressure in the middle of each layer of clay within
5 % of the largest load (beside its range within a quarter of a cell or layer: the history is that of the nearest material point), or if a warning in the log
or an error (exit codes 2 and 3) reports that it is not. Closes with `N passed, N failed`.
"""

from __future__ import annotations

import csv
import math
import pathlib
import random
import sys
from dataclasses import dataclass

import numpy as np

TOP = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(TOP / "tools"))
from qsmpm_verify.cpu_limit import run_limited  # noqa: E402
from qsmpm_verify.trouble import Trouble  # noqa: E402
from random_grounds import run_scenes  # noqa: E402

SECONDS = 120.0
OF_WATER = 9.81
MOST_SETTLED, MOST_PRESSED = 0.03, 0.05
# Warnings of too large an outflow, or of none.
REPORTED = ("drains to more permeable soil", "hardly any water drains")


@dataclass
class Layer:
    """A layer: its ends, Young's modulus and permeability."""

    low: float
    high: float
    young: float
    permeability: float

    @property
    def modulus(self) -> float:
        """Modulus of confined compression, Poisson's ratio 0.3."""
        return self.young * 0.7 / (1.3 * 0.4)

    @property
    def is_clay(self) -> bool:
        """Whether its pressures are compared."""
        return self.permeability < 1e-2


@dataclass
class Column:
    """A scene: layers from the base (0) upwards, phases of time and load at their end."""

    layers: list[Layer]
    cells: int
    open_base: bool
    phases: list[tuple[float, float]]

    @property
    def height(self) -> float:
        """Height of the ground."""
        return self.layers[-1].high

    def __str__(self) -> str:
        what = "/".join(("clay" if layer.is_clay else "sand") + f" {layer.high - layer.low:.2g}" for layer in reversed(self.layers))
        return f"{what}, {'open' if self.open_base else 'closed'} base, {len(self.phases) // 2} loads, {self.cells} cells"

    def deck(self) -> str:
        """The deck."""
        cell = self.height / self.cells
        text = f"*UNITS, LENGTH=m, FORCE=kN\n*MODEL, TYPE=PLANE STRAIN\n*GRID\nX, 0, {2 * cell:.8g}, 2\nY, 0, {self.height:.8g}, {self.cells}\n"
        text += f"*NSET, NSET=base, PLANE=Y\n0\n*NSET, NSET=left, PLANE=X\n0\n*NSET, NSET=right, PLANE=X\n{2 * cell:.8g}\n"
        for i, layer in enumerate(self.layers):
            text += f"*MATERIAL, NAME=soil{i}\n*ELASTIC\n{layer.young:.6g}, 0.3\n*MOHR COULOMB\n10, 30, 0\n*UNIT WEIGHT\n18, 19\n"
            text += f"*PERMEABILITY\n{layer.permeability:.6g}\n"
            text += f"*BODY, NAME=layer{i}, MATERIAL=soil{i}, SHAPE=BOX\n0, {2 * cell:.8g}, {layer.low:.8g}, {layer.high:.8g}\n"
        text += f"*SURFACE, NAME=top, TYPE=BOX\n0, {2 * cell:.8g}, {self.height:.8g}, {self.height:.8g}\n"
        text += f"*HISTORY, NAME=top, QUANTITY=DISPLACEMENT, COMPONENT=Y\n{cell:.8g}, {self.height:.8g}\n"
        for i, layer in enumerate(self.layers):
            text += f"*HISTORY, NAME=p{i}, QUANTITY=PORE PRESSURE\n{cell:.8g}, {0.5 * (layer.low + layer.high):.8g}\n"
        text += f"*PHASE, NAME=ground\n*INITIAL, TYPE=K0\n{self.height:.8g}, 0.5\n*FIX\nbase, ALL\nleft, X\nright, X\n*GRAVITY\n0, -1\n"
        text += f"*WATER LEVEL, UNIT WEIGHT={OF_WATER}\n0, {self.height:.8g}\n*CONTROLS, STEPS=1\n*END PHASE\n"
        for k, (time, load) in enumerate(self.phases):
            text += f"*PHASE, NAME=phase{k}, TIME={time:.6g}\n"
            if k == 0:
                text += f"*RESET DISPLACEMENTS\n*CONSOLIDATION, UNIT WEIGHT={OF_WATER}\n" + ("base, OPEN\n" if self.open_base else "")
            before = self.phases[k - 1][1] if k else 0.0
            text += f"*PRESSURE, SURFACE=top\n{load:.6g}\n" if abs(load - before) > 0.0 else ""
            text += "*END PHASE\n"
        return text

    def theory(self) -> tuple[list[float], list[list[tuple[float, float]]]]:
        """Settlement, and range of the excess pressure around the middle of the layers, at the end of each phase."""
        sizes, resistance, compliance, middles = [], [], [], []
        for layer in self.layers:
            n = 2 * max(20, round(60 * (layer.high - layer.low) / self.height)) + 1
            size = (layer.high - layer.low) / n
            near = max(1, round(0.25 * min(self.height / self.cells, layer.high - layer.low) / size))
            middles.append(slice(len(sizes) + n // 2 - near, len(sizes) + n // 2 + near + 1))
            sizes += [size] * n
            resistance += [0.5 * size * OF_WATER / layer.permeability] * n
            compliance += [size / layer.modulus] * n
        m = len(sizes)
        storage, flow = np.array(compliance), np.zeros((m, m))
        for i in range(m - 1):
            k = 1.0 / (resistance[i] + resistance[i + 1])
            flow[i, i] += k
            flow[i + 1, i + 1] += k
            flow[i, i + 1] -= k
            flow[i + 1, i] -= k
        flow[-1, -1] += 1.0 / resistance[-1]
        if self.open_base:
            flow[0, 0] += 1.0 / resistance[0]
        root = np.sqrt(storage)
        rates, modes = np.linalg.eigh(flow / np.outer(root, root))
        rates = np.maximum(rates, 1e-14 * rates[-1])
        ones, state = modes.T @ root, np.zeros(m)
        settled, pressed, before = [], [], 0.0
        for time, load in self.phases:
            decay = np.exp(-rates * time)
            state = decay * state + (load - before) / time * (1.0 - decay) / rates * ones
            pressure = modes @ state / root
            settled.append(float(np.sum(storage * (load - pressure))))
            pressed.append([(float(min(pressure[part])), float(max(pressure[part]))) for part in middles])
            before = load
        return settled, pressed


def column(number: int, seed: int) -> Column:
    """A scene by its number."""
    chance = random.Random(f"column {seed} {number}")
    count, at, layers = chance.randint(2, 5), 0.0, []
    seam = chance.randint(0, count - 1) if chance.random() < 0.33 else -1
    clay = chance.random() < 0.5
    for i in range(count):
        clay = not clay if chance.random() < 0.7 else clay
        thick = chance.uniform(0.1, 0.4) if i == seam else chance.uniform(0.8, 5.0)
        permeability = 10.0 ** (chance.uniform(-5.0, -3.0) if clay else chance.uniform(-1.0, 1.0))
        young = 10.0 ** (chance.uniform(3.3, 4.0) if clay else chance.uniform(4.0, 4.7))
        layers.append(Layer(at, at + thick, young, permeability))
        at += thick
    cells = chance.randint(8, 20)
    weakest = min(layer.modulus for layer in layers)
    # Time in which the slowest layer drains.
    slow = max((layer.high - layer.low) ** 2 * OF_WATER / (layer.permeability * layer.modulus) for layer in layers)
    loads, load = [], 0.0
    for i in range(chance.randint(1, 3)):
        load = 0.0 if i == 2 and chance.random() < 0.5 else load + 0.01 * weakest * chance.uniform(0.2, 1.0)
        loads += [(slow * 10.0 ** chance.uniform(-3.5, -0.5), load), (slow * 10.0 ** chance.uniform(-2.0, 0.0), load)]
    return Column(layers, cells, chance.random() < 0.4, loads)


@dataclass
class Result:
    """What came out of a scene."""

    number: int
    scene: Column
    settled: float
    pressed: float
    seconds: float
    said: list[str]
    code: int

    @property
    def held(self) -> bool:
        """Whether the scene is right, or reported."""
        right = self.code == 0 and self.settled <= MOST_SETTLED and self.pressed <= MOST_PRESSED
        return right or self.code in (2, 3) or any(words in line for line in self.said for words in REPORTED)

    def row(self) -> str:
        """The row of the table."""
        notes = [line.removeprefix("warning: ")[:110] for line in self.said] + ([f"exit code {self.code}"] if self.code else [])
        return f"| {self.number} | {self.scene} | {self.settled:.1%} | {self.pressed:.1%} | {self.seconds:.1f} | {'; '.join(notes)} |"


def solve(_: str, number: int, seed: int, program: pathlib.Path, folder: pathlib.Path) -> Result:
    """Runs a scene."""
    scene = column(number, seed)
    deck, out = folder / f"column_{seed}_{number}.inp", folder / f"column_{seed}_{number}"
    deck.write_text(scene.deck())
    ended = run_limited([program, "run", deck, "--out", out, "--quiet"], SECONDS)
    if ended.code is None:
        raise Trouble(ended.how)
    log = (out / "job.log").read_text().splitlines() if (out / "job.log").is_file() else [ended.errors]
    said = list(dict.fromkeys(line for line in log if line.startswith("warning: "))) + (log[-1:] if ended.code else [])
    settled = pressed = math.nan
    if ended.code == 0:
        with (out / "curves.csv").open(encoding="utf-8") as file:
            rows = list(csv.reader(file))
        names = [name.split(" [")[0].strip() for name in rows[0]]
        ends = {int(row[names.index("phase")]): dict(zip(names, map(float, row), strict=True)) for row in rows[1:]}
        theory, pressures = scene.theory()
        largest, load = max(map(abs, theory)), max(load for _, load in scene.phases)
        settled = max(abs(-ends[k + 2]["top"] - theory[k]) for k in range(len(theory))) / largest
        clay = [i for i, layer in enumerate(scene.layers) if layer.is_clay]
        found = [(ends[k + 2][f"p{i}"] - ends[1][f"p{i}"], pressures[k][i]) for k in range(len(theory)) for i in clay]
        pressed = max((max(low - value, value - high, 0.0) for value, (low, high) in found), default=0.0) / load
    return Result(number, scene, settled, pressed, ended.cpu, said, ended.code)


def main() -> int:
    head = ["| scene | ground | settlement off | pressure off | CPU s | log |", "|---|---|---|---|---|---|"]
    return run_scenes(__doc__, ["column"], solve, head, "Layered columns that consolidate")


if __name__ == "__main__":
    sys.exit(main())
