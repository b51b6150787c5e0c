"""Run the computations of a scene with their programs and evaluate their results."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from qsmpm_verify import peers_calculix, peers_kratos, peers_ogs, peers_xslope
from qsmpm_verify.cache import program_hash
from qsmpm_verify.cases import Case
from qsmpm_verify.peers_model import Model, Solution, read_model, read_own
from qsmpm_verify.peers_runs import run_peer
from qsmpm_verify.peers_scenes import PeerRun, Scene
from qsmpm_verify.places import TOP
from qsmpm_verify.results import read_curves
from qsmpm_verify.runner import deck_text
from qsmpm_verify.trouble import RunFailed, Trouble

VERSIONS = {
    "calculix": peers_calculix.version, "kratos": peers_kratos.version, "ogs": peers_ogs.version, "xslope": peers_xslope.version,
    "script": peers_kratos.version,
}  # fmt: skip
NAMES = {
    "calculix": "CalculiX (Debian package calculix-ccx, tools/setup)", "kratos": "Kratos (tools/setup --peers)",
    "ogs": "OpenGeoSys (tools/setup --peers)", "xslope": "xslope (tools/setup --peers)", "script": "Kratos (tools/setup --peers)",
}  # fmt: skip


@dataclass(frozen=True)
class Outcome:
    """Result of a run; `trouble` states why there is none, `absent` that the program is not installed, `said` its remarks on the result."""

    program: str
    cpu_seconds: float = 0.0
    reused: bool = False
    figures: dict[str, Any] = field(default_factory=dict)
    solution: Solution | None = None
    trouble: str = ""
    absent: bool = False
    said: str = ""


class Computer:
    """Runs the computations of scenes once each; a run of another program uses the model of the run named by `of`."""

    def __init__(self, program: Path, root: Path, fresh: bool, tell: Callable[[str, float, bool], None]) -> None:
        self.program, self.root, self.fresh, self.tell = program, root, fresh, tell
        self.folders: dict[str, Path] = {}
        self.models: dict[str, Model] = {}

    def scene(self, scene: Scene, efforts: tuple[str, ...]) -> dict[str, Outcome]:
        """Results of the runs of the requested efforts."""
        outcomes: dict[str, Outcome] = {}
        for name, run in scene.runs.items():
            if run.effort in efforts:
                outcomes[name] = self._outcome(scene, run, outcomes)
                self.tell(f"{scene.name}/{name}", outcomes[name].cpu_seconds, outcomes[name].reused)
        return outcomes

    def _outcome(self, scene: Scene, run: PeerRun, before: dict[str, Outcome]) -> Outcome:
        folder = self.root / scene.name / run.name.replace(" ", "_")
        named = VERSIONS.get(run.program, lambda: "QSMPM")()
        if not named:
            return Outcome(run.program, trouble=f"not installed: {NAMES[run.program]}", absent=True)
        try:
            if run.program == "qsmpm":
                return self._own(scene, run, folder)
            if run.program == "script":
                return self._script(run, folder, named)
            source = before.get(run.words["of"])
            if source is None or source.trouble:
                return Outcome(named, trouble=f"{run.words['of']}: {source.trouble if source else 'not run'}")
            if run.program in ("bounds", "xslope"):
                deck = self.folders[f"{scene.name}/{run.words['of']}"].parent / "scene.inp"
                answer = peers_xslope.bounds if run.program == "bounds" else peers_xslope.solve
                figures, done = answer(deck, folder, run.words, self.fresh)
                return Outcome(named, done.cpu_seconds, done.reused, figures, said=peers_xslope.said(figures))
            return self._peer(scene, run, folder, named)
        except (RunFailed, OSError, ValueError) as error:
            return Outcome(named, trouble=str(error))

    def _own(self, scene: Scene, run: PeerRun, folder: Path) -> Outcome:
        deck = TOP / run.words["deck"] if "deck" in run.words else scene.deck
        case = Case(run.name, scene.title, deck, (), replace=tuple((a, str(b)) for a, b in run.words.get("replace", [])))
        files = {"scene.inp": deck_text(case)}
        for name, script, *words in run.words.get("make", []):
            files[name] = _printed(TOP / script, words)
        command = [str(self.program), "run", "scene.inp", "--out", "results", "--threads", "1", "--quiet"]
        done = run_peer(command, program_hash(self.program), files, ["results/curves.csv"], folder, fresh=self.fresh)
        results = folder / "results"
        self.folders[f"{scene.name}/{run.name}"] = results
        curves = read_curves(results)
        figures = {name: float(values[-1]) for name, values in curves.columns.items()}
        if (results / "safety.json").is_file():
            phases = json.loads((results / "safety.json").read_text(encoding="utf-8"))["phases"]
            figures |= {"factor": float(phases[-1]["stable"]), "upper": float(phases[-1]["lost"] or "nan")}
        fem = "BASIS=FEM" in files["scene.inp"].upper()
        return Outcome("QSMPM", done.cpu_seconds, done.reused, figures, read_own(results) if fem else None, said=peers_xslope.said(figures))

    def _peer(self, scene: Scene, run: PeerRun, folder: Path, named: str) -> Outcome:
        source = f"{scene.name}/{run.words['of']}"
        if source not in self.models:
            self.models[source] = read_model(self.folders[source])
        model, steps = self.models[source], int(run.words.get("steps", 0))
        if run.program == "ogs":
            solution, done = peers_ogs.solve(model, folder, self.fresh)
        elif model.flow:
            raise RunFailed(f"{run.name}: groundwater flow is supported with OpenGeoSys only")
        elif run.program == "calculix":
            solution, done = peers_calculix.solve(
                model, folder, run.words.get("element", ""), run.words.get("law", "ELASTIC"), steps, self.fresh
            )
        else:
            element = run.words.get("element") or ("TotalLagrangianElement" if steps else "SmallDisplacementElement")
            solution, done = peers_kratos.solve(model, folder, element, max(1, steps), self.fresh)
        figures = {
            name: scale * float(solution.displacement[node, axis]) for name, (node, axis, scale) in model.places.items()
        }
        return Outcome(named, done.cpu_seconds, done.reused, figures, solution)

    def _script(self, run: PeerRun, folder: Path, named: str) -> Outcome:
        figures, done = peers_kratos.run_script([str(word) for word in run.words["command"]], folder, 1200.0, self.fresh)
        if figures.get("ended", "done") != "done":
            return Outcome(named, done.cpu_seconds, done.reused, figures, trouble=f"ended with: {figures['ended']}")
        return Outcome(named, done.cpu_seconds, done.reused, figures)


def _printed(script: Path, words: list[str]) -> str:
    """Output of a script of the tree."""
    done = subprocess.run([sys.executable, str(script), *words], capture_output=True, text=True, timeout=120, check=False)
    if done.returncode != 0:
        raise Trouble(f"{script.name}: {done.stderr.strip()[-120:]}")
    return done.stdout
