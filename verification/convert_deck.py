#!/usr/bin/env python3
"""Words that were renamed: the reader names the new one, tools/convert-deck writes it, docs/renamed.md lists it.

Usage: convert_deck.py BINARY

Closes with `N passed, N failed`.
"""
from __future__ import annotations

import os
import pathlib
import re
import subprocess
import sys
import tempfile

TOP = pathlib.Path(__file__).resolve().parents[1]
PROGRAM = str(pathlib.Path(sys.argv[1]).resolve())
sys.path.insert(0, str(TOP / "tools"))
from qsmpm_verify.cpu_limit import run_limited  # noqa: E402

# A deck as it was written for an earlier version: old words in any case, over lines, in an included file, with CRLF.
OLD = """*HEADING\r
 Controls of a block, max holds=3,
*UNITS, LENGTH=m, FORCE=kN
*model, type=plane strain\r
*GRID, ELEMENT=QUAD4
 X, 0, 2, 4
 Y, 0, 2, 4
*NSET, NSET="max holds, proximal=1", PLANE=Y
 0
*INCLUDE, INPUT=soil.inp
*BODY, NAME=block, MATERIAL=soil, SHAPE=BOX
 0, 1, 0, 1
*POINTS, PER ELEMENT=4
*HISTORY, NAME=top, QUANTITY=DISPLACEMENT, COMPONENT=Y
 0.5, 1
*PHASE, NAME=weight
*FIX
 "max holds, proximal=1", ALL
*GRAVITY
 0, -1
** hold fade=0.5 is a comment
*controls, steps=2, LARGEST MOVE = 1,\r
\r
** and so is this
 Max   Holds=30, hold fade=1, few iterations=5,
 MANY ITERATIONS=12, Proximal=YES, DRAG SHARE=1e-3
*hold test, repeats=2
 0.5, 1
*END PHASE"""
SOIL = "*MATERIAL, NAME=soil\n*ELASTIC\n 100, 0.3\n*locking  cure, TYPE=NONE\n*UNIT WEIGHT\n 20\n"
NEW = (OLD.replace("LARGEST MOVE =", "MAX DISPLACEMENT =").replace("Max   Holds=", "MAX REEQUILIBRATIONS=")
       .replace("hold fade=1", "STABILISATION FADE=1").replace("few iterations=", "DESIRED MIN ITERATIONS=")
       .replace("MANY ITERATIONS=", "DESIRED MAX ITERATIONS=").replace("Proximal=", "DAMPING=")
       .replace("DRAG SHARE=", "DAMPING SHARE=").replace("*hold test", "*CONSTANT LOAD TEST"))
STANDARD = "*METHOD, BASIS=STANDARD"
MODEL = "*model, type=plane strain\r\n"

passed = failed = 0


def check(name: str, held: bool) -> None:
    """Count one test."""
    global passed, failed
    passed, failed = passed + bool(held), failed + (not held)
    print(("ok     " if held else "FAILED ") + name)


def convert(*words: str | pathlib.Path) -> bytes:
    """What tools/convert-deck says."""
    return subprocess.run([sys.executable, TOP / "tools" / "convert-deck", *words], check=True, capture_output=True,
                          env=os.environ | {"QSMPM": PROGRAM}).stdout


def qsmpm(*words: str | pathlib.Path) -> str:
    """What the program says to a call."""
    run = run_limited([PROGRAM, *words], 60.0)
    return run.output + run.errors


def curves(deck: pathlib.Path) -> str:
    """Curves of a run of a deck."""
    out = deck.with_suffix("")
    qsmpm("run", deck, "--out", out, "--quiet")
    return (out / "curves.csv").read_text()


with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    deck, soil = folder / "deck.inp", folder / "soil.inp"

    def write(text: str) -> None:
        """The deck and what it includes."""
        deck.write_bytes(text.encode())
        soil.write_text(SOIL)

    write(OLD)
    check("to the standard output", convert("--stdout", deck).decode() == NEW.replace(MODEL, MODEL + STANDARD + "\r\n"))
    check("which leaves the files alone", deck.read_bytes() == OLD.encode() and soil.read_text() == SOIL)
    convert("--words", deck)
    check("words in any case and over lines; comments, quotes, blanks and line ends stay", deck.read_bytes() == NEW.encode())
    check("words of the included file", soil.read_text() == SOIL.replace("*locking  cure", "*VOLUMETRIC LOCKING"))
    write(OLD)
    convert(deck)
    check("a deck that names no method is given the one it had", STANDARD in deck.read_text())
    done = deck.read_bytes()
    check("a converted deck is left alone", convert(deck) == b"" and deck.read_bytes() == done)
    converted = curves(deck)
    deck.write_text(NEW.replace(MODEL, MODEL + "*METHOD, BASIS=STANDARD, INTEGRATION=POINTS, STABILISATION=BACKGROUND\n"))
    check("and it has the results of that method", converted == curves(deck) and "damping_share" in converted)
    deck.write_text(NEW)
    check("which are not those of the method that is recommended", converted != curves(deck))
    for line, wanted in [("*METHOD, INTEGRATION=CELL", "*METHOD, BASIS=STANDARD, INTEGRATION=CELL"),
                         ("*method,basis=GIMP", "*method,basis=GIMP"),
                         ("* method,\n KINEMATICS=JAUMANN,\n Basis = SPLINE2", "* method,\n KINEMATICS=JAUMANN,\n Basis = SPLINE2")]:
        write(NEW.replace(MODEL, MODEL + line + "\n"))
        convert(deck)
        check(f"{line.splitlines()}: basis", deck.read_bytes().decode() == NEW.replace(MODEL, MODEL + wanted + "\n"))
    point = "*MATERIAL, NAME=soil\n*POINT TEST, TYPE=OEDOMETER\n*POINT STAGE\n AXIAL STRAIN, -0.01\n"
    deck.write_text(point)
    convert(deck)
    check("a test of a point has no basis", deck.read_text() == point)

    table = qsmpm("help", "renamed")
    rows = re.findall(r"^\| (\S+.*?) \| `(.*?)` \| `(.*?)` \|$", table, re.M)
    check("docs/renamed.md lists them", len(rows) > 5 and table.strip() in (TOP / "docs/renamed.md").read_text())
    for place, old, new in rows:
        if place.startswith("curves"):
            check(f"{place}: {old} is {new}", f",{new}," in converted and old not in converted)
            continue
        if place == "keyword":
            text, wanted = f"*{old}\n", f"deck.inp:1: *{old}: this keyword is now *{new} (tools/convert-deck"
        else:
            # A word of a parameter gives way to a card of its own, which no converter can fill.
            named = old if "=" in old else f"{old}=1"
            text = f"*MODEL, TYPE=3D\n*PHASE, NAME=a\n{place},\n {named}\n*END PHASE\n"
            wanted = f"deck.inp:3: {place}: {old} is now {new}\n" if "=" in old else \
                f"deck.inp:3: {place}: parameter {old} is now {new} (tools/convert-deck"
        deck.write_text(text)
        check(f"{place}: {old} is refused by its new name", wanted in qsmpm("check", deck))
print(f"{passed} passed, {failed} failed")
