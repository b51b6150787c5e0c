"""Checks of restart files that several ranks read, each of them its own part: the run goes on as if nothing had been, whoever
wrote the file and however many read it, and what cannot be of the deck is refused."""

from __future__ import annotations

import os
import pathlib
import re
import shutil
import signal
import zlib

import h5py
from many_ranks import CARRIED, SECONDS, STANDARD, end_one, plane
from phase_begins import FREED, GROUND
from shared_scenes import SAME, SLOPE
from support import TOP, Check, Place, distance, expect, pit_on_squares, upset_exactly

SEAL = len(b"qsmpm crc32 00000000\n")


def often(deck: str) -> str:
    """A deck that writes a picture and a restart file after each step."""
    deck = re.sub(r"\*(RESTART|FIELD).*\n", "", deck)
    first = deck.index("*PHASE")
    return f"{deck[:first]}*RESTART, EVERY=1\n*FIELD, EVERY=1\n{deck[first:]}"


def ends_at(place: Place, deck: str, name: str, step: int, ranks: int) -> pathlib.Path:
    """The folder of a run of one process that finds no room for the results of a step, or of ranks of which the first one waits for
    who reads its results of the next step when another is killed: the restart file is that of the step."""
    folder = place.work / name
    if ranks == 0:
        (folder / "results").mkdir(parents=True)
        full = folder / f"results/{step:06d}.h5.tmp"
        full.symlink_to("/dev/full")
        place.run("qsmpm", deck, name, code=1, wall=SECONDS)
        full.unlink(missing_ok=True)
    else:
        pipe = place.work / f"long/results/{step + 1:06d}.h5.tmp"
        pipe.parent.mkdir(parents=True)
        os.mkfifo(pipe)
        shutil.move(end_one(place, deck, ranks, step + 2, signal.SIGKILL).folder, folder)
        (folder / "results" / pipe.name).unlink()
    return folder


def goes_on(place: Place, name: str, deck: str, *steps: int) -> None:
    """Three ranks, stopped, go on to the curves and the state of a run that went through, to the byte; two and one go on from their
    file, and three from that of one process."""
    deck = often(deck)
    through = place.run("qsmpm-mpi", deck, f"{name}-through", ranks=3)
    for step in steps:
        for wrote, reads in ((3, 3), (3, 2), (3, 1), (0, 3)):
            folder = ends_at(place, deck, f"{name}-{step}-{wrote}-{reads}", step, wrote)
            rest = place.run("qsmpm-mpi", deck, folder.name, ranks=reads, restart=folder / "restart.h5")
            expect(f"continued from step {step}" in rest.log, f"{name}: it has not ended at step {step}")
            if wrote == reads:
                for file in ("curves.csv", "restart.h5"):
                    expect((through.folder / file).read_bytes() == (rest.folder / file).read_bytes(), f"{name}, step {step}: other bytes in {file}")
            apart = distance(through, rest)
            expect(apart <= SAME, f"{name}, step {step}, {wrote} to {reads} ranks: {apart:.1e} from a run that went through")


def moving(place: Place) -> None:
    """A block on its way through the boxes goes on from the files of any number of ranks."""
    goes_on(place, "block", plane("0, 1, 0, 1.5", phase=CARRIED.replace("{way}", "0.8"), steps=6), 4)


def fixity(place: Place) -> None:
    """So does one whose fixity is freed."""
    goes_on(place, "fixity", plane("0, 2, 0, 1.5", steps=2) + FREED, 4)


def ground(place: Place) -> None:
    """Ground with initial stresses and phases that branch."""
    goes_on(place, "ground", GROUND.format(method=STANDARD), 2, 4)


def slope(place: Place) -> None:
    """Strengths that are lowered."""
    goes_on(place, "slope", SLOPE.format(method=STANDARD, words="GEOMETRY=FIXED"), 3)


def pit(place: Place) -> None:
    """A pit while bodies come and go, and when none go any more."""
    deck = pit_on_squares()
    deck = deck.replace(" X, 0, 12, 24\n Y, 0, 8, 16", " X, 0, 12, 12\n Y, 0, 8, 8").replace("4.5", "5").replace("3.5", "4")
    goes_on(place, "pit", deck.replace("CONTROLS, ", "CONTROLS, TOLERANCE=1E-9, "), 5, 12)


def freed(place: Place) -> None:
    """Walls that are freed."""
    deck = (TOP / "verification/cases/decks/support_free.inp").read_text()
    goes_on(place, "freed", deck.replace("X, 0, 20, 40\nY, -10, 1, 22", "X, 0, 20, 20\nY, -10, 1, 11"), 2)


def upset(place: Place) -> None:
    """Surfaces that stretch."""
    goes_on(place, "upset", upset_exactly(), 21)


def reseal(path: pathlib.Path) -> None:
    """A file as if it had been written so."""
    data = path.read_bytes()
    data = data[: data.rindex(b"qsmpm crc32 ")] if b"qsmpm crc32 " in data[-2 * SEAL :] else data
    path.write_bytes(data + b"qsmpm crc32 %08X\n" % zlib.crc32(data))


def misfits(place: Place) -> None:
    """A cell that is none, a number that is none and points that are missing, in a file that looks whole, are refused by all ranks."""
    deck = plane("0, 2, 0, 1.5", more="*RESTART, EVERY=1\n")
    good = place.run("qsmpm", deck, "good").folder / "restart.h5"
    bad = place.work / "bad.h5"
    for name, value in (("points/cell", 10**6), ("points/cell", 0), ("points/stress", float("nan")), ("points/number", None)):
        shutil.copy(good, bad)
        with h5py.File(bad, "r+") as file:
            if value is None:
                rows = file[name][:-1]
                del file[name]
                file[name] = rows
            else:
                file[name][-1] = value
        reseal(bad)
        run = place.run("qsmpm-mpi", deck, "refused", ranks=3, code=1, restart=bad, wall=SECONDS)
        words = "has another size" if value is None else "the material points in it cannot be those of this analysis"
        expect(words in run.said and run.said.count("cannot read") == 1, f"{name} {value}: {run.said}")


CHECKS: list[Check] = []
LONG_CHECKS: list[Check] = [moving, fixity, ground, slope, pit, freed, upset, misfits]
