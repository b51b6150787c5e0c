#!/usr/bin/env python3
"""The gallery of the documentation: scenes with a known result, each with its picture, deck, CPU seconds, value and error.

Usage: gallery.py     (runs what has not been run, a minute of CPU time; writes docs/gallery.md and docs/figures/gallery_*.png)

A scene is a case of verification/cases, which gives its deck, its result and the source of the exact value.
"""
from __future__ import annotations

import json
import pathlib
import subprocess
import sys
from dataclasses import dataclass

TOP = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(TOP / "tools"))
from qsmpm_verify.cases import Case, load_all  # noqa: E402

VERIFY = TOP / "tools/qsmpm-verify"
PAGE = TOP / "docs/gallery.md"
HEAD = """# Gallery

These scenes have known results. They run with default settings unless their decks name others. `verification/gallery.py` runs them, draws the pictures and
writes this page. CPU seconds are those of the machine that wrote it. The decks belong to the named cases: `tools/qsmpm-verify run CASE` leaves the deck as it
was run in `build/verify/CASE/deck`.

"""


@dataclass(frozen=True)
class Scene:
    """A case, the quantity that is reported, what the picture shows, and the arguments of `qsmpm-verify` that draw it."""
    case: str
    quantity: str
    title: str
    seen: str
    draw: tuple[str, ...]

    def picture(self) -> pathlib.Path:
        return TOP / "docs/figures" / f"gallery_{self.case.replace('/', '_')}.png"


SCENES = (
    Scene("fitted/clay_slope", "last stable factor", "Factor of safety of a clay slope", "failure mechanism",
          ("view", "--mechanism")),
    Scene("fitted/seam_slides", "load that is carried", "A block that slides on a weak seam", "shear strain during sliding",
          ("view", "--field", "shear_strain", "--mesh")),
    Scene("fitted/footing", "limit load of the half, s_u = 1", "A strip footing on clay", "displacement at the limit load",
          ("view", "--field", "displacement", "--mesh")),
    Scene("clay_laws/footing_adp", "limit load", "A strip footing on anisotropic clay (NGI-ADP)", "displacement at the limit load",
          ("view", "--field", "displacement")),
    Scene("contact/pipe_smooth", "at three tenths", "A pipe pushed into the seabed", "accumulated shear strain",
          ("view", "--field", "accumulated_plastic_shear_strain")),
    Scene("contact/tbar_smooth", "force over strength and diameter, mean over half a cell of travel", "A T-bar at great depth in clay", "displacement",
          ("view", "--field", "displacement")),
    Scene("contact/wall_active", "active force on a smooth wall", "Active pressure on a wall", "horizontal displacement",
          ("view", "--field", "displacement_x")),
    Scene("tunnel/trough", "above the tunnel", "Volume loss of a tunnel", "settlement, ground 1000 m wide",
          ("view", "--field", "displacement_y", "--range", "-0.0003", "0")),
    Scene("water/storm", "after three days of rain", "Rainfall on a slope", "pore pressure after infiltration",
          ("view", "--field", "pore_pressure", "--phase", "storm")),
    Scene("consolidation/cylinder", "largest pressure in the middle, T = 0.06", "Consolidation of a cylinder of clay", "pore pressure against time",
          ("plot", "--x", "load_factor", "--y", "p")),
    Scene("clay_laws/creep_column", "settlement", "Creep of a column of soft clay over 10 000 days", "settlement against time",
          ("plot", "--x", "load_factor", "--y", "settlement")),
    Scene("strength_profile/shansep_drain", "strength of consolidated clay", "Strength increase of clay under a fill (SHANSEP)", "vertical stress",
          ("view", "--field", "stress_yy")),
    Scene("clay_laws/shear_loop", "after the loop", "A shear loop at small strain", "force against displacement",
          ("plot", "--x", "move", "--y", "shear")),
    Scene("softening_nonlocal/biaxial_16", "work of the whole run", "A shear band of prescribed width (nonlocal softening)", "accumulated shear strain",
          ("view", "--field", "accumulated_plastic_shear_strain")),
    Scene("rock/cylinder", "force a radian at the limit", "A rock cylinder with the Hoek-Brown criterion", "vertical stress",
          ("view", "--field", "stress_yy")),
    Scene("hardening/footing_clay_40", "load", "A plate on hardening soil", "vertical displacement",
          ("view", "--field", "displacement_y")),
    Scene("column_logarithmic/advised", "height", "A column that self-weight shortens by a quarter", "vertical stress",
          ("view", "--field", "stress_yy")),
)


def figures() -> dict[tuple[str, str], dict]:
    """Results of the cases, by case and quantity."""
    written = TOP / "build/gallery.json"
    ended = subprocess.run([VERIFY, "run", *[scene.case for scene in SCENES], "--effort", "long", "--json", written], cwd=TOP, check=False)
    if ended.returncode != 0:
        sys.exit("a scene of the gallery misses its tolerance")
    return {(row["case"], row["quantity"]): row for row in json.loads(written.read_text(encoding="utf-8"))}


def block(scene: Scene, case: Case, row: dict) -> str:
    """A scene of the page."""
    quantity = next(quantity for quantity in case.quantities if quantity.name == scene.quantity)
    subprocess.run([VERIFY, scene.draw[0], TOP / "build/verify" / scene.case / "results", *scene.draw[1:], "--out", scene.picture()], cwd=TOP, check=True,
                   stdout=subprocess.DEVNULL)
    deck = pathlib.Path(case.deck).resolve().relative_to(TOP)
    return (f"## {scene.title}\n![{scene.seen}](figures/{scene.picture().name})\n\n"
            f"{scene.seen[0].upper()}{scene.seen[1:]}; `{deck}`, case `{scene.case}`.\n\n"
            f"| {quantity.name} | exact | error | CPU s |\n|---|---|---|---|\n"
            f"| {row['value']:.5g} | {float(row['reference']):.5g}, {quantity.source} | {100 * row['error']:.2g} % | {row['cpu_seconds']:.2g} |\n")


def main() -> int:
    cases = load_all(TOP / "verification/cases", TOP)
    rows = figures()
    blocks = [block(scene, cases[scene.case], rows[scene.case, scene.quantity]) for scene in SCENES]
    PAGE.write_text(HEAD + "\n".join(blocks), encoding="utf-8")
    print(f"{PAGE.relative_to(TOP)}: {len(SCENES)} scenes")
    return 0


if __name__ == "__main__":
    sys.exit(main())
