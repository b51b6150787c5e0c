"""`scene`: savings and change of the result with a smaller model of a scene; chart, CSV file and the table of docs/scene.md."""

from __future__ import annotations

import argparse
import csv
import shlex
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import matplotlib.pyplot as plt

from qsmpm_verify.batch import add_running_words, checked_program, efforts_up_to
from qsmpm_verify.pages import markdown_table, write_between
from qsmpm_verify.places import BUILD, SCENES, TOP
from qsmpm_verify.plots import save, set_ticks
from qsmpm_verify.progress import Progress
from qsmpm_verify.reductions import Cost, Saving, load_reductions, measure
from qsmpm_verify.report import table
from qsmpm_verify.trouble import Trouble

PARTS = (("CPU time [s]", "seconds"), ("memory [MiB]", "memory"), ("equations", "equations"))
HEADER = ["reduction", "scene", "CPU s", "MiB", "equations", "points", "change of the result"]


def add_words(verbs: argparse._SubParsersAction) -> None:
    """Arguments of the subcommand."""
    verb = verbs.add_parser("scene", help="compare cost and result of a scene with those of a smaller model")
    verb.add_argument("names", nargs="*", help="reductions; default all")
    add_running_words(verb, "scene")
    verb.add_argument("--repeat", type=int, default=1, help="number of runs of each model; the least CPU time counts")
    verb.add_argument("--charts", type=Path, default=BUILD / "charts", help="folder of scene.svg and scene.csv")
    verb.add_argument("--page", type=Path, help="write table and chart into a page in the format of docs/scene.md")
    verb.set_defaults(act=act)


def take_savings(words: argparse.Namespace) -> list[Saving]:
    """Run what the command line requests."""
    efforts = efforts_up_to(words.effort)
    reductions = load_reductions(SCENES, TOP, words.names, efforts)
    program = checked_program(words)
    if words.repeat < 1:
        raise Trouble("--repeat must be at least 1")
    if not reductions:
        raise Trouble(f"no reduction of effort {words.effort}; --effort quick includes all except the long ones")
    progress = Progress(2 * len(reductions) * words.repeat)
    with ThreadPoolExecutor(max_workers=words.jobs) as pool:
        waiting = [
            pool.submit(measure, reduction, program, words.out, words.repeat, words.fresh,
                        lambda run: progress.tell(run.case.name, run.wall_seconds, run.reused))
            for reduction in reductions
        ]  # fmt: skip
        try:
            return [future.result() for future in waiting]
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def pair(whole: float, reduced: float, form: str) -> str:
    """`12 -> 3`: value of the full scene and of the reduced model, and their ratio."""
    return f"{whole:{form}} -> {reduced:{form}} ({whole / reduced:.1f}x)"


def change_text(saving: Saving) -> str:
    """The change of the result; 0 if all digits agree."""
    return f"{saving.change:.1e}" if saving.change else "0"


def row(saving: Saving) -> list[str]:
    """Cells of a table row."""
    whole, reduced = saving.whole, saving.reduced
    return [
        saving.reduction.title, saving.reduction.scene, pair(whole.seconds, reduced.seconds, ".2g"),
        pair(whole.memory, reduced.memory, ".0f"), pair(whole.equations, reduced.equations, "d"),
        pair(whole.points, reduced.points, "d"), f"{saving.reduction.what}: {change_text(saving)}",
    ]  # fmt: skip


def value(cost: Cost, part: str) -> float:
    """One of the plotted quantities."""
    return float(getattr(cost, part))


def draw_bars(axes: plt.Axes, savings: Sequence[Saving], part: str) -> None:
    """Bars of the full scene and of the reduced model, with their values."""
    for shift, model, colour in ((-0.2, "whole", "0.65"), (0.2, "reduced", "tab:green")):
        values = [value(getattr(s, model), part) for s in savings]
        places = [i + shift for i in range(len(savings))]
        drawn = axes.barh(places, values, 0.38, color=colour, label=f"{model} scene" if model == "whole" else "reduced")
        axes.bar_label(drawn, [f"{v:.3g}" if v < 1000 else f"{v:.0f}" for v in values], padding=3, fontsize=7)
    axes.set_xscale("log")
    values = [value(cost, part) for s in savings for cost in (s.whole, s.reduced)]
    low, high = 0.5 * min(values), 4.0 * max(values)
    axes.set_xlim(low, high)
    set_ticks(axes.xaxis, low, high)
    axes.grid(axis="x", alpha=0.3, lw=0.5)


def draw(savings: Sequence[Saving], path: Path) -> Path:
    """CPU seconds, memory and equations side by side, the change of the result at the right."""
    figure, every = plt.subplots(1, 3, figsize=(11.0, 0.62 * len(savings) + 1.5), sharey=True)
    for axes, (name, part) in zip(every, PARTS):
        draw_bars(axes, savings, part)
        axes.set_xlabel(name)
    every[0].set_yticks(range(len(savings)), [s.reduction.title for s in savings], fontsize=8)
    every[0].invert_yaxis()
    handles, names = every[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="upper left", ncols=2, fontsize=8, frameon=False)
    other = every[2].twinx()
    other.set_ylim(every[2].get_ylim())
    other.set_yticks(range(len(savings)), [change_text(s) for s in savings], fontsize=8)
    other.set_title("change of\nthe result [-]", fontsize=8, loc="right")
    return save(figure, path)


def write_csv(savings: Sequence[Saving], path: Path) -> None:
    """One row for each model."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(["reduction", "model", "cpu_seconds [s]", "memory [MiB]", "equations [-]", "points [-]", "figure",
                       "change [-]"])
        for s in savings:
            for model, cost in (("whole", s.whole), ("reduced", s.reduced)):
                change = "" if model == "whole" else f"{s.change:.6g}"
                rows.writerow([s.reduction.name, model, f"{cost.seconds:.4g}", f"{cost.memory:.1f}", cost.equations,
                               cost.points, s.reduction.what, change])


def page_lines(savings: Sequence[Saving], command: str, picture: str) -> list[str]:
    """The generated part of a page."""
    notes = [f"- {s.reduction.title}: {s.reduction.note}" for s in savings]
    return [
        f"Written by `{command}`. Full scene -> reduced model; CPU seconds of the whole process on a shared machine; the change is "
        "the largest over all steps, relative to the largest value.",
        "", f"![Savings with a smaller model]({picture})", "", *markdown_table(HEADER, [row(s) for s in savings]), "", *notes,
    ]  # fmt: skip


def act(words: argparse.Namespace) -> int:
    """Run, draw, report."""
    command = shlex.join(["tools/qsmpm-verify", "scene", *words.names, "--effort", words.effort])
    if words.repeat > 1:
        command += f" --repeat {words.repeat}"
    savings = take_savings(words)
    print(table(HEADER, [row(s) for s in savings]))
    picture = draw(savings, words.charts / "scene.svg")
    write_csv(savings, words.charts / "scene.csv")
    print(picture)
    if words.page:
        shown = draw(savings, words.page.parent / "figures" / "scene.svg")
        write_between(words.page, "scene", page_lines(savings, f"{command} --page {words.page}", f"figures/{shown.name}"))
    return 0
