"""The check figure: the imported section, for comparison with the drawing."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from shapely.geometry import Polygon

from qsmpm_verify.importing.loads import tractions_of
from qsmpm_verify.importing.section import Section
from qsmpm_verify.plots import save


def draw_section(section: Section, path: Path) -> Path:
    """Regions by soil, their names, corners and water levels, in metres."""
    low_x, high_x, low_y, high_y = section.box()
    ratio = min(1.0, max(0.25, (high_y - low_y) / (high_x - low_x)))
    figure = Figure(figsize=(10.0, 10.0 * ratio + 1.6), layout="constrained")
    axes = figure.subplots()
    colours = {soil: mpl.colormaps["Pastel1"](i % 9) for i, soil in enumerate(section.soils)}
    for region in section.regions:
        x, y = zip(*region.outline, strict=True)
        axes.fill(x, y, facecolor=colours[region.soil], edgecolor="0.3", lw=0.8)
        axes.plot(x, y, ".", color="0.3", ms=3)
        place = Polygon(region.outline).representative_point()
        axes.text(place.x, place.y, region.name, ha="center", va="center", fontsize=8)
    thick = 0.03 * (high_x - low_x)
    for level in section.water:
        x, y = zip(*level, strict=True)
        axes.plot(x, y, color="tab:blue", lw=1.5)
    for pieces, _ in tractions_of(section):
        for (end_x, end_y), (start_x, start_y) in pieces:
            x, y = (start_x, end_x, end_x, start_x), (start_y, end_y, end_y + thick, start_y + thick)
            axes.fill(x, y, facecolor="none", edgecolor="tab:red", hatch="||", lw=0.8)
    axes.set_aspect("equal")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    drawn = f"{len(section.regions)} regions of {len(section.soils)} soils, {len(section.water)} water lines, {len(section.loads)} loads"
    axes.set_title(drawn, fontsize=9, loc="left")
    axes.legend(handles=[Patch(facecolor=colour, label=name) for name, colour in colours.items()], fontsize=8, loc="upper right")
    return save(figure, path)
