"""Runs of other programs: measured, and kept as long as their input and the program are unchanged."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import subprocess
import threading
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from qsmpm_verify.runner import last_line
from qsmpm_verify.trouble import RunFailed


@dataclass(frozen=True)
class Finished:
    """A successful process: its folder, CPU seconds of the whole process, whether it was kept."""

    folder: Path
    cpu_seconds: float
    reused: bool = False


def key_of(command: list[str], version: str, files: Mapping[str, str]) -> str:
    """Hash of all dependencies of a run: command, version of the program, texts of its files by name."""
    key = hashlib.sha256(json.dumps([command, version]).encode())
    for name, text in sorted(files.items()):
        key.update(f"\0{name}\0{text}".encode())
    return key.hexdigest()


def _kept(folder: Path, key: str, needed: list[str]) -> Finished | None:
    """The run kept in a folder if it is the requested one and its files exist."""
    try:
        content = json.loads((folder / "peer.json").read_text(encoding="utf-8"))
        if content["key"] != key or not all((folder / name).is_file() for name in needed):
            return None
        return Finished(folder, float(content["cpu_seconds"]), reused=True)
    except (OSError, ValueError, KeyError, TypeError):
        return None


def measure(command: list[str], folder: Path, seconds: float) -> tuple[int, float]:
    """Exit code and CPU seconds of a process in a folder, on one thread; its output is written to terminal.txt."""
    one = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "CCX_NPROC_STIFFNESS"), "1")
    with (folder / "terminal.txt").open("wb") as output:
        child = subprocess.Popen(
            command, cwd=folder, stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT,
            env={**os.environ, **one, "LC_ALL": "C.UTF-8"},
        )  # fmt: skip
        guard = threading.Timer(seconds, child.kill)
        guard.start()
        try:
            _, status, usage = os.wait4(child.pid, 0)
        finally:
            guard.cancel()
    child.returncode = os.waitstatus_to_exitcode(status)
    return child.returncode, usage.ru_utime + usage.ru_stime


def run_peer(
    command: list[str], version: str, files: Mapping[str, str], needed: list[str], folder: Path,
    seconds: float = 600.0, fresh: bool = False,
) -> Finished:  # fmt: skip
    """Write the files into the folder and run the command there, unless the same run is kept.

    A run that fails, is stopped or does not write a required file raises RunFailed.
    """
    key = key_of(command, version, files)
    kept = None if fresh else _kept(folder, key, needed)
    if kept is not None:
        return kept
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
    code, cpu = measure(command, folder, seconds)
    missing = [name for name in needed if not (folder / name).is_file()]
    if code != 0 or missing:
        line = last_line(folder / "terminal.txt")
        raise RunFailed(f"{folder.name}: exit code {code}{', no ' + missing[0] if missing else ''}: {line[:120]}")
    (folder / "peer.json").write_text(json.dumps({"key": key, "cpu_seconds": cpu}) + "\n", encoding="utf-8")
    return Finished(folder, cpu)
