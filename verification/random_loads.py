#!/usr/bin/env python3
"""Random footings and walls by default settings: is the limit load within the bounds of limit analysis, or does the log say that it is not?

    verification/random_loads.py [--scene footing|wall] [--count 20] [--seed 1] [--only N ...] [--program build/qsmpm] [--keep DIR] [--markdown FILE]

`--scene footing`: a footing on one to three layers of clay (phi = 0) and soil with friction (psi = phi), half of them with a water level below the ground, a
third beside a slope of 30 or 45 degrees, two to six cells in half of the footing. The footing is a set of nodes pushed down (rough), a rigid body (smooth,
rough or with a friction angle), a pressure on the ground, or a block of concrete under a pressure that may be eccentric. The deck names no element and no
method.

`--scene wall`: a wall pushed into, or drawn away from, one to three such layers at rest, by nodes that are free or fixed along it or as a rigid body with or
without friction, on a smooth base at its foot or on ground that continues below it; five to fourteen cells high.

A scene passes if the limit load (the largest reaction, at a wall that is drawn away the least, or the limit load of the log) is within 0.35 over the number
of cells in half of the footing, within 0.6 over that of the wall, of the bounds of the initial geometry, or the last load of those of the deformed one, or if
a warning in the log or an error (exit codes 2 and 3) reports that it is not. A load that still rises at the end of the motion is not compared with the lower
bound (nan). Closes with `N passed, N failed`.
"""

from __future__ import annotations

import csv
import json
import math
import pathlib
import random
import re
import sys
from dataclasses import dataclass

TOP = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(TOP / "tools"))
from qsmpm_verify.bounds.deformed import deformed  # noqa: E402
from qsmpm_verify.bounds.phases import read_scene  # noqa: E402
from qsmpm_verify.bounds.search import Search  # noqa: E402
from qsmpm_verify.cpu_limit import run_limited  # noqa: E402
from qsmpm_verify.study.cards import read_deck  # noqa: E402
from qsmpm_verify.trouble import Trouble  # noqa: E402
from random_grounds import WATER, Soil, lines, run_scenes  # noqa: E402

SECONDS = 300.0
# Warnings that are not about the load.
OTHER = ("concrete", "K0 stresses", "has dilated", "has reached the side", "locks", "soil has sheared", "share cells", "differ by")


@dataclass
class Footing:
    """A scene: a footing 2 b wide, its middle at x = 0, the ground at y = 0 and below."""

    kind: str
    half: float
    cell: float
    soils: list[Soil]
    water: float | None
    slope: tuple[float, float] | None
    friction: str
    eccentric: float

    @property
    def depth(self) -> float:
        """Depth of the ground."""
        return -self.soils[0].low

    @property
    def width(self) -> float:
        """Distance of the ends of the ground from the middle of the footing."""
        return self.cell * math.ceil(7.0 * self.half / self.cell)

    def polygon(self, low: float, high: float) -> list[tuple[float, float]]:
        """A layer."""
        left, right = -self.width, self.width
        if not self.slope:
            return [(left, low), (right, low), (right, high), (left, high)]
        at, angle = self.slope
        toe = -0.5 * self.depth

        def face(y: float) -> float:
            return at - y / math.tan(math.radians(angle))

        corners = [(left, low)]
        if low < toe:
            corners += [(right, low), (right, min(high, toe))]
            corners += [(face(toe), toe), (face(high), high)] if high > toe else []
        else:
            corners += [(face(low), low), (face(high), high)]
        return [*corners, (left, high)]

    @property
    def share(self) -> float:
        """The part by which the load may be off."""
        return 0.35 * self.cell / self.half

    @property
    def needs_load(self) -> bool:
        """Whether a pressure is given."""
        return self.kind in ("pressure", "block")

    @property
    def by_nodes(self) -> bool:
        """Whether nodes are pushed."""
        return self.kind == "nodes"

    @property
    def active(self) -> bool:
        """Whether the least force counts."""
        return False

    def __str__(self) -> str:
        what = f"{self.kind}{self.friction if self.kind == 'rigid' else ''}{', eccentric' if self.eccentric and self.kind == 'block' else ''} on "
        what += "/".join("clay" if soil.friction == 0.0 else f"{soil.friction:.0f}" for soil in reversed(self.soils))
        return what + f"{', water' if self.water is not None else ''}{f', slope {self.slope[1]:.0f}' if self.slope else ''}, {self.half / self.cell:.0f} cells"

    def deck(self, pressure: float) -> str:
        """The deck of a scene, with a pressure where there is one."""
        half, width, depth, cell = self.half, self.width, self.depth, self.cell
        block = self.kind in ("rigid", "block")
        text = f"""*UNITS, LENGTH=m, FORCE=kN
*MODEL, TYPE=PLANE STRAIN
*GRID
X, {-width:.8g}, {width:.8g}, {round(2 * width / cell)}
Y, {-depth:.8g}, 0, {round(depth / cell)}
{f"Y, 0, {2 * cell:.8g}, 2" if block else ""}
*NSET, NSET=base, PLANE=Y
{-depth:.8g}
*NSET, NSET=left, PLANE=X
{-width:.8g}
*NSET, NSET=right, PLANE=X
{width:.8g}
""".replace("\n\n", "\n")
        for i, soil in enumerate(self.soils):
            text += soil.cards(i)
            text += f"*BODY, NAME=layer{i}, MATERIAL=soil{i}, SHAPE=POLYGON\n{lines(self.polygon(soil.low, soil.high))}"
        top = f"layer{len(self.soils) - 1}"
        level = f"*WATER LEVEL, UNIT WEIGHT={WATER}\n{-width:.8g}, {self.water:.8g}\n" if self.water is not None else ""
        push = 0.06 * half
        phase = "*PHASE, NAME=push\n"
        if self.kind == "nodes":
            text += f"*NSET, NSET=footing, BOX\n{-half:.8g}, {half:.8g}, 0, 0\n*HISTORY, NAME=load, QUANTITY=REACTION, COMPONENT=Y, NSET=footing, SCALE=-1\n"
            phase += f"*FIX\nfooting, X\n*PRESCRIBE\nfooting, Y, {-push:.6g}\n*CONTROLS, STEPS=20\n"
        elif self.kind == "rigid":
            text += f"*RIGID BODY, NAME=footing, SHAPE=BOX\n{-half:.8g}, {half:.8g}, 0, {2 * cell:.8g}\n*SURFACE, NAME=top, TYPE=OUTLINE, BODY={top}, BOX\n"
            right = min(2.0 * half, self.slope[0] if self.slope else 2.0 * half)
            text += f"{-2 * half:.8g}, {right:.8g}, 0, 0\n*CONTACT, BODY=footing, SURFACE=top{self.friction}\n"
            text += "*HISTORY, NAME=load, QUANTITY=CONTACT FORCE, COMPONENT=Y, BODY=footing\n"
            phase += f"*MOVE, BODY=footing\n0, {-push:.6g}\n*CONTROLS, STEPS=20\n"
        else:
            body, high, left = top, 0.0, -half
            later = ""
            if self.kind == "block":
                body, high, left = "block", cell, -half + 2.0 * self.eccentric
                text += "*MATERIAL, NAME=concrete\n*ELASTIC\n3e7, 0.2\n"
                later = f"*BODY, NAME=block, MATERIAL=concrete, SHAPE=BOX\n{-half:.8g}, {half:.8g}, 0, {cell:.8g}\n"
            text += f"{later}*SURFACE, NAME=loaded, TYPE=OUTLINE, BODY={body}, BOX\n{left:.8g}, {half:.8g}, {high:.8g}, {high:.8g}\n"
            phase += f"*PRESSURE, SURFACE=loaded\n{pressure:.6g}\n*CONTROLS, STEPS=20\n"
        rest = "*INITIAL, TYPE=K0\n0, 0.6\n" if not self.slope and self.kind != "block" else ""
        fixed = "*FIX\nbase, ALL\nleft, X\nright, X\n*GRAVITY\n0, -1\n"
        steps = "*CONTROLS, STEPS=1\n" if rest else ""
        return f"{text}*PHASE, NAME=ground\n{rest}{fixed}{level}{steps}*END PHASE\n{phase}*END PHASE\n"


def footing(number: int, seed: int) -> Footing:
    """A scene by its number."""
    chance = random.Random(f"footing {seed} {number}")
    half = chance.uniform(0.4, 3.0)
    cell = half / chance.randint(2, 6)
    depth = cell * math.ceil(chance.uniform(3.0, 4.0) * half / cell)
    inner = sorted(-chance.uniform(0.3 * half, 0.8 * depth) for _ in range(chance.randint(0, 2)))
    cuts = [-depth, *inner, 0.0]
    cuts = [cuts[0], *(y for before, y in zip(cuts, cuts[1:], strict=False) if y - before > 0.5 * cell or y == 0.0)]
    soils = []
    for low, high in zip(cuts, cuts[1:], strict=False):
        clay = chance.random() < 0.5
        friction = 0.0 if clay else chance.uniform(15.0, 36.0)
        cohesion = half * chance.uniform(15.0, 60.0) if clay else half * chance.uniform(1.0, 8.0)
        soils.append(Soil(low, high, cohesion, friction, chance.uniform(16.0, 21.0), 10.0 ** chance.uniform(4.0, 5.0) * half))
    slope = (half * chance.uniform(1.1, 2.5), chance.choice([30.0, 45.0])) if chance.random() < 0.33 else None
    # The edge of a uniform pressure on soil with friction fails at the load of a strip without width, which cells cannot show.
    kinds = ["nodes", "rigid", "block", "pressure" if soils[-1].friction == 0.0 else "nodes"]
    return Footing(chance.choice(kinds), half, cell, soils, -chance.uniform(0.05, 0.8) * depth if chance.random() < 0.5 else None,
                   slope, chance.choice(["", ", ADHESION=1e6", ", FRICTION ANGLE=15"]), chance.choice([0.0, 0.0, 0.3 * half]))  # fmt: skip


@dataclass
class Wall:
    """A wall of a height at x = 0, the ground to its right; its foot at y = 0."""

    kind: str
    active: bool
    high: float
    cell: float
    soils: list[Soil]
    friction: str
    deep: float

    @property
    def share(self) -> float:
        """The part by which the load may be off."""
        return 0.6 * self.cell / self.high

    @property
    def needs_load(self) -> bool:
        """Whether a pressure is given."""
        return False

    @property
    def by_nodes(self) -> bool:
        """Whether nodes are pushed."""
        return self.kind != "rigid"

    def __str__(self) -> str:
        layers = "/".join("clay" if soil.friction == 0.0 else f"{soil.friction:.0f}" for soil in reversed(self.soils))
        where = "ground below" if self.deep else "on its base"
        return f"{'active' if self.active else 'passive'}, {self.kind}{self.friction}, {layers}, {where}, {self.high / self.cell:.0f} cells"

    def deck(self, _: float) -> str:
        """The deck of the scene."""
        high, deep, cell = self.high, self.deep, self.cell
        left = -3 * cell if self.kind == "rigid" or self.active else 0.0
        left = -cell * round(2.0 * high / cell) if deep else left
        width = cell * math.ceil((1.5 if self.active else 4.5) * high / cell)
        text = f"""*UNITS, LENGTH=m, FORCE=kN
*MODEL, TYPE=PLANE STRAIN
*GRID
X, {left:.8g}, {width:.8g}, {round((width - left) / cell)}
Y, {-deep:.8g}, {high:.8g}, {round((high + deep) / cell)}
Y, {high:.8g}, {high + 2 * cell:.8g}, 2
*NSET, NSET=base, PLANE=Y
{-deep:.8g}
*NSET, NSET=right, PLANE=X
{width:.8g}
*NSET, NSET=left, PLANE=X
{left:.8g}
"""
        for i, soil in enumerate(self.soils):
            text += soil.cards(i)
            text += f"*BODY, NAME=layer{i}, MATERIAL=soil{i}, SHAPE=BOX\n0, {width:.8g}, {soil.low:.8g}, {soil.high:.8g}\n"
        if deep:
            text += f"*BODY, NAME=front, MATERIAL=soil0, SHAPE=BOX\n{left:.8g}, 0, {-deep:.8g}, 0\n"
        way = (-0.02 if self.active else 0.04) * high
        if self.kind == "rigid":
            # One layer, whose face is the surface. Corners of the wall are round: one ends below a base.
            text += f"*RIGID BODY, NAME=wall, SHAPE=BOX\n{-2 * cell:.8g}, 0, {0.0 if deep else -cell:.8g}, {high + cell:.8g}\n"
            text += f"*SURFACE, NAME=face, TYPE=OUTLINE, BODY=layer0, BOX\n0, 0, 0, {high:.8g}\n*CONTACT, BODY=wall, SURFACE=face{self.friction}\n"
            text += "*HISTORY, NAME=load, QUANTITY=CONTACT FORCE, COMPONENT=X, BODY=wall, SCALE=-1\n"
            push = f"*MOVE, BODY=wall\n{way:.6g}, 0\n"
        else:
            text += f"*NSET, NSET=face, BOX\n0, 0, 0, {high:.8g}\n*HISTORY, NAME=load, QUANTITY=REACTION, COMPONENT=X, NSET=face\n"
            push = f"{'*FIX' + chr(10) + 'face, Y' + chr(10) if self.kind == 'rough nodes' else ''}*PRESCRIBE\nface, X, {way:.6g}\n"
        held = "face, X\n" if self.by_nodes else ""
        rest = "" if deep else f"*INITIAL, TYPE=K0\n{high:.8g}, 0.5\n"
        text += f"*PHASE, NAME=ground\n{rest}*FIX\nbase, {'ALL' if deep else 'Y'}\nright, X\n{'left, X' + chr(10) if deep else ''}{held}"
        return f"{text}*GRAVITY\n0, -1\n{'*CONTROLS, STEPS=1' + chr(10) if rest else ''}*END PHASE\n*PHASE, NAME=push\n{push}*CONTROLS, STEPS=20\n*END PHASE\n"


def wall(number: int, seed: int) -> Wall:
    """A scene by its number."""
    chance = random.Random(f"wall {seed} {number}")
    high = chance.uniform(1.5, 8.0)
    cells = chance.randint(5, 14)
    cell = high / cells
    active = chance.random() < 0.4
    kind = chance.choice(["rigid", "rigid", "smooth nodes", "rough nodes"])
    # The node at the foot of a wall of nodes also pushes ground in front of it, which an active force is too small for (docs/tried.md).
    deep = cell * round(0.6 * cells) if chance.random() < 0.4 and (kind == "rigid" or not active) else 0.0
    inner = sorted(chance.uniform(0.15 * high, 0.85 * high) for _ in range(chance.randint(0, 2)))
    cuts = [-deep, *(inner if kind != "rigid" else []), high]
    soils = []
    for low, top in zip(cuts, cuts[1:], strict=False):
        clay = chance.random() < 0.3 and not active
        friction = 0.0 if clay else chance.uniform(20.0, 36.0)
        cohesion = high * chance.uniform(5.0, 12.0) if clay else high * chance.uniform(0.05, 0.3 if active else 1.2)
        soils.append(Soil(low, top, cohesion, friction, chance.uniform(16.0, 21.0), 10.0 ** chance.uniform(4.0, 5.0) * high / 3.0))
    friction = chance.choice(["", "", ", FRICTION ANGLE=15"]) if kind == "rigid" else ""
    return Wall(kind, active, high, cell, soils, friction, deep)


def bounds_of(deck: pathlib.Path, run: pathlib.Path | None = None) -> tuple[float, float]:
    """Bounds of the force or of the load factor of the last phase, in the initial geometry or that at the end of a run."""
    scene = read_scene(read_deck(deck))
    if run is not None:
        scene = deformed(scene, read_deck(deck), run, None)
    found = Search(scene).run()
    # The force along the motion, which holds ground that follows it.
    low, high = sorted(abs(value) for value in (found.lower.value, found.upper.value))
    return low, high


SCENES = {"footing": footing, "wall": wall}


@dataclass
class Result:
    """What came out of a scene."""

    number: int
    scene: Footing | Wall
    low: float
    high: float
    load: float
    last: float
    cpu: float
    said: list[str]
    deformed: tuple[float, float, float] | None = None

    @property
    def error(self) -> float:
        """The distance from the bounds, over the nearest of them."""
        return self.load / min(max(self.load, self.low), self.high) - 1.0

    @property
    def held(self) -> bool:
        """Whether the scene passes."""
        share = self.scene.share
        if math.isnan(self.load) and self.last < (1.0 + share) * self.high:
            return True
        at_least = [float(x) for line in self.said for x in re.findall(r"above load factor ([\d.E+-]+)", line)]
        if any(x <= self.high for x in at_least):
            return True
        if abs(self.error) <= share or any(line.startswith("exit") for line in self.said):
            return True
        if any(("slip surface" in line or line.startswith("warning:")) and not any(words in line for words in OTHER) for line in self.said):
            return True
        return self.deformed is not None and (1.0 - share) * self.deformed[0] <= self.deformed[2] <= (1.0 + share) * self.deformed[1]

    def row(self) -> str:
        """A line of the table."""
        words = "; ".join(dict.fromkeys(re.sub(r"^warning: |phase '[^']*': ", "", line)[:110] for line in self.said))
        moved = f"{self.deformed[2]:.4g} in {self.deformed[0]:.4g} to {self.deformed[1]:.4g}" if self.deformed else ""
        bounds = f"{self.low:.4g} to {self.high:.4g}"
        return f"| {self.number} | {self.scene} | {bounds} | {self.load:.4g} | {self.error:+.1%} | {moved} | {self.cpu:.1f} | {words} |"


def loads_of(out: pathlib.Path, active: bool) -> tuple[float, float]:
    """Limit load, and the last load."""
    if (out / "limit_load.json").is_file():
        found = json.loads((out / "limit_load.json").read_text())
        return float(found["knee"]), float(found["carried"])
    if not (out / "curves.csv").is_file():
        return math.nan, math.nan
    about = re.search(r"about load factor ([\d.E+-]+)", (out / "job.log").read_text())
    if about:
        return float(about.group(1)), math.nan
    rows = [row for row in csv.DictReader((out / "curves.csv").read_text().splitlines()) if row["phase"] == "2"]
    column = next((name for name in rows[0] if name.startswith("load") and not name.startswith("load_factor")), None) if rows else None
    course = [float(row[column]) for row in rows] if column else []
    if not course:
        return math.nan, math.nan
    where = [0.0, *(float(row["load_factor"]) for row in rows)]
    slopes = [(b - a) / (y - x) for a, b, x, y in zip([0.0, *course], course, where, where[1:], strict=False)]
    # A load that still rises at the end of the motion is not the limit load.
    rises = not active and slopes[-1] > 0.1 * max(slopes)
    return math.nan if rises else (min if active else max)(course), course[-1]


def solve(kind: str, number: int, seed: int, program: pathlib.Path, folder: pathlib.Path) -> Result:
    """A scene, its bounds and its load."""
    scene = SCENES[kind](number, seed)
    deck = folder / f"{kind}_{seed}_{number}.inp"
    deck.write_text(scene.deck(1.0))
    low, high = bounds_of(deck)
    if not low > 0.0:
        raise Trouble("the bounds are not found")
    if scene.needs_load:
        # The phase has twice the limit load.
        deck.write_text(scene.deck(low + high))
        low, high = low / (low + high), high / (low + high)
    out = folder / deck.stem
    ended = run_limited([program, "run", deck, "--out", out], SECONDS, folder)
    log = (out / "job.log").read_text().splitlines() if (out / "job.log").is_file() else [ended.errors]
    said = [line for line in log if line.startswith("warning:") or "limit load" in line or "force against its motion" in line or "slip surface" in line]
    load, last = loads_of(out, scene.active)
    # A phase that ends at its limit load ends with exit code 0 or 3 and says so.
    if ended.code != 0 and "limit load" not in " ".join(said):
        said.append(f"{ended.how}: {log[-1] if log else ''}")
    result = Result(number, scene, low, high, load, last, ended.cpu, said)
    if abs(result.error) > scene.share and scene.by_nodes and not math.isnan(last):
        result.deformed = (*bounds_of(deck, out), last)
    return result


def main() -> int:
    head = ["| scene | ground | bounds | load | off | deformed | CPU s | log |", "|---|---|---|---|---|---|---|---|"]
    return run_scenes(__doc__, list(SCENES), solve, head, "Limit loads of random {}s beside limit analysis")


if __name__ == "__main__":
    sys.exit(main())
