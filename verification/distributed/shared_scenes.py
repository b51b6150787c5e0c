"""Checks of several ranks against one process: surfaces, factors of safety, stages, pore water, contact, warnings."""

from __future__ import annotations

import shutil
import signal

from joint_files import expect_same_points
from many_ranks import CARRIED, STANDARD, WEIGHT, agrees, end_one, plane
from support import TOP, Check, Place, Run, distance, expect, expect_same_bytes, pit_on_squares, upset_exactly

from qsmpm_verify.results import read_mechanism  # noqa: E402  (support.py has set the path)

# Relative difference of curves from those of one process: rounding, where the iterations are the same.
SAME, LOST = 1.0e-9, 0.1
# A block under a load that leans, with its reactions; its surfaces lie in several boxes.
LOADED = """*SURFACE, NAME=top, TYPE=OUTLINE, BODY=body, BOX
0, 2, 1.5, 1.5
*SURFACE, NAME=side, TYPE=OUTLINE, BODY=body, BOX
2, 2, 0, 1.5
"""
LOADS = "*FIX\nbase, ALL\nleft, X\n*TRACTION, SURFACE=top\n1, -3\n*PRESSURE, SURFACE=side\n4"
SLOPE = """*HEADING
A slope whose strength is lowered until it fails.
*UNITS, LENGTH=m, FORCE=kN
*MODEL, TYPE=PLANE STRAIN
*GRID, ELEMENT=QUAD4
X, 0, 4, 16
Y, 0, 1, 4
*NSET, NSET=base, PLANE=Y
0
*NSET, NSET=left, PLANE=X
0
*MATERIAL, NAME=soil
*ELASTIC
1E4, 0.33
*MOHR COULOMB
0.7, 25, 25
*UNIT WEIGHT
15
*BODY, NAME=slope, MATERIAL=soil, SHAPE=POLYGON
0, 0
2.5, 0
1.5, 1
0, 1
*POINTS, BODY=slope, PER ELEMENT=4
*METHOD, {method}
*HISTORY, NAME=crest, QUANTITY=DISPLACEMENT, COMPONENT=Y
1.5, 1
*PHASE, NAME=built
*FIX
base, ALL
left, X
*GRAVITY
0, -1
*CONTROLS, STEPS=2, STABILISATION FADE=0.1
*END PHASE
*PHASE, NAME=factor, TYPE=SAFETY
*SAFETY, TOLERANCE=0.05, {words}
*CONTROLS, STEPS=3, STABILISATION SHARE=1
*END PHASE
"""


def carried(way: str) -> str:
    """A block under a pressure that rides through the boxes of the ranks."""
    surfaces = LOADED.replace("0, 2, 1.5", "0, 1, 1.5").replace("2, 2, 0", "1, 1, 0")
    return plane("0, 1, 0, 1.5", phase=CARRIED.replace("{way}", way) + "\n*PRESSURE, SURFACE=top\n3", steps=16,
                 more=surfaces + "*FIELD, EVERY=5\n")  # fmt: skip


def loaded_surfaces(place: Place) -> None:
    """Tractions and pressures that follow on seven ranks; one that rides from rank to rank: carried_block."""
    agrees(place, "loads", plane("0, 2, 0, 1.5", phase=LOADS, more=LOADED), (7,), SAME)


def more_loaded_surfaces(place: Place) -> None:
    """The same in rings and with domains, on 2, 3 and 4 ranks, and to the byte on the same ranks again."""
    agrees(place, "loads", plane("0, 2, 0, 1.5", phase=LOADS, more=LOADED), (2, 3, 4), SAME)
    agrees(place, "ring", plane("0.5, 2, 0, 1.5", phase=LOADS, more=LOADED, model="AXISYMMETRIC"), (3,), SAME)
    domains = "BASIS=SPLINE2G, INTEGRATION=POINTS, KINEMATICS=LOGARITHMIC"
    agrees(place, "domains", plane("0, 2, 0, 1.5", domains, LOADS, more=LOADED), (4,), SAME)
    agrees(place, "carried", carried("1.6"), (3, 4), SAME)
    first, other = (place.run("qsmpm-mpi", carried("1.6"), name, ranks=4) for name in ("first", "other"))
    expect(first.curves == other.curves, "other curves from the same ranks")
    deck = (TOP / "verification/cases/decks/support_free.inp").read_text()
    agrees(place, "freed", deck, (3, 5, 7), SAME)


def freed_supports(place: Place) -> None:
    """Walls that hold a cut and are freed: their reactions count once, and what they carried is lowered on all ranks."""
    deck = (TOP / "verification/cases/decks/support_free.inp").read_text()
    for old, new in (("X, 0, 20, 40\nY, -10, 1, 22", "X, 0, 20, 20\nY, -10, 1, 11"), ("STEPS=10", "STEPS=3"), ("ELEMENT=9", "ELEMENT=4")):
        deck = deck.replace(old, new)
    agrees(place, "freed", deck, (3,), SAME)


def factor_of_safety(place: Place) -> None:
    """A search for a factor of safety: the bracket of one process, and its mechanism."""
    domains = "BASIS=SPLINE2G, INTEGRATION=CELL, KINEMATICS=LOGARITHMIC"
    finds_bracket(place, SLOPE.format(method=domains, words="GEOMETRY=FIXED"), 2)


def runout(place: Place) -> None:
    """A search whose places follow, with the run-out behind it."""
    finds_bracket(place, SLOPE.format(method=STANDARD, words="GEOMETRY=MOVING, RUNOUT=1.7"), 3)


def finds_bracket(place: Place, deck: str, ranks: int) -> None:
    """Curves, bracket and pictures of one process from several."""
    alone = place.run("qsmpm", deck, "alone")
    shared = place.run("qsmpm-mpi", deck, "shared", ranks=ranks)
    apart = distance(alone, shared)
    expect(apart <= SAME, f"{apart:.1e} from one process")
    found = [(run.folder / "safety.json").read_text() for run in (alone, shared)]
    expect(found[0] == found[1] and '"lost": 0' not in found[0], f"{found}")
    one, other = (read_mechanism(run.folder) for run in (alone, shared))
    # A try that is lost ends in no equilibrium: the rounding of sums grows with each of its sub-steps, 3.5e-2 seen.
    expect_same_points(one.fields, other.fields, "mechanism", near=LOST)
    pictures = sorted(p.name for p in shared.folder.glob("mechanism*"))
    expect(pictures == ["mechanism_mesh_000002.vtu", "mechanism_points_000002.vtu"], f"{pictures}")


def pit(steps: int) -> str:
    """The pit of input/ on coarse cells, with so many steps of its second stage."""
    deck = pit_on_squares().replace("CONTROLS, ", "CONTROLS, TOLERANCE=1E-9, ")
    for old, new in ((" X, 0, 12, 24\n Y, 0, 8, 16", " X, 0, 12, 12\n Y, 0, 8, 8"), ("4.5", "5"), ("3.5", "4"), ("STEPS=4", "STEPS=2"),
                     ("STEPS=6", f"STEPS={steps}")):  # fmt: skip
        deck = deck.replace(old, new)
    return deck


def stages(place: Place) -> None:
    """Bodies that come, go and change, with feet, tracers that wait and a loaded surface: a pit."""
    agrees(place, "pit", pit(2), (3,), SAME)


def more_stages(place: Place) -> None:
    """The pit with all its steps, and a bank in lifts."""
    agrees(place, "pit", pit(6), (2, 4), SAME)
    agrees(place, "lifts", (TOP / "verification/cases/decks/stages_lifts_5.inp").read_text(), (2, 4), SAME)


def continued_stages(place: Place) -> None:
    """A run that is killed while a body is taken out and another one waits goes on from its file: on as many ranks to the same
    bytes, on two and on one to the same curves."""
    deck = pit(40).replace("*PHASE", "*RESTART, EVERY=1\n*PHASE", 1)
    whole = place.run("qsmpm-mpi", deck, "whole", ranks=3)
    run = end_one(place, deck, 3, 12, signal.SIGKILL)
    expect(len(run.rows()) < 40, "it was not killed in its second stage")
    shutil.copytree(run.folder, place.work / "kept")
    expect_same_bytes(whole, place.run("qsmpm-mpi", deck, "long", ranks=3, restart=run.folder / "restart.h5"))
    for ranks in (2, 1):
        run = Run(place.work / f"on-{ranks}", None, "", 0.0)
        shutil.copytree(place.work / "kept", run.folder)
        run = place.run("qsmpm-mpi", deck, run.folder.name, ranks=ranks, restart=run.folder / "restart.h5")
        expect(distance(whole, run) <= SAME, f"{ranks} ranks: {distance(whole, run):.1e} from a run that went through")


def pore_water(place: Place) -> None:
    """A slope below its water level, and soil that is loaded undrained and then drained."""
    for name, ranks in (("water_slope", 2), ("undrained_column", 2)):
        deck = (TOP / f"verification/cases/decks/{name}.inp").read_text()
        agrees(place, name, deck.replace("STRESS, COMPONENT=XX", "PORE PRESSURE"), (ranks,), SAME)


def rigid_bodies(place: Place) -> None:
    """Plates that pull, shear and squeeze soil: patches of contact across boxes, forces counted once, surfaces that are refined."""
    for name, ranks in (("contact_bar", 3), ("contact_upset", 2)):
        deck = (TOP / f"verification/cases/decks/{name}.inp").read_text().replace("STEPS=10", "STEPS=4")
        agrees(place, name, deck.replace("-0.95\n*CONTROLS, STEPS=38", "-0.25\n*CONTROLS, STEPS=10"), (ranks,), SAME)


def pushed_pipe(phase: str = "", strength: str = "") -> str:
    """A pipe that is pushed into soil that comes to lie against it, on coarse cells, and what is done to it then."""
    deck = (TOP / "input/pipe.inp").read_text().replace("10, 0, 0\n", strength).replace("*FIELD, EVERY=10\n", "")
    deck = deck if strength else deck.replace("*MOHR COULOMB\n", "")
    for old, new in (("3.0, 30", "3.0, 15"), ("3.3, 33", "3.2, 16"), ("0, 3.0, 0, 2.5", "0, 3.0, 0, 2.4"),
                     ("0, 3.0, 0.5", "0, 2.9, 0.5"), ("0, -0.5", "0, -0.1"), ("STEPS=50", "STEPS=5"), ("1e-4", "1e-9")):  # fmt: skip
        deck = deck.replace(old, new)
    return deck + phase


LOADED_PIPE = """*PHASE, NAME=load
*FIX
axis, X
side, X
base, ALL
*LOAD, BODY=pipe, COMPONENT=Y
-80
*CONTROLS, STEPS=2, TOLERANCE=1e-9
*END PHASE
"""


def on_points(name: str) -> str:
    """A scene of a loaded body, integrated at its points, to small residuals."""
    deck = (TOP / f"verification/cases/decks/{name}.inp").read_text().replace("INTEGRATION=CELL", "INTEGRATION=POINTS")
    return deck.replace("2.1", "2").replace("1e-6", "1e-9")


def loaded_bodies(place: Place) -> None:
    """Contact on a pipe, then its load; a plate that turns on two columns: bodies with unknowns of their own on 2 ranks."""
    agrees(place, "pipe", pushed_pipe(LOADED_PIPE), (2,), SAME)
    agrees(place, "columns", on_points("contact_columns"), (2,), SAME)


def more_loaded_bodies(place: Place) -> None:
    """A strip that turns, soil that yields around a pipe and flows past a bar; a plate that is lifted off; PETSC gives its rows away."""
    agrees(place, "pipe", pushed_pipe(LOADED_PIPE), (3,), SAME)
    agrees(place, "upset", upset_exactly(), (3,), SAME)
    agrees(place, "strip", on_points("contact_strip_turned"), (2, 3), SAME)
    agrees(place, "yielding", pushed_pipe(strength="10, 0, 0\n"), (2, 4), SAME)
    # The first four of its steps, as long as it has them: longer ones are cut where several ways lead on.
    bar = (TOP / "verification/cases/decks/contact_tbar.inp").read_text().replace("STEPS=10", "STEPS=4").replace("\n0.004, 0", "\n0.0016, 0")
    agrees(place, "bar", bar.replace("1e-4", "1e-9"), (2, 4), SAME)
    alone = place.run("qsmpm", pushed_pipe(LOADED_PIPE), "alone")
    shared = place.run("qsmpm-mpi", pushed_pipe(LOADED_PIPE).replace("*METHOD", "*SOLVER, TYPE=PETSC\n*METHOD"), "petsc", ranks=3)
    expect(distance(alone, shared) <= SAME, f"{distance(alone, shared):.1e} from one process")
    expect(shared.log.count("rigid bodies that are loaded have equations that run through all") == 1, shared.log)
    lifted = on_points("contact_columns").replace("-100, 1.8", "100, 1.8")
    said = [place.run(program, lifted, name, ranks=ranks, code=None).log for program, name, ranks in
            (("qsmpm", "lifted-alone", 0), ("qsmpm-mpi", "lifted", 3))]  # fmt: skip
    expect(all("is loaded but not in contact" in log for log in said), "\n".join(said))


def warnings(place: Place) -> None:
    """Cut cells are warned of, and a piece that hangs on nothing is named, in the words of one process."""
    cut = plane("0, 2, 0, 1.4", "BASIS=SPLINE2, INTEGRATION=POINTS, KINEMATICS=LOGARITHMIC")
    loose = "*BODY, NAME=loose, MATERIAL=soil, SHAPE=BOX\n0.5, 1.5, 1.75, 2\n*POINTS, BODY=loose, PER ELEMENT=4\n"
    apart = plane("0, 2, 0, 1", phase=WEIGHT, more=loose).replace("0.9, 1.3", "0.9, 0.9")
    for name, deck, code, words in (("cut", cut, 0, "warning: the integration error of cells cut by a body is"),
                                    ("apart", apart, 5, "is not supported by any constraint")):  # fmt: skip
        said = []
        for run in (place.run("qsmpm", deck, f"{name}-alone", code=code),
                    place.run("qsmpm-mpi", deck, name, ranks=2, code=code)):  # fmt: skip
            said.append([line for line in run.log.splitlines() if words in line or line.startswith("warning")])
        expect(said[0] == said[1] and any(words in line for line in said[0]), f"{name}: {said}")


def stabilised(place: Place, basis: str, ways: str, ranks: int, steps: int = 2) -> None:
    """A body with cut or boundary cells: curves of one process, and its shares of the stabilisation."""
    top = 1.5 if "CELL" in ways else 1.4
    deck = plane(f"0, 2, 0, {top}", f"BASIS={basis}, KINEMATICS=LOGARITHMIC, {ways}", steps=steps)
    name = f"{basis}-{ways}-{ranks}".replace(", ", "-").lower()
    alone, shared = place.run("qsmpm", deck, f"{name}-alone"), place.run("qsmpm-mpi", deck, name, ranks=ranks)
    column = alone.curves.decode().splitlines()[0].split(",").index("stabilisation_share")
    shares = [[row[column] for row in run.rows()] for run in (alone, shared)]
    # Cells that are full have nothing to stabilise.
    apart = max(distance(alone, shared), *(abs(a - b) / (max(shares[0]) or 1.0) for a, b in zip(*shares, strict=True)))
    expect(apart <= SAME, f"{name}: {apart:.1e} from one process")


def rings(place: Place) -> None:
    """What ranks are told of cells and nodes around theirs: faces, roots and shares of the stabilisation are those of one process."""
    stabilised(place, "GIMP", "INTEGRATION=POINTS, STABILISATION=BACKGROUND", 3)
    stabilised(place, "SPLINE2", "INTEGRATION=CELL, STABILISATION=GHOST", 3)


def more_rings(place: Place) -> None:
    """The same of all functions and integrations that ranks share, on 2, 3, 4 and 7 of them."""
    for basis in ("STANDARD", "GIMP", "SPLINE2", "SPLINE2G", "SPLINE3"):
        for ranks, ways in ((2, "CELL, STABILISATION=GHOST"), (3, "POINTS, STABILISATION=BACKGROUND"),
                            (4, "POINTS, STABILISATION=GHOST"), (7, "CELL, STABILISATION=GHOST")):  # fmt: skip
            stabilised(place, basis, f"INTEGRATION={ways}", ranks, steps=5)
    locked = plane("0, 2, 0, 1.4", "BASIS=GIMP, INTEGRATION=POINTS, KINEMATICS=LOGARITHMIC")
    agrees(place, "locked", locked.replace("*UNIT WEIGHT", "*VOLUMETRIC LOCKING, TYPE=UNIFORM PRESSURE\n*UNIT WEIGHT"), (2, 4), SAME)


CHECKS: list[Check] = [rings, loaded_surfaces, freed_supports, factor_of_safety, stages, pore_water, rigid_bodies, loaded_bodies,
                       warnings]  # fmt: skip
LONG_CHECKS: list[Check] = [continued_stages, more_stages, more_rings, more_loaded_surfaces, more_loaded_bodies, runout]
