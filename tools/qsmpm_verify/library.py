"""`functions` and `references`: the formulas of the library as a list, in full or as the page docs/references.md."""

from __future__ import annotations

import argparse
import inspect

from qsmpm_verify.reference import FAMILIES, REFERENCES, functions
from qsmpm_verify.reference.page import entries, markdown
from qsmpm_verify.trouble import Trouble


def add_words(verbs: argparse._SubParsersAction) -> None:
    """Arguments of the subcommands."""
    names = verbs.add_parser("functions", help="list the formulas available to `curve` and to the cases")
    names.set_defaults(act=lambda words: list_formulas())
    verb = verbs.add_parser("references", help="print formula, range, source and check of references")
    verb.add_argument("names", nargs="*", help="functions to describe; default all")
    verb.add_argument("--markdown", action="store_true", help="write the whole page in the format of docs/references.md")
    verb.set_defaults(act=tell)


def list_formulas() -> int:
    """Names, arguments and first lines of the formulas."""
    for name, function in REFERENCES.items():
        print(f"{name}({', '.join(inspect.signature(function).parameters)})")
        print("    " + (inspect.getdoc(function) or "").splitlines()[0])
    return 0


def tell(words: argparse.Namespace) -> int:
    """The full description of references, or the page of all."""
    if words.markdown:
        if words.names:
            raise Trouble("--markdown writes the page of all references and takes no names")
        print(markdown(), end="")
        return 0
    known = {name: function for family in FAMILIES for name, function in functions(family).items()}
    unknown = [name for name in words.names if name not in known]
    if unknown:
        raise Trouble(f"unknown reference {', '.join(unknown)}; `qsmpm-verify functions` lists the names")
    for name in words.names or known:
        print(f"{name}({', '.join(inspect.signature(known[name]).parameters)})")
        for key, value in entries(known[name]).items():
            print(f"    {key + ':':9s} {value}")
    return 0
