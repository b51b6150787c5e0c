"""`plot`, `points` and `figures`: figures of finished runs."""

from __future__ import annotations

import argparse
from pathlib import Path

from qsmpm_verify import plots
from qsmpm_verify.told import read_phase


def add_words(verbs: argparse._SubParsersAction) -> None:
    """Arguments of the subcommands."""
    plot = verbs.add_parser("plot", help="draw the curves of runs in one diagram")
    plot.add_argument("results", nargs="+", type=Path, help="result folders of runs")
    plot.add_argument("--x", default="load_factor", help="column along x")
    plot.add_argument("--y", default=None, help="column along y; default the first history")
    plot.add_argument("--phase", type=read_phase, help="rows of one phase only, by name or number")
    plot.add_argument("--out", type=Path, default=Path("curves.png"), help="file of the figure")
    plot.set_defaults(act=draw_columns)
    points = verbs.add_parser("points", help="draw the material points of the last state, coloured by displacement")
    points.add_argument("results", nargs="+", type=Path)
    points.add_argument("--out", type=Path, default=Path("points.png"))
    points.set_defaults(act=draw_points)
    figures = verbs.add_parser(
        "figures", help="draw the figures of the paper from the runs of one folder, as produced by tools/demo"
    )
    figures.add_argument("folder", type=Path, help="folder that contains the runs, one for each deck")
    figures.add_argument("--out", type=Path, default=None, help="folder of the figures; default the same folder")
    figures.set_defaults(act=draw_figures)


def draw_columns(words: argparse.Namespace) -> int:
    """One column against another."""
    plots.plot_columns(words.results, words.x, words.y, words.out, words.phase)
    return 0


def draw_points(words: argparse.Namespace) -> int:
    """Material points of the last states."""
    plots.plot_points(words.results, words.out)
    return 0


def draw_figures(words: argparse.Namespace) -> int:
    """Figures of the paper."""
    for picture in plots.paper_figures(words.folder, words.out or words.folder):
        print(picture)
    return 0
