#!/usr/bin/env python3
"""Draw the rooms of src/ and what uses what: docs/figures/house.svg.

A floor stands above those it uses; rooms in a frame use one another. An arrow that follows from others is left out; the width
says how many `use` statements it stands for.
"""
from __future__ import annotations

import collections
import pathlib
import re
import sys

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt

from house import FLOORS, ROOMS, TOP

matplotlib.rcParams["svg.hashsalt"] = "house"


def uses() -> tuple[dict[tuple[str, str], int], dict[str, tuple[int, int]]]:
    """Number of `use` statements from room to room, and files and lines of each room."""
    sources = {path: path.read_text() for path in sorted((TOP / "src").glob("*/**/*.f90"))
               if "include" not in path.parts}
    room = {path: path.relative_to(TOP / "src").parts[0] for path in sources}
    owner = {found.lower(): room[path] for path, text in sources.items()
             for found in re.findall(r"^module\s+(\w+)\s*$", text, re.M)}
    count: collections.Counter = collections.Counter()
    sizes: dict[str, tuple[int, int]] = {name: (0, 0) for name in ROOMS}
    for path, text in sources.items():
        files, lines = sizes[room[path]]
        sizes[room[path]] = files + 1, lines + text.count("\n")
        for name in re.findall(r"^\s*use\s*(?:,\s*\w+\s*::|::)?\s*(\w+)", text, re.M):
            other = owner.get(name.lower())
            if other and other != room[path]:
                count[room[path], other] += 1
    return dict(count), sizes


def between_floors(count: dict[tuple[str, str], int]) -> dict[tuple[int, int], int]:
    """Number of `use` statements from floor to floor."""
    place = {name: i for i, row in enumerate(FLOORS) for name in row}
    found: collections.Counter = collections.Counter()
    for (a, b), number in count.items():
        if place[a] != place[b]:
            found[place[a], place[b]] += number
    return dict(found)


def heights(count: dict[tuple[int, int], int]) -> list[int]:
    """Height of a floor: one above the highest that it uses."""
    level: list[int] = []
    for i in range(len(FLOORS)):
        level.append(max([level[b] + 1 for a, b in count if a == i], default=0))
    return level


def reached(floor: int, count: dict[tuple[int, int], int]) -> set[int]:
    """All floors that a floor uses, directly or through others."""
    below = {b for a, b in count if a == floor}
    return below.union(*[reached(other, count) for other in below])


def middles(level: list[int]) -> dict[int, float]:
    """Abscissa of each floor: those of one height side by side, each as wide as its rooms."""
    rows = collections.defaultdict(list)
    for i, height in enumerate(level):
        rows[height].append(i)
    found = {}
    for row in rows.values():
        left = -0.5 * sum(width(i) for i in row)
        for i in row:
            found[i] = left + 0.5 * width(i)
            left += width(i)
    return found


def width(floor: int) -> float:
    """Width of the frame of a floor: four rooms side by side at the most."""
    return 3.6 * min(len(FLOORS[floor]), 4) + 0.6


def main() -> int:
    target = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else TOP / "docs/figures/house.svg"
    uses_of, sizes = uses()
    count = between_floors(uses_of)
    level = heights(count)
    x, y, top = middles(level), [0.0] * len(FLOORS), 0.0
    for height in range(max(level) + 1):
        row = [i for i in range(len(FLOORS)) if level[i] == height]
        for i in row:
            y[i] = top
        top += 0.55 + max(-(-len(FLOORS[i]) // 4) for i in row)
    figure, axes = plt.subplots(figsize=(8.3, 11.0))
    for (above, below), number in sorted(count.items()):
        others = [b for a, b in count if a == above and b != below]
        if any(below in reached(other, count) for other in others):
            continue
        axes.annotate("", (x[below], y[below] - 0.12 + -(-len(FLOORS[below]) // 4)), (x[above], y[above] - 0.12), zorder=1, arrowprops={
            "arrowstyle": "->", "color": "0.45", "linewidth": 0.6 + 0.1*number**0.5,
            "connectionstyle": f"arc3,rad={0.0 if x[above] != x[below] or level[above] - level[below] == 1 else 0.5}"})
    for i, row in enumerate(FLOORS):
        lines = -(-len(row) // 4)
        if len(row) > 1:
            axes.add_patch(plt.Rectangle((x[i] - 0.5*width(i), y[i] - 0.12), width(i), lines, facecolor="0.97", edgecolor="0.3", zorder=2))
        for k, name in enumerate(row):
            column, line = k % 4, k // 4
            left = x[i] + 3.6*(column - 0.5*min(len(row), 4)) + 0.1
            axes.add_patch(plt.Rectangle((left, y[i] + line - 0.06), 3.4, 0.86, facecolor="#eef2f7", edgecolor="0.3", zorder=3))
            axes.text(left + 1.7, y[i] + line + 0.5, f"{name}/", ha="center", va="center", fontsize=9, weight="bold", zorder=4)
            axes.text(left + 1.7, y[i] + line + 0.16, f"{sizes[name][0]} files, {sizes[name][1]:,} lines", ha="center", va="center",
                      fontsize=6.5, zorder=4)
    reach = max(abs(x[i]) + 0.5*width(i) for i in x) + 0.5
    axes.set_xlim(-reach, reach)
    axes.set_ylim(-0.5, top)
    axes.axis("off")
    figure.savefig(target, metadata={"Date": None}, bbox_inches="tight")
    print(f"{target}: {len(ROOMS)} rooms, {sum(f for f, _ in sizes.values())} files, "
          f"{sum(n for _, n in sizes.values()):,} lines on {max(level) + 1} floors")
    return 0


if __name__ == "__main__":
    sys.exit(main())
