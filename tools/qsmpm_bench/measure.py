"""Run processes and measure them: CPU seconds of the whole process, wall-clock seconds, memory, the profile."""

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
    """A measurement failed."""


@dataclass(frozen=True)
class Sample:
    """One successful process."""

    cpu: float
    wall: float
    memory: int
    figures: dict[str, Any] = field(default_factory=dict)
    """profile.json of QSMPM, or the output of a script for another program."""
    directory: Path | None = None


def process(command: list[str], log: Path, threads: int = 1, timeout: float = 3600.0) -> tuple[float, float, int]:
    """CPU seconds, wall-clock seconds and exit code of a process; exceeding the time limit is an error."""
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
    """A deck to be measured: a file with replacements, or a text."""

    name: str
    path: Path | None = None
    replace: tuple[tuple[str, str], ...] = ()
    text: str = ""

    def write(self, folder: Path) -> Path:
        """Write the deck to an empty folder; a replacement without a match is an error."""
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
    """Run a deck in its own folder; any exit code other than 0 is an error."""
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
    """Run a script for another program: its last line is a JSON object."""
    log.parent.mkdir(parents=True, exist_ok=True)
    cpu, wall, code = process(command, log, 1, timeout)
    line = last_line(log)
    if code != 0:
        raise BenchError(f"{' '.join(command)}: exit code {code}: {line}")
    try:
        figures = json.loads(line)
    except ValueError as error:
        raise BenchError(f"{' '.join(command)}: its last line is not JSON: {line[:80]}") from error
    return Sample(cpu, wall, int(figures.get("peak_memory_bytes", 0)), figures)


def interleave(jobs: Mapping[str, Callable[[], Sample]], repeat: int,
               tell: Callable[[str], None] = lambda text: None) -> dict[str, list[Sample]]:
    """All jobs alternately, `repeat` times, so that changes of the machine load affect all equally."""
    samples: dict[str, list[Sample]] = {name: [] for name in jobs}
    for turn in range(repeat):
        for name, job in jobs.items():
            samples[name].append(job())
            tell(f"[{turn + 1}/{repeat}] {name}: {samples[name][-1].cpu:.2f} s CPU")
    return samples


@dataclass(frozen=True)
class Spread:
    """Median of some values, with the minimum and the maximum."""

    median: float
    low: float
    high: float

    @staticmethod
    def of(values: Iterable[float]) -> Spread:
        """Of one value or more."""
        ordered = sorted(values)
        if not ordered:
            raise BenchError("no values for a median")
        return Spread(statistics.median(ordered), ordered[0], ordered[-1])

    def text(self, digits: int = 3) -> str:
        """`1.23 (1.20-1.31)`, or the value alone if all are the same."""
        figure = significant(self.median, digits)
        if self.low == self.high:
            return figure
        return f"{figure} ({significant(self.low, digits)}-{significant(self.high, digits)})"


def significant(value: float, digits: int = 3) -> str:
    """A number with a given number of significant digits, without exponent between 1e-4 and 1e6."""
    if value == 0 or not 1e-4 <= abs(value) < 1e6:
        return f"{value:.{digits - 1}e}" if value else "0"
    text = f"{value:.{digits}g}"
    return f"{float(text):.0f}" if "e" in text else text


def cpu(samples: Iterable[Sample]) -> Spread:
    """CPU seconds of some runs."""
    return Spread.of(sample.cpu for sample in samples)


def memory_mib(samples: Iterable[Sample]) -> float:
    """Peak memory of some runs [MiB]."""
    return max(sample.memory for sample in samples) / 2**20


def fitted_exponent(sizes: list[float], costs: list[float]) -> float:
    """Slope of the least-squares line of log(cost) over log(size)."""
    import numpy as np

    if len(sizes) < 2:
        raise BenchError("an exponent requires two sizes")
    return float(np.polyfit(np.log(sizes), np.log(costs), 1)[0])


def processor() -> str:
    """Name of the processor."""
    for line in Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return "unknown processor"


def load_warning(load: float) -> str:
    """A sentence if other processes use the machine, otherwise empty."""
    return f"load average {load:.2f} at the start: other processes used the machine" if load > QUIET else ""
