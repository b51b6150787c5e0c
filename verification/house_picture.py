#!/usr/bin/env python3
"""Draw the rooms of src/ and what uses what: docs/figures/house.svg.

A room stands above those it uses. An arrow that follows from others (a room uses what its rooms use) is left out; the
width says how many `use` statements it stands for.
"""
from __future__ import annotations

import collections
import pathlib
import re
import sys

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt

from house import FLOORS, TOP

matplotlib.rcParams["svg.hashsalt"] = "house"


def uses() -> tuple[dict[tuple[str, str], int], dict[str, tuple[int, int]]]:
    """Number of `use` statements from room to room, and files and lines of each room."""
    sources = {path: path.read_text() for path in sorted((TOP / "src").glob("*/**/*.f90"))
               if "include" not in path.parts}
    room = {path: path.relative_to(TOP / "src").parts[0] for path in sources}
    owner = {found.lower(): room[path] for path, text in sources.items()
             for found in re.findall(r"^module\s+(\w+)\s*$", text, re.M)}
    count: collections.Counter = collections.Counter()
    sizes: dict[str, tuple[int, int]] = {name: (0, 0) for name in FLOORS}
    for path, text in sources.items():
        files, lines = sizes[room[path]]
        sizes[room[path]] = files + 1, lines + text.count("\n")
        for name in re.findall(r"^\s*use\s*(?:,\s*\w+\s*::|::)?\s*(\w+)", text, re.M):
            other = owner.get(name.lower())
            if other and other != room[path]:
                count[room[path], other] += 1
    return dict(count), sizes


def floors(count: dict[tuple[str, str], int]) -> dict[str, int]:
    """Floor of a room: one above the highest that it uses."""
    level: dict[str, int] = {}
    for name in FLOORS:
        level[name] = max([level[b] + 1 for a, b in count if a == name and b in level], default=0)
    return level


def reached(name: str, count: dict[tuple[str, str], int]) -> set[str]:
    """All rooms that a room uses, directly or through others."""
    below = {b for a, b in count if a == name}
    return below.union(*[reached(other, count) for other in below])


def main() -> int:
    target = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else TOP / "docs/figures/house.svg"
    count, sizes = uses()
    level = floors(count)
    rows = collections.defaultdict(list)
    for name in FLOORS:
        rows[level[name]].append(name)
    place = {name: (4.0*(i - 0.5*(len(row) - 1)), 1.5*floor) for floor, row in rows.items()
             for i, name in enumerate(row)}
    figure, axes = plt.subplots(figsize=(8.3, 11.0))
    for (above, below), number in sorted(count.items()):
        others = [b for a, b in count if a == above and b != below]
        if any(below in reached(other, count) for other in others):
            continue
        (x0, y0), (x1, y1) = place[above], place[below]
        axes.annotate("", (x1, y1 + 0.42), (x0, y0 - 0.42), zorder=1, arrowprops={
            "arrowstyle": "->", "color": "0.45", "linewidth": 0.6 + 0.25*number**0.5,
            "connectionstyle": f"arc3,rad={0.0 if x0 != x1 or level[above] - level[below] == 1 else 0.5}"})
    for name, (x, y) in place.items():
        axes.add_patch(plt.Rectangle((x - 1.6, y - 0.42), 3.2, 0.84, facecolor="#eef2f7", edgecolor="0.3", zorder=2))
        axes.text(x, y + 0.1, f"{name}/", ha="center", va="center", fontsize=11, weight="bold", zorder=3)
        axes.text(x, y - 0.23, f"{sizes[name][0]} files, {sizes[name][1]:,} lines", ha="center", va="center",
                  fontsize=7.5, zorder=3)
    reach = max(abs(x) for x, _ in place.values()) + 2.0
    axes.set_xlim(-reach, reach)
    axes.set_ylim(-0.8, 1.5*max(level.values()) + 0.8)
    axes.axis("off")
    figure.savefig(target, metadata={"Date": None}, bbox_inches="tight")
    print(f"{target}: {len(FLOORS)} rooms, {sum(f for f, _ in sizes.values())} files, "
          f"{sum(n for _, n in sizes.values()):,} lines on {max(level.values()) + 1} floors")
    return 0


if __name__ == "__main__":
    sys.exit(main())
