#!/usr/bin/env python3
"""House rules of the sources: one module a file, private, use with only, no upward use, no state, no output.

Each rule is one test; a breach is printed with file and line. Closes with `N passed, N failed`.
"""
from __future__ import annotations

import pathlib
import re
import sys

TOP = pathlib.Path(__file__).resolve().parents[1]
# Rooms in the order of use. Rooms of one floor may use one another: the model between two steps and its parts.
FLOORS = [["base"], ["parallel"], ["elements"], ["geometry"], ["fitting"], ["mesh"], ["materials"], ["problem"], ["particles"], ["basis"], ["solver"],
          ["model", "surfaces", "contact", "initial", "water", "stages", "safety", "distribution"], ["estimate"], ["assembly"], ["terms"], ["step"],
          ["phases"], ["reduction"], ["deck"], ["output"], ["laboratory"], ["api"]]
ROOMS = [name for row in FLOORS for name in row]
MOST_FILES = 30
LONGEST_LINE = 120
LONGEST_FILE = 600
# A number that falls: the longest there is.
LONGEST_PROCEDURE = 130
LONGEST_PROSE = 160
FORBIDDEN = {
    "no stop in the library": r"^\s*(error\s+)?stop\b",
    "no goto, common or equivalence": r"^\s*(go\s*to\b|common\s*/|equivalence\s*\()",
    "no saved state": r"^\s*save\b|,\s*save\s*(,|::)",
    "terms are opened by their type in src/terms alone": r"select\s+type\s*\(\s*term\b",
    "no writing to the screen": r"^\s*(print\b|write\s*\(\s*\*\s*,)",
    "no unfinished marks": r"(?i)\b(todo|fixme|xxx)\b",
}


def floor(path: pathlib.Path) -> int:
    """Place of a source's folder in the order of use."""
    return next(i for i, row in enumerate(FLOORS) if path.relative_to(TOP / "src").parts[0] in row)


def first_sentence(path: pathlib.Path) -> str:
    """What the head of a module says first."""
    head = []
    for line in path.read_text().splitlines():
        if not line.startswith("!>") or (head and not line[2:].strip()):
            break
        head.append(line[2:].strip())
    return re.split(r"(?<=[.?])(?<!e\.g\.)(?<!eq\.)(?<!eqs\.)\s", " ".join(head) + " ")[0].rstrip(":")


def listed(folder: pathlib.Path) -> str:
    """The README of a folder with its files in a sentence each."""
    text = (folder / "README.md").read_text().split("\n## Files\n")[0].rstrip("\n") if (folder / "README.md").is_file() else f"# {folder.name}"
    files = [path for path in sorted(folder.glob("*.f90"))]
    return text + "\n\n## Files\n" + "".join(f"- `{path.name}`: {first_sentence(path)}\n" for path in files)


def source_folders() -> list[pathlib.Path]:
    """Folders of src/ with Fortran sources of the library."""
    return sorted({path.parent for path in (TOP / "src").glob("*/**/*.f90")} - {TOP / "src/api/include"})


def crowded_or_unlisted() -> list[str]:
    """Folders with too many files, or whose README does not list them as they are."""
    found = []
    for folder in source_folders():
        name, files = folder.relative_to(TOP), list(folder.glob("*.f90"))
        found += [f"{name}: {len(files)} files"] if len(files) > MOST_FILES else []
        readme = folder / "README.md"
        found += [] if readme.is_file() and readme.read_text() == listed(folder) else [f"{name}/README.md: verification/house.py --readmes writes it"]
    return found


def state_of(text: str) -> list[tuple[int, str]]:
    """Variables that outlive a call: of a module, or of a procedure and given a value where they are declared."""
    found, first, statement, depth, inside = [], 0, "", 0, False
    for number, line in enumerate(text.splitlines(), 1):
        part = re.sub(r"('[^']*'|\"[^\"]*\")", "''", line).split("!")[0].strip().lower()
        if not statement:
            first = number
        statement += " " + part.rstrip("&")
        if part.endswith("&"):
            continue
        code, statement = statement.strip(), ""
        if re.match(r"(type(?!\s*\()|(abstract\s+)?interface)\b", code):
            depth += 1
        elif re.match(r"end\s*(type|interface)\b", code):
            depth -= 1
        elif code == "contains" and depth == 0:
            inside = True
        elif depth == 0 and "::" in code and re.match(r"(integer|real|logical|complex|character|type\s*\(|class\s*\("
                                                      r"|procedure\s*\(|double)", code):
            kind, names = code.split("::", 1)
            if "parameter" not in kind and (not inside or re.search(r"(?<![=<>/])=(?!=)", names)):
                found.append((first, code))
    return found


def components_of(path: str, kind: str) -> list[str]:
    """Names of the components of a derived type of a source file."""
    body = re.search(rf"^  type(?:,[^:]*)? :: {kind}\n(.*?)^  end type", (TOP / path).read_text(), re.M | re.S)
    if not body:
        return []
    code = re.sub(r"!.*|&\s*\n", "", body[1]).split("contains")[0]
    names = []
    for declared in re.findall(r"::(.*)", code):
        while re.search(r"\([^()]*\)", declared):
            declared = re.sub(r"\([^()]*\)", "", declared)
        names += [name.split("=")[0].strip() for name in declared.split(",")]
    return names


def unnamed_state() -> list[str]:
    """Components of the state that the tests of checkpoint and restart do not alter or do not compare: they know the
    fields of what rides on the mesh by the lists of src/particles/points.f90, and name the others."""
    samples = (TOP / "verification/unit/state_samples.f90").read_text()
    lists = (TOP / "src/particles/points.f90").read_text().split("contains\n\n", 1)[1]
    altering, comparing = samples.split("function state_differences", 1)
    # The number of places and the part of the grid belong to the arrays and to the mesh: compared, not altered.
    apart, found = {"count", "window"}, []
    for path, kind in [("src/model/model.f90", "rest_of_state_type"), ("src/model/model.f90", "state_type"),
                       ("src/model/model.f90", "progress_type"),
                       ("src/model/model.f90", "phase_end_type"), ("src/model/limit_load.f90", "limit_load_type")]:
        names = components_of(path, kind)
        found += [] if names else [f"{path}: no type {kind}"]
        found += [f"{path}: {kind}%{name} is not altered" for name in names
                  if name not in apart and not re.search(rf"%{name}\b", altering)]
        found += [f"{path}: {kind}%{name} is not compared" for name in names
                  if len(re.findall(rf"\b[ab]%(?:\w+%)*{name}\b", comparing)) < 2]
    for kind in ("carried_type", "points_type", "surface_points_type", "watched_points_type"):
        names = components_of("src/particles/points.f90", kind)
        found += [] if names else [f"src/particles/points.f90: no type {kind}"]
        found += [f"src/particles/points.f90: {kind}%{name} is in no list of fields" for name in names
                  if name not in apart and not re.search(rf"=self%{name}\)", lists)]
    return found


def lost_places() -> list[str]:
    """Files and routines that docs/theory.md places an equation in and that are not there."""
    text, found = (TOP / "docs/theory.md").read_text(), []
    for routine, name in re.findall(r"`(\w+)` \(`(\w+/[\w/]+\.f90)`\)", text):
        path = TOP / "src" / name
        if not path.is_file() or not re.search(rf"(subroutine|function)\s+{routine}\b", path.read_text()):
            found.append(f"docs/theory.md: {routine} in {name}")
    return found


def lost_rooms() -> list[str]:
    """Beginnings of paths in ROOMS of mutants.py that no source has: the files moved, and their lines are drawn no more."""
    text = (TOP / "verification/mutants.py").read_text()
    starts = re.findall(r'"([a-z]+/[\w/]+)"', re.search(r"^ROOMS = \{(.*?)^\}", text, re.M | re.S)[1])
    paths = [str(path.relative_to(TOP / "src")) for path in (TOP / "src").rglob("*.f90")]
    return [start for start in starts if not any(path.startswith(start) for path in paths)] or ([] if starts else ["none"])


def pages() -> list[pathlib.Path]:
    """Pages that people write; those in docs/data and the references are written by commands."""
    made = {"deck.md", "reference.md", "references.md"}
    return [TOP / "README.md"] + [page for page in sorted((TOP / "docs").rglob("*.md")) if page.parent.name != "data" and page.name not in made]


def long_prose() -> list[str]:
    """Lines of pages that are too long and neither a row of a table nor code."""
    found = []
    for page in pages():
        for number, line in enumerate(re.sub(r"^```.*?^```", lambda code: "\n" * code[0].count("\n"), page.read_text(), flags=re.M | re.S).splitlines(), 1):
            if len(line) > LONGEST_PROSE and not line.lstrip().startswith("|") and not line.startswith("    "):
                found.append(f"{page.relative_to(TOP)}:{number}: {len(line)} columns")
    return found


def anchors(page: pathlib.Path) -> set[str]:
    """What the headings of a page are called in links."""
    return {re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-") for heading in re.findall(r"^#+ (.*)$", page.read_text(), re.M)}


def lost_links() -> list[str]:
    """Links of pages and READMEs to files, folders or headings that are not there."""
    found = []
    for page in [*sorted((TOP / "docs").rglob("*.md")), TOP / "README.md", *sorted((TOP / "src").rglob("README.md"))]:
        for target in re.findall(r"\]\(([^)\s]+)\)", re.sub(r"`[^`\n]*`", "", page.read_text())):
            path, _, heading = target.partition("#")
            if re.match(r"[a-z]+:", target):
                continue
            other = (page.parent / path).resolve() if path else page
            if not other.exists() or heading and heading not in anchors(other):
                found.append(f"{page.relative_to(TOP)}: {target}")
    return found


def stale_figures() -> list[str]:
    """Figures of pages whose link is the table they are from, and that it does not hold: [1.66](../data/week.md)."""
    found = []
    for page in pages():
        for figure, to in re.findall(r"\[(-?\d[\d.]*)(?: %)?\]\(([\w./]*data/\w+\.md)\)", page.read_text()):
            held = re.findall(r"(?<![\w.])-?\d[\d.]*(?:e[+-]?\d+)?", (page.parent / to).read_text())
            digits = len(figure.partition(".")[2])
            if not any(f"{float(number):.{digits}f}" == figure for number in held if number.count(".") <= 1):
                found.append(f"{page.relative_to(TOP)}: {figure} of {to}")
    return found

def unused_arguments(text: str) -> list[str]:
    """Arguments that a procedure does not use, unless it is bound to a type, called from C, of an interface or handed on: the compiler
    cannot tell these from a mistake and is not asked."""
    code = re.sub(r"&\s*\n\s*&?", "", re.sub(r"!.*", "", re.sub(r"'[^'\n]*'|\"[^\"\n]*\"", "''", text)))
    code = re.sub(r"^\s*(abstract )?interface\b.*?^\s*end interface", "", code, flags=re.M | re.S)
    found = []
    for kind, name, names, body in re.findall(
            r"^(?!\s*end\b|\s*module (?:pure |subroutine|function|integer|real|logical|type))[\w()=,*: ]*?\b(subroutine|function) (\w+)\(([^()]*)\)"
            r"((?:[^\n]*\n)*?)\s*end \1 \2\b", code, re.M):
        free = re.sub(rf"\b(call|subroutine|function)\s+{name}\b|\b{name}\s*\(|\bpublic\b[^\n]*", "", code)
        if re.search(rf"\b{name}\b(?!\s*=[^>=])", free.replace(f"end {kind} {name}", "")) or "bind(c" in body.split("\n")[0]:
            continue
        for argument in filter(None, re.split(r"[\s,]+", names)):
            # Once in its declaration; one that is only cleared is of intent out.
            if len(re.findall(rf"\b{argument}\b", body)) < 2 and not re.search(rf"intent\(out\)[^\n]*::[^\n]*\b{argument}\b", body):
                found.append(f"{name}: {argument}")
    return found


def long_procedures(lines: list[str]) -> list[str]:
    """Procedures longer than the longest allowed, those within them counted: arguments, not the reach of a host, say what one touches."""
    found, begun = [], []
    for number, line in enumerate(lines, 1):
        code = line.split("!")[0]
        ends = re.match(r"\s*end (?:subroutine|function) (\w+)", code)
        begins = re.match(r"\s*(?!end\b)[\w (),:*=]*\b(?:subroutine|function)\s+(\w+)\s*(?:\(|$)", code)
        if ends:
            while begun and begun[-1][0] != ends[1]:
                begun.pop()
            if begun and number - begun[-1][1] >= LONGEST_PROCEDURE:
                found.append(f"{ends[1]}: {number - begun[-1][1] + 1}")
            if begun:
                begun.pop()
        elif begins:
            begun.append((begins[1], number))
    return found


def main() -> int:
    if "--readmes" in sys.argv:
        for folder in source_folders():
            (folder / "README.md").write_text(listed(folder))
    # What is compiled by other compilers, in the program that uses the library, has rules of its own.
    sources = [path for path in sorted((TOP / "src").rglob("*.f90")) if path.parent.name != "include"]
    owner = {}
    for path in sources:
        found = re.search(r"^module\s+(\w+)\s*$", path.read_text(), re.M)
        if found:
            owner[found[1].lower()] = path
    breaches: dict[str, list[str]] = {rule: [] for rule in [
        "one module or submodule a file, named as the file", "implicit none and private everywhere", "use with only everywhere",
        "a folder uses only folders before it, or of its floor", f"lines of at most {LONGEST_LINE} columns, no tabs",
        f"files of at most {LONGEST_FILE} lines", f"procedures of at most {LONGEST_PROCEDURE} lines, those within counted", "no variable outlives a call", "arguments are used, but for those that kin of a procedure has",
        "the tests of the checkpoint know every component of the state",
        "routines that the theory names are where it says",
        "files that the mutants are drawn from exist",
        "every room has its place in the order of use and a README whose head has at most ten lines",
        f"folders of at most {MOST_FILES} files, each with a README that lists them",
        f"prose of at most {LONGEST_PROSE} columns", "links of pages lead somewhere",
        "figures of pages stand in the tables they are from", *FORBIDDEN]}
    breaches["the tests of the checkpoint know every component of the state"] = unnamed_state()
    breaches["routines that the theory names are where it says"] = lost_places()
    breaches["files that the mutants are drawn from exist"] = lost_rooms()
    rooms = sorted(path.name for path in (TOP / "src").iterdir() if path.is_dir())
    breaches["every room has its place in the order of use and a README whose head has at most ten lines"] = [
        f"src/{name}" for name in rooms if name not in ROOMS or not (TOP / "src" / name / "README.md").is_file()
        or len((TOP / "src" / name / "README.md").read_text().split("\n## Files")[0].splitlines()) > 10]
    breaches[f"prose of at most {LONGEST_PROSE} columns"] = long_prose()
    breaches["links of pages lead somewhere"] = lost_links()
    breaches["figures of pages stand in the tables they are from"] = stale_figures()
    breaches[f"folders of at most {MOST_FILES} files, each with a README that lists them"] = crowded_or_unlisted()
    for path in sources:
        text, name = path.read_text(), str(path.relative_to(TOP))
        library = path.name != "main.f90"
        if library:
            modules = re.findall(r"^module\s+(\w+)\s*$", text, re.M)
            # A submodule is named as its file, and nothing of it can be seen from elsewhere.
            part = re.search(r"^submodule\s*\(qsmpm_\w+\)\s*(\w+)\s*$", text, re.M)
            # The public module, src/api/qsmpm.f90, is named as the library.
            if part and (modules or part[1] != path.stem) or not part and modules not in ([f"qsmpm_{path.stem}"], [f"qsmpm_{path.parent.name}_{path.stem}"]) and not (
                    path.parts[-2:] == ("api", "qsmpm.f90") and modules == ["qsmpm"]):
                breaches["one module or submodule a file, named as the file"].append(f"{name}: {modules}")
            if not re.search(r"^\s*implicit none", text, re.M) or not (part or re.search(r"^\s*private\s*$", text, re.M)):
                breaches["implicit none and private everywhere"].append(name)
            for number, code in state_of(text):
                breaches["no variable outlives a call"].append(f"{name}:{number}: {code[:80]}")
            breaches["arguments are used, but for those that kin of a procedure has"] += [f"{name}: {found}" for found in unused_arguments(text)]
        lines = text.splitlines()
        if len(lines) > LONGEST_FILE:
            breaches[f"files of at most {LONGEST_FILE} lines"].append(f"{name}: {len(lines)}")
        breaches[f"procedures of at most {LONGEST_PROCEDURE} lines, those within counted"] += [f"{name}: {found}" for found in long_procedures(lines)]
        for number, line in enumerate(lines, 1):
            where = f"{name}:{number}: {line.strip()[:80]}"
            if len(line) > LONGEST_LINE or "\t" in line:
                breaches[f"lines of at most {LONGEST_LINE} columns, no tabs"].append(where)
            code = line.split("!")[0]
            used = re.match(r"\s*use\s*(?:,\s*\w+\s*::\s*|::\s*|\s)\s*(\w+)(\s*$|\s*,.*)", code)
            if used:
                if "only" not in used[2]:
                    breaches["use with only everywhere"].append(where)
                other = owner.get(used[1].lower())
                if library and other and floor(other) > floor(path):
                    breaches["a folder uses only folders before it, or of its floor"].append(where)
            if library:
                for rule, pattern in FORBIDDEN.items():
                    if "src/terms" in rule and "terms" in path.parts:
                        continue
                    if re.search(pattern, line if "marks" in rule else code):
                        breaches[rule].append(where)
    for rule, list_of in breaches.items():
        print(("FAILED " if list_of else "ok     ") + rule)
        for breach in list_of[:20]:
            print("       " + breach)
    failed = sum(bool(b) for b in breaches.values())
    print(f"{len(breaches) - failed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
