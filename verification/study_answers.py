#!/usr/bin/env python3
"""`qsmpm-verify study` on scenes whose answers are known: does the band hold the answer, and is it no wider than it must be?

    verification/study_answers.py [NAME ...] [--program FILE] [--out DIR] [--budget 2min] [--markdown FILE]

Every scene is a deck of the repository, some with replacements, a figure and its true value. The table tells the value
the study gives, its band, how far off both are in truth, and how the choice compares with the cheapest run that really is
within the target. A scene whose figure does not converge, and one whose budget is too small, must say so.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import math
import shutil
import sys
from dataclasses import dataclass
from pathlib import Path

TOP = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(TOP / "tools"))

from factors import BRACKETS, SLOPES, slope_of  # noqa: E402
from qsmpm_verify.pages import figure_folder, markdown_table  # noqa: E402
from qsmpm_verify.reference import REFERENCES  # noqa: E402
from qsmpm_verify.report import table  # noqa: E402
from qsmpm_verify.study.cards import read_deck  # noqa: E402
from qsmpm_verify.study.judgement import Answer, answer_of, choice_of, seconds_of_choice, warnings_of  # noqa: E402
from qsmpm_verify.study.search import Search, Trial, Wish  # noqa: E402
from qsmpm_verify.study.telling import grid_text, tell_study  # noqa: E402
from qsmpm_verify.study.verb import seconds, tell_run  # noqa: E402

HEADER = ["scene", "truth", "answer", "+-", "off", "finest off", "band/finest off", "holds", "choice", "CPU s", "best CPU s"]


@dataclass(frozen=True)
class Scene:
    """A deck with an answer; NaN where no grid has one."""

    name: str
    deck: str
    history: str
    truth: float
    source: str
    replace: tuple[tuple[str, str], ...] = ()
    target: float = 0.01
    at: str = "last"
    budget: float = 0.0
    sure: float = 0.0
    """Share of the truth that itself is not sure."""
    text: str = ""
    """The deck itself where it is written here; `deck` then says where from."""


STIFF = (("1, 25, 25", "1000, 25, 25"), ("LOAD FACTOR=25", "LOAD FACTOR=5"), ("STEPS=100", "STEPS=5"))
NONE = math.nan
DRAWN = ("cantilever",)
BOUNDS = "bounds of limit analysis, as near as they are, `qsmpm-verify bounds DECK`"


def scenes() -> list[Scene]:
    """The scenes: those with answers, one that has none, one whose budget ends first."""
    bore = {"pressure": 435.815, "young": 1e4, "poisson": 0.3, "cohesion": 58.735026918962575, "friction": 30.0, "far": 400.0}
    decks = "verification/cases/decks"
    column = REFERENCES["column_height_hencky"](height=50.0, young=10.0, unit_weight=0.8)
    return [
        Scene("column", "input/column_logarithmic.inp", "top_height", column, "column_height_hencky", target=1e-3),
        Scene("cylinder", f"{decks}/cylinder.inp", "bore_growth", 1.9066666666666667e-6, "Lame (1852), of small strain: sure to the strain, 2e-6", target=1e-3,
              sure=2e-6),
        Scene("cavity", f"{decks}/cavity_pressure.inp", "growth", REFERENCES["cavity_growth_hencky"](**bore),
              "cavity_growth_hencky"),
        Scene("cantilever", "input/cantilever.inp", "tip_deflection", 8.2539, "own FEM of 8-node cells, none of size",
              sure=5e-5),
        Scene("footing", f"{decks}/footing_small.inp", "reaction", 2.0 + math.pi, "Prandtl (1920)", target=0.03),
        Scene("slope", f"{decks}/limit_load.inp", "crest_settlement", 1.52187e-5, "own FEM of triangles, none of size", STIFF,
              sure=5e-5),
        *slopes(),
        *week(),
        Scene("bands", f"{decks}/softening_biaxial.inp", "force", NONE, "no grid is the last one",
              (("REGULARISATION=CELL, LENGTH=0.1", "REGULARISATION=NONE"),)),
        Scene("cut", "input/footing.inp", "reaction", NONE, "the budget is ten seconds", budget=10.0),
    ]  # fmt: skip


def slopes() -> list[Scene]:
    """Factors of safety of slopes with psi = phi, 10 cells a height."""
    found = []
    for slope in SLOPES:
        low, high = BRACKETS[slope]
        sure = (high - low) / (high + low)
        found.append(Scene(f"slope {slope}", "verification/factors.py", "F", 0.5 * (low + high), BOUNDS, sure=sure, text=slope_of(slope, 10)[0]))
    return found


def week() -> list[Scene]:
    """Scenes of verification/week whose answer is no bound."""
    decks = "verification/week/decks"
    return [
        Scene("strip", f"{decks}/strip.inp", "load", 590.113, "characteristics, as in verification/week/footings.toml", target=0.03),
        Scene("circle", f"{decks}/circle.inp", "load", 631.46, "characteristics, as in verification/week/footings.toml", target=0.03),
        Scene("passive", f"{decks}/wall_passive.inp", "force", 117.877, "Rankine, of ground that does not heave before the wall: sure to 2 %", sure=0.02),
        Scene("active", f"{decks}/wall_active.inp", "force", 8.2822,
              "bounds of limit analysis 0.1 % around it, `qsmpm-verify bounds DECK`; the ground sinks by 4 mm of 2 m, the force with its square: sure to 0.5 %", sure=0.005),
        Scene("embankment", f"{decks}/embankment.inp", "F", 1.65761, BOUNDS, sure=0.0033),
        Scene("dam", f"{decks}/dam.inp", "F", 1.31783, BOUNDS, sure=0.0031),
        Scene("seam", f"{decks}/seam.inp", "F", 1.06444, BOUNDS, sure=0.0037),
        Scene("sample", "verification/cases/decks/sample_safety.inp", "F", 1.4867106, "Mohr-Coulomb between plates, as in verification/cases/safety.toml"),
    ]  # fmt: skip


def deck_of(scene: Scene, folder: Path) -> Path:
    """The deck itself, or a copy of it with the replacements."""
    path = TOP / scene.deck
    if not scene.replace and not scene.text:
        return path
    text = scene.text or path.read_text(encoding="utf-8")
    for old, new in scene.replace:
        if old not in text:
            sys.exit(f"{path}: nothing to replace at {old!r}")
        text = text.replace(old, new)
    folder.mkdir(parents=True, exist_ok=True)
    copy = folder / f"{file_name(scene)}.inp"
    copy.write_text(text, encoding="utf-8")
    return copy


def file_name(scene: Scene) -> str:
    """The name of a scene in a path."""
    return scene.name.replace(" ", "_").replace("/", "_")


def studied(scene: Scene, words: argparse.Namespace) -> tuple[Search, Answer | None, Trial | None]:
    """Run the study of a scene; what it prints goes to study.txt beside its runs."""
    root = words.out / file_name(scene)
    deck = read_deck(deck_of(scene, words.out / "decks"))
    wish = Wish(scene.history, scene.at, scene.target, scene.budget or words.budget, words.program.resolve(), root)
    search = Search(deck, wish, tell_run)
    search.go(lambda trials: seconds_of_choice(trials, scene.target))
    answer = answer_of(search.trials)
    choice = choice_of(search.trials, answer, scene.target)
    told = io.StringIO()
    with contextlib.redirect_stdout(told):
        tell_study(search, answer, choice, warnings_of(deck))
    (root / "study.txt").write_text(told.getvalue(), encoding="utf-8")
    return search, answer, choice


def row_of(scene: Scene, search: Search, answer: Answer | None, choice: Trial | None) -> list[str]:
    """A row of the table."""
    if answer is None:
        return [scene.name, number(scene.truth), "none", "-", "-", "-", "-", "-", "none", "-", "-"]
    good = [t for t in search.trials if t.good]
    finest = max((t for t in good if t.method in answer.methods), key=lambda t: (t.level, t.seconds))
    off, finest_off = abs(answer.value - scene.truth), abs(finest.figure - scene.truth)
    near = [t.seconds for t in good if abs(t.figure - scene.truth) <= scene.target * abs(scene.truth)]
    known = math.isfinite(scene.truth)
    return [
        scene.name, number(scene.truth), f"{answer.value:.6g}", f"{answer.half:.2g}", number(off, 2), number(finest_off, 2),
        f"{answer.half / finest_off:.2g}" if known else "-", ("yes" if off <= answer.half + scene.sure * abs(scene.truth) else "NO") if known else "-",
        f"{choice.method}, {grid_text(choice)}" if choice else "none", f"{choice.seconds:.3g}" if choice else "-",
        f"{min(near):.3g}" if near else "-",
    ]  # fmt: skip


def number(value: float, digits: int = 6) -> str:
    """A number; a dash where there is none."""
    return f"{value:.{digits}g}" if math.isfinite(value) else "-"


def main() -> int:
    """Run the scenes, print the table, write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--program", type=Path, default=TOP / "build" / "qsmpm")
    parser.add_argument("--out", type=Path, default=TOP / "build" / "study")
    parser.add_argument("--budget", type=seconds, default=120.0)
    parser.add_argument("--markdown", type=Path)
    words = parser.parse_args()
    chosen = [s for s in scenes() if not words.names or s.name in words.names]
    rows, endings = [], []
    for scene in chosen:
        search, answer, choice = studied(scene, words)
        rows.append(row_of(scene, search, answer, choice))
        endings.append(f"- {scene.name}: {scene.deck}, `{scene.history}`; truth: {scene.source}. Ended: {search.ending}."
                       + "".join(f" {note}." for note in (answer.notes if answer else ())))
    print(table(HEADER, rows))
    known = [row for scene, row in zip(chosen, rows) if math.isfinite(scene.truth)]
    none = sum(row[2] == "none" for row in known)
    held = f"The band holds the truth in {sum(row[7] == 'yes' for row in known)} of {len(known)} scenes that have one; {none} got no answer."
    print(held)
    print("\n".join(endings))
    if words.markdown:
        page = ["# The answers of `study` where the truth is known", "",
                f"Written by `verification/study_answers.py --budget {words.budget:.0f}s --markdown FILE`; do not edit.", "",
                *markdown_table(HEADER, rows), "", held, "", *endings]  # fmt: skip
        for scene in (s for s in chosen if s.name in DRAWN):
            shutil.copy(words.out / scene.name / "study.svg", figure_folder(words.markdown) / f"study_{scene.name}.svg")
        words.markdown.write_text("\n".join(page) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
