"""`chart`: error against CPU seconds for the studies of verification/studies, and the best method for an error."""

from __future__ import annotations

import argparse
import csv
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path

import matplotlib.pyplot as plt

from qsmpm_verify.batch import add_running_words, checked_program, efforts_up_to
from qsmpm_verify.front import Sample, choices, front, lasting_errors, order
from qsmpm_verify.places import BUILD, STUDIES, TOP
from qsmpm_verify.plots import save
from qsmpm_verify.progress import Progress
from qsmpm_verify.report import table
from qsmpm_verify.sampling import count_runs, sample_study
from qsmpm_verify.studies import Study, load_studies
from qsmpm_verify.trouble import RunFailed, Trouble

MARKS = "osD^v<>pPX*h"


def add_words(verbs: argparse._SubParsersAction) -> None:
    """Words of the verb."""
    verb = verbs.add_parser("chart", help="error against CPU seconds of many methods, and the best for an error")
    verb.add_argument("studies", nargs="*", help="names of studies or files; all when none is given")
    add_running_words(verb, "studies")
    verb.add_argument("--charts", type=Path, default=BUILD / "charts", help="folder of the pictures and CSV files")
    verb.add_argument("--markdown", type=Path, help="write charts and tables as a page")
    verb.add_argument("--repeat", type=int, default=1, help="run each this often; the least CPU time counts")
    verb.set_defaults(act=act)


def label_of(method: str, samples: Sequence[Sample]) -> str:
    """Text of the legend: the method and its fitted order."""
    fitted = order([s for s in samples if s.method == method])
    return method if fitted is None else f"{method}; order {fitted:.1f}"


def draw(study: Study, samples: Sequence[Sample], path: Path) -> Path:
    """Error over CPU seconds: a line a method, other codes hollow and dashed, the front drawn broad."""
    figure, axes = plt.subplots(figsize=(8.6, 5.2))
    for place, method in enumerate(study.methods):
        drawn = [s for s in samples if s.method == method.label and s.good]
        if drawn:
            axes.loglog(
                [s.seconds for s in drawn],
                [s.error for s in drawn],
                "-" + MARKS[place % len(MARKS)],
                color=f"C{place % 10}",
                ms=5,
                lw=1.2,
                label=label_of(method.label, samples),
            )
    errors, along = lasting_errors(samples), front(samples)
    axes.loglog(
        [samples[i].seconds for i in along],
        [errors[i] for i in along],
        "-",
        color="gold",
        lw=7,
        alpha=0.5,
        zorder=0,
        label="no run is cheaper and better",
    )
    for place, other in enumerate(study.others):
        size, error, seconds = zip(*other.points)
        axes.loglog(
            seconds,
            error,
            "--" + MARKS[place % len(MARKS)],
            color="0.35",
            mfc="white",
            ms=5,
            lw=0.9,
            label=f"{other.label} (stored)",
        )
    axes.set_xlabel("CPU seconds, one core")
    axes.set_ylabel(study.error.name)
    axes.set_title(study.title, fontsize=10)
    axes.grid(alpha=0.3, which="both", lw=0.5)
    axes.legend(fontsize=7, loc="upper left", bbox_to_anchor=(1.01, 1.0))
    return save(figure, path)


def write_csv(study: Study, samples: Sequence[Sample], path: Path) -> None:
    """Every run and every stored point; failures have no figure but a reason."""
    errors, along = lasting_errors(samples), set(front(samples))
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(
            ["study", "method", study.size, "error [-]", "lasting error [-]", "cpu_seconds [s]", "on front", "note"]
        )
        for i, s in enumerate(samples):
            figures = [f"{s.error:.6g}", f"{errors[i]:.6g}", f"{s.seconds:.4g}"] if s.good else ["", "", ""]
            rows.writerow([study.name, s.method, f"{s.size:g}", *figures, "yes" if i in along else "", s.message])
        for other in study.others:
            for size, error, seconds in other.points:
                rows.writerow(
                    [study.name, other.label, f"{size:g}", f"{error:.6g}", "", f"{seconds:.4g}", "", other.caveat]
                )


def error_text(sample: Sample) -> str:
    """The error of a run as the tables show it."""
    return ("<= " if sample.at_floor else "") + f"{sample.error:.2e}" if sample.good else "fails"


def run_rows(study: Study, samples: Sequence[Sample]) -> list[list[str]]:
    """Rows of the table of all runs."""
    errors, along = lasting_errors(samples), set(front(samples))
    return [
        [s.method, f"{s.size:g}", error_text(s), f"{s.seconds:.3g}" if s.good else "-",
         "best" if i in along else "luck" if s.good and errors[i] > 1.5 * s.error else "", s.message[:90]]
        for i, s in enumerate(samples)
    ]  # fmt: skip


def run_header(study: Study) -> list[str]:
    """Headings of the table of all runs."""
    return ["method", study.size, "error", "CPU s", "front", "note"]


def choice_rows(samples: Sequence[Sample]) -> list[list[str]]:
    """Rows of the table of choices."""
    return [
        [f"{c.asked:.2g}", c.sample.method, f"{c.sample.size:g}", f"{c.error:.1e}", f"{c.sample.seconds:.2g}"]
        for c in choices(samples)
    ]  # fmt: skip


def markdown_table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """A table of a page."""
    return [
        "| " + " | ".join(header) + " |",
        "|" + "---|" * len(header),
        *("| " + " | ".join(row) + " |" for row in rows),
    ]


def choice_header(study: Study) -> list[str]:
    """Headings of the table of choices."""
    return [f"{study.error.name} at most", "method", study.size, "its error", "CPU s"]


def study_page(study: Study, samples: Sequence[Sample], picture: str) -> list[str]:
    """One study as lines of a page."""
    lines = [f"## {study.title}", ""]
    lines += [f"Error: {study.error.name}; reference: {study.source}. {study.note}".rstrip(), ""]
    lines += [f"![{study.title}]({picture})", "", *markdown_table(choice_header(study), choice_rows(samples)), ""]
    lines += [*markdown_table(run_header(study), run_rows(study, samples)), ""]
    if study.others:
        rows = [[o.label, f"{p[0]:g}", f"{p[1]:.2e}", f"{p[2]:.3g}"] for o in study.others for p in o.points]
        lines += ["Other codes, stored figures:", "", *markdown_table(["code", study.size, "error", "CPU s"], rows), ""]
        lines += [f"- {o.label}: {o.caveat} Source: {o.source}." for o in study.others] + [""]
    return lines


PREFACE = (
    "Error against CPU seconds of one core. `best` marks a run no other is both cheaper and better than, judged by the",
    "largest error on this and the finer grids of the same method; `luck` marks an error that grows on a finer grid.",
)


def take_samples(words: argparse.Namespace) -> list[tuple[Study, list[Sample]]]:
    """Run what the command line asks for."""
    studies = load_studies(STUDIES, TOP, words.studies)
    program, efforts = checked_program(words), efforts_up_to(words.effort)
    if words.repeat < 1:
        raise Trouble("--repeat is a number from 1")
    total = sum(count_runs(study, efforts) for study in studies) * words.repeat
    progress = Progress(total)
    taken = []
    for study in studies:
        samples = sample_study(study, efforts, program, words.out, words.jobs, words.repeat, words.fresh, progress.tell)
        if samples and not any(s.good for s in samples):
            raise RunFailed(f"study {study.name}: no run of it gave a figure; the first says: {samples[0].message}")
        taken.append((study, samples))
    return taken


def command_of(words: argparse.Namespace, verb: str, names: Sequence[str]) -> str:
    """The command a page names."""
    return shlex.join(["tools/qsmpm-verify", verb, *names, "--effort", words.effort])


def act(words: argparse.Namespace) -> int:
    """Run the studies, draw and tell."""
    command = command_of(words, "chart", words.studies)
    page = ["# Error and cost", "", f"Written by `{command} --markdown FILE`; do not edit.", *PREFACE, ""]
    for study, samples in take_samples(words):
        picture = draw(study, samples, words.charts / f"{study.name}.svg")
        write_csv(study, samples, words.charts / f"{study.name}.csv")
        print(f"\n{study.title}\n")
        print(table(run_header(study), run_rows(study, samples)))
        print("\n" + table(choice_header(study), choice_rows(samples)))
        print(f"\n{picture}", file=sys.stderr)
        if words.markdown:
            shown = draw(study, samples, words.markdown.parent / "figures" / f"chart_{study.name}.svg")
            page += study_page(study, samples, f"figures/{shown.name}")
    if words.markdown:
        words.markdown.parent.mkdir(parents=True, exist_ok=True)
        words.markdown.write_text("\n".join(page) + "\n", encoding="utf-8")
    return 0
