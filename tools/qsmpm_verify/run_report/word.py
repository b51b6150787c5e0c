"""A report of a run as a document (.docx), by python-docx."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from docx import Document
from docx.shared import Mm, Pt

from qsmpm_verify.run_report.content import Heading, Picture, Piece, Rows

PAPER, MARGIN = (Mm(210), Mm(297)), Mm(20)
WIDTH, HEIGHT = Mm(170), Mm(95)
"""Widths of figures: that of the text area of a page, and for two figures on one page."""


def write_document(title: str, pieces: Sequence[Piece], out: Path) -> Path:
    """The same elements as the page."""
    document = Document()
    page = document.sections[0]
    page.page_width, page.page_height = PAPER
    page.left_margin = page.right_margin = page.top_margin = page.bottom_margin = MARGIN
    document.add_heading(title, level=0)
    for piece in pieces:
        if isinstance(piece, Heading):
            document.add_heading(piece.text, level=1)
        elif isinstance(piece, Rows):
            add_table(document, piece)
        elif isinstance(piece, Picture):
            shape = document.add_picture(str(piece.png), width=WIDTH)
            if shape.height > HEIGHT:
                shape.width, shape.height = int(shape.width * HEIGHT / shape.height), HEIGHT
            document.paragraphs[-1].paragraph_format.keep_with_next = True
            document.add_paragraph(piece.caption, style="Caption")
        elif piece.kind == "deck":
            run = document.add_paragraph().add_run("\n".join(piece.lines))
            run.font.size, run.font.name = Pt(7), "Courier New"
        else:
            for line in piece.lines:
                document.add_paragraph(line, style="List Bullet" if piece.kind == "warning" else None).paragraph_format.space_after = Pt(3)
    out.parent.mkdir(parents=True, exist_ok=True)
    document.save(str(out))
    return out


def add_table(document: Any, piece: Rows) -> None:
    """A table with column widths that fit the longest words."""
    lines = [piece.header, *piece.rows]
    longest = [max(len(word) for line in lines for word in (line[i].split() or [""])) + 2 for i in range(len(piece.header))]
    grid = document.add_table(rows=len(lines), cols=len(piece.header), style="Light Grid Accent 1")
    grid.autofit = False
    for column, share in zip(grid.columns, longest, strict=True):
        column.width = int(WIDTH * share / sum(longest))
    for row, line in zip(grid.rows, lines, strict=True):
        for cell, value, share in zip(row.cells, line, longest, strict=True):
            cell.text, cell.width = value, int(WIDTH * share / sum(longest))
            cell.paragraphs[0].runs[0].font.size = Pt(8)
