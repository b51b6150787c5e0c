"""Arguments of `import`: FILE, --to, --soils, --cells, --unit, --water, --gap, --analysis, --picture."""

from __future__ import annotations

import argparse
import subprocess
from pathlib import Path

from qsmpm_verify.importing.checks import check_section, check_soils
from qsmpm_verify.importing.deck import deck_of
from qsmpm_verify.importing.dxf import read_dxf
from qsmpm_verify.importing.gsz import read_gsz
from qsmpm_verify.importing.picture import draw_section
from qsmpm_verify.importing.rs2 import read_rs2
from qsmpm_verify.importing.section import METRES, Section
from qsmpm_verify.importing.slide import read_slide
from qsmpm_verify.importing.soils import missing, read_table, write_table
from qsmpm_verify.places import PROGRAM
from qsmpm_verify.trouble import RunFailed, Trouble

ELSEWHERE = {
    ".msh": "a mesh is read by the deck itself: *MESH, INPUT=FILE (docs/howto/mesh.md)",
    ".inp": "a mesh of Abaqus is read by the deck itself: *MESH, INPUT=FILE (docs/howto/mesh.md)",
    ".stl": "a closed surface is read by the deck itself: *BODY, SHAPE=POLYHEDRON, INPUT=FILE",
    ".dwg": "DWG is a closed format: save the drawing as DXF",
}


def add_words(verbs: argparse._SubParsersAction) -> None:
    """Arguments of the subcommand."""
    verb = verbs.add_parser("import", help="convert a section drawn in another program to a deck: DXF drawings, projects of GeoStudio, Slide2 and RS2")
    verb.add_argument("file", type=Path, help="drawing (.dxf) or project (.gsz, .slmd, .slim, .sli, .fez, .fea)")
    verb.add_argument("--to", type=Path, metavar="DECK", help="deck to write (default FILE with .inp)")
    verb.add_argument("--soils", type=Path, metavar="CSV", help="table of soils; it is written for completion if values are missing")
    verb.add_argument("--cells", type=whole, default=20, metavar="N", help="number of grid cells over the height (default 20)")
    verb.add_argument("--unit", choices=tuple(METRES), help="unit of a drawing, if it defines none or a wrong one")
    verb.add_argument("--water", metavar="LAYER", help="layer of the water level; default the layer with such a name")
    verb.add_argument("--gap", type=float, metavar="LENGTH", help="largest gap between lines that are joined, in metres")
    verb.add_argument("--analysis", metavar="NAME", help="name or number of an analysis or scenario of a project (default the first one)")
    verb.add_argument("--picture", type=Path, help="check figure (default DECK with .png)")
    verb.add_argument("--program", type=Path, default=PROGRAM, help="program that checks the deck")
    verb.set_defaults(act=act)


def whole(word: str) -> int:
    """A number of cells."""
    if not word.isdigit() or not 2 <= int(word) <= 1000:
        raise argparse.ArgumentTypeError(f"'{word}' is not a number of cells from 2 to 1000")
    return int(word)


def read(words: argparse.Namespace) -> Section:
    """The section of a file, by its format."""
    kind = words.file.suffix.lower()
    if kind == ".dxf":
        return read_dxf(words.file, words.unit, words.water, words.gap)
    if kind == ".gsz":
        return read_gsz(words.file, words.analysis)
    if kind not in (".slmd", ".slim", ".sli", ".fez", ".fea"):
        raise Trouble(f"{words.file}: {ELSEWHERE.get(kind, 'known are .dxf, .gsz, .slmd, .slim, .sli, .fez and .fea')}")
    try:
        return read_rs2(words.file) if kind in (".fez", ".fea") else read_slide(words.file, words.analysis)
    except (ValueError, IndexError, KeyError, StopIteration) as error:
        raise Trouble(f"{words.file}: damaged, or of an unsupported version ({error}): export the section as DXF") from error


def act(words: argparse.Namespace) -> int:
    """Read, request missing data, write, draw, check; report how data were interpreted and what was omitted."""
    section = read(words)
    check_section(section)
    deck = words.to or words.file.with_suffix(".inp")
    table = words.soils or deck.with_suffix(".soils.csv")
    if table.exists():
        read_table(table, section)
    check_soils(section)
    lacks = missing(section)
    picture = draw_section(section, words.picture or deck.with_suffix(".png"))
    if lacks:
        write_table(table, section)
        tell(section)
        print(f"picture    {picture}")
        raise Trouble(f"soil parameters are missing, {'; '.join(lacks)}: complete {table} and repeat the command")
    deck.write_text(deck_of(section, words.file.name, words.cells), encoding="utf-8")
    tell(section)
    print(f"picture    {picture}")
    print(f"deck       {deck}")
    check(words.program, deck)
    return 0


def tell(section: Section) -> None:
    """One line for each region, each note and each omission."""
    for region in section.regions:
        print(f"region     {region.name}: soil '{region.soil}', {len(region.outline)} corners")
    for note in section.notes:
        print(f"note       {note}")
    for what in section.left:
        print(f"omitted    {what}")


def check(program: Path, deck: Path) -> None:
    """The check of the deck by the program."""
    if not program.is_file():
        print(f"not checked: {program} not found")
        return
    done = subprocess.run([program.resolve(), "check", deck], capture_output=True, text=True, check=False, timeout=600)
    print(done.stdout, end="")
    if done.returncode:
        raise RunFailed(done.stderr.strip() or f"the program rejects {deck}")
