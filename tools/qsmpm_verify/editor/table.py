"""The keyword table as written by the program, and the parts of it that an editor shows."""

from __future__ import annotations

import json
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from qsmpm_verify.study.cards import plain
from qsmpm_verify.trouble import RunFailed, Trouble

Entry = dict[str, Any]

PLACES = {"model": "before the first phase", "material": "below a *MATERIAL", "phase": "inside a phase", "anywhere": "anywhere"}


@dataclass(frozen=True)
class Table:
    """Keywords by name, in the order of the program."""

    keywords: dict[str, Entry]

    def parameter(self, keyword: str, name: str) -> Entry | None:
        """A parameter of a keyword."""
        entry = self.keywords.get(plain(keyword))
        return next((p for p in entry["parameters"] if p["name"] == plain(name)), None) if entry else None


def read_table(program: Path) -> Table:
    """Get the table from the program."""
    if not program.is_file():
        raise Trouble(f"{program} not found: build it first (tools/test or cmake --build build)")
    done = subprocess.run([program, "help", "--json"], capture_output=True, text=True, check=False, timeout=60)
    if done.returncode:
        raise RunFailed(f"{program}: {done.stderr.strip()}")
    return Table({entry["name"]: entry for entry in json.loads(done.stdout)["keywords"]})


def value_of(item: Entry) -> str:
    """Allowed values of a parameter."""
    if item["kind"] == "word":
        return "|".join(item.get("words", []))
    kind = {"integer": "whole number", "flag": ""}.get(item["kind"], item["kind"])
    return "|".join([kind, *item.get("words", [])]) if kind else ""


def item_text(item: Entry) -> str:
    """An item in a line of Markdown."""
    value = value_of(item)
    words = [f"`{item['name']}{'=' + value if value else ''}`: {item['sentence']}"]
    words += ["required"] if item["required"] else []
    words += [f"in `{item['range']}`"] if "range" in item else []
    words += [f"only with `{item['needs']}`"] if "needs" in item else []
    words += [f"default `{item['default']}`"] if "default" in item else []
    return "; ".join(words)


def explained(entry: Entry) -> str:
    """A keyword as Markdown: purpose, position, parameters, data lines, example."""
    often = ", any number of times" if entry["many"] else ", once"
    parts = [f"**\\*{entry['name']}** ({PLACES[entry['section']]}{often})", entry["sentence"]]
    if entry["parameters"]:
        parts.append("\n".join(f"- {item_text(item)}" for item in entry["parameters"]))
    for data in entry["data"]:
        head = "Data lines" + (f" with `{data['when']}`" if "when" in data else "") + f": {data['sentence']}"
        parts.append("\n".join([head, "", *(f"- {item_text(item)}" for item in data["columns"])]))
    if "advice" in entry:
        parts.append(entry["advice"])
    return "\n\n".join([*parts, f"```\n{entry['example']}\n```"])
