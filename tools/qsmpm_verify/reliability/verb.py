"""Arguments of `reliability`: DECK, VARIABLES, --runs, --seed, --jobs, --out."""

from __future__ import annotations

import argparse
import json
import math
import os
import tomllib
from pathlib import Path
from typing import Any

import numpy as np

from qsmpm_verify.editor.table import read_table
from qsmpm_verify.places import PROGRAM
from qsmpm_verify.reliability.fields import Field, read_field, with_partners
from qsmpm_verify.reliability.form import SAMPLES, SEED, Form, Sample, find_design, hypercube, shares
from qsmpm_verify.reliability.picture import draw
from qsmpm_verify.reliability.runs import Response, Runs, read_response
from qsmpm_verify.reliability.variables import Space, make_space, read_variable
from qsmpm_verify.study.cards import read_deck
from qsmpm_verify.trouble import RunFailed, Trouble


def add_words(verbs: argparse._SubParsersAction) -> None:
    """Arguments of the subcommand."""
    verb = verbs.add_parser("reliability", help="compute the probability that a result of a deck exceeds its limit: FORM, response surface, Monte Carlo")
    verb.add_argument("deck", type=Path, help="deck to be analysed")
    verb.add_argument("variables", type=Path, help="uncertain parameters, their correlation and the limit (TOML)")
    verb.add_argument("--runs", type=int, default=0, metavar="N", help="Monte Carlo with N runs (Latin hypercube) instead of the search")
    verb.add_argument("--seed", type=int, default=1, help="seed of the hypercube and of fields (default 1)")
    verb.add_argument("--jobs", type=int, default=max(1, (os.cpu_count() or 2) // 2), help="number of parallel runs")
    verb.add_argument("--out", type=Path, help="folder of the runs, the figure and reliability.json (default output/reliability/DECK)")
    verb.add_argument("--program", type=Path, default=PROGRAM, help="program to run")
    verb.set_defaults(act=act)


def read_question(path: Path) -> tuple[Space, list[Field], Response]:
    """Variables, correlations, fields and response of the file."""
    try:
        table: dict[str, Any] = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise Trouble(f"{path}: {error.strerror}") from error
    except tomllib.TOMLDecodeError as error:
        raise Trouble(f"{path}: {error}") from error
    unknown = [key for key in table if key not in ("variable", "field", "correlation", "response")]
    if unknown or not (table.get("variable") or table.get("field")):
        raise Trouble(f"{path}: {f'unknown table {unknown[0]}' if unknown else 'neither [[variable]] nor [[field]]'}")
    try:
        pairs = [(str(c["between"][0]), str(c["between"][1]), float(c["rho"])) for c in table.get("correlation", [])]
        fields = [read_field(f) for f in table.get("field", [])]
        scattered = {field.variable.name for field in fields}
        space = make_space([read_variable(v) for v in table.get("variable", [])], [pair for pair in pairs if not scattered.issuperset(pair[:2])])
        fields = with_partners(fields, [pair for pair in pairs if scattered.issuperset(pair[:2])])
        return space, fields, read_response(table.get("response", {}))
    except (KeyError, IndexError, TypeError, ValueError) as error:
        raise Trouble(f"{path}: {error}") from error
    except Trouble as trouble:
        raise Trouble(f"{path}: {trouble}") from trouble


def act(words: argparse.Namespace) -> int:
    """Run, evaluate, report; exit code 3 if required runs have no result."""
    space, fields, response = read_question(words.variables)
    if fields and not words.runs:
        raise Trouble(f"{words.variables}: a random field requires sampling, for example --runs 200")
    root = words.out or Path("output") / "reliability" / words.deck.stem
    runs = Runs(read_deck(words.deck), space, response, read_table(words.program), words.program.resolve(), root, max(1, words.jobs), fields, words.seed)
    names = [variable.name for variable in space.variables]
    told: dict[str, Any]
    try:
        if words.runs:
            told, margins = sample(runs, words.runs, words.seed)
        else:
            form = find_design(runs.margins, len(names))
            told = told_form(form, space)
            margins = form.surface.at(np.random.default_rng(SEED).standard_normal((SAMPLES, len(names))))
    except RunFailed as trouble:
        raise RunFailed(f"{words.deck}: {trouble}; message of the program: {runs.reasons[-1] if runs.reasons else 'none'}") from trouble
    told["runs"], told["runs without an answer"] = runs.made, runs.failed
    side = "below" if response.fails_below else "above"
    told["fails"] = f"{response.quantity} {side} {response.limit:g}"
    root.mkdir(parents=True, exist_ok=True)
    (root / "reliability.json").write_text(json.dumps(told, indent=2) + "\n", encoding="utf-8")
    picture = draw(told["alpha"], margins, f"margin of {response.quantity} to {response.limit:g}", title_of(told), root / "reliability.png")
    for key, value in told.items():
        print(f"{key:<24}{text_of(value)}")
    print(f"{'picture':<24}{picture}")
    return 0


def told_form(form: Form, space: Space) -> dict[str, Any]:
    """Result of the search."""
    names = [variable.name for variable in space.variables]
    return {
        "beta": form.beta, "probability, first order": form.first_order, "probability, sampled": form.probability,
        "alpha": shares(form.alpha, names), "design point": shares(space.values(form.design), names),
        "settled": form.settled,
    }  # fmt: skip


def sample(runs: Runs, count: int, seed: int) -> tuple[dict[str, Any], np.ndarray]:
    """Result of Monte Carlo sampling; a run without a result counts as failed."""
    u = hypercube(len(runs.space.variables), count, seed)
    found = Sample(runs.space.values(u), runs.margins(u))
    known = np.isfinite(found.margins)
    if known.sum() < 3:
        raise RunFailed("fewer than three runs have a result")
    names = [variable.name for variable in runs.space.variables]
    slope = np.linalg.lstsq(np.hstack([np.ones((known.sum(), 1)), u[known]]), found.margins[known], rcond=None)[0][1:]
    mean, sd = float(found.margins[known].mean()), float(found.margins[known].std(ddof=1))
    told = {
        "probability": found.probability, "its standard error": found.error, "mean margin": mean, "standard deviation": sd,
        "beta of these two": mean / sd if sd else math.inf,
        "alpha": shares(-slope / max(float(np.linalg.norm(slope)), 1.0e-300), names),
    }  # fmt: skip
    return told, found.margins


def title_of(told: dict[str, Any]) -> str:
    """Title of the figure."""
    head = f"beta {told['beta']:.3g}, probability {told['probability, sampled']:.3g}" if "beta" in told else f"probability {told['probability']:.3g}"
    return f"{head}; fails: {told['fails']}; {told['runs']} runs"


def text_of(value: Any) -> str:
    """A value as printed."""
    if isinstance(value, dict):
        return ", ".join(f"{name} {number:.4g}" for name, number in value.items())
    return f"{value:.4g}" if isinstance(value, float) else str(value)
