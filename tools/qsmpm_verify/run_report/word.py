"""A report of a run as a document (.docx), by python-docx."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from docx import Document
from docx.shared import Mm, Pt

from qsmpm_verify.run_report.content import Heading, Picture, Piece, Rows

WIDTH = Mm(160)
"""Of pictures: what margins leave of a page."""


def write_document(title: str, pieces: Sequence[Piece], out: Path) -> Path:
    """The same pieces as the page."""
    document = Document()
    document.add_heading(title, level=0)
    for piece in pieces:
        if isinstance(piece, Heading):
            document.add_heading(piece.text, level=1)
        elif isinstance(piece, Rows):
            grid = document.add_table(rows=1, cols=len(piece.header), style="Light Grid Accent 1")
            for cells, values in ((grid.rows[0].cells, piece.header), *((grid.add_row().cells, row) for row in piece.rows)):
                for cell, value in zip(cells, values, strict=True):
                    cell.text = value
                    cell.paragraphs[0].runs[0].font.size = Pt(8)
        elif isinstance(piece, Picture):
            document.add_picture(str(piece.png), width=WIDTH)
            document.add_paragraph(piece.caption, style="Caption")
        elif piece.kind == "deck":
            document.add_paragraph().add_run("\n".join(piece.lines)).font.size = Pt(7)
        else:
            for line in piece.lines:
                document.add_paragraph(line, style="List Bullet" if piece.kind == "warning" else None)
    out.parent.mkdir(parents=True, exist_ok=True)
    document.save(str(out))
    return out
