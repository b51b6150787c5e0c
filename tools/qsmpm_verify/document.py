"""`report`: a self-contained HTML file with all charts, the stability map, the cases and figures."""

from __future__ import annotations

import argparse
import base64
import json
from argparse import Namespace
from collections.abc import Callable, Sequence
from pathlib import Path

from qsmpm_verify import chart, choosing, scene, stability_map, view
from qsmpm_verify.batch import add_running_words, checked_program, efforts_up_to
from qsmpm_verify.cases import load_all, select
from qsmpm_verify.hypertext import SCRIPT, STYLE, command, figure, inline_svg, table, text, with_tips
from qsmpm_verify.judge import Verdict, judge
from qsmpm_verify.machine import describe
from qsmpm_verify.places import CASES, STABILITY, TOP
from qsmpm_verify.progress import Progress
from qsmpm_verify.report import closing_line, counts, word_of
from qsmpm_verify.run_report import verb as run_report
from qsmpm_verify.runner import Run, run_all
from qsmpm_verify.stability import load_rows
from qsmpm_verify.studies import Study
from qsmpm_verify.trouble import Trouble

LARGEST = 5_000_000
"""Largest size in bytes that can usually be sent by mail."""

VIEWS = (
    (
        "slope_grid/e200_10",
        "mises",
        "The slope of the paper at a unit weight of 100 kN/m3: initial and deformed geometry",
    ),
    ("cantilever/spline_4_points_9", "stress_xx", "The cantilever under its full load"),
)


def chart_part(words: Namespace) -> tuple[str, int]:
    """The charts and the number of their runs that failed."""
    asked = Namespace(**{**vars(words), "studies": [], "out": words.folder / "studies", "repeat": 1, "peers": False})
    parts, failed = (
        ["<h2 id=charts>Error against cost</h2>\n<p>" + text(" ".join(chart.PREFACE).replace("`", "")) + "</p>\n"],
        0,
    )
    taken = chart.take_samples(asked)
    header, choices = choosing.table_cells(taken)
    parts.append("<h3>Which method for which error</h3>\n" + table(header, [("", row) for row in choices]))
    plain_legend = choosing.LEGEND.replace("`", "")
    parts.append(f"<p class=command>{text(plain_legend)}</p>\n")
    for study, samples in taken:
        picture = chart.draw(study, samples, words.folder / "charts" / f"{study.name}.svg")
        chart.write_csv(study, samples, words.folder / "charts" / f"{study.name}.csv")
        failed += sum(not s.good for s in samples)
        parts.append(f"<h3>{text(study.title)}</h3>\n<p>Reference: {text(study.source)}. {text(study.note)}</p>\n")
        parts.append(
            figure(with_tips(inline_svg(picture), chart.tips(study, samples)), f"{study.error.name} against CPU seconds of one core; broad line: no run is better")
        )
        parts.append(table(chart.choice_header(study), [("", row) for row in chart.choice_rows(samples)]))
        rows = [("best" if row[4] == "best" else "", row) for row in chart.run_rows(study, samples)]
        parts.append("<details><summary>All runs</summary>" + table(chart.run_header(study), rows) + "</details>\n")
        parts.append(others_part(study))
        parts.append(command(chart.command_of(words, "chart", [study.name])))
    return "".join(parts), failed


def others_part(study: Study) -> str:
    """Results of other programs, and how they differ from those of QSMPM."""
    if not study.others:
        return ""
    rows = [("", row) for row in chart.other_rows(study)]
    said = "".join(
        f"<p class=command>{text(o.label)}: {text(o.caveat)} Source: {text(o.source)}.</p>\n" for o in study.others
    )
    return "<details><summary>Other programs</summary>" + table(chart.other_header(study), rows) + said + "</details>\n"


def scene_part(words: Namespace) -> str:
    """Savings and changes with the reduced model of a scene."""
    asked = Namespace(**{**vars(words), "names": [], "out": words.folder / "scene", "repeat": 1})
    savings = scene.take_savings(asked)
    picture = scene.draw(savings, words.folder / "charts" / "scene.svg")
    scene.write_csv(savings, words.folder / "charts" / "scene.csv")
    notes = "".join(f"<li>{text(s.reduction.title)}: {text(s.reduction.note)}</li>" for s in savings)
    caption = ("Full scene (grey) and reduced model (green); at the right the largest change of the result over all steps, "
               "relative to its largest value")  # fmt: skip
    return (
        "<h2 id=scene>The smallest model of a scene</h2>\n" + figure(inline_svg(picture), caption)
        + table(scene.HEADER, [("", scene.row(s)) for s in savings]) + f"<ul class=command>{notes}</ul>\n"
        + command(chart.command_of(words, "scene", []))
    )  # fmt: skip


def map_part(words: Namespace) -> str:
    """The stability map."""
    asked = Namespace(**{**vars(words), "tests": [], "out": words.folder / "stability"})
    methods, tests = load_rows(STABILITY, TOP, [])
    matrix = stability_map.fill_matrix(tests, asked)
    picture = stability_map.draw(methods, tests, matrix, words.folder / "charts" / "stability.svg")
    stability_map.write_csv(tests, matrix, words.folder / "charts" / "stability.csv")
    shown = with_tips(inline_svg(picture), stability_map.tips(methods, tests, matrix))
    rows = []
    for t in tests:
        limits = [f"{t.good:g}", f"{t.fair:g}"] if t.figure else ["-", "-"]
        rows.append(("", [t.id, t.title, t.asks, *limits]))
    silent = [f for f in matrix.values() if f.outcome == stability_map.SILENT]
    reported = [f for f in matrix.values() if f.outcome == stability_map.TOLD]
    lists = "".join(
        f"<details><summary>{text(title)}</summary>"
        + table(
            ["test", "method", "field", "said"],
            [("", [f.test, f.method, stability_map.cell_text(f), f.note]) for f in kind],
        )
        + "</details>\n"
        for title, kind in (("Silent failures", silent), ("Messages of the failures", reported))
    )
    return (
        "<h2 id=map>Where methods fail</h2>\n" + figure(shown, stability_map.count_line(matrix))
        + table(["test", "what", "asks", "good up to", "degraded up to"], rows) + lists
        + command("tools/qsmpm-verify map")
    )  # fmt: skip


def case_part(words: Namespace, program: Path) -> tuple[str, list[Verdict], dict[str, Run]]:
    """The verification cases, their verdicts and runs."""
    cases = select(load_all(CASES, TOP), [], efforts_up_to(words.effort))
    progress = Progress(len(cases))
    runs = run_all(
        cases, program, words.folder / "verify", words.jobs,
        lambda run: progress.tell(run.case.name, run.wall_seconds, run.reused), words.fresh,
    )  # fmt: skip
    verdicts = [verdict for case in cases for verdict in judge(case, runs)]
    rows = []
    for v in verdicts:
        error = "-" if v.error is None else f"{v.error:.1e}"
        cells = [v.case, v.quantity, f"{v.value:.6g}", v.reference, error, v.tolerance, word_of(v), v.note[:120]]
        rows.append(("missed" if v.held is False else "", cells))
    header = ["case", "quantity", "value", "reference", "error", "tolerance", "verdict", "note"]
    missed = [row for row in rows if row[0]]
    shown = table(header, missed) if missed else "<p>All passed.</p>"
    whole = f"<details><summary>All {len(rows)} figures</summary>{table(header, rows)}</details>\n"
    again = command(f"tools/qsmpm-verify run --effort {words.effort}")
    return (
        f"<h2 id=cases>Verification cases</h2>\n<p>{closing_line(verdicts)}</p>\n{shown}{whole}{again}",
        verdicts,
        runs,
    )


def view_part(words: Namespace, runs: dict[str, Run]) -> str:
    """Figures of the last states of successful runs."""
    parts = []
    for name, field, caption in VIEWS:
        run = runs.get(name)
        if run is None or run.exit_code != 0:
            continue
        out = view.last_state(run.directory, field, words.folder / "charts" / f"view_{name.replace('/', '_')}.png")
        picture = base64.b64encode(out.read_bytes()).decode()
        shown = f'<img alt="{text(caption)}" src="data:image/png;base64,{picture}">'
        parts.append(figure(shown, caption) + command(f"tools/qsmpm-verify view {run.directory} --field {field}"))
    return "<h2 id=views>Pictures</h2>\n" + "".join(parts) if parts else ""


def add_words(verbs: argparse._SubParsersAction) -> None:
    """Arguments of the subcommand."""
    verb = verbs.add_parser("report", help="write an HTML report of a run; without RUN, of the charts, stability map, cases, figures and the machine")
    verb.add_argument("run", type=Path, nargs="?", help="folder of a run, or its results.h5")
    verb.add_argument("--docx", type=Path, help="for a run: also write a document")
    verb.add_argument("--bounds", action="store_true", help="for a run: limit analysis of its safety phases")
    add_running_words(verb, "")
    verb.add_argument("--html", type=Path, help="file to write; default report.html in the folder of the run, or qsmpm_report.html in the folder of the runs")
    verb.set_defaults(act=act)


def study_part() -> str:
    """Studies of the user's decks in output/study; empty without such studies."""
    parts = []
    for path in sorted((TOP / "output" / "study").glob("*/figures.json")):
        try:
            told = json.loads(path.read_text(encoding="utf-8"))
            deck, history, lines = str(told["deck"]), str(told["history"]), [str(line) for line in told["told"]]
        except (ValueError, KeyError, TypeError) as error:
            raise Trouble(f"{path}: truncated, or not the results of a study ({error!r})") from error
        picture = path.with_name("study.svg")
        drawing = with_tips(inline_svg(picture), study_tips(told.get("runs", []))) if picture.is_file() else ""
        shown = figure(drawing, f"{deck}: error against CPU seconds") if drawing else ""
        items = "".join(f"<li>{text(line)}</li>" for line in lines)
        parts.append(f"<h3>{text(deck)}: {text(history)}</h3>\n<ul>{items}</ul>\n{shown}")
    return "<h2 id=studies>Studies of user decks</h2>\n" + "".join(parts) if parts else ""


def study_tips(runs: Sequence[dict]) -> dict[str, list[str]]:
    """Tooltips of the marks in the figure of a study, by the names of their groups."""
    good = [run for run in runs if "figure" in run and "seconds" in run]
    return {
        f"runs-{number}": [f"{method}, grid 2^{run.get('level', 0)}: {run['figure']:.6g}, {run['seconds']:.3g} CPU s"
                           for run in good if run.get("method") == method and run.get("steps") == 1]
        for number, method in enumerate(dict.fromkeys(run.get("method") for run in good))
    }  # fmt: skip


def or_gap(title: str, make: Callable[[], str], gaps: list[str]) -> str:
    """A part of the page; if it cannot be generated, the page states the reason and continues."""
    try:
        return make()
    except Trouble as trouble:
        gaps.append(title)
        return f"<h2>{text(title)}</h2>\n<p class=missed>This part is missing: {text(trouble)}</p>\n"


def page_of(parts: Sequence[str], summary: str, facts: str, again: str) -> str:
    """The page: summary, parts, machine."""
    links = "".join(
        f"<a href='#{name}'>{title}</a> | " for name, title in (
            ("charts", "Charts"), ("studies", "Studies of user decks"), ("scene", "Smaller models"), ("map", "Stability map"),
            ("views", "Pictures"), ("cases", "Cases"))
        if f"id={name}>" in "".join(parts)
    )  # fmt: skip
    return (
        "<!doctype html><html lang=en><meta charset=utf-8><meta name=viewport content='width=device-width, initial-scale=1'>"
        f"<title>QSMPM report</title><style>{STYLE}</style>\n"
        f"<h1>QSMPM: results, accuracy and cost</h1>\n<p>{summary}</p>\n"
        f"<nav>{links}<a href='#machine'>Machine</a></nav>\n{''.join(parts)}<h2 id=machine>Machine and versions</h2>\n{facts}"
        f"{again}<script>{SCRIPT}</script></html>\n"
    )


def act(words: Namespace) -> int:
    """Run what is not yet available, write the page. Exit code 1 if a case missed, 3 if a run or a whole part failed."""
    if words.run is not None:
        return run_report.act(words)
    program = checked_program(words)
    words.folder, words.program = words.out, program
    gaps: list[str] = []
    failed: list[int] = []
    found: dict[str, Run] = {}
    verdicts: list[Verdict] = []

    def charts() -> str:
        part, count = chart_part(words)
        failed.append(count)
        return part

    def cases() -> str:
        part, judged, runs = case_part(words, program)
        verdicts.extend(judged)
        found.update(runs)
        return part

    case_page = or_gap("Verification cases", cases, gaps)
    parts = [
        or_gap("Error against cost", charts, gaps), or_gap("Studies of user decks", study_part, gaps),
        or_gap("The smallest model of a scene", lambda: scene_part(words), gaps),
        or_gap("Where methods fail", lambda: map_part(words), gaps), view_part(words, found), case_page,
    ]  # fmt: skip
    held, missed = counts(verdicts)
    summary = (f"{held} results of the verification cases passed, {missed} missed; {sum(failed)} runs of the charts failed "
               "and are listed there." + (f" Missing: {', '.join(gaps)}." if gaps else ""))  # fmt: skip
    facts = table(["what", "is"], [("", fact) for fact in describe(program, TOP)])
    page = page_of(parts, summary, facts, command(f"tools/qsmpm-verify report --effort {words.effort}"))
    out = words.html or words.out / "qsmpm_report.html"
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_text(page, encoding="utf-8")
    size = out.stat().st_size
    print(f"{out}: {size / 1e6:.2f} MB" + (", too large for mail" if size > LARGEST else ""))
    print(summary)
    if gaps or any(run.exit_code != run.case.exit_code for run in found.values()):
        return 3
    return 1 if missed else 0
