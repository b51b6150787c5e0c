"""Checks of several ranks against one process: meshes that are read, grids of other elements than squares and bricks."""

from __future__ import annotations

from many_ranks import CARRIED, ELASTIC, PLASTIC, STANDARD, agrees, interrupted, plane
from one_rank import shortened
from shared_scenes import SAME
from support import TOP, Check, Place, distance, expect, expect_same_bytes

CELLS = "BASIS=STANDARD, INTEGRATION=CELL, KINEMATICS=LOGARITHMIC"
TUTORIAL = TOP / "docs" / "tutorial"
# Soil that locks: one pressure for several cells, where these are small.
STIFF = "*ELASTIC\n200, 0.49\n*VOLUMETRIC LOCKING, TYPE=UNIFORM PRESSURE"

LOOSE = """*MATERIAL, NAME=loose
*ELASTIC
100, 0.3
*VOLUMETRIC LOCKING, TYPE=NONE
*UNIT WEIGHT
10
*BODY, NAME=loose, MATERIAL=loose, SHAPE=POLYGON
0, 1
1, 1
1.125, 1.5
0, 1.5
*POINTS, BODY=loose, PER ELEMENT=4
*BODY, NAME=half, MATERIAL=soil, SHAPE=POLYGON
1, 1
1.125, 1
1.125, 1.5
*POINTS, BODY=half, PER ELEMENT=4
"""


def read_mesh(deck: str, corners: bool = False) -> str:
    """The deck of `plane` on a mesh of triangles that is written out, with six nodes each or three, wider to the right."""
    nx, ny = 24, 4
    number = {}
    lines = ["*NODE"]
    for j in range(2 * ny + 1):
        for i in range(2 * nx + 1):
            if corners and (i % 2 or j % 2):
                continue
            number[i, j] = len(number) + 1
            lines.append(f"{number[i, j]}, {3 * i / (2 * nx)}, {2 * j / (2 * ny)}")
    lines.append(f"*ELEMENT, TYPE={'TRI3' if corners else 'TRI6'}")
    n = 0
    for j in range(0, 2 * ny, 2):
        for i in range(0, 2 * nx, 2):
            square = [(i, j), (i + 2, j), (i + 2, j + 2), (i, j + 2)]
            turned = (i // 2 + j // 2) % 2
            for three in ((0, 1, 2), (0, 2, 3)):
                ends = [square[(k + turned) % 4] for k in three]
                middles = [((a[0] + b[0]) // 2, (a[1] + b[1]) // 2) for a, b in zip(ends, ends[1:] + ends[:1], strict=True)]
                n += 1
                lines.append(", ".join(str(x) for x in [n, *(number[p] for p in ends + ([] if corners else middles))]))
    first, last = deck.index("*GRID"), deck.index("*NSET, NSET=base")
    return deck[:first] + "\n".join(lines) + "\n" + deck[last:]


def on_grid(deck: str, words: str) -> str:
    """The same deck on a grid of another element."""
    return deck.replace("ELEMENT=QUAD4", words)


def moved(steps: int, more: str = "", method: str = CELLS, way: float = 0.2) -> str:
    """A light block that its base carries over the mesh, some way a step."""
    deck = plane("0, 1, 0, 1.5", method, CARRIED.replace("{way}", f"{way * steps}").replace("0, -1", "0, -0.2"), steps=steps, more=more)
    return deck.replace("PER ELEMENT=4", "PER ELEMENT=12").replace("*CONTROLS, ", "*CONTROLS, STABILISATION SHARE=1, ")


def carried_mesh(place: Place) -> None:
    """A block that is carried over a mesh of triangles of six nodes, from part to part, moves as on one process."""
    agrees(place, "read", read_mesh(moved(4)), (3,), SAME)


def repeats(place: Place) -> None:
    """The same ranks share a mesh in the same parts and give the same bytes of curves, results and restart file."""
    deck = read_mesh(moved(8, "*RESTART, EVERY=4\n"))
    first, other = (place.run("qsmpm-mpi", deck, name, ranks=4) for name in ("first", "other"))
    expect_same_bytes(first, other)


def patches(place: Place) -> None:
    """Triangles of three nodes that share pressures two by two, and those above that share none, one beside its half of a square,
    are those of one process."""
    deck = plane("0, 2, 0, 1", more=LOOSE).replace("*ELASTIC\n200, 0.3", STIFF, 1)
    agrees(place, "read", read_mesh(deck, corners=True), (3,), SAME)


def more_meshes(place: Place) -> None:
    """Elastic bodies on all kinds of grids and on meshes that are read, on 2, 3, 4 and 7 ranks."""
    body = plane("0, 2, 0, 1.5").replace("PER ELEMENT=4", "PER ELEMENT=12")
    for name, words in (("tri6", "ELEMENT=TRI6"), ("quad8", "ELEMENT=QUAD8"), ("tri3", "ELEMENT=TRI3, DIAGONAL=RANDOM"),
                        ("perturbed", "ELEMENT=TRI6, DIAGONAL=RANDOM, PERTURB=0.2, SEED=3")):  # fmt: skip
        method = STANDARD if name == "perturbed" else CELLS
        for deck, ranks, kind in ((body, (2, 3, 4, 7), "still"), (moved(8, method=method), (3, 4), "moved")):
            deck = deck.replace("PER ELEMENT=12", "PER ELEMENT=9") if name == "quad8" else deck
            agrees(place, f"{name}-{kind}", on_grid(deck, words), ranks, SAME)
    agrees(place, "read", read_mesh(body), (2, 3, 4, 7), SAME)
    agrees(place, "read-moved", read_mesh(moved(8)), (2, 4, 7), SAME)
    agrees(place, "ring", read_mesh(plane("0.5, 2, 0, 1.5", model="AXISYMMETRIC")), (2, 3), SAME)
    ring = plane("0.5, 2, 0, 1.5", model="AXISYMMETRIC").replace("*CONTROLS, ", "*CONTROLS, STABILISATION SHARE=1, ")
    agrees(place, "ring-grid", on_grid(ring, "ELEMENT=TRI6"), (2, 3), SAME)
    agrees(place, "ghost", read_mesh(plane("0, 2, 0, 1.4", STANDARD + ", STABILISATION=GHOST")), (3, 4), SAME)


def slope(words: str, points: int, factor: int, steps: int) -> str:
    """A slice of the paper's slope with a growing weight: twelve is below the load at which it fails."""
    deck = (TOP / "input/slope_e50_coarse.inp").read_text().split("*PHASE")[0]
    deck = deck.replace("ELEMENT=WEDGE15, DIAGONAL=RANDOM, PERTURB=0.15, SEED=1", words)
    deck = deck.replace("PER ELEMENT=36", f"PER ELEMENT={points}").replace("*FIELD, EVERY=10\n", "")
    fixed = "base, ALL\nleft, X\nright, X\nfront, Z\nback, Z\n"
    return (f"{deck}*PHASE, NAME=gravity, LOAD FACTOR={factor}\n*FIX\n{fixed}*GRAVITY\n0, -1, 0\n*CONTROLS, STEPS={steps}, "
            "NEWTON=FULL, TOLERANCE=1E-6, STABILISATION SHARE=1\n*END PHASE\n")  # fmt: skip


def yielding_meshes(place: Place) -> None:
    """The paper's slope in wedges, a hill that gmsh meshed, and columns keep within ten times their tolerance."""
    shifted = "DIAGONAL=RANDOM, PERTURB=0.15, SEED=1"
    agrees(place, "six", slope(f"ELEMENT=WEDGE6, {shifted}", 8, 12, 6), (2, 3, 4, 7), PLASTIC)
    agrees(place, "fifteen", slope(f"ELEMENT=WEDGE15, {shifted}", 36, 12, 6), (2, 3, 4), PLASTIC)
    for name in ("5_hill.inp", "5_hill.msh"):
        (place.work / name).write_text((TUTORIAL / name).read_text())
    agrees(place, "hill", (TUTORIAL / "5_hill.inp").read_text(), (2, 3, 4, 7), PLASTIC)
    for ranks in (2, 3, 4):
        agrees(place, f"column-{ranks}", (TOP / "input/column_logarithmic.inp").read_text(), (ranks,), ELASTIC)


def failing_slope(place: Place) -> None:
    """Triangles of six nodes: the slope past the load at which it fails, with points that go from part to part."""
    deck = shortened("slope_e50_plane.inp", 30).replace("*SOLVER, TYPE={solver}\n", "")
    agrees(place, "slope", deck, (3,), PLASTIC)


def continued(place: Place) -> None:
    """A run on three ranks is continued by one, then by two, to the curves of a run that went through."""
    deck = read_mesh(moved(20, "*RESTART, EVERY=4\n", way=0.08))
    through = place.run("qsmpm", deck, "through")
    first = interrupted(place, deck, 3, 6)
    interrupted(place, deck, 1, len(first.rows()) + 4, restart=True)
    last = place.run("qsmpm-mpi", deck, "long", ranks=2, restart=first.folder / "restart.h5")
    apart = distance(through, last)
    expect(apart <= SAME, f"{apart:.1e} from a run that went through")


CHECKS: list[Check] = [carried_mesh, patches]
LONG_CHECKS: list[Check] = [more_meshes, yielding_meshes, failing_slope, continued, repeats]
