"""Words of `editor` (files for an editor) and `language-server`."""

from __future__ import annotations

import argparse
from pathlib import Path

from qsmpm_verify.editor.grammar import write_extension
from qsmpm_verify.editor.table import read_table
from qsmpm_verify.places import PROGRAM


def add_words(verbs: argparse._SubParsersAction) -> None:
    """Words of both verbs."""
    files = verbs.add_parser("editor", help="colours and snippets of decks for an editor: a TextMate grammar as an extension of VS Code")
    files.add_argument("--out", type=Path, default=Path("output") / "qsmpm-deck", help="folder of the extension (default output/qsmpm-deck)")
    server = verbs.add_parser("language-server", help="completion, help and errors of decks for an editor, over standard input and output")
    for verb in (files, server):
        verb.add_argument("--program", type=Path, default=PROGRAM, help="the program that is asked")
    files.set_defaults(act=write)
    server.set_defaults(act=serve)


def write(words: argparse.Namespace) -> int:
    """Write the files."""
    for path in write_extension(read_table(words.program), words.out):
        print(path)
    return 0


def serve(words: argparse.Namespace) -> int:
    """Serve until the editor ends it."""
    from qsmpm_verify.editor.server import make_server

    make_server(read_table(words.program), words.program.resolve()).start_io()
    return 0
