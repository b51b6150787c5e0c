"""Checks of several ranks against one process: meshes that are read, grids of other elements than squares and bricks."""

from __future__ import annotations

from many_ranks import CARRIED, ELASTIC, PLASTIC, STANDARD, agrees, plane
from one_rank import shortened
from shared_scenes import SAME
from support import TOP, Check, Place, distance, expect, expect_same_bytes

CELLS = "BASIS=STANDARD, INTEGRATION=CELL, KINEMATICS=LOGARITHMIC"
TUTORIAL = TOP / "docs" / "tutorial"
# Soil that locks: one pressure for several cells, where these are small.
STIFF = "*ELASTIC\n200, 0.49\n*VOLUMETRIC LOCKING, TYPE=UNIFORM PRESSURE"


def read_mesh(deck: str, corners: bool = False) -> str:
    """The deck of `plane` on a mesh of triangles that is written out, with six nodes each or three, wider to the right."""
    nx, ny = 12, 8
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


def moved(steps: int, more: str = "") -> str:
    """A light block that its base carries over the mesh."""
    deck = plane("0, 1, 0, 1.5", CELLS, CARRIED.replace("{way}", "1.6").replace("0, -1", "0, -0.2"), steps=steps, more=more)
    return deck.replace("PER ELEMENT=4", "PER ELEMENT=12").replace("*CONTROLS, ", "*CONTROLS, STABILISATION SHARE=1, ")


def carried_mesh(place: Place) -> None:
    """A block that is carried over a mesh of triangles of six nodes from part to part, as one process does, twice the same bytes."""
    deck = read_mesh(moved(8, "*RESTART, EVERY=4\n"))
    alone = place.run("qsmpm", deck, "alone")
    first, other = (place.run("qsmpm-mpi", deck, name, ranks=3) for name in ("first", "other"))
    expect(distance(alone, first) <= SAME, f"{distance(alone, first):.1e} from one process")
    expect_same_bytes(first, other)


def patches(place: Place) -> None:
    """Triangles of three nodes that share pressures two by two: the pairs are those of one process."""
    deck = plane("0, 2, 0, 1.5").replace("*ELASTIC\n200, 0.3", STIFF)
    agrees(place, "read", read_mesh(deck, corners=True), (3,), SAME)


def more_meshes(place: Place) -> None:
    """Elastic bodies on all kinds of grids and on meshes that are read, on 2, 3, 4 and 7 ranks."""
    body = plane("0, 2, 0, 1.5").replace("PER ELEMENT=4", "PER ELEMENT=12")
    for name, words in (("tri6", "ELEMENT=TRI6"), ("quad8", "ELEMENT=QUAD8"), ("tri3", "ELEMENT=TRI3, DIAGONAL=RANDOM"),
                        ("perturbed", "ELEMENT=TRI6, DIAGONAL=RANDOM, PERTURB=0.2, SEED=3")):  # fmt: skip
        agrees(place, f"{name}", on_grid(body, words), (2, 3, 4, 7), SAME)
        agrees(place, f"{name}-moved", on_grid(moved(8), words), (3, 4), SAME)
    agrees(place, "read", read_mesh(body), (2, 3, 4, 7), SAME)
    agrees(place, "read-moved", read_mesh(moved(8)), (2, 4, 7), SAME)
    agrees(place, "ring", read_mesh(plane("0.5, 2, 0, 1.5", model="AXISYMMETRIC")), (2, 3), SAME)
    agrees(place, "ring-grid", on_grid(plane("0.5, 2, 0, 1.5", model="AXISYMMETRIC"), "ELEMENT=TRI6"), (2, 3), SAME)
    ghost = "BASIS=STANDARD, INTEGRATION=CELL, KINEMATICS=LOGARITHMIC, STABILISATION=GHOST"
    agrees(place, "ghost", read_mesh(plane("0, 2, 0, 1.4", ghost)), (3, 4), SAME)


CHECKS: list[Check] = [carried_mesh, patches]
LONG_CHECKS: list[Check] = [more_meshes]
