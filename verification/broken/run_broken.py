#!/usr/bin/env python3
"""Run every broken deck and check how the program refuses it.

    run_broken.py QSMPM [NAME ...]
    run_broken.py --show NAME

A deck is a good one of `bases/` with patches: `block.toml` lists those made of `bases/block.inp`, each with its name, what is
expected, lines of comment (`head`) and pairs of an old text, which occurs once, and a new one, applied in order. `--show` prints a
deck as it is run, whose lines are those that the messages name. The bases must pass the check; a deck that no
patch can say (bytes that are no text) stands here as a file. A deck begins with what is expected, one line each:

    ** expect exit 2 line 7: *CONTROLS: unknown parameter 'TOLERENCE'
    ** expect exit 2 line 2 in parts/wrong.txt: *CONTROLS: STEPS 'ten' is not a number
    ** expect exit 5: singular

Each must be found as the start of the message of one line of output, for that file and line (text
behind `...` anywhere in it), and the number of messages must be that of the expectations. A deck with a
*POINT TEST is run by `point`; a line `** by run` or `** by point` behind the expectations names the command instead,
and then the deck itself is good. A deck that is refused with code 2, or at a line with another code, is both
checked and run, and nothing may be written; one that fails later passes the check.
Prints one line per deck and closes with `N passed, N failed`.
"""
from __future__ import annotations

import pathlib
import re
import shutil
import sys
import tempfile
import tomllib

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[1] / "tools"))
from qsmpm_verify.cpu_limit import run_limited  # noqa: E402

CPU_SECONDS = 60
EXPECTATION = re.compile(r"\*\* expect exit (\d+)(?: line (\d+)(?: in (\S+))?)?: (.*)")


def patched(base: str, row: dict) -> str:
    """The text of a deck: what is expected, its comment, the patched base."""
    text = base
    for old, new in row.get("patch", []):
        if text.count(old) != 1:
            sys.exit(f"{row['name']}: {old!r} occurs {text.count(old)} times, not once")
        text = text.replace(old, new)
    return "".join([*(f"** expect {line}\n" for line in row["expect"]), *(f"** {line}\n" for line in row.get("head", [])), text])


def texts() -> dict[str, str]:
    """The decks of all tables by their names."""
    found: dict[str, str] = {}
    for table in sorted(HERE.glob("*.toml")):
        base = (HERE / "bases" / f"{table.stem}.inp").read_text(encoding="ascii")
        for row in tomllib.loads(table.read_text(encoding="utf-8"))["deck"]:
            if row["name"] in found:
                sys.exit(f"{table.name}: {row['name']} is there twice")
            found[row["name"]] = patched(base, row)
    return found


def laid_out(place: pathlib.Path) -> list[pathlib.Path]:
    """All decks, written where they are run, beside the files that they name."""
    shutil.copytree(HERE / "parts", place / "parts")
    for name, text in texts().items():
        (place / f"{name}.inp").write_text(text, encoding="ascii")
    for file in [*HERE.glob("*.inp"), HERE / "run_broken.py"]:
        shutil.copy(file, place)
    return sorted(place.glob("*.inp"))


class Expectation:
    """What one header line says."""

    def __init__(self, match: re.Match[str], deck: str) -> None:
        self.code = int(match[1])
        self.place = f"{match[3] or deck}:{match[2]}: " if match[2] else ""
        self.text = match[4].strip()

    def found_in(self, output: str) -> bool:
        if self.place:
            first, *others = (self.place + self.text).split("...")
            return any(line.startswith(first) and all(other.strip() in line for other in others)
                       for line in output.splitlines())
        return self.text.lower() in output.lower()


def read_expectations(deck: pathlib.Path) -> list[Expectation]:
    """The expectations at the head of a deck."""
    found = []
    for line in deck.read_text(encoding="utf-8-sig").splitlines():
        match = EXPECTATION.match(line)
        if not match:
            break
        found.append(Expectation(match, deck.name))
    return found


def call(program: str, place: pathlib.Path, *words: str) -> tuple[int | None, str]:
    """Exit code (None when it took too long) and all output of the program."""
    ended = run_limited([program, *words], CPU_SECONDS, cwd=place)
    return ended.code, ended.output + ended.errors + ended.reason


def judge(output: str, code: int | None, wanted: list[Expectation]) -> str:
    """What is wrong with a refusal, empty when nothing is."""
    if code is None:
        return output
    if code != wanted[0].code:
        return f"exit code {code}, not {wanted[0].code}: {output.strip()[-200:]}"
    for expectation in wanted:
        if not expectation.found_in(output):
            return f"no line '{expectation.place}{expectation.text}' in: {output.strip()}"
    messages = [line for line in output.splitlines() if re.match(r"\S+:\d+: (?!warning: )|\S+\.inp: the deck ", line)]
    if wanted[0].code == 2 and len(messages) != len(wanted):
        return f"{len(messages)} messages, not {len(wanted)}: {output.strip()}"
    return ""


def by_command(text: str) -> str:
    """The command a deck names for itself, empty when it names none."""
    found = re.search(r"^\*\* by (run|point)$", text, re.M)
    return found[1] if found else ""


def try_deck(program: str, deck: pathlib.Path) -> str:
    """Check and run one deck; what is wrong with the way it is refused, empty when nothing is."""
    wanted = read_expectations(deck)
    if not wanted:
        return "the deck does not tell what is expected"
    code, output = call(program, deck.parent, "check", "--plugins", deck.name)
    early = wanted[0].code == 2 or bool(wanted[0].place)
    good = not early or by_command(deck.read_text(encoding="utf-8-sig", errors="replace"))
    if good and code != 0:
        return f"check: exit code {code}, not 0: {output.strip()[-200:]}"
    problem = judge(output, code, wanted) if not good else ""
    if problem:
        return "check: " + problem
    text = deck.read_text(encoding="utf-8-sig", errors="replace")
    command = by_command(text) or ("point" if "\n*POINT TEST" in text else "run")
    with tempfile.TemporaryDirectory() as folder:
        target = pathlib.Path(folder) / "out"
        before = set(deck.parent.rglob("*"))
        code, output = call(program, deck.parent, command, deck.name, "--out", str(target))
        problem = judge(output, code, wanted)
        if problem:
            return "run: " + problem
        if early and (target.exists() or set(deck.parent.rglob("*")) != before):
            return "run: something was written"
    return ""


def wrong_bases(program: str) -> list[str]:
    """Bases that do not pass the check; a library that is not there is no fault of theirs."""
    return [base.name for base in sorted((HERE / "bases").glob("*.inp")) if call(program, HERE / "bases", "check", base.name)[0] not in (0, 6)]


def main() -> int:
    if len(sys.argv) == 3 and sys.argv[1] == "--show":
        print(texts()[sys.argv[2]], end="")
        return 0
    if len(sys.argv) < 2:
        print(__doc__)
        return 2
    program = str(pathlib.Path(sys.argv[1]).resolve())
    failed, count = 0, 0
    with tempfile.TemporaryDirectory() as folder:
        for deck in laid_out(pathlib.Path(folder)):
            if len(sys.argv) > 2 and deck.stem not in sys.argv[2:]:
                continue
            problem = try_deck(program, deck)
            failed += bool(problem)
            count += 1
            print(f"FAILED {deck.stem}: {problem}" if problem else f"ok     {deck.stem}")
    for name in wrong_bases(program):
        failed += 1
        print(f"FAILED bases/{name}: does not pass the check")
    print(f"{count - failed} passed, {failed} failed")
    return 1 if failed or not count else 0


if __name__ == "__main__":
    sys.exit(main())
