"""Points of other programs for the charts: results stored by `qsmpm-verify peers --json`, and Kratos run immediately.

build/peers.json contains {"points": [{"study": "cantilever", "label": "Kratos MPM", "error": ..., "seconds": ...,
"note": ..., "size": ...}]}; the size is optional. Kratos is run by the scripts of tools/peers in the environment
of `tools/setup --peers`; the output of a script is kept as long as script, arguments and interpreter are unchanged.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from qsmpm_verify.cache import keep, kept
from qsmpm_verify.places import BUILD, TOP
from qsmpm_verify.reference.beam import beam_deflection
from qsmpm_verify.studies import Other, Study
from qsmpm_verify.trouble import RunFailed, Trouble

STORED = BUILD / "peers.json"
SCRIPTS = TOP / "tools" / "peers"


def default_python() -> Path:
    """The interpreter with Kratos: QSMPM_PEERS_PYTHON, or that of the tree."""
    return Path(os.environ.get("QSMPM_PEERS_PYTHON") or TOP / ".venv-peers" / "bin" / "python")


@dataclass(frozen=True)
class KratosScene:
    """A script of tools/peers for the scene of a study: its arguments for each size, and the error of its output."""

    script: str
    label: str
    runs: tuple[tuple[float, tuple[str, ...]], ...]
    error: Callable[[float, dict[str, Any]], float]
    note: str


def printed_error(cells: float, figures: dict[str, Any]) -> float:
    """The script prints the error of the study."""
    return float(figures["error"])


def cantilever_error(cells: float, figures: dict[str, Any]) -> float:
    """Difference from the reference of the study, converted to a beam that is shorter by half of the width of a point.

    The script loads and evaluates the outermost of six points per cell; Reissner's beam gives the difference.
    """
    shorter = 10.0 - 0.5 / (6.0 * cells)
    ratio = beam_deflection(100.0, shorter, 1.0, 12000.0, 0.2) / beam_deflection(100.0, 10.0, 1.0, 12000.0, 0.2)
    return abs(float(figures["down"]) / (8.2539 * ratio) - 1.0)


SCENES = {
    "column": KratosScene(
        "kratos_column.py", "Kratos, standard MPM, 4 points",
        ((16, ("16", "4")), (32, ("32", "4")), (64, ("64", "4")), (128, ("128", "4"))), printed_error,
        "Neo-Hookean law: the exact stress is the same; whole process.",
    ),
    "cantilever": KratosScene(
        "kratos_cantilever.py", "Kratos, standard MPM, 36 points", ((2, ("0.5", "36")), (4, ("0.25", "36"))),
        cantilever_error,
        "Neo-Hookean law; load and evaluation at the outermost points, the reference converted to these points; whole process.",
    ),
    "cube": KratosScene(
        "kratos_cube.py", "Kratos, standard MPM, 16 points", ((2, ("2", "16")), (4, ("4", "16")), (8, ("8", "16"))), printed_error,
        "Plane model; neo-Hookean law, compared with its own exact stress; whole process.",
    ),
}  # fmt: skip
"""Scripts by study."""


def grouped(points: Iterable[dict[str, Any]], where: str) -> list[Other]:
    """Points by their label; an invalid point is an error."""
    lines: dict[str, list[tuple[float, float, float]]] = {}
    notes: dict[str, str] = {}
    for point in points:
        try:
            label, error, seconds = str(point["label"]), float(point["error"]), float(point["seconds"])
            size = float(point.get("size") or math.nan)
        except (KeyError, TypeError, ValueError, AttributeError):
            raise Trouble(f"{where}: a point requires a label, an error and seconds: {point}") from None
        if not (error > 0 and seconds > 0 and math.isfinite(error * seconds)):
            raise Trouble(f"{where}: error and seconds of '{label}' must be positive")
        lines.setdefault(label, []).append((size, error, seconds))
        notes.setdefault(label, str(point.get("note", "")))
    return [
        Other(label, tuple(sorted(found, key=lambda p: p[2])), notes[label], where, "run")
        for label, found in lines.items()
    ]


def peer_points(study: str, stored: Path = STORED) -> list[Other]:
    """Points of a study stored by `qsmpm-verify peers --json build/peers.json`; none if it has not been run."""
    if not stored.is_file():
        return []
    try:
        points = json.loads(stored.read_text(encoding="utf-8"))["points"]
        own = [point for point in points if point["study"] == study]
    except (ValueError, KeyError, TypeError) as error:
        raise Trouble(f"{stored}: not a file of `qsmpm-verify peers --json` ({error!r})") from error
    return grouped(own, stored.name)


def _kratos(python: Path, script: Path, words: tuple[str, ...], folder: Path) -> dict[str, Any]:
    """Output of a script, with its CPU seconds; kept as long as its dependencies are unchanged."""
    from qsmpm_bench.measure import BenchError, run_script

    key = hashlib.sha256()
    for path in (script, SCRIPTS / "kratos_scene.py", SCRIPTS / "requirements.txt"):
        key.update(path.read_bytes())
    key.update(" ".join([str(python), *words]).encode())
    record = folder / f"{script.stem}_{'_'.join(words)}.json"
    content = kept(record, key.hexdigest())
    if content and "figures" in content:
        return dict(content["figures"])
    try:
        sample = run_script([str(python), str(script), *words], record.with_suffix(".txt"), 600.0)
    except BenchError as error:
        raise RunFailed(str(error)) from error
    figures = {**sample.figures, "cpu_seconds": sample.cpu}
    keep(record, {"key": key.hexdigest(), "figures": figures})
    return figures


def live_points(study: str, python: Path, folder: Path, tell: Callable[[str], None]) -> list[Other]:
    """Results of Kratos for the scene of a study; none without a script for the study."""
    if study not in SCENES:
        return []
    if not python.is_file():
        raise Trouble(f"{python} not found: run tools/setup --peers, or set QSMPM_PEERS_PYTHON")
    scene = SCENES[study]
    points = []
    for size, words in scene.runs:
        tell(f"{scene.script} {' '.join(words)}")
        figures = _kratos(python, SCRIPTS / scene.script, words, folder)
        points.append({"label": scene.label, "size": size, "error": scene.error(size, figures),
                       "seconds": figures["cpu_seconds"], "note": scene.note})  # fmt: skip
    return grouped(points, f"tools/peers/{scene.script}")


def with_peers(study: Study, live: bool, out: Path, tell: Callable[[str], None]) -> Study:
    """The study with the available points of other programs; a program run here replaces its stored
    results of the same label."""
    found = peer_points(study.name) + (live_points(study.name, default_python(), out, tell) if live else [])
    fresh = {other.label for other in found}
    return replace(study, others=tuple(o for o in study.others if o.label not in fresh) + tuple(found))
