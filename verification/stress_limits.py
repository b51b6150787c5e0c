#!/usr/bin/env python3
"""What runs stated of their stress error, for the limits of docs/methods/stress_error.md: one line a group of cases.

Usage: stress_limits.py [FOLDER...]   (no runs are made)

A folder holds finished runs, that is files job.log at any depth; build/verify and build/stability when none is given, where
`qsmpm-verify run` and `map` put theirs. A group is the folder below it. The last line of each log that states an error counts.
"""
from __future__ import annotations

import pathlib
import re
import sys

TOP = pathlib.Path(__file__).resolve().parent.parent
FOLDERS = ("build/verify", "build/stability")
SCATTER = re.compile(r"^stress error, estimated: mean (\S+) %")
MISMATCH = re.compile(r"; on (?:loaded|held) surface '.*?' mean (\S+) %")
WARNING = re.compile(r"^warning: stresses (?:of neighbouring material points differ|differ from the traction)")


def stated(log: pathlib.Path) -> tuple[float, float | None, bool] | None:
    """Mean scatter and mean mismatch in per cent, and whether the run warns; None where no stress error is stated."""
    lines = log.read_text(encoding="utf-8", errors="replace").splitlines()
    last = next((line for line in reversed(lines) if SCATTER.match(line)), None)
    if last is None:
        return None
    mismatch = MISMATCH.search(last)
    return (float(SCATTER.match(last).group(1)), float(mismatch.group(1)) if mismatch else None,
            any(WARNING.match(line) for line in lines))  # fmt: skip


def span(values: list[float]) -> str:
    """Smallest and largest."""
    return f"{min(values):.2g} to {max(values):.2g}" if values else "-"


def main() -> None:
    """Print the table."""
    folders = [pathlib.Path(word) for word in sys.argv[1:]] or [TOP / folder for folder in FOLDERS]
    groups: dict[str, list[tuple[float, float | None, bool]]] = {}
    for folder in folders:
        for log in sorted(folder.rglob("job.log")):
            found = stated(log)
            if found:
                groups.setdefault(log.relative_to(folder).parts[0], []).append(found)
    print("| group | runs | mean scatter, % | mismatch, % | runs that warn |\n|---|---|---|---|---|")
    for name, runs in sorted(groups.items()):
        mismatches = [run[1] for run in runs if run[1] is not None]
        print(f"| {name} | {len(runs)} | {span([run[0] for run in runs])} | {span(mismatches)} "
              f"| {sum(run[2] for run in runs)} |")  # fmt: skip
    everything = [run for runs in groups.values() for run in runs]
    print(f"\n{sum(run[2] for run in everything)} of {len(everything)} runs warn.")


if __name__ == "__main__":
    main()
