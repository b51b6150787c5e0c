"""Finished runs are kept and used again as long as nothing they depend on has changed.

What a run depends on is the text of its deck, the files the deck names behind INPUT=, FILE= and LIBRARY= (and those
that included files name), the bytes of the program and the number of threads. Their hash stands in run.json beside the
results, with how the run ended and the hashes of what it wrote. A run that was stopped, crashed or failed for a reason
outside of its deck is never used again.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import time
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

NAMED_FILE = re.compile(r"(INPUT|FILE|LIBRARY)\s*=\s*(\"[^\"]*\"|[^,\s]+)", re.IGNORECASE)
LASTING = (0, 2, 3, 4, 5, 6)
"""Exit codes that the same deck brings again; 1 may be a full disk, the others are signals."""


@dataclass(frozen=True)
class Record:
    """How a kept run ended."""

    exit_code: int
    wall_seconds: float
    message: str


@lru_cache(maxsize=8)
def _hash_of(path: Path, size: int, changed: int) -> str:
    """Hash of a file's bytes; size and time of the last change of any kind keep it from being read again."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def program_hash(program: Path) -> str:
    """Hash of the program's bytes."""
    status = program.stat()
    return _hash_of(program, status.st_size, status.st_ctime_ns)


def named_files(text: str, folder: Path) -> list[Path]:
    """Files a deck names, and those the included ones name, that are there; each once.

    A library that does not lie beside the deck is sought from the working directory, as the program does.
    """
    found: list[Path] = []
    waiting = [(text, folder)]
    while waiting:
        inside, beside = waiting.pop()
        for hit in NAMED_FILE.finditer(inside):
            library = hit[1].upper() == "LIBRARY"
            path = beside / hit[2].strip('"')
            if library and not path.is_file():
                path = Path(hit[2].strip('"'))
            if path in found or not path.is_file():
                continue
            found.append(path)
            if not library and path.suffix.lower() not in (".msh", ".stl", ".h5"):
                waiting.append((path.read_text(encoding="utf-8", errors="replace"), path.parent))
    return sorted(found)


def run_key(text: str, folder: Path, program: Path, threads: int) -> str:
    """Hash of everything a run depends on; `text` is the deck, `folder` where the files it names lie."""
    key = hashlib.sha256()
    key.update(f"{program_hash(program)} {threads}\n".encode())
    key.update(text.encode())
    for path in named_files(text, folder):
        key.update(f"\0{path.name}\0".encode() + path.read_bytes())
    return key.hexdigest()


def _hashes(results: Path) -> dict[str, str]:
    """Hashes of the files of a run that figures are taken from."""
    names = ("curves.csv", "job.log", "timing.json", "profile.json", "results.h5")
    files = [results / name for name in names] + sorted((results / "results").glob("*.h5"))
    return {str(path.relative_to(results)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files if path.is_file()}


def keep(path: Path, content: dict[str, Any]) -> None:
    """Write a record in one go: an interruption leaves the old one or none."""
    part = path.with_name(path.name + ".part")
    part.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    part.replace(path)


def kept(path: Path, key: str) -> dict[str, Any] | None:
    """A record when it is there, whole and of this key."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        return content if content["key"] == key else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def remember(directory: Path, key: str, record: Record) -> None:
    """Write run.json when the run may be used again."""
    if record.exit_code not in LASTING:
        return
    content: dict[str, Any] = {
        "key": key, "exit_code": record.exit_code, "wall_seconds": round(record.wall_seconds, 3),
        "message": record.message, "hashes": _hashes(directory / "results"),
        "finished": time.strftime("%Y-%m-%d %H:%M:%S"), "load_average": round(os.getloadavg()[0], 2),
    }  # fmt: skip
    keep(directory / "run.json", content)


def recall(directory: Path, key: str) -> Record | None:
    """The run kept in a folder when it is the one asked for and its files are as it left them."""
    try:
        content = json.loads((directory / "run.json").read_text(encoding="utf-8"))
        if content["key"] != key or content["hashes"] != _hashes(directory / "results"):
            return None
        return Record(int(content["exit_code"]), float(content["wall_seconds"]), str(content["message"]))
    except (OSError, ValueError, KeyError, TypeError):
        return None
