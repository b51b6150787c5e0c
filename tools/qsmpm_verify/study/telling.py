"""Output of a study: tables, the chart of error against cost, figures.json and the deck of the selected run."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import matplotlib.pyplot as plt

from qsmpm_verify.drawing import MARKS
from qsmpm_verify.plots import save, set_ticks
from qsmpm_verify.report import table
from qsmpm_verify.study.judgement import Answer, bands_by_method
from qsmpm_verify.study.search import Search, Trial, Wish


def grid_text(trial: Trial) -> str:
    """Number of cells along an axis relative to the deck: 2x, or 1/2."""
    return f"{2**trial.level}x" if trial.level >= 0 else f"1/{2**-trial.level}"


def run_rows(trials: Sequence[Trial], answer: Answer | None, choice: Trial | None) -> list[list[str]]:
    """One row for each run."""
    return [
        [t.method, grid_text(t), f"{t.steps}x", f"{t.figure:.6g}" if t.good else "-",
         f"{answer.error(t):.2e}" if answer and t.good else "-", f"{t.seconds:.3g}" if t.good else "-",
         "choice" if t == choice else t.reason[:80]]
        for t in trials
    ]  # fmt: skip


RUN_HEADER = ["method", "grid", "steps", "figure", "error", "CPU s", "note"]


def band_rows(trials: Sequence[Trial]) -> list[list[str]]:
    """One row for each method with two or more grids: the limit of its results."""
    return [
        [method, *([f"{b.value:.6g}", f"{b.half:.2g}", b.note] if b else ["-", "-", "does not converge on these grids"])]
        for method, b in bands_by_method(trials).items()
    ]


def said(search: Search, answer: Answer | None, choice: Trial | None, warnings: Sequence[str]) -> list[str]:
    """The sentences below the tables, beginning with the result."""
    wish = search.wish
    lines = []
    if answer is None:
        lines.append(f"{wish.history}: no result: no method converges on the grids that were run")
    else:
        lines.append(f"{wish.history} = {answer.value:.6g} +- {answer.half:.2g} ({100 * answer.share:.2g} %), of which "
                     f"{answer.grids:.2g} from the grids" + ("" if answer.steps is None else
                     f"; doubling the steps changes it by {answer.steps:.2g}"))
        lines += list(answer.notes)
    if choice is not None:
        lines.append(f"cheapest within {100 * wish.target:g} %: {choice.method}, grid {grid_text(choice)}, steps "
                     f"{choice.steps}x: {choice.seconds:.3g} CPU s")
    else:
        lines.append(f"no run is reliably within {100 * wish.target:g} %; a larger --target or a larger --budget may help")
    return [*lines, *(f"note: {w}" for w in warnings), f"ended: {search.ending}; {search.spent:.0f} s were used"]


def draw_study(trials: Sequence[Trial], answer: Answer, choice: Trial | None, wish: Wish, title: str, path: Path) -> Path:
    """Error against CPU seconds, one line for each method; errors below the band of the result cannot be distinguished from it."""
    figure, axes = plt.subplots(figsize=(8.6, 4.8))
    good = [t for t in trials if t.good]
    least = max(answer.share, 1e-12)

    def place(t: Trial) -> tuple[float, float]:
        return max(t.seconds, 1e-3), max(answer.error(t), 0.3 * least)

    for number, method in enumerate(dict.fromkeys(t.method for t in good)):
        own, colour = [t for t in good if t.method == method and t.steps == 1], f"C{number % 10}"
        axes.loglog(*zip(*map(place, own)), "-" + MARKS[number % len(MARKS)], color=colour, ms=5, lw=1.2, gid=f"runs-{number}")
        axes.annotate(method, place(own[-1]), fontsize=8, color=colour, xytext=(6, 6), textcoords="offset points")
    for t in (t for t in good if t.steps > 1):
        axes.loglog(*place(t), "x", color="0.3", ms=7)
        axes.annotate(f"{t.steps}x steps", place(t), fontsize=7, color="0.3", xytext=(6, -9), textcoords="offset points")
    if choice is not None:
        axes.loglog(*place(choice), "o", mfc="none", color="tab:green", ms=13, mew=1.5)
    axes.axhline(wish.target, color="tab:green", lw=1, ls="--")
    axes.margins(x=0.2)
    bottom = 0.2 * least
    axes.axhspan(bottom, least, color="0.88", zorder=0)
    axes.set_ylim(bottom, 2 * max(wish.target, *(place(t)[1] for t in good)))
    set_ticks(axes.xaxis, *axes.get_xlim())
    set_ticks(axes.yaxis, *axes.get_ylim())
    axes.set_xlabel("CPU time of one core [s]")
    axes.set_ylabel(f"error of {wish.history} [-]")
    axes.set_title(f"{title}: {wish.history} = {answer.value:.5g} ± {answer.half:.2g}. Grey: below the uncertainty of the result; "
                   "dashed: the target; ring: the selected run", fontsize=9, loc="left")
    axes.grid(alpha=0.3, which="both", lw=0.5)
    return save(figure, path)


def write_figures(search: Search, answer: Answer | None, choice: Trial | None, lines: Sequence[str], path: Path) -> None:
    """figures.json: all output for other programs."""
    rows = [{k: v for k, v in asdict(t).items() if k != "deck" and v == v} for t in search.trials]
    content = {
        "deck": str(search.deck.path), "history": search.wish.history, "at": search.wish.place,
        "answer": asdict(answer) if answer else None, "choice": choice.name if choice else None,
        "ended": search.ending, "runs": rows, "told": list(lines),
    }  # fmt: skip
    path.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


def tell_study(search: Search, answer: Answer | None, choice: Trial | None, warnings: Sequence[str]) -> None:
    """Print and write all output."""
    wish, name = search.wish, search.deck.path.stem
    lines = said(search, answer, choice, warnings)
    print(table(RUN_HEADER, run_rows(search.trials, answer, choice)) + "\n")
    print(table(["method", "limit", "+-", "as"], band_rows(search.trials)) + "\n")
    print("\n".join(lines))
    wish.root.mkdir(parents=True, exist_ok=True)
    write_figures(search, answer, choice, lines, wish.root / "figures.json")
    if answer is not None:
        print(f"drawing: {draw_study(search.trials, answer, choice, wish, name, wish.root / 'study.svg')}")
    if choice is not None:
        written = wish.root / f"{name}_choice.inp"
        written.write_text(choice.deck, encoding="utf-8")
        print(f"deck: {written}")
