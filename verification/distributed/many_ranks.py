"""Checks of several ranks: the same deck by one process and by many, for what they can share."""

from __future__ import annotations

import json
import os
import pathlib
import re
import signal
import subprocess
import time

from one_rank import LOST, cut, shortened
from support import ENVIRONMENT, TOP, Check, Place, Run, distance, expect, expect_same_bytes

# Curves of another number of ranks: where nothing yields, and where soil yields (ten times the TOLERANCE of the decks).
ELASTIC, PLASTIC = 1.0e-6, 1.0e-3
SECONDS = 10.0
"""By the clock, in which all ranks end once one has to."""
STANDARD = "BASIS=STANDARD, INTEGRATION=POINTS, KINEMATICS=LOGARITHMIC"
WEIGHT = "*FIX\nbase, ALL\nleft, X\n*GRAVITY\n0, -1"
# A block of four by six cells that its base carries to the right, through the boxes of the ranks.
CARRIED = "*FIX\nbase, Y\n*PRESCRIBE\nbase, X, {way}\n*GRAVITY\n0, -1"


def plane(body: str, method: str = STANDARD, phase: str = WEIGHT, model: str = "PLANE STRAIN", more: str = "",
          steps: int = 5) -> str:  # fmt: skip
    """An elastic body on a grid of 12 by 8 cells of a quarter, with histories of a tracer, a point, a reaction, a volume."""
    return f"""*HEADING
A body that ranks share.
*UNITS, LENGTH=m, FORCE=kN
*MODEL, TYPE={model}
*GRID, ELEMENT=QUAD4
X, 0, 3, 12
Y, 0, 2, 8
*NSET, NSET=base, PLANE=Y
0
*NSET, NSET=left, PLANE=X
0
*MATERIAL, NAME=soil
*ELASTIC
200, 0.3
*UNIT WEIGHT
10
*BODY, NAME=body, MATERIAL=soil, SHAPE=BOX
{body}
*POINTS, BODY=body, PER ELEMENT=4
*METHOD, {method}
*HISTORY, NAME=top, QUANTITY=DISPLACEMENT, COMPONENT=Y
0.9, 1.3
*HISTORY, NAME=stress, QUANTITY=STRESS, COMPONENT=YY
0.6, 0.3
*HISTORY, NAME=base, QUANTITY=REACTION, COMPONENT=Y, NSET=base
*HISTORY, NAME=volume, QUANTITY=VOLUME
*HISTORY, NAME=front, QUANTITY=RUNOUT, COMPONENT=X
{more}*PHASE, NAME=weight
{phase}
*CONTROLS, STEPS={steps}, TOLERANCE=1E-8
*END PHASE
"""


def agrees(place: Place, name: str, deck: str, ranks: tuple[int, ...], bound: float) -> None:
    """The curves of some numbers of ranks are those of one process."""
    alone = place.run("qsmpm", deck, f"{name}-alone")
    for n in ranks:
        shared = place.run("qsmpm-mpi", deck, f"{name}-{n}", ranks=n)
        apart = distance(alone, shared)
        expect(apart <= bound, f"{name}: {n} ranks {apart:.1e} from one process, bound {bound:.0e}")


def elastic_bodies(place: Place) -> None:
    """2 and 3 ranks give the curves of one process where nothing yields: splines, rings, space; seven: loaded_surfaces."""
    for name, ranks in (("SPLINE2", 3), ("SPLINE3", 2)):
        method = f"BASIS={name}, INTEGRATION=POINTS, KINEMATICS=LOGARITHMIC"
        agrees(place, name.lower(), plane("0, 2, 0, 1.5", method), (ranks,), ELASTIC)
    agrees(place, "ring", plane("0.5, 2, 0, 1.5", model="AXISYMMETRIC"), (2,), ELASTIC)
    agrees(place, "space", cut(4, 0.3, 2.0, 1, strength=""), (3,), ELASTIC)


def more_elastic_bodies(place: Place) -> None:
    """The same on 2, 3, 4 and 7 ranks, with ghost faces too."""
    for basis in ("STANDARD", "GIMP", "SPLINE2", "SPLINE3"):
        method = f"BASIS={basis}, INTEGRATION=POINTS, KINEMATICS=LOGARITHMIC"
        agrees(place, basis.lower(), plane("0, 2, 0, 1.5", method), (2, 3, 4, 7), ELASTIC)
    agrees(place, "ghost", plane("0, 2, 0, 1.4", STANDARD + ", STABILISATION=GHOST"), (2, 3, 4, 7), ELASTIC)
    agrees(place, "ring", plane("0.5, 2, 0, 1.5", model="AXISYMMETRIC"), (2, 3, 4, 7), ELASTIC)
    agrees(place, "space", cut(6, 0.3, 2.0, 2, strength=""), (2, 3, 4, 7), ELASTIC)


def failing_bodies(place: Place) -> None:
    """A slope that yields, with cells and ghost faces, keeps within ten times its tolerance; cuts: solved_together."""
    agrees(place, "slope", slope(15), (3,), PLASTIC)


def together(place: Place, deck: str, ranks: tuple[int, ...]) -> Run:
    """The last of the runs of some numbers of ranks with PETSC, beside one process with MUMPS."""
    alone = place.run("qsmpm", deck.replace("{solver}", "MUMPS"), "mumps")
    for n in ranks:
        shared = place.run("qsmpm-mpi", deck.replace("{solver}", "PETSC"), f"petsc-{n}", ranks=n)
        expect(distance(alone, shared) <= PLASTIC, f"{n} ranks: {distance(alone, shared):.1e} from one process")
        expect(0 < shared.profile["most_sweeps"] <= 60, f"{n} ranks: {shared.profile['most_sweeps']} sweeps")
        expect("the first one solves" not in shared.log, shared.log)
    return shared


def solved_together(place: Place) -> None:
    """PETSC solves on all ranks together, takes few sweeps, repeats to the byte, and gives way to the first rank."""
    deck = cut(6, 0.3, 7.0, 2, solver="{solver}")
    shared = together(place, deck, (3,))
    again = place.run("qsmpm-mpi", deck.replace("{solver}", "PETSC"), "again", ranks=3)
    expect(again.curves == shared.curves, "other curves from the same ranks")
    stiff = cut(8, 0.49999999, 3.0, 1, strength="", solver="{solver}")
    stiff = stiff.replace("*UNIT WEIGHT", "*VOLUMETRIC LOCKING, TYPE=NONE\n*UNIT WEIGHT")
    alone = place.run("qsmpm", stiff.replace("{solver}", "MUMPS"), "stiff")
    shared = place.run("qsmpm-mpi", stiff.replace("{solver}", "PETSC"), "stiff-2", ranks=2)
    expect("does not precondition the equations" in shared.log, shared.log)
    expect(distance(alone, shared) <= PLASTIC, f"{distance(alone, shared):.1e} from one process")


def chosen_together(place: Place) -> None:
    """AUTO solves large equations in space on all ranks together, on the first one where soil nearly keeps its volume and where
    sweeps do not pay, in the rest of the run and in one that is continued."""
    drained = place.run("qsmpm-mpi", cut(26, 0.3, 3.0, 1), "drained", ranks=2, seconds=300)
    expect(drained.profile["sweeps"] > 0 and "the first one solves" not in drained.log, drained.log)
    stiff = [place.run("qsmpm-mpi", cut(14, 0.495, 2.0, 1, solver=solver), f"stiff-{solver}", ranks=2) for solver in ("AUTO", "MUMPS")]
    expect(stiff[0].curves == stiff[1].curves, "AUTO is not MUMPS with soil that nearly keeps its volume")
    deck = cut(14, 0.48, 7.0, 7, restart="*RESTART, EVERY=1\n")
    deck += deck[deck.index("*PHASE"):].replace("NAME=gravity", "NAME=hold").replace("STEPS=7", "STEPS=8")
    alone = place.run("qsmpm", deck, "alone", seconds=300)
    through = place.run("qsmpm-mpi", deck, "through", ranks=2, seconds=300)
    expect(through.log.count("the first one solves") == 1, through.log)
    expect(distance(alone, through) <= PLASTIC, f"{distance(alone, through):.1e} from one process")
    part = interrupted(place, deck, 2, 9)
    expect("the first one solves" in part.log and len(part.rows()) < len(through.rows()), "it was stopped too early or too late")
    rest = place.run("qsmpm-mpi", deck, "long", ranks=2, seconds=300, restart=part.folder / "restart.h5")
    expect(through.curves == rest.curves, f"{through.rows()[-1]}\n{rest.rows()[-1]}")


def more_solved_together(place: Place) -> None:
    """PETSC on 2, 3 and 4 ranks of a larger cut, and on a slope in the plane; MUMPS on the cut and the slope."""
    agrees(place, "slope", slope(15), (2, 4), PLASTIC)
    agrees(place, "cut", cut(6, 0.3, 7.0, 3), (3,), PLASTIC)
    together(place, cut(8, 0.3, 7.0, 3, solver="{solver}"), (2, 3, 4))
    alone = place.run("qsmpm", slope(10), "plane")
    shared = place.run("qsmpm-mpi", slope(10).replace("*METHOD", "*SOLVER, TYPE=PETSC\n*METHOD"), "plane-3", ranks=3)
    expect(distance(alone, shared) <= PLASTIC, f"slope: {distance(alone, shared):.1e} from one process")


def slope(factor: int) -> str:
    """The first steps of the slope on a grid."""
    return shortened("slope_grid.inp", factor).replace("*SOLVER, TYPE={solver}\n", "")


def carried_block(place: Place) -> None:
    """A block with a loaded surface that rides through the boxes of four ranks: no point is lost, nor is one where a rank has
    none of its own."""
    deck = plane("0, 1, 0, 1.5", phase=CARRIED.replace("{way}", "1.6") + "\n*PRESSURE, SURFACE=top\n3", steps=16,
                 more="*SURFACE, NAME=top, TYPE=OUTLINE, BODY=body, BOX\n0, 1, 1.5, 1.5\n*FIELD, EVERY=4\n")  # fmt: skip
    agrees(place, "block", deck, (4,), ELASTIC)


def repeats(place: Place) -> None:
    """The same ranks give the same bytes of curves, results and restart file."""
    deck = plane("0, 1, 0, 1.5", phase=CARRIED.replace("{way}", "0.8"), steps=8, more="*RESTART, EVERY=4\n")
    first, other = (place.run("qsmpm-mpi", deck, name, ranks=3) for name in ("first", "other"))
    expect_same_bytes(first, other)


def is_alive(process: int) -> bool:
    """Whether a process runs; one that has ended and was not waited for does not."""
    try:
        return ") Z" not in pathlib.Path(f"/proc/{process}/stat").read_text()
    except OSError:
        return False


def ten_repeats(place: Place) -> None:
    """Ten runs on four ranks give the same bytes: solved by PETSc on all of them, and on the first one."""
    for solver in ("PETSC", "MUMPS"):
        deck = cut(8, 0.3, 7.0, 3, solver=solver, restart="*RESTART, EVERY=2\n")
        first = place.run("qsmpm-mpi", deck, f"{solver}-0", ranks=4)
        for i in range(1, 10):
            expect_same_bytes(first, place.run("qsmpm-mpi", deck, f"{solver}-{i}", ranks=4))


def end_one(place: Place, deck: str, ranks: int, rows: int, by: signal.Signals, restart: bool = False, victim: int = -1,
            after: float = 0.0, begun: str = "") -> Run:  # fmt: skip
    """Run a deck into the folder `long`, send a signal to one of its processes, the last one, when the curves have some rows and a
    file of some name is there, or some seconds later; all end in time."""
    path, folder = place.work / "long.inp", place.work / "long"
    path.write_text(deck)
    words = ["mpirun", "-n", str(ranks), str(place.build / "qsmpm-mpi"), "run", str(path), "--out", str(folder), "--quiet"]
    words += ["--restart", str(folder / "restart.h5")] if restart else []
    job = subprocess.Popen(words, env=ENVIRONMENT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        while not (folder / "curves.csv").is_file() or (folder / "curves.csv").read_text().count("\n") < rows:
            expect(job.poll() is None, f"the run has ended with {job.returncode}")
            time.sleep(0.02)
        found = subprocess.run(["pgrep", "-P", str(job.pid), "qsmpm-mpi"], capture_output=True, text=True, check=True)
        processes = sorted(int(p) for p in found.stdout.split())
        while begun and not (folder / begun).exists():
            expect(job.poll() is None, f"the run has ended with {job.returncode}")
        time.sleep(after)
        os.kill(processes[victim], by)
        told = time.monotonic()
        code = job.wait(timeout=SECONDS)
        while any(is_alive(p) for p in processes):
            expect(time.monotonic() < told + SECONDS, "processes are left")
            time.sleep(0.02)
    finally:
        if job.poll() is None:
            job.kill()
    return Run(folder, code, "", 0.0)


def interrupted(place: Place, deck: str, ranks: int, rows: int, restart: bool = False) -> Run:
    """Ask a run to stop by a signal to one of its processes."""
    run = end_one(place, deck, ranks, rows, signal.SIGTERM, restart)
    expect(run.code == 128 + signal.SIGTERM, f"exit code {run.code}")
    expect((run.folder / "restart.h5").is_file() and "stopped on request" in run.log, "no state")
    return run


def stopped_and_continued(place: Place) -> None:
    """A signal to one of three ranks ends all in ten seconds; one process and two ranks go on as if nothing had been."""
    goes_on(place, (3, 1, 2))


def stopped_and_continued_again(place: Place) -> None:
    """Four ranks, two, one and four again, each stopped by a signal to one of them, give the curves of one process."""
    goes_on(place, (4, 2, 1, 4))


def goes_on(place: Place, numbers: tuple[int, ...]) -> None:
    """A run is stopped and continued by some numbers of ranks."""
    deck = plane("0, 1, 0, 1.5", phase=CARRIED.replace("{way}", "1.2"), steps=300)
    part = interrupted(place, deck, numbers[0], 10)
    for ranks in numbers[1:]:
        part = interrupted(place, deck, ranks, len(part.rows()) + 10, restart=True)
    through = place.stop("qsmpm", deck, "through", len(part.rows()) + 1)
    apart = distance(through, part, len(part.rows()))
    expect(apart < 1.0e-9, f"{apart:.1e} from a run that went through")


def planned(place: Place) -> None:
    """`qsmpm plan --ranks` tells how a run shares its points, and what cannot be shared."""
    run = place.run("qsmpm-mpi", slope(1), "planned", ranks=2)
    words: list[str | pathlib.Path] = [place.build / "qsmpm", "plan", place.work / "planned.inp", "--json", "--ranks", "2"]
    plan = json.loads(subprocess.run(words, capture_output=True, check=True).stdout)["2 processes"]
    told = re.search(r"shared by 2 processes: imbalance (\S+) of their points, (\S+) copies of a point", run.log)
    expect(told is not None, "the log does not tell how points are shared")
    assert told is not None
    for name, figure in (("imbalance", told[1]), ("copies of a point", told[2])):
        expect(abs(float(plan[name]) - float(figure)) < 0.006, f"{name}: planned {plan[name]}, {figure} in the run")
    words[2] = TOP / "input" / "footing.inp"
    plan = json.loads(subprocess.run(words, capture_output=True, check=True).stdout)["2 processes"]
    expect("*MOVING MESH" in plan["not shared"], f"a plan that should name the moving mesh: {plan}")


def planned_memory(place: Place) -> None:
    """`qsmpm plan --ranks` tells the memory of a process within a factor of 1.5."""
    run = place.run("qsmpm-mpi", cut(20, 0.3, 2.0, 1, solver="PETSC"), "memory", ranks=2, seconds=300)
    words: list[str | pathlib.Path] = [place.build / "qsmpm-mpi", "plan", place.work / "memory.inp", "--json", "--ranks", "2"]
    plan = json.loads(subprocess.run(words, capture_output=True, check=True).stdout)["2 processes"]
    (planned,) = (float(figure) for figure in re.findall(r"(\S+) MB", plan["memory of a process"]))
    used = run.profile["peak_memory_bytes"] / 1e6
    expect(planned / 1.5 <= used <= 1.5 * planned, f"{used:.0f} MB, planned {planned:.0f}")


def refused(place: Place) -> None:
    """What ranks cannot share is named before anything is computed or written, once."""
    deck = (TOP / "input/footing.inp").read_text()
    run = place.run("qsmpm-mpi", deck, "footing", ranks=2, code=2)
    expect("2 processes cannot share this deck yet" in run.said and "*MOVING MESH" in run.said, run.said)
    expect(run.said.count("cannot share") == 1 and not run.folder.exists(), run.said)
    small = plane("0, 0.25, 0, 0.25").replace("0.9, 1.3", "0.1, 0.1").replace("0.6, 0.3", "0.1, 0.1")
    few = place.run("qsmpm-mpi", small, "few", ranks=3, code=2)
    expect("too few cells" in few.said, few.said)


def moved(deck: str) -> str:
    """The histories of a body at the end of the grid."""
    return deck.replace("0.9, 1.3", "2.9, 1.3").replace("0.6, 0.3", "2.6, 0.3")


def failures(place: Place) -> None:
    """A lost equilibrium, and points that leave the grid on one rank, end all with the code of one process, in order."""
    away = moved(plane("2, 3, 0, 1.5", phase=CARRIED.replace("{way}", "9"), steps=20))
    away = away.replace("*CONTROLS, ", "*CONTROLS, SMALLEST STEP=0.5, ")
    for name, deck, ranks in (("lost", LOST, 2), ("away", away, 2)):
        alone = place.run("qsmpm", deck, f"{name}-alone", code=None)
        shared = place.run("qsmpm-mpi", deck, name, ranks=ranks, code=alone.code)
        expect(alone.code not in (0, None), f"{name}: {alone.code}")
        expect("without calling" not in shared.said, shared.said)
        kept = [(run.folder / "restart.h5").is_file() for run in (alone, shared)]
        expect(kept[0] == kept[1], f"{name}: a state was kept by {kept}")
        last = [run.log.splitlines()[-1] for run in (alone, shared)]
        expect(last[0].split(":")[:3] == last[1].split(":")[:3], "\n".join(last))


CHECKS: list[Check] = [elastic_bodies, failing_bodies, solved_together, carried_block, repeats, stopped_and_continued, planned, refused,
                       failures]  # fmt: skip
LONG_CHECKS: list[Check] = [more_elastic_bodies, more_solved_together, stopped_and_continued_again, ten_repeats, chosen_together, planned_memory]
