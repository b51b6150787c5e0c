#!/usr/bin/env python3
"""The reference of the library's entries, docs/reference.md, from the sources: Fortran, C, Fortran 77, Python.

    api_reference.py > docs/reference.md     write it
    api_reference.py --check                 is it current? Closes with `N passed, N failed`

An entry without a sentence of its own, or with an argument that is not declared, is an error.
"""
from __future__ import annotations

import ast
import pathlib
import re
import sys

TOP = pathlib.Path(__file__).resolve().parents[1]
PAGE = TOP / "docs/reference.md"
API = TOP / "src/api"
HEAD = """# Reference of the library

Every entry with its arguments, by language; printed from the sources by `verification/api_reference.py`. What they are for, with examples:
[embedding](embedding.md).
"""
# Types of `use qsmpm` whose procedures are called on them, and the files that have these.
OBJECTS = {
    "problem_type": ["problem.f90"],
    "simulation_type": ["stepped_analysis.f90", "simulation.f90"],
}
PROCEDURES = {"named_values.f90": ["list_value_names", "value_shape", "get_values", "view_values", "set_values"],
              "program_name.f90": ["program_name", "has_feature"]}


def fail(sentence: str) -> None:
    """End with a sentence."""
    sys.exit(f"api_reference: {sentence}")


# ---- Fortran ----

def joined(text: str) -> list[str]:
    """Lines of a source with continuations put together."""
    return re.sub(r"&\s*\n\s*&?", " ", text).splitlines()


def procedures(text: str) -> dict[str, tuple[str, list[tuple[str, str]], str, str]]:
    """Sentence, arguments with their declarations and sentences, kind and result of each procedure of a source."""
    found, lines, told = {}, joined(text), []
    for i, line in enumerate(lines):
        if m := re.match(r"\s*!> ?(.*)", line):
            told.append(m[1])
            continue
        m = re.match(r"\s*(?:(?:pure|recursive|elemental)\s+)*(?:[a-z]+\s*(?:\([^)]*\))?\s+)?(subroutine|function)\s+(\w+)\s*(?:\(([^)]*)\))?(.*)", line)
        if m and not line.strip().startswith("end"):
            names = [a.strip() for a in (m[3] or "").split(",") if a.strip()]
            found[m[2]] = (" ".join(told), dummies(lines[i + 1:], names), m[1], m[4])
        told = []
    return found


def dummies(lines: list[str], names: list[str]) -> list[tuple[str, str]]:
    """Declaration and sentence of each dummy argument, in their order."""
    declared: dict[str, str] = {}
    told: list[str] = []
    for line in lines:
        if re.match(r"\s*end\s*(subroutine|function)", line):
            break
        if m := re.match(r"\s*!> ?(.*)", line):
            told.append(m[1])
            continue
        if "::" in line and not line.strip().startswith(("use", "!")):
            kind, rest = line.split("::", 1)
            for name in re.findall(r"(\w+)(?:\([^)]*\))?\s*(?:,|$)", rest.split("!")[0].strip()):
                if name in names and name not in declared:
                    shape = re.search(rf"\b{name}(\([^)]*\))", rest)
                    declared[name] = f"`{kind.strip()}{' ' + shape[1] if shape else ''}`" + (
                        f": {' '.join(told)}" if told else "")
        elif m := re.match(r"\s*external\s*::\s*(\w+)", line):
            declared[m[1]] = "external procedure"
        told = []
    if missing := [n for n in names if n not in declared]:
        fail(f"arguments without a declaration: {missing}")
    return [(n, declared[n]) for n in names]


def bound(text: str, name: str) -> dict[str, list[str]]:
    """Public procedures bound to a type: the name they are called by, and those they stand for."""
    body = re.search(rf"type(?:, extends\(\w+\))? :: {name}\n(.*?)end type {name}", text, re.S)
    if not body:
        return {}
    listed: dict[str, list[str]] = {}
    for line in joined(body[1].split("contains", 1)[-1]):
        if m := re.match(r"\s*procedure(, private)? :: (.*)", line):
            for item in m[2].split(","):
                words = [w.strip() for w in item.split("=>")]
                if not m[1]:
                    listed[words[0]] = [words[-1]]
        elif m := re.match(r"\s*generic :: (\w+) => (.*)", line):
            listed[m[1]] = [w.strip() for w in m[2].split(",")]
    return listed


def entry(title: str, sentence: str, arguments: list[tuple[str, str]]) -> str:
    """An entry of the page."""
    if not sentence:
        fail(f"{title} has no sentence")
    text = f"**`{title}`** {sentence}\n"
    return text + "".join(f"- `{name}` {what}\n" for name, what in arguments) + "\n"


def fortran() -> str:
    """Procedures of `use qsmpm`."""
    text = "\n## Fortran: use qsmpm\n\n"
    for name, files in OBJECTS.items():
        text += f"### {name}\n\n"
        for file in files:
            source = (API / file).read_text()
            own = procedures(source)
            # The type that simulation_type extends is a room of its own.
            for called, stands_for in (bound(source, name) | bound(source, file[:-4] + "_type")).items():
                for procedure in stands_for:
                    if procedure not in own:
                        fail(f"{file} has no {procedure}")
                    sentence, arguments, _, _ = own[procedure]
                    kind = "" if own[procedure][2] == "function" else "call "
                    names = [n for n, _ in arguments if n != "self"]
                    text += entry(f"{kind}x%{called}({', '.join(names)})", sentence,
                                  [a for a in arguments if a[0] != "self"])
    text += "### Procedures\n\n"
    for file, names in PROCEDURES.items():
        own = procedures((API / file).read_text())
        for name in names:
            sentence, arguments, kind, _ = own[name]
            text += entry(f"{'call ' if kind == 'subroutine' else ''}{name}({', '.join(n for n, _ in arguments)})",
                          sentence, arguments)
    return text


# ---- C, Fortran 77, Python ----

def c_entries() -> str:
    """Functions, types and values of the header, in its order."""
    header = (API / "include/qsmpm.h").read_text().split('extern "C" {\n#endif')[1].split("#ifdef __cplusplus")[0]
    text = "\n## C: qsmpm.h\n\n" + " ".join(re.search(r"/\*(.*?)\*/", (API / "include/qsmpm.h").read_text(), re.S)[1].replace(
        "\n *", " ").split()) + "\n\n"
    return text + "```c\n" + re.sub(r"/\* -+ (.*?) -+ \*/", r"/* \1 */", header).strip() + "\n```\n"


def fortran77() -> str:
    """External subroutines."""
    text = "\n## Fortran 77: qsmpm_f77.f90\n\nCompile `qsmpm_c.f90` and `qsmpm_f77.f90` with the program. HANDLE is an INTEGER*8.\n\n"
    source = (API / "include/qsmpm_f77.f90").read_text()
    head, outer = source.split("end module qsmpm_f77_handles")
    for name, (sentence, arguments, _, _) in procedures(outer).items():
        shown = [(n.upper(), re.sub(r"integer\(c_intptr_t\)", "integer*8", w)) for n, w in arguments if n != "handle"]
        text += entry(f"CALL {name.upper()}({', '.join(n.upper() for n, _ in arguments)})", sentence, shown)
    text += "Procedures of the program that are called:\n\n"
    for name, title in (("law_interface", "SUBROUTINE LAW"), ("logger_interface", "SUBROUTINE LOGGER")):
        sentence, arguments, _, _ = procedures(head)[name]
        text += entry(f"{title}({', '.join(n.upper() for n, _ in arguments)})", sentence,
                      [(n.upper(), w) for n, w in arguments])
    return text


def python() -> str:
    """Classes and functions of the package."""
    text = "\n## Python: import qsmpm\n\n"
    package = TOP / "tools/qsmpm"
    listed = re.search(r"__all__ = \[(.*?)\]", (package / "__init__.py").read_text(), re.S)[1]
    public = re.findall(r'"(\w+)"', listed)
    nodes = {n.name: n for path in sorted(package.glob("*.py")) for n in ast.parse(path.read_text()).body
             if isinstance(n, (ast.ClassDef, ast.FunctionDef))}
    for name in public:
        if name.startswith("__"):
            continue
        node = nodes[name]
        sentence = " ".join((ast.get_docstring(node) or "").split())
        if isinstance(node, ast.FunctionDef):
            text += entry(f"{name}({ast.unparse(node.args)}) -> {ast.unparse(node.returns)}", sentence, [])
            continue
        base = f"({ast.unparse(node.bases[0])})" if node.bases else ""
        text += f"### {name}\n\n" + entry(f"class {name}{base}", sentence, [])
        text += "".join(member(n) for n in node.body)
    return text


def member(node: ast.stmt) -> str:
    """A field, property or method of a class."""
    if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
        return f"- `{node.target.id}: {ast.unparse(node.annotation)}`\n"
    if not isinstance(node, ast.FunctionDef):
        return ""
    marks = [ast.unparse(d) for d in node.decorator_list]
    if node.name == "__init__":
        return f"\n**`{node.name}({ast.unparse(node.args)})`**\n\n"
    if node.name.startswith("_") or any(m.endswith(".setter") for m in marks):
        return ""
    sentence = " ".join((ast.get_docstring(node) or "").split())
    if not sentence:
        fail(f"{node.name} has no sentence")
    if "property" in marks:
        return f"- `{node.name} -> {ast.unparse(node.returns)}` {sentence}\n"
    return f"- `{node.name}({ast.unparse(node.args)}) -> {ast.unparse(node.returns)}` {sentence}\n"


def page() -> str:
    """The whole page."""
    text = HEAD + fortran() + c_entries() + fortran77() + python()
    return re.sub(r"\n{3,}", "\n\n", text).rstrip() + "\n"


def main() -> int:
    text = page()
    if "--check" not in sys.argv[1:]:
        sys.stdout.write(text)
        return 0
    current = PAGE.exists() and PAGE.read_text() == text
    if not current:
        print(f"{PAGE.relative_to(TOP)} is not what the sources say: verification/api_reference.py > docs/reference.md")
    print(f"{int(current)} passed, {int(not current)} failed")
    return 0 if current else 1


if __name__ == "__main__":
    sys.exit(main())
