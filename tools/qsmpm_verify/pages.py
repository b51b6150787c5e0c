"""Markdown tables of a page, and the parts of a page that a command writes."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from pathlib import Path

from qsmpm_verify.trouble import Trouble


def markdown_table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """A table of a page; vertical bars inside cells are escaped."""
    lines = [[cell.replace("|", "\\|") for cell in row] for row in (header, *rows)]
    head, *body = ["| " + " | ".join(row) + " |" for row in lines]
    return [head, "|" + "---|" * len(header), *body]


def figure_folder(page: Path) -> Path:
    """Folder of the figures of a page: beside it, or for the tables of docs/data beside their folder."""
    return (page.parent.parent if page.parent.name == "data" else page.parent) / "figures"


def link_to(figure: Path, page: Path) -> str:
    """Link from a page to a figure."""
    return Path(os.path.relpath(figure, page.parent)).as_posix()


def marks(name: str) -> tuple[str, str]:
    """Marker lines between which a subcommand writes."""
    return f"<!-- begin qsmpm-verify {name} -->", f"<!-- end qsmpm-verify {name} -->"


def write_between(page: Path, name: str, lines: Sequence[str]) -> None:
    """Replace the text between the markers of a subcommand; a page without them is not changed and is an error."""
    begin, end = marks(name)
    pattern = re.compile(re.escape(begin) + r"\n.*?" + re.escape(end), re.DOTALL)
    try:
        text = page.read_text(encoding="utf-8")
    except OSError as error:
        raise Trouble(f"{page}: {error.strerror}") from error
    if len(pattern.findall(text)) != 1:
        raise Trouble(f"{page}: exactly one part is required between '{begin}' and '{end}'")
    body = "\n".join([begin, *lines, end])
    page.write_text(pattern.sub(lambda _: body, text), encoding="utf-8")
