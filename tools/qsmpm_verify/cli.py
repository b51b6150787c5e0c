"""The command `qsmpm-verify`: run, compare and plot analyses. Every subcommand is a module that defines its arguments and executes it.

Exit code 0: all comparisons passed; 1: a comparison failed; 2: invalid arguments or a missing result; 3: a run failed.
"""

from __future__ import annotations

import argparse
import importlib
import os
import sys

from qsmpm_verify.trouble import Trouble

HOMES = {
    "batch": ("list", "run"), "curve": ("curve",), "library": ("functions", "references"), "chart": ("chart",), "study.verb": ("study",),
    "scene": ("scene",), "peers": ("peers",), "stability_map": ("map",), "effectivity": ("trust",), "point": ("point",), "view": ("view",),
    "paraview": ("paraview",), "document": ("report",), "pictures": ("plot", "points", "figures"), "pressures": ("pressures",),
    "week": ("week",), "metamorphic": ("metamorphic",), "bounds.verb": ("bounds",), "importing.verb": ("import",),
    "editor.verb": ("editor", "language-server"), "reliability.verb": ("reliability",), "partial": ("partial",),
}  # fmt: skip
"""Modules by subcommand. Only the module of the requested subcommand is imported, because importing all takes longer than most subcommands run."""


def parser(asked: str = "") -> argparse.ArgumentParser:
    """Argument parser of the command line, with all subcommands or only the requested one."""
    main = argparse.ArgumentParser(prog="qsmpm-verify", description=__doc__,
                                   formatter_class=argparse.RawDescriptionHelpFormatter)
    verbs = main.add_subparsers(dest="verb", required=True, metavar="COMMAND")
    known = any(asked in own for own in HOMES.values())
    for home, own in HOMES.items():
        if asked in own or not known:
            importlib.import_module(f"qsmpm_verify.{home}").add_words(verbs)
    return main


def main(arguments: list[str] | None = None) -> int:
    """Parse the arguments, execute the subcommand, report an error in one sentence."""
    given = sys.argv[1:] if arguments is None else arguments
    words = parser(given[0] if given else "").parse_args(given)
    try:
        return int(words.act(words))
    except Trouble as trouble:
        print(f"qsmpm-verify: {trouble}", file=sys.stderr)
        return trouble.exit_code
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except KeyboardInterrupt:
        print("qsmpm-verify: interrupted; finished runs are kept", file=sys.stderr)
        return 130
