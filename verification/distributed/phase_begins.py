"""Checks of what is divided from the start: building, the begin of phases with their initial stresses, ends that are kept."""

from __future__ import annotations

from many_ranks import CARRIED, ELASTIC, STANDARD, agrees, plane
from shared_scenes import SAME
from support import Check, Place, distance, expect

# Level ground at yield beside its surface, two layers, on cells that do not hold its stresses; then a load, and another one
# from the end of the first phase.
GROUND = """*HEADING
Ground at rest, and two ways on from there.
*UNITS, LENGTH=m, FORCE=kN
*MODEL, TYPE=PLANE STRAIN
*GRID, ELEMENT=QUAD4
X, 0, 3, 12
Y, 0, 2, 8
*NSET, NSET=base, PLANE=Y
0
*NSET, NSET=left, PLANE=X
0
*NSET, NSET=right, PLANE=X
3
*MATERIAL, NAME=soil
*ELASTIC
2000, 0.3
*MOHR COULOMB
1, 30, 0
*UNIT WEIGHT
18
*STRENGTH PROFILE
1.4, 1, 2
*MATERIAL, NAME=deep
*ELASTIC
5000, 0.25
*UNIT WEIGHT
20
*BODY, NAME=soil, MATERIAL=soil, SHAPE=BOX
0, 3, 0.7, 1.4
*BODY, NAME=deep, MATERIAL=deep, SHAPE=BOX
0, 3, 0, 0.7
*POINTS, BODY=soil, PER ELEMENT=4
*METHOD, {method}
*SURFACE, NAME=top, TYPE=OUTLINE, BODY=soil, BOX
0, 1, 1.4, 1.4
*HISTORY, NAME=top, QUANTITY=DISPLACEMENT, COMPONENT=Y
0.5, 1.4
*HISTORY, NAME=stress, QUANTITY=STRESS, COMPONENT=XX
1.6, 0.6
*HISTORY, NAME=base, QUANTITY=REACTION, COMPONENT=Y, NSET=base
*PHASE, NAME=rest
*INITIAL, TYPE=K0
1.4, 0.5
*FIX
base, ALL
left, X
right, X
*GRAVITY
0, -1
*CONTROLS, STEPS=1, TOLERANCE=1E-9, STABILISATION SHARE=1
*END PHASE
*PHASE, NAME=load
*TRACTION, SURFACE=top
0, -4
*CONTROLS, STEPS=2, TOLERANCE=1E-9, STABILISATION SHARE=1
*END PHASE
*PHASE, NAME=pull, PARENT=rest
*TRACTION, SURFACE=top
0, 2
*CONTROLS, STEPS=2, TOLERANCE=1E-9, STABILISATION SHARE=1
*END PHASE
"""


def rest_and_branches(place: Place) -> None:
    """K0 stresses that are corrected on 3 ranks, and phases from an end that is kept: one process's curves, and its words."""
    same_as_alone(place, "points", GROUND.format(method=STANDARD))


FREED = """*PHASE, NAME=freed
*FIX
left, FREE
*CONTROLS, STEPS=3, TOLERANCE=1E-8
*END PHASE
"""


def freed_fixity(place: Place) -> None:
    """What a fixity carried is lowered over the phase that frees it, also where the model is divided anew on the way."""
    agrees(place, "freed", plane("0, 2, 0, 1.5", steps=2, more="*RESTART, EVERY=1\n") + FREED, (2,), SAME)


def more_rests(place: Place) -> None:
    """The same with cells and smooth functions, and stresses that the soil does not bear."""
    gimp = GROUND.format(method="BASIS=GIMP, INTEGRATION=POINTS, KINEMATICS=LOGARITHMIC")
    same_as_alone(place, "gimp", gimp)
    beyond = GROUND.format(method=STANDARD).replace("1.4, 0.5", "1.4, 0.1").replace("*STRENGTH PROFILE\n1.4, 1, 2\n", "")
    runs = [place.run("qsmpm", beyond, "beyond-alone", code=3), place.run("qsmpm-mpi", beyond, "beyond-3", ranks=3, code=3)]
    said = [[line.split(", most at")[0] for line in run.log.splitlines() if "initial stress of" in line or "stopped" in line] for run in runs]
    expect(said[0] == said[1] and len(said[0]) > 2, f"exceed the strength: {said}")


def same_as_alone(place: Place, name: str, deck: str) -> None:
    """Curves of one process from three, and what the log says of the model and of initial stresses."""
    alone = place.run("qsmpm", deck, f"{name}-alone")
    shared = place.run("qsmpm-mpi", deck, f"{name}-3", ranks=3)
    apart = distance(alone, shared)
    expect(apart <= SAME, f"{name}: {apart:.1e} from one process")
    words = ("averaged in cells", "corrected for", "initial stress of", "nodes,", "grid of", "reads material point", "strength from", "lies outside", "starts from")
    said = [[line.split("; ")[-1] for line in run.log.splitlines() if any(word in line for word in words)] for run in (alone, shared)]
    expect(said[0] == said[1] and any("starts from" in line for line in said[0]), f"{name}: {said}")


def divided_anew(place: Place) -> None:
    """A block whose points gather in few boxes is divided anew on the way, with its loaded surface and reactions."""
    deck = plane("0, 1, 0, 1.5", phase=CARRIED.replace("{way}", "1.6"), steps=16)
    agrees(place, "block", deck, (4,), ELASTIC)
    told = (place.work / "block-4" / "job.log").read_text().count("shared by 4 processes")
    expect(told > 1, f"divided {told} times")


CHECKS: list[Check] = [rest_and_branches, freed_fixity]
LONG_CHECKS: list[Check] = [more_rests, divided_anew]
