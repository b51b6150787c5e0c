"""Data that CPU times depend on: processor, system, compiler, libraries and their versions."""

from __future__ import annotations

import os
import platform
import re
import subprocess
import time
from importlib import metadata
from pathlib import Path


def _first_line(command: list[str]) -> str:
    """First line of the output of a command; empty if it cannot be run."""
    try:
        found = subprocess.run(command, capture_output=True, text=True, timeout=10, check=False).stdout
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return found.splitlines()[0].strip() if found.strip() else ""


def _processor() -> str:
    try:
        hit = re.search(r"model name\s*:\s*(.*)", Path("/proc/cpuinfo").read_text(encoding="utf-8"))
    except OSError:
        hit = None
    return hit[1].strip() if hit else platform.processor()


def _memory() -> str:
    try:
        hit = re.search(r"MemTotal:\s*(\d+)", Path("/proc/meminfo").read_text(encoding="utf-8"))
    except OSError:
        hit = None
    return f"{int(hit[1]) / 1048576:.1f} GB" if hit else ""


def linked_libraries(program: Path) -> list[str]:
    """Numerical libraries linked with the program, with their files."""
    try:
        found = subprocess.run(["ldd", str(program)], capture_output=True, text=True, timeout=10, check=False).stdout
    except (OSError, subprocess.TimeoutExpired):
        return []
    names = re.findall(r"(\S*(?:blas|lapack|mumps|cholmod|umfpack|hdf5|metis|gfortran)\S*) => (\S+)", found)
    return [Path(path).resolve().name for _, path in names]


def _commit(top: Path) -> str:
    commit = _first_line(["git", "-C", str(top), "rev-parse", "--short", "HEAD"])
    changed = _first_line(["git", "-C", str(top), "status", "--porcelain", "--untracked-files=no"])
    return f"{commit} with changes" if commit and changed else commit


def describe(program: Path, top: Path) -> list[tuple[str, str]]:
    """Names and values for the head of a report; unknown values are omitted."""
    system = platform.freedesktop_os_release().get("PRETTY_NAME", "") if Path("/etc/os-release").exists() else ""
    packages = ", ".join(f"{name} {metadata.version(name)}" for name in ("numpy", "h5py", "matplotlib", "vtk"))
    facts = [
        ("date", time.strftime("%Y-%m-%d %H:%M %Z")),
        ("program", _first_line([str(program), "--version"])),
        ("source", _commit(top)),
        ("processor", f"{_processor()}, {os.cpu_count()} cores"),
        ("memory", _memory()),
        ("load of the machine at the end", f"{os.getloadavg()[0]:.1f}"),
        ("system", f"{system}, Linux {platform.release()}"),
        ("compiler", _first_line(["gfortran", "--version"])),
        ("libraries", ", ".join(linked_libraries(program))),
        ("Python", f"{platform.python_version()}, {packages}"),
    ]
    return [(name, value) for name, value in facts if value]
