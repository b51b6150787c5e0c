#!/usr/bin/env python3
"""Sections of other programs, imported as a user does, solved, and beside them Bishop's circles, xslope and bounds of limit analysis.

    verification/imported/run_imported.py build/qsmpm [FILE...] [--quick] [--markdown docs/data/imported.md] [--write]

`import FILE` writes a deck, which is run as it is (psi = 0, since these files do not know it) and once more with a table of soils that says
psi = phi, which is what limit equilibrium and limit analysis take. Seven minutes of CPU time, most of them searches of xslope and bounds; `--quick`
takes coarse grids, psi = phi and bounds for the five layers alone, and of xslope one circle. `--write` makes the files anew from `sections.py`. Runs go to
output/imported, quick ones to output/imported_quick. Closes with `N passed, N failed[, N skipped]`; without xslope what is beside it is skipped.

Tolerances: a mesh of 20 cells a height is up to 2 % above the bracket (docs/data/factors.md), one of 10 up to 4 %; Bishop's method is within 5 % of those
that fulfil all equations (Duncan 1996, J. Geotech. Eng. 122, 577-596); two programs on one circle differ by their slices alone, 0.5 %. Without dilation
the factor is between that of strength reduced after Davis, the careful one, and that of psi = phi.
"""

from __future__ import annotations

import argparse
import contextlib
import csv
import io
import json
import pathlib
import sys
import tempfile
import time
import zipfile
from typing import Any

HERE = pathlib.Path(__file__).resolve().parent
TOP = HERE.parents[1]
sys.path[:0] = [str(TOP / "tools"), str(HERE)]
import matplotlib as mpl  # noqa: E402
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from sections import SECTIONS, WRITERS, Drawn, write_sli  # noqa: E402

from qsmpm_verify.bounds.phases import read_scene  # noqa: E402
from qsmpm_verify.bounds.search import Search  # noqa: E402
from qsmpm_verify.cpu_limit import run_limited  # noqa: E402
from qsmpm_verify.slip_circles import Ground, Slope, bishop, on_circle  # noqa: E402
from qsmpm_verify.study.cards import read_deck  # noqa: E402

FOLDER = TOP / "output" / ("imported_quick" if "--quick" in sys.argv else "imported")
SECONDS = 300.0
BISHOP, SLICES = 0.05, 0.005
HEADS = ("file", "section", "psi", "QSMPM", "CPU s", "limit analysis", "from its middle", "Bishop", "from it", "circle beside", "xslope on it",
         "its Bishop", "its Spencer")  # fmt: skip
Circle = tuple[float, float, float]


class Tally:
    """Checks that held, did not, and were left out."""

    def __init__(self) -> None:
        self.held, self.missed, self.left = 0, 0, 0

    def check(self, holds: bool, text: str) -> None:
        """One check, told."""
        self.held, self.missed = self.held + holds, self.missed + (not holds)
        print(f"  {'held  ' if holds else 'MISSED'} {text}", flush=True)

    def skip(self, text: str) -> None:
        """One that cannot be made here."""
        self.left += 1
        print(f"  left out: {text}", flush=True)


def same(drawn: Drawn, stored: pathlib.Path) -> bool:
    """Whether a stored file is what its writer makes."""
    with tempfile.TemporaryDirectory() as folder:
        made = pathlib.Path(folder) / drawn.file
        WRITERS[made.suffix](drawn, made)
        if made.suffix == ".gsz":
            with zipfile.ZipFile(made) as one, zipfile.ZipFile(stored) as other:
                return [one.read(name) for name in one.namelist()] == [other.read(name) for name in other.namelist()]
        return made.read_bytes() == stored.read_bytes()


def solved(binary: pathlib.Path, file: pathlib.Path, name: str, table: pathlib.Path | None, cells: int, tally: Tally) -> tuple[float, float, pathlib.Path]:
    """Import a file, run the deck that this writes: middle of the bracket of its factor, CPU seconds, deck."""
    deck = FOLDER / f"{name}.inp"
    deck.with_suffix(".soils.csv").unlink(missing_ok=True)
    words = [TOP / "tools/qsmpm-verify", "import", file, "--to", deck, "--cells", str(cells), "--program", binary]
    done = run_limited([*words, *(["--soils", table] if table is not None else [])], SECONDS)
    left = [line for line in done.output.splitlines() if line.startswith("left")]
    tally.check(done.code == 0 and not left, f"{name}: imported, nothing left {'; '.join(left)}{done.errors[-300:]}")
    ran = run_limited([binary, "run", deck, "--out", FOLDER / name, "--quiet"], SECONDS)
    found = json.loads((FOLDER / name / "safety.json").read_text(encoding="utf-8"))["phases"][-1] if ran.code == 0 else {"stable": None, "lost": None}
    upper = found["lost"] or found.get("refused")
    ended = upper is not None
    tally.check(ended, f"{name}: a factor is found {ran.errors[-300:]}")
    return (0.5 * (float(found["stable"]) + float(upper)) if ended else float("nan")), ran.cpu, deck


def shows(picture: pathlib.Path, soils: int) -> bool:
    """Whether a check picture shows each soil in a colour of its own, water in blue and loads in red."""
    image = (255.0 * plt.imread(picture)[:, :, :3]).round().astype(int)
    colours = [mpl.colormaps["Pastel1"](i)[:3] for i in range(soils)] + [mpl.colors.to_rgb(name) for name in ("tab:blue", "tab:red")]
    return all(np.count_nonzero(np.abs(image - np.round(255.0 * np.array(colour))).max(axis=2) < 2) > 50 for colour in colours)


def dilatant(drawn: Drawn) -> pathlib.Path:
    """A table of soils with psi = phi."""
    path = FOLDER / f"{pathlib.Path(drawn.file).stem}.dilatant.csv"
    with path.open("w", newline="", encoding="utf-8") as file:
        rows = [(s.name, s.weight, s.saturated, s.cohesion, s.friction, s.friction) for s in drawn.soils]
        csv.writer(file).writerows([("name", "weight", "saturated_weight", "cohesion", "friction", "dilation"), *rows])
    return path


def by_xslope(drawn: Drawn, circle: Circle, searched: bool) -> list[float] | None:
    """Bishop's factor of a circle, then of xslope's own searches by Bishop and Spencer; none where it is not installed."""
    try:
        from xslope import search, slide2
    except ImportError:
        return None
    high = max(y for _, corners in drawn.regions for _, y in corners)
    wide = max(x for _, corners in drawn.regions for x, _ in corners)
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
        path = pathlib.Path(folder) / "section.sli"
        write_sli(drawn, path)
        data: dict[str, Any] = slide2.slide2_to_slope_data(slide2.read_sli(str(path)))[0]
        for material, soil in zip(data["materials"], drawn.soils, strict=True):
            material["gamma_sat"] = soil.saturated
        data["dloads"] = [[{"X": x, "Y": y, "Normal": size} for x in (a, b)] for a, b, y, size in drawn.loads]
        # Pressures by the depth below the line, as decks and GeoStudio's piezometric lines take them, not lowered on its slope.
        data["piezo_phreatic"] = False
        ours = {"Xo": circle[0], "Yo": circle[1], "R": circle[2], "Depth": circle[1] - circle[2]}
        runs = [search.run_lem_analysis({**data, "circular": True, "circles": [ours]}, "bishop", analysis="single_surface", announce=False, num_slices=400)]
        start = {"Xo": 0.5 * wide, "Yo": 2.0 * high, "R": 1.6 * high, "Depth": 0.4 * high}
        for method in ("bishop", "spencer") if searched else ():
            runs.append(search.run_lem_analysis({**data, "circular": True, "circles": [start]}, method, grid_seed=True, announce=False))
    return [float(run["results"]["FS"]) for run in runs]


def slope_of(drawn: Drawn) -> Slope:
    """The numbers of a section for circles."""
    soils = drawn.soils
    grounds = [Ground(corners, soils[i].weight, soils[i].saturated, soils[i].cohesion, soils[i].friction) for i, corners in drawn.regions]
    return Slope(grounds, drawn.water, [(a, b, size) for a, b, _, size in drawn.loads])


def compare(binary: pathlib.Path, drawn: Drawn, quick: bool, tally: Tally) -> list[list[str]]:
    """Rows of the table, psi = 0 as imported and psi = phi."""
    file, cells, mesh = HERE / drawn.file, 10 if quick else 20, 0.04 if quick else 0.02
    stem = file.stem
    print(f"{drawn.file}: {drawn.what}", flush=True)
    tally.check(same(drawn, file), f"{drawn.file} is what sections.py writes")
    table = file.with_suffix(".soils.csv")
    factor, place = bishop(slope_of(drawn))
    # A little shallower than the critical one, which may touch a firm layer that slices see in part.
    near, circle = on_circle(slope_of(drawn), (place[0], place[1], 0.97 * place[2]))
    beside = by_xslope(drawn, circle, not quick)
    rows = []
    factors: list[float] = []
    runs = [("0", table if table.exists() else None), ("phi", dilatant(drawn))]
    for psi, given in runs if not quick or len(drawn.soils) == 5 else runs[:1]:
        value, seconds, deck = solved(binary, file, f"{stem}_{psi}", given, cells, tally)
        factors.append(value)
        found = Search(read_scene(read_deck(deck)), *((250, 1) if quick else (500, 3))).run() if psi == "phi" or not quick else None
        bracket = "-"
        away = "-"
        if found is not None:
            low, high = found.lower.value, found.upper.value
            bracket = f"{low:.3f} to {high:.3f}{', Davis' if found.reduced else ''}"
            away = f"{value / (0.5 * (low + high)) - 1.0:+.1%}"
            if psi == "phi":
                tally.check(low * (1.0 - mesh) <= value <= high * (1.0 + mesh), f"{stem}, psi = phi: {value:.3f} by limit analysis {bracket}, mesh {mesh:.0%}")
            else:
                tally.check(value >= low * (1.0 - mesh), f"{stem}, psi = 0: {value:.3f} not below {bracket}")
        told = [f"{near:.3f}", *(f"{one:.3f}" for one in beside or [])]
        rows.append([drawn.file, drawn.what, psi, f"{value:.3f}", f"{seconds:.1f}", bracket, away, f"{factor:.3f}", f"{value / factor - 1.0:+.1%}",
                     *[*told, "-", "-", "-"][:4]])  # fmt: skip
    tally.check(shows(FOLDER / f"{stem}_0.png", len(drawn.soils)), f"{stem}: the check picture shows soils, water and loads")
    best = factors[-1]
    if len(factors) == 2:
        tally.check(factors[0] <= best * 1.01, f"{stem}: without dilation {factors[0]:.3f}, with psi = phi {best:.3f}, not above it")
    tally.check(abs(best / factor - 1.0) <= BISHOP, f"{stem}, psi = {psi}: {best:.3f} by Bishop {factor:.3f}")
    if beside is None:
        tally.skip(f"{stem}: xslope is not installed (pip install xslope)")
        return rows
    at = f"({circle[0]:.2f}, {circle[1]:.2f}), r = {circle[2]:.2f}"
    tally.check(abs(beside[0] / near - 1.0) <= SLICES, f"{stem}: circle of {at}: {near:.4f}, xslope {beside[0]:.4f}")
    for name, other in zip(("Bishop", "Spencer"), beside[1:], strict=False):
        tally.check(abs(best / other - 1.0) <= BISHOP, f"{stem}, psi = {psi}: {best:.3f} by xslope's {name} {other:.3f}")
    return rows


def main() -> int:
    """All files, the table, the sum."""
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("binary", type=pathlib.Path)
    words.add_argument("files", nargs="*", help="names of files (default all)")
    words.add_argument("--quick", action="store_true", help="10 cells a height, coarse bounds, no searches of xslope")
    words.add_argument("--markdown", type=pathlib.Path, help="write the table as a page")
    words.add_argument("--write", action="store_true", help="write the files from sections.py and end")
    given = words.parse_args()
    if given.write:
        for drawn in SECTIONS:
            WRITERS[pathlib.Path(drawn.file).suffix](drawn, HERE / drawn.file)
        return 0
    FOLDER.mkdir(parents=True, exist_ok=True)
    tally, start = Tally(), time.process_time()
    rows = [row for drawn in SECTIONS if not given.files or drawn.file in given.files for row in compare(given.binary.resolve(), drawn, given.quick, tally)]
    lines = ["| " + " | ".join(row) + " |" for row in (HEADS, ["---"] * len(HEADS), *rows)]
    print("\n".join(lines))
    if given.markdown:
        head = "Sections imported and solved, `verification/imported/run_imported.py build/qsmpm --markdown docs/data/imported.md`"
        given.markdown.write_text(f"{head}.\n\n" + "\n".join(lines) + "\n", encoding="utf-8")
    print(f"{time.process_time() - start:.0f} CPU s but for those of the runs")
    print(f"{tally.held} passed, {tally.missed} failed" + (f", {tally.left} skipped" if tally.left else ""))
    return 1 if tally.missed or not rows else 0


if __name__ == "__main__":
    sys.exit(main())
