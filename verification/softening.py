#!/usr/bin/env python3
"""Softening on three meshes, with regularisation and without: runs the scenes, prints their figures, draws the chart.

Usage: softening.py BINARY [CHART.svg]      (about 80 s of CPU time; runs go to output/softening)

Left: force over displacement of the layer in simple shear (verification/cases/decks/softening_layer.inp) against its
closed form. Right: settlement of the crest over unit weight of the softening slope (input/slope_softening.inp).
"""
from __future__ import annotations

import csv
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

TOP = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(TOP / "tools"))
from qsmpm_verify.cpu_limit import run_limited  # noqa: E402

LAYER = TOP / "verification/cases/decks/softening_layer.inp"
SLOPE = TOP / "input/slope_softening.inp"
BARE = "REGULARISATION=NONE"
#: Shear modulus, strength of the weak row and in the end, slip at which it is reached, displacement of the plate.
SHEAR, PEAK, RESIDUAL, SLIP, MOVE = 4000.0, 9.0, 2.0, 0.02, 0.04
COLOURS = ("#1b6ca8", "#d1495b", "#3a7d44")


def run(binary: str, name: str, deck: str) -> list[dict[str, float]]:
    """Rows of the curves of a deck; columns without their units."""
    folder = TOP / "output/softening"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{name}.inp").write_text(deck, encoding="utf-8")
    ended = run_limited([binary, "run", folder / f"{name}.inp", "--out", folder / name], 900.0)
    if ended.code != 0:
        sys.exit(f"{name}: {ended.how}: {ended.errors}")
    with (folder / name / "curves.csv").open(encoding="utf-8") as file:
        return [{key.split(" [")[0]: float(value) for key, value in row.items() if value} for row in csv.DictReader(file)]


def layer(binary: str, rows: int, bare: bool) -> list[dict[str, float]]:
    """The layer of so many rows of cells."""
    top = f"{0.5 + 1 / rows:.10g}"
    deck = LAYER.read_text(encoding="utf-8").replace("1.25, 6\n", f"1.25, {rows * 3 // 2}\n")
    deck = deck.replace("Y, 0, 1, 4\n", f"Y, 0, 1, {rows}\n").replace("0, 1, 0.5, 0.75", f"0, 1, 0.5, {top}")
    deck = deck.replace("0, 1, 0.75, 1", f"0, 1, {top}, 1")
    if bare:
        deck = deck.replace("REGULARISATION=CELL, LENGTH=0.1", BARE)
    return run(binary, f"layer_{rows}{'_bare' if bare else ''}", deck)


def slope(binary: str, cells: int, bare: bool) -> list[dict[str, float]]:
    """The slope of so many cells a height."""
    deck = SLOPE.read_text(encoding="utf-8").replace("X, 0, 5, 50", f"X, 0, 5, {5 * cells}")
    deck = deck.replace("Y, 0, 1, 10", f"Y, 0, 1, {cells}")
    if bare:
        deck = deck.replace("REGULARISATION=CELL, LENGTH=0.1", BARE)
    return run(binary, f"slope_{cells}{'_bare' if bare else ''}", deck)


def exact(move: float) -> float:
    """Shear force of the layer: the weak row in series with the elastic layer."""
    if move <= PEAK / SHEAR:
        return SHEAR * move
    return max(RESIDUAL, (move - PEAK * SLIP / (PEAK - RESIDUAL)) / (1 / SHEAR - SLIP / (PEAK - RESIDUAL)))


def slides_between(rows: list[dict[str, float]]) -> str:
    """The loads between which the crest settles most."""
    steps = zip(rows, rows[1:], strict=False)
    before, after = max(steps, key=lambda pair: pair[1]["crest_settlement"] - pair[0]["crest_settlement"])
    return (f"slides between {before['load_factor']:g} and {after['load_factor']:g} kN/m3 to "
            f"{after['crest_settlement']:.3f} m, at 40 {rows[-1]['crest_settlement']:.3f} m")


def draw_layer(binary: str, axes: plt.Axes) -> None:
    """Left side of the chart."""
    for rows, colour in zip((4, 8, 16), COLOURS, strict=True):
        for bare in (False, True):
            curve = layer(binary, rows, bare)
            print(f"layer, {rows} rows{', no regularisation' if bare else ''}: work {curve[-1]['internal_work']:.4f}")
            axes.plot([0.0] + [MOVE * row["load_factor"] for row in curve], [0.0] + [row["shear_force"] for row in curve],
                      color=colour, linestyle="--" if bare else "-", linewidth=1.3,
                      label=f"{rows} rows{', bare' if bare else ''}")
    places = [MOVE * i / 2000 for i in range(2001)]
    axes.plot(places, [exact(place) for place in places], color="black", linewidth=0.8, label="closed form")
    axes.set(xlabel="displacement of the plate [m]", ylabel="shear force [kN/m]", title="Layer in simple shear")
    axes.legend(fontsize=7, frameon=False)


def draw_slope(binary: str, axes: plt.Axes) -> None:
    """Right side of the chart."""
    for cells, colour in zip((5, 10, 20), COLOURS, strict=True):
        for bare in (False, True):
            curve = slope(binary, cells, bare)
            print(f"slope, {cells} cells a height{', no regularisation' if bare else ''}: {slides_between(curve)}")
            axes.plot([row["load_factor"] for row in curve], [row["crest_settlement"] for row in curve], color=colour,
                      linestyle="--" if bare else "-", linewidth=1.3, label=f"{cells} cells{', bare' if bare else ''}")
    axes.set(xlabel="unit weight [kN/m3]", ylabel="settlement of the crest [m]", title="Slope, 1 m high")
    axes.legend(fontsize=7, frameon=False)


def main() -> int:
    """Run, print, draw."""
    if len(sys.argv) not in (2, 3):
        print(__doc__)
        return 2
    plt.rcParams["svg.hashsalt"] = "softening"
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.5, 4.0), layout="constrained")
    draw_layer(sys.argv[1], left)
    draw_slope(sys.argv[1], right)
    for axes in (left, right):
        axes.spines[["top", "right"]].set_visible(False)
    chart = pathlib.Path(sys.argv[2]) if len(sys.argv) == 3 else TOP / "docs/figures/softening.svg"
    figure.savefig(chart, metadata={"Date": None})
    print(chart)
    return 0


if __name__ == "__main__":
    sys.exit(main())
