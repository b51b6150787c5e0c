"""Memory of the processes that go on from a restart file: an elastic cube is run, then continued from its end, where nothing is
left to compute, so that the most a process has held is what it takes to read its part and to write it.

    .venv/bin/python verification/distributed/restart_memory.py --cells 30 --ranks 1 2 4
"""

from __future__ import annotations

import argparse
import pathlib
import resource
import subprocess
import sys
import tempfile

from one_rank import cut
from support import ENVIRONMENT, TOP, Place


def measured(command: list[str]) -> int:
    """Run a command and add the most that it has held to the file that is named first [MB]."""
    code = subprocess.run(command[1:], check=False).returncode
    with pathlib.Path(command[0]).open("a") as file:
        file.write(f"{resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * 1024 / 1e6:.0f}\n")
    return code


def held(place: Place, ranks: int, deck: pathlib.Path, folder: pathlib.Path, more: list[str]) -> str:
    """MB of each process of a run."""
    file = place.work / "held"
    file.unlink(missing_ok=True)
    program = [str(place.build / "qsmpm-mpi"), "run", str(deck), "--out", str(folder), "--quiet", *more]
    subprocess.run(["mpirun", "-n", str(ranks), sys.executable, __file__, "--measured", str(file), *program], env=ENVIRONMENT, check=True)
    return " ".join(sorted(file.read_text().split(), key=int))


def main() -> int:
    if sys.argv[1:2] == ["--measured"]:
        return measured(sys.argv[2:])
    reader = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    reader.add_argument("--cells", type=int, default=14)
    reader.add_argument("--ranks", nargs="+", type=int, default=[1, 2])
    reader.add_argument("--build", type=pathlib.Path, default=TOP / "build")
    words = reader.parse_args()
    print("| ranks | MB of each, the run | MB of each, continued |")
    print("|---|---|---|")
    with tempfile.TemporaryDirectory(prefix="qsmpm-memory-") as folder:
        place = Place(words.build.resolve(), pathlib.Path(folder))
        deck = place.work / "cube.inp"
        deck.write_text(cut(words.cells, 0.3, 2.0, 1, strength="", solver="PETSC", wide=1.0, restart="*RESTART, EVERY=1\n"))
        for ranks in words.ranks:
            out = place.work / f"of-{ranks}"
            run = held(place, ranks, deck, out, [])
            print(f"| {ranks} | {run} | {held(place, ranks, deck, out, ['--restart', str(out / 'restart.h5')])} |", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
