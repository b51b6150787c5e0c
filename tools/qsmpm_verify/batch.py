"""`list` and `run`: the cases of verification/cases, run and compared with their references."""

from __future__ import annotations

import argparse
from pathlib import Path

from qsmpm_verify.cases import EFFORTS, load_all, select
from qsmpm_verify.judge import judge
from qsmpm_verify.pages import figure_folder
from qsmpm_verify.places import BUILD, CASES, PROGRAM, TOP
from qsmpm_verify.progress import Progress
from qsmpm_verify.report import closing_line, counts, verdict_table, write_json, write_markdown
from qsmpm_verify.runner import run_all
from qsmpm_verify.trouble import Trouble


def add_running_words(verb: argparse.ArgumentParser, out: str) -> None:
    """Arguments of every subcommand that runs the program."""
    verb.add_argument("--program", type=Path, default=PROGRAM, help="program to run")
    verb.add_argument("--out", type=Path, default=BUILD / out, help="folder of the runs")
    verb.add_argument(
        "--effort",
        choices=(*EFFORTS, "all"),
        default="quick",
        help="small: small runs only; quick: small and quick runs (default); long or all: all runs",
    )
    verb.add_argument("--quick", dest="effort", action="store_const", const="quick", help="equivalent to --effort quick")
    verb.add_argument("--jobs", type=int, default=1, help="number of parallel runs")
    verb.add_argument("--fresh", action="store_true", help="repeat runs that are already available")


def add_words(verbs: argparse._SubParsersAction) -> None:
    """Arguments of `list` and `run`."""
    verbs.add_parser("list", help="list names and titles of all cases").set_defaults(act=list_cases)
    verb = verbs.add_parser("run", help="run cases and compare them with references; finished runs are reused")
    verb.add_argument("cases", nargs="*", help="names, files or patterns; default all")
    add_running_words(verb, "verify")
    verb.add_argument("--markdown", type=Path, help="write the results as a page in the format of docs/data/verification.md")
    verb.add_argument("--json", type=Path, help="also write the results to a file")
    verb.set_defaults(act=run_cases)


def efforts_up_to(effort: str) -> tuple[str, ...]:
    """Efforts included in a choice."""
    return EFFORTS if effort == "all" else EFFORTS[: EFFORTS.index(effort) + 1]


def checked_program(words: argparse.Namespace) -> Path:
    """The program, which must exist."""
    if not words.program.is_file():
        raise Trouble(f"{words.program} not found: build it first (tools/test or cmake --build build)")
    if words.jobs < 1:
        raise Trouble("--jobs must be at least 1")
    return words.program.resolve()


def list_cases(words: argparse.Namespace) -> int:
    """One line for each case."""
    for case in load_all(CASES, TOP).values():
        print(f"{case.name:40s} {case.effort:6s} {case.title}")
    return 0


def run_cases(words: argparse.Namespace) -> int:
    """Run, assess, print. Exit code 1 if a result missed, 3 if a run did not end as expected."""
    cases = select(load_all(CASES, TOP), words.cases, efforts_up_to(words.effort))
    program = checked_program(words)
    if not cases:
        asked = " ".join(words.cases)
        raise Trouble(f"no case of effort {words.effort} among {asked}; --effort all includes the long ones")
    progress = Progress(len(cases))
    runs = run_all(
        cases, program, words.out, words.jobs,
        lambda run: progress.tell(run.case.name, run.wall_seconds, run.reused), words.fresh,
    )  # fmt: skip
    verdicts = [verdict for case in cases for verdict in judge(case, runs)]
    print(verdict_table(verdicts))
    if words.json:
        write_json(verdicts, words.json)
    if words.markdown:
        from qsmpm_verify import plots  # matplotlib, for this alone

        finished = {run.case.name: run.directory for run in runs.values() if run.exit_code == 0}
        pictures = plots.page_figures(finished, figure_folder(words.markdown))
        command = " ".join(["tools/qsmpm-verify run", *words.cases, f"--effort {words.effort} --markdown FILE"])
        write_markdown(verdicts, command, words.markdown, pictures)
    print(closing_line(verdicts))
    if any(run.exit_code != run.case.exit_code and not run.case.expected_to_fail for run in runs.values()):
        return 3
    return 1 if counts(verdicts)[1] else 0
