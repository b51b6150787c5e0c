"""`metamorphic`: scenes in other frames, units, orders, splits, grids, models and processes must answer the same.

verification/metamorphic/scenes.toml lists the scenes:

    [[scene]]
    name = "slope"
    deck = "verification/metamorphic/slope.inp"
    tolerance = 1e-7              largest difference of a history, over the largest value of those of its unit
    tolerances = {auto = 1e-3}    other ones of single relations
    quick = ["mirror"]            what `--quick` tries
    skip = {auto = "..."}         relations that do not hold here, and why
    expected_to_fail = {order = "..."}   faults that are known, with their figure: passed while they miss

The seed chooses where a scene is moved to and how its cards are shuffled.
"""

from __future__ import annotations

import argparse
import os
import random
import shutil
import tomllib
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from qsmpm_verify import frames
from qsmpm_verify.batch import checked_program
from qsmpm_verify.cases import CaseError, check_keys
from qsmpm_verify.cpu_limit import run_limited
from qsmpm_verify.judge import HOLDS_NOW
from qsmpm_verify.places import BUILD, METAMORPHIC, PROGRAM, TOP
from qsmpm_verify.report import table
from qsmpm_verify.results import Curves, ResultError, read_curves
from qsmpm_verify.study.cards import Deck, read_deck
from qsmpm_verify.trouble import Trouble

Change = Callable[[Deck, random.Random], Deck]
RELATIONS: dict[str, Change] = {
    "moved_1e3": lambda deck, chance: frames.translated(deck, 1e3, chance),
    "moved_1e5": lambda deck, chance: frames.translated(deck, 1e5, chance),
    "mirror": lambda deck, chance: frames.mirrored(deck),
    "turn_left": lambda deck, chance: frames.turned(deck, 1),
    "turn_right": lambda deck, chance: frames.turned(deck, -1),
    "units": lambda deck, chance: frames.in_units(deck),
    "order": frames.reordered,
    "split": lambda deck, chance: frames.split(deck),
    "larger_grid": lambda deck, chance: frames.enlarged(deck),
    "auto": lambda deck, chance: frames.whole_as_auto(deck),
}
RANKS = tuple(f"ranks_{n}" for n in range(1, 6))
OWN = {"phase", "step", "load_factor", "iterations", "out_of_balance", "damping_share", "stabilisation_share", "inaccurate_points",
       "step_error", "compliance", "external_work", "internal_work"}  # fmt: skip
"""Columns that are no histories; those of soil beside bodies are left out too."""
SECONDS = 60.0


@dataclass(frozen=True)
class Scene:
    """A deck and what must hold of it."""

    name: str
    deck: Path
    tolerance: float
    tolerances: dict[str, float] = field(default_factory=dict)
    quick: tuple[str, ...] = ()
    skip: dict[str, str] = field(default_factory=dict)
    expected_to_fail: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Finding:
    """How a relation came out: the history that differs most; `held` is None for one that could not be tried."""

    scene: str
    relation: str
    history: str
    difference: float
    tolerance: float
    held: bool | None
    note: str = ""


def load_scenes(path: Path) -> list[Scene]:
    """The scenes, read strictly."""
    listed = tomllib.loads(path.read_text(encoding="utf-8"))
    check_keys(listed, {"scene"}, str(path))
    scenes = []
    for entry in listed["scene"]:
        where = f"{path}, scene '{entry.get('name', '?')}'"
        check_keys(entry, set(Scene.__dataclass_fields__), where)
        for key in ("tolerances", "skip", "expected_to_fail", "quick"):
            for relation in entry.get(key, ()):
                if relation not in RELATIONS and relation not in RANKS:
                    raise CaseError(f"{where}: no relation '{relation}'; there are {', '.join((*RELATIONS, *RANKS))}")
        made: dict[str, Any] = {**entry, "deck": TOP / entry["deck"], "quick": tuple(entry.get("quick", ()))}
        scenes.append(Scene(**made))
    return scenes


def add_words(verbs: argparse._SubParsersAction) -> None:
    """Words of the verb."""
    verb = verbs.add_parser("metamorphic", help="scenes moved, mirrored, turned, in other units, orders, grids and processes answer the same")
    verb.add_argument("scenes", nargs="*", help="names; all when none is given")
    verb.add_argument("--seed", type=int, default=12, help="start of the random numbers")
    verb.add_argument("--quick", action="store_true", help="a selection of a few CPU seconds")
    verb.add_argument("--relation", action="append", choices=(*RELATIONS, *RANKS), help="these alone")
    verb.add_argument("--all", action="store_true", help="every history of every relation")
    verb.add_argument("--program", type=Path, default=PROGRAM, help="the program to run")
    verb.add_argument("--out", type=Path, default=BUILD / "metamorphic", help="folder of the runs")
    verb.set_defaults(act=act)


def run_deck(text: str, folder: Path, command: list[str]) -> Curves:
    """The curves of a deck."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    deck = folder / "deck.inp"
    deck.write_text(text, encoding="utf-8")
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    ended = run_limited([*command, "run", str(deck), "--out", str(folder / "results")], SECONDS, env=environment)
    if ended.code != 0:
        said = (ended.errors or ended.output).strip().splitlines()[-1:]
        raise ResultError(" ".join([ended.how + ":", *said])[:200])
    return read_curves(folder / "results")


def phase_ends(curves: Curves, deck: Deck) -> list[int]:
    """Rows at the ends of the phases; of one that is split at the end of its second half."""
    names = [dict(card.parameters).get("NAME", "") for card in deck.cards if card.keyword == "PHASE"]
    number = curves.column("phase")
    return [int(np.flatnonzero(number == i + 1)[-1]) for i, name in enumerate(names) if not name.endswith(" half") and np.any(number == i + 1)]


def differences(base: Curves, deck: Deck, other: Curves, changed: Deck) -> dict[str, float]:
    """The largest difference of every history, over the largest value of those of its unit."""
    names = [name for name in base.units if name not in OWN and not name.startswith("soil_")]
    same = len(base) == len(other) and np.array_equal(base.column("phase"), other.column("phase"))
    rows = [np.arange(len(base))] * 2 if same else [np.array(phase_ends(base, deck)), np.array(phase_ends(other, changed))]
    if len(rows[0]) != len(rows[1]):
        raise ResultError(f"{len(rows[0])} phases against {len(rows[1])}")
    largest: dict[str, float] = {}
    for name in names:
        unit = base.units[name] or name
        largest[unit] = max(largest.get(unit, 0.0), float(np.abs(base.column(name)).max()))
    found = {}
    for name in names:
        gap = np.abs(base.column(name)[rows[0]] - other.column(name)[rows[1]])
        found[name] = float(gap.max() / (largest[base.units[name] or name] or 1.0))
    return found


def changed_deck(relation: str, deck: Deck, seed: int) -> Deck:
    """The deck of a relation; its own random numbers, whatever else is tried."""
    return deck if relation in RANKS else RELATIONS[relation](deck, random.Random(f"{seed} {relation} {deck.path.name}"))


def try_relation(scene: Scene, relation: str, deck: Deck, base: Curves, program: Path, out: Path, seed: int) -> tuple[Finding, dict[str, float]]:
    """Run the other deck and compare."""
    tolerance = scene.tolerances.get(relation, scene.tolerance)
    command = [str(program)]
    if relation in RANKS:
        parallel = program.with_name("qsmpm-mpi")
        if not parallel.is_file():
            return Finding(scene.name, relation, "", np.nan, tolerance, None, "qsmpm-mpi is not built"), {}
        command = ["mpirun", "--oversubscribe", "--allow-run-as-root", "-n", relation.removeprefix("ranks_"), str(parallel)]
    try:
        other = changed_deck(relation, deck, seed)
        found = differences(base, deck, run_deck(other.text(), out / scene.name / relation, command), other)
    except ResultError as error:
        return _marked(scene, Finding(scene.name, relation, "", np.inf, tolerance, False, str(error))), {}
    worst = max(found, key=lambda name: found[name])
    return _marked(scene, Finding(scene.name, relation, worst, found[worst], tolerance, found[worst] <= tolerance)), found


def _marked(scene: Scene, finding: Finding) -> Finding:
    """What is known to fail passes while it fails."""
    mark = scene.expected_to_fail.get(finding.relation)
    if mark is None:
        return finding
    note = HOLDS_NOW if finding.held else f"expected: {mark}"
    return Finding(finding.scene, finding.relation, finding.history, finding.difference, finding.tolerance, not finding.held, note)


def relations_of(scene: Scene, words: argparse.Namespace) -> list[str]:
    """What is tried of a scene."""
    wanted = words.relation or (scene.quick if words.quick else (*RELATIONS, *RANKS))
    return [relation for relation in wanted if relation not in scene.skip]


def act(words: argparse.Namespace) -> int:
    """Try all, print, close. Exit code 1 when a relation does not hold."""
    program = checked_program(argparse.Namespace(program=words.program, jobs=1))
    scenes = load_scenes(METAMORPHIC / "scenes.toml")
    for name in words.scenes:
        if name not in [scene.name for scene in scenes]:
            raise Trouble(f"no scene '{name}'; there are {', '.join(scene.name for scene in scenes)}")
    findings: list[Finding] = []
    for scene in scenes:
        wanted = relations_of(scene, words)
        if (words.scenes and scene.name not in words.scenes) or not wanted:
            continue
        deck = read_deck(scene.deck)
        base = run_deck(deck.text(), words.out / scene.name / "as_it_is", [str(program)])
        for relation in wanted:
            finding, found = try_relation(scene, relation, deck, base, program, words.out, words.seed)
            findings.append(finding)
            for name, value in sorted(found.items()) if words.all else ():
                print(f"  {scene.name} {relation} {name}: {value:.1e}")
    return tell(findings, words.seed)


def tell(findings: list[Finding], seed: int) -> int:
    """The table and the closing line."""
    sign = {True: "held", False: "FAILED", None: "skipped"}
    rows = [[f.scene, f.relation, f.history or "-", f"{f.difference:.1e}", f"{f.tolerance:.0e}", sign[f.held], f.note] for f in findings]
    print(table(["scene", "relation", "history", "difference", "tolerance", "verdict", "note"], rows))
    held, failed, skipped = (sum(f.held is value for f in findings) for value in (True, False, None))
    print(f"seed {seed}")
    print(f"{held} passed, {failed} failed" + (f", {skipped} skipped" if skipped else ""))
    return 1 if failed else 0
