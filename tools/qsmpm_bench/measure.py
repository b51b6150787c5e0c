"""Run processes and measure them: CPU seconds of the whole process, wall seconds, memory, the profile it writes."""

from __future__ import annotations

import json
import os
import shutil
import statistics
import subprocess
import threading
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from qsmpm_verify.cases import Case
from qsmpm_verify.runner import last_line, write_deck

#: Load average above which figures of time are not worth much.
QUIET = 0.5


class BenchError(Exception):
    """A measurement cannot be made."""


@dataclass(frozen=True)
class Sample:
    """One process that has ended as it should."""

    cpu: float
    wall: float
    memory: int
    figures: dict[str, Any] = field(default_factory=dict)
    """profile.json of QSMPM, or what a peer's script prints."""
    directory: Path | None = None


def process(command: list[str], log: Path, threads: int = 1, timeout: float = 3600.0) -> tuple[float, float, int]:
    """CPU seconds, wall seconds and exit code of a process; one that runs out of time is an error."""
    environment = {**os.environ, "OMP_NUM_THREADS": str(threads), "OPENBLAS_NUM_THREADS": str(threads),
                   "MKL_NUM_THREADS": "1", "LC_ALL": "C.UTF-8"}
    late = threading.Event()
    with log.open("wb") as output:
        started = time.monotonic()
        child = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT,
                                 env=environment)

        def stop() -> None:
            late.set()
            child.kill()

        guard = threading.Timer(timeout, stop)
        guard.start()
        try:
            _, status, usage = os.wait4(child.pid, 0)
        finally:
            guard.cancel()
    child.returncode = os.waitstatus_to_exitcode(status)
    if late.is_set():
        raise BenchError(f"{' '.join(command)}: stopped after {timeout:g} s")
    return usage.ru_utime + usage.ru_stime, time.monotonic() - started, child.returncode


@dataclass(frozen=True)
class Deck:
    """A deck to be timed: a file with replacements, or a text."""

    name: str
    path: Path | None = None
    replace: tuple[tuple[str, str], ...] = ()
    text: str = ""

    def write(self, folder: Path) -> Path:
        """Put the deck into an empty folder; a replacement that hits nothing is an error."""
        if self.path is None:
            copy = folder / f"{self.name}.inp"
            copy.write_text(self.text, encoding="utf-8")
            return copy
        try:
            return write_deck(Case(self.name, self.name, self.path, (), replace=self.replace), folder)
        except (OSError, ValueError) as error:
            raise BenchError(f"{self.name}: {error}") from error


def run_deck(deck: Deck, program: Path, root: Path, threads: int = 1, timeout: float = 3600.0,
             profile: bool = True, restart: Path | None = None) -> Sample:
    """Run a deck in a folder of its own; anything but exit code 0 is an error."""
    folder = root / deck.name
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "deck").mkdir(parents=True)
    path = deck.write(folder / "deck")
    command = [str(program), "run", str(path), "--out", str(folder / "results"), "--threads", str(threads), "--quiet"]
    if profile:
        command.append("--profile")
    if restart is not None:
        command += ["--restart", str(restart)]
    cpu, wall, code = process(command, folder / "terminal.txt", threads, timeout)
    if code != 0:
        raise BenchError(f"{deck.name}: exit code {code}: {last_line(folder / 'terminal.txt')}")
    figures = json.loads((folder / "results" / "profile.json").read_text()) if profile else {}
    return Sample(cpu, wall, int(figures.get("peak_memory_bytes", 0)), figures, folder / "results")


def run_script(command: list[str], log: Path, timeout: float) -> Sample:
    """Run a peer's script: its last line is a JSON object."""
    log.parent.mkdir(parents=True, exist_ok=True)
    cpu, wall, code = process(command, log, 1, timeout)
    line = last_line(log)
    if code != 0:
        raise BenchError(f"{' '.join(command)}: exit code {code}: {line}")
    try:
        figures = json.loads(line)
    except ValueError as error:
        raise BenchError(f"{' '.join(command)}: its last line is no JSON: {line[:80]}") from error
    return Sample(cpu, wall, int(figures.get("peak_memory_bytes", 0)), figures)


def interleave(jobs: Mapping[str, Callable[[], Sample]], repeat: int,
               tell: Callable[[str], None] = lambda text: None) -> dict[str, list[Sample]]:
    """All jobs in turn, `repeat` times over, so that a change of the machine meets all of them alike."""
    samples: dict[str, list[Sample]] = {name: [] for name in jobs}
    for turn in range(repeat):
        for name, job in jobs.items():
            samples[name].append(job())
            tell(f"[{turn + 1}/{repeat}] {name}: {samples[name][-1].cpu:.2f} s CPU")
    return samples


@dataclass(frozen=True)
class Spread:
    """Median of some figures, with the smallest and the largest."""

    median: float
    low: float
    high: float

    @staticmethod
    def of(values: Iterable[float]) -> Spread:
        """Of one figure or more."""
        ordered = sorted(values)
        if not ordered:
            raise BenchError("no figure to take the median of")
        return Spread(statistics.median(ordered), ordered[0], ordered[-1])

    def text(self, digits: int = 3) -> str:
        """`1.23 (1.20-1.31)`, or the figure alone when all are the same."""
        figure = significant(self.median, digits)
        if self.low == self.high:
            return figure
        return f"{figure} ({significant(self.low, digits)}-{significant(self.high, digits)})"


def significant(value: float, digits: int = 3) -> str:
    """A number with so many significant digits, without exponent between 1e-4 and 1e6."""
    if value == 0 or not 1e-4 <= abs(value) < 1e6:
        return f"{value:.{digits - 1}e}" if value else "0"
    text = f"{value:.{digits}g}"
    return f"{float(text):.0f}" if "e" in text else text


def cpu(samples: Iterable[Sample]) -> Spread:
    """CPU seconds of some runs."""
    return Spread.of(sample.cpu for sample in samples)


def memory_mib(samples: Iterable[Sample]) -> float:
    """Largest memory of some runs [MiB]."""
    return max(sample.memory for sample in samples) / 2**20


def fitted_exponent(sizes: list[float], costs: list[float]) -> float:
    """Slope of the least-squares line through log(cost) over log(size)."""
    import numpy as np

    if len(sizes) < 2:
        raise BenchError("an exponent needs two sizes")
    return float(np.polyfit(np.log(sizes), np.log(costs), 1)[0])


def processor() -> str:
    """Name of the processor."""
    for line in Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return "unknown processor"


def load_warning(load: float) -> str:
    """A sentence when others use the machine, empty when it is quiet."""
    return f"load average {load:.2f} at the start: others used the machine" if load > QUIET else ""
