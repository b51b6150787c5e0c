"""Finished runs are kept and reused as long as their dependencies have not changed.

A run depends on the text of its deck, the files named after INPUT=, FILE= and LIBRARY= (and those
named by included files), the bytes of the program and the number of threads. Their hash is in run.json beside the
results, with the end of the run and the hashes of its output. A run that was stopped, crashed or failed for a reason
outside its deck is never reused.
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
"""Exit codes that are reproducible for the same deck; 1 may be a full disk, the others are signals."""


@dataclass(frozen=True)
class Record:
    """End of a kept run."""

    exit_code: int
    wall_seconds: float
    message: str


@lru_cache(maxsize=8)
def _hash_of(path: Path, size: int, changed: int) -> str:
    """Hash of the bytes of a file; it is read again only if its size or the time of its last change differ."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def program_hash(program: Path) -> str:
    """Hash of the bytes of the program."""
    status = program.stat()
    return _hash_of(program, status.st_size, status.st_ctime_ns)


def named_files(text: str, folder: Path) -> list[Path]:
    """Existing files named by a deck and by the files it includes, each once.

    A library that is not beside the deck is searched from the working directory, as in the program.
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
    """Hash of all dependencies of a run; `text` is the deck, `folder` the folder of the files it names."""
    key = hashlib.sha256()
    key.update(f"{program_hash(program)} {threads}\n".encode())
    key.update(text.encode())
    for path in named_files(text, folder):
        key.update(f"\0{path.name}\0".encode() + path.read_bytes())
    return key.hexdigest()


def _hashes(results: Path) -> dict[str, str]:
    """Hashes of the files of a run from which results are taken."""
    names = ("curves.csv", "job.log", "timing.json", "profile.json", "results.h5")
    files = [results / name for name in names] + sorted((results / "results").glob("*.h5"))
    return {str(path.relative_to(results)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files if path.is_file()}


def keep(path: Path, content: dict[str, Any]) -> None:
    """Write a record atomically: after an interruption the old one exists, or none."""
    part = path.with_name(path.name + ".part")
    part.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    part.replace(path)


def kept(path: Path, key: str) -> dict[str, Any] | None:
    """A record if it exists, is complete and has this key."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        return content if content["key"] == key else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def remember(directory: Path, key: str, record: Record) -> None:
    """Write run.json if the run may be reused."""
    if record.exit_code not in LASTING:
        return
    content: dict[str, Any] = {
        "key": key, "exit_code": record.exit_code, "wall_seconds": round(record.wall_seconds, 3),
        "message": record.message, "hashes": _hashes(directory / "results"),
        "finished": time.strftime("%Y-%m-%d %H:%M:%S"), "load_average": round(os.getloadavg()[0], 2),
    }  # fmt: skip
    keep(directory / "run.json", content)


def recall(directory: Path, key: str) -> Record | None:
    """The run kept in a folder if it is the requested one and its files are unchanged."""
    try:
        content = json.loads((directory / "run.json").read_text(encoding="utf-8"))
        if content["key"] != key or content["hashes"] != _hashes(directory / "results"):
            return None
        return Record(int(content["exit_code"]), float(content["wall_seconds"]), str(content["message"]))
    except (OSError, ValueError, KeyError, TypeError):
        return None
