"""Execution of `report RUN`: content, page, document."""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from qsmpm_verify.run_report.content import content_of
from qsmpm_verify.run_report.page import write_page
from qsmpm_verify.trouble import Trouble
from qsmpm_verify.view import folder_of, job_of


def act(words: argparse.Namespace) -> int:
    """Write the page of one run, and the document if requested."""
    if not words.run.exists():
        raise Trouble(f"{words.run}: no such folder")
    folder = folder_of(words.run)
    with tempfile.TemporaryDirectory() as work:
        pieces = content_of(folder, Path(work), words.bounds)
        print(write_page(job_of(folder), pieces, words.html or folder / "report.html"))
        if words.docx:
            from qsmpm_verify.run_report.word import write_document

            print(write_document(job_of(folder), pieces, words.docx))
    return 0
