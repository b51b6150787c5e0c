"""Checks of several ranks against one process: steps as long as their error allows, tractions on material points."""

from __future__ import annotations

from many_ranks import STANDARD, WEIGHT, agrees, interrupted, plane
from shared_scenes import LOADED, LOADS, SAME, carried
from support import Check, Place, Run, distance, expect

JAUMANN = STANDARD.replace("LOGARITHMIC", "JAUMANN")
# What an iterated solution leaves of the position's error, where PETSC solves and its sweeps are others.
NEAR = 1.0e-3


PRESSED = WEIGHT + "\n*PRESSURE, SURFACE=top\n1"
SHEARED = "*FIX\nbase, ALL\nceiling, Y\n*PRESCRIBE\nceiling, X, 0.015\n*GRAVITY\n0, -1"


def yielding(method: str = JAUMANN, solver: str = "", phase: str = PRESSED, error: str = "1E-3") -> str:
    """A block that yields under a pressure, in steps that their error cuts and lets grow."""
    deck = plane("0, 2, 0, 1.5", method, phase, more=LOADED)
    deck = deck.replace("*UNIT WEIGHT", "*MOHR COULOMB\n3.3, 25, 5\n*UNIT WEIGHT").replace("*METHOD", solver + "*METHOD")
    deck = deck.replace("*MATERIAL", "*NSET, NSET=ceiling, PLANE=Y\n1.5\n*MATERIAL")
    return deck.replace("STEPS=5, TOLERANCE=1E-8", f"STEPS=4, STEP ERROR={error}, TOLERANCE=1E-9, STABILISATION SHARE=1")


def column(run: Run, name: str) -> list[float]:
    """Values of a column of the curves."""
    place = run.curves.decode().splitlines()[0].split(",").index(name)
    return [row[place] for row in run.rows()]


def expect_same_steps(alone: Run, shared: Run, bound: float) -> None:
    """Curves and errors of the steps are those of one process, which cut some."""
    expect(distance(alone, shared) <= bound, f"{distance(alone, shared):.1e} from one process")
    errors = [column(run, "step_error") for run in (alone, shared)]
    apart = max(abs(a - b) for a, b in zip(*errors, strict=True)) / max(errors[0])
    expect(apart <= bound and len(errors[0]) > 8, f"{len(errors[0])} steps, errors {apart:.1e} from one process")


def step_errors(place: Place) -> None:
    """Steps are as long by their error as those of one process: at points, in cells, solved by PETSC and in single precision."""
    cells = JAUMANN.replace("INTEGRATION=POINTS", "INTEGRATION=CELL")
    for name, deck, program, bound in (
        ("points", yielding(), "qsmpm", SAME),
        ("cells", yielding(cells, "*SOLVER, TYPE=MUMPS, PRECISION=SINGLE\n"), "qsmpm", SAME),
        ("petsc", yielding(solver="*SOLVER, TYPE=PETSC\n"), "qsmpm-mpi", NEAR),
    ):
        alone = place.run(program, deck, name)
        for ranks in (1, 2, 3):
            expect_same_steps(alone, place.run("qsmpm-mpi", deck, f"{name}-{ranks}", ranks=ranks), bound)


def sheared_by_errors(place: Place) -> None:
    """Soil that is sheared between walls, where the stresses err more than the places; a run that ranks leave is gone on with by others."""
    deck = yielding(phase=SHEARED)
    alone = place.run("qsmpm", deck, "alone")
    done = len(interrupted(place, deck, 3, 20).rows())
    expect(done < len(alone.rows()), "it was not stopped")
    interrupted(place, deck, 2, done + 20, restart=True)
    rest = place.run("qsmpm-mpi", deck, "long", ranks=1, restart=place.work / "long" / "restart.h5")
    expect_same_steps(alone, rest, SAME)


def on_points(deck: str) -> str:
    """The tractions of a deck on its outermost material points."""
    return deck.replace("*PRESSURE, SURFACE=top\n3", "*TRACTION, SURFACE=top\n0.5, -3").replace("SURFACE=top\n", "SURFACE=top, CARRIER=POINTS\n")


def carrying_points(place: Place) -> None:
    """Points that carry tractions: in boxes, rings, domains and cells, through the boxes of ranks, in two phases; ranks leave, others go on."""
    agrees(place, "loads", on_points(plane("0, 2, 0, 1.5", phase=LOADS, more=LOADED)), (2, 3, 7), SAME)
    agrees(place, "ring", on_points(plane("0.5, 2, 0, 1.5", phase=LOADS, more=LOADED, model="AXISYMMETRIC")), (3,), SAME)
    for basis, ways in (("GIMP", "POINTS"), ("SPLINE2G", "CELL"), ("SPLINE3", "POINTS")):
        method = f"BASIS={basis}, INTEGRATION={ways}, KINEMATICS=LOGARITHMIC"
        agrees(place, basis.lower(), on_points(plane("0, 2, 0, 1.5", method, LOADS, more=LOADED)), (2, 4), SAME)
    more = "*PHASE, NAME=more\n*TRACTION, SURFACE=top, CARRIER=POINTS\n-2, -5\n*CONTROLS, STEPS=3, TOLERANCE=1E-9\n*END PHASE\n"
    agrees(place, "carried", on_points(carried("1.6")) + more, (2, 3, 4), SAME)
    deck = on_points(carried("1.2").replace("STEPS=16", "STEPS=200"))
    alone = place.run("qsmpm", deck, "alone")
    done = len(interrupted(place, deck, 3, 20).rows())
    interrupted(place, deck, 2, done + 20, restart=True)
    rest = place.run("qsmpm-mpi", deck, "long", ranks=4, restart=place.work / "long" / "restart.h5")
    expect(distance(alone, rest) <= SAME, f"{distance(alone, rest):.1e} from a run that went through")


STUCK = """*MODEL, TYPE=PLANE STRAIN
*GRID, ELEMENT=QUAD4
X, 0, 2.1, 21
Y, 0, 2, 20
*NSET, NSET=base, PLANE=Y
0
*MATERIAL, NAME=clay
*ELASTIC
1200, 0.4
*BODY, NAME=ground, MATERIAL=clay, SHAPE=BOX
0, 2.1, 0, 1.6
*METHOD, BASIS=SPLINE2, INTEGRATION=POINTS
*RIGID BODY, NAME=bar, SHAPE=CIRCLE, IN PLACE=YES
1.08, 1.1, 0.22
*CONTACT, BODY=bar, ON=BODY, TENSION=YES, ADHESION=1
*HISTORY, NAME=fx, QUANTITY=CONTACT FORCE, COMPONENT=X, BODY=bar
*HISTORY, NAME=fy, QUANTITY=CONTACT FORCE, COMPONENT=Y, BODY=bar
*PHASE, NAME=move
*FIX
base, ALL
*MOVE, BODY=bar
0.012, -0.02
*CONTROLS, STEPS=2, TOLERANCE=1E-9
*END PHASE
"""


def patches_on_bodies(place: Place) -> None:
    """Every process has the patches whole that act on its nodes, however many share the body; each profile has the keys of one process."""
    alone = place.run("qsmpm", STUCK, "alone")
    for ranks in (3, 5):
        shared = place.run("qsmpm-mpi", STUCK, f"ranks-{ranks}", ranks=ranks)
        expect(distance(alone, shared) <= SAME, f"{ranks} ranks: {distance(alone, shared):.1e} from one process")
        expect(keys(shared.profile) == keys(alone.profile), f"{ranks} ranks: {sorted(keys(shared.profile) ^ keys(alone.profile))}")


def keys(profile: dict) -> set[str]:
    """Keys of a profile and of its parts."""
    return {*profile, *(f"{part}.{key}" for part, of in profile["parts"].items() for key in of)}


CHECKS: list[Check] = [patches_on_bodies]
LONG_CHECKS: list[Check] = [step_errors, sheared_by_errors, carrying_points]
