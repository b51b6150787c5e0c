"""Checks of what goes wrong on one rank: laws, numbers, a process that is killed, a disk that is full. All ranks end, in
time, with one exit code, and what was written is good."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess

from many_ranks import CARRIED, SECONDS, end_one, plane
from support import Check, Place, Run, expect, expect_same_bytes

FAULTS = {4: "not a finite number", 5: "asks for a shorter step", 6: "ends the program", 3: "SIGSEGV", 12: "ends the program"}
"""Ways of verification/plugins/faulty_umat.f to go wrong, and words of what is said of them."""


def faulty(place: Place, kind: int) -> str:
    """A body of 12 by 6 cells whose law goes wrong in its third step in its last column, which one of two ranks has no copy of."""
    library = place.build / "verification" / "plugins" / "libfaulty.so"
    law = f"*USER MATERIAL, INTERFACE=UMAT, LIBRARY={library}\n 200, 0.3, {kind}, 3, 0.5, 0, 2.8\n"
    return plane("0, 3, 0, 1.5").replace("*ELASTIC\n200, 0.3\n", law)


def laws(place: Place) -> None:
    """A law that goes wrong on one rank (NaN, shorter steps, XIT, a bad address, _exit) ends all in ten seconds, as on one process."""
    for kind, words in FAULTS.items():
        deck = faulty(place, kind)
        alone = place.run("qsmpm", deck, f"{kind}-alone", code=None)
        shared = place.run("qsmpm-mpi", deck, f"{kind}-shared", ranks=2, code=alone.code, wall=SECONDS)
        expect(alone.code in (3, 6), f"{kind}: exit code {alone.code}")
        last = [run.log.splitlines()[-1] for run in (alone, shared)]
        expect(words in last[1] and last[0].split(":")[:5] == last[1].split(":")[:5], "\n".join(last))
        expect(len(shared.rows()) == 2 and (shared.folder / "restart.h5").is_file(), f"{kind}: the steps before are not whole")


def let_go() -> str:
    """A block that rests beside a wall, is freed from it while its force fades, and is carried away."""
    deck = plane("0, 1, 0, 1.5", phase="*FIX\nbase, Y\nleft, X\n*GRAVITY\n0, -1", steps=6, more="*RESTART, EVERY=1\n")
    for name, words, steps in (("freed", "*FIX\nbase, X\nleft, FREE", 8), ("carried", "*PRESCRIBE\nbase, X, 0.8", 26)):
        deck += f"*PHASE, NAME={name}\n{words}\n*CONTROLS, STEPS={steps}, TOLERANCE=1E-8\n*END PHASE\n"
    return deck


def killed(place: Place) -> None:
    """One of two ranks is killed: all end in ten seconds, not with 0, and the run goes on from its file to the same bytes."""
    deck = plane("0, 1, 0, 1.5", phase=CARRIED.replace("{way}", "1.2"), steps=60, more="*RESTART, EVERY=5\n")
    whole = place.run("qsmpm-mpi", deck, "whole", ranks=2)
    run = end_one(place, deck, 2, 12, signal.SIGKILL)
    expect(run.code != 0 and not run.log.rstrip().endswith("finished"), f"exit code {run.code}")
    expect(len(run.rows()) < 60, "it had ended before")
    rest = place.run("qsmpm-mpi", deck, "long", ranks=2, restart=run.folder / "restart.h5")
    expect_same_bytes(whole, rest)


def killed_in_writing(place: Place) -> None:
    """Each of three ranks is killed at many moments after one has begun to write a restart file: the last one is good, and the run
    goes on from it to the same bytes."""
    deck = let_go()
    whole = place.run("qsmpm-mpi", deck, "whole", ranks=3)
    unfinished = 0
    for moment in range(12):
        at = Place(place.build, place.work / f"{moment}")
        at.work.mkdir()
        run = end_one(at, deck, 3, 3 + moment, signal.SIGKILL, victim=moment % 3, after=0.0005 * moment, begun="restart.h5.tmp")
        expect(run.code != 0 and len(run.rows()) < 40, f"moment {moment}: it had ended before")
        unfinished += (run.folder / "restart.h5.tmp").exists()
        expect_same_bytes(whole, at.run("qsmpm-mpi", deck, "long", ranks=3, restart=run.folder / "restart.h5"))
    expect(unfinished > 2, f"only {unfinished} of the moments fall into the writing of a file")


def full_disk(place: Place) -> None:
    """A disk that is full, where the first rank writes, ends all in ten seconds with exit code 1, and the last state is good."""
    disk = place.work / "disk"
    disk.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=480k", "tmpfs", str(disk)]
    if os.geteuid() != 0 or subprocess.run(mount, capture_output=True, check=False).returncode != 0:
        print("left out: a full disk (needs root to mount a small tmpfs)")
        return
    try:
        deck = plane("0, 1, 0, 1.5", phase=CARRIED.replace("{way}", "1.2"), steps=24, more="*FIELD, EVERY=1\n*RESTART, EVERY=1\n")
        full = place.run("qsmpm-mpi", deck, "disk/out", ranks=3, code=1, wall=SECONDS)
        expect("No space left" in full.said and "without calling" not in full.said, full.said)
        expect(0 < len(full.rows()) < 24, f"{len(full.rows())} steps")
        shutil.copy(full.folder / "restart.h5", place.work / "last.h5")
    finally:
        subprocess.run(["umount", str(disk)], check=False)
    place.run("qsmpm", deck, "room", restart=place.work / "last.h5")


CHECKS: list[Check] = [laws, killed, full_disk]
LONG_CHECKS: list[Check] = [killed_in_writing]
