"""Paths in the tree.

The tree is that of QSMPM_TREE if it is set, else the one that contains this package, else the one that contains the current
folder: an installed copy of the package can be used with any checkout.
"""

import os
import shutil
import sysconfig
from pathlib import Path


def is_tree(folder: Path) -> bool:
    """Whether a folder is the top of a checkout."""
    return (folder / "verification" / "cases").is_dir()


def find_tree() -> Path:
    """The top of the tree; the current folder if there is none, in which case every requested file is missing."""
    if named := os.environ.get("QSMPM_TREE"):
        return Path(named).resolve()
    own, here = Path(__file__).resolve().parents[2], Path.cwd()
    return next((folder for folder in (own, here, *here.parents) if is_tree(folder)), here)


TOP = find_tree()
BUILD = TOP / "build"
PROGRAM = BUILD / "qsmpm"
if not is_tree(TOP):
    # Outside a checkout the program of the same installation, else one on the PATH.
    _FOLDERS = os.pathsep.join((sysconfig.get_path("scripts"), os.environ.get("PATH", "")))
    PROGRAM = Path(shutil.which("qsmpm", path=_FOLDERS) or PROGRAM)
CASES = TOP / "verification" / "cases"
STUDIES = TOP / "verification" / "studies"
SCENES = STUDIES / "scene"
STABILITY = TOP / "verification" / "stability"
TRUST = TOP / "verification" / "trust"
METAMORPHIC = TOP / "verification" / "metamorphic"
WEEK = TOP / "verification" / "week"
PEERS = TOP / "verification" / "peers"
