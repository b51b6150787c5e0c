"""The command `qsmpm-verify`: list, run, demo and plot."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from qsmpm_verify import plots
from qsmpm_verify.cases import EFFORTS, CaseError, load_all, select
from qsmpm_verify.judge import judge
from qsmpm_verify.report import closing_line, counts, verdict_table, write_json, write_markdown
from qsmpm_verify.results import ResultError
from qsmpm_verify.runner import Run, run_all

TOP = Path(__file__).resolve().parents[2]


def parser() -> argparse.ArgumentParser:
    """Words of the command line."""
    main = argparse.ArgumentParser(prog="qsmpm-verify", description=__doc__)
    verbs = main.add_subparsers(dest="verb", required=True)
    verbs.add_parser("list", help="names and titles of all cases")
    run = verbs.add_parser("run", help="run cases and compare them with their references")
    run.add_argument("cases", nargs="*", help="names, files or patterns; all when none is given")
    run.add_argument("--program", type=Path, default=TOP / "build" / "qsmpm", help="the program to run")
    run.add_argument("--out", type=Path, default=TOP / "build" / "verify", help="folder of the runs")
    run.add_argument("--effort", choices=(*EFFORTS, "all"), default="quick",
                     help="small: only the small cases; quick: small and quick (default); long or all: everything")
    run.add_argument("--jobs", type=int, default=1, help="runs side by side")
    run.add_argument("--markdown", type=Path, help="write the figures as a page, as docs/verification.md is")
    run.add_argument("--json", type=Path, help="write the figures to a file as well")
    plot = verbs.add_parser("plot", help="draw the curves and the last state of runs")
    plot.add_argument("results", nargs="+", type=Path, help="result folders of runs")
    plot.add_argument("--x", default="load_factor", help="column along x")
    plot.add_argument("--y", default=None, help="column along y; the first history when not given")
    plot.add_argument("--out", type=Path, default=Path("curves.png"), help="picture to write")
    points = verbs.add_parser("points", help="draw the material points of the last state, coloured by displacement")
    points.add_argument("results", nargs="+", type=Path)
    points.add_argument("--out", type=Path, default=Path("points.png"))
    figures = verbs.add_parser("figures", help="figures of the paper from runs under one folder, as the demo makes them")
    figures.add_argument("folder", type=Path, help="folder that holds the runs, one a deck")
    figures.add_argument("--out", type=Path, default=None, help="folder of the pictures; the same when not given")
    return main


def efforts_up_to(effort: str) -> tuple[str, ...]:
    """Efforts that a choice includes."""
    return EFFORTS if effort == "all" else EFFORTS[: EFFORTS.index(effort) + 1]


def run_cases(words: argparse.Namespace) -> int:
    """Run, judge, print."""
    cases = select(load_all(TOP / "verification" / "cases", TOP), words.cases, efforts_up_to(words.effort))
    if not words.program.exists():
        raise ResultError(f"{words.program} is not there: build it first (tools/test or cmake --build build)")
    done = 0

    def tell(run: Run) -> None:
        nonlocal done
        done += 1
        print(f"[{done}/{len(cases)}] {run.case.name}: {run.wall_seconds:.1f} s", file=sys.stderr, flush=True)

    runs = run_all(cases, words.program.resolve(), words.out, words.jobs, tell)
    verdicts = [verdict for case in cases for verdict in judge(case, runs)]
    print(verdict_table(verdicts))
    if words.json:
        write_json(verdicts, words.json)
    if words.markdown:
        finished = {run.case.name: run.directory for run in runs.values() if run.exit_code == 0}
        pictures = plots.page_figures(finished, words.markdown.parent / "figures")
        command = " ".join(["tools/qsmpm-verify run", *words.cases, f"--effort {words.effort} --markdown FILE"])
        write_markdown(verdicts, command, words.markdown, pictures)
    print(closing_line(verdicts))
    return 1 if counts(verdicts)[1] else 0


def main(arguments: list[str] | None = None) -> int:
    """Exit code 0 when all held, 1 on a miss, 2 when asked wrongly or a result is not there."""
    words = parser().parse_args(arguments)
    try:
        if words.verb == "list":
            for case in load_all(TOP / "verification" / "cases", TOP).values():
                print(f"{case.name:40s} {case.effort:6s} {case.title}")
            return 0
        if words.verb == "run":
            return run_cases(words)
        if words.verb == "plot":
            plots.plot_columns(words.results, words.x, words.y, words.out)
        elif words.verb == "points":
            plots.plot_points(words.results, words.out)
        else:
            for picture in plots.paper_figures(words.folder, words.out or words.folder):
                print(picture)
        return 0
    except (CaseError, ResultError) as trouble:
        print(f"qsmpm-verify: {trouble}", file=sys.stderr)
        return 2
