"""`chart`: error against CPU seconds for the studies of verification/studies, and the best method for an error."""

from __future__ import annotations

import argparse
import csv
import math
import shlex
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from qsmpm_verify import choosing
from qsmpm_verify.batch import add_running_words, checked_program, efforts_up_to
from qsmpm_verify.bounds.points import bound_points
from qsmpm_verify.drawing import draw, tips
from qsmpm_verify.front import Sample, choices, front, lasting_errors
from qsmpm_verify.pages import figure_folder, link_to, markdown_table, write_between
from qsmpm_verify.peer_points import with_peers
from qsmpm_verify.places import BUILD, STUDIES, TOP
from qsmpm_verify.progress import Progress
from qsmpm_verify.report import table
from qsmpm_verify.sampling import count_runs, sample_study
from qsmpm_verify.studies import Study, load_studies
from qsmpm_verify.trouble import RunFailed, Trouble

def add_words(verbs: argparse._SubParsersAction) -> None:
    """Arguments of the subcommand."""
    verb = verbs.add_parser("chart", help="plot error against CPU seconds for many methods, and list the best method for an error")
    verb.add_argument("studies", nargs="*", help="names of studies or files; default all")
    add_running_words(verb, "studies")
    verb.add_argument("--charts", type=Path, default=BUILD / "charts", help="folder of the figures and CSV files")
    verb.add_argument("--markdown", type=Path, help="write charts and tables as a page in the format of docs/data/charts.md")
    verb.add_argument("--repeat", type=int, default=1, help="number of runs of each; the least CPU time counts")
    verb.add_argument("--peers", action="store_true", help="also run Kratos for the scenes it supports")
    verb.add_argument("--table", type=Path, metavar="PAGE", help="write the table of methods by error into a page in the format of docs/charts.md")
    verb.set_defaults(act=act)


def write_csv(study: Study, samples: Sequence[Sample], path: Path) -> None:
    """Every run and every stored point; failed runs have a reason instead of a result."""
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
                figures = [size_text(size), f"{error:.6g}", "", f"{seconds:.4g}"]
                rows.writerow([study.name, other.label, *figures, "", f"{other.how}: {other.caveat}"])


def size_text(size: float) -> str:
    """A size, empty if that of another program is unknown."""
    return f"{size:g}" if math.isfinite(size) else ""


def error_text(sample: Sample) -> str:
    """The error of a run as shown in the tables."""
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


def choice_header(study: Study) -> list[str]:
    """Headings of the table of choices."""
    return [f"{study.error.name} at most", "method", study.size, "its error", "CPU s"]


def other_header(study: Study) -> list[str]:
    """Headings of the table of other programs."""
    return ["program", "figures", study.size, "error", "CPU s"]


def other_rows(study: Study) -> list[list[str]]:
    """Rows of the table of other programs."""
    return [
        [o.label, o.how, size_text(size), f"{error:.2e}", f"{seconds:.3g}"]
        for o in study.others for size, error, seconds in o.points
    ]  # fmt: skip


def study_page(study: Study, samples: Sequence[Sample], picture: str) -> list[str]:
    """One study as lines of a page."""
    lines = [f"## {study.title}", ""]
    lines += [f"Error: {study.error.name}; reference: {study.source}. {study.note}".rstrip(), ""]
    lines += [f"![{study.title}]({picture})", "", *markdown_table(choice_header(study), choice_rows(samples)), ""]
    lines += [*markdown_table(run_header(study), run_rows(study, samples)), ""]
    if study.others:
        lines += ["Other programs:", "", *markdown_table(other_header(study), other_rows(study)), ""]
        lines += [f"- {o.label}: {o.caveat} Source: {o.source}." for o in study.others] + [""]
    return lines


PREFACE = (
    "Error against CPU seconds of one core. `best` marks a run for which no other run is both cheaper and more accurate, assessed by the",
    "largest error on this and the finer grids of the same method; `luck` marks an error that increases on a finer grid.",
)


def take_samples(words: argparse.Namespace) -> list[tuple[Study, list[Sample]]]:
    """Run what the command line requests."""
    studies = load_studies(STUDIES, TOP, words.studies)
    program, efforts = checked_program(words), efforts_up_to(words.effort)
    if words.repeat < 1:
        raise Trouble("--repeat must be at least 1")
    total = sum(count_runs(study, efforts) for study in studies) * words.repeat
    progress = Progress(total)
    taken = []
    for study in studies:
        samples = sample_study(study, efforts, program, words.out, words.jobs, words.repeat, words.fresh, progress.tell)
        if samples and not any(s.good for s in samples):
            raise RunFailed(f"study {study.name}: no run gave a result; message of the first: {samples[0].message}")
        shown = with_peers(study, words.peers, words.out / "peers", lambda line: print(line, file=sys.stderr))
        shown = replace(shown, others=shown.others + tuple(bound_points(study, words.out / "bounds")))
        taken.append((shown, samples))
    return taken


def command_of(words: argparse.Namespace, verb: str, names: Sequence[str]) -> str:
    """The command stated on a page."""
    return shlex.join(["tools/qsmpm-verify", verb, *names, "--effort", words.effort])


def act(words: argparse.Namespace) -> int:
    """Run the studies, plot and report."""
    command = command_of(words, "chart", words.studies)
    page = ["# Error and cost", "", f"Written by `{command} --markdown FILE`; do not edit.", *PREFACE, ""]
    taken = take_samples(words)
    for study, samples in taken:
        picture = draw(study, samples, words.charts / f"{study.name}.svg")
        write_csv(study, samples, words.charts / f"{study.name}.csv")
        print(f"\n{study.title}\n")
        print(table(run_header(study), run_rows(study, samples)))
        print("\n" + table(choice_header(study), choice_rows(samples)))
        print(f"\n{picture}", file=sys.stderr)
        if words.markdown:
            shown = draw(study, samples, figure_folder(words.markdown) / f"chart_{study.name}.svg")
            page += study_page(study, samples, link_to(shown, words.markdown))
    if words.markdown:
        words.markdown.parent.mkdir(parents=True, exist_ok=True)
        words.markdown.write_text("\n".join(page) + "\n", encoding="utf-8")
    if words.table:
        write_between(words.table, "chart", choosing.table_lines(taken, command))
    return 0
