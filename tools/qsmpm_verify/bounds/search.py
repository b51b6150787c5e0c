"""The limit load or force of a phase, or the factor of safety at its end, from above and below; triangles are bisected where the dissipation is largest.

The factor F is that at which the margin of the strength divided by F is zero: the margin is the stress by which all cones can be reduced in equilibrium.
Its slope with F is known from the duals, so Newton's method finds F; the bound is a factor at which a computed margin has the correct sign.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace

import numpy as np

from qsmpm_verify.bounds.cone import TOLERANCE, Answer, Balance, Joint, Kind, Yield, largest
from qsmpm_verify.bounds.contact import lower_joint, upper_joint
from qsmpm_verify.bounds.layout import first_triangles
from qsmpm_verify.bounds.lower import lower_balance
from qsmpm_verify.bounds.model import Loads, Model, model_of
from qsmpm_verify.bounds.nodes import Nodes, nodes_of
from qsmpm_verify.bounds.rigid import bodies_of
from qsmpm_verify.bounds.scene import Scene
from qsmpm_verify.bounds.triangles import Triangles, cut_at, halve
from qsmpm_verify.bounds.upper import lifted, upper_balance
from qsmpm_verify.results import Array
from qsmpm_verify.trouble import RunFailed, Trouble

# Factors are found to this share.
CLOSE = 1e-4
MOST_TRIES = 12
# Triangles around a place where a load begins, and in half a circle where the face of a body does; loads that differ by less than this share are the same.
FAN, SAME = 8, 1e-6
# A lower bound above the upper one by more than this share is none, nor is the other.
ORDER = 2e-3
# Units of stress tried, each ten times the one before.
MOST_SCALES = 2


@dataclass(frozen=True)
class Bound:
    """A bound, or the status of the solver if not Solved."""

    value: float
    status: str
    seconds: float
    tries: int = 1

    @property
    def solved(self) -> bool:
        """Whether it is a bound."""
        return self.status == "Solved"


@dataclass(frozen=True)
class Mechanism:
    """Velocities of the nodes and dissipation per area in each triangle."""

    model: Model
    nodes: Nodes
    velocity: Array
    density: Array


@dataclass
class Found:
    """Results of a search."""

    kind: Kind
    upper: Bound
    lower: Bound
    triangles: int
    reduced: bool
    mechanism: Mechanism
    passes: list[tuple[int, float]] = field(default_factory=list)

    @property
    def both(self) -> bool:
        """Whether both bounds exist and are in the correct order."""
        low, high = self.lower.value, self.upper.value
        return self.upper.solved and self.lower.solved and low - high <= ORDER * max(abs(low), abs(high))


class Side:
    """One of the two bounds on a mesh, the upper one with nodes: its equilibrium, and its cones at a factor."""

    def __init__(self, model: Model, balance: Balance, kind: Kind, loads: tuple[Loads, Loads], flow: str, nodes: Nodes | None) -> None:
        above = nodes is not None
        self.model, self.kind, self.flow, self.above = model, kind, flow, above
        whole = (lifted(array) if above else array for array in (model.cohesion, loads[0].pore, loads[1].pore))
        self.cohesion, self.pore, self.more = (array.ravel() for array in whole)
        self.material = np.repeat(np.where(balance.still, -1, model.material), 3)
        size = float(np.ptp(model.mesh.places, axis=0).max())
        self.scale = max(float(self.cohesion[self.material >= 0].max()), *(load.stress(size) for load in loads), 1e-12)
        self.balance = balance
        self.stretch(self.scale)
        self.joint = upper_joint(model, nodes, flow) if nodes is not None else lower_joint(model)

    def stretch(self, by: float) -> None:
        """The equilibrium equations in a unit of stress multiplied by a factor."""
        old = self.balance
        self.balance = replace(old, dead=old.dead / by, live=old.live / by, limits=old.limits / by)

    def contact(self) -> Joint | None:
        """Tractions between soil and rigid bodies, in units of `scale`."""
        return None if self.joint is None else replace(self.joint, adhesion=self.joint.adhesion / self.scale)

    def cones(self, factor: float) -> Yield:
        """Cones of the strength divided by a factor, in units of `scale`."""
        parts: list[tuple[Array, Array, Array, Array]] = []
        for number, strength in enumerate(self.model.strengths):
            own = np.flatnonzero(self.material == number)
            share, phi = strength.at(factor, self.flow)
            head = share * self.cohesion[own] * np.cos(phi) - self.pore[own] * np.sin(phi)
            parts.append((own, head, np.full(len(own), np.sin(phi)), np.ones(len(own))))
            if strength.tension is not None:
                parts.append((own, strength.tension / factor - self.pore[own], np.ones(len(own)), np.zeros(len(own))))
        point, head, slope, margin = (np.concatenate(part) for part in zip(*parts))
        return Yield(point, head / self.scale, slope, self.more[point] / self.scale, margin)

    def raw(self, factor: float) -> Answer:
        """The result in units of `scale`."""
        return largest(self.balance, self.cones(factor), self.kind, self.contact())

    def solve(self, factor: float = 1.0) -> Answer:
        """The result in the units of the deck, at a factor; in larger units of stress if the solver does not converge."""
        answer = self.raw(factor)
        for _ in range(MOST_SCALES):
            if answer.solved:
                break
            self.scale *= 10.0
            self.stretch(10.0)
            answer = self.raw(factor)
        if self.kind is Kind.LOAD:
            return answer
        return replace(answer, value=answer.value * self.scale)

    def slope(self, answer: Answer, factor: float) -> float:
        """Change of the margin with the factor at constant duals."""
        small = 1e-6 * factor
        mean = answer.stress[:, 0]
        ends = [self.cones(factor + sign * small) for sign in (-1.0, 1.0)]
        heads = [cones.head - cones.slope * mean[cones.point] for cones in ends]
        return float(answer.rate @ (heads[1] - heads[0])) / (2.0 * small) * self.scale


def _spent(start: float) -> float:
    """CPU seconds since a time."""
    return time.process_time() - start


def find_factor(side: Side, guess: float) -> tuple[Bound, Answer]:
    """The factor at which the margin is zero, from the side on which it is a bound, by more than the tolerance of the solver."""
    start, factor, tries = time.process_time(), guess, 0
    sign = -1.0 if side.above else 1.0
    low, high = 0.0, np.inf
    best: tuple[float, Answer] | None = None
    while tries < MOST_TRIES:
        answer = side.solve(factor)
        tries += 1
        if not answer.solved:
            return Bound(np.nan, answer.status, _spent(start), tries), answer
        slack = TOLERANCE * side.scale
        low, high = (max(low, factor), high) if answer.value >= sign * slack else (low, min(high, factor))
        if answer.value * sign >= slack and (best is None or factor * sign > best[0] * sign):
            best = (factor, answer)
        slope = side.slope(answer, factor)
        root = factor - (answer.value - sign * slack) / slope if slope < 0.0 else 2.0 * factor
        near = abs(root / factor - 1.0)
        if best is not None and best[0] == factor and near < 3.0 * CLOSE:
            break
        step = np.clip(root - sign * 0.5 * CLOSE * root, 0.5 * factor, 2.0 * factor)
        factor = float(step) if low < step < high else (low + min(high, 4.0 * factor)) / 2.0
    if best is None:
        return Bound(np.nan, "NoFactor", _spent(start), tries), answer
    return Bound(best[0], "Solved", _spent(start), tries), best[1]


def next_guess(factor: float, margin: float, slope: float) -> float:
    """Newton's next factor, between half and twice the present one: a slope near zero within the tolerance of the solver is meaningless."""
    root = factor - margin / slope if slope < 0.0 else 2.0 * factor
    return float(np.clip(root, 0.5 * factor, 2.0 * factor))


def angles_of(corners: Array) -> Array:
    """Angles of triangles (n, 3, 2) at their corners (n, 3)."""
    ahead = np.roll(corners, -1, axis=1) - corners
    ahead /= np.linalg.norm(ahead, axis=2)[..., None]
    return np.asarray(np.arccos(np.clip(-np.sum(ahead * np.roll(ahead, 1, axis=1), axis=2), -1.0, 1.0)))


def narrow_fans(model: Model, before: Loads, live: Loads) -> Array:
    """Positions on the outline where loads or prescribed velocities begin, or the face of a body that does not fail, with too few soil triangles for
    the fan of stresses that starts there.

    However small the triangles, stresses can rotate at most once from one triangle to the next.
    """
    seen: dict[int, Array] = {}
    begins: set[int] = set()
    for edge in np.flatnonzero(model.sides[:, 1] < 0):
        for end, place in enumerate(model.edges[edge]):
            acts = np.concatenate([load.traction[edge, end] for load in (before, live)] + [model.pushed[edge], [float(model.touching[edge])]])
            if np.any(np.abs(acts - seen.setdefault(int(place), acts)) > SAME * (1e-300 + np.abs(acts) + np.abs(seen[int(place)]))):
                begins.add(int(place))
    body = bodies_of(model, by_corners=False)
    beside = np.where(model.sides < 0, -2, body[model.sides])
    border = (beside == -1).any(axis=1) & (beside >= 0).any(axis=1)
    free = (beside == -1).any(axis=1) & (beside == -2).any(axis=1) & (model.held == 0)
    faces = np.intersect1d(model.edges[border], model.edges[free])
    soil = model.mesh.corners[body < 0]
    count = np.bincount(soil.ravel(), minlength=len(model.mesh.places))
    angle = np.bincount(soil.ravel(), angles_of(model.mesh.places[soil]).ravel(), len(model.mesh.places))
    few = {place for place in begins if 0 < count[place] < FAN} | {int(place) for place in faces if count[place] < FAN * angle[place] / np.pi - 0.5}
    return np.array(sorted(few), dtype=int)


class Search:
    """Bounds of a scene."""

    def __init__(self, scene: Scene, count: int = 500, passes: int = 3, share: float = 0.25) -> None:
        self.scene, self.passes, self.share = scene, passes, share
        self.kind = Kind.MARGIN if scene.safety else Kind.FORCE if scene.pushes else Kind.LOAD
        self.mesh: Triangles = first_triangles(scene, count)
        self.guess = 1.0

    def loads(self, model: Model) -> tuple[Loads, Loads]:
        """Loads without the live load, and the live load at a factor of one."""
        if self.kind is Kind.LOAD:
            live = model.after - model.before
            if live.largest() <= 0.0:
                raise Trouble(f"phase '{self.scene.phase}': no load changes in it; request its factor of safety (--factor)")
            over = self.scene.load_factor
            return model.before, Loads(live.weight / over, live.pore / over, live.traction / over)
        if self.kind is Kind.FORCE and (model.after - model.before).largest() > 0.0 and model.before.largest() > 0.0:
            raise Trouble(f"*PRESCRIBE: phase '{self.scene.phase}' also changes loads; apply them in an earlier phase")
        return model.after, model.after - model.after

    def settled(self) -> Model:
        """The scene on the mesh, bisected at corners where loads are inconsistent."""
        for _ in range(6):
            model = model_of(self.scene, self.mesh)
            before, live = self.loads(model)
            _, torn = lower_balance(model, before, live)
            cut = np.union1d(torn, narrow_fans(model, before, live))
            if not len(cut):
                break
            self.mesh = cut_at(self.mesh, cut)
        return model

    def upper(self, model: Model) -> tuple[Side, Nodes]:
        """The upper-bound problem."""
        nodes = nodes_of(model)
        loads = self.loads(model)
        return Side(model, upper_balance(model, nodes, *loads), self.kind, loads, self.scene.flow, nodes), nodes

    def lower(self, model: Model) -> Side:
        """The lower-bound problem."""
        loads = self.loads(model)
        balance, _ = lower_balance(model, *loads)
        return Side(model, balance, self.kind, loads, self.scene.flow, None)

    def solve(self, side: Side) -> tuple[Bound, Answer]:
        """A bound."""
        start = time.process_time()
        if self.kind is Kind.MARGIN:
            return find_factor(side, self.guess)
        answer = side.solve()
        return Bound(answer.value if answer.solved else np.nan, answer.status, _spent(start)), answer

    def mechanism(self, model: Model, nodes: Nodes, answer: Answer) -> Mechanism:
        """The mechanism of the upper bound."""
        velocity = nodes.velocity(answer.motion)
        largest = float(np.abs(velocity).max())
        spent = np.zeros(3 * len(model.area))
        np.add.at(spent, answer.point, answer.rate * answer.head)
        return Mechanism(model, nodes, velocity / max(largest, 1e-300), spent.reshape(-1, 3).sum(axis=1) / model.area)

    def marked(self, density: Array, area: Array) -> Array:
        """Triangles to bisect: the share of them with the largest dissipation; edges are included with the mean over slip lines and fans."""
        worth = np.maximum(density, 0.0) * area
        order = np.argsort(-worth, kind="stable")
        most = int(self.share * len(area)) + 1
        enough = int(np.searchsorted(np.cumsum(worth[order]), 0.95 * worth.sum())) + 1
        return np.asarray(order[: min(most, enough)])

    def run(self) -> Found:
        """Refinement passes, then both bounds on the last mesh."""
        history: list[tuple[int, float]] = []
        for turn in range(self.passes + 1):
            model = self.settled()
            side, nodes = self.upper(model)
            if turn == self.passes:
                break
            if self.kind is Kind.MARGIN and turn == 0:
                bound, answer = find_factor(side, self.guess)
                if bound.solved:
                    self.guess = bound.value
            else:
                answer = side.solve(self.guess)
            if not answer.solved:
                break
            history.append((len(model.area), self.guess if self.kind is Kind.MARGIN else answer.value))
            if self.kind is Kind.MARGIN and turn:
                self.guess = next_guess(self.guess, answer.value, side.slope(answer, self.guess))
            mechanism = self.mechanism(model, nodes, answer)
            self.mesh = halve(self.mesh, self.marked(mechanism.density, model.area))
        upper, answer = self.solve(side)
        if len(answer.motion) == 0 and not upper.solved:
            raise RunFailed(f"no upper bound: {upper.status}")
        mechanism = self.mechanism(model, nodes, answer)
        if upper.solved and self.kind is Kind.MARGIN:
            self.guess = 0.97 * upper.value
        lower, _ = self.solve(self.lower(model))
        reduced = any(strength.reduced() for strength in model.strengths)
        return Found(self.kind, upper, lower, len(model.area), reduced, mechanism, history)
