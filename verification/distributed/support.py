"""What the checks of the program of many processes share: running a deck, reading what it wrote."""

from __future__ import annotations

import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass

HERE = pathlib.Path(__file__).resolve().parent
TOP = HERE.parents[1]
sys.path.insert(0, str(TOP / "tools"))
from qsmpm_verify.cpu_limit import run_limited  # noqa: E402

# mpirun refuses root and more ranks than cores unless it is told. Ranks that wait give way to those that work, also where
# there are as many cores as ranks: others use them too. They speak through memory: to look for networks at each start took longer
# than the runs.
ENVIRONMENT = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "OMPI_ALLOW_RUN_AS_ROOT": "1",
               "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OMPI_MCA_rmaps_base_oversubscribe": "1",
               "OMPI_MCA_mpi_yield_when_idle": "1", "OMPI_MCA_pml": "ob1", "OMPI_MCA_btl": "self,vader"}
CPU_SECONDS = int(os.environ.get("QSMPM_CHECK_SECONDS", "120"))
WALL_FACTOR = 5.0


def pit_on_squares() -> str:
    """The pit of input/ on the squares of its grid: triangles that go with the ground are for one process."""
    deck = (TOP / "input/excavation.inp").read_text()
    return deck.replace("*GRID\n", "*GRID, ELEMENT=QUAD4\n").replace("*HISTORY, NAME=bottom", "*METHOD, BASIS=STANDARD, INTEGRATION=CELL\n*HISTORY, NAME=bottom")


def upset_exactly() -> str:
    """Surfaces that stretch under a plate, solved far below the bound by which runs are compared."""
    return (TOP / "verification/cases/decks/contact_upset.inp").read_text().replace("TOLERANCE=1e-6", "TOLERANCE=1e-9")


def expect(condition: bool, sentence: str) -> None:
    """Fail with a sentence."""
    if not condition:
        raise AssertionError(sentence)


@dataclass(frozen=True)
class Run:
    """A run that has ended."""

    folder: pathlib.Path
    code: int | None
    said: str
    cpu: float

    @property
    def log(self) -> str:
        return (self.folder / "job.log").read_text()

    @property
    def curves(self) -> bytes:
        return (self.folder / "curves.csv").read_bytes()

    @property
    def profile(self) -> dict:
        return json.loads((self.folder / "profile.json").read_text())

    def rows(self) -> list[list[float]]:
        """The numbers of the curves."""
        lines = self.curves.decode().splitlines()
        return [[float(x) for x in line.split(",")] for line in lines[1:]]


@dataclass(frozen=True)
class Place:
    """Where the programs are, and where the checks may write."""

    build: pathlib.Path
    work: pathlib.Path

    def run(self, program: str, deck: str | pathlib.Path, name: str, ranks: int = 0, code: int | None = 0,
            seconds: float = CPU_SECONDS, restart: pathlib.Path | None = None, wall: float | None = None, **more: str) -> Run:  # fmt: skip
        """Run a deck, a file or its text, by mpirun where ranks are given; a code that is not wanted is an error."""
        folder = self.work / name
        if isinstance(deck, str):
            path = self.work / f"{name}.inp"
            path.write_text(deck)
        else:
            path = deck
        words: list[str | pathlib.Path] = ["mpirun", "-n", str(ranks)] if ranks else []
        words += [self.build / program, "run", path, "--out", folder, "--profile", "--quiet"]
        words += ["--restart", restart] if restart else []
        # Ranks that wait for one that was lost use no CPU time.
        done = run_limited(words, seconds, self.work, {**ENVIRONMENT, **more}, wall=WALL_FACTOR * seconds if wall is None else wall)
        said = done.output + done.errors
        expect(code is None or done.code == code, f"{name}: {done.how}\n{said}")
        return Run(folder, done.code, said, done.cpu)

    def stop(self, program: str, deck: str, name: str, rows: int) -> Run:
        """Run a deck until its curves have some rows, then ask it to end."""
        (self.work / f"{name}.inp").write_text(deck)
        folder = self.work / name
        process = subprocess.Popen([self.build / program, "run", self.work / f"{name}.inp", "--out", folder, "--quiet"],
                                   env=ENVIRONMENT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)  # fmt: skip
        curves = folder / "curves.csv"
        while process.poll() is None and not (curves.is_file() and curves.read_text().count("\n") > rows):
            time.sleep(0.01)
        process.send_signal(signal.SIGTERM)
        return Run(folder, process.wait(CPU_SECONDS), "", 0.0)

    def call(self, *words: str | pathlib.Path) -> str:
        """What a command says on both streams; it must end well."""
        done = run_limited(words, CPU_SECONDS, self.work, ENVIRONMENT)
        expect(done.code == 0, f"{' '.join(map(str, words))}: {done.how}\n{done.output}{done.errors}")
        return done.output + done.errors


def with_solver(deck: pathlib.Path, words: str) -> str:
    """A deck of input/ with *SOLVER and its words in place of what it has."""
    lines = [line for line in deck.read_text().splitlines() if not line.upper().startswith("*SOLVER")]
    first = next(i for i, line in enumerate(lines) if re.match(r"\*(PHASE|METHOD)", line, re.IGNORECASE))
    return "\n".join([*lines[:first], f"*SOLVER, {words}", *lines[first:]]) + "\n"


def distance(one: Run, other: Run, first: int | None = None) -> float:
    """Largest difference of loads and histories, of the first rows or of all, relative to the largest value of each; counts and
    residuals may differ."""
    a, b = one.rows()[:first], other.rows()[:first]
    expect(len(a) == len(b), f"{len(a)} rows and {len(b)}")
    names = one.curves.decode().splitlines()[0].split(",")
    worst = 0.0
    for column in [i for i, name in enumerate(names) if "[" in name or name == "load_factor"]:
        size = max(max(abs(row[column]) for row in a), 1e-300)
        worst = max([worst, *(abs(p[column] - q[column]) / size for p, q in zip(a, b, strict=True))])
    return worst


def expect_same_bytes(one: Run, other: Run) -> None:
    """Curves, results, pictures and restart file of two runs are the same bytes."""
    names = [sorted(p.relative_to(run.folder) for p in run.folder.rglob("*") if p.suffix in (".h5", ".csv", ".vtu")) for run in (one, other)]
    expect(len(names[0]) > 2 and names[0] == names[1], f"other files: {', '.join(map(str, sorted({*names[0]} ^ {*names[1]})))}")
    for name in names[0]:
        expect((one.folder / name).read_bytes() == (other.folder / name).read_bytes(), f"{name} has other bytes")


Check = Callable[[Place], None]
