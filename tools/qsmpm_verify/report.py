"""Tables as text and as pages, JSON output, and the closing line."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from qsmpm_verify.judge import Verdict
from qsmpm_verify.pages import link_to

WORDS = {True: "held", False: "MISSED", None: "printed"}


def word_of(verdict: Verdict) -> str:
    """The verdict as a word."""
    return "expected" if verdict.expected else WORDS[verdict.held]


def table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Columns under headings; the first is left-aligned, the others are right-aligned."""
    cells = [list(header), *(list(row) for row in rows)]
    widths = [max(len(row[i]) for row in cells) for i in range(len(header))]
    lines = [
        "  ".join(
            cell.ljust(width) if i == 0 else cell.rjust(width)
            for i, (cell, width) in enumerate(zip(row, widths))
        ).rstrip()
        for row in cells
    ]
    lines.insert(1, "  ".join("-" * width for width in widths))
    return "\n".join(lines)


def verdict_table(verdicts: Sequence[Verdict]) -> str:
    """The results of the cases, one line each, followed by notes."""
    rows = [
        [
            v.case,
            v.quantity,
            f"{v.value:.7g}",
            v.reference,
            "-" if v.error is None else f"{v.error:.2e}",
            v.tolerance,
            word_of(v),
            "-" if v.cpu_seconds is None else f"{v.cpu_seconds:.2f}",
        ]
        for v in verdicts
    ]
    header = ["case", "quantity", "value", "reference", "error", "tolerance", "verdict", "CPU s"]
    notes = [f"{v.case}, {v.quantity}: {v.note}" for v in verdicts if v.note and (v.held is False or v.expected)]
    return "\n".join([table(header, rows), *notes])


def counts(verdicts: Sequence[Verdict]) -> tuple[int, int]:
    """Number of results that passed (or miss as expected) and that failed; printed results count as neither."""
    return sum(v.held is True for v in verdicts), sum(v.held is False for v in verdicts)


def closing_line(verdicts: Sequence[Verdict]) -> str:
    """`N passed, N failed`."""
    held, missed = counts(verdicts)
    return f"{held} passed, {missed} failed"


def write_json(verdicts: Sequence[Verdict], path: Path) -> None:
    """The results as a list of objects; values that are not finite numbers are null."""

    def clean(value: object) -> object:
        return None if isinstance(value, float) and not math.isfinite(value) else value

    rows = [{key: clean(value) for key, value in asdict(v).items()} for v in verdicts]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")


def write_markdown(verdicts: Sequence[Verdict], command: str, path: Path, pictures: Sequence[Path] = ()) -> None:
    """The results as a page; the command that wrote it is at its head, figures beside the page are at its end."""
    lines = ["# Verification figures", "", f"Written by `{command}`; do not edit. CPU seconds are those of the machine used.", "",
             "| case | quantity | value | reference | error | tolerance | verdict | CPU s |", "|---|---|---|---|---|---|---|---|"]  # fmt: skip
    for v in verdicts:
        error = "-" if v.error is None else f"{v.error:.2e}"
        cpu = "-" if v.cpu_seconds is None else f"{v.cpu_seconds:.2f}"
        lines.append(f"| {v.case} | {v.quantity} | {v.value:.7g} | {v.reference} | {error} | {v.tolerance} | {word_of(v)} | {cpu} |")
    for picture in pictures:
        lines += ["", f"![{picture.stem.replace('_', ' ')}]({link_to(picture, path)})"]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
