"""`metamorphic`: transformed scenes (frames, units, orders, splits, grids, models, processes) must give the same results.

verification/metamorphic/scenes.toml lists the scenes:

    [[scene]]
    name = "slope"
    deck = "verification/metamorphic/slope.inp"
    tolerance = 1e-7              largest difference of a history, divided by the largest value of the histories of its unit
    tolerances = {auto = 1e-3}    different tolerances for single relations
    quick = ["mirror"]            relations run by `--quick`
    skip = {auto = "..."}         relations that do not hold here, with reason
    expected_to_fail = {order = "..."}   known defects with their value: passed while they miss

The seed selects the translation of a scene and the order of its keywords.
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
"""Columns that are not histories; those of soil beside bodies are omitted too."""
SECONDS = 60.0


@dataclass(frozen=True)
class Scene:
    """A deck and the relations that must hold for it."""

    name: str
    deck: Path
    tolerance: float
    tolerances: dict[str, float] = field(default_factory=dict)
    quick: tuple[str, ...] = ()
    skip: dict[str, str] = field(default_factory=dict)
    expected_to_fail: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Finding:
    """Outcome of a relation: the history with the largest difference; `held` is None if it could not be run."""

    scene: str
    relation: str
    history: str
    difference: float
    tolerance: float
    held: bool | None
    note: str = ""


def load_scenes(path: Path) -> list[Scene]:
    """The scenes, with strict checks."""
    listed = tomllib.loads(path.read_text(encoding="utf-8"))
    check_keys(listed, {"scene"}, str(path))
    scenes = []
    for entry in listed["scene"]:
        where = f"{path}, scene '{entry.get('name', '?')}'"
        check_keys(entry, set(Scene.__dataclass_fields__), where)
        for key in ("tolerances", "skip", "expected_to_fail", "quick"):
            for relation in entry.get(key, ()):
                if relation not in RELATIONS and relation not in RANKS:
                    raise CaseError(f"{where}: unknown relation '{relation}'; known are {', '.join((*RELATIONS, *RANKS))}")
        made: dict[str, Any] = {**entry, "deck": TOP / entry["deck"], "quick": tuple(entry.get("quick", ()))}
        scenes.append(Scene(**made))
    return scenes


def add_words(verbs: argparse._SubParsersAction) -> None:
    """Arguments of the subcommand."""
    verb = verbs.add_parser("metamorphic", help="check that translated, mirrored, rotated scenes, other units, orders, grids and processes give the same results")
    verb.add_argument("scenes", nargs="*", help="names; default all")
    verb.add_argument("--seed", type=int, default=12, help="seed of the random numbers")
    verb.add_argument("--quick", action="store_true", help="a selection that takes a few CPU seconds")
    verb.add_argument("--relation", action="append", choices=(*RELATIONS, *RANKS), help="only these relations")
    verb.add_argument("--all", action="store_true", help="print every history of every relation")
    verb.add_argument("--program", type=Path, default=PROGRAM, help="program to run")
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
    """Rows at the ends of the phases; for a split phase at the end of its second half."""
    names = [dict(card.parameters).get("NAME", "") for card in deck.cards if card.keyword == "PHASE"]
    number = curves.column("phase")
    return [int(np.flatnonzero(number == i + 1)[-1]) for i, name in enumerate(names) if not name.endswith(" half") and np.any(number == i + 1)]


def differences(base: Curves, deck: Deck, other: Curves, changed: Deck) -> dict[str, float]:
    """The largest difference of every history, divided by the largest value of the histories of its unit."""
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
    """The deck of a relation; its random numbers do not depend on the other relations."""
    return deck if relation in RANKS else RELATIONS[relation](deck, random.Random(f"{seed} {relation} {deck.path.name}"))


def try_relation(scene: Scene, relation: str, deck: Deck, base: Curves, program: Path, out: Path, seed: int) -> tuple[Finding, dict[str, float]]:
    """Run the transformed deck and compare."""
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
    """A known defect passes while it fails."""
    mark = scene.expected_to_fail.get(finding.relation)
    if mark is None:
        return finding
    note = HOLDS_NOW if finding.held else f"expected: {mark}"
    return Finding(finding.scene, finding.relation, finding.history, finding.difference, finding.tolerance, not finding.held, note)


def relations_of(scene: Scene, words: argparse.Namespace) -> list[str]:
    """The relations to run for a scene."""
    wanted = words.relation or (scene.quick if words.quick else (*RELATIONS, *RANKS))
    return [relation for relation in wanted if relation not in scene.skip]


def act(words: argparse.Namespace) -> int:
    """Run all, print, report. Exit code 1 if a relation does not hold."""
    program = checked_program(argparse.Namespace(program=words.program, jobs=1))
    scenes = load_scenes(METAMORPHIC / "scenes.toml")
    for name in words.scenes:
        if name not in [scene.name for scene in scenes]:
            raise Trouble(f"unknown scene '{name}'; known are {', '.join(scene.name for scene in scenes)}")
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
