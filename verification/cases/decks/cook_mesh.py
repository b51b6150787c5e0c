#!/usr/bin/env python3
"""Mesh of Cook's membrane for gmsh readers: a tapered panel, n by n elements.

    cook_mesh.py N [--triangles | --quadratic] > cook_N.msh

The panel has the corners (0,0), (48,44), (48,60), (0,44); the mesh is mapped from a square. Groups:
"panel" for the elements, "left" for the clamped side.
"""
from __future__ import annotations

import argparse


def position(i: float, j: float, n: int) -> tuple[float, float]:
    """Node i along, j up."""
    low, high = 44 * i / n, 44 + 16 * i / n
    return 48 * i / n, low + (high - low) * j / n


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("n", type=int)
    kinds = parser.add_mutually_exclusive_group()
    kinds.add_argument("--triangles", action="store_true", help="two triangles for each quadrilateral")
    kinds.add_argument("--quadratic", action="store_true", help="8-node quadrilaterals")
    options = parser.parse_args()
    n = options.n
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", "2", '1 1 "left"', '2 2 "panel"',
             "$EndPhysicalNames", "$Nodes", str((n + 1) ** 2 + options.quadratic * 2 * n * (n + 1))]
    number = {}
    for j in range(n + 1):
        for i in range(n + 1):
            number[i, j] = len(number) + 1
            x, y = position(i, j, n)
            lines.append(f"{number[i, j]} {x:.15g} {y:.15g} 0")
    if options.quadratic:
        middles = [(i + 0.5, j) for j in range(n + 1) for i in range(n)] + [(i, j + 0.5) for j in range(n) for i in range(n + 1)]
        for i, j in middles:
            number[i, j] = len(number) + 1
            x, y = position(i, j, n)
            lines.append(f"{number[i, j]} {x:.15g} {y:.15g} 0")
    elements = [f"1 2 1 1 {number[0, j]} {number[0, j + 1]}" for j in range(n)]
    for j in range(n):
        for i in range(n):
            a, b, c, d = number[i, j], number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]
            if options.triangles:
                elements += [f"2 2 2 2 {a} {b} {c}", f"2 2 2 2 {a} {c} {d}"]
            elif options.quadratic:
                sides = [number[place] for place in ((i + 0.5, j), (i + 1, j + 0.5), (i + 0.5, j + 1), (i, j + 0.5))]
                elements.append(f"16 2 2 2 {a} {b} {c} {d} " + " ".join(map(str, sides)))
            else:
                elements.append(f"3 2 2 2 {a} {b} {c} {d}")
    lines += ["$EndNodes", "$Elements", str(len(elements))]
    lines += [f"{k} {e}" for k, e in enumerate(elements, 1)]
    print("\n".join([*lines, "$EndElements"]))


if __name__ == "__main__":
    main()
