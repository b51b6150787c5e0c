#!/usr/bin/env python3
"""Random decks, meshes, restart files and calls of the library, from a seed: what the program makes of them.

    verification/fuzz.py                              some hundred, as tools/test runs them
    verification/fuzz.py --count 20000 --seed 7       any number; --keep FOLDER keeps the input of each finding
    verification/fuzz.py --kind mesh --only 7:mesh:113    one of them again

Kinds: `valid` (decks drawn from the words of the deck, meant to be good), `broken` (decks with a word, a number or a
line changed), `mesh` (damaged Gmsh, Abaqus and STL files), `restart` (damaged restart files), `calls` (sequences of
calls of the C interface with any arguments). A finding is a signal, a hang (more than CPU_SECONDS), an exit code
that docs/conventions.md does not name, exit code 0 with a result that is not finite, a failure without a message, or a
damaged restart file that is read with other results. Closes with `N passed, N failed`: a test an input.
"""

from __future__ import annotations

import argparse
import ctypes
import dataclasses
import math
import pathlib
import random
import re
import shutil
import sys
import tempfile
import zlib

import h5py
import numpy as np

TOP = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(TOP / "tools"))
from qsmpm_verify.cpu_limit import Ended, run_limited  # noqa: E402

CPU_SECONDS = 30.0
CODES = {0, 1, 2, 3, 4, 5, 6}
SEAL = len(b"qsmpm crc32 00000000\n")
SHARES = {"valid": 0.15, "broken": 0.35, "mesh": 0.30, "restart": 0.12, "calls": 0.08}
DECKS = TOP / "verification" / "cases" / "decks"
NUMBER = re.compile(r"(?<![\w.])[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?(?![\w.])")
NUMBERS = ["0", "-1", "1", "2", "7", "1e-30", "1e30", "1e300", "-1e300", "1e999", "nan", "inf", "-0", "2147483647",
           "2147483648", "99999999999999999999", "0.5", "1e-300", "", "1.5.2", "0x10", "1e", "-"]
WORDS = ["", "ALL", "NONE", "soil", "base", "X", "Y", "Z", "XX", "YES", "NO", "\"", "=", ",", "*", "**", "ä", "\0", "\t",
         "a" * 300, "%s%n", "../../etc", "3D"]


@dataclasses.dataclass
class Outcome:
    """What became of one input."""

    name: str
    code: int | None
    finding: str = ""


def one_of(lot: random.Random, *choices: str) -> str:
    """One of some words."""
    return lot.choice(choices)


def number(lot: random.Random, low: float, high: float) -> str:
    """A number between two, in short."""
    return f"{lot.uniform(low, high):.4g}"


# ---- decks that are meant to be good -------------------------------------------------------------------------------


def method(lot: random.Random) -> str:
    """A *METHOD that the elements of the grid allow."""
    basis = one_of(lot, "STANDARD", "STANDARD", "FEM", "GIMP", "SPLINE2", "SPLINE2G", "SPLINE3")
    words = [f"BASIS={basis}"]
    if basis != "FEM":
        words.append(f"INTEGRATION={one_of(lot, 'CELL', 'POINTS')}")
        if lot.random() < 0.3:
            words.append(f"STABILISATION={'GHOST' if basis != 'STANDARD' else one_of(lot, 'GHOST', 'BACKGROUND')}")
            words.append(f"FACTOR={one_of(lot, '1e-6', '1e-3', '0.1')}")
    if lot.random() < 0.3:
        words.append(f"KINEMATICS={one_of(lot, 'JAUMANN', 'LOGARITHMIC')}")
    return "*METHOD, " + ", ".join(words)


def material(lot: random.Random) -> str:
    """A material with its weight."""
    kind = lot.randrange(5)
    text = f"*ELASTIC\n{number(lot, 50, 5000)}, {one_of(lot, '0', '0.3', '0.45', '0.495', '-0.3')}"
    if kind in (1, 2):
        friction = lot.choice([0, 20, 35])
        text += f"\n*MOHR COULOMB\n{number(lot, 0.2, 20)}, {friction}, {lot.choice([0, friction // 2, friction])}"
    if kind == 2:
        text += "\n*SOFTENING, TYPE=LINEAR, LENGTH=0.1\n0.1, 0, 0, 0.2"
    if kind == 3:
        text = f"*CAM CLAY, OCR={number(lot, 1, 3)}\n1.1, 0.2, 0.04, 2.1, 0.25"
    return text + f"\n*UNIT WEIGHT\n{number(lot, 0.1, 20)}"


def valid_deck(lot: random.Random) -> str:
    """A block on a base, drawn from the words of the deck."""
    solid = lot.random() < 0.15
    scheme = method(lot)
    spline = not re.search("STANDARD|FEM", scheme)
    flat = ("QUAD4",) if spline else ("QUAD4", "QUAD8", "TRI3", "TRI6")
    element = one_of(lot, *(("HEX8",) if spline else ("HEX8", "TET4", "TET10", "WEDGE6")) if solid else flat)
    model = "3D" if solid else one_of(lot, "PLANE STRAIN", "PLANE STRAIN", "AXISYMMETRIC")
    cells, rows, third = lot.randint(2, 5), lot.randint(2, 6), ", 0, 1" if solid else ""
    width, height = number(lot, 0.3, 1.5), number(lot, 0.3, 1.4)
    if "FEM" in scheme:
        # A carried mesh holds whole cells.
        width, height = f"{lot.randint(1, 2 * cells) / cells:.17g}", f"{1.5 * lot.randint(1, rows) / rows:.17g}"
    lines = ["*HEADING", "Random deck.", f"*MODEL, TYPE={model}", f"*GRID, ELEMENT={element}", f"X, 0, 2, {2 * cells}",
             f"Y, 0, 1.5, {rows}"]
    lines += ["Z, 0, 1, 2"] if solid else []
    lines += ["*NSET, NSET=base, PLANE=Y", "0", "*NSET, NSET=side, PLANE=X", "0", "*MATERIAL, NAME=soil", material(lot),
              "*BODY, NAME=block, MATERIAL=soil, SHAPE=BOX", f"0, {width}, 0, {height}{third}", scheme]
    lines += ["*SURFACE, NAME=top, TYPE=SEGMENT", f"{width}, {height}, 0, {height}"] if not solid else []
    lines += ["*HISTORY, NAME=u, QUANTITY=DISPLACEMENT, COMPONENT=Y", f"0.1, 0.1{', 0.1' if solid else ''}",
              "*HISTORY, NAME=r, QUANTITY=REACTION, COMPONENT=Y, NSET=base", "*RESTART, EVERY=1"]
    for phase in range(lot.randint(1, 2)):
        lines += [f"*PHASE, NAME=p{phase}, LOAD FACTOR={number(lot, 0.1, 3)}"]
        if phase == 0:
            if "CAM CLAY" in material_of(lines):
                lines += ["*INITIAL, TYPE=K0", f"{height}, 0.6"]
            lines += ["*FIX", "base, ALL", "side, X"]
            lines += ["*GRAVITY", f"0, -1{', 0' if solid else ''}"]
        elif not solid:
            lines += [one_of(lot, f"*TRACTION, SURFACE=top\n0, -{number(lot, 0.01, 2)}",
                             f"*PRESSURE, SURFACE=top\n{number(lot, 0.01, 2)}", "*RESET DISPLACEMENTS")]
        lines += [f"*CONTROLS, STEPS={lot.randint(1, 3)}, TOLERANCE={one_of(lot, '1e-3', '1e-6', '1e-9')}"
                  + one_of(lot, ", DAMPING=NO", *(", MAX SUBSTEPS=8" + more for more in (
                      "", ", NEWTON=MODIFIED", ", STEP ERROR=0.05", ", LINE SEARCH=NO")))
                  + ", SMALLEST STEP=0.5", "*END PHASE"]
    return "\n".join(lines) + "\n"


def material_of(lines: list[str]) -> str:
    """The text so far, to see which material it has."""
    return "\n".join(lines)


# ---- damage --------------------------------------------------------------------------------------------------------


def damage_text(lot: random.Random, text: str) -> str:
    """A text with one to three changes: of a number, a word, a line, a letter, the end."""
    for _ in range(lot.randint(1, 3)):
        lines = text.split("\n")
        at = lot.randrange(len(lines))
        way = lot.randrange(9)
        if way <= 2:
            found = list(NUMBER.finditer(text))
            if found:
                hit = lot.choice(found)
                text = text[:hit.start()] + lot.choice(NUMBERS) + text[hit.end():]
            continue
        if way == 3:
            parts = lines[at].split(",")
            parts[lot.randrange(len(parts))] = lot.choice(WORDS)
            lines[at] = ",".join(parts)
        elif way == 4:
            del lines[at]
        elif way == 5:
            lines.insert(lot.randrange(len(lines) + 1), lines[at])
        elif way == 6:
            other = lot.randrange(len(lines))
            lines[at], lines[other] = lines[other], lines[at]
        elif way == 7 and lines[at]:
            place = lot.randrange(len(lines[at]))
            lines[at] = lines[at][:place] + lot.choice(WORDS) + lines[at][place + 1:]
        elif way == 8:
            del lines[at + 1:]
            lines[at] = lines[at][:lot.randrange(len(lines[at]) + 1)]
        text = "\n".join(lines)
    return text


def damage_bytes(lot: random.Random, content: bytes) -> bytes:
    """Bytes with some of them changed, cut off, put in or repeated."""
    changed = bytearray(content)
    way = lot.randrange(6)
    if way <= 2:
        for _ in range(1 if way == 0 else lot.randint(1, 20)):
            changed[lot.randrange(len(changed))] ^= 1 << lot.randrange(8)
    elif way == 3:
        del changed[lot.randrange(len(changed)):]
    elif way == 4:
        at, length = lot.randrange(len(changed)), lot.randint(1, 64)
        changed[at:at + length] = bytes(lot.randrange(256) for _ in range(length if lot.random() < 0.7 else 0))
    else:
        at = lot.randrange(len(changed))
        changed[at:at] = changed[at:at + lot.randint(1, 200)]
    return bytes(changed)


def resealed(content: bytes) -> bytes:
    """Bytes with the last line that says they are whole."""
    return content + b"qsmpm crc32 %08X\n" % zlib.crc32(content)


# ---- the trials ----------------------------------------------------------------------------------------------------


class Fuzz:
    """The program under trial and a folder to work in."""

    def __init__(self, program: pathlib.Path, seed: int, work: pathlib.Path, keep: pathlib.Path | None) -> None:
        self.program, self.seed, self.work, self.keep = program, seed, work, keep
        self.restarts: dict[str, tuple[str, bytes, str]] = {}

    def lot(self, kind: str, index: int) -> random.Random:
        """The numbers of one trial, whatever else is tried."""
        return random.Random(f"{self.seed}:{kind}:{index}")

    def run(self, folder: pathlib.Path, *more: str, out: str = "out") -> Ended:
        """Run the deck of a folder."""
        return run_limited([self.program, "run", "deck.inp", "--out", out, "--quiet", *more], CPU_SECONDS, cwd=folder)

    def valid(self, lot: random.Random, folder: pathlib.Path) -> tuple[int | None, str]:
        """A deck that is meant to be good."""
        (folder / "deck.inp").write_text(valid_deck(lot))
        ended = self.run(folder)
        return ended.code, judge(ended, folder / "out")

    def broken(self, lot: random.Random, folder: pathlib.Path) -> tuple[int | None, str]:
        """A good deck with changes."""
        text = valid_deck(lot)
        if lot.random() < 0.4:
            text = lot.choice(sorted(DECKS.glob("*.inp"))).read_text()
            text = re.sub(r"STEPS=\d+", "STEPS=1", re.sub(r"(?m)^([XYZ], \S+, \S+), \d+", r"\1, 3", text))
            link_neighbours(folder)
        (folder / "deck.inp").write_text(damage_text(lot, text))
        ended = self.run(folder)
        return ended.code, judge(ended, folder / "out")

    def mesh(self, lot: random.Random, folder: pathlib.Path) -> tuple[int | None, str]:
        """A deck with a damaged file beside it."""
        deck, name, content = lot.choice(MESHES)()
        content = damage_bytes(lot, content) if lot.random() < 0.4 else \
            damage_text(lot, content.decode("latin-1")).encode("latin-1", "replace")
        (folder / name).write_bytes(content)
        (folder / "deck.inp").write_text(deck)
        ended = self.run(folder)
        return ended.code, judge(ended, folder / "out")

    def restart(self, lot: random.Random, folder: pathlib.Path) -> tuple[int | None, str]:
        """A damaged restart file: refused, or read as if it were whole. Half of them have a seal that is right, so that
        what reads them is tried too."""
        kind = lot.choice(["QUAD4", "TRI6"])
        if kind not in self.restarts:
            self.restarts[kind] = self.make_restart(kind)
        deck, content, curves = self.restarts[kind]
        (folder / "deck.inp").write_text(deck)
        sealed = lot.random() < 0.5
        content = resealed(damage_bytes(lot, content[:-SEAL])) if sealed else damage_bytes(lot, content)
        (folder / "restart.h5").write_bytes(content)
        ended = self.run(folder, "--restart", "restart.h5")
        finding = judge(ended, folder / "out")
        if not finding and not sealed and ended.code == 0 and last_row(folder / "out") != curves:
            finding = "a damaged restart file is read with other results"
        return ended.code, finding

    def make_restart(self, element: str) -> tuple[str, bytes, str]:
        """A deck, the restart file of its middle and the last row of its curves."""
        folder = self.work / f"whole_{element}"
        folder.mkdir()
        block = ["*MODEL, TYPE=PLANE STRAIN", f"*GRID, ELEMENT={element}", "X, 0, 2, 4", "Y, 0, 1.5, 3",
                 "*NSET, NSET=base, PLANE=Y", "0", "*MATERIAL, NAME=soil", "*ELASTIC", "100, 0.3", "*MOHR COULOMB",
                 "0.3, 30, 0", "*UNIT WEIGHT", "1", "*BODY, NAME=block, MATERIAL=soil, SHAPE=BOX", "0, 1, 0, 1",
                 "*METHOD, INTEGRATION=CELL", "*HISTORY, NAME=u, QUANTITY=DISPLACEMENT, COMPONENT=Y", "0.5, 0.9",
                 "*RESTART, EVERY=1", "*PHASE, NAME=one, LOAD FACTOR=0.5", "*FIX", "base, ALL", "*GRAVITY", "0, -1",
                 "*CONTROLS, STEPS=2", "*END PHASE", "*PHASE, NAME=two", "*GRAVITY", "0, -1", "*CONTROLS, STEPS=2",
                 "*END PHASE"]
        deck = "\n".join(block) + "\n"
        (folder / "deck.inp").write_text(deck)
        half = run_limited([sys.executable, __file__, "--half", str(self.program.parent / "libqsmpm.so")], CPU_SECONDS,
                           cwd=folder)
        if half.code != 0:
            sys.exit(f"the deck of the restart files does not run: {half.errors}")
        ended = self.run(folder, "--restart", "half.h5")
        if ended.code != 0:
            sys.exit(f"a whole restart file is refused: {ended.errors}")
        return deck, (folder / "half.h5").read_bytes(), last_row(folder / "out")

    def calls(self, lot: random.Random, folder: pathlib.Path) -> tuple[int | None, str]:
        """Calls of the C interface, in a process of their own."""
        (folder / "deck.inp").write_text(valid_deck(lot))
        library = self.program.parent / "libqsmpm.so"
        ended = run_limited([sys.executable, __file__, "--child", str(lot.randrange(10**9)), str(library)], CPU_SECONDS,
                            cwd=folder)
        if ended.code == 0:
            return 0, ""
        last = (ended.output.strip().splitlines() or ["nothing called"])[-1]
        return ended.code, f"{ended.how}: {last} {ended.errors.strip()[-200:]}"

    def trial(self, kind: str, index: int) -> Outcome:
        """One input, judged."""
        folder = self.work / f"{kind}_{index}"
        folder.mkdir()
        code, finding = getattr(self, kind)(self.lot(kind, index), folder)
        name = f"{self.seed}:{kind}:{index}"
        if finding and self.keep:
            shutil.copytree(folder, self.keep / name.replace(":", "_"), dirs_exist_ok=True, symlinks=True)
        shutil.rmtree(folder, ignore_errors=True)
        return Outcome(name, code, finding)


def link_neighbours(folder: pathlib.Path) -> None:
    """The files that the decks of the cases name."""
    for path in DECKS.iterdir():
        if path.suffix in (".msh", ".stl"):
            (folder / path.name).symlink_to(path)


def judge(ended: Ended, out: pathlib.Path) -> str:
    """What is wrong with the end of a run, empty when nothing is."""
    if ended.code is None or ended.code < 0 or ended.code not in CODES:
        return f"{ended.how}: {ended.errors.strip()[-160:]}"
    if ended.code != 0:
        said = (ended.output + ended.errors).strip()
        return "" if len(said) > 10 else f"exit code {ended.code} without a message"
    if not (out / "curves.csv").exists():
        return "exit code 0 without results"
    for row in (out / "curves.csv").read_text().splitlines()[1:]:
        for cell in row.split(","):
            if not math.isfinite(float(cell or "0")):
                return f"exit code 0 with {cell} in curves.csv"
    for path in sorted(out.glob("results/[0-9]*.h5"))[-1:]:
        with h5py.File(path) as file:
            for name, values in file["step/points"].items():
                if not np.isfinite(values[...]).all():
                    return f"exit code 0 with {name} that is not finite in {path.name}"
    return ""


def last_row(out: pathlib.Path) -> str:
    """The last row of the curves of a run."""
    lines = (out / "curves.csv").read_text().splitlines() if (out / "curves.csv").exists() else [""]
    return lines[-1]


def gmsh() -> tuple[str, str, bytes]:
    """A deck with a Gmsh mesh of sets."""
    deck = (DECKS / "patch.inp").read_text()
    return deck, "patch.msh", (DECKS / "patch.msh").read_bytes()


def abaqus() -> tuple[str, str, bytes]:
    """A deck with an Abaqus mesh of 3 by 2 squares."""
    nodes = [f"{1 + i + 4 * j}, {i * 0.5}, {j * 0.5}" for j in range(3) for i in range(4)]
    cells = [f"{1 + i + 3 * j}, {1 + i + 4 * j}, {2 + i + 4 * j}, {6 + i + 4 * j}, {5 + i + 4 * j}"
             for j in range(2) for i in range(3)]
    mesh = ["*HEADING", "A mesh", "*PART, NAME=p", "*NODE, NSET=every", *nodes, "*ELEMENT, TYPE=CPE4, ELSET=body", *cells,
            "*NSET, NSET=base, GENERATE", "1, 4, 1", "*NSET, NSET=top", "9, 10, 11, 12", "*ELSET, ELSET=half", "1, 2, 3",
            "*SURFACE, NAME=loaded", "half, S1", "*END PART", "*ASSEMBLY, NAME=a", "*INSTANCE, NAME=i, PART=p",
            "*END INSTANCE", "*END ASSEMBLY"]
    deck = ["*MODEL, TYPE=PLANE STRAIN", "*MESH, INPUT=mesh.inp", "*MATERIAL, NAME=soil", "*ELASTIC", "100, 0.3",
            "*UNIT WEIGHT", "1", "*BODY, NAME=b, MATERIAL=soil, SHAPE=ALL", "*METHOD, BASIS=FEM", "*PHASE, NAME=one", "*FIX",
            "base, ALL", "*GRAVITY", "0, -1", "*CONTROLS, STEPS=1", "*END PHASE"]
    return "\n".join(deck) + "\n", "mesh.inp", ("\n".join(mesh) + "\n").encode()


def stl() -> tuple[str, str, bytes]:
    """A deck with a tetrahedron as STL, ASCII."""
    corners = [(0.1, 0.0, 0.1), (0.9, 0.0, 0.1), (0.4, 0.0, 0.9), (0.5, 0.8, 0.4)]
    facets = []
    for a, b, c in ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)):
        places = "\n".join("vertex {} {} {}".format(*corners[k]) for k in (a, b, c))
        facets.append(f"facet normal 0 0 0\nouter loop\n{places}\nendloop\nendfacet")
    content = "solid body\n" + "\n".join(facets) + "\nendsolid body\n"
    deck = ["*MODEL, TYPE=3D", "*GRID, ELEMENT=HEX8", "X, 0, 1, 3", "Y, 0, 1, 3", "Z, 0, 1, 3", "*NSET, NSET=base, PLANE=Y",
            "0", "*MATERIAL, NAME=soil", "*ELASTIC", "100, 0.3", "*UNIT WEIGHT", "1",
            "*BODY, NAME=b, MATERIAL=soil, SHAPE=POLYHEDRON, INPUT=body.stl", "*PHASE, NAME=one", "*FIX", "base, ALL",
            "*GRAVITY", "0, -1, 0", "*CONTROLS, STEPS=1, MAX SUBSTEPS=20, SMALLEST STEP=0.5", "*END PHASE"]
    return "\n".join(deck) + "\n", "body.stl", content.encode()


MESHES = [gmsh, abaqus, stl]


# ---- calls of the C interface, in a process of their own -----------------------------------------------------------


def prototypes() -> list[tuple[str, list[str]]]:
    """Functions of the header and the types of their arguments."""
    text = re.sub(r"/\*.*?\*/", "", (TOP / "src/api/include/qsmpm.h").read_text(), flags=re.S)
    return [(name, [word.strip() for word in arguments.split(",") if word.strip() != "void"])
            for name, arguments in re.findall(r"^int (qsmpm_\w+)\(([^)]*)\);", text, re.M)]


class Caller:
    """Calls with arguments drawn by chance; buffers are as long as they are said to be."""

    def __init__(self, seed: int, library: str) -> None:
        self.lot = random.Random(seed)
        self.library = ctypes.CDLL(library)
        self.handles = [ctypes.c_void_p() for _ in range(2)]
        self.reals = (ctypes.c_double * 4096)()
        self.integers = (ctypes.c_int * 4096)()
        self.buffer = ctypes.create_string_buffer(512)
        self.options = (ctypes.c_int * 32)()
        self.texts = [b"deck.inp", b"nowhere.inp", b"", b"soil", b"base", b"side", b"top", b"p0", b"value", b"history",
                      b"set", b"point_stress", b"point_position", b"point_force", b"point_state", b"histories", b"out",
                      b"saved.h5", b"a" * 400, b"\xff\xfe", b"*MODEL, TYPE=PLANE STRAIN\n",
                      pathlib.Path("deck.inp").read_bytes(), None]

    def argument(self, kind: str) -> object:
        """One argument of a type."""
        lot = self.lot
        if kind.startswith("qsmpm_handle *"):
            return ctypes.byref(lot.choice(self.handles)) if lot.random() < 0.95 else None
        if kind.startswith("qsmpm_handle"):
            return lot.choice(self.handles) if lot.random() < 0.95 else None
        if kind.startswith("const char"):
            return lot.choice(self.texts)
        if kind.startswith("char *"):
            return self.buffer if lot.random() < 0.9 else None
        if "double **" in kind:
            return ctypes.byref(ctypes.c_void_p()) if lot.random() < 0.9 else None
        if "double *" in kind:
            for i in range(12):
                self.reals[i] = lot.choice([0.0, 1.0, -1.0, 1e-3, 1e300, math.inf, math.nan])
            return self.reals if lot.random() < 0.9 else None
        if kind.startswith(("int *", "const int *")):
            for i in range(12):
                self.integers[i] = lot.choice([0, 1, 2, -1, 7])
            return self.integers if lot.random() < 0.9 else None
        if kind.startswith("double"):
            return ctypes.c_double(lot.choice([0.0, 0.3, 0.5, 1.0, 2.0, -1.0, 1e300, math.inf, -math.inf, math.nan]))
        if kind == "int size":
            return lot.choice([512, 512, 100, 1, 0, -5])
        if kind.startswith("int"):
            return lot.choice([0, 1, 2, 3, 4, 6, 12, 100, 4096, -1, -2147483648])
        # Loggers, user data, model options and functions: none.
        return None

    def call(self, name: str, kinds: list[str]) -> None:
        """One call; a failure must have a sentence."""
        arguments = [self.argument(kind) for kind in kinds]
        print(name, [getattr(a, "value", a) if not isinstance(a, bytes) else a[:30] for a in arguments], flush=True)
        code = getattr(self.library, name)(*arguments)
        statuses = "version" not in name and name not in ("qsmpm_has", "qsmpm_finished", "qsmpm_name", "qsmpm_error",
                                                          "qsmpm_messages", "qsmpm_create", "qsmpm_destroy")
        if not statuses or code == 0:
            return
        if code not in {1, 2, 3, 4, 5, 6, 7, 128 + 2, 128 + 15}:
            sys.exit(f"status {code}")
        handle = arguments[0] if kinds and kinds[0].startswith("qsmpm_handle") else None
        if code != 7 and isinstance(handle, ctypes.c_void_p) and handle.value:
            told = ctypes.create_string_buffer(512)
            self.library.qsmpm_error(handle, told, 512)
            if not told.value:
                sys.exit(f"status {code} without a sentence")

    def run(self) -> None:
        """Some calls; a run that has ended well has finite stresses."""
        functions = prototypes()
        by_name = dict(functions)
        self.library.qsmpm_create(ctypes.byref(self.handles[0]))
        if self.lot.random() < 0.7:
            self.library.qsmpm_read_deck(self.handles[0], b"deck.inp")
            if self.lot.random() < 0.7:
                self.library.qsmpm_initialise(self.handles[0])
        for _ in range(self.lot.randint(10, 60)):
            name, kinds = self.lot.choice(functions)
            if self.lot.random() < 0.2:
                name = self.lot.choice(["qsmpm_advance", "qsmpm_initialise", "qsmpm_set_displacement", "qsmpm_get"])
                kinds = by_name[name]
            self.call(name, kinds)
        for handle in self.handles:
            self.library.qsmpm_destroy(ctypes.byref(handle))


def save_half(path: str) -> int:
    """Take three steps of a deck and save the state."""
    library, handle = ctypes.CDLL(path), ctypes.c_void_p()
    library.qsmpm_create(ctypes.byref(handle))
    return (library.qsmpm_set_verbosity(handle, 0) or library.qsmpm_read_deck(handle, b"deck.inp")
            or library.qsmpm_initialise(handle) or library.qsmpm_advance(handle) or library.qsmpm_advance(handle)
            or library.qsmpm_advance(handle) or library.qsmpm_save(handle, b"half.h5"))


# ---- all of it -----------------------------------------------------------------------------------------------------


def table(outcomes: list[Outcome]) -> str:
    """Kinds against exit codes."""
    codes = sorted({o.code for o in outcomes if o.code is not None})
    lines = ["| kind | inputs | " + " | ".join(f"exit {c}" for c in codes) + " | findings |",
             "|---|---|" + "---|" * (len(codes) + 1)]
    for kind in SHARES:
        rows = [o for o in outcomes if f":{kind}:" in o.name]
        if rows:
            lines.append(f"| {kind} | {len(rows)} | " + " | ".join(str(sum(o.code == c for o in rows)) for c in codes)
                         + f" | {sum(bool(o.finding) for o in rows)} |")
    return "\n".join(lines)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", type=pathlib.Path, default=TOP / "build" / "qsmpm")
    parser.add_argument("--seed", type=int, default=12)
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--kind", choices=SHARES)
    parser.add_argument("--only", help="SEED:KIND:NUMBER of one trial")
    parser.add_argument("--keep", type=pathlib.Path, help="folder for the inputs of the findings")
    parser.add_argument("--child", nargs=2, help=argparse.SUPPRESS)
    parser.add_argument("--half", help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.half:
        return save_half(asked.half)
    if asked.child:
        Caller(int(asked.child[0]), asked.child[1]).run()
        return 0
    trials = [(kind, i) for kind, share in SHARES.items() if asked.kind in (None, kind)
              for i in range(round(asked.count * (1 if asked.kind else share)))]
    if asked.only:
        seed, kind, index = asked.only.split(":")
        asked.seed, trials = int(seed), [(kind, int(index))]
    if asked.keep:
        asked.keep.mkdir(parents=True, exist_ok=True)
    outcomes = []
    with tempfile.TemporaryDirectory() as work:
        fuzz = Fuzz(asked.program.resolve(), asked.seed, pathlib.Path(work), asked.keep)
        for kind, index in trials:
            outcomes.append(fuzz.trial(kind, index))
            if outcomes[-1].finding:
                print(f"FAILED {outcomes[-1].name}: {outcomes[-1].finding}", flush=True)
    print(table(outcomes))
    findings = sum(bool(o.finding) for o in outcomes)
    print(f"{len(outcomes) - findings} passed, {findings} failed")
    return 1 if findings or not outcomes else 0


if __name__ == "__main__":
    sys.exit(main())
