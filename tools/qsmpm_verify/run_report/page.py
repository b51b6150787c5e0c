"""A report of a run as one HTML file."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from pathlib import Path

from qsmpm_verify.hypertext import SCRIPT, STYLE, figure, inline_svg, table, text, with_tips
from qsmpm_verify.run_report.content import Heading, Picture, Piece, Rows

MARKED = """.warning { background: #fff3d6; padding: 2px 10px; } pre { background: #f7f7f7; padding: 8px; font-size: 12px; overflow-x: auto; }
@media print { pre { font-size: 7.5pt; white-space: pre-wrap; } }"""


def shown(piece: Piece) -> str:
    """An element as HTML."""
    if isinstance(piece, Heading):
        return f"<h2 id={piece.name}>{text(piece.text)}</h2>\n"
    if isinstance(piece, Rows):
        return table(piece.header, [("", row) for row in piece.rows])
    if isinstance(piece, Picture):
        if piece.svg is not None:
            return figure(with_tips(inline_svg(piece.svg), piece.tips), piece.caption)
        data = base64.b64encode(piece.png.read_bytes()).decode()
        return figure(f'<img alt="{text(piece.caption)}" src="data:image/png;base64,{data}">', piece.caption)
    if piece.kind == "deck":
        return "<details><summary>the deck with all defaults</summary><pre>" + text("\n".join(piece.lines)) + "</pre></details>\n"
    return "".join(f"<p{' class=warning' if piece.kind == 'warning' else ''}>{text(line)}</p>\n" for line in piece.lines)


def write_page(title: str, pieces: Sequence[Piece], out: Path) -> Path:
    """The page."""
    links = " | ".join(f"<a href='#{piece.name}'>{text(piece.text)}</a>" for piece in pieces if isinstance(piece, Heading))
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_text(
        "<!doctype html><html lang=en><meta charset=utf-8><meta name=viewport content='width=device-width, initial-scale=1'>"
        f"<title>{text(title)}</title><style>{STYLE}{MARKED}</style>\n<h1>{text(title)}</h1>\n<nav>{links}</nav>\n"
        + "".join(shown(piece) for piece in pieces) + f"<script>{SCRIPT}</script></html>\n", encoding="utf-8")
    return out
