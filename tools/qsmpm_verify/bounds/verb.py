"""Arguments of `bounds`: DECK, --phase, --factor, --run, --step, --triangles, --passes, --out, --json."""

from __future__ import annotations

import argparse
import json
import math
from pathlib import Path

from qsmpm_verify.bounds.cone import Kind
from qsmpm_verify.bounds.deformed import deformed
from qsmpm_verify.bounds.flow import flows
from qsmpm_verify.bounds.picture import draw_mechanism
from qsmpm_verify.bounds.phases import read_scene
from qsmpm_verify.bounds.scene import Scene
from qsmpm_verify.bounds.search import Bound, Found, Search
from qsmpm_verify.bounds.words import name_of
from qsmpm_verify.study.cards import Deck, read_deck
from qsmpm_verify.trouble import Trouble

NAMES = {
    Kind.LOAD: "load factor at failure",
    Kind.MARGIN: "factor of safety",
    Kind.FORCE: "force of the prescribed motion, its power over the largest velocity",
}


def add_words(verbs: argparse._SubParsersAction) -> None:
    """Arguments of the subcommand."""
    verb = verbs.add_parser("bounds", help="compute upper and lower bounds of the limit load or factor of safety of a deck, by limit analysis")
    verb.add_argument("deck", type=Path, help="plane-strain deck with bodies of SHAPE=BOX or POLYGON and *MOHR COULOMB")
    verb.add_argument("--phase", help="phase to be analysed (default the last one)")
    verb.add_argument("--factor", action="store_true", help="factor of safety at the end of a phase that is not TYPE=SAFETY")
    verb.add_argument("--triangles", type=whole, default=500, metavar="N", help="initial number of triangles (default 500)")
    verb.add_argument("--passes", type=whole, default=3, metavar="N", help="number of bisections where the dissipation is largest (default 3)")
    verb.add_argument("--run", type=Path, metavar="DIR", help="use the deformed geometry of the run in DIR")
    verb.add_argument("--step", type=whole, metavar="N", help="after step N of this run (default the last one written)")
    verb.add_argument("--out", type=Path, help="figure of the mechanism (.png, .svg or .pdf)")
    verb.add_argument("--json", type=Path, help="JSON file of the bounds")
    verb.set_defaults(act=act)


def whole(word: str) -> int:
    """A non-negative integer."""
    if not word.isdigit():
        raise argparse.ArgumentTypeError(f"'{word}' is not a whole number")
    return int(word)


def bound_text(bound: Bound) -> str:
    """A bound, or the reason why there is none."""
    if bound.solved:
        return f"{bound.value:.6g}, {bound.seconds:.2g} CPU s"
    return f"none: solver status {bound.status}"


def report(scene: Scene, found: Found) -> None:
    """One line for each result."""
    print(f"phase      {scene.phase}: {NAMES[found.kind]}")
    print(f"upper      {bound_text(found.upper)}")
    print(f"lower      {bound_text(found.lower)}")
    if found.upper.solved and found.lower.solved and not found.both:
        print("bracket    none: the lower bound exceeds the upper bound, so one of them is wrong; use more --triangles or fewer --passes")
    if found.both:
        middle = 0.5 * (found.upper.value + found.lower.value)
        print(f"bracket    {middle:.6g} +- {0.5 * abs(found.upper.value - found.lower.value) / abs(middle):.2%} on {found.triangles} triangles")
    if found.reduced:
        print("strength   reduced after Davis where psi < phi: bounds for the reduced strength, an estimate for the deck")
    for text in scene.said:
        print(f"note       {text}")
    if flows(scene):
        print("water      pore pressures of the flow computed by the program on the grid of the deck: bounds for these pressures")


def record(scene: Scene, found: Found) -> dict[str, object]:
    """Output; a value that is not a bound is null."""

    def of(bound: Bound) -> dict[str, object]:
        wrong = found.upper.solved and found.lower.solved and not found.both
        value = bound.value if bound.solved and math.isfinite(bound.value) and not wrong else None
        return {"value": value, "status": bound.status, "cpu_seconds": round(bound.seconds, 3)}

    return {
        "phase": scene.phase, "quantity": NAMES[found.kind], "upper": of(found.upper), "lower": of(found.lower),
        "triangles": found.triangles, "davis": found.reduced, "seepage": flows(scene),
    }  # fmt: skip


def scale_of(deck: Deck, scene: Scene, history: str) -> float:
    """Ratio of a history to the power of the force: for a contact force along the motion of the only moving body; otherwise zero."""
    moving = {name: wall.velocity for name, wall in scene.walls.items() if wall.velocity != (0.0, 0.0)}
    for card in deck.all("HISTORY"):
        if name_of(card, "NAME") == history and card.value("QUANTITY") == "CONTACT FORCE" and len(moving) == 1 and name_of(card, "BODY") in moving:
            along = {"X": 0, "Y": 1}.get(card.value("COMPONENT") or "", 0)
            velocity = moving[name_of(card, "BODY")]
            scale = float(card.value("SCALE") or 1.0)
            return -scale * math.copysign(1.0, velocity[along]) if velocity[1 - along] == 0.0 else 0.0
    return 0.0


def note_of(deck: Deck, safety: bool, value: float | None, history: str = "") -> tuple[str, tuple[float, float] | None]:
    """A sentence for comparison with a result computed by another method, a factor or the force of a history, and its position relative to the
    bounds; also the bounds, where they hold for the strength of the deck, and for water on any grid."""
    try:
        scene = read_scene(deck, None, False)
        scale = scale_of(deck, scene, history) if scene.pushes else 1.0
        if scene.safety is not safety or scale == 0.0 or not (safety or scene.pushes or history in ("", "load_factor")):
            return "", None
        found = Search(scene).run()
    except Trouble as trouble:
        return f"no bounds of limit analysis: {trouble}", None
    if not found.both:
        return "no bounds of limit analysis: its optimisation problems were not solved", None
    low, high = sorted((scale * found.lower.value, scale * found.upper.value))
    text = f"limit analysis: between {low:.5g} and {high:.5g}" + (", strength reduced after Davis" if found.reduced else "")
    text += ", with the flow computed on the grid of the deck" if flows(scene) else ""
    other = found.reduced or flows(scene)
    if value is not None and not other and not low <= value <= high:
        beyond = value / high - 1.0 if value > high else value / low - 1.0
        text += f"; the result is {abs(beyond):.2%} {'above the upper' if beyond > 0 else 'below the lower'} bound"
    return text, None if other else (low, high)


def act(words: argparse.Namespace) -> int:
    """Read, solve, report; exit code 1 if a bound is missing."""
    if words.out is not None and words.out.suffix.lower() not in (".png", ".svg", ".pdf"):
        raise Trouble(f"{words.out}: a figure must be a .png, .svg or .pdf file")
    if not 20 <= words.triangles <= 20000 or words.passes > 8:
        raise Trouble("--triangles must be from 20 to 20000, --passes at most 8")
    if words.step is not None and words.run is None:
        raise Trouble("--step N requires --run DIR")
    deck = read_deck(words.deck)
    scene = read_scene(deck, words.phase, words.factor)
    if words.run is not None:
        scene = deformed(scene, deck, words.run, words.step)
    found = Search(scene, words.triangles, words.passes).run()
    report(scene, found)
    if words.json is not None:
        words.json.parent.mkdir(parents=True, exist_ok=True)
        words.json.write_text(json.dumps(record(scene, found), indent=1) + "\n", encoding="utf-8")
    if words.out is not None:
        print(draw_mechanism(scene, found, words.out))
    return 0 if found.both else 1
