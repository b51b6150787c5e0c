"""Points of limit analysis for the charts: the bound farther from the reference, against the CPU seconds of both, mesh by mesh."""

from __future__ import annotations

import hashlib
from pathlib import Path

from qsmpm_verify.bounds.phases import read_scene
from qsmpm_verify.bounds.search import Search
from qsmpm_verify.cache import keep, kept
from qsmpm_verify.reference import REFERENCES
from qsmpm_verify.studies import Other, Study
from qsmpm_verify.study.cards import read_deck
from qsmpm_verify.trouble import Trouble

PASSES = range(4)


def bound_points(study: Study, folder: Path) -> list[Other]:
    """The limit-analysis line of a study that requests it, kept while deck and programs are unchanged."""
    reference = study.error.reference
    if not study.bounds:
        return []
    if not isinstance(reference, dict) or "function" not in reference:
        raise Trouble(f"study {study.name}: bounds require a function as reference")
    deck = study.methods[0].entries[0].case.deck
    exact = REFERENCES[reference["function"]](**{name: value for name, value in reference.items() if name != "function"})
    key = hashlib.sha256(deck.read_bytes())
    for path in sorted(Path(__file__).parent.glob("*.py")):
        key.update(path.read_bytes())
    record = folder / f"{study.name}_bounds.json"
    content = kept(record, key.hexdigest())
    if not content:
        content = {"key": key.hexdigest(), "points": [point_of(deck, passes, exact / study.bounds) for passes in PASSES]}
        folder.mkdir(parents=True, exist_ok=True)
        keep(record, content)
    return [Other("limit analysis, the farther bound", tuple((n, error, seconds) for n, error, seconds in content["points"]),
                  "Rigorous upper and lower bounds; the size is the number of triangles.", "qsmpm-verify bounds", "run")]  # fmt: skip


def point_of(deck: Path, passes: int, exact: float) -> tuple[float, float, float]:
    """Triangles, error of the farther bound, and CPU seconds of both; the mesh is bisected the given number of times before."""
    found = Search(read_scene(read_deck(deck)), passes=passes).run()
    if not found.both:
        raise Trouble(f"{deck.name}: the optimisation problems of limit analysis were not solved")
    error = max(abs(bound.value / exact - 1.0) for bound in (found.upper, found.lower))
    return float(found.triangles), error, found.upper.seconds + found.lower.seconds
