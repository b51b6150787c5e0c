#!/usr/bin/env python3
"""Mutation test of the unit tests: one-line faults planted in `src/`, and how many of them no unit test notices.

Mutants are drawn with a fixed seed over the executable statements of `src/`: a condition negated, an assignment, a
call or a term deleted, a number ten times as large or off by one, a bound or a comparison swapped. All of them are
compiled into one copy of the sources behind a switch; a mutant that does not compile is left out, one that no unit
test executes is not counted, and another one is drawn. Each counted mutant then runs the suites that execute it,
with a limit in CPU seconds, until one fails.

    verification/mutants.py                     20 mutants
    verification/mutants.py --long              200 mutants, 80 of them in the rooms of ROOMS
    verification/mutants.py --long --guarded    those 80 alone
    verification/mutants.py --room loads --room phases --count 30 --seed 3
    verification/mutants.py --room "restart in rows" --ranks             asks the checks of several processes too
    verification/mutants.py --room "restart in rows" --ranks joint_files. restarts.    those of some modules or names alone

The checks of several processes are those of verification/distributed that are about the room (ABOUT), or all for a room
that has no row there. They are asked of the mutants that no unit test notices and that they execute, the quickest first,
one at a time.

Results are kept in build/mutants/results.json and used again while the sources and the file of the suite are the
same; --fresh runs all again. Mutants that change no result are listed with the reason in
verification/mutants_equivalent.toml. Closes with `N passed, N failed`:
failed are the survivors beyond LARGEST_SHARE in the rooms of ROOMS. docs/guarding.md tells what was found.
"""

from __future__ import annotations

import argparse
import concurrent.futures
import contextlib
import dataclasses
import hashlib
import json
import os
import pathlib
import re
import subprocess
import sys
import threading
import tomllib

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "tools"))
from qsmpm_verify.cpu_limit import run_limited

TOP = pathlib.Path(__file__).resolve().parents[1]
BUILD = TOP / "build" / "mutants"
COPIED = ["src", "cmake", "verification/unit", "verification/plugins", "verification/conditioning",
          "verification/manufactured", "CMakeLists.txt", "tools/umat", "tools/build-umat", "tools/bench_kernels.f90",
          "tools/bench_solvers.f90"]
# What holds the promise that a step is accepted in equilibrium or not at all: files by the start of their names.
ROOMS = {
    "step control": ["step/stepping", "step/step_", "step/load_step"],
    "equilibrium": ["step/equilibrium", "step/field_balance"],
    "checkpoint": ["model/saved_places", "model/model_window", "api/snapshot"],
    "convection": ["step/convection", "step/held_sides", "assembly/recovered_gradient", "step/nodal_fields", "particles/point_location", "mesh/moving_rows"],
    "phases": ["phases/phase", "stages/phase_start"],
    "loads": ["terms/dead_loads", "terms/pressures", "terms/supports", "surfaces/model_surfaces"],
    "contact": ["terms/contact/", "phases/contact_report", "contact/body_loads", "contact/body_points", "contact/contact_results", "step/penetration",
                "materials/law"],
    "safety": ["phases/safety_", "safety/", "materials/strength_factor"],
    "flow of water": ["water/seepage", "water/transient_seepage", "geometry/seepage_field", "water/consolidation", "water/free_surface",
                      "water/free_water", "water/face_leak", "water/confined_modulus", "terms/pore_flow", "terms/flow_points"],
    "weak seams and nonlocal strain": ["problem/layer_interfaces", "terms/nonlocal_strain", "materials/kinematics/principal_law"],
    "first guess and cell pressure": ["step/load_step", "assembly/uniform_pressure"],
    "clay and sand": ["materials/models/soft_soil_creep", "materials/models/creep_return", "materials/models/ngi_adp", "materials/models/small_strain",
                      "materials/models/swelling"],
    "values by place and by name": ["materials/models/value_field", "deck/scene/deck_values_by_place", "deck/card_check", "model/material_law"],
    "gaps and widths of cells": ["model/layer_warnings", "mesh/mesh_measure", "model/background_in_use", "phases/sheared_ground"],
    "restart in rows": ["output/restart_rows", "output/restart_division", "parallel/shared_file"],
    "restart": ["output/restart", "base/hdf5_", "output/hdf5_"],
}
ROOM_SHARE = 0.4
LARGEST_SHARE = 0.05
# Candidates compiled for each mutant that is counted: some are not executed by any test.
SPARE = 2.5
# Checks of several processes (verification/distributed) that --ranks asks beside the short ones.
LONG_CHECKS = ["restarts.moving", "restarts.fixity", "restarts.ground", "restarts.slope", "restarts.pit", "restarts.freed", "restarts.upset",
               "restarts.misfits", "joint_files.refused_names", "shared_scenes.more_loaded_bodies"]
# The checks that are about a room, by the starts of their names: the others take hours and say little of it.
ABOUT = {
    "restart in rows": ["joint_files.", "faults.killed", "many_ranks.stopped_and_continued", "restarts."],
    "safety": ["shared_scenes.factor_of_safety", "restarts.slope"],
}
RANKS = "ranks: "
ONE_AT_A_TIME = threading.Lock()
# CPU seconds that a suite may take with a mutant, beside those it takes without.
FACTOR, MARGIN = 4.0, 3.0


@dataclasses.dataclass
class Statement:
    """A logical line of a source: first and last line, its text without comments, what it is."""

    path: str
    first: int
    last: int
    text: str
    kind: str
    occurrence: int = 0


@dataclasses.dataclass
class Mutant:
    """A statement and what takes its place; `text` is empty where it is deleted."""

    key: str
    room: str
    operator: str
    statement: Statement
    text: str
    number: int = 0


def room_of(path: str) -> str:
    """Room of a source, or its folder."""
    for room, starts in ROOMS.items():
        if any(path.startswith(start) for start in starts):
            return room
    return path.split("/")[0]


def masked(text: str) -> str:
    """The text with the inside of its literals blanked, of the same length."""
    return re.sub(r"'[^']*'|\"[^\"]*\"", lambda m: "'" + "~" * (len(m[0]) - 2) + "'", text)


def without_comment(line: str) -> str:
    """The line up to a comment."""
    mark = masked(line).find("!")
    return line if mark < 0 else line[:mark]


def depths(text: str) -> list[int]:
    """Depth in parentheses at each character."""
    found, depth = [], 0
    for letter in masked(text):
        depth -= letter in ")]"
        found.append(depth)
        depth += letter in "(["
    return found


def outside(text: str) -> str:
    """What stands in no parentheses."""
    return "".join(letter for letter, depth in zip(text, depths(text)) if depth == 0)


def assignment_sign(text: str) -> int:
    """Place of the sign of an assignment, or -1."""
    clean = masked(text)
    if "::" in clean:
        return -1
    for i, depth in enumerate(depths(text)):
        if clean[i] == "=" and depth == 0:
            if clean[i + 1:i + 2] in ("=", ">") or clean[i - 1] in "=/<>":
                return -1
            return i if re.fullmatch(r"[a-z]\w*[\w%(),: \-+*/=.<>'~\[\]]*", clean[:i].strip(), re.I) else -1
    return -1


def closing(text: str, start: int) -> int:
    """Place of the parenthesis that closes the one at `start`."""
    level = depths(text)
    return next(i for i in range(start + 1, len(text)) if text[i] == ")" and level[i] == level[start])


def kind_of(text: str) -> str:
    """What a statement is: if, elseif, while, do, call, assignment, jump, one-line if; empty for all others."""
    lower = text.lower()
    if re.match(r"(if|else if)\s*\(", lower):
        rest = text[closing(text, text.index("(")) + 1:].strip().lower()
        if rest == "then":
            return "if" if lower.startswith("if") else "elseif"
        return "oneline" if kind_of(rest) in ("assignment", "call", "jump") else ""
    if re.match(r"do while\s*\(", lower):
        return "while"
    if re.match(r"do \w+ = ", lower):
        return "do"
    if re.match(r"call\s+\w", lower):
        return "call"
    if re.fullmatch(r"exit|cycle|return", lower):
        return "jump"
    if re.match(r"(where|forall|do|end|else|select|case|type|class|use|associate|write|read|allocate|deallocate|open"
                r"|close|inquire|nullify)\b", lower):
        return ""
    return "assignment" if assignment_sign(text) > 0 else ""


def statements_of(source: str, name: str) -> list[Statement]:
    """The statements of a source that can be mutated."""
    found: list[Statement] = []
    seen: dict[str, int] = {}
    text, first, in_where, after_directive, in_body = "", 0, False, False, False
    for number, line in enumerate(source.splitlines(), 1):
        if re.match(r"\s*!\$", line):
            after_directive = "atomic" in line or "workshare" in line
            continue
        code = without_comment(line).strip()
        if not code:
            continue
        first = first if text else number
        text += code.removeprefix("&").removesuffix("&") if text else code.removesuffix("&")
        if code.endswith("&"):
            continue
        text = text.strip()
        in_body = in_body or text.lower() == "contains"
        if re.fullmatch(r"where\s*\(.*\)", text, re.I) and closing(text, text.index("(")) == len(text) - 1:
            in_where = True
        kind = kind_of(text) if in_body and not in_where and not after_directive and ";" not in masked(text) else ""
        if kind:
            seen[text] = seen.get(text, 0) + 1
            found.append(Statement(name, first, number, text, kind, seen[text]))
        if re.match(r"end\s*where", text, re.I):
            in_where = False
        text, after_directive = "", False
    return found


def replaced(text: str, match: re.Match[str], by: str) -> str:
    """The text with a match replaced."""
    return text[:match.start()] + by + text[match.end():]


def mutations_of_expression(text: str) -> list[tuple[str, str]]:
    """Operator and changed text for every place of an expression that an operator fits."""
    clean, found = masked(text), []
    swaps = {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "/=", "/=": "=="}
    for m in re.finditer(r"==|/=|<=|>=|(?<!=)>|<(?!=)", clean):
        found.append(("comparison", replaced(text, m, swaps[m[0]])))
    for m in re.finditer(r"\.and\.|\.or\.", clean):
        found.append(("and, or", replaced(text, m, ".or." if m[0] == ".and." else ".and.")))
    for m in re.finditer(r"\.not\.\s*", clean):
        found.append(("negation dropped", replaced(text, m, "")))
    for m in re.finditer(r"\.true\.|\.false\.", clean):
        found.append(("logical", replaced(text, m, ".false." if m[0] == ".true." else ".true.")))
    for m in re.finditer(r"\b(min|max)(val|loc)?(?=\()", clean):
        found.append(("bound", replaced(text, m, ("max" if m[1] == "min" else "min") + (m[2] or ""))))
    for m in re.finditer(r"\b(?!0+\.0*_wp)\d+\.\d*(e[+-]?\d+)?_wp", clean):
        found.append(("times ten", replaced(text, m, f"(10.0_wp*{m[0]})")))
    for m in re.finditer(r"(?<![\w.%+\-])\d+(?![\w.])", clean):
        for by in (-1, 1):
            found.append(("off by one", replaced(text, m, str(int(m[0]) + by))))
    for m in re.finditer(r"(?<=[\w)\]])\s*([+-])\s*(?=[\w(.])", clean):
        if not re.search(r"\d[ed]$", clean[:m.start()]):
            found.append(("sign", replaced(text, m, " - " if m[1] == "+" else " + ")))
    for m in re.finditer(r"(?<=[\w)\]])(\*|/)(?=[\w(])", clean):
        found.append(("product", replaced(text, m, "/" if m[1] == "*" else "*")))
    level, starts = depths(text), []
    for m in re.finditer(r"\s+[+-]\s+|\s+\.(and|or)\.\s+", clean):
        if level[m.start()] == 0:
            starts.append(m)
    for i, m in enumerate(starts):
        end = starts[i + 1].start() if i + 1 < len(starts) else len(text)
        found.append(("term dropped", text[:m.start()] + text[end:]))
    return found


def mutations_of(statement: Statement) -> list[tuple[str, str]]:
    """Operator and what takes the place of the statement; of conditions and loops the new expression alone."""
    text, kind, found = statement.text, statement.kind, []
    if kind in ("if", "elseif", "while", "oneline"):
        start = text.index("(")
        end = closing(text, start)
        inside, rest = text[start + 1:end], text[end + 1:].strip()
        changed = [("condition negated", f".not. ({inside})")] + mutations_of_expression(inside)
        if kind != "oneline":
            return changed
        found = [(operator, f"if ({new}) {rest}") for operator, new in changed]
        inner = Statement(statement.path, 0, 0, rest, kind_of(rest))
        found += [(operator, f"if ({inside}) {new}" if new else "") for operator, new in mutations_of(inner)]
    elif kind == "assignment":
        sign = assignment_sign(text)
        left, right = text[:sign].rstrip(), text[sign + 1:].strip()
        found = [("assignment deleted", "")]
        found += [(operator, f"{left} = {new}") for operator, new in mutations_of_expression(right)]
        clean = masked(right)
        if not re.fullmatch(r"(spread\()?0+\.0*_wp(, 1, \w+\))?", clean) and re.search(r"[*+/\-]|_wp", clean) and \
                not re.search(r"'|\.(and|or|not)\.|==|[<>]", clean):
            found.append(("times ten", f"{left} = 10*({right})"))
    elif kind == "call":
        found = [("call deleted", "")]
        start = text.find("(")
        if start > 0:
            found += [(operator, text[:start + 1] + new + ")")
                      for operator, new in mutations_of_expression(text[start + 1:closing(text, start)])]
    elif kind == "jump":
        found = [("jump deleted", "")]
    elif kind == "do":
        bounds = text[text.index("=") + 1:].strip()
        # Both bounds are worked out, whichever is used: a subscript that is changed would leave its array without the mutant.
        found = [(operator, new) for operator, new in mutations_of_expression(bounds)
                 if operator in ("off by one", "sign", "bound") and outside(new) != outside(bounds)]
    return found


def draw(seed: int, sources: dict[pathlib.Path, bytes], wanted: dict[str, int]) -> list[Mutant]:
    """Candidates room by room in an order that the seed gives; changes elsewhere in the sources leave it alone."""
    def lot(*words: object) -> str:
        return hashlib.sha256("\0".join(map(str, (seed, *words))).encode()).hexdigest()

    pools: dict[str, list[tuple[str, Statement]]] = {room: [] for room in wanted}
    for path, content in sources.items():
        if path.parts[0] != "src" or path.suffix != ".f90" or path.name == "main.f90" or path.parent.name == "include":
            continue
        name = str(path.relative_to("src"))
        room = room_of(name)
        if room in wanted:
            pools[room] += [(lot(name, s.text, s.occurrence), s) for s in statements_of(content.decode(), name)]
    found = []
    for room, pool in pools.items():
        taken = 0
        for key, statement in sorted(pool, key=lambda item: item[0]):
            if taken >= wanted[room]:
                break
            choices = mutations_of(statement)
            if not choices:
                continue
            # First the operator, then its place: else the many places of a few operators would crowd the others out.
            operators = sorted({operator for operator, _ in choices})
            operator = operators[int(key[:8], 16) % len(operators)]
            texts = [text for name, text in choices if name == operator]
            text = texts[int(key[8:16], 16) % len(texts)]
            mark = hashlib.sha256(f"{statement.path}\0{statement.text}\0{statement.occurrence}\0{text}".encode())
            found.append(Mutant(mark.hexdigest()[:12], room, operator, statement, text))
            taken += 1
    for number, mutant in enumerate(found, 1):
        mutant.number = number
    return found


def switched(mutant: Mutant) -> str:
    """The statement with its mutant behind a switch, on lines of any length."""
    number, old, new, kind = mutant.number, mutant.statement.text, mutant.text, mutant.statement.kind
    if kind in ("if", "elseif", "while"):
        start = old.index("(")
        end = closing(old, start)
        inside = old[start + 1:end]
        return (f"{old[:start]}((mutant_on({number}) .and. ({new})) .or. ((.not. mutant_on({number})) .and. "
                f"({inside}))){old[end + 1:]}")
    if kind == "do":
        sign = old.index("=")
        a, b = split_list(old[sign + 1:]), split_list(new)
        bounds = ", ".join(x.strip() if x.strip() == y.strip() else f"mutant_pick({number}, {y.strip()}, {x.strip()})"
                           for x, y in zip(a, b))
        return f"{old[:sign]}= {bounds}"
    if not new:
        return f"if (.not. mutant_on({number})) then\n{old}\nend if"
    return f"if (mutant_on({number})) then\n{new}\nelse\n{old}\nend if"


def split_list(text: str) -> list[str]:
    """Parts of a list between its commas."""
    parts, begin = [], 0
    for i, depth in enumerate(depths(text)):
        if depth == 0 and text[i] == ",":
            parts.append(text[begin:i])
            begin = i + 1
    return [*parts, text[begin:]]


SWITCH = """module qsmpm_mutant_switch
  use, intrinsic :: iso_c_binding, only: c_int
  implicit none
  private
  public :: mutant_on, mutant_pick
  interface
    pure integer(c_int) function c_on(number) bind(c, name='qsmpm_mutant_on')
      import :: c_int
      integer(c_int), intent(in), value :: number
    end function c_on
  end interface
contains
  pure logical function mutant_on(number)
    integer, intent(in) :: number
    mutant_on = c_on(int(number, c_int)) /= 0
  end function mutant_on
  pure integer function mutant_pick(number, changed, usual)
    integer, intent(in) :: number, changed, usual
    mutant_pick = usual
    if (mutant_on(number)) mutant_pick = changed
  end function mutant_pick
end module qsmpm_mutant_switch
"""
# Which mutant is on is read once from the environment; which switches were passed is written at the end.
SWITCH_C = """#include <stdio.h>
#include <stdlib.h>
#define MOST 100000
static int active;
static char passed[MOST];
__attribute__((constructor)) static void begin(void) {
  const char *text = getenv("QSMPM_MUTANT");
  active = text ? atoi(text) : 0;
}
__attribute__((destructor)) static void end(void) {
  const char *path = getenv("QSMPM_MUTANTS_PASSED");
  FILE *file = path ? fopen(path, "a") : NULL;
  if (!file) return;
  for (int i = 0; i < MOST; i++)
    if (passed[i]) fprintf(file, "%d\\n", i);
  fclose(file);
}
int qsmpm_mutant_on(int number) {
  passed[number] = 1;
  return number == active;
}
"""


def put(path: pathlib.Path, content: bytes) -> None:
    """Write a file when it is not the same already: what has not changed is not compiled again."""
    if path.exists() and path.read_bytes() == content:
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)


def read_sources() -> dict[pathlib.Path, bytes]:
    """All that the copy is made of, read once: the tree may change while the copy is compiled."""
    found = {}
    for name in COPIED:
        source = TOP / name
        for path in sorted(source.rglob("*")) if source.is_dir() else [source]:
            if path.is_file() and "__pycache__" not in path.parts:
                found[path.relative_to(TOP)] = path.read_bytes()
    return found


def write_copy(sources: dict[pathlib.Path, bytes], mutants: list[Mutant]) -> dict[str, list[tuple[int, int, int]]]:
    """The copy of the sources with all mutants in it; which lines of it belong to which mutant."""
    tree = BUILD / "tree"
    by_file: dict[str, list[Mutant]] = {}
    for mutant in mutants:
        by_file.setdefault(mutant.statement.path, []).append(mutant)
    where: dict[str, list[tuple[int, int, int]]] = {}
    # A file that has moved or gone since the last run would be built beside its heir.
    switches = {pathlib.Path("src/base/mutant_switch.f90"), pathlib.Path("src/base/mutant_switch.c")}
    for old in tree.rglob("*"):
        if old.is_file() and old.relative_to(tree) not in sources.keys() | switches:
            old.unlink()
    for path, content in sources.items():
        inside = str(path.relative_to("src")) if path.parts[0] == "src" else ""
        to = tree / path
        if inside in by_file:
            text, where[str(to)] = planted(content.decode(), by_file[inside])
            content = text.encode()
        put(to, content)
        if os.access(TOP / path, os.X_OK):
            to.chmod(0o755)
    put(tree / "src/base/mutant_switch.f90", SWITCH.encode())
    put(tree / "src/base/mutant_switch.c", SWITCH_C.encode())
    return where


def planted(text: str, mutants: list[Mutant]) -> tuple[str, list[tuple[int, int, int]]]:
    """A source with its mutants, and first line, last line and number of each."""
    lines, out, where, at = text.splitlines(), [], [], 1
    for mutant in sorted(mutants, key=lambda m: m.statement.first):
        out += lines[at - 1:mutant.statement.first - 1]
        new = switched(mutant).splitlines()
        where.append((len(out) + 1, len(out) + len(new), mutant.number))
        out += new
        at = mutant.statement.last + 1
    out += lines[at - 1:]
    head = next(i for i, line in enumerate(out) if re.match(r"(module|submodule \(\w+\))\s+\w+\s*$", line))
    out.insert(head + 1, "  use qsmpm_mutant_switch, only: mutant_on, mutant_pick")
    return "\n".join(out) + "\n", [(first + 1, last + 1, number) for first, last, number in where]


def build(sources: dict[pathlib.Path, bytes], mutants: list[Mutant], ranks: bool) -> list[Mutant]:
    """Compile the copy, for several processes too where these are asked; mutants that do not compile are left out. The others."""
    binary = BUILD / "build"
    flags = ("-O1 -fcheck=bounds -ffree-line-length-none -w "
             "-finit-real=nan -finit-integer=-987654321 -finit-logical=true")
    while True:
        where = write_copy(sources, mutants)
        if not (binary / "build.ninja").exists():
            run(["cmake", "-S", str(BUILD / "tree"), "-B", str(binary), "-G", "Ninja", "-DCMAKE_BUILD_TYPE=None",
                 f"-DCMAKE_Fortran_FLAGS={flags}", "-DQSMPM_SHARED=OFF", "-DQSMPM_INSTALL=OFF",
                 f"-DQSMPM_MPI={'ON' if ranks else 'OFF'}"])
        targets = ["run_unit_tests", *(["qsmpm", "qsmpm-mpi"] if ranks else [])]
        done = subprocess.run(["ninja", "-C", str(binary), "-k", "0", *targets], capture_output=True, text=True)
        (BUILD / "build.log").write_text(done.stdout + done.stderr)
        if done.returncode == 0:
            return mutants
        stillborn = set()
        for path, line in re.findall(r"^(\S+\.f90):(\d+):[\d-]+:", done.stdout, re.M):
            stillborn |= {n for first, last, n in where.get(str(pathlib.Path(path).resolve()), ())
                          if first <= int(line) <= last}
        if not stillborn:
            sys.exit(f"the copy does not compile: {BUILD / 'build.log'}")
        print(f"   {len(stillborn)} do not compile", flush=True)
        mutants = [m for m in mutants if m.number not in stillborn]


def run(command: list[str]) -> None:
    """Run what must not fail."""
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(command)}\n{done.stdout}{done.stderr}")


def command_of(suite: str) -> list[str | pathlib.Path]:
    """What runs a suite of unit tests, or a check of several processes."""
    binary = BUILD / "build"
    if suite.startswith(RANKS):
        return [sys.executable, TOP / "verification/distributed/run_ranks.py", binary, "--check", suite.removeprefix(RANKS)]
    return [binary / "run_unit_tests", suite]


def environment(mutant: int, seconds: float = 100.0, **more: str) -> dict[str, str]:
    """With a mutant switched on; a run of a check of several processes, of the seconds that the check takes without, ends soon where it
    has come to stand."""
    return {**os.environ, "QSMPM_MUTANT": str(mutant), "QSMPM_CHECK_SECONDS": str(round(10 + 0.5 * seconds)), **more}


def checks_of(starts: list[str]) -> list[str]:
    """The checks of several processes, or those whose names begin so."""
    listed = subprocess.run([*command_of(RANKS)[:3], "--list"], capture_output=True, text=True, check=True).stdout.split()
    # The unit tests of several processes link no mutants that they are about.
    checks = [name for name in [*listed, *LONG_CHECKS] if not name.startswith("one_rank.")]
    return [RANKS + name for name in checks if not starts or name.startswith(tuple(starts))]


def starts_of(rooms: list[str]) -> list[str]:
    """Starts of the names of the checks that are about some rooms; none, for all checks, where one of them has no row."""
    return [start for room in rooms for start in ABOUT[room]] if all(room in ABOUT for room in rooms) else []


def baseline(checks: list[str]) -> tuple[dict[str, float], dict[int, list[str]]]:
    """CPU seconds of every suite and check, and those that execute each mutant, the quickest first."""
    names = subprocess.run([BUILD / "build" / "run_unit_tests", "--list"], capture_output=True, text=True, check=True).stdout.split()
    names += checks
    seconds: dict[str, float] = {}
    reached: dict[int, list[str]] = {}
    passed = BUILD / "passed.txt"
    for name in names:
        passed.unlink(missing_ok=True)
        ended = run_limited(command_of(name), 300.0, env=environment(0, QSMPM_MUTANTS_PASSED=str(passed)))
        if ended.code != 0 and name.startswith(RANKS):
            print(f"left out, it fails without a mutant: {name}", flush=True)
            continue
        if ended.code != 0:
            sys.exit(f"suite {name} fails without a mutant:\n{ended.output}")
        seconds[name] = ended.cpu
        for number in set(passed.read_text().split() if passed.exists() else ()):
            reached.setdefault(int(number), []).append(name)
    for suites in reached.values():
        suites.sort(key=lambda name: (name.startswith(RANKS), seconds[name]))
    return seconds, reached


def try_mutant(mutant: Mutant, suites: list[str], seconds: dict[str, float], known: dict[str, str]) -> tuple[str, dict[str, str]]:
    """Suite that notices the mutant, and how; empty when none does. And what is known of it then."""
    known = dict(known)
    for name in suites:
        if name not in known:
            # Checks of several processes compare and are ended by the clock: two at once would fail each other.
            with ONE_AT_A_TIME if name.startswith(RANKS) else contextlib.nullcontext():
                ended = run_limited(command_of(name), FACTOR * seconds[name] + MARGIN, env=environment(mutant.number, seconds[name]))
            known[name] = "" if ended.code == 0 else ended.how
        if known[name]:
            return f"{name}: {known[name]}", known
    return "", known


def file_of(name: str) -> str:
    """What the file of a suite is known by: the checks of several processes have one for each module."""
    return name.split(".")[0]


def digest(folder: pathlib.Path, pattern: str = "*") -> str:
    """Of the files of a folder."""
    found = hashlib.sha256()
    for path in sorted(folder.rglob(pattern)):
        if path.is_file() and "__pycache__" not in path.parts:
            found.update(path.name.encode() + path.read_bytes())
    return found.hexdigest()[:16]


class Results:
    """What each suite has said of each mutant, kept while the sources and the file of the suite are the same."""

    def __init__(self, fresh: bool) -> None:
        self.path = BUILD / "results.json"
        self.sources = digest(TOP / "src")
        kept = json.loads(self.path.read_text()) if self.path.exists() and not fresh else {}
        self.all: dict[str, dict[str, str]] = kept.get("results", {}) if kept.get("sources") == self.sources else {}
        self.suites = {path.stem.removeprefix("test_"): hashlib.sha256(path.read_bytes()).hexdigest()[:16]
                       for path in (TOP / "verification" / "unit").glob("test_*.f90")}
        self.suites |= {RANKS + path.stem: hashlib.sha256(path.read_bytes()).hexdigest()[:16]
                        for path in (TOP / "verification" / "distributed").glob("*.py")}
        former = kept.get("suites", {})
        for known in self.all.values():
            for name in [name for name in known if former.get(file_of(name)) != self.suites.get(file_of(name))]:
                del known[name]

    def of(self, mutant: Mutant) -> dict[str, str]:
        """What is known of a mutant."""
        return self.all.setdefault(mutant.key, {})

    def save(self) -> None:
        """Write what is known."""
        self.path.write_text(json.dumps({"sources": self.sources, "suites": self.suites, "results": self.all}))


def quotas(count: int, rooms: list[str], guarded: bool) -> dict[str, int]:
    """Mutants wanted of every room: ROOM_SHARE of them in ROOMS in equal parts, the rest by the folders of src."""
    if rooms:
        return spread(count, rooms)
    inside = spread(round(ROOM_SHARE * count), list(ROOMS))
    folders = sorted(path.name for path in (TOP / "src").iterdir() if path.is_dir())
    return inside if guarded else {**inside, **spread(count - round(ROOM_SHARE * count), folders)}


def spread(count: int, names: list[str]) -> dict[str, int]:
    """A number in nearly equal parts."""
    return {name: count // len(names) + (i < count % len(names)) for i, name in enumerate(names)}


def equivalent() -> dict[str, str]:
    """Mutants shown to change no result, and why."""
    path = TOP / "verification" / "mutants_equivalent.toml"
    return {row["key"]: row["reason"] for row in tomllib.loads(path.read_text())["mutant"]}


def report(mutants: list[Mutant], results: dict[str, str]) -> int:
    """Print survivors and the table of rooms; the number of mutants beyond what is allowed."""
    known = equivalent()
    rows: dict[str, list[int]] = {}
    for m in mutants:
        row = rows.setdefault(m.room, [0, 0, 0])
        row[0] += 1
        survives = results[m.key] == ""
        row[1] += survives and m.key not in known
        row[2] += survives and m.key in known
        if survives:
            print(f"{m.key} {m.room}: src/{m.statement.path}:{m.statement.first}: {m.operator}"
                  + (f" (equivalent: {known[m.key]})" if m.key in known else ""))
            print(f"    - {m.statement.text}\n    + {m.text or '(deleted)'}")
    rooms = [room for room in rows if room in ROOMS]
    for name, chosen in (("the rooms above", rooms), ("all others", [r for r in rows if r not in ROOMS])):
        table = [rows[room] for room in chosen]
        for room in chosen:
            print("| {} | {} | {} | {} | {:.0f} % |".format(room, *rows[room], 100 * rows[room][1] / rows[room][0]))
        if table:
            total = [sum(column) for column in zip(*table)]
            print("| {} | {} | {} | {} | {:.1f} % |".format(name, *total, 100 * total[1] / total[0]))
    drawn = sum(rows[room][0] for room in rooms)
    return max(0, sum(rows[room][1] for room in rooms) - int(LARGEST_SHARE * drawn))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--long", action="store_true", help="200 mutants")
    parser.add_argument("--count", type=int, help="number of mutants, 20 when not given")
    parser.add_argument("--room", action="append", default=[], help="mutants of this room or folder of src alone; may be repeated")
    parser.add_argument("--guarded", action="store_true", help="of the mutants those in the rooms of ROOMS alone")
    parser.add_argument("--seed", type=int, default=12)
    parser.add_argument("--without", action="append", default=[], help="leave a suite out, to see what it is worth")
    parser.add_argument("--ranks", nargs="*", metavar="START",
                        help="ask the checks of several processes too, those about the rooms or whose names begin so; wants MPI and PETSc")
    parser.add_argument("--fresh", action="store_true", help="run all again")
    asked = parser.parse_args()
    wanted = quotas(asked.count or (200 if asked.long else 20), asked.room, asked.guarded)
    BUILD.mkdir(parents=True, exist_ok=True)
    results = Results(asked.fresh)
    sources = read_sources()
    more = {room: round(SPARE * number) for room, number in wanted.items()}
    candidates = build(sources, draw(asked.seed, sources, more), asked.ranks is not None)
    checks = [] if asked.ranks is None else checks_of(asked.ranks or starts_of(list(wanted)))
    seconds, reached = baseline(checks)
    mutants, taken = [], dict.fromkeys(wanted, 0)
    for mutant in candidates:
        if mutant.number in reached and taken[mutant.room] < wanted[mutant.room]:
            mutants.append(mutant)
            taken[mutant.room] += 1
    print(f"{len(candidates)} drawn, {sum(m.number in reached for m in candidates)} executed by a test, "
          f"{len(mutants)} counted; all suites take {sum(seconds.values()):.0f} CPU s", flush=True)
    outcome = {}
    suites = [[name for name in reached[mutant.number] if name not in asked.without] for mutant in mutants]
    former = [results.of(mutant) for mutant in mutants]
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        tried = pool.map(lambda m, names, known: try_mutant(m, names, seconds, known), mutants, suites, former)
        for i, (mutant, (how, known)) in enumerate(zip(mutants, tried), 1):
            outcome[mutant.key] = how
            results.all[mutant.key] = known
            results.save()
            print(f"{i:4d} {mutant.key} {mutant.room}: {how or 'SURVIVES'}", flush=True)
    beyond = report(mutants, outcome)
    print(f"{len(mutants) - beyond} passed, {beyond} failed")
    return 1 if beyond else 0


if __name__ == "__main__":
    sys.exit(main())
