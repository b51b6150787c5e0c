#!/usr/bin/env python3
"""Run every command of the pages of docs/tutorial and look for what the pages show of its answer; close with N passed, M failed.

    verification/tutorial.py [--pictures] [--howto]

A command is an indented line that begins with `$`; the indented lines below it are pieces of what it says. `--pictures`
copies the pictures the commands draw to docs/figures; `--howto` runs the pages of docs/howto instead, two minutes. Commands run in the top folder, as the reader types
them; `tools/qsmpm-verify` is a process of its own for the first one, and called here for the others, for to start Python and its
packages takes longer than what they draw.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

TOP = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(TOP / "tools"))
from qsmpm_verify.cli import main as verify  # noqa: E402

VERIFY = "tools/qsmpm-verify "
PAGES = TOP / "docs" / "tutorial"
LIMIT = 300
PICTURES = {
    "1_block": "tutorial_1", "2_column": "tutorial_2", "3_footing": "tutorial_3", "3_footing_strain": "tutorial_3_strain",
    "4_slope": "tutorial_4", "5_hill": "tutorial_5", "6_triaxial": "tutorial_6", "7_own_law": "tutorial_7",
    "8_stages": "tutorial_8", "8_stages_mechanism": "tutorial_8_mechanism", "9_drawdown": "tutorial_9",
    "9_drawdown_mechanism": "tutorial_9_mechanism", "10_wall": "tutorial_10", "10_wall_force": "tutorial_10_force",
}  # fmt: skip


def commands_of(page: Path) -> Iterator[tuple[str, list[str]]]:
    """The commands of a page, each with what is shown of its answer."""
    command, shown = "", []
    for line in page.read_text(encoding="utf-8").splitlines():
        inside = line.startswith("    ")
        if command and (not inside or line.startswith("    $ ")):
            yield command, shown
            command, shown = "", []
        if line.startswith("    $ "):
            command = line[6:]
        elif inside and command:
            shown.append(line.strip())
    if command:
        yield command, shown


def plain(text: str) -> str:
    """Text with its blanks squeezed."""
    return re.sub(r"\s+", " ", text)


def called_here(command: str) -> tuple[int, str]:
    """Exit code of a call of `tools/qsmpm-verify`, and what it says."""
    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        try:
            code = verify(shlex.split(command)[1:])
        except SystemExit as end:
            code = end.code if isinstance(end.code, int) else 2
    return code, said.getvalue()


def typed(command: str) -> tuple[int, str]:
    """Exit code of a command of the shell, and what it says."""
    try:
        done = subprocess.run(["bash", "-c", command], cwd=TOP, capture_output=True, text=True, timeout=LIMIT)
    except subprocess.TimeoutExpired:
        return 124, f"not done in {LIMIT} s"
    return done.returncode, done.stdout + done.stderr


def try_command(page: str, command: str, shown: list[str], here: bool) -> tuple[int, int]:
    """Run a command, by the shell or here; how many of the lines shown were said, and how many were not."""
    code, text = called_here(command) if here else typed(command)
    said = plain(text)
    missing = [line for line in shown if plain(line) not in said]
    for line in missing:
        print(f"MISSED {page}: $ {command}\n  shown: {line}\n  said:  {said[-600:]}")
    if not shown and code != 0:
        print(f"MISSED {page}: $ {command}\n  exit code {code}: {said[-600:]}")
        return 0, 1
    return max(len(shown), 1) - len(missing), len(missing)


def main() -> int:
    """All pages, one after the other."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pictures", action="store_true")
    parser.add_argument("--howto", action="store_true")
    words = parser.parse_args()
    passed = failed = 0
    known = False
    os.chdir(TOP)
    pages = TOP / "docs" / "howto" if words.howto else PAGES
    for page in sorted(pages.glob("*.md")):
        for command, shown in commands_of(page):
            plain_call = command.startswith(VERIFY) and not set(command) & set("|;<>&$")
            good, bad = try_command(page.name, command, shown, known and plain_call)
            known = known or plain_call
            passed, failed = passed + good, failed + bad
    for deck in sorted(pages.glob("*.inp")):
        short = len(deck.read_text(encoding="utf-8").splitlines()) <= 60
        print("" if short else f"MISSED {deck.name}: longer than 60 lines\n", end="")
        passed, failed = passed + short, failed + (not short)
    if words.pictures:
        for drawn, name in PICTURES.items():
            shutil.copy(TOP / "output" / f"{drawn}.png", TOP / "docs" / "figures" / f"{name}.png")
    print(f"{passed} passed, {failed} failed")
    return 1 if failed or not passed else 0


if __name__ == "__main__":
    sys.exit(main())
