"""Pieces of the page that `report` writes: its style, text, tables, commands and drawings as parts of HTML."""

from __future__ import annotations

import html
import re
from collections.abc import Sequence
from pathlib import Path

STYLE = """
body { font: 15px/1.45 sans-serif; color: #222; max-width: 1080px; margin: 2em auto; padding: 0 1em; }
h1, h2 { line-height: 1.2; } h2 { border-bottom: 1px solid #ccc; margin-top: 2em; }
table { border-collapse: collapse; font-size: 13px; margin: .8em 0; }
th, td { padding: 2px 9px; border-bottom: 1px solid #e3e3e3; text-align: left; }
th { background: #f4f4f4; } td.n { text-align: right; }
figure { margin: 1em 0; } figure svg, figure img { max-width: 100%; height: auto; }
figcaption, .command { font-size: 12.5px; color: #555; } code { background: #f4f4f4; padding: 1px 4px; }
@media print { details { display: block; } details > * { display: block; } figure, table { break-inside: avoid; } a { color: inherit; } }
.missed { background: #f7c6c6; } .best { background: #e4f5e8; } details { margin: .6em 0; } summary { cursor: pointer; }
"""

NUMBER = re.compile(r"(<= |>= )?-?\d[\d.]*(e[-+]?\d+)?$")


def text(value: object) -> str:
    """Text without marks of the language."""
    return html.escape(str(value))


def table(header: Sequence[str], rows: Sequence[tuple[str, Sequence[str]]]) -> str:
    """A table; every row has a class and its cells."""
    head = "".join(f"<th>{text(h)}</th>" for h in header)
    body = "".join(
        f"<tr{f' class={kind}' if kind else ''}>"
        + "".join(f"<td{' class=n' if NUMBER.match(cell) else ''}>{text(cell)}</td>" for cell in cells)
        + "</tr>\n"
        for kind, cells in rows
    )
    return f"<table><thead><tr>{head}</tr></thead><tbody>\n{body}</tbody></table>\n"


def command(line: str) -> str:
    """The command that brings a figure again."""
    return f'<p class="command">Again by <code>{text(line)}</code></p>\n'


def inline_svg(path: Path) -> str:
    """A drawing as part of the page: without its head, names of parts made its own."""
    drawing = path.read_text(encoding="utf-8")
    drawing = drawing[drawing.index("<svg") :]
    drawing = re.sub(r"<metadata>.*?</metadata>", "", drawing, flags=re.DOTALL)
    own = re.sub(r"\W", "_", path.stem)
    drawing = re.sub(r'\bid="([^"]+)"', rf'id="{own}_\1"', drawing)
    drawing = re.sub(r'(xlink:href="#|url\(#)', rf"\1{own}_", drawing)
    return drawing


def figure(content: str, caption: str) -> str:
    """A picture with its text."""
    return f"<figure>{content}<figcaption>{text(caption)}</figcaption></figure>\n"
