"""Where things lie in the tree."""

from pathlib import Path

TOP = Path(__file__).resolve().parents[2]
BUILD = TOP / "build"
PROGRAM = BUILD / "qsmpm"
CASES = TOP / "verification" / "cases"
STUDIES = TOP / "verification" / "studies"
STABILITY = TOP / "verification" / "stability"
PEERS = TOP / "verification" / "peers"
