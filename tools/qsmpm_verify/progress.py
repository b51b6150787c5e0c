"""Progress of a batch of runs: a bar on a terminal, plain lines otherwise."""

from __future__ import annotations

import sys
import time
from threading import Lock
from typing import TextIO

WIDTH = 24


class Progress:
    """Counts finished runs; parallel runs may report at the same time."""

    def __init__(self, total: int, stream: TextIO | None = None) -> None:
        self.total = total
        self.done = 0
        self.reused = 0
        self.stream = stream or sys.stderr
        self.terminal = self.stream.isatty()
        self.started = time.monotonic()
        self._lock = Lock()

    def left(self) -> str:
        """Remaining time if the remaining runs take as long as those that were actually run."""
        run = self.done - self.reused
        if not run or self.done == self.total:
            return ""
        seconds = (time.monotonic() - self.started) / run * (self.total - self.done)
        return f", about {seconds / 60:.0f} min left" if seconds > 90 else f", about {seconds:.0f} s left"

    def tell(self, name: str, seconds: float, reused: bool = False) -> None:
        """Report a run that has ended or was already available."""
        with self._lock:
            self.done += 1
            self.reused += reused
            what = "already available" if reused else f"{seconds:.1f} s"
            if not self.terminal:
                print(f"[{self.done}/{self.total}] {name}: {what}", file=self.stream, flush=True)
                return
            full = WIDTH * self.done // max(1, self.total)
            bar = "#" * full + "." * (WIDTH - full)
            line = f"[{bar}] {self.done}/{self.total} {name}: {what}{self.left()}"
            end = "\n" if self.done == self.total else ""
            self.stream.write("\r\x1b[K" + line[:118] + end)
            self.stream.flush()
