"""The command `qsmpm-verify`; every verb is a module that says its words and acts.

Exit code 0 when all held, 1 on a miss, 2 when asked wrongly or a result is not there, 3 when a run failed.
"""

from __future__ import annotations

import argparse
import os
import sys

from qsmpm_verify import (
    batch, chart, curve, document, effectivity, library, metamorphic, paraview, partial, peers, pictures, point, pressures, scene, stability_map, view,
    week,
)
from qsmpm_verify.bounds import verb as bounds
from qsmpm_verify.editor import verb as editor
from qsmpm_verify.importing import verb as importing
from qsmpm_verify.reliability import verb as reliability
from qsmpm_verify.study import verb as study
from qsmpm_verify.trouble import Trouble


def parser() -> argparse.ArgumentParser:
    """Words of the command line."""
    main = argparse.ArgumentParser(prog="qsmpm-verify", description=__doc__,
                                   formatter_class=argparse.RawDescriptionHelpFormatter)
    verbs = main.add_subparsers(dest="verb", required=True, metavar="VERB")
    verbs_of = (
        batch.add_list, batch.add_run, curve.add_words, library.add_words, chart.add_words, study.add_words,
        scene.add_words, peers.add_words, stability_map.add_words, effectivity.add_words, point.add_words, view.add_words,
        paraview.add_words, document.add_words, pictures.add_words, pressures.add_words, week.add_words, metamorphic.add_words,
        bounds.add_words, importing.add_words, editor.add_words, reliability.add_words, partial.add_words,
    )  # fmt: skip
    for add in verbs_of:
        add(verbs)
    return main


def main(arguments: list[str] | None = None) -> int:
    """Read the words, act, tell trouble in one sentence."""
    words = parser().parse_args(arguments)
    try:
        return int(words.act(words))
    except Trouble as trouble:
        print(f"qsmpm-verify: {trouble}", file=sys.stderr)
        return trouble.exit_code
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except KeyboardInterrupt:
        print("qsmpm-verify: interrupted; what has finished is kept", file=sys.stderr)
        return 130
