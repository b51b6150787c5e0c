"""Settings of a study: the program, number of runs, size, output folder."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from qsmpm_bench.decks import TOP
from qsmpm_bench.measure import BenchError, Deck, Sample, interleave, run_deck


@dataclass
class Bench:
    """Settings of one invocation."""

    program: Path
    root: Path
    repeat: int = 3
    quick: bool = False
    against: Path | None = None
    figures: Path | None = None
    peers_python: Path = field(default=TOP / ".venv-peers" / "bin" / "python")

    def tell(self, text: str) -> None:
        """Progress on the error output."""
        print(text, file=sys.stderr, flush=True)

    def times(self, decks: list[Deck], threads: int = 1, timeout: float = 3600.0) -> dict[str, list[Sample]]:
        """Run the decks alternately, each `repeat` times."""
        return interleave({deck.name: self.job(deck, threads, timeout) for deck in decks}, self.repeat, self.tell)

    def job(self, deck: Deck, threads: int = 1, timeout: float = 3600.0) -> Callable[[], Sample]:
        """Run a deck."""
        return lambda: run_deck(deck, self.program, self.root / f"threads_{threads}", threads, timeout)

    def times_against(self, decks: list[Deck]) -> dict[str, list[Sample]]:
        """The same decks with the other program, alternating with the runs of this one; names end in `against`."""
        if self.against is None:
            return self.times(decks)
        other, profile = self.against, knows(self.against, "--profile")
        jobs: dict[str, Callable[[], Sample]] = {}
        for deck in decks:
            jobs[deck.name] = self.job(deck)
            jobs[f"{deck.name} against"] = partial(run_deck, deck, other, self.root / "against", 1, profile=profile)
        return interleave(jobs, self.repeat, self.tell)

    def help(self, keyword: str) -> str:
        """Help of the program on a keyword."""
        return subprocess.run([str(self.program), "help", *keyword.split()], capture_output=True, text=True,
                              check=False).stdout

    def krylov(self) -> str | None:
        """The keyword line for the iterative solver, None if the program has none."""
        for line in self.help("SOLVER").splitlines():
            name, equals, values = line.strip().partition("=")
            if equals and "KRYLOV" in values.split(":")[0].split("|"):
                return f"*SOLVER, {name}=KRYLOV\n"
        return None


def knows(program: Path, option: str) -> bool:
    """Whether the help of a program lists an option."""
    try:
        text = subprocess.run([str(program), "help"], capture_output=True, text=True, check=False).stdout
    except OSError as error:
        raise BenchError(f"{program}: {error.strerror}") from error
    return option in text
