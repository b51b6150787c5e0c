#!/usr/bin/env python3
"""Random layered ground by default settings: does the factor of safety lie within the bounds of limit analysis, or does the log say that it does not?

    verification/random_grounds.py [--scene ground|pit] [--count 20] [--seed 1] [--only N ...] [--program build/qsmpm] [--keep DIR] [--markdown FILE]

`--scene ground`: a slope built at once, a cut excavated from K0 ground, or an embankment on level ground, of one to four layers of clay (phi = 0) and soil
with friction (psi = phi in three quarters of the scenes, psi = 0 in the others), a third of them with a seam of 0.3 to 1.5 cells, half with a water level, a
third with a surcharge on the crest; 6 to 12 cells a height. The strengths are scaled so that the factor is 1.15 to 1.9. The deck names no element and no
method. With psi = 0 the bounds are those of strength reduced after Davis. `--scene pit`: half of a pit dug in two phases beside a wall of concrete, with a
strut in half of the scenes, in one to three such layers at rest, half with a water level; 5 to 10 cells a depth.

A scene passes if the factor is within 3 % of the bounds, that of a pit within 0.2 over its depth in cells, or if a warning of the factor, the note on the
flow rule with a lowest value below the upper bound, the one on ground that has deformed, a bracket without an upper end or an error (exit codes 2 and 3)
reports that it is not. Closes with `N passed, N failed`.
"""

from __future__ import annotations

import argparse
import json
import math
import pathlib
import random
import re
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

TOP = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(TOP / "tools"))
from qsmpm_verify.bounds.phases import read_scene  # noqa: E402
from qsmpm_verify.bounds.search import Search  # noqa: E402
from qsmpm_verify.cpu_limit import run_limited  # noqa: E402
from qsmpm_verify.study.cards import read_deck  # noqa: E402
from qsmpm_verify.trouble import Trouble  # noqa: E402

SECONDS = 300.0
SHARE = 0.03
WATER = 9.81
LARGEST_FRICTION = 42.0


@dataclass
class Soil:
    """A layer between two heights."""

    low: float
    high: float
    cohesion: float
    friction: float
    weight: float
    stiffness: float

    def scaled(self, by: float) -> Soil:
        """The layer with its strength times a factor."""
        friction = math.degrees(math.atan(by * math.tan(math.radians(self.friction))))
        return Soil(self.low, self.high, by * self.cohesion, friction, self.weight, self.stiffness)

    def cards(self, number: int, dilates: bool = True) -> str:
        """Its material."""
        text = f"*MATERIAL, NAME=soil{number}\n*ELASTIC\n{self.stiffness:.5g}, 0.3\n*MOHR COULOMB\n"
        text += f"{self.cohesion:.6g}, {self.friction:.6g}, {self.friction if dilates else 0.0:.6g}\n"
        return text + f"*UNIT WEIGHT\n{self.weight:.5g}, {self.weight + 1.0:.5g}\n"


def lines(polygon: list[tuple[float, float]]) -> str:
    """The vertices of a polygon."""
    return "".join(f"{x:.8g}, {y:.8g}\n" for x, y in polygon)


@dataclass
class Ground:
    """A scene: ground of a height above the toe, the toe at height 0."""

    kind: str
    height: float
    angle: float
    cell: float
    soils: list[Soil]
    dilates: bool
    water: list[tuple[float, float]]
    surcharge: float

    @property
    def crest(self) -> float:
        """Where the crest ends."""
        return math.ceil(1.5 * self.height / self.cell) * self.cell

    def face(self, height: float) -> float:
        """Where the slope has a height."""
        return self.crest + (self.height - height) / math.tan(math.radians(self.angle))

    @property
    def width(self) -> float:
        """Width of the ground."""
        return math.ceil((self.face(0.0) + 2.0 * self.height) / self.cell) * self.cell

    def polygon(self, low: float, high: float) -> list[tuple[float, float]]:
        """A layer left of the face, or below the toe of the whole width."""
        right = [(self.width, low), (self.width, min(high, 0.0))] if low < 0.0 else [(self.face(low), low)]
        if low < 0.0 < high:
            right.append((self.face(0.0), 0.0))
        return [(0.0, low), *right, *([(self.face(high), high)] if high > 0.0 else []), (0.0, high)]

    def excavated(self, low: float, high: float) -> list[tuple[float, float]]:
        """What a cut takes out of a layer above the toe."""
        return [(self.face(low), low), (self.width, low), (self.width, high), (self.face(high), high)]

    def __str__(self) -> str:
        return f"{self.kind}, {len(self.soils)} layers{', water' if self.water else ''}{', surcharge' if self.surcharge else ''}"

    def deck(self, by: float) -> str:
        """The deck with its strengths times a factor."""
        base, top = self.soils[0].low, self.height
        text = f"""*UNITS, LENGTH=m, FORCE=kN
*MODEL, TYPE=PLANE STRAIN
*GRID
X, 0, {self.width:.8g}, {round(self.width / self.cell)}
Y, {base:.8g}, {top:.8g}, {round((top - base) / self.cell)}
*NSET, NSET=base, PLANE=Y
{base:.8g}
*NSET, NSET=left, PLANE=X
0
*NSET, NSET=right, PLANE=X
{self.width:.8g}
"""
        bodies, coming, going = "", [], []
        for i, soil in enumerate(soil.scaled(by) for soil in self.soils):
            text += soil.cards(i, self.dilates)
            later = ", ACTIVE=NO" if self.kind == "embankment" and soil.low >= 0.0 else ""
            coming += [f"layer{i}"] if later else []
            bodies += f"*BODY, NAME=layer{i}, MATERIAL=soil{i}, SHAPE=POLYGON{later}\n{lines(self.polygon(soil.low, soil.high))}"
            if self.kind == "cut" and soil.high > 0.0:
                bodies += f"*BODY, NAME=cut{i}, MATERIAL=soil{i}, SHAPE=POLYGON\n{lines(self.excavated(max(soil.low, 0.0), soil.high))}"
                going.append(f"cut{i}")
        text += bodies
        if self.surcharge:
            text += f"*SURFACE, NAME=crest, TYPE=OUTLINE, BODY=layer{len(self.soils) - 1}, BOX\n"
            text += f"{0.3 * self.crest:.6g}, {0.8 * self.crest:.6g}, {top:.8g}, {top:.8g}\n"
        load = f"*PRESSURE, SURFACE=crest\n{self.surcharge:.5g}\n" if self.surcharge else ""
        level = f"*WATER LEVEL, UNIT WEIGHT={WATER}\n{lines(self.water)}" if self.water else ""
        fixed = "*FIX\nbase, ALL\nleft, X\nright, X\n*GRAVITY\n0, -1\n"
        if self.kind == "slope":
            return f"{text}*PHASE, NAME=built\n{fixed}{level}{load}*END PHASE\n*PHASE, NAME=factor, TYPE=SAFETY\n*END PHASE\n"
        rest = f"*INITIAL, TYPE=K0\n{top if going else 0.0:.8g}, 0.6\n"
        text += f"*PHASE, NAME=ground\n{rest}{fixed}{'' if going else level}*CONTROLS, STEPS=1\n*END PHASE\n"
        change = "*DEACTIVATE\n" + "\n".join(going) if going else "*ACTIVATE\n" + "\n".join(coming)
        return f"{text}*PHASE, NAME=built\n{change}\n{level if going else ''}{load}*END PHASE\n*PHASE, NAME=factor, TYPE=SAFETY\n*END PHASE\n"


@dataclass
class Pit:
    """Half of a pit beside a wall of concrete; the surface at y = 0, the axis of the pit at x = 0."""

    height: float
    half: float
    thick: float
    foot: float
    cell: float
    soils: list[Soil]
    water: float | None
    strut: float | None
    dilates: bool = True

    angle = 90.0

    def __str__(self) -> str:
        what = f"pit, {len(self.soils)} layers, wall of {-self.foot / self.height:.1f} depths{', strut' if self.strut else ''}"
        return f"{what}{', water' if self.water is not None else ''}, {self.height / self.cell:.0f} cells"

    def deck(self, by: float) -> str:
        """The deck with its strengths times a factor."""
        base, back = self.soils[0].low, self.half + self.thick
        width = math.ceil((back + 3.5 * self.height) / self.cell) * self.cell
        text = f"""*UNITS, LENGTH=m, FORCE=kN
*MODEL, TYPE=PLANE STRAIN
*GRID
X, 0, {width:.8g}, {round(width / self.cell)}
Y, {base:.8g}, 0, {round(-base / self.cell)}
*NSET, NSET=base, PLANE=Y
{base:.8g}
*NSET, NSET=axis, PLANE=X
0
*NSET, NSET=right, PLANE=X
{width:.8g}
*MATERIAL, NAME=wall
*ELASTIC
3e7, 0.2
*UNIT WEIGHT
24
*BODY, NAME=wall, MATERIAL=wall, SHAPE=BOX
{self.half:.8g}, {back:.8g}, {self.foot:.8g}, 0
"""
        dug: list[list[str]] = [[], []]
        level = -0.45 * self.height

        def body(name: str, i: int, x: tuple[float, float], low: float, high: float) -> str:
            if high - low < 1e-9:
                return ""
            return f"*BODY, NAME={name}, MATERIAL=soil{i}, SHAPE=BOX\n{x[0]:.8g}, {x[1]:.8g}, {low:.8g}, {high:.8g}\n"

        for i, soil in enumerate(soil.scaled(by) for soil in self.soils):
            low, high = soil.low, soil.high
            text += soil.cards(i)
            text += body(f"right{i}", i, (back, width), low, high)
            text += body(f"left{i}", i, (0.0, self.half), low, max(low, min(high, -self.height)))
            text += body(f"under{i}", i, (self.half, back), low, max(low, min(high, self.foot)))
            for part, (floor, top) in enumerate([(level, 0.0), (-self.height, level)]):
                one = body(f"pit{i}{'ab'[part]}", i, (0.0, self.half), max(low, floor), max(low, floor, min(high, top)))
                text += one
                dug[part] += [f"pit{i}{'ab'[part]}"] if one else []
        if self.strut:
            place = self.half + 0.5 * self.thick
            text += f"*PROP, NAME=strut, STIFFNESS=50000, FIXED=YES\n{place:.8g}, {self.strut:.8g}, 0, {self.strut:.8g}\n"
        water = f"*WATER LEVEL, UNIT WEIGHT={WATER}\n0, {self.water:.8g}\n{width:.8g}, {self.water:.8g}\n" if self.water is not None else ""
        text += f"*PHASE, NAME=ground\n*INITIAL, TYPE=K0\n0, 0.6\n*FIX\nbase, ALL\naxis, X\nright, X\n*GRAVITY\n0, -1\n{water}"
        text += "*CONTROLS, STEPS=1\n*END PHASE\n"
        text += "*PHASE, NAME=dig 1\n*DEACTIVATE\n" + "\n".join(dug[0]) + "\n*END PHASE\n*PHASE, NAME=dig 2\n"
        text += f"{'*INSTALL' + chr(10) + 'strut' + chr(10) if self.strut else ''}*DEACTIVATE\n" + "\n".join(dug[1]) + "\n*END PHASE\n"
        return text + "*PHASE, NAME=factor, TYPE=SAFETY\n*END PHASE\n"


def pit(number: int, seed: int) -> Pit:
    """A scene by its number."""
    chance = random.Random(f"pit {seed} {number}")
    height = chance.uniform(2.5, 7.0)
    cell = height / chance.randint(5, 10)
    half, thick = height * chance.uniform(0.8, 2.0), chance.uniform(0.4, 0.9)
    strut = -0.3 * height if chance.random() < 0.5 else None
    foot = -height * (chance.uniform(1.3, 1.8) if strut else chance.uniform(1.8, 2.5))
    base = -cell * round((0.8 * height - foot) / cell)
    inner = sorted(chance.uniform(base + 1.5 * cell, -1.5 * cell) for _ in range(chance.randint(0, 2)))
    cuts = [base, *inner, 0.0]
    cuts = [cuts[0], *(y for before, y in zip(cuts, cuts[1:], strict=False) if y - before > 0.6 * cell or y == 0.0)]
    soils = []
    for low, high in zip(cuts, cuts[1:], strict=False):
        clay = chance.random() < 0.35
        friction = 0.0 if clay else chance.uniform(22.0, 36.0)
        cohesion = height * (chance.uniform(3.0, 6.0) if clay else chance.uniform(0.3, 1.5))
        soils.append(Soil(low, high, cohesion, friction, chance.uniform(16.0, 20.0), 10.0 ** chance.uniform(3.9, 5.0)))
    return Pit(height, half, thick, foot, cell, soils, -chance.uniform(0.2, 1.4) * height if chance.random() < 0.5 else None, strut)


def ground(number: int, seed: int) -> Ground:
    """A scene by its number."""
    chance = random.Random(f"{seed} {number}")
    height = chance.uniform(3.0, 12.0)
    cell = height / chance.randint(6, 12)
    kind = chance.choice(["slope", "cut", "embankment"])
    base = -cell * round(chance.uniform(0.5, 1.2) * height / cell)
    inner = sorted(chance.uniform(base + 1.5 * cell, height - 1.5 * cell) for _ in range(chance.randint(0, 3)))
    if kind == "embankment":
        inner = sorted([*inner, 0.0])
    cuts = [base, *inner, height]
    fixed = (0.0, height) if kind == "embankment" else (height,)
    cuts = [cuts[0], *(y for before, y in zip(cuts, cuts[1:], strict=False) if y - before > 0.4 * cell or y in fixed)]
    if chance.random() < 0.33 and len(cuts) > 2:
        at = chance.randint(1, len(cuts) - 2)
        cuts.insert(at + 1, min(cuts[at] + chance.uniform(0.3, 1.5) * cell, cuts[at + 1] - 0.4 * cell))
        cuts = sorted(cuts)
    soils = []
    for low, high in zip(cuts, cuts[1:], strict=False):
        clay = chance.random() < 0.35
        friction = 0.0 if clay else chance.uniform(15.0, 38.0)
        cohesion = height * (chance.uniform(2.0, 5.0) if clay else chance.uniform(0.3, 1.5))
        soils.append(Soil(low, high, cohesion, friction, chance.uniform(16.0, 21.0), 10.0 ** chance.uniform(3.7, 5.0)))
    water = []
    if chance.random() < 0.5:
        back = chance.uniform(0.1, 0.7) * height
        water = [(0.0, back), (0.5 * height, back)]
    result = Ground(kind, height, chance.choice([27.0, 34.0, 45.0, 56.0, 70.0]), cell, soils, chance.random() < 0.75, water,
                    chance.uniform(5.0, 30.0) if chance.random() < 0.33 else 0.0)
    if water and kind != "slope":
        # K0 stresses want level water.
        level = chance.uniform(0.1, 0.8) * base if kind == "embankment" else -chance.uniform(0.0, 0.8) * abs(base)
        result.water[:] = [(0.0, level)]
    elif water:
        toe = chance.choice([0.0, chance.uniform(-0.5, 0.0) * abs(base), 0.3 * water[0][1]])
        result.water.append((result.face(max(toe, 0.0)), toe))
    return result


def bounds_of(deck: pathlib.Path, **more: int) -> tuple[float, float]:
    """Bounds of the factor."""
    found = Search(read_scene(read_deck(deck)), **more).run()
    return found.lower.value, found.upper.value


SCENES = {"ground": ground, "pit": pit}


@dataclass
class Result:
    """What came out of a scene."""

    number: int
    scene: Ground | Pit
    low: float
    high: float
    factor: float
    cpu: float
    said: list[str]

    @property
    def error(self) -> float:
        """The distance from the bounds, over the nearest of them."""
        return self.factor / min(max(self.factor, self.low), self.high) - 1.0

    @property
    def reported(self) -> bool:
        """Whether the log says why the factor is not within the bounds."""
        lowest = [float(x) for line in self.said for x in re.findall(r"after Davis it may be as low as ([\d.]+)", line)]
        words = ("neither equilibrium nor", "deformed ground", "exit code 2:", "exit code 3:")
        warned = any(line.startswith("warning") and "factor" in line for line in self.said)
        return warned or any(word in line for line in self.said for word in words) or any(x < self.high for x in lowest)

    @property
    def held(self) -> bool:
        """Whether the scene passes."""
        share = 0.2 * self.scene.cell / self.scene.height if isinstance(self.scene, Pit) else SHARE
        return self.reported if math.isnan(self.factor) else abs(self.error) <= share or self.reported

    def row(self) -> str:
        """A line of the table."""
        scene = self.scene
        words = "; ".join(dict.fromkeys(re.sub(r"^warning: |phase '[^']*': ", "", line)[:110] for line in self.said))
        return (f"| {self.number} | {scene} | {scene.angle:.0f} | {'phi' if scene.dilates else '0'} | {self.low:.3f} to {self.high:.3f} | {self.factor:.3f} "
                f"| {self.error:+.1%} | {self.cpu:.1f} | {words} |")  # fmt: skip


def solve(kind: str, number: int, seed: int, program: pathlib.Path, folder: pathlib.Path) -> Result:
    """A scene, its bounds and its factor."""
    scene = SCENES[kind](number, seed)
    deck = folder / f"{kind}_{seed}_{number}.inp"
    deck.write_text(scene.deck(1.0))
    low, high = bounds_of(deck, count=300, passes=1)
    if not low > 0.0:
        raise Trouble("the bounds are not found")
    by = random.Random(f"factor {seed} {number}").uniform(1.15, 1.9) / (0.5 * (low + high))
    if max(soil.scaled(by).friction for soil in scene.soils) > LARGEST_FRICTION:
        raise Trouble("its angle of friction would be too large")
    deck.write_text(scene.deck(by))
    low, high = bounds_of(deck)
    out = folder / deck.stem
    ended = run_limited([program, "run", deck, "--out", out], SECONDS, folder)
    log = (out / "job.log").read_text().splitlines() if (out / "job.log").is_file() else [ended.errors]
    said = [line for line in log if line.startswith(("warning: phase", "warning: the")) or "neither equilibrium nor" in line or "after Davis it may" in line
            or "the factor is that of the deformed ground" in line]
    factor = math.nan
    if (out / "safety.json").is_file():
        found = json.loads((out / "safety.json").read_text())["phases"]
        factor = float(found[-1]["stable"]) if found else math.nan
    if ended.code != 0:
        said.append(f"{ended.how}: {log[-1] if log else ''}")
    return Result(number, scene, low, high, factor, ended.cpu, said)


def run_scenes(doc: str | None, scenes: list[str], solve: Callable[..., Any], head: list[str], title: str) -> int:
    """The command of a script of random scenes, the first one by default; `solve` gives a result with `held` and `row`, `head` begins its table."""
    words = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--scene", choices=scenes, default=scenes[0])
    words.add_argument("--count", type=int, default=20)
    words.add_argument("--seed", type=int, default=1)
    words.add_argument("--only", type=int, nargs="*")
    words.add_argument("--program", type=pathlib.Path, default=TOP / "build/qsmpm")
    words.add_argument("--keep", type=pathlib.Path, help="folder for decks and runs")
    words.add_argument("--markdown", type=pathlib.Path)
    given = words.parse_args()
    rows, failed, left = [], 0, 0
    print("\n".join(head))
    with tempfile.TemporaryDirectory() as name:
        folder = given.keep or pathlib.Path(name)
        folder.mkdir(parents=True, exist_ok=True)
        for number in given.only or range(given.count):
            try:
                found = solve(given.scene, number, given.seed, given.program.resolve(), folder.resolve())
            except Trouble as trouble:
                print(f"scene {number} left out: {trouble}", flush=True)
                left += 1
                continue
            failed += not found.held
            rows.append(found.row() + ("" if found.held else " **not reported**"))
            print(rows[-1], flush=True)
    if given.markdown:
        scene = "" if given.scene in ("ground", "column") else f" --scene {given.scene}"
        script = pathlib.Path(sys.argv[0]).name
        command = f"verification/{script}{scene} --count {given.count} --seed {given.seed} --markdown {given.markdown}"
        given.markdown.write_text(f"{title.format(given.scene)}, `{command}`.\n\n" + "\n".join(head + rows) + "\n")
    total = len(given.only or range(given.count))
    print(f"{total - failed - left} passed, {failed} failed" + (f", {left} skipped" if left else ""))
    return 1 if failed else 0


def main() -> int:
    head = ["| scene | ground | slope | psi | bounds | factor | off | CPU s | log |", "|---|---|---|---|---|---|---|---|---|"]
    return run_scenes(__doc__, list(SCENES), solve, head, "Factors of safety of random layered ground beside limit analysis")


if __name__ == "__main__":
    sys.exit(main())
