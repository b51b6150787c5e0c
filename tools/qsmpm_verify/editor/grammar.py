"""Syntax colouring and snippets of decks as files: a TextMate grammar, snippets, and the VS Code extension that contains them."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

from qsmpm_verify.editor.table import Table


def words_of(names: list[str]) -> str:
    """Names as one regular expression, long names first, with any number of blanks."""
    return "|".join(re.escape(name).replace(r"\ ", r"\s+") for name in sorted(names, key=lambda n: (-len(n), n)))


def grammar(table: Table) -> dict[str, Any]:
    """Patterns for known keywords, unknown keywords, parameters, values of choices, numbers and comments."""
    items = [item for entry in table.keywords.values() for item in entry["parameters"]]
    parameters = sorted({item["name"] for item in items})
    choices = sorted({word for item in items for word in item.get("words", [])})
    return {
        "name": "QSMPM deck", "scopeName": "source.qsmpm", "fileTypes": ["inp"],
        "patterns": [
            {"name": "comment.line.qsmpm", "match": r"^\s*\*\*.*$"},
            {"match": rf"(?i)^\s*(\*\s*(?:{words_of(list(table.keywords))}))\s*(?=,|$)", "captures": {"1": {"name": "keyword.control.qsmpm"}}},
            {"name": "invalid.illegal.qsmpm", "match": r"^\s*\*[^,\n]*"},
            {"match": rf"(?i)(?<=,)\s*({words_of(parameters)})\s*(?==|,|$)", "captures": {"1": {"name": "variable.parameter.qsmpm"}}},
            {"match": rf"(?i)(?<==)\s*({words_of(choices)})\s*(?=,|$)", "captures": {"1": {"name": "constant.language.qsmpm"}}},
            {"name": "string.quoted.double.qsmpm", "match": r'"[^"]*"'},
            {"name": "constant.numeric.qsmpm", "match": r"(?<![\w.])[-+]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][-+]?\d+)?(?![\w.])"},
        ],
    }  # fmt: skip


def snippets(table: Table) -> dict[str, Any]:
    """The example of every keyword."""
    return {
        f"*{name}": {"prefix": f"*{name}", "description": entry["sentence"], "body": re.sub(r"([$}\\])", r"\\\1", entry["example"]).split("\n")}
        for name, entry in table.keywords.items()
    }  # fmt: skip


PACKAGE = {
    "name": "qsmpm-deck", "displayName": "QSMPM decks", "version": "1.0.0", "publisher": "qsmpm", "license": "BSD-3-Clause",
    "description": "Syntax colouring, snippets, help and diagnostics for QSMPM decks", "engines": {"vscode": "^1.82.0"},
    "categories": ["Programming Languages", "Snippets"], "main": "./extension.js", "activationEvents": ["onLanguage:qsmpm"],
    "dependencies": {"vscode-languageclient": "^9.0.0"},
    "contributes": {
        "languages": [{"id": "qsmpm", "aliases": ["QSMPM deck"], "extensions": [".inp"], "configuration": "./language-configuration.json"}],
        "grammars": [{"language": "qsmpm", "scopeName": "source.qsmpm", "path": "./syntaxes/qsmpm.tmLanguage.json"}],
        "snippets": [{"language": "qsmpm", "path": "./snippets/qsmpm.json"}],
        "configuration": {"title": "QSMPM", "properties": {"qsmpm.command": {
            "type": "string", "default": "qsmpm-verify", "description": "command whose subcommand `language-server` is started"}}},
    },
}  # fmt: skip
START = """// Starts the language server of QSMPM: `qsmpm-verify language-server`, which uses standard input and output.
const { workspace } = require('vscode');
const { LanguageClient } = require('vscode-languageclient/node');
let client;
exports.activate = () => {
  const command = workspace.getConfiguration('qsmpm').get('command');
  client = new LanguageClient('qsmpm', 'QSMPM decks', { command, args: ['language-server'] },
    { documentSelector: [{ language: 'qsmpm' }] });
  return client.start();
};
exports.deactivate = () => client && client.stop();
"""


def write_extension(table: Table, folder: Path) -> list[Path]:
    """Files of the extension."""
    files = {
        "package.json": PACKAGE,
        "language-configuration.json": {"comments": {"lineComment": "**"}, "wordPattern": "[^\\s,=*]+"},
        "syntaxes/qsmpm.tmLanguage.json": grammar(table),
        "snippets/qsmpm.json": snippets(table),
    }
    paths = []
    for name, content in files.items():
        paths.append(folder / name)
        paths[-1].parent.mkdir(parents=True, exist_ok=True)
        paths[-1].write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
    paths.append(folder / "extension.js")
    paths[-1].write_text(START, encoding="utf-8")
    return paths
