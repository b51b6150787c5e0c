"""The language server: completion, help at the cursor, and the errors and warnings of `qsmpm check` at their lines."""

from __future__ import annotations

import asyncio
import re
import tempfile
from pathlib import Path
from urllib.parse import unquote, urlparse

from lsprotocol import types
from pygls.lsp.server import LanguageServer

from qsmpm_verify.editor.deck_text import offers, place_at
from qsmpm_verify.editor.table import Table, explained, item_text

PAUSE = 0.3
"""Seconds without a change after which a deck is checked."""
LONGEST = 60.0
"""Time limit of a check in seconds."""
MESSAGE = re.compile(r"^(?P<file>.+?):(?:(?P<line>\d+):)? (?P<text>.+)$")


def make_server(table: Table, program: Path) -> LanguageServer:
    """A server with the keyword table and access to the program."""
    server = LanguageServer("qsmpm", "1")
    latest: dict[str, int] = {}

    @server.feature(types.TEXT_DOCUMENT_COMPLETION, types.CompletionOptions(trigger_characters=["*", ",", "=", " "]))
    def complete(request: types.CompletionParams) -> list[types.CompletionItem]:
        lines = lines_of(server, request.text_document.uri)
        at = request.position
        found = offers(table, lines, at.line, at.character)
        return [item_of(name, entry) for name, entry in found]

    @server.feature(types.TEXT_DOCUMENT_HOVER)
    def hover(request: types.HoverParams) -> types.Hover | None:
        lines = lines_of(server, request.text_document.uri)
        text = help_at(table, lines, request.position.line, request.position.character)
        return types.Hover(types.MarkupContent(types.MarkupKind.Markdown, text)) if text else None

    async def check(uri: str) -> None:
        latest[uri] = latest.get(uri, 0) + 1
        mine = latest[uri]
        await asyncio.sleep(PAUSE)
        if latest[uri] != mine:
            return
        document = server.workspace.get_text_document(uri)
        found = await diagnose(program, path_of(uri), document.source)
        if latest[uri] == mine:
            server.text_document_publish_diagnostics(types.PublishDiagnosticsParams(uri, found, document.version))

    @server.feature(types.TEXT_DOCUMENT_DID_OPEN)
    async def opened(request: types.DidOpenTextDocumentParams) -> None:
        await check(request.text_document.uri)

    @server.feature(types.TEXT_DOCUMENT_DID_CHANGE)
    async def changed(request: types.DidChangeTextDocumentParams) -> None:
        await check(request.text_document.uri)

    @server.feature(types.TEXT_DOCUMENT_DID_SAVE)
    async def saved(request: types.DidSaveTextDocumentParams) -> None:
        await check(request.text_document.uri)

    return server


def lines_of(server: LanguageServer, uri: str) -> list[str]:
    """Lines of a document, at least one."""
    return server.workspace.get_text_document(uri).source.split("\n")


def path_of(uri: str) -> Path:
    """The file of a document."""
    return Path(unquote(urlparse(uri).path))


def item_of(name: str, entry: dict | None) -> types.CompletionItem:
    """A keyword, a parameter, or a word."""
    if entry is None:
        return types.CompletionItem(name, kind=types.CompletionItemKind.EnumMember)
    is_keyword = "parameters" in entry
    text = explained(entry) if is_keyword else item_text(entry)
    insert = name if is_keyword or entry["kind"] == "flag" else f"{name}="
    kind = types.CompletionItemKind.Keyword if is_keyword else types.CompletionItemKind.Property
    return types.CompletionItem(name, kind=kind, detail=entry["sentence"], insert_text=insert,
                                documentation=types.MarkupContent(types.MarkupKind.Markdown, text))


def help_at(table: Table, lines: list[str], line: int, column: int) -> str:
    """Help on the parameter at the cursor, or on the keyword of its line or data line."""
    if line >= len(lines) or lines[line].lstrip().startswith("**"):
        return ""
    comma = lines[line].find(",", column)
    end = comma if comma >= 0 else len(lines[line])
    place = place_at(lines, line, end)
    entry = table.keywords.get(place.keyword or place.typed.upper())
    if entry is None:
        entry = table.keywords.get(" ".join(lines[line][:end].strip().lstrip("*").upper().split()))
    item = table.parameter(place.keyword, place.parameter or place.typed) if place.keyword and place.on_card else None
    return item_text(item) if item else explained(entry) if entry else ""


async def diagnose(program: Path, path: Path, source: str) -> list[types.Diagnostic]:
    """Messages of the program on the deck as edited, written beside its file so that the files it refers to are found."""
    folder = path.parent if path.parent.is_dir() else Path(tempfile.gettempdir())
    try:
        copy = tempfile.NamedTemporaryFile("w", dir=folder, prefix=".qsmpm-", suffix=".inp", encoding="utf-8")  # noqa: SIM115
    except OSError:
        copy = tempfile.NamedTemporaryFile("w", prefix=".qsmpm-", suffix=".inp", encoding="utf-8")  # noqa: SIM115
    with copy:
        copy.write(source)
        copy.flush()
        process = await asyncio.create_subprocess_exec(program, "check", copy.name, stdout=asyncio.subprocess.DEVNULL,
                                                       stderr=asyncio.subprocess.PIPE)
        try:
            _, told_errors = await asyncio.wait_for(process.communicate(), LONGEST)
        except TimeoutError:
            process.kill()
            return []
        return diagnostics_of(told_errors.decode(errors="replace"), copy.name, source.split("\n"))


def diagnostics_of(report: str, name: str, lines: list[str]) -> list[types.Diagnostic]:
    """Messages of the program as diagnostics at their lines; messages on other files or without a line are shown at the first line."""
    found = []
    for row in report.splitlines():
        hit = MESSAGE.match(row)
        own = hit is not None and hit["file"] == name
        text = hit["text"] if hit and own else row
        if not text.strip() or re.fullmatch(r"\d+ errors? in the deck", text):
            continue
        line = min(int(hit["line"]) - 1, len(lines) - 1) if hit and own and hit["line"] else 0
        mild = text.startswith("warning:") or " warning: " in text
        severity = types.DiagnosticSeverity.Warning if mild or not own else types.DiagnosticSeverity.Error
        reach = types.Range(types.Position(line, 0), types.Position(line, max(1, len(lines[line]))))
        found.append(types.Diagnostic(reach, text.removeprefix("warning: "), severity=severity, source="qsmpm"))
    return found
