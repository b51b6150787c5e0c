#!/usr/bin/env python3
"""A Python wheel in a new virtual environment; closes with `N passed, N failed`.

    run_wheel.py [BUILD]      a wheel of library and program of BUILD (default build), numpy borrowed from this Python
    run_wheel.py --long       `pip install .[verify]` as a user does it: the library is compiled, packages are fetched;
                              and once more without the GPL parts
"""
from __future__ import annotations

import argparse
import os
import pathlib
import re
import subprocess
import sys
import sysconfig
import tempfile
import venv
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
TOP = HERE.parents[1]
# Nothing of the tree or of this Python may help.
ENVIRONMENT = {k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "QSMPM", "VIRTUAL_ENV"))}
ENVIRONMENT |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}


def call(*words: object, cwd: pathlib.Path, seconds: int = 300) -> str:
    """Run a command; its output, both streams. Failure is an error."""
    done = subprocess.run([str(w) for w in words], cwd=cwd, env=ENVIRONMENT, capture_output=True, text=True, timeout=seconds)
    if done.returncode:
        raise AssertionError(f"{' '.join(map(str, words))}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout + done.stderr


def expect(condition: bool, sentence: str) -> None:
    """Fail with a sentence."""
    if not condition:
        raise AssertionError(sentence)


class Wheel:
    """An environment with the package in it; `run` uses it from a folder beside the tree."""

    def __init__(self, work: pathlib.Path) -> None:
        self.work, self.environment = work, work / "environment"
        self.python, self.bin = self.environment / "bin/python", self.environment / "bin"

    def make(self, build: pathlib.Path) -> None:
        """A wheel of what has been built installs into a new environment."""
        call(sys.executable, "-m", "pip", "wheel", TOP, "--quiet", "--no-build-isolation", "--no-deps", "--no-index", "-w",
             self.work / "wheels", "-C", f"cmake.define.QSMPM_BUILT={build}", cwd=self.work)
        wheels = list((self.work / "wheels").glob("*.whl"))
        expect(len(wheels) == 1 and "-py3-none-" in wheels[0].name, f"{wheels}")
        venv.create(self.environment, with_pip=False)
        call(sys.executable, "-m", "pip", f"--python={self.python}", "install", "--quiet", "--no-index", "--no-deps", wheels[0],
             cwd=self.work)
        # What the package depends on is borrowed.
        site = next((self.environment / "lib").glob("python*/site-packages"))
        (site / "borrowed.pth").write_text(sysconfig.get_path("purelib") + "\n")

    def carries(self, build: pathlib.Path) -> None:
        """A wheel of tools/wheel has every library but those of glibc, gcc and zlib inside, with licences, and runs."""
        out = self.work / "carried"
        call(TOP / "tools/wheel", build, "--out", out, cwd=self.work)
        (wheel,) = out.glob("*manylinux*.whl")
        names = zipfile.ZipFile(wheel).namelist()
        expect(sum("licenses/libraries/" in name for name in names) > 5 and any("sboms/" in name for name in names), f"{names}")
        site = next((self.environment / "lib").glob("python*/site-packages"))
        call(sys.executable, "-m", "pip", f"--python={self.python}", "install", "--quiet", "--no-index", "--no-deps", "--force-reinstall",
             wheel, cwd=self.work)
        for inside in (site / "qsmpm/libqsmpm.so", site / "qsmpm.scripts/qsmpm"):
            for line in call("ldd", inside, cwd=self.work).splitlines():
                name, _, found = (word.strip() for word in line.partition("=>"))
                expect(not found or found.startswith(str(site)) or re.match(r"lib(c|m|mvec|dl|rt|pthread|resolv|gcc_s|z)\.so", name), line)
        self.runs()

    def make_all(self, *options: str) -> None:
        """`pip install .[verify]` compiles the library and fetches what it depends on."""
        venv.create(self.environment, with_pip=True, clear=True)
        call(self.python, "-m", "pip", "install", "--quiet", f"{TOP}[verify]", *options, cwd=self.work, seconds=3600)

    def finds_its_library(self) -> None:
        """`import qsmpm` has the library inside, and its version."""
        text = call(self.python, "-c", "import qsmpm, importlib.metadata as m; print(qsmpm.library_path(), qsmpm.__version__, "
                    "m.version('qsmpm'), qsmpm.__file__)", cwd=self.work)
        path, inside, package, file = text.split()
        expect(path.startswith(str(self.environment)) and file.startswith(str(self.environment)), text)
        expect(inside == package, text)

    def runs(self) -> None:
        """An analysis from Python, and the program, away from the tree."""
        (self.work / "block.inp").write_text((HERE / "block.inp").read_text())
        text = call(self.python, "-c", "import qsmpm\nwith qsmpm.Simulation('block.inp') as run:\n    run.run()\n"
                    "    print(run.phase_results[0].ended_by, run.histories['settlement'])", cwd=self.work)
        call(self.bin / "qsmpm", "run", "block.inp", "--quiet", "--out", "out", cwd=self.work)
        rows = [line.split(",") for line in (self.work / "out/curves.csv").read_text().splitlines()]
        settlement = float(rows[-1][rows[0].index("settlement [-]")])
        expect(text.startswith("whole load ") and float(text.split()[2]) == settlement, f"{text} {settlement}")

    def brings_its_programs(self) -> None:
        """The programs of the environment work away from the tree: results are read, a UMAT is built."""
        text = call(self.bin / "qsmpm-verify", "curve", "out", "--against", "out/curves.csv", "--y", "settlement",
                    "--out", "curve.png", cwd=self.work)
        expect((self.work / "curve.png").stat().st_size > 1000, text)
        call(self.bin / "qsmpm-bench", "--help", cwd=self.work)
        call(self.bin / "build-umat", TOP / "verification/plugins/elastic_umat.f", "-o", "libelastic.so", cwd=self.work)
        call(self.bin / "convert-deck", "--stdout", "block.inp", cwd=self.work)

    def answers(self) -> None:
        """`qsmpm` of the environment explains keywords and other words, checks a deck, and tells what is wrong with one."""
        text = call(self.bin / "qsmpm", "help", "gravity", cwd=self.work) + call(self.bin / "qsmpm", "help", "sheet", "pile", cwd=self.work)
        expect(text.startswith("*GRAVITY") and "SHEET PILE is no keyword: walls" in text, text)
        text = call(self.bin / "qsmpm", "check", "block.inp", cwd=self.work)
        expect("material points" in text, text)
        (self.work / "wrong.inp").write_text("*PLATE\n" + (self.work / "block.inp").read_text())
        done = subprocess.run([self.bin / "qsmpm", "check", "wrong.inp"], cwd=self.work, env=ENVIRONMENT, capture_output=True, text=True)
        expect(done.returncode == 2 and done.stderr.startswith("wrong.inp:1: *PLATE: unknown keyword: structural elements"), done.stderr)

    def is_free(self) -> None:
        """Without the GPL parts the library says so and links none of them."""
        text = call(self.python, "-c", "import qsmpm; print(qsmpm.has('suitesparse'), qsmpm.library_path())", cwd=self.work)
        expect(text.startswith("False"), text)
        linked = call("ldd", text.split()[1], cwd=self.work)
        expect("cholmod" not in linked and "umfpack" not in linked, linked)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("build", nargs="?", type=pathlib.Path, default=TOP / "build")
    parser.add_argument("--long", action="store_true", help="compile, fetch, and once more without the GPL parts")
    given = parser.parse_args()
    passed = failed = 0
    with tempfile.TemporaryDirectory(prefix="qsmpm-wheel-") as folder:
        wheel = Wheel(pathlib.Path(folder))
        uses = [("uses", wheel.finds_its_library), ("runs", wheel.runs), ("answers", wheel.answers),
                ("programs", wheel.brings_its_programs)]
        tests = [("make", lambda: wheel.make(given.build.resolve())), *uses, ("carries", lambda: wheel.carries(given.build.resolve()))]
        if given.long:
            tests = [("pip install", wheel.make_all), *uses,
                     ("pip install without GPL", lambda: wheel.make_all("-C", "cmake.define.QSMPM_WITH_SUITESPARSE=OFF")),
                     *uses, ("free", wheel.is_free)]
        for name, test in tests:
            try:
                test()
            except Exception as fault:  # noqa: BLE001 - any fault is a failed test
                failed += 1
                print(f"FAILED {name}: {type(fault).__name__}: {fault}")
            else:
                passed += 1
                print(f"ok     {name}")
    print(f"{passed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
