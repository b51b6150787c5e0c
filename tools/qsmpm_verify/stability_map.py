"""`map`: the stability map. Rows are tests in which methods fail, columns are methods."""

from __future__ import annotations

import argparse
import csv
import math
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import matplotlib.pyplot as plt

from qsmpm_verify.batch import checked_program
from qsmpm_verify.chart import markdown_table
from qsmpm_verify.pages import figure_folder, link_to
from qsmpm_verify.mapping import DEGRADED, NONE, PASS, SILENT, TOLD, Commands, Field, command_field, deck_field
from qsmpm_verify.places import BUILD, PROGRAM, STABILITY, TOP
from qsmpm_verify.plots import save
from qsmpm_verify.progress import Progress
from qsmpm_verify.report import table
from qsmpm_verify.stability import Test, Trial, load_rows

COLOURS = {PASS: "#8fd19e", DEGRADED: "#ffe08a", TOLD: "#f6b26b", SILENT: "#e06666", NONE: "#eeeeee"}
SIGNS = {PASS: "", DEGRADED: "~ ", TOLD: "! ", SILENT: "X ", NONE: ""}

Matrix = dict[tuple[str, str], Field]


def add_words(verbs: argparse._SubParsersAction) -> None:
    """Arguments of the subcommand."""
    verb = verbs.add_parser("map", help="compute the stability map: tests in which methods fail, and the outcome for each method")
    verb.add_argument("tests", nargs="*", help="rows, such as S1; default all")
    verb.add_argument("--program", type=Path, default=PROGRAM, help="program to run")
    verb.add_argument("--out", type=Path, default=BUILD / "stability", help="folder of the runs")
    verb.add_argument("--charts", type=Path, default=BUILD / "charts", help="folder of the figure and the CSV file")
    verb.add_argument("--markdown", type=Path, help="write the map as a page in the format of docs/data/stability.md")
    verb.add_argument("--jobs", type=int, default=1, help="number of parallel runs")
    verb.add_argument("--fresh", action="store_true", help="repeat runs that are already available")
    verb.add_argument("--strict", action="store_true", help="exit code 1 if any field fails silently")
    verb.set_defaults(act=act)


def fill_matrix(tests: Sequence[Test], words: argparse.Namespace) -> Matrix:
    """Run all fields."""
    program = checked_program(words)
    commands = Commands(program)
    progress = Progress(sum(len(test.trials) for test in tests))

    def one(test: Test, trial: Trial) -> Field:
        if test.command:
            field, reused = command_field(test, trial, commands), False
        else:
            field, reused = deck_field(test, trial, program, words.out, words.fresh)
        progress.tell(trial.case.name, field.seconds, reused)
        return field

    with ThreadPoolExecutor(max_workers=words.jobs) as pool:
        futures = [pool.submit(one, test, trial) for test in tests for trial in test.trials]
        try:
            fields = [future.result() for future in futures]
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return {(field.test, field.method): field for field in fields}


def _number(value: float) -> str:
    """A value of the map as text."""
    return f"{value:.1e}" if 0 < abs(value) < 1e-2 else f"{value:.3g}"


def cell_text(field: Field | None) -> str:
    """A field of the map: its mark and its value, or how the run ended."""
    if field is None:
        return "-"
    if math.isfinite(field.figure):
        figure = _number(field.figure)
        if field.outcome != PASS and math.isfinite(field.stated):
            figure += f" ({_number(field.stated)})"
        return SIGNS[field.outcome] + figure
    ending = "not finished" if field.exit_code is None else f"exit {field.exit_code}"
    return SIGNS[field.outcome] + ending


def matrix_rows(methods: Sequence[str], tests: Sequence[Test], matrix: Matrix) -> list[list[str]]:
    """Rows of the map as text."""
    return [[f"{t.id} {t.title}", *(cell_text(matrix.get((t.id, m))) for m in methods)] for t in tests]


def draw(methods: Sequence[str], tests: Sequence[Test], matrix: Matrix, path: Path) -> Path:
    """The map in colours, with the value in each field."""
    figure, axes = plt.subplots(figsize=(12.5, 0.42 * len(tests) + 1.3))
    for row, test in enumerate(tests):
        for column, method in enumerate(methods):
            field = matrix.get((test.id, method))
            colour = COLOURS[field.outcome if field else NONE]
            axes.add_patch(plt.Rectangle((column, row), 1, 1, facecolor=colour, edgecolor="white", lw=1.5,
                                         gid=f"field-{row}-{column}"))
            shown = cell_text(field).replace(" (", "\n(")
            axes.text(column + 0.5, row + 0.5, shown, ha="center", va="center", fontsize=8)
    axes.set_xlim(0, len(methods))
    axes.set_ylim(len(tests), 0)
    axes.set_xticks([i + 0.5 for i in range(len(methods))], methods, fontsize=9)
    axes.xaxis.tick_top()
    axes.set_yticks([i + 0.5 for i in range(len(tests))], [f"{t.id}  {t.title}" for t in tests], fontsize=8)
    axes.tick_params(length=0)
    for side in axes.spines.values():
        side.set_visible(False)
    marks = [plt.Rectangle((0, 0), 1, 1, facecolor=COLOURS[kind]) for kind in COLOURS]
    names = [f"{SIGNS[kind]}{kind}" for kind in COLOURS]
    axes.legend(marks, names, ncols=5, fontsize=8, frameon=False, loc="upper right", bbox_to_anchor=(1.0, 0.0))
    return save(figure, path)


def tips(methods: Sequence[str], tests: Sequence[Test], matrix: Matrix) -> dict[str, list[str]]:
    """Tooltips of the fields of the figure, by the names of their groups."""
    told = {}
    for row, test in enumerate(tests):
        for column, method in enumerate(methods):
            field = matrix.get((test.id, method))
            if field:
                told[f"field-{row}-{column}"] = [f"{test.id} {method}: {field.outcome}, {cell_text(field)}. {field.note[:160]}".strip()]
    return told


def write_csv(tests: Sequence[Test], matrix: Matrix, path: Path) -> None:
    """Every field with its value, exit code and message."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(["test", "method", "outcome", "figure", "stated", "exit code", "good", "fair", "deck", "said"])
        for test in tests:
            for trial in test.trials:
                field = matrix[test.id, trial.method]
                figure = f"{field.figure:.6g}" if math.isfinite(field.figure) else ""
                stated = f"{field.stated:.6g}" if math.isfinite(field.stated) else ""
                code = "" if field.exit_code is None else str(field.exit_code)
                deck = " ".join(test.command) or trial.case.name
                rows.writerow(
                    [
                        test.id, trial.method, field.outcome, figure, stated, code, test.good, test.fair, deck, field.note
                    ]  # fmt: skip
                )


def count_line(matrix: Matrix) -> str:
    """Number of fields of each outcome."""
    kinds = [field.outcome for field in matrix.values()]
    return ", ".join(f"{kinds.count(kind)} {kind}" for kind in (PASS, DEGRADED, TOLD, SILENT))


def map_page(methods: Sequence[str], tests: Sequence[Test], matrix: Matrix, picture: str) -> list[str]:
    """The map as lines of a page."""
    lines = [
        f"![stability map]({picture})",
        "",
        f"{count_line(matrix)}. No sign: pass; `~` degraded; `!` fails and reports it, by its",
    ]
    lines += [
        "exit code and a message, or by a warning in its log; `X` fails silently: it finishes, its result is in error and its",
        "log does not report it. In parentheses, if the value is a stress error: the estimate that the run itself reports of",
        "this error ([stress error](../methods/stress_error.md)); it is reported only if the run warns and states at least half of it.",
        "",
    ]
    lines += [*markdown_table(["test", *methods], matrix_rows(methods, tests, matrix)), ""]
    rows = []
    for t in tests:
        figure = t.figure.name if t.figure else "exit code"
        limits = f"{t.good:g} / {t.fair:g}" if t.figure else ", ".join(map(str, t.ends))
        rows.append([t.id, t.asks, figure, limits, t.skip_reason])
    return lines + [*markdown_table(["test", "asks", "figure", "good / fair", "not for all methods"], rows), ""]


def act(words: argparse.Namespace) -> int:
    """Run the map, draw it and report it."""
    methods, tests = load_rows(STABILITY, TOP, words.tests)
    matrix = fill_matrix(tests, words)
    print(table(["test", *methods], matrix_rows(methods, tests, matrix)))
    write_csv(tests, matrix, words.charts / "stability.csv")
    picture = draw(methods, tests, matrix, words.charts / "stability.svg")
    silent = [field for field in matrix.values() if field.outcome == SILENT]
    for field in silent:
        print(f"fails silently: {field.test} {field.method}: {cell_text(field)[2:]} {field.note}".rstrip())
    print(f"{picture}\n{count_line(matrix)}")
    if words.markdown:
        shown = draw(methods, tests, matrix, figure_folder(words.markdown) / "stability.svg")
        command = " ".join(["tools/qsmpm-verify map", *words.tests, "--markdown FILE"])
        page = ["# Where methods fail", "", f"Written by `{command}`; do not edit.", ""]
        page += map_page(methods, tests, matrix, link_to(shown, words.markdown))
        words.markdown.write_text("\n".join(page) + "\n", encoding="utf-8")
    return 1 if silent and words.strict else 0
