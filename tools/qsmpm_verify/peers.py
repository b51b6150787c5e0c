"""`peers`: comparison of QSMPM with other programs: CalculiX, Kratos, OpenGeoSys and xslope, if installed.

The scenes are verification/peers/*.toml. A mesh, its supports and its loads are taken from QSMPM's own results and given
to the other program, or ground, strengths and water from the deck. Exit code 1 if a comparison failed; a program that is not installed is
reported, and its comparisons are skipped.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from textwrap import wrap
from typing import Any

from qsmpm_verify.chart import command_of, markdown_table
from qsmpm_verify.peers_compute import NAMES, VERSIONS, Computer, Outcome
from qsmpm_verify.peers_judge import Finding, as_rows, chart_point, judge_check
from qsmpm_verify.peers_scenes import Scene, load_scenes
from qsmpm_verify.places import BUILD, PEERS, PROGRAM, TOP
from qsmpm_verify.progress import Progress
from qsmpm_verify.report import WORDS, table
from qsmpm_verify.trouble import Trouble

HEADER = ["check", "value", "peer's", "difference", "tolerance", "verdict", "CPU s", "peer's CPU s"]
ABSENT = "not compared"
WIDTH = 160
"""Columns of the page's prose."""


def add_words(verbs: argparse._SubParsersAction) -> None:
    """Arguments of the subcommand."""
    verb = verbs.add_parser("peers", help="compute scenes with CalculiX, Kratos, OpenGeoSys and xslope and compare the results")
    verb.add_argument("scenes", nargs="*", help="names of scenes (verification/peers); default all")
    verb.add_argument("--program", type=Path, default=PROGRAM, help="QSMPM's program")
    verb.add_argument("--out", type=Path, default=BUILD / "peers", help="folder of the runs")
    verb.add_argument("--effort", choices=("quick", "long"), default="quick", help="quick (default) or long")
    verb.add_argument("--quick", dest="effort", action="store_const", const="quick", help="equivalent to --effort quick")
    verb.add_argument("--fresh", action="store_true", help="repeat runs that are already available")
    verb.add_argument("--json", type=Path, default=BUILD / "peers.json", help="JSON file of the results")
    verb.add_argument("--markdown", type=Path, help="write the results as a page in the format of docs/peers.md")
    verb.set_defaults(act=act)


def _number(value: float | None, form: str) -> str:
    return "-" if value is None else format(value, form)


def verdict_of(finding: Finding) -> str:
    """The verdict in the table."""
    return ABSENT if finding.note and finding.held is None else WORDS[finding.held]


def row_of(finding: Finding) -> list[str]:
    """A line of the table."""
    return [
        f"{finding.quantity}: {finding.run} by {finding.against}", _number(finding.value, ".7g"),
        _number(finding.peer_value, ".7g"), _number(finding.difference, ".1e"), _number(finding.tolerance, ".1e"),
        verdict_of(finding), _number(finding.seconds, ".2f"), _number(finding.peer_seconds, ".2f"),
    ]  # fmt: skip


def versions() -> list[str]:
    """One sentence for each program: its version, or that it is not installed."""
    return [
        version() or f"not installed: {NAMES[key]}; its comparisons are skipped" for key, version in VERSIONS.items() if key != "script"
    ]  # fmt: skip


def scene_page(scene: Scene, findings: list[Finding]) -> list[str]:
    """A scene as lines of the page."""
    deck = scene.deck.relative_to(TOP)
    lines = [f"## {scene.title}", "", *wrap(f"`{deck}`, `verification/peers/{scene.name}.toml`. {scene.note}", WIDTH), ""]
    if not findings:
        return [*lines, "No check; the results are under *Error and cost of the other programs*.", ""]
    lines += [*markdown_table(HEADER, [row_of(f) for f in findings]), ""]
    reasons = dict.fromkeys(f"{f.tolerance:.1e}: {f.reason}." for f in findings if f.tolerance is not None)
    notes = [f"{f.quantity}, {f.run} by {f.against}: {f.note}" for f in findings if f.note]
    said = dict.fromkeys(f"{line}." for f in findings for line in f.said)
    return [*lines, *(part for line in [*reasons, *notes, *said] for part in wrap(f"- {line}", WIDTH, subsequent_indent="  ")), ""]


def points_page(points: list[dict[str, Any]]) -> list[str]:
    """The points for the charts as lines of the page."""
    rows = [
        [p["study"], p["label"], f"{p['size']:g}", _number(p["error"], ".2e"), _number(p["seconds"], ".2f"), p["note"]]
        for p in points
    ]  # fmt: skip
    return ["## Error and cost of the other programs", "", "CPU seconds of the whole process.", "",
            *markdown_table(["study", "program", "size", "error", "CPU s", "note"], rows), ""]  # fmt: skip


def page_head(command: str) -> list[str]:
    """Head of the page."""
    text = (
        f"Written by `{command} --markdown FILE`; do not edit. {'; '.join(versions())}. CPU seconds are those of whole "
        "processes on one thread. Where another program uses the same mesh, it receives nodes, cells, supports and loads from "
        "QSMPM's results, so that only element, integration rule and equilibrium are compared."
    )
    return ["# QSMPM beside other programs", "", *wrap(text, WIDTH), ""]


def _judge(scene: Scene, outcomes: dict[str, Outcome]) -> tuple[list[Finding], list[dict[str, Any]]]:
    findings = [found for check in scene.checks if (found := judge_check(scene, check, outcomes)) is not None]
    points = [made for point in scene.points if (made := chart_point(scene, point, outcomes)) is not None]
    return findings, points


def act(words: argparse.Namespace) -> int:
    """Run, assess, report."""
    scenes = load_scenes(PEERS, TOP, words.scenes)
    efforts = ("quick", "long") if words.effort == "long" else ("quick",)
    if not words.program.is_file():
        raise Trouble(f"{words.program} not found: build it first (tools/test or cmake --build build)")
    progress = Progress(sum(run.effort in efforts for scene in scenes for run in scene.runs.values()))
    computer = Computer(words.program.resolve(), words.out.resolve(), words.fresh, progress.tell)
    page = page_head(command_of(words, "peers", words.scenes))
    findings: list[Finding] = []
    points: list[dict[str, Any]] = []
    for scene in scenes:
        own, drawn = _judge(scene, computer.scene(scene, efforts))
        if own:
            print(f"\n{scene.title}\n\n{table(HEADER, [row_of(f) for f in own])}")
        print("".join(f"\n{f.quantity}, {f.run} by {f.against}: {f.note}" for f in own if f.note), end="")
        findings, points, page = findings + own, points + drawn, page + scene_page(scene, own)
    words.json.parent.mkdir(parents=True, exist_ok=True)
    content = {"peers": versions(), "checks": as_rows(findings), "points": points}
    words.json.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    if words.markdown:
        words.markdown.write_text("\n".join([*page, *points_page(points)]).rstrip() + "\n", encoding="utf-8")
    held, missed = sum(f.held is True for f in findings), sum(f.held is False for f in findings)
    absent = sum(verdict_of(f) == ABSENT for f in findings)
    print("\n" + "\n".join(versions()))
    print(f"{held} passed, {missed} failed" + (f", {absent} skipped" if absent else ""))
    return 1 if missed else 0
