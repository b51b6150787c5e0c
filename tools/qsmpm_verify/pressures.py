"""`pressures`: the contact pressure on walls and bodies of a plane run against depth or along the surface, with theory."""

from __future__ import annotations

import argparse
import csv
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from qsmpm_verify.bodies import is_flat
from qsmpm_verify.curve import table_values
from qsmpm_verify.fields import unit_of
from qsmpm_verify.formula import read_formula
from qsmpm_verify.plots import save
from qsmpm_verify.results import Array, Curves, Points, ResultError, read_curves, read_points
from qsmpm_verify.study.cards import read_deck
from qsmpm_verify.surroundings import chain
from qsmpm_verify.told import read_phase
from qsmpm_verify.trouble import Trouble
from qsmpm_verify.view import caption_of, chosen_steps, folder_of, job_of

ALONG = ("depth", "s", "x", "y")


def add_words(verbs: argparse._SubParsersAction) -> None:
    """Arguments of the subcommand."""
    verb = verbs.add_parser("pressures", help="plot the contact pressure on walls and bodies against depth or along the surface, with theory")
    verb.add_argument("result", type=Path, help="folder of a run, or its results.h5")
    verb.add_argument("--along", choices=ALONG, default="depth",
                      help="depth below --top, s along the surface from its first end, or a coordinate; default depth")
    verb.add_argument("--against", metavar="REFERENCE", help="theory: function:NAME(argument=value, argument=depth), or a CSV with "
                      "a column with the name of --along and a column `pressure`")
    verb.add_argument("--top", type=float, help="reference height of depths; default the upper end of the contact")
    verb.add_argument("--body", help="name of a rigid body; default all")
    verb.add_argument("--step", type=int, help="step to plot; default the last one written")
    verb.add_argument("--phase", type=read_phase, help="plot the last step written of a phase, by name or number")
    verb.add_argument("--out", type=Path, default=Path("pressures.png"), help="file of the figure, .png, .svg or .pdf")
    verb.add_argument("--csv", type=Path, help="also write the table to a CSV file")
    verb.set_defaults(act=act, film=False, mechanism=False)


def table_of(points: Points, body: int | None, top: float | None) -> Curves:
    """Data of the surface points in contact: x, y, depth, s, extent and pressure, in their order along the surface."""
    contacts = points.around.contacts
    if not contacts:
        raise ResultError(f"{points.path}: step {points.step} has no contacts")
    chosen = contacts["pressure"] > 0
    if body is not None:
        chosen &= contacts["body"] == body
    if not chosen.any():
        raise ResultError(f"{points.path}: no contact pressure in step {points.step}")
    x, y = contacts["position"][chosen, :2].T
    extent, order = contacts["extent"][chosen], chain(np.stack([x, y], axis=1))
    end = 0.5 * extent * np.abs(contacts["normal"][chosen, 0])
    depth = (float((y + end).max()) if top is None else top) - y
    columns = {"x": x, "y": y, "depth": depth, "extent": extent, "pressure": contacts["pressure"][chosen]}
    columns = {name: values[order] for name, values in columns.items()}
    columns["s"] = np.cumsum(columns["extent"]) - 0.5 * columns["extent"]
    return Curves(points.path, columns, {}, {})


def number_of(folder: Path, name: str) -> int:
    """Number of a rigid body of the deck."""
    for path in sorted(folder.glob("*.echo.inp"))[:1]:
        names = [str(card.value("NAME")) for card in read_deck(path).all("RIGID BODY")]
        if name in names:
            return names.index(name) + 1
        raise Trouble(f"unknown rigid body '{name}'; known are {', '.join(names)}")
    raise ResultError(f"{folder}: no echoed deck with the names of the bodies")


def theory_of(reference: str, table: Curves, along: str) -> Array:
    """The reference at every row."""
    if reference.startswith("function:"):
        return read_formula(reference.removeprefix("function:")).along(table, np.arange(len(table)))
    return table_values(read_curves(Path(reference)), along, "pressure", table.column(along))


def draw(table: Curves, along: str, theory: Array | None, names: tuple[str, str], words: argparse.Namespace, caption: str) -> Path:
    """Pressure of each point as a step over its length, the theory as a line; depth is positive downwards."""
    figure, axes = plt.subplots(figsize=(5.2, 5.6) if along in ("depth", "y") else (6.4, 4.4), layout="constrained")
    place, pressure = table.column(along), table.column("pressure")
    upright = along in ("depth", "y")
    order = np.argsort(place, kind="stable")
    middle = 0.5 * (place[order][1:] + place[order][:-1])
    ends = np.concatenate([place[order][:1], middle, place[order][-1:]])
    if len(order) > 1:
        ends[0], ends[-1] = 2 * ends[0] - ends[1], 2 * ends[-1] - ends[-2]
        if along == "depth":
            ends[0] = max(ends[0], 0.0)
    axes.stairs(pressure[order], ends, orientation="horizontal" if upright else "vertical", fill=True, color="#c2314f", alpha=0.35)
    axes.stairs(pressure[order], ends, orientation="horizontal" if upright else "vertical", color="#c2314f", lw=1.4, label="computed")
    if theory is not None:
        line = (theory[order], place[order]) if upright else (place[order], theory[order])
        axes.plot(*line, "k-", lw=1.4, label=words.against.removeprefix("function:"))
    (axes.set_xlabel if upright else axes.set_ylabel)(names[1])
    (axes.set_ylabel if upright else axes.set_xlabel)(names[0])
    if along == "depth":
        axes.invert_yaxis()
    axes.set_title(caption, fontsize=9, loc="left")
    axes.grid(alpha=0.3)
    figure.legend(fontsize=7, loc="outside lower left", frameon=False)
    return save(figure, words.out)


def act(words: argparse.Namespace) -> int:
    """Read, compare, print, plot."""
    if words.out.suffix.lower() not in (".png", ".svg", ".pdf"):
        raise Trouble(f"{words.out}: a figure must be a .png, .svg or .pdf file")
    folder = folder_of(words.result)
    points = read_points(words.result, chosen_steps(words)[0])
    if not is_flat([points]):
        raise Trouble(f"{words.result}: pressure diagrams require a plane run")
    body = None if words.body is None else number_of(folder, words.body)
    table = table_of(points, body, words.top)
    theory = theory_of(words.against, table, words.along) if words.against else None
    length, stress = unit_of(folder, "position"), unit_of(folder, "contact_pressure")
    extent, pressure = table.column("extent"), table.column("pressure")
    force = stress.removesuffix("2")
    print(f"rows       {len(table)} in contact, {extent.sum():.4g} {length} long")
    print(f"force      {extent @ pressure:.6g} {force}, largest pressure {pressure.max():.4g} {stress}")
    if theory is not None:
        known = np.isfinite(theory)
        gap = np.abs(pressure - theory)[known]
        due = float(extent[known] @ theory[known])
        print(f"theory     {due:.6g} {force}, computed {float(extent[known] @ pressure[known]) / due - 1:+.3%}")
        print(f"difference rms {np.sqrt(np.average(gap**2, weights=extent[known])):.4g}, largest {gap.max():.4g} {stress}")
    if words.csv:
        write_table(table, theory, (length, stress), words.csv)
    names = [f"{name} [{unit}]" if unit else name for name, unit in ((words.along, length), ("contact pressure", stress))]
    print(draw(table, words.along, theory, (names[0], names[1]), words, caption_of(job_of(folder), points, words)))
    return 0


def write_table(table: Curves, theory: Array | None, units: tuple[str, str], path: Path) -> None:
    """The rows with headings `name [unit]`."""
    columns = dict(table.columns) | ({} if theory is None else {"theory": theory})
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow([f"{name} [{units[name in ('pressure', 'theory')]}]" for name in columns])
        rows.writerows([f"{value:.8g}" for value in row] for row in zip(*columns.values()))
