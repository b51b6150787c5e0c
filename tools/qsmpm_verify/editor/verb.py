"""Arguments of `editor` (files for a text editor) and `language-server`."""

from __future__ import annotations

import argparse
from pathlib import Path

from qsmpm_verify.editor.grammar import write_extension
from qsmpm_verify.editor.table import read_table
from qsmpm_verify.places import PROGRAM


def add_words(verbs: argparse._SubParsersAction) -> None:
    """Arguments of both subcommands."""
    files = verbs.add_parser("editor", help="write syntax colouring and snippets for decks in an editor: a TextMate grammar as an extension of VS Code")
    files.add_argument("--out", type=Path, default=Path("output") / "qsmpm-deck", help="folder of the extension (default output/qsmpm-deck)")
    server = verbs.add_parser("language-server", help="run a language server for decks (completion, help, diagnostics) on standard input and output")
    for verb in (files, server):
        verb.add_argument("--program", type=Path, default=PROGRAM, help="program that checks the decks")
    files.set_defaults(act=write)
    server.set_defaults(act=serve)


def write(words: argparse.Namespace) -> int:
    """Write the files."""
    for path in write_extension(read_table(words.program), words.out):
        print(path)
    return 0


def serve(words: argparse.Namespace) -> int:
    """Serve until the editor ends the session."""
    from qsmpm_verify.editor.server import make_server

    make_server(read_table(words.program), words.program.resolve()).start_io()
    return 0
