"""`week`: the scenes of an engineer's first week with default settings, with hand values, CPU seconds and the predicted range."""

from __future__ import annotations

import argparse
import json
import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from qsmpm_verify.batch import add_running_words, checked_program, efforts_up_to
from qsmpm_verify.cases import Case, load_all, select
from qsmpm_verify.cpu_limit import run_limited
from qsmpm_verify.judge import Verdict, judge
from qsmpm_verify.pages import markdown_table
from qsmpm_verify.places import TOP, WEEK
from qsmpm_verify.progress import Progress
from qsmpm_verify.report import closing_line, counts, table, word_of, write_json
from qsmpm_verify.runner import Run, run_all

HEADER = ["case", "figure", "value", "hand value", "error", "tolerance", "verdict", "CPU s", "plan, CPU s"]
HOLDS = 0.8
"""Required share of plans whose range holds."""

Range = tuple[float, float]


def add_words(verbs: argparse._SubParsersAction) -> None:
    """Arguments of the subcommand."""
    verb = verbs.add_parser("week", help="run the scenes of an engineer's first week with default settings and compare them with hand values and plans")
    verb.add_argument("cases", nargs="*", help="names, files or patterns; default all")
    add_running_words(verb, "week")
    verb.add_argument("--no-plan", dest="plan", action="store_false", help="omit the plans")
    verb.add_argument("--markdown", type=Path, help="write the results as a page in the format of docs/data/week.md")
    verb.add_argument("--json", type=Path, help="also write the results to a file")
    verb.set_defaults(act=act)


def range_of(text: str) -> Range | None:
    """The range of CPU seconds that a plan predicts for a run: `2.1 to 15 s: ...`."""
    hit = re.match(r"([\d.]+(?:E[+-]?\d+)?) to ([\d.]+(?:E[+-]?\d+)?) s\b", text)
    return (float(hit[1]), float(hit[2])) if hit else None


def planned(run: Run, program: Path) -> Range | None:
    """Prediction of `qsmpm plan` for the deck of a run."""
    deck = run.directory.parent / "deck" / run.case.deck.name
    if run.case.command != "run" or not deck.is_file():
        return None
    ended = run_limited([program, "plan", deck, "--json"], 60.0)
    if ended.code != 0:
        return None
    words = json.loads(ended.output).get("first step", {})
    return range_of(str(words.get("expected of the run", "")))


def seconds_of(verdicts: Sequence[Verdict]) -> float:
    """CPU seconds of a case; NaN if it wrote none."""
    return next((v.cpu_seconds for v in verdicts if v.cpu_seconds is not None), math.nan)


def lines(verdicts: Mapping[str, list[Verdict]], plans: Mapping[str, Range | None]) -> list[list[str]]:
    """Rows of the table."""
    rows = []
    for name, figures in verdicts.items():
        plan = plans.get(name)
        for i, v in enumerate(figures):
            told = "" if i else ("-" if plan is None else f"{plan[0]:.2g} to {plan[1]:.2g}")
            rows.append([
                name if i == 0 else "", v.quantity, f"{v.value:.5g}", v.reference, "-" if v.error is None else f"{100 * v.error:.1f} %",
                v.tolerance, word_of(v), "" if i else f"{seconds_of(figures):.2f}", told,
            ])  # fmt: skip
    return rows


def plan_verdict(verdicts: Mapping[str, list[Verdict]], plans: Mapping[str, Range | None], cases: Mapping[str, Case]) -> Verdict | None:
    """Whether enough of the ranges hold; failed runs do not count."""
    inside = [
        plan is not None and plan[0] <= seconds_of(verdicts[name]) <= plan[1]
        for name, plan in plans.items()
        if cases[name].command == "run" and verdicts[name][0].held and not verdicts[name][0].expected
        and not math.isnan(seconds_of(verdicts[name]))
    ]  # fmt: skip
    if not inside:
        return None
    share = sum(inside) / len(inside)
    # One scene of a few is not counted against it.
    wanted = min(HOLDS, (len(inside) - 1) / len(inside))
    return Verdict("week", f"plans whose range holds, of {len(inside)}", share, f">= {wanted:.2g}", None, "-", share >= wanted, None)


def page(command: str, rows: list[list[str]], plan: Verdict | None, notes: Sequence[str]) -> str:
    """The page of the results."""
    text = ["# A week of scenes", "", f"Written by `{command}`; do not edit. CPU seconds are those of the machine used.", "",
            *markdown_table(HEADER, rows)]  # fmt: skip
    if plan is not None:
        text += ["", f"{plan.quantity}: {100 * plan.value:.0f} %."]
    return "\n".join([*text, "", *(f"- {note}" for note in notes)]) + "\n"


def act(words: argparse.Namespace) -> int:
    """Run, plan, assess, print. Exit code 1 if a result missed."""
    cases = select(load_all(WEEK, TOP), words.cases, efforts_up_to(words.effort))
    program = checked_program(words)
    progress = Progress(len(cases))
    runs = run_all(
        cases, program, words.out, words.jobs,
        lambda run: progress.tell(run.case.name, run.wall_seconds, run.reused), words.fresh,
    )  # fmt: skip
    verdicts = {case.name: judge(case, runs) for case in cases}
    plans = {case.name: planned(runs[case.name], program) for case in cases} if words.plan else {}
    plan = plan_verdict(verdicts, plans, {case.name: case for case in cases})
    rows = lines(verdicts, plans)
    print(table(HEADER, rows))
    flat = [v for figures in verdicts.values() for v in figures] + ([plan] if plan else [])
    notes = [f"{v.case}, {v.quantity}: {v.note}" for v in flat if v.note and (v.held is False or v.expected)]
    print(*notes, sep="\n")
    if plan:
        print(f"{plan.quantity}: {plan.value:.2f}, {word_of(plan)}")
    if words.json:
        write_json(flat, words.json)
    if words.markdown:
        words.markdown.write_text(page(f"tools/qsmpm-verify week --effort {words.effort} --markdown FILE", rows, plan, notes), encoding="utf-8")
    print(closing_line(flat))
    return 1 if counts(flat)[1] else 0
