"""Arguments of `study`: DECK, --history, --at, --target, --budget."""

from __future__ import annotations

import argparse
import re
import sys
from pathlib import Path

from qsmpm_verify.bounds.verb import note_of
from qsmpm_verify.places import PROGRAM
from qsmpm_verify.study.cards import read_deck
from qsmpm_verify.study.judgement import answer_of, choice_of, seconds_of_choice, warnings_of, within_bounds
from qsmpm_verify.study.search import FACTOR, Search, Trial, Wish
from qsmpm_verify.study.telling import grid_text, tell_study
from qsmpm_verify.trouble import RunFailed, Trouble

SECONDS = {"s": 1.0, "min": 60.0, "h": 3600.0}


def add_words(verbs: argparse._SubParsersAction) -> None:
    """Arguments of the subcommand."""
    verb = verbs.add_parser("study", help="run a deck with several grids, methods and steps: result, error and cost")
    verb.add_argument("deck", type=Path, help="deck to be analysed")
    verb.add_argument("--history", required=True, metavar="NAME", help="requested column of curves.csv")
    verb.add_argument("--at", choices=("last", "max", "min"), default="last", help="position at which it is read (default last)")
    verb.add_argument("--target", type=share, default=0.01, metavar="1%%", help="target error (default 1%%)")
    verb.add_argument("--budget", type=seconds, default=600.0, metavar="10min", help="time budget of all runs (default 10min)")
    verb.add_argument("--out", type=Path, help="folder of the runs (default output/study/DECK)")
    verb.add_argument("--program", type=Path, default=PROGRAM, help="program to run")
    verb.add_argument("--fresh", action="store_true", help="repeat runs that are already available")
    verb.set_defaults(act=act)


def share(word: str) -> float:
    """1% or 0.01."""
    hit = re.fullmatch(r"([\d.]+(?:[eE]-?\d+)?)\s*(%?)", word.strip())
    value = float(hit[1]) * (0.01 if hit[2] else 1.0) if hit else 0.0
    if not 0.0 < value < 1.0:
        raise argparse.ArgumentTypeError(f"'{word}' is not a fraction such as 1% or 0.01")
    return value


def seconds(word: str) -> float:
    """90s, 10min, 2h or a number of seconds."""
    hit = re.fullmatch(r"([\d.]+)\s*(s|min|h)?", word.strip())
    if not hit or float(hit[1]) <= 0.0:
        raise argparse.ArgumentTypeError(f"'{word}' is not a time such as 90s, 10min or 2h")
    return float(hit[1]) * SECONDS[hit[2] or "s"]


def tell_run(trial: Trial, spent: float) -> None:
    """One line for each run during the search."""
    told = f"{trial.figure:.6g}, {trial.seconds:.3g} CPU s" if trial.good else trial.reason[:100]
    print(f"{trial.method}, grid {grid_text(trial)}, steps {trial.steps}x: {told} ({spent:.0f} s used)", file=sys.stderr)


def act(words: argparse.Namespace) -> int:
    """Search, assess, report; exit code 1 if no run is within the target, 3 if none has a result."""
    if not words.program.is_file():
        raise Trouble(f"{words.program} not found: build it first (tools/test or cmake --build build)")
    deck = read_deck(words.deck)
    root = words.out or Path("output") / "study" / words.deck.stem
    wish = Wish(words.history, words.at, words.target, words.budget, words.program.resolve(), root, words.fresh)
    search = Search(deck, wish, tell_run)
    search.go(lambda trials: seconds_of_choice(trials, wish.target))
    if not any(t.good for t in search.trials):
        first = search.trials[0].reason if search.trials else search.ending
        raise RunFailed(f"{words.deck}: no run gave a result; message of the first: {first}")
    answer = answer_of(search.trials)
    note, bounds = note_of(deck, wish.history == FACTOR, answer.value if answer else None, wish.history)
    answer = within_bounds(answer, bounds)
    choice = choice_of(search.trials, answer, wish.target)
    notes = [*warnings_of(deck), *filter(None, [note])]
    tell_study(search, answer, choice, notes)
    return 0 if choice else 1
