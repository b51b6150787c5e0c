#!/usr/bin/env python3
"""Does the program keep its promises when things go wrong?

Usage: resilience.py BINARY

Runs small decks that must fail in a known way, and interrupted runs that must continue to the same bytes:
a step that cannot converge, a point pushed out of the mesh, singular equations, a full disk (a small tmpfs, root only),
SIGTERM in the middle, restart. Prints a line a check and closes with `N passed, N failed`.
"""
from __future__ import annotations

import filecmp
import json
import os
import pathlib
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import zlib

import h5py

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "tools"))
from qsmpm_verify.cpu_limit import run_limited  # noqa: E402

CPU_SECONDS = 120
# By the clock, on a loaded machine, until an interrupted run has some rows and until it has ended.
PATIENCE = 1200
SEAL = len(b"qsmpm crc32 00000000\n")

BLOCK = """*HEADING
Small block.
*UNITS, LENGTH=m, FORCE=kN
*MODEL, TYPE=PLANE STRAIN
*GRID, ELEMENT=QUAD4
X, 0, {width}, {columns}
Y, 0, 1, 4
*NSET, NSET=base, PLANE=Y
0
*NSET, NSET=side, PLANE=X
0
*MATERIAL, NAME=soil
*ELASTIC
100, 0.3
{strength}*UNIT WEIGHT
1
*BODY, NAME=block, MATERIAL=soil, SHAPE=BOX
0, 1, 0, 1
*METHOD, {method}
*HISTORY, NAME=top, QUANTITY=POSITION, COMPONENT=Y
0.5, 1
*RESTART, EVERY=1
*PHASE, NAME=load, LOAD FACTOR={factor}
{fixities}{loads}*CONTROLS, STEPS={steps}, {controls}
*END PHASE
"""


def block(**changes: object) -> str:
    values: dict[str, object] = dict(
        width=2, columns=8, strength="", method="STABILISATION=GHOST", factor=1, steps=10,
        fixities="*FIX\nbase, ALL\n", loads="*GRAVITY\n0, -1\n", controls="TOLERANCE=1E-6")
    values.update(changes)
    return BLOCK.format(**values)


class Checks:
    def __init__(self, binary: str) -> None:
        self.binary, self.passed, self.failed = binary, 0, 0

    def check(self, name: str, held: bool, detail: str = "") -> None:
        self.passed, self.failed = self.passed + held, self.failed + (not held)
        print(("ok    " if held else "FAILED ") + name + ("" if held else f": {detail}"), flush=True)

    def run(self, folder: pathlib.Path, deck: str, *more: str, out: pathlib.Path | None = None) -> subprocess.CompletedProcess[str]:
        path = folder / "case.inp"
        path.write_text(deck)
        words = [self.binary, "run", str(path), "--out", str(out or folder / "out"), *more]
        ended = run_limited(words, CPU_SECONDS)
        return subprocess.CompletedProcess(words, -9 if ended.code is None else ended.code, ended.output,
                                           ended.errors + ended.reason)


def last_restart_continues(checks: Checks, folder: pathlib.Path, deck: str, code: int, name: str) -> None:
    """The last good state is on disk and can be read: continuing ends in the same way."""
    again = checks.run(folder, deck, "--restart", str(folder / "out" / "restart.h5"), out=folder / "again")
    checks.check(f"{name}: the last good state can be read", again.returncode == code, f"exit {again.returncode}: {again.stderr[-300:]}")


def not_converging(checks: Checks, folder: pathlib.Path) -> None:
    deck = block(strength="*MOHR COULOMB\n0.1, 20, 0\n", factor=200, steps=20,
                 controls="TOLERANCE=1E-6, DAMPING=NO, SMALLEST STEP=0.5, MAX ITERATIONS=4")
    run = checks.run(folder, deck)
    text = run.stdout + run.stderr
    checks.check("a step that does not converge ends with exit 3", run.returncode == 3, f"exit {run.returncode}: {text[-300:]}")
    checks.check("the message tells load, residual and worst place",
                 "load factor" in text and "out of balance" in text and "node" in text, text[-300:])
    last_restart_continues(checks, folder, deck, 3, "not converging")


def collapse(checks: Checks, folder: pathlib.Path) -> None:
    """A bank that cannot stand and flows out of the mesh: whatever was accepted was in equilibrium."""
    deck = block(strength="*MOHR COULOMB\n2, 30, 0\n", steps=10, method="INTEGRATION=CELL", controls="TOLERANCE=1E-4")
    for old, new in (("ELEMENT=QUAD4", "ELEMENT=TRI6"), ("100, 0.3", "1000, 0.3"), ("*UNIT WEIGHT\n1\n", "*UNIT WEIGHT\n18\n"),
                     ("0, 1, 0, 1\n*METHOD", "0, 1, 0, 0.8\n*METHOD"), ("0.5, 1\n", "0.5, 0.8\n")):
        deck = deck.replace(old, new)
    run = checks.run(folder, deck)
    checks.check("a bank that cannot stand does not end with exit 0", run.returncode in (3, 4), f"exit {run.returncode}")
    rows = [line.split(",") for line in (folder / "out" / "curves.csv").read_text().splitlines()]
    names = [cell.split("[")[0].strip() for cell in rows[0]]
    for name, bound in (("out_of_balance", 1e-4), ("stabilisation_share", 5e-3)):
        worst = max(float(row[names.index(name)]) for row in rows[1:])
        checks.check(f"no accepted step has a {name} above {bound:g}", worst <= bound, f"{worst:g}")


def point_lost(checks: Checks, folder: pathlib.Path) -> None:
    deck = block(width=1, columns=4, factor=1, steps=4, loads="*PRESCRIBE\ntop, Y, 0.8\n",
                 controls="TOLERANCE=1E-6, MAX DISPLACEMENT=10, DAMPING=NO, SMALLEST STEP=0.5").replace(
        "*MATERIAL", "*NSET, NSET=top, PLANE=Y\n1\n*MATERIAL", 1)
    run = checks.run(folder, deck)
    text = run.stdout + run.stderr
    checks.check("a point that leaves the mesh ends with exit 4", run.returncode == 4, f"exit {run.returncode}: {text[-300:]}")
    checks.check("the message names the point", "point" in text and "left the mesh" in text, text[-300:])


def singular(checks: Checks, folder: pathlib.Path) -> None:
    deck = block(fixities="*FIX\nside, X\n", controls="TOLERANCE=1E-6, DAMPING=NO, SMALLEST STEP=0.5")
    run = checks.run(folder, deck)
    checks.check("equations without support end with exit 5", run.returncode == 5,
                 f"exit {run.returncode}: {(run.stdout + run.stderr)[-300:]}")


def same_results(one: pathlib.Path, two: pathlib.Path) -> tuple[bool, str]:
    """Everything a run writes but job.log and timing.json must be the same bytes."""
    def names(folder: pathlib.Path) -> list[str]:
        return sorted(str(p.relative_to(folder)) for pattern in ("*.csv", "*.vtu", "*.pvd", "*.h5", "results/*.h5") for p in folder.glob(pattern))

    pictures = names(one)
    if not {"curves.csv", "restart.h5", "results.h5"} <= set(pictures) or pictures != names(two):
        return False, f"the lists of files differ: {set(pictures) ^ set(names(two))}"
    for name in pictures:
        if not filecmp.cmp(one / name, two / name, shallow=False):
            return False, f"{name} differ"
    return True, ""


def wait_for_rows(process: subprocess.Popen[bytes], out: pathlib.Path, rows: int) -> None:
    """Wait until the curves of a run have some rows, or it has ended."""
    deadline = time.time() + PATIENCE
    while time.time() < deadline and process.poll() is None:
        if (out / "curves.csv").exists() and len((out / "curves.csv").read_text().splitlines()) > rows:
            break
        time.sleep(0.005)


def interrupt(checks: Checks, folder: pathlib.Path, out: pathlib.Path, rows: int, by: signal.Signals = signal.SIGTERM) -> int:
    """Run the deck of a folder until its curves have some rows, end it by a signal and tell the exit code."""
    process = subprocess.Popen([checks.binary, "run", str(folder / "case.inp"), "--out", str(out)],
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    wait_for_rows(process, out, rows)
    process.send_signal(by)
    return process.wait(PATIENCE)


def interrupted(checks: Checks, folder: pathlib.Path) -> None:
    deck = block(factor=20, steps=200, method="STABILISATION=GHOST")
    whole = checks.run(folder, deck, out=folder / "whole")
    checks.check("the uninterrupted run ends well", whole.returncode == 0, whole.stderr[-300:])
    twice = checks.run(folder, deck, out=folder / "twice")
    same, why = same_results(folder / "whole", folder / "twice")
    checks.check("the same deck gives the same bytes", twice.returncode == 0 and same, why)
    threads = checks.run(folder, deck, "--threads", "2", out=folder / "threads")
    same, why = same_results(folder / "whole", folder / "threads")
    checks.check("two threads give the bytes of one", threads.returncode == 0 and same, why)
    part = folder / "part"
    code = interrupt(checks, folder, part, 60)
    checks.check("SIGTERM ends with exit 143", code == 143, f"exit {code}")
    log = next(part.glob("*.log")).read_text().strip().splitlines()
    checks.check("an interrupted run does not say finished", log[-1] != "qsmpm: finished", log[-1])
    rest = checks.run(folder, deck, "--restart", str(part / "restart.h5"), out=part)
    same, why = same_results(folder / "whole", part)
    checks.check("the restarted run ends well", rest.returncode == 0, rest.stderr[-300:])
    checks.check("and its results are the bytes of the uninterrupted one", same, why)


RELEASED = """*PHASE, NAME=let go
*FIX
side, FREE
*SUPPORT, SURFACE=face, TYPE=FREE
*CONTROLS, STEPS=120, TOLERANCE=1E-6
*END PHASE
"""


def released(checks: Checks, folder: pathlib.Path) -> None:
    """A run that is interrupted while the forces of freed nodes and supports fall goes on to the same bytes."""
    deck = block(fixities="*FIX\nbase, ALL\nside, X\n*SUPPORT, SURFACE=face\n", steps=2) + RELEASED
    deck = deck.replace("*HISTORY", "*SURFACE, NAME=face, TYPE=SEGMENT\n1, 0, 1, 1\n*HISTORY", 1)
    whole = checks.run(folder, deck, out=folder / "whole")
    checks.check("supports and nodes are let go", whole.returncode == 0, whole.stderr[-300:])
    part = folder / "part"
    code = interrupt(checks, folder, part, 30)
    rows = len((part / "curves.csv").read_text().splitlines())
    checks.check("SIGTERM while they are let go", code == 143 and rows < 120, f"exit {code}, {rows} rows")
    rest = checks.run(folder, deck, "--restart", str(part / "restart.h5"), out=part)
    same, why = same_results(folder / "whole", part)
    checks.check("continued, the bytes of the uninterrupted run", rest.returncode == 0 and same, why)


DUG = """*PHASE, NAME=dig
*DEACTIVATE
pit
*CONTROLS, STEPS=60, TOLERANCE=1E-8
*END PHASE
*PHASE, NAME=fill
*ACTIVATE
pit
lift
*CHANGE MATERIAL
block, stiff
*CONTROLS, STEPS=5, TOLERANCE=1E-8
*END PHASE
"""


def dug(checks: Checks, folder: pathlib.Path) -> None:
    """A run that is killed inside an excavation goes on to the same bytes, through the phases behind it too."""
    deck = block(width=1, columns=4, steps=2, method="BASIS=SPLINE2G, INTEGRATION=CELL", controls="TOLERANCE=1E-8") + DUG
    for old, new in (("0, 1, 0, 1\n*METHOD", "0, 1, 0, 0.6\n*BODY, NAME=pit, MATERIAL=soil, SHAPE=POLYGON\n0, 0.6\n0.6, 0.6\n"
                      "0.7, 0.9\n0, 0.9\n*BODY, NAME=lift, MATERIAL=soil, SHAPE=BOX, ACTIVE=NO\n0.8, 1, 0.6, 0.8\n*METHOD"),
                     ("*BODY", "*MATERIAL, NAME=stiff\n*ELASTIC\n200, 0.3\n*UNIT WEIGHT\n1.2\n*BODY"), ("0.5, 1\n", "0.3, 0.6\n"),
                     ("*RESTART", "*FIELD, EVERY=20\n*RESTART")):
        deck = deck.replace(old, new, 1)
    whole = checks.run(folder, deck, out=folder / "whole")
    checks.check("a pit is dug and filled", whole.returncode == 0, whole.stderr[-300:])
    part = folder / "part"
    code = interrupt(checks, folder, part, 15, signal.SIGKILL)
    with h5py.File(part / "restart.h5") as file:
        phase, share = int(file["progress"].attrs["phase"]), float(file["progress"].attrs["fraction"])
    checks.check("killed inside the excavation", code == -9 and phase == 2 and 0 < share < 1, f"exit {code}, {share} of phase {phase}")
    rest = checks.run(folder, deck, "--restart", str(part / "restart.h5"), out=part)
    same, why = same_results(folder / "whole", part)
    checks.check("continued, the bytes of the run that was not killed", rest.returncode == 0 and same, f"exit {rest.returncode}: {why}")


def kept_factors(checks: Checks, folder: pathlib.Path) -> None:
    """Factors that are kept for later matrices end with their increment: a continued run has none and gives the same bytes."""
    deck = block(columns=6, steps=12, factor=30, strength="*MOHR COULOMB\n20, 20, 0\n", method="BASIS=SPLINE2G, INTEGRATION=CELL")
    deck = deck.replace("*MODEL", "*SOLVER, TYPE=UMFPACK, KEEP FACTOR=YES\n*MODEL", 1)
    whole = checks.run(folder, deck, out=folder / "whole")
    checks.check("a block runs with kept factors", whole.returncode == 0, whole.stderr[-300:])
    code = interrupt(checks, folder, folder / "part", 6, signal.SIGKILL)
    rest = checks.run(folder, deck, "--restart", str(folder / "part" / "restart.h5"), out=folder / "part")
    same, why = same_results(folder / "whole", folder / "part")
    checks.check("killed and continued, the same bytes", code == -9 and rest.returncode == 0 and same, f"exit {code}, {rest.returncode}: {why}")


PRESSED = """*SURFACE, NAME=head, TYPE=SEGMENT
1, 1, 0, 1
*RIGID BODY, NAME=plate, SHAPE=PLANE
0, 1, 0, -1
*CONTACT, BODY=plate, SURFACE=head, FRICTION ANGLE=10
*HISTORY, NAME=push, QUANTITY=CONTACT FORCE, COMPONENT=X, BODY=plate
*HISTORY"""


def pressed(checks: Checks, folder: pathlib.Path) -> None:
    """A rigid plate that presses and slips: pressure, shear and place of the plate are kept; two threads and a continued run give the same
    bytes."""
    deck = block(loads="*MOVE, BODY=plate\n0.1, -0.05\n", method="BASIS=GIMP, INTEGRATION=CELL", steps=40).replace("*HISTORY", PRESSED, 1)
    whole = checks.run(folder, deck, out=folder / "whole")
    checks.check("a block under a plate runs", whole.returncode == 0, whole.stderr[-300:])
    threads = checks.run(folder, deck, "--threads", "2", out=folder / "threads")
    same, why = same_results(folder / "whole", folder / "threads")
    checks.check("on two threads, the same bytes", threads.returncode == 0 and same, why)
    code = interrupt(checks, folder, folder / "part", 6, signal.SIGKILL)
    rest = checks.run(folder, deck, "--restart", str(folder / "part" / "restart.h5"), out=folder / "part")
    same, why = same_results(folder / "whole", folder / "part")
    checks.check("killed amid contact and continued, the same bytes", code == -9 and rest.returncode == 0 and same,
                 f"exit {code}, {rest.returncode}: {why}")


def stretched(checks: Checks, folder: pathlib.Path) -> None:
    """A surface whose points are split as it stretches: two threads and a continued run give the same bytes."""
    deck = (pathlib.Path(__file__).resolve().parent / "cases" / "decks" / "contact_upset.inp").read_text()
    deck = deck.replace("*PHASE", "*RESTART, EVERY=1\n*PHASE", 1).replace("STEPS=38", "STEPS=80")
    whole = checks.run(folder, deck, out=folder / "whole")
    checks.check("a block whose surface stretches runs", whole.returncode == 0, whole.stderr[-300:])
    threads = checks.run(folder, deck, "--threads", "2", out=folder / "threads")
    same, why = same_results(folder / "whole", folder / "threads")
    checks.check("points split on two threads, the same bytes", threads.returncode == 0 and same, why)
    code = interrupt(checks, folder, folder / "part", 50, signal.SIGKILL)
    rest = checks.run(folder, deck, "--restart", str(folder / "part" / "restart.h5"), out=folder / "part")
    same, why = same_results(folder / "whole", folder / "part")
    checks.check("killed with more points than as drawn and continued, the same bytes", code == -9 and rest.returncode == 0 and same,
                 f"exit {code}, {rest.returncode}: {why}")


LOADED = PRESSED.replace("SHAPE=PLANE\n0, 1, 0, -1", "SHAPE=BOX\n-0.3, 1.3, 1, 1.5").replace("SURFACE=head, FRICTION ANGLE=10", "ON=BODY, FRICTION ANGLE=30")


def loaded(checks: Checks, folder: pathlib.Path) -> None:
    """A rigid box with contact points of its own, pressed down, loaded sideways and turned: what it and its points keep is continued,
    and two threads give the same."""
    loads = "*MOVE, BODY=plate\n0, -0.05\n*LOAD, BODY=plate, COMPONENT=MZ\n0.1\n*LOAD, BODY=plate, COMPONENT=X\n0.5, 0.5, 1.1\n"
    deck = block(loads=loads, method="BASIS=GIMP, INTEGRATION=CELL", steps=40).replace("*HISTORY", LOADED, 1)
    whole = checks.run(folder, deck, out=folder / "whole")
    checks.check("a block under a loaded box runs", whole.returncode == 0, whole.stderr[-300:])
    threads = checks.run(folder, deck, "--threads", "2", out=folder / "threads")
    same, why = same_results(folder / "whole", folder / "threads")
    checks.check("a box that turns, on two threads, the same bytes", threads.returncode == 0 and same, why)
    code = interrupt(checks, folder, folder / "part", 6, signal.SIGKILL)
    rest = checks.run(folder, deck, "--restart", str(folder / "part" / "restart.h5"), out=folder / "part")
    same, why = same_results(folder / "whole", folder / "part")
    checks.check("killed under the load and continued, the same bytes", code == -9 and rest.returncode == 0 and same,
                 f"exit {code}, {rest.returncode}: {why}")


VARIANTS = """*PHASE, NAME=crushed, LOAD FACTOR=300
*GRAVITY
0, -1
*CONTROLS, STEPS=10, SMALLEST STEP=0.5, DAMPING=NO
*END PHASE
*PHASE, NAME=behind
*CONTROLS, STEPS=1
*END PHASE
*PHASE, NAME=factor, TYPE=SAFETY, PARENT=load
*SAFETY, TOLERANCE=1E-3
*CONTROLS, TOLERANCE=1E-6
*END PHASE
"""


def searched(checks: Checks, folder: pathlib.Path) -> None:
    """One variant of a tree loses equilibrium, the other is a search for a factor of safety: that is run and ends with the other's code;
    killed in the search and continued it gives the same bytes."""
    deck = block(columns=16, width=4, strength="*MOHR COULOMB\n1, 15, 15\n", method="BASIS=SPLINE2G, INTEGRATION=CELL", factor=3,
                 steps=2, fixities="*FIX\nbase, ALL\nside, X\n") + VARIANTS
    whole = checks.run(folder, deck, out=folder / "whole")
    checks.check("a lost variant makes exit 3", whole.returncode == 3, f"exit {whole.returncode}: {whole.stderr[-300:]}")
    checks.check("and is named with what was not run for it", "'crushed' has lost equilibrium" in whole.stderr
                 and whole.stderr.rstrip().endswith("were not run: 'behind'"), whole.stderr[-300:])
    ends = [phase["ended_by"] for phase in json.loads((folder / "whole" / "summary.json").read_text())["phases"]]
    checks.check("the summary tells all ends", ends == ["whole load", "lost", "not run", "factor"], str(ends))
    rows = [line.split(",")[0] for line in (folder / "whole" / "curves.csv").read_text().splitlines()]
    first = rows.index("4")
    checks.check("the search has several steps", rows.count("4") >= 5, str(rows.count("4")))
    part = folder / "part"
    code = interrupt(checks, folder, part, first + 2, signal.SIGKILL)
    there = len((part / "curves.csv").read_text().splitlines())
    checks.check("SIGKILL in the search", code == -9 and there < len(rows), f"exit {code}, {there} rows of {len(rows)}")
    rest = checks.run(folder, deck, "--restart", str(part / "restart.h5"), out=part)
    same, why = same_results(folder / "whole", part)
    checks.check("continued, it ends as the uninterrupted run", rest.returncode == 3 and rest.stderr == whole.stderr, rest.stderr[-300:])
    checks.check("with its bytes", same, why)
    with h5py.File(part / "results.h5") as file:
        there = sorted(file.get("mechanisms", {}))
        moved = [float(abs(file[f"mechanisms/{name}/points/displacement"][...]).max()) for name in there]
    checks.check("and the way it fails among its results", there == ["000004"] and moved[0] > 1e-3, f"{there} {moved}")
    for name in ("safety.json", "summary.json"):
        checks.check(f"and its {name}", filecmp.cmp(folder / "whole" / name, part / name, shallow=False))


def quiet(checks: Checks, folder: pathlib.Path) -> None:
    """--quiet shows what was found, warnings and errors, and neither steps nor notes."""
    deck = block(columns=16, width=4, strength="*MOHR COULOMB\n1, 15, 15\n", method="BASIS=SPLINE2G, INTEGRATION=CELL", factor=3,
                 steps=2, fixities="*FIX\nbase, ALL\nside, X\n").replace("0, 1, 0, 1\n", "-1, 1, 0, 1\n") + VARIANTS
    run = checks.run(folder, deck, "--quiet")
    shown, told = run.stdout.splitlines(), run.stderr.splitlines()
    checks.check("quiet, the factor of safety is shown, with what it depends on", len(shown) == 3
                 and shown[0].startswith("phase 'factor': factor of safety ") and shown[1].startswith("the factor depends on the grid")
                 and shown[2].startswith("the factor is that of the deformed ground"), run.stdout[-500:])
    warnings = [line for line in told if "warning: " in line]
    checks.check("quiet, warnings go to the error output", any("body 'block': 50.0 % of it lies outside" in line for line in warnings),
                 run.stderr[-500:])
    checks.check("quiet, nothing else does but the error", len(told) == len(warnings) + 1 and "'crushed' has lost" in told[-1], run.stderr[-500:])
    log = (folder / "out" / "job.log").read_text().splitlines()
    checks.check("and the log has what was shown", set(shown) <= set(log))


# Sends SIGTERM from within METIS, once.
IN_METIS = """#define _GNU_SOURCE
#include <dlfcn.h>
#include <signal.h>
#include <unistd.h>
static int sent = 0;
void *libmetis__SetupGraph(void *a, int b, int c, int *d, int *e, int *f, int *g, int *h)
{
    void *(*real)(void *, int, int, int *, int *, int *, int *, int *) = dlsym(RTLD_NEXT, "libmetis__SetupGraph");
    if (!sent) { sent = 1; kill(getpid(), SIGTERM); }
    return real(a, b, c, d, e, f, g, h);
}
"""


def stopped_in_metis(checks: Checks, folder: pathlib.Path) -> None:
    """METIS takes SIGTERM for an error of its own; it is a stop on request all the same."""
    (folder / "in_metis.c").write_text(IN_METIS)
    library = folder / "in_metis.so"
    subprocess.run(["cc", "-shared", "-fPIC", "-o", str(library), str(folder / "in_metis.c"), "-ldl"], check=True)
    (folder / "case.inp").write_text(block(width=2, columns=40, steps=5, method="STABILISATION=GHOST\n*SOLVER, TYPE=MUMPS"))
    done = subprocess.run([checks.binary, "run", str(folder / "case.inp"), "--out", str(folder / "out")], capture_output=True,
                          text=True, timeout=PATIENCE, env={**os.environ, "LD_PRELOAD": str(library)})
    checks.check("SIGTERM within METIS ends with exit 143", done.returncode == 143 and "stopped on request" in done.stderr,
                 f"exit {done.returncode}: {done.stderr[-200:]}")
    checks.check("and the state is on disk", (folder / "out" / "restart.h5").exists())


def follows(checks: Checks, folder: pathlib.Path) -> None:
    """The part of a wide grid that is looked at follows a block on a base that runs: the results are those of the whole grid, and an
    interruption after it has moved leaves no trace."""
    ways = (("SPLINE2G CELL", "QUAD4", "BASIS=SPLINE2G, INTEGRATION=CELL"), ("STANDARD on random TRI6", "TRI6, DIAGONAL=RANDOM, PERTURB=0.2, SEED=3", ""))
    for name, element, method in ways:
        here = folder / name.replace(" ", "_")
        here.mkdir()
        deck = block(width=12, columns=48, steps=100, factor=1, fixities="*FIX\nbase, Y\n", loads="*GRAVITY\n0, -10\n*PRESCRIBE\nbase, X, 8\n",
                     method=method or "STABILISATION=GHOST",
                     controls="TOLERANCE=1E-6, MAX DISPLACEMENT=1, STABILISATION SHARE=1")
        deck = deck.replace("ELEMENT=QUAD4", "ELEMENT=" + element).replace("*RESTART", "*FIELD, EVERY=20\n*RESTART", 1)
        part = checks.run(here, deck, out=here / "window")
        laid = (here / "window" / "job.log").read_text().count("active window rebuilt")
        checks.check(f"{name}: the run ends well", part.returncode == 0, part.stderr[-300:])
        checks.check(f"{name}: the part looked at has moved several times", laid >= 3, f"{laid} times")
        whole = checks.run(here, deck.replace("*GRID,", "*GRID, WINDOW=NO,"), out=here / "whole")
        checks.check(f"{name}: the run on the whole grid ends well", whole.returncode == 0, whole.stderr[-300:])
        curves = [(here / way / "curves.csv").read_bytes() for way in ("window", "whole")]
        checks.check(f"{name}: curves are those of the whole grid to the byte", curves[0] == curves[1])
        (here / "case.inp").write_text(deck)
        cut = here / "cut"
        code = interrupt(checks, here, cut, 70)
        before = (cut / "job.log").read_text().count("active window rebuilt")
        checks.check(f"{name}: SIGTERM ends with exit 143 after the part has moved", code == 143 and before > 0, f"exit {code}, {before} times")
        rest = checks.run(here, deck, "--restart", str(cut / "restart.h5"), out=cut)
        same, why = same_results(here / "window", cut)
        checks.check(f"{name}: continued, it ends well", rest.returncode == 0, rest.stderr[-300:])
        checks.check(f"{name}: with the bytes of the uninterrupted one", same, why)


def echo_runs(checks: Checks, folder: pathlib.Path) -> None:
    deck = block(factor=5)
    checks.run(folder, deck, out=folder / "first")
    echo = folder / "first" / "case.echo.inp"
    text = echo.read_text()
    other = folder / "echo"
    other.mkdir()
    checks.run(other, text, out=other / "second")
    same, why = same_results(folder / "first", other / "second")
    checks.check("the echo deck runs and gives the same bytes", same, why)


BASES = (("FEM", "BASIS=FEM", ""),
         ("STANDARD on a moving mesh", "STABILISATION=GHOST", "*MOVING MESH, NSET=plate, AXIS=Y, BASE=0\n"),
         ("GIMP", "BASIS=GIMP", ""),
         ("SPLINE2 on a moving mesh", "BASIS=SPLINE2", "*MOVING MESH, NSET=plate, AXIS=Y, BASE=0\n"),
         ("SPLINE2G CELL", "BASIS=SPLINE2G, INTEGRATION=CELL, FACTOR=0.05", ""),
         ("SPLINE3 CELL", "BASIS=SPLINE3, INTEGRATION=CELL, KINEMATICS=JAUMANN", ""))


def bases(checks: Checks, folder: pathlib.Path) -> None:
    """Other bases and meshes that move: the echo deck, two threads and an interrupted and continued run all give the same bytes. The block
    yields under a plate that covers a part of it, so that states, domains and kinks all count."""
    for name, method, more in BASES:
        here = folder / name.replace(" ", "_")
        other = here / "echo"
        other.mkdir(parents=True)
        deck = block(strength="*MOHR COULOMB\n0.5, 30, 0\n", factor=0.5, steps=60, method=method,
                     loads="*GRAVITY\n0, -1\n*PRESCRIBE\nplate, Y, -0.06\n")
        deck = deck.replace("*MATERIAL", f"*NSET, NSET=plate, BOX\n0, 0.5, 1, 1\n{more}*FIELD, EVERY=10\n*MATERIAL", 1)
        whole = checks.run(here, deck, out=here / "whole")
        checks.check(f"{name}: the uninterrupted run ends well", whole.returncode == 0, whole.stderr[-300:])
        checks.run(other, (here / "whole" / "case.echo.inp").read_text(), out=other / "out")
        same, why = same_results(here / "whole", other / "out")
        checks.check(f"{name}: the echo deck gives the same bytes", same, why)
        checks.run(here, deck, "--threads", "2", out=here / "threads")
        same, why = same_results(here / "whole", here / "threads")
        checks.check(f"{name}: two threads give the bytes of one", same, why)
        code = interrupt(checks, here, here / "part", 15)
        rest = checks.run(here, deck, "--restart", str(here / "part" / "restart.h5"), out=here / "part")
        same, why = same_results(here / "whole", here / "part")
        checks.check(f"{name}: a restarted run gives the bytes of the uninterrupted one", code == 143 and rest.returncode == 0
                     and same, f"exit {code}, then {rest.returncode}: {why} {rest.stderr[-300:]}")


WEDGES = """*HEADING
Block of wedges, of so many points that threads evaluate them.
*MODEL, TYPE=3D
*GRID, ELEMENT=WEDGE15
X, 0, 2, 6
Y, 0, 1, 3
Z, 0, 1, 8
*NSET, NSET=base, PLANE=Y
0
*NSET, NSET=front, PLANE=Z
0
*NSET, NSET=back, PLANE=Z
1
*MATERIAL, NAME=soil
*ELASTIC
100, 0.3
*MOHR COULOMB
0.5, 30, 0
*UNIT WEIGHT
1
*BODY, NAME=block, MATERIAL=soil, SHAPE=BOX
0, 1.2, 0, 0.9, 0, 1
*METHOD, INTEGRATION={integration}
*HISTORY, NAME=top, QUANTITY=POSITION, COMPONENT=Y
1.2, 0.9, 0.5
*PHASE, NAME=load, LOAD FACTOR=2
*FIX
base, ALL
front, Z
back, Z
*GRAVITY
0, -1, 0
*CONTROLS, STEPS=2
*END PHASE
"""


def threads(checks: Checks, folder: pathlib.Path) -> None:
    """Meshes of many chunks of cells, the wedges with more than the 2000 points from which threads are woken: one, two and four
    threads give the same bytes."""
    inputs = pathlib.Path(__file__).resolve().parents[1] / "input"
    decks = {"slope": re.sub(r"STEPS=\d+", "STEPS=8", (inputs / "slope_grid.inp").read_text()),
             "footing": re.sub(r"STEPS=\d+", "STEPS=2", (inputs / "footing.inp").read_text()).replace("LOAD FACTOR=0.2", "LOAD FACTOR=0.01"),
             "wedges at points": WEDGES.format(integration="POINTS"),
             "wedges in cells": WEDGES.format(integration="CELL")}
    for name, deck in decks.items():
        here = folder / name.replace(" ", "_")
        here.mkdir()
        one = checks.run(here, deck, out=here / "1")
        checks.check(f"{name}: the run ends well", one.returncode == 0, one.stderr[-300:])
        for count in ("2", "4"):
            checks.run(here, deck, "--threads", count, out=here / count)
            same, why = same_results(here / "1", here / count)
            checks.check(f"{name}: {count} threads give the bytes of one", same, why)


def sleeping_threads(checks: Checks, folder: pathlib.Path) -> None:
    """Threads of a run sleep while they wait, unless the environment says how they are to wait. The runtime tells."""
    deck = folder / "case.inp"
    deck.write_text(block(factor=1, steps=1))
    free = {key: value for key, value in os.environ.items() if key not in ("OMP_WAIT_POLICY", "GOMP_SPINCOUNT")}
    for name, given, turns in (("asleep", {}, "0"), ("as they are told", {"GOMP_SPINCOUNT": "77"}, "77")):
        run = subprocess.run([checks.binary, "run", str(deck), "--threads", "2", "--quiet", "--out", str(folder / turns)],
                             capture_output=True, text=True, env={**free, **given, "OMP_DISPLAY_ENV": "verbose"}, check=False)
        told = re.findall(r"GOMP_SPINCOUNT = '(\d+)'", run.stderr)
        checks.check(f"two threads wait {name}", run.returncode == 0 and told[-1:] == [turns], run.stderr[-300:])


def two_runs(checks: Checks, folder: pathlib.Path) -> None:
    """A second run into a folder is refused while the first one writes, and its results stay as they are; a run that was killed leaves no
    lock."""
    deck = block(factor=20, steps=400)
    out = folder / "out"
    (folder / "case.inp").write_text(deck)
    first = subprocess.Popen([checks.binary, "run", str(folder / "case.inp"), "--out", str(out)], stdout=subprocess.DEVNULL,
                             stderr=subprocess.DEVNULL)
    wait_for_rows(first, out, 20)
    second = checks.run(folder, deck, out=out)
    checks.check("a second run into a folder ends with exit 1", second.returncode == 1, f"exit {second.returncode}: {second.stderr[-300:]}")
    checks.check("and names the folder and the process that writes there", str(out) in second.stderr and str(first.pid) in second.stderr,
                 second.stderr[-300:])
    checks.check("the first run finishes", first.wait(PATIENCE) == 0)
    rows = len((out / "curves.csv").read_text().splitlines())
    checks.check("its curves are whole", rows >= 401 and (out / "job.log").read_text().endswith("qsmpm: finished\n"), f"{rows} lines")
    checks.check("no lock is left", not (out / "run.lock").exists())
    killed = subprocess.Popen([checks.binary, "run", str(folder / "case.inp"), "--out", str(out)], stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL)
    wait_for_rows(killed, out, 5)
    killed.kill()
    killed.wait(PATIENCE)
    after = checks.run(folder, block(), out=out)
    checks.check("after a run that was killed the folder is free", after.returncode == 0, after.stderr[-300:])


def damaged(checks: Checks, folder: pathlib.Path, seeds: int = 40) -> None:
    """A restart file with one bit turned, a byte less or a piece of another is refused in one line, never read and never a crash."""
    deck = block(steps=2)
    checks.run(folder, deck)
    good = (folder / "out" / "restart.h5").read_bytes()
    wrong: list[str] = []
    rng = random.Random(12)
    for seed in range(seeds):
        bad = bytearray(good)
        if seed % 10 == 9:
            del bad[rng.randrange(len(bad)):]
        elif seed % 10 == 8:
            at = rng.randrange(len(bad) - 64)
            bad[at:at + 64] = bytes(64) if any(bad[at:at + 64]) else b"x" * 64
        else:
            bad[rng.randrange(len(bad))] ^= 1 << rng.randrange(8)
        (folder / "bad.h5").write_bytes(bad)
        run = checks.run(folder, deck, "--restart", str(folder / "bad.h5"), out=folder / "again")
        if run.returncode != 1 or "cannot read" not in run.stderr or len(run.stderr.splitlines()) != 1:
            wrong.append(f"{seed}: exit {run.returncode} {run.stderr[-100:]!r}")
    checks.check(f"{seeds} damaged restart files are refused", not wrong, "; ".join(wrong[:5]))
    checks.check("and nothing is written", not (folder / "again").exists())
    (folder / "bad.h5").write_bytes(good)
    run = checks.run(folder, deck, "--restart", str(folder / "bad.h5"), out=folder / "again")
    checks.check("the whole one is read", run.returncode == 0, run.stderr[-300:])


def resealed(checks: Checks, folder: pathlib.Path) -> None:
    """Numbers out of their ranges are refused even under a checksum that fits."""
    deck = block(steps=2)
    checks.run(folder, deck)
    for name, index, value, told in (("points/cell", 0, 100000, "material points"), ("points/material", 0, 7, "material points"),
                                     ("points/stress", (0, 0), float("nan"), "material points"), ("points/volume", 3, -1.0, "material points"),
                                     ("points/body", 1, 0, "material points"), ("mesh/window", 3, 4000, "part of the grid"),
                                     ("mesh/reactions", (0, 0), float("inf"), "the mesh"), ("progress@phase", None, 3, "progress"),
                                     ("progress@fraction", None, 1.5, "progress"), ("points@count", None, 3, "points has another size than it says")):
        shutil.copy(folder / "out" / "restart.h5", folder / "bad.h5")
        with h5py.File(folder / "bad.h5", "r+") as file:
            if "@" in name:
                group, _, key = name.partition("@")
                file[group].attrs.modify(key, value)
            else:
                file[name][index] = value
        data = (folder / "bad.h5").read_bytes()
        data = data[:-SEAL] if data[-SEAL:].startswith(b"qsmpm crc32 ") else data
        (folder / "bad.h5").write_bytes(data + b"qsmpm crc32 %08X\n" % zlib.crc32(data))
        run = checks.run(folder, deck, "--restart", str(folder / "bad.h5"), out=folder / "again")
        checks.check(f"restart.h5: {name} = {value} is refused", run.returncode == 1 and told in run.stderr, f"exit {run.returncode}: {run.stderr[-200:]}")


MARKING_MODEL = r"""
#include <stdio.h>
__attribute__((constructor)) static void mark(void) { FILE *f = fopen("MARK", "w"); if (f) fclose(f); }
void umat_(double *stress, double *state, double *ddsdde) {
    for (int i = 0; i < 36; i++) ddsdde[i] = i % 7 == 0 ? (i < 21 ? 200.0 : 100.0) : 0.0;
    (void)stress; (void)state;
}
"""


def strange_library(checks: Checks, folder: pathlib.Path) -> None:
    """A library that a deck names is loaded, which runs its code, by run and point, and by check and plan when they are told to."""
    mark, source, library = folder / "mark", folder / "model.c", folder / "libmodel.so"
    source.write_text(MARKING_MODEL.replace("MARK", str(mark)))
    subprocess.run(["cc", "-shared", "-fPIC", "-o", str(library), str(source)], check=True)
    deck = folder / "case.inp"
    deck.write_text(block(steps=1).replace("*ELASTIC\n100, 0.3\n", "*USER MATERIAL, INTERFACE=UMAT, LIBRARY=libmodel.so\n 1\n"))
    for words, loads in ((["check"], False), (["plan"], False), (["check", "--plugins"], True), (["plan", "--plugins"], True)):
        mark.unlink(missing_ok=True)
        run = subprocess.run([checks.binary, words[0], str(deck), *words[1:]], capture_output=True, text=True, timeout=PATIENCE)
        checks.check(f"{' '.join(words)} ends well", run.returncode == 0, run.stderr[-300:])
        checks.check(f"{' '.join(words)} {'loads' if loads else 'does not load'} a library", mark.exists() == loads)
        checks.check(f"{' '.join(words)} {'has nothing to say' if loads else 'says so'}", ("is not loaded" in run.stderr) != loads, run.stderr[-300:])
    library.unlink()
    run = subprocess.run([checks.binary, "check", str(deck)], capture_output=True, text=True, timeout=PATIENCE)
    checks.check("check sees a library that is not there", run.returncode == 6 and "there is no library" in run.stderr, run.stderr[-300:])


def planned(checks: Checks, folder: pathlib.Path) -> None:
    """The first step of a scene with rigid bodies can be planned, reduced or not, with the patches and points of its contacts."""
    inputs = pathlib.Path(__file__).resolve().parents[1] / "input"
    decks = pathlib.Path(__file__).resolve().parent / "cases" / "decks"
    for deck in (inputs / "wall_passive.inp", inputs / "tbar.inp", decks / "scene_pipes.inp"):
        run = subprocess.run([checks.binary, "plan", str(deck)], capture_output=True, text=True, timeout=PATIENCE)
        checks.check(f"plan {deck.name} ends well", run.returncode == 0 and "expected of the run" in run.stdout, run.stderr[-300:])
        contact = [int(n) for n in re.findall(r"contact patches +(\d+)\n +contact points +(\d+)\n +unknowns of bodies +(\d+)", run.stdout)[0]]
        checks.check(f"and tells what its contact costs: {contact}", 0 < contact[0] < contact[1], run.stdout)
    deck = folder / "k0.inp"
    deck.write_text((decks.parents[1] / "broken" / "bases" / "k0.inp").read_text().replace(" 0, 30, 0\n", " 1, 0, 0\n"))
    run = subprocess.run([checks.binary, "plan", str(deck)], capture_output=True, text=True, timeout=PATIENCE)
    checks.check("plan tells what the run refuses", "the run is lost" in run.stdout and "the K0 stresses are not in equilibrium" in run.stdout, run.stdout[-400:])
    run = subprocess.run([checks.binary, "check", str(inputs / "tbar.inp")], capture_output=True, text=True, timeout=PATIENCE)
    checks.check("check says what touches a body", "touched by the soil around it" in run.stdout, run.stdout)


def silent_decks(checks: Checks, folder: pathlib.Path) -> None:
    """Nothing is to be warned of before the run in any deck of input/ and of the tutorial (6: a library is not built)."""
    top = pathlib.Path(__file__).resolve().parents[1]
    decks = sorted([*(top / "input").glob("*.inp"), *(top / "docs" / "tutorial").glob("*.inp")])
    checks.check(f"there are {len(decks)} decks", len(decks) > 50)
    for deck in decks:
        run = subprocess.run([checks.binary, "check", str(deck)], capture_output=True, text=True, timeout=PATIENCE, cwd=folder)
        words = [line for line in (run.stdout + run.stderr).splitlines() if "warning: " in line]
        checks.check(f"{deck.name} is checked without a warning", run.returncode in (0, 6) and not words, "\n".join(words) + run.stderr[-300:])


CLOCK_MODEL = r"""
/* Elasticity that adds up DTIME in its first state variable and keeps the time at the end of the step in its second. */
void umat_(double *stress, double *state, double *ddsdde, void *sse, void *spd, void *scd, void *rpl, void *ddsddt, void *drplde,
           void *drpldt, double *stran, double *dstran, double *time, double *dtime) {
    for (int i = 0; i < 36; i++) ddsdde[i] = i % 7 == 0 ? (i < 21 ? 200.0 : 100.0) : 0.0;
    for (int i = 0; i < 6; i++) stress[i] += ddsdde[7 * i] * dstran[i];
    state[0] += *dtime;
    state[1] = time[1] + *dtime;
    (void)sse; (void)spd; (void)scd; (void)rpl; (void)ddsddt; (void)drplde; (void)drpldt; (void)stran;
}
"""


def clocks_and_levels(checks: Checks, folder: pathlib.Path) -> None:
    """A model is told the deck's time in phases, stages and tables; its state may start otherwise at every level, and be recorded."""
    source = folder / "clock.c"
    source.write_text(CLOCK_MODEL)
    subprocess.run(["cc", "-shared", "-fPIC", "-o", str(folder / "libclock.so"), str(source)], check=True)
    material = "*USER MATERIAL, INTERFACE=UMAT, LIBRARY=libclock.so, STATE=3\n 1\n"
    deck = block(steps=4).replace("*ELASTIC\n100, 0.3\n", material + "*USER STATE, ALONG=Y\n0, 0, 0, 2\n0.5, 0, 0, 1\n2, 0, 0, 4\n")
    deck = deck.replace("LOAD FACTOR=1\n", "LOAD FACTOR=1, TIME=10, START TIME=100\n")
    deck = deck.replace("*RESTART", "".join(f"*HISTORY, NAME={name}, QUANTITY=STATE, STATE={state}\n0.5, 0.5\n"
                                            for name, state in (("sum", "1"), ("end", "SDV2"))) + "*RESTART", 1)
    deck += "*PHASE, NAME=more, TIME=5\n*GRAVITY\n0, -1.5\n*CONTROLS, STEPS=2\n*END PHASE\n"
    run = checks.run(folder, deck)
    checks.check("a deck with times and levels runs", run.returncode == 0, run.stderr[-300:])
    head, *rows = [line.split(",") for line in (folder / "out" / "curves.csv").read_text().splitlines()]
    names = [cell.split("[")[0].strip() for cell in head]
    column = {name: [float(row[names.index(name)]) for row in rows] for name in ("phase", "sum", "end")}
    at = [i for i, phase in enumerate(column["phase"]) if phase == 1][-1]
    # Steps held at their load take 1e-6 of their phase.
    for what, value, wanted in (("of the first phase", column["sum"][at], 10.0), ("at its end", column["end"][at], 110.0),
                                ("of both phases", column["sum"][-1], 15.0), ("at the end", column["end"][-1], 115.0)):
        checks.check(f"the time {what} is that of the deck", abs(value - wanted) < 2e-3, f"{value}, not {wanted}")
    with h5py.File(folder / "out" / "results.h5") as file:
        last = file[f"steps/{max(file['steps'])}/points"]
        position, displacement, state = (last[name][...] for name in ("position", "displacement", "SDV3"))
        y = (position - displacement)[..., 1] if position.shape[-1] in (2, 3) else (position - displacement)[1]
    wanted = [2 - 2 * v if v < 0.5 else 1 + 2 * (v - 0.5) for v in y.ravel()]
    checks.check("the state starts as its levels say", max(abs(a - b) for a, b in zip(state.ravel(), wanted)) < 1e-12)
    (folder / "path.csv").write_text("time [s],E22\n0,0\n5,-0.001\n20,-0.002\n")
    test = "*MATERIAL, NAME=soil\n" + material + ("*POINT TEST, TYPE=PATH, START TIME=50\n*POINT STAGE, STEPS=2, TIME=3\nE22, 0.001\n"
                                                   "*POINT STAGE, INPUT=path.csv, STEPS=2\n")
    (folder / "point.inp").write_text(test)
    run = subprocess.run([checks.binary, "point", str(folder / "point.inp"), "--out", str(folder / "point")], capture_output=True, text=True)
    checks.check("a point test with times runs", run.returncode == 0, run.stderr[-300:])
    head, *rows = [line.split(",") for line in (folder / "point" / "curves.csv").read_text().splitlines()]
    names = [cell.split("[")[0].strip() for cell in head]
    at = names.index("SDV1") if "SDV1" in names else names.index("state_16")
    found = [float(row[at + 1]) for row in rows]
    wanted = [0, 51.5, 53, 53 + 10e-6, 53 + 20e-6, 55.5, 58, 65.5, 73]
    checks.check("its times are those of stage and table", len(found) == 9 and max(abs(a - b) for a, b in zip(found, wanted)) < 1e-4, f"{found}")


def leaves_by_exit(checks: Checks, folder: pathlib.Path) -> None:
    """A model that ends the process with exit code 0, past all handlers, is a failure of the model."""
    for kind, name in ((12, "_exit"), (20, "quick_exit")):
        run = checks.run(folder, faulty_block(checks, kind), out=folder / name)
        checks.check(f"{name}(0) inside a model ends with exit 6", run.returncode == 6, f"exit {run.returncode}: {run.stderr[-300:]}")
        checks.check("and with a message", "ends the program" in run.stderr, run.stderr[-300:])
        rows = len((folder / name / "curves.csv").read_text().splitlines()) - 1
        checks.check("the steps before are whole", rows == 2 and (folder / name / "restart.h5").exists(), f"{rows} rows")


def faulty_block(checks: Checks, kind: int) -> str:
    """A block of a model that goes wrong in its third step."""
    library = pathlib.Path(checks.binary).parent / "verification" / "plugins" / "libfaulty.so"
    return block(steps=4).replace("*ELASTIC\n100, 0.3\n", f"*USER MATERIAL, INTERFACE=UMAT, LIBRARY={library}\n 200, 0.3, {kind}, 3, 0, 0\n")


def never_returns(checks: Checks, folder: pathlib.Path) -> None:
    """A model in an endless loop: the first SIGTERM ends the run, with its results whole and the model named."""
    (folder / "case.inp").write_text(faulty_block(checks, 21))
    process = subprocess.Popen([checks.binary, "run", str(folder / "case.inp"), "--out", str(folder / "out")],
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    wait_for_rows(process, folder / "out", 2)
    time.sleep(0.5)
    process.send_signal(signal.SIGTERM)
    try:
        code = process.wait(20)
    except subprocess.TimeoutExpired:
        process.kill()
        code = process.wait()
    text = (folder / "out" / "job.log").read_text()
    checks.check("SIGTERM ends a run whose model does not return with exit 143", code == 143, f"exit {code}: {text[-300:]}")
    checks.check("and the log names the model", "the model does not return" in text, text[-300:])
    rows = len((folder / "out" / "curves.csv").read_text().splitlines()) - 1
    checks.check("the steps before it are whole", rows == 2 and (folder / "out" / "restart.h5").exists(), f"{rows} rows")


def small_memory(checks: Checks, folder: pathlib.Path) -> None:
    """A process that may not have the memory of the linear algebra says so; that library asks for it for ever otherwise, deaf to SIGTERM."""
    (folder / "case.inp").write_text(block(steps=2))
    least = 0
    for mebibytes in (100, 150, 200, 250):
        limits = ((resource.RLIMIT_AS, mebibytes << 20), (resource.RLIMIT_CPU, 20))
        run = subprocess.run([checks.binary, "run", str(folder / "case.inp"), "--out", str(folder / f"out{mebibytes}")], capture_output=True,
                             text=True, preexec_fn=lambda limits=limits: [resource.setrlimit(kind, (most, most)) for kind, most in limits])
        checks.check(f"in {mebibytes} MiB a run ends by itself", run.returncode in (0, 1, 127), f"exit {run.returncode}: {run.stderr[-300:]}")
        least += run.returncode == 1 and "not enough memory" in run.stderr
    checks.check("where there is too little it says so", least > 0)


def full_disk(checks: Checks, folder: pathlib.Path) -> None:
    disk = folder / "disk"
    disk.mkdir()
    if os.geteuid() != 0 or subprocess.run(["mount", "-t", "tmpfs", "-o", "size=400k", "tmpfs", str(disk)],
                                           capture_output=True).returncode != 0:
        print("skipped: a full disk (needs root to mount a small tmpfs)")
        return
    try:
        deck = block(factor=20, steps=400).replace("*RESTART", "*FIELD, EVERY=1\n*RESTART", 1)
        run = checks.run(folder, deck, out=disk / "out")
        text = run.stdout + run.stderr
        checks.check("a full disk ends with exit 1 and says so", run.returncode == 1 and bool(text.strip()),
                     f"exit {run.returncode}: {text[-300:]}")
        # The check is on reading: the state is continued with room to write.
        again = checks.run(folder, deck.replace("*FIELD, EVERY=1\n", "*FIELD, EVERY=1\n"), "--restart",
                           str(disk / "out" / "restart.h5"), out=folder / "room")
        checks.check("full disk: the last good restart file is whole", again.returncode == 0, again.stderr[-300:])
    finally:
        subprocess.run(["umount", str(disk)], check=False)


def shell_limits(checks: Checks, folder: pathlib.Path) -> None:
    """ulimit -f and -s: a file that may not grow ends a run like a full disk, and a small stack is met or told."""
    (folder / "case.inp").write_text(block(factor=20, steps=600, columns=2))

    def limited(kind: int, soft: int, hard: int, out: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run([checks.binary, "run", str(folder / "case.inp"), "--out", str(folder / out)], capture_output=True, text=True,
                              timeout=PATIENCE, preexec_fn=lambda: resource.setrlimit(kind, (soft, hard)))

    run = limited(resource.RLIMIT_FSIZE, 80000, 80000, "short")
    checks.check("a file that grows too large ends with exit 1 and says so", run.returncode == 1 and "File too large" in run.stderr,
                 f"exit {run.returncode}: {run.stderr[-300:]}")
    rows = (folder / "short" / "curves.csv").read_text()
    checks.check("its rows are whole", rows.endswith("\n") and len({line.count(",") for line in rows.splitlines()}) == 1, rows[-200:])
    checks.check("nothing is half written", not list((folder / "short").rglob("*.tmp")), str(list((folder / "short").rglob("*.tmp"))))
    again = checks.run(folder, (folder / "case.inp").read_text(), "--restart", str(folder / "short" / "restart.h5"), out=folder / "room")
    checks.check("and the last good state goes on", again.returncode == 0, again.stderr[-300:])
    run = limited(resource.RLIMIT_STACK, 300 << 10, 300 << 10, "small")
    checks.check("a stack that is too small is told", run.returncode == 1 and "stack" in run.stderr, f"exit {run.returncode}: {run.stderr[-300:]}")
    run = limited(resource.RLIMIT_STACK, 300 << 10, resource.RLIM_INFINITY, "grown")
    checks.check("one that may grow does", run.returncode == 0, f"exit {run.returncode}: {run.stderr[-300:]}")


def piped(checks: Checks, folder: pathlib.Path) -> None:
    """A deck through a named pipe is the deck."""
    pipe, deck = folder / "pipe", block(steps=2)
    os.mkfifo(pipe)
    process = subprocess.Popen([checks.binary, "run", str(pipe), "--out", str(folder / "piped")], stderr=subprocess.PIPE, text=True)
    pipe.write_text(deck)
    words = process.communicate(timeout=PATIENCE)[1]
    checks.run(folder, deck)
    same = process.returncode == 0 and filecmp.cmp(folder / "out" / "curves.csv", folder / "piped" / "curves.csv", shallow=False)
    checks.check("a deck through a pipe gives the curves of its file", same, words[-300:])


def main() -> int:
    checks = Checks(os.path.abspath(sys.argv[1]))
    for test in (not_converging, collapse, point_lost, singular, interrupted, released, searched, dug, kept_factors, pressed, stretched, loaded, quiet, stopped_in_metis, follows, echo_runs, bases,
                 threads, sleeping_threads, two_runs, damaged, resealed, strange_library, planned, silent_decks, leaves_by_exit, never_returns,
                 clocks_and_levels,
                 small_memory, full_disk, shell_limits, piped):
        with tempfile.TemporaryDirectory() as name:
            try:
                test(checks, pathlib.Path(name))
            except Exception as trouble:  # a crashed check is a failed one
                checks.check(test.__name__, False, repr(trouble))
    print(f"{checks.passed} passed, {checks.failed} failed")
    return 1 if checks.failed else 0


if __name__ == "__main__":
    sys.exit(main())
