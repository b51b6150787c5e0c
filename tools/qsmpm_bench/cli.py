"""The command `tools/bench`: one subcommand for each study; each prints Markdown and writes Markdown and CSV."""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

from qsmpm_bench import against, blocks, peers, shares
from qsmpm_bench.context import Bench, knows
from qsmpm_bench.decks import TOP
from qsmpm_bench.measure import BenchError, load_warning, processor
from qsmpm_bench.tables import Result, write_files, write_section
from qsmpm_verify.results import ResultError

Study = Callable[[Bench], Result]
STUDIES: dict[str, tuple[Study, str]] = {
    "kernels": (blocks.kernels, "point-iterations per CPU second by basis and dimension"),
    "parts": (shares.parts, "share of the time for each part; rate of the factorisation compared with dgemm"),
    "solvers": (shares.solvers, "output of build/bench_solvers"),
    "size": (blocks.size, "cost and memory against the number of points"),
    "memory": (blocks.size, "as size: bytes per point and per equation"),
    "threads": (shares.threads, "one and two threads: wall-clock seconds and identity of the results"),
    "scene": (shares.scene_study, "the model selected for a scene, its plane equivalent and its 3D slice"),
    "empty": (blocks.empty, "the same scene in a domain ten times larger"),
    "million": (blocks.million, "a million points in 3D"),
    "against": (against.against, "this program and another one (--against PROGRAM), alternately: speed for each scene"),
    "peers": (peers.peers, "three scenes compared with Kratos, one with xslope (tools/setup --peers)"),
}
#: `all`: every study once; what bench_solvers prints stands in a section of the page that is written by hand.
ALL = ["parts", "kernels", "size", "threads", "scene", "empty", "million", "peers"]


def parser() -> argparse.ArgumentParser:
    """Arguments of the command line."""
    main = argparse.ArgumentParser(prog="bench", description=__doc__)
    verbs = main.add_subparsers(dest="study", required=True, metavar="STUDY")
    for name, text in [("all", f"{', '.join(ALL)}"), *((name, text) for name, (_, text) in STUDIES.items())]:
        verb = verbs.add_parser(name, help=text)
        verb.add_argument("--repeat", type=int, default=3, help="number of runs for each value (default 3): medians and spreads")
        verb.add_argument("--quick", action="store_true", help="small scenes, as a functional test")
        verb.add_argument("--program", type=Path, default=TOP / "build" / "qsmpm", help="program to measure")
        verb.add_argument("--against", type=Path, help="for against, kernels, parts: another program, run alternately with it")
        verb.add_argument("--out", type=Path, default=TOP / "build" / "bench", help="folder of runs, Markdown and CSV")
        verb.add_argument("--json", type=Path, help="also write the results to a file")
        verb.add_argument("--markdown", type=Path, metavar="PAGE",
                          help="write the sections of a page in the format of docs/data/performance.md")
        verb.add_argument("--figures", type=Path, help="write charts to a folder, such as docs/figures")
    return main


def heading(words: argparse.Namespace, name: str, load: float, seconds: float) -> str:
    """How the results were obtained."""
    command = f"tools/bench {name} --repeat {words.repeat}" + (" --quick" if words.quick else "")
    version = subprocess.run([str(words.program), "--version"], capture_output=True, text=True, check=False).stdout
    text = (f"`{command}`: medians of {words.repeat} (smallest-largest), one thread unless stated; {version.strip()}; "
            f"{processor()}, {os.cpu_count()} cores, load average {load:.2f} at the start, {seconds:.0f} s.")
    warning = load_warning(load)
    return f"{text} **{warning[0].upper()}{warning[1:]}.**" if warning else text


def run(words: argparse.Namespace) -> None:
    """Run the studies, print and write their results."""
    if words.repeat < 1:
        raise BenchError("--repeat must be at least 1")
    if not words.program.exists():
        raise BenchError(f"{words.program} not found: build it first")
    if not knows(words.program, "--profile"):
        raise BenchError(f"{words.program} does not support --profile")
    bench = Bench(words.program.resolve(), words.out / "runs", words.repeat, words.quick, words.against, words.figures)
    figures = {}
    for name in ALL if words.study == "all" else [words.study]:
        load, started = os.getloadavg()[0], time.monotonic()
        if load_warning(load):
            print(f"bench: {load_warning(load)}", file=sys.stderr)
        result = STUDIES[name][0](bench)
        head = heading(words, name, load, time.monotonic() - started)
        body = f"{head}\n\n{result.markdown()}"
        print(body, flush=True)
        write_files(result, words.out)
        figures[name] = {"heading": head, **result.plain()}
        if words.markdown:
            page = write_section(words.markdown.read_text(encoding="utf-8"), result.name, body)
            words.markdown.write_text(page, encoding="utf-8")
        if words.json:
            words.json.write_text(json.dumps(figures, indent=2) + "\n", encoding="utf-8")


def main(arguments: list[str] | None = None) -> int:
    """Exit code 0 if the results are available, 2 if they cannot be obtained."""
    words = parser().parse_args(arguments)
    try:
        run(words)
    except (BenchError, ResultError, OSError) as trouble:
        print(f"bench: {trouble}", file=sys.stderr)
        return 2
    return 0
