"""`point`: the diagrams of a laboratory report for a test of one material point, with a measurement if there is one.

The diagrams show stress against the controlled strain, the volumetric strain or the pore pressure, the path of p and q,
and compression against pressure. A measurement is a CSV with headings `name [unit]` with names of curves.csv; its
columns are plotted, strains in % and stresses in another known unit are converted to the units of the result.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from qsmpm_verify.curve import open_result
from qsmpm_verify.results import Array, Curves, ResultError
from qsmpm_verify.trouble import Trouble
from qsmpm_verify.units import read_unit

LABELS = {
    "axial_strain": r"axial strain $\varepsilon_a$", "volumetric_strain": r"volumetric strain $\varepsilon_v$",
    "shear_strain": r"shear strain $\gamma$", "p": "mean pressure $p$", "q": "deviatoric stress $q$",
    "s12": r"shear stress $\tau$", "pore_pressure": "pore pressure $u$", "axial_stress": r"axial stress $\sigma_a$",
}  # fmt: skip


@dataclass(frozen=True)
class Panel:
    """One pair of quantities; `down` plots y downwards, as for compression, `log` x on a logarithmic axis."""

    x: str
    y: str
    down: bool = False
    log: bool = False


def value(curves: Curves, name: str) -> Array | None:
    """A quantity of a table, None if it is missing."""
    if name == "axial_stress" and name not in curves.columns:
        return -curves.columns["s22"] if "s22" in curves.columns else None
    return curves.columns.get(name)


def unit(curves: Curves, name: str) -> str:
    """Unit of a quantity."""
    return curves.units.get("s22" if name == "axial_stress" and name not in curves.units else name, "")


def panels(curves: Curves) -> list[Panel]:
    """The most informative diagrams of a test, from the quantities that vary."""
    sheared = float(np.ptp(curves.column("shear_strain")))
    pressed = float(np.ptp(curves.column("axial_strain")))
    if sheared > pressed:
        return [Panel("shear_strain", "s12"), Panel("shear_strain", "volumetric_strain", down=True), Panel("p", "q")]
    second = Panel("axial_strain", "volumetric_strain", down=True)
    if "pore_pressure" in curves.columns:
        second = Panel("axial_strain", "pore_pressure")
    if float(np.ptp(curves.column("lateral_strain"))) == 0.0:
        return [Panel("axial_stress", "axial_strain", down=True), Panel("axial_stress", "axial_strain", True, True),
                Panel("p", "q")]  # fmt: skip
    return [Panel("axial_strain", "q"), second, Panel("p", "q")]


def factor(own: str, other: str, name: str) -> float:
    """Factor that converts a measurement to the unit of the result."""
    if other == own or not other or (not own and other in ("-", "1")):
        return 1.0
    if not own and other == "%":
        return 0.01
    mine, theirs = read_unit(own), read_unit(other)
    if mine is not None and theirs is not None and mine.powers == theirs.powers:
        return theirs.factor / mine.factor
    raise ResultError(f"{name}: the measurement is in '{other}', the result in '{own}'")


def draw_panel(axes: Axes, panel: Panel, curves: Curves, measured: Curves | None) -> bool:
    """One diagram; returns whether the measurement contains it."""
    x, y = value(curves, panel.x), value(curves, panel.y)
    if x is None or y is None:
        raise ResultError(f"{curves.path}: no {panel.x} or {panel.y}; `point` requires the output of `qsmpm point`")
    keep = x > 0 if panel.log else np.full(len(x), True)
    axes.plot(x[keep], y[keep], "-", lw=1.2, color="tab:blue", label="QSMPM")
    yields = curves.columns.get("yields")
    if yields is not None and np.any((yields > 0) & keep):
        first = int(np.argmax((yields > 0) & keep))
        axes.plot(x[first], y[first], "o", ms=5, mfc="none", color="tab:red", label="first yield")
    found = False
    if measured is not None:
        mx, my = value(measured, panel.x), value(measured, panel.y)
        if mx is not None and my is not None:
            mx = mx * factor(unit(curves, panel.x), unit(measured, panel.x), panel.x)
            my = my * factor(unit(curves, panel.y), unit(measured, panel.y), panel.y)
            axes.plot(mx, my, "k.", ms=4, label=measured.path.stem)
            found = True
    for name, put in ((panel.x, axes.set_xlabel), (panel.y, axes.set_ylabel)):
        put(LABELS[name] + (f" [{unit(curves, name)}]" if unit(curves, name) else ""), fontsize=9)
    if panel.log:
        axes.set_xscale("log")
    if panel.down:
        axes.invert_yaxis()
    axes.grid(alpha=0.3)
    axes.legend(fontsize=7)
    return found


def draw(result: Path, against: Path | None, out: Path, unfinished: bool) -> int:
    """The diagrams of a result; returns the number of them for which the measurement has data."""
    curves = open_result(result, unfinished)
    measured = open_result(against, unfinished) if against else None
    chosen = panels(curves)
    figure, row = plt.subplots(1, len(chosen), figsize=(4.2 * len(chosen), 3.8))
    found = sum(draw_panel(axes, panel, curves, measured) for axes, panel in zip(row, chosen, strict=True))
    if measured is not None and not found:
        plt.close(figure)
        pairs = ", ".join(f"{panel.x} and {panel.y}" for panel in chosen)
        raise ResultError(f"{against}: it contains none of the plotted pairs: {pairs}")
    out.parent.mkdir(parents=True, exist_ok=True)
    figure.tight_layout()
    figure.savefig(out, dpi=130)
    plt.close(figure)
    return found


def add_words(verbs: argparse._SubParsersAction) -> None:
    """Arguments of the subcommand."""
    verb = verbs.add_parser("point", help="plot the diagrams of a laboratory report for a result of `qsmpm point`")
    verb.add_argument("result", type=Path, help="folder of the result, or its curves.csv")
    verb.add_argument("--against", type=Path, metavar="CSV", help="measurement with headings `axial_strain [%%],q [kPa]`")
    verb.add_argument("--out", type=Path, help="file of the figure, .png, .svg or .pdf; default RESULT/point.png")
    verb.add_argument("--unfinished", action="store_true", help="accept a test that did not finish")
    verb.set_defaults(act=act)


def act(words: argparse.Namespace) -> int:
    """Plot and report the file."""
    folder = words.result if words.result.is_dir() else words.result.parent
    out = words.out or folder / "point.png"
    if out.suffix.lower() not in (".png", ".svg", ".pdf"):
        raise Trouble(f"{out}: a figure must be a .png, .svg or .pdf file")
    draw(words.result, words.against, out, words.unfinished)
    print(out)
    return 0
