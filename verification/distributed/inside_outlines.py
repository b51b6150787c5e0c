"""Checks of bodies that are integrated inside of their outlines: cells that hold a part of them and no point, states that come from
points of other ranks, surfaces that are laid anew in each attempt at a step."""

from __future__ import annotations

import re

import h5py
import numpy as np
from joint_files import expect_same_results
from many_ranks import CARRIED, agrees, plane
from restarts import ends_at, goes_on, often
from shared_scenes import LOADED, SAME
from support import TOP, Check, Place, Run, distance, expect, expect_same_bytes, pit_on_squares

CELLS = "BASIS=STANDARD, INTEGRATION=CELL, KINEMATICS=LOGARITHMIC"
HISTORIES = """*HISTORY, NAME=corner, QUANTITY=DISPLACEMENT, COMPONENT=X
0.63, -0.09
*HISTORY, NAME=stress, QUANTITY=STRESS, COMPONENT=XY
0.4, 0.2
*HISTORY, NAME=volume, QUANTITY=VOLUME
"""


def turned(element: str, points: int, basis: str, steps: int = 2) -> str:
    """The turned block under so much pressure on all of its outline that its sides shorten by 5 %; it leans, so that stresses differ."""
    deck = (TOP / "verification/cases/decks/turned_block.inp").read_text()
    for old, new in (("ELEMENT=TRI6", f"ELEMENT={element}"), ("PER ELEMENT=12", f"PER ELEMENT={points}"), ("STANDARD", basis),
                     ("*PRESSURE, SURFACE=all\n1.0", "*PRESSURE, SURFACE=all\n10929.74523\n*TRACTION, SURFACE=side\n900, -2500"),
                     ("*METHOD", "*SURFACE, NAME=side, TYPE=OUTLINE, BODY=b, BOX\n0.3, 0.9, -0.3, 0.3\n*METHOD"),
                     ("*PHASE", HISTORIES + "*FIELD, EVERY=2\n*PHASE"), ("STEPS=1", f"STEPS={steps}")):  # fmt: skip
        deck = deck.replace(old, new, 1)
    return deck


def carried(method: str = CELLS, steps: int = 16, way: str = "1.6") -> str:
    """A block that cuts cells on three sides and rides through the boxes of the ranks, under loads on its outline."""
    surfaces = LOADED.replace("0, 2, 1.5, 1.5", "0, 1, 1.42, 1.42").replace("2, 2, 0, 1.5", "0.93, 0.93, 0, 1.42")
    phase = CARRIED.replace("{way}", way) + "\n*PRESSURE, SURFACE=side\n3\n*TRACTION, SURFACE=top\n0.5, -3"
    return plane("0.1, 0.93, 0, 1.42", method, phase, steps=steps, more=surfaces + "*FIELD, EVERY=1000\n")


def agrees_in_points(place: Place, name: str, deck: str, ranks: tuple[int, ...]) -> None:
    """Curves of one process, what its points carry at the end, and its surface points by their numbers."""
    agrees(place, name, deck, ranks, SAME)
    alone = Run(place.work / f"{name}-alone", 0, "", 0.0)
    for n in ranks:
        shared = Run(place.work / f"{name}-{n}", 0, "", 0.0)
        expect_same_surfaces(alone, shared)
        if n > 1:
            expect_same_results(alone, shared)


def expect_same_surfaces(alone: Run, shared: Run) -> None:
    """Every surface point is there once, with the number, place and area of one process."""
    fields = []
    for run in (alone, shared):
        with h5py.File(run.folder / "restart.h5") as file:
            order = np.argsort(file["surface/number"])
            fields.append([file[f"surface/{name}"][:][order] for name in ("number", "surface", "position", "area_vector")])
    (numbers, *one), (other_numbers, *other) = fields
    expect(np.array_equal(numbers, other_numbers), f"numbers of surface points: {numbers}\n{other_numbers}")
    expect(all(np.allclose(a, b, rtol=0.0, atol=SAME) for a, b in zip(one, other, strict=True)), "other surface points")


def pressed(place: Place) -> None:
    """A block turned in its grid under pressure: triangles, bricks, domains, splines; on many ranks as on one process."""
    agrees_in_points(place, "quad4", turned("QUAD4", 4, "STANDARD"), (1, 2, 3, 4, 7))
    for name, element, points, basis, ranks in (("tri6", "TRI6", 12, "STANDARD", 3), ("quad8", "QUAD8", 9, "STANDARD", 2),
                                                ("gimp", "QUAD4", 4, "GIMP", 3), ("spline2", "QUAD4", 9, "SPLINE2", 4),
                                                ("spline3", "QUAD4", 16, "SPLINE3", 2)):  # fmt: skip
        agrees_in_points(place, name, turned(element, points, basis), (ranks,))


def inside(place: Place) -> None:
    """Bodies inside of their outlines: a block rides through boxes, its surfaces laid anew; a column is drawn out, with cells without a point."""
    agrees_in_points(place, "block", carried(steps=8, way="0.8"), (3,))
    agrees_in_points(place, "column", drawn_out(), (2,))


def bed() -> str:
    """A layer of sixty cells by three, cut above and at its ends, that its base carries under a load: ranks look at parts of it."""
    surfaces = LOADED.replace("0, 2, 1.5, 1.5", "0, 15, 0.63, 0.63").replace("2, 2, 0, 1.5", "14.9, 14.9, 0, 0.63")
    phase = CARRIED.replace("{way}", "0.7") + "\n*PRESSURE, SURFACE=side\n3\n*TRACTION, SURFACE=top\n0.5, -3"
    deck = plane("0.1, 14.9, 0, 0.63", CELLS, phase, steps=5, more=surfaces + "*FIELD, EVERY=1000\n")
    return deck.replace("X, 0, 3, 12", "X, 0, 16, 64").replace("0.9, 1.3", "7.3, 0.6")


def far_apart(place: Place) -> None:
    """A long layer, of whose loaded surface each rank lays a part."""
    agrees_in_points(place, "bed", bed(), (2, 4, 7))


def rides(place: Place) -> None:
    """A block whose cut sides ride from rank to rank, and out of boxes of ranks; the same bytes from as many ranks again."""
    agrees_in_points(place, "quad4", carried(), (1, 2, 3, 4, 7))
    agrees_in_points(place, "spline2", carried(CELLS.replace("STANDARD", "SPLINE2")), (3,))
    agrees_in_points(place, "sparse", carried(steps=32).replace("PER ELEMENT=4", "PER ELEMENT=1"), (4, 7))
    first, other = (place.run("qsmpm-mpi", carried(), name, ranks=3) for name in ("first", "other"))
    expect_same_bytes(first, other)


def thin() -> str:
    """A strip of a third of a cell, of one point a cell, that hangs and bends."""
    deck = plane("", CELLS, "*FIX\nceiling, ALL\n*GRAVITY\n0.4, -0.6", more="*FIELD, EVERY=1000\n")
    deck = deck.replace("SHAPE=BOX\n", "SHAPE=POLYGON\n0.3, 0.02\n0.38, 0.0\n0.68, 1.77\n0.6, 1.79")
    for old, new in (("PER ELEMENT=4", "PER ELEMENT=1"), ("*MATERIAL", "*NSET, NSET=ceiling, PLANE=Y\n1.75\n*MATERIAL"),
                     ("0.9, 1.3", "0.345, 0.04"), ("0.6, 0.3", "0.508, 1.0"), ("200, 0.3", "5E4, 0.3"),
                     ("STEPS=5", "STEPS=5, STABILISATION SHARE=1")):  # fmt: skip
        deck = deck.replace(old, new)
    return deck


def drawn_out() -> str:
    """A column of one point a cell, held above and pulled at its end until parts of it are five times as long."""
    surface = "*SURFACE, NAME=end, TYPE=OUTLINE, BODY=body, BOX\n0, 1, 3.05, 3.05\n*FIELD, EVERY=1000\n"
    phase = "*FIX\nceiling, ALL\nall, X\n*GRAVITY\n0, -1\n*TRACTION, SURFACE=end\n0, -135"
    deck = plane("0.1, 0.6, 3.05, 4", CELLS.replace("LOGARITHMIC", "JAUMANN"), phase, steps=10, more=surface)
    for old, new in (("Y, 0, 2, 8", "Y, 0, 4, 16"), ("PER ELEMENT=4", "PER ELEMENT=1"), ("200, 0.3", "200, 0.0"),
                     ("*MATERIAL", "*NSET, NSET=ceiling, PLANE=Y\n4\n*NSET, NSET=all, BOX\n0, 3, 0, 4\n*MATERIAL"),
                     ("0.9, 1.3", "0.5, 3.6"), ("0.6, 0.3", "0.5, 3.9"), ("STEPS=10", "STEPS=10, STABILISATION SHARE=1")):  # fmt: skip
        deck = deck.replace(old, new)
    return deck


def without_points(place: Place) -> None:
    """Cells that hold a part of a strip and no point; a column that is drawn out, where states come from points beyond the cells around."""
    agrees_in_points(place, "strip", thin(), (1, 2, 3, 4, 7))
    agrees_in_points(place, "smooth", thin().replace("STANDARD", "SPLINE2"), (2,))
    agrees_in_points(place, "column", drawn_out(), (2, 3, 4))


def more_pressed(place: Place) -> None:
    """A turned block in space, and a ring with cut sides."""
    space = (TOP / "verification/cases/decks/turned_block_space.inp").read_text()
    stl = TOP / "verification/cases/decks/turned_block.stl"
    for old, new in (("WEDGE15", "HEX8"), ("ELEMENT=18", "ELEMENT=8"), ("turned_block.stl", str(stl)),
                     ("SURFACE=all\n1.0", "SURFACE=all\n9000"), ("STEPS=1", "STEPS=2"), ("*PHASE", HISTORIES.replace("0.63, -0.09", "0, 0.25, 0").replace("0.4, 0.2", "0, 0.2, 0.1")
                                              + "*FIELD, EVERY=2\n*PHASE")):  # fmt: skip
        space = space.replace(old, new)
    agrees_in_points(place, "space", space, (2, 3))
    agrees_in_points(place, "ring", carried(way="0.0001", steps=3).replace("PLANE STRAIN", "AXISYMMETRIC"), (2, 4))


def pit() -> str:
    """The pit of input/ in elastic ground, on cells that all of its bodies cut, with a street that is loaded from the start."""
    deck = pit_on_squares().replace("*MOHR COULOMB\n 15, 25, 0, 5\n", "")
    for old, new in (("X, 0, 12, 24\n Y, 0, 8, 16", "X, 0, 12, 11\n Y, 0, 8, 9"),
                     ("CONTROLS, ", "CONTROLS, TOLERANCE=1E-9, STABILISATION SHARE=1, "),
                     ("STEPS=4", "STEPS=3"), ("STEPS=6", "STEPS=3"),
                     ("*DEACTIVATE\n upper", "*PRESSURE, SURFACE=street\n 10\n*DEACTIVATE\n upper"),
                     ("*PRESSURE, SURFACE=street\n 10\n*CONT", "*PRESSURE, SURFACE=street\n 40\n*CONT")):  # fmt: skip
        deck = deck.replace(old, new)
    return deck


def staged(place: Place) -> None:
    """Cut bodies that come, go and change beside a loaded street: their unloading, in cells that they share."""
    agrees(place, "pit", pit(), (2, 3, 7), SAME)


# The upper side of a block on a ramp, as a segment of the grid and as its outline, and a load on it that friction bears.
SIDES = {"SEGMENT": "\n2.292820323027551, 2.092820323027551, 0.907179676972449, 1.292820323027551",
         "OUTLINE, BODY=block, BOX": "\n0.9, 2.3, 1.2, 2.1"}  # fmt: skip
PUSHED = "*PHASE, NAME=more\n*TRACTION, SURFACE=top\n2, -6\n*CONTROLS, STEPS=6, TOLERANCE=1e-9\n*END PHASE\n"


def mixed() -> str:
    """Soil that could yield, which rides with a stiff thin wall that cannot: the outline of the one is followed, the other's is not."""
    wall = "*BODY, NAME=wall, MATERIAL=wall, SHAPE=POLYGON\n1.61, 0\n1.7, 0\n1.75, 1.41\n1.66, 1.41\n*POINTS, BODY=wall, PER ELEMENT=1\n"
    soil = "*MATERIAL, NAME=wall\n*ELASTIC\n2E4, 0.2\n*UNIT WEIGHT\n24\n*BODY, NAME=body"
    deck = plane("", CELLS, CARRIED.replace("{way}", "0.4"), more="*FIELD, EVERY=1000\n")
    deck = deck.replace("SHAPE=BOX\n", "SHAPE=POLYGON\n0, 0\n1.6, 0\n1.65, 1.4\n0, 1.4")
    for old, new in (("*UNIT WEIGHT\n10", "*MOHR COULOMB\n1E5, 30, 0\n*UNIT WEIGHT\n10"), ("*BODY, NAME=body", soil),
                     ("*METHOD", wall + "*METHOD"), ("STEPS=5", "STEPS=5, STABILISATION SHARE=1")):  # fmt: skip
        deck = deck.replace(old, new, 1)
    return deck


def side_by_side(place: Place) -> None:
    """Bodies inside of their outlines beside others: one process's curves, and its words of how far the others are off."""
    agrees_in_points(place, "mixed", mixed(), (2, 3, 4))
    logs = [(place.work / f"mixed-{end}/job.log").read_text().splitlines() for end in ("alone", "2", "3", "4")]
    said = [[line for line in log if "along its outline" in line] for log in logs]
    expect(len(said[0]) > 1 and all(lines == said[0] for lines in said), f"{said}")


def touched(place: Place) -> None:
    """Contact with bodies inside of their outlines: a plate that turns on two columns, a strip."""
    for name, ranks in (("contact_columns", 2), ("contact_strip_turned", 3)):
        deck = (TOP / f"verification/cases/decks/{name}.inp").read_text()
        agrees(place, name, re.sub("TOLERANCE=[^,\n]+", "TOLERANCE=1E-9", deck), (ranks,), SAME)
    held = {}
    for kind, where in SIDES.items():
        deck = (TOP / "verification/cases/decks/contact_block.inp").read_text().replace("ANGLE=40", "ANGLE=31").replace("1e-6", "1e-9")
        deck = deck.replace("*METHOD", f"*SURFACE, NAME=top, TYPE={kind}{where}\n*METHOD") + PUSHED
        agrees(place, kind.split(",")[0].lower(), deck, (3,), SAME)
        held[kind] = Run(place.work / f"{kind.split(',')[0].lower()}-alone", 0, "", 0.0).rows()[-1]
    column = [abs(row[-5]) for row in held.values()]
    expect(abs(column[0] - column[1]) <= 0.02 * column[0], f"the block has slid by {column}")


def continued(place: Place) -> None:
    """Ranks leave, others go on: a block with a loaded outline on its way, a pit while bodies go."""
    goes_on(place, "block", carried(steps=8, way="0.8"), 4)
    goes_on(place, "pit", pit(), 3)
    deck = often(carried(steps=8, way="0.8"))
    folder = ends_at(place, deck, "two", 4, 2)
    rest = place.run("qsmpm-mpi", deck, "two", ranks=3, restart=folder / "restart.h5")
    through = Run(place.work / "block-through", 0, "", 0.0)
    expect(distance(through, rest) <= SAME, f"two to three ranks: {distance(through, rest):.1e} from a run that went through")
    expect_same_surfaces(through, rest)


CHECKS: list[Check] = [inside]
LONG_CHECKS: list[Check] = [pressed, far_apart, rides, without_points, more_pressed, staged, side_by_side, touched, continued]
