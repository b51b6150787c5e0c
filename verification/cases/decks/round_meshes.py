"""Meshes of round bodies in Abaqus' form: python round_meshes.py, beside the decks that read them.

consolidation_ball.mesh: an eighth of a ball, six tetrahedra (C3D10) over its radius; water_well.mesh: a quarter of the ground around a well,
bricks (C3D8).
"""

import itertools
import math
from pathlib import Path

EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))
FACES = ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0))

Place = tuple[float, ...]


def lines(rows: list[list[int]]) -> str:
    """Rows of whole numbers, a line each."""
    return "".join(", ".join(map(str, row)) + "\n" for row in rows)


def write(name: str, title: str, nodes: list[Place], kind: str, cells: list[list[int]], sets: dict[str, list[int]], surface: str = "") -> None:
    """Write a mesh; numbers count from 0 here and from 1 in the file."""
    text = f"** {title}; made by round_meshes.py\n*NODE\n"
    text += "".join(f"{i}, " + ", ".join(f"{x:.7g}" for x in place) + "\n" for i, place in enumerate(nodes, 1))
    text += f"*ELEMENT, TYPE={kind}\n" + lines([[i, *(n + 1 for n in cell)] for i, cell in enumerate(cells, 1)])
    for word, items in sets.items():
        text += f"*NSET, NSET={word}\n" + lines([[n + 1 for n in items[i : i + 16]] for i in range(0, len(items), 16)])
    Path(__file__).with_name(name).write_text(text + surface)


def eighth_of_ball(name: str, n: int) -> None:
    """The tetrahedron a + b + c <= n in n^3 pieces (Freudenthal), its layers of equal a + b + c bent to spheres."""
    number: dict[tuple[int, int, int], int] = {}
    nodes: list[Place] = []
    for total in range(n + 1):
        for a, b in itertools.product(range(total + 1), repeat=2):
            if a + b <= total:
                number[a, b, total - a - b] = len(nodes)
                length = math.hypot(a, b, total - a - b) or 1.0
                nodes.append(tuple(round(total / n * x / length, 7) for x in (a, b, total - a - b)))
    cells = []
    for start in itertools.product(range(n), repeat=3):
        for order in itertools.permutations(range(3)):
            corners = [list(start)]
            for axis in order:
                corners.append([x + (i == axis) for i, x in enumerate(corners[-1])])
            if all(n >= u >= v >= w for u, v, w in corners):
                cell = [number[u - v, v - w, w] for u, v, w in corners]
                cells.append(cell if volume([nodes[i] for i in cell]) > 0 else [cell[i] for i in (0, 1, 3, 2)])
    skin = {i for place, i in number.items() if sum(place) == n}
    faces = [f"{e}, S{s}\n" for e, cell in enumerate(cells, 1) for s, face in enumerate(FACES, 1) if all(cell[i] in skin for i in face)]
    middle: dict[tuple[int, ...], int] = {}
    for cell in cells:
        for i, j in EDGES:
            pair = tuple(sorted((cell[i], cell[j])))
            if pair not in middle:
                middle[pair] = len(nodes)
                nodes.append(tuple((x + y) / 2 for x, y in zip(nodes[pair[0]], nodes[pair[1]], strict=True)))
            cell.append(middle[pair])
    sets = {"skin": sorted(skin)}
    write(name, f"An eighth of a ball of 1 m, {len(cells)} tetrahedra", nodes, "C3D10", cells, sets, "*SURFACE, NAME=skin\n" + "".join(faces))


def volume(places: list[Place]) -> float:
    """Six times the volume of a tetrahedron."""
    a, b, c = ([x - y for x, y in zip(place, places[0], strict=True)] for place in places[1:])
    return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0])


def ground_around_well(name: str, inner: float, outer: float, heights: list[float], rings: int, sectors: int) -> None:
    """A quarter of a cylinder, rings growing by one ratio."""
    nodes = [
        (round(r * math.cos(t), 7), round(r * math.sin(t), 7), z)
        for z in heights
        for r in (inner * (outer / inner) ** (i / rings) for i in range(rings + 1))
        for t in (math.pi / 2 * j / sectors for j in range(sectors + 1))
    ]
    row, layer = sectors + 1, (sectors + 1) * (rings + 1)
    cells = [
        [k * layer + i * row + j + step for step in (0, row, row + 1, 1, layer, layer + row, layer + row + 1, layer + 1)]
        for k, i, j in itertools.product(range(len(heights) - 1), range(rings), range(sectors))
    ]
    at = {word: [k * layer + i * row + j for k in range(len(heights)) for j in range(row)] for word, i in (("well", 0), ("rim", rings))}
    write(name, f"A quarter of the ground around a well, {inner} to {outer} m", nodes, "C3D8", cells, at)


if __name__ == "__main__":
    eighth_of_ball("consolidation_ball.mesh", 6)
    ground_around_well("water_well.mesh", 1, 8, [0, 1, 2], 8, 6)
