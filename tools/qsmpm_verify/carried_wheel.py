"""A Python wheel for computers without a compiler and without the libraries, which it contains.

    tools/wheel                   compiles program and library, without the GPL parts of SuiteSparse
    tools/wheel BUILD             uses those of a build, with the libraries that it links
    tools/wheel --out FOLDER      output folder (default output/wheels)

It requires Linux with a glibc at least as new as on the computer that builds it; the name of the wheel states which
(manylinux_2_35 is Debian 12, Ubuntu 22.04). System libraries are included by auditwheel, which lists them with
their packages in the wheel; the licence of each, from its Debian package, is stored beside it (docs/licences.md).
"""
from __future__ import annotations

import argparse
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

TOP = pathlib.Path(__file__).resolve().parents[2]
# That of the environment of the tools, with auditwheel and what it calls beside it.
PYTHON = pathlib.Path(sys.executable)


def call(*words: object) -> None:
    """Run a command of the environment of the tools; its output is shown if it fails."""
    path = f"{PYTHON.parent}:{os.environ.get('PATH', '')}"
    done = subprocess.run([str(w) for w in words], cwd=TOP, env=os.environ | {"PATH": path}, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"wheel: {' '.join(map(str, words))}: exit code {done.returncode}\n{done.stdout}{done.stderr}")


def the_one(folder: pathlib.Path) -> pathlib.Path:
    """The only wheel in a folder."""
    wheels = list(folder.glob("*.whl"))
    if len(wheels) != 1:
        sys.exit(f"wheel: {folder} has {len(wheels)} wheels, not one")
    return wheels[0]


def add_licences(wheel: pathlib.Path, out: pathlib.Path) -> int:
    """Write the licences of the included libraries beside their list; returns their number."""
    from auditwheel.wheeltools import InWheel

    with InWheel(wheel, out) as content:
        content = pathlib.Path(content)
        information = next(content.glob("*.dist-info"))
        parts = json.loads(next(information.glob("sboms/*.json")).read_text())["components"]
        names = sorted({part["name"] for part in parts if part["purl"].startswith("pkg:deb/")})
        for name in names:
            licence = pathlib.Path("/usr/share/doc", name, "copyright")
            if not licence.exists():
                sys.exit(f"wheel: {licence} not found: the licence of {name} cannot be included")
            (information / "licenses/libraries").mkdir(exist_ok=True)
            shutil.copy(licence, information / "licenses/libraries" / name)
    return len(names)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", nargs="?", type=pathlib.Path)
    parser.add_argument("--out", type=pathlib.Path, default=TOP / "output/wheels")
    given = parser.parse_args()
    options = ["-C", "cmake.define.QSMPM_WITH_SUITESPARSE=OFF"]
    if given.build:
        options = ["-C", f"cmake.define.QSMPM_BUILT={given.build.resolve()}"]
    given.out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="qsmpm-wheel-") as folder:
        made, repaired = pathlib.Path(folder, "made"), pathlib.Path(folder, "repaired")
        call(PYTHON, "-m", "pip", "wheel", TOP, "--quiet", "--no-build-isolation", "--no-deps", "--no-index", "-w", made, *options)
        call(PYTHON, "-m", "auditwheel", "repair", "-w", repaired, the_one(made))
        last = given.out.resolve() / the_one(repaired).name
        count = add_licences(the_one(repaired), last)
    print(f"{last}: {last.stat().st_size/1e6:.0f} MB, with the libraries of {count} system packages")
    return 0


if __name__ == "__main__":
    sys.exit(main())
