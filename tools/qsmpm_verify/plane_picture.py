"""Figures of plane bodies by matplotlib: a field up to the boundary, initial and current outlines, edges of the mesh."""

from __future__ import annotations

from dataclasses import dataclass
from dataclasses import field as field_of
from textwrap import wrap
from typing import Any, cast

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: E402
from matplotlib.collections import LineCollection, PolyCollection  # noqa: E402
from matplotlib.colors import BoundaryNorm, Normalize  # noqa: E402

from qsmpm_verify.body_net import Net, nets_of  # noqa: E402
from qsmpm_verify.cells import CORNERS  # noqa: E402
from qsmpm_verify.flow_net import draw_net  # noqa: E402
from qsmpm_verify.outlines import Outline  # noqa: E402
from qsmpm_verify.results import Array, Mesh  # noqa: E402
from qsmpm_verify.surroundings import NOTHING, Surroundings  # noqa: E402

# Fields of whole numbers: they have classes, and nothing between them.
CLASSES: dict[str, dict[int, str]] = {"plastic": {0: "elastic", 1: "yields"}, "material": {}}
WIDTH = 9.6
DOTS = 125
# Length of the largest bar of pressure, over the size of the view.
BAR = 0.1
SOLID, PRESSED, WATER = "0.82", "#d76f84", "#1f6fd0"


@dataclass(frozen=True)
class Frame:
    """Common properties of the figures of a series: corners of the view, limits of the colour scale, the field.

    `names` are those of classes defined by the run, `length` is the unit of the axes; `pressure` the largest pressure of
    the contacts, `stress` its unit.
    """

    low: Array
    high: Array
    least: float
    most: float
    field: str
    title: str
    names: dict[int, str] = field_of(default_factory=dict)
    length: str = ""
    pressure: float = 0.0
    stress: str = ""

    def classes(self) -> list[int]:
        """Numbers of the classes of a field with classes; otherwise none."""
        return list(range(round(self.least), round(self.most) + 1)) if self.field in CLASSES else []


@dataclass(frozen=True)
class Body:
    """Points of a state: initial and current positions, values with their association, current outline;
    objects beside them."""

    start: Array
    place: Array
    values: Array
    kinds: Array
    outline: Outline
    around: Surroundings = NOTHING
    flow: Array | None = None
    """Velocity of groundwater flow at the points, if their values are heads; NaN where they are dry."""


def _colours(frame: Frame) -> tuple[matplotlib.colors.Colormap, Normalize]:
    """Viridis, in steps if the field has classes."""
    classes = frame.classes()
    if classes:
        bounds = np.arange(classes[0], classes[-1] + 2) - 0.5
        return plt.get_cmap("viridis", len(classes)), BoundaryNorm(bounds, len(classes))
    most = frame.most if frame.most > frame.least else frame.least + 1.0
    return plt.get_cmap("viridis"), Normalize(frame.least, most)


def _fill(axes: plt.Axes, net: Net, values: Array, frame: Frame) -> None:
    """The field on a triangular mesh: smooth, or one class for each triangle."""
    colours, norm = _colours(frame)
    look: dict[str, Any] = {"cmap": colours, "norm": norm, "rasterized": True}
    x, y = net.now.T
    if frame.classes():
        mean = np.median(values[net.source][net.triangles], axis=1)
        axes.tripcolor(x, y, triangles=net.triangles, facecolors=mean, shading="flat", **look)
    else:
        axes.tripcolor(x, y, values[net.source], triangles=net.triangles, shading="gouraud", **look)


def _lines(axes: plt.Axes, places: Array, pairs: Array, colour: str, width: float, order: float) -> None:
    """Lines between pairs of points."""
    axes.add_collection(LineCollection(list(places[pairs]), colors=colour, linewidths=width, zorder=order))


def draw_body(axes: plt.Axes, body: Body, frame: Frame, outline: bool = True) -> None:
    """The field of a body in its current position, with its current outline and, in grey, the initial one."""
    colours, norm = _colours(frame)
    inside: set[int] = set()
    for net, members in nets_of(body.start, body.place, body.kinds, body.outline):
        _fill(axes, net, body.values[members], frame)
        inside |= set(members[net.source[np.unique(net.triangles)]].tolist())
        if outline:
            _lines(axes, net.before, net.outline, "0.45", 0.9, 3)
            _lines(axes, net.now, net.outline, "black", 1.1, 4)
    alone = np.array(sorted(set(range(len(body.place))) - inside), dtype=int)
    x, y = body.place[alone].T
    axes.scatter(x, y, c=body.values[alone], s=6, cmap=colours, norm=norm, linewidths=0, zorder=2)
    axes.set_xlim(frame.low[0], frame.high[0])
    axes.set_ylim(frame.low[1], frame.high[1])
    axes.set_aspect("equal")


def draw_around(axes: plt.Axes, around: Surroundings, frame: Frame) -> None:
    """Rigid bodies in the background, contact pressures as bars on the soil, water levels with their symbol."""
    size = float((frame.high - frame.low).max())
    bodies = [area for area in (body.area(2 * size) for body in around.bodies) if area is not None]
    if bodies:
        axes.add_collection(PolyCollection(bodies, facecolors=SOLID, edgecolors="0.25", linewidths=1.0, zorder=1,
                                           label="rigid body"))
    if frame.pressure > 0:
        told = f"contact pressure, largest {frame.pressure:.3g} {frame.stress}".strip()
        axes.add_collection(PolyCollection(list(around.bars(BAR * size / frame.pressure)), facecolors=PRESSED,
                                           edgecolors=PRESSED, linewidths=0.4, zorder=5, label=told))
    for number, line in enumerate(around.water):
        axes.plot(*line[:, :2].T, color=WATER, lw=1.4, zorder=6, label="" if number else "water level")
        x = frame.low[0] + 0.06 * (frame.high[0] - frame.low[0])
        mark = max(x, line[0, 0]) if line[-1, 0] > x else line[:, 0].mean()
        height = float(np.interp(mark, line[:, 0], line[:, 1]))
        axes.plot(mark, height + 0.008 * size, "v", color=WATER, ms=6, mfc="white", zorder=6)


def legend(figure: plt.Figure, axes: plt.Axes) -> None:
    """Legend of the objects beside the soil; none without such objects."""
    drawn, names = axes.get_legend_handles_labels()
    if drawn:
        figure.legend(drawn, names, loc="outside lower left", ncols=3, fontsize=8, frameon=False)


def draw_mesh(axes: plt.Axes, mesh: Mesh) -> None:
    """Edges of the cells in the initial geometry; corners are first in every cell."""
    pairs = [
        (cell[i], cell[(i + 1) % n]) for kind, cell in zip(mesh.types, mesh.cells)
        if (n := CORNERS.get(int(kind), 0)) for i in range(n)
    ]  # fmt: skip
    if pairs:
        edges = np.unique(np.sort(np.array(pairs), axis=1), axis=0)
        _lines(axes, mesh.nodes[:, :2], edges, "0.6", 0.35, 2.5)


def bar(figure: plt.Figure, axes: plt.Axes | list[plt.Axes], frame: Frame, **place: Any) -> None:
    """The colour scale with values, or with the names of the classes."""
    colours, norm = _colours(frame)
    shown = figure.colorbar(plt.cm.ScalarMappable(norm, colours), ax=axes, **place)
    # A letter of 9 points is about 0.075 inches wide; what is longer than the bar is broken between words.
    figure.draw_without_rendering()
    most = int(shown.ax.get_window_extent().height / figure.dpi / 0.075)
    shown.set_label("\n".join(wrap(frame.title, max(most, 8), break_long_words=False)), fontsize=9)
    shown.ax.tick_params(labelsize=8)
    classes = frame.classes()
    if classes:
        names = {**CLASSES[frame.field], **frame.names}
        shown.set_ticks(classes, labels=[names.get(c, str(c)) for c in classes])
        shown.ax.tick_params(length=0)


def label_axes(axes: plt.Axes, frame: Frame) -> None:
    """Names of the axes with their unit, if known."""
    if frame.length:
        axes.set_xlabel(f"x [{frame.length}]", fontsize=8)
        axes.set_ylabel(f"y [{frame.length}]", fontsize=8)


def plane_picture(body: Body, frame: Frame, caption: str, outline: bool = True, mesh: Mesh | None = None) -> Array:
    """One image as rows of red, green and blue; all images of a series have the same size."""
    size = frame.high - frame.low
    named = bool(body.around.bodies or body.around.water)
    height = float(np.clip(0.84 * WIDTH * size[1] / size[0] + (1.25 if named else 0.9), 2.2, 9.0))
    figure, axes = plt.subplots(figsize=(WIDTH, height), dpi=DOTS, layout="constrained")
    if mesh is not None:
        draw_mesh(axes, mesh)
    draw_body(axes, body, frame, outline)
    if body.flow is not None:
        draw_net(axes, body.place, body.values, body.flow)
    draw_around(axes, body.around, frame)
    legend(figure, axes)
    axes.set_title(caption, fontsize=10, loc="left")
    axes.tick_params(labelsize=8)
    label_axes(axes, frame)
    bar(figure, axes, frame, shrink=0.9, pad=0.01)
    figure.canvas.draw()
    # The canvas is Agg's: matplotlib.use above.
    pixels = np.asarray(cast(FigureCanvasAgg, figure.canvas).buffer_rgba())[..., :3].copy()
    plt.close(figure)
    # Films by MPEG want even numbers of pixels.
    return pixels[: pixels.shape[0] // 2 * 2, : pixels.shape[1] // 2 * 2]
