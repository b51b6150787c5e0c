"""`plot`, `points` and `figures`: pictures of finished runs."""

from __future__ import annotations

import argparse
from pathlib import Path

from qsmpm_verify import plots
from qsmpm_verify.told import read_phase


def add_words(verbs: argparse._SubParsersAction) -> None:
    """Words of the verbs."""
    plot = verbs.add_parser("plot", help="draw the curves of runs over each other")
    plot.add_argument("results", nargs="+", type=Path, help="result folders of runs")
    plot.add_argument("--x", default="load_factor", help="column along x")
    plot.add_argument("--y", default=None, help="column along y; the first history when not given")
    plot.add_argument("--phase", type=read_phase, help="rows of a phase alone, by name or number")
    plot.add_argument("--out", type=Path, default=Path("curves.png"), help="picture to write")
    plot.set_defaults(act=draw_columns)
    points = verbs.add_parser("points", help="draw the material points of the last state, coloured by displacement")
    points.add_argument("results", nargs="+", type=Path)
    points.add_argument("--out", type=Path, default=Path("points.png"))
    points.set_defaults(act=draw_points)
    figures = verbs.add_parser(
        "figures", help="figures of the paper from runs under one folder, as the demo makes them"
    )
    figures.add_argument("folder", type=Path, help="folder that holds the runs, one a deck")
    figures.add_argument("--out", type=Path, default=None, help="folder of the pictures; the same when not given")
    figures.set_defaults(act=draw_figures)


def draw_columns(words: argparse.Namespace) -> int:
    """One column over another."""
    plots.plot_columns(words.results, words.x, words.y, words.out, words.phase)
    return 0


def draw_points(words: argparse.Namespace) -> int:
    """Points of last states."""
    plots.plot_points(words.results, words.out)
    return 0


def draw_figures(words: argparse.Namespace) -> int:
    """Figures of the paper."""
    for picture in plots.paper_figures(words.folder, words.out or words.folder):
        print(picture)
    return 0
