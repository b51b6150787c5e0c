"""Groundwater flow: the heads that the program computes for a phase (docs/methods/seepage.md), linear on its own triangles.

A deck of that phase, and of the phases from which a transient flow starts, with all nodes fixed is cheap, and its material points keep
their initial positions, three in a triangle: their heads give those of the corners exactly.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import lsqr

from qsmpm_verify.bounds.heads import Heads, shares
from qsmpm_verify.bounds.scene import Level, Scene, State
from qsmpm_verify.bounds.words import PASSED, name_of
from qsmpm_verify.cpu_limit import run_limited
from qsmpm_verify.places import PROGRAM
from qsmpm_verify.results import Array, read_mesh, read_points
from qsmpm_verify.study.cards import Card, Deck
from qsmpm_verify.trouble import RunFailed

# CPU seconds that the program may take.
SECONDS = 600.0


def flows(scene: Scene) -> bool:
    """Whether there is groundwater flow at one of the ends of the phase."""
    return any(isinstance(level, Flow) for state in (scene.before, scene.after) for level in state.water.values())


@dataclass(frozen=True)
class Flow(Level):
    """Groundwater flow defined by a keyword, in a state and, if transient, the TIME of its phase after an earlier flow; it has no corners, and is
    computed when required."""

    deck: Deck
    phase: str
    card: Card
    state: State
    time: str
    before: Flow | None

    @property
    def row(self) -> list[Flow]:
        """The flows from which it starts, and itself."""
        return [*(self.before.row if self.before else []), self]

    def at(self, places: Array) -> Array:
        """Heads, instead of those of a level."""
        return self.heads.at(places.reshape(-1, 2)).reshape(places.shape[:-1])

    def lines(self, outlines: Array) -> Iterable[Array]:
        """The phreatic surface."""
        return self.heads.surface(outlines)

    @cached_property
    def heads(self) -> Heads:
        """Heads computed by the program."""
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "flow.inp").write_text(self.text(), encoding="utf-8")
            environment = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
            try:
                ended = run_limited([PROGRAM, "run", "flow.inp", "--out", "out", "--quiet"], SECONDS, Path(folder), environment)
            except OSError as error:
                raise RunFailed(f"*WATER LEVEL, TYPE=SEEPAGE: the program that computes the flow cannot be started: {error}") from error
            if ended.code != 0:
                said = "; ".join(line.split(": ", 1)[-1] for line in ended.errors.splitlines() if ": warning: " not in line)
                raise RunFailed(f"*WATER LEVEL, TYPE=SEEPAGE: phase '{self.phase}': the program found no flow ({ended.how}): {said}")
            mesh, points = read_mesh(Path(folder) / "out"), read_points(Path(folder) / "out")
        corners = np.array([cell[:3] for cell in mesh.cells])
        own, share = shares(mesh.nodes[corners, :2], points.field("position")[:, :2])
        equations = sparse.csr_matrix((share.ravel(), (np.repeat(np.arange(len(own)), 3), corners[own].ravel())), (len(own), len(mesh.nodes)))
        values = lsqr(equations, points.field("head"), atol=1e-14, btol=1e-14)[0]
        return Heads(mesh.nodes[:, :2], corners[np.unique(own)], values)

    def text(self) -> str:
        """The deck that the program runs: the model in the state, with all nodes fixed."""
        grid, idle = self.deck.find("GRID"), PASSED - {"UNITS", "ELASTIC"}
        assert grid is not None
        cards = [card for card in self.deck.cards[: [card.keyword for card in self.deck.cards].index("PHASE")] if card.keyword not in idle]
        for place, card in enumerate(cards):
            if card.keyword == "BODY":
                name = name_of(card, "NAME")
                there = "YES" if name in self.state.active else "NO"
                cards[place] = card.with_value("MATERIAL", self.state.materials[name]).with_value("ACTIVE", there)
        cards += [Card("NSET", (("NSET", "every node"), ("BOX", "")), ("-1e9, 1e9, -1e9, 1e9",))]
        for flow in self.row:
            if flow.state.active != self.state.active:
                raise RunFailed(f"phase '{self.phase}': its flow continues from one through other bodies, which bounds do not support")
            cards.append(Card("PHASE", (("NAME", flow.phase), *((("TIME", flow.time),) if flow.time else ()))))
            cards += [Card("FIX", (), ("every node, ALL",)), Card("GRAVITY", (), ("0, -1",)), flow.card, Card("CONTROLS", (("STEPS", "1"),))]
            cards += [Card("SUPPORT", (("SURFACE", name), ("TYPE", kind))) for name, kind in self.state.supports.items()] if flow is self.row[0] else []
            cards.append(Card("END PHASE"))
        return self.deck.with_cards(cards).with_card(grid.with_value("ELEMENT", "TRI6").with_value("FIT", "YES")).text()
