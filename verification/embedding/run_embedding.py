#!/usr/bin/env python3
"""The library in the hands of other programs: installed, found, linked, called; closes with `N passed, N failed`.

    run_embedding.py [BUILD] [--long]

Installs BUILD (default build) into an empty folder and builds programs from it in clean folders: by find_package, by
pkg-config from C, by the interface source as a program of another compiler would, by ctypes. Two analyses that take
turns in one process must give the files of two runs of the command line. With --long the library is also built as a
part of another project (add_subdirectory), which takes a compilation of all sources.
"""
from __future__ import annotations

import argparse
import filecmp
import os
import pathlib
import re
import shutil
import sys
import tempfile
from collections.abc import Callable, Sequence

HERE = pathlib.Path(__file__).resolve().parent
TOP = HERE.parents[1]
sys.path.insert(0, str(TOP / "tools"))
from qsmpm_verify.cpu_limit import run_limited  # noqa: E402

ENVIRONMENT = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}


def call(*words: object, cwd: pathlib.Path = HERE, seconds: int = 120, code: int | None = 0, **more: str) -> str:
    """Run a command for some CPU seconds; its output, both streams. A code that is not wanted is an error."""
    done = run_limited([str(w) for w in words], seconds, cwd, {**ENVIRONMENT, **more})
    if code is not None and done.code != code:
        raise AssertionError(f"{' '.join(map(str, words))}: {done.how}\n{done.output}{done.errors}")
    return done.output + done.errors


class Skipped(Exception):
    """What a test wants is not installed."""


def expect(condition: bool, sentence: str) -> None:
    """Fail with a sentence."""
    if not condition:
        raise AssertionError(sentence)


def numbers(text: str, *names: str) -> list[float]:
    """The number behind each name."""
    return [float(re.search(rf"{name}\s+(\S+)", text)[1]) for name in names]


def last_settlement(folder: pathlib.Path) -> float:
    """The settlement in the last row of a run's curves."""
    rows = [line.split(",") for line in (folder / "curves.csv").read_text().splitlines()]
    return float(rows[-1][rows[0].index("settlement [-]")])


class Embedding:
    """The tests; what one makes a later one may use."""

    def __init__(self, build: pathlib.Path, work: pathlib.Path) -> None:
        self.build, self.work = build, work
        self.prefix = work / "prefix"
        self.lib = self.prefix / "lib"

    # ---- what is installed ----

    def installs(self) -> None:
        """The build installs into an empty folder, with nothing that names the source or the build."""
        call("cmake", "--install", self.build, "--prefix", self.work / "first")
        # Moved afterwards: a package may be put anywhere.
        shutil.move(self.work / "first", self.prefix)
        for name in ("include/qsmpm.h", "lib/libqsmpm.a", "lib/libqsmpm.so", "lib/pkgconfig/qsmpm.pc",
                     "lib/cmake/qsmpm/qsmpmConfig.cmake", "share/qsmpm/fortran/qsmpm_c.f90",
                     "share/qsmpm/fortran/qsmpm_f77.f90", "share/doc/qsmpm/LICENSE", "share/doc/qsmpm/docs/reference.md",
                     "share/doc/qsmpm/docs/embedding.md", "share/doc/qsmpm/input/slope_safety.inp"):
            expect((self.prefix / name).exists(), f"{name} is not installed")
        for path in [*self.prefix.glob("lib/cmake/qsmpm/*"), *self.prefix.glob("lib/pkgconfig/*")]:
            expect(str(TOP) not in path.read_text(), f"{path.name} names the source folder")
        self.has_licences()
        modules = list((self.prefix / "include/qsmpm").glob("*/qsmpm.mod"))
        expect(len(modules) == 1, "the modules are not in a folder of their compiler")
        call(self.prefix / "bin/qsmpm", "check", "block.inp")
        if (self.build / "qsmpm-mpi").exists():
            call("cmake", "--install", self.build, "--prefix", self.work / "many", "--component", "mpi")
            call(self.work / "many/bin/qsmpm-mpi", "check", "block.inp")

    def has_licences(self) -> None:
        """The licences of what is linked are there, those of the GPL parts only with them."""
        folder = self.prefix / "share/doc/qsmpm/licences"
        if not pathlib.Path("/usr/share/doc/libmumps-seq-dev/copyright").exists():
            return
        expect("CeCILL-C" in (folder / "libmumps-seq-dev.txt").read_text(), "the licence of MUMPS is not installed")
        gpl = (folder / "libsuitesparse-dev.txt").exists()
        linked = "cholmod" in call("ldd", self.lib / "libqsmpm.so")
        expect(gpl == linked, f"licence of SuiteSparse {gpl}, linked {linked}")

    def holds_no_state(self) -> None:
        """No variable of the library outlives a call, but for flags of signals and the guard of plug-ins."""
        found = []
        for line in call("nm", "-A", self.lib / "libqsmpm.a").splitlines():
            words = line.split()
            if len(words) < 3 or words[-2] not in "bBdDC":
                continue
            # Tables of types, branches and constants, lengths of texts on their way out of a function, and locks are
            # made by the compiler; nothing of them outlives a call.
            if re.match(r"__.*_MOD___(vtab|def_init)_|(A|jumptable|slen)\.\d+|\.gomp_critical_", words[-1]):
                continue
            found.append(f"{words[0].split(':')[-2]}: {words[-1]}")
        # Flags of signals, and the guard around models that end the process: they belong to the process.
        known = {"posix.c.o: received", "plugin.c.o: active", "plugin.c.o: installed", "plugin.c.o: abandoned",
                 "plugin.c.o: abandoned_by", "plugin.c.o: abandoned_model", "plugin.c.o: before",
                 *(f"plugin.c.o: {name}" for name in ("watches", "threads", "calls", "own_calls", "stopped", "invalid"))}
        expect(set(found) <= known and "posix.c.o: received" in found,
               f"variables that outlive a call: {set(found) - known}")

    # ---- CMake ----

    def configure(self, source: pathlib.Path, folder: str, *options: object, code: int = 0) -> str:
        """Configure a project in a clean folder."""
        return call("cmake", "-S", source, "-B", self.work / folder, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                    *options, seconds=300, code=code)

    def found_by_cmake(self) -> None:
        """A Fortran project finds the package, uses its modules and extends a soil model."""
        told = self.configure(HERE / "modern", "modern", f"-DCMAKE_PREFIX_PATH={self.prefix}")
        expect("may not be readable" not in told, "the package warns of its own compiler")
        call("cmake", "--build", self.work / "modern", "--target", "host", seconds=300)
        own, theirs = numbers(call(self.work / "modern/host"), "own", "theirs")
        # The library's rate is that of Kirchhoff stress, the model's of Cauchy stress: a volume strain apart.
        expect(0.0 < abs(own - theirs) < 0.02 * theirs, f"own law {own}, the library's {theirs}")

    def used_by_a_legacy_program(self) -> None:
        """A fixed-form program with a load program of its own, by external subroutines and the shared library."""
        call("cmake", "--build", self.work / "modern", "--target", "legacy", seconds=300)
        text = call(self.work / "modern/legacy")
        lifts = [float(v) for v in re.findall(r"LIFT\s+(\S+)", text)]
        expect(len(lifts) == 3, text)
        times = [float(v) for v in re.findall(r"TIME\s+(\S+)", text)]
        expect(times == [11.0, 21.0, 31.0], f"a stage of 1 and three of 10 end at {times}")
        # Elastic in plane strain: lift = load (1 - nu^2)/E, up to strains of 0.08 % and the share of the stabilisation.
        for load, lift in zip((4.0, 8.0, 6.0), lifts):
            expect(abs(lift / (load * (1 - 0.3**2) / 10000.0) - 1.0) < 0.005, f"load {load} lifts {lift}")
        expect("STATUS 1 there is no surface 'tip' (did you mean top?)" in text, text)

    def steered_by_a_legacy_program(self) -> None:
        """A fixed-form program with a law and a COMMON of its own rejects a step, steps again, and is the deck's run."""
        call("cmake", "--build", self.work / "modern", "--target", "steer", seconds=300)
        folder = self.work / "steer"
        folder.mkdir()
        build = self.prefix / "bin/build-umat"
        call(build, HERE / "legacy/common_umat.f", "-o", folder / "libcommon.so")
        call(build, TOP / "verification/plugins/elastic_umat.f", "-o", folder / "libelastic.so")
        block = (HERE / "block.inp").read_text()
        (folder / "block.inp").write_text(block)
        for name, constants in (("common", "0, 0"), ("elastic", "1000, 0.3")):
            (folder / f"{name}.inp").write_text(block.replace(
                "*UNIT WEIGHT", f"*USER MATERIAL, INTERFACE=UMAT, LIBRARY={folder}/lib{name}.so, STATE=1, "
                f"SYMMETRIC=YES\n{constants}\n*UNIT WEIGHT"))
        call(self.prefix / "bin/qsmpm", "run", folder / "elastic.inp", "--quiet", "--out", folder / "deck")
        settlement = last_settlement(folder / "deck")
        text = call(self.work / "modern/steer", cwd=folder)
        first, own, steps = numbers(text, "REJECTED", "OWN", "STEPS")
        expect(own == settlement and numbers(text, "UMAT") == [settlement], f"the deck settles {settlement!r}: {text}")
        expect(0.4 * own < first < 0.6 * own and steps == 5, text)
        expect("CALLED T HEARD T" in text and "LOADED T" in text and "SAME COMMON T" in text, text)
        expect("GOES ON TO 0.750" in text, text)
        expect(text.count("THIS LAW DOES NOT WANT TO") == 1 and "STATUS 6 " in text, text)
        expect(numbers(text, "SENTENCES")[0] == 3, text)
        expect("MATERIAL stiff SETTLES" in text and
               "added cards:3: *CHANGE MATERIAL: there is no body 'black' (did you mean block?)" in text, text)

    def steered_by_another_compiler(self) -> None:
        """The same program and the interface sources compiled by flang, with the library and the UMAT of gfortran."""
        flang = next((c for c in ("flang", "flang-new", *(f"flang-{n}" for n in range(30, 15, -1))) if shutil.which(c)), None)
        if flang is None:
            raise Skipped("no flang here (tools/setup --long)")
        folder = self.work / "flang"
        shutil.copytree(self.work / "steer", folder)
        source = self.prefix / "share/qsmpm/fortran"
        for file in (source / "qsmpm_c.f90", source / "qsmpm_f77.f90", HERE / "legacy/steer.f"):
            call(flang, "-O1", "-c", file, cwd=folder)
        call(flang, "-rdynamic", "qsmpm_c.o", "qsmpm_f77.o", "steer.o", f"-L{self.lib}", "-lqsmpm", f"-Wl,-rpath,{self.lib}", "-o",
             "steer", cwd=folder)
        told = call(folder / "steer", cwd=folder)
        for line in call(self.work / "modern/steer", cwd=folder).splitlines():
            expect(line.startswith("Note:") or line in told, f"{line}\nis not in\n{told}")

    def warns_of_another_compiler(self) -> None:
        """A project with another compiler is warned and pointed to the interface source, not stopped."""
        other = self.work / "other"
        shutil.copytree(self.prefix, other, symlinks=True)
        config = other / "lib/cmake/qsmpm/qsmpmConfig.cmake"
        text = config.read_text()
        changed = re.sub(r'(_qsmpm_ours ")\d+', r"\g<1>7", text)
        expect(changed != text, "the package names no compiler")
        config.write_text(changed)
        told = self.configure(HERE / "modern", "other-build", f"-DCMAKE_PREFIX_PATH={other}")
        expect("qsmpm_c.f90" in told and "may not be readable" in re.sub(r"\s+", " ", told), told[-800:])

    def refuses_another_minor_version(self) -> None:
        """While the version is 0.x another minor version is another interface."""
        folder = self.work / "later"
        folder.mkdir()
        (folder / "CMakeLists.txt").write_text("cmake_minimum_required(VERSION 3.25)\nproject(later LANGUAGES C)\n"
                                               "find_package(qsmpm 0.2 CONFIG REQUIRED)\n")
        told = self.configure(folder, "later-build", f"-DCMAKE_PREFIX_PATH={self.prefix}", code=1)
        expect("0.1.0" in told, told[-800:])

    def found_by_a_c_project(self) -> None:
        """A CMake project without Fortran gets the shared library."""
        folder = self.work / "only-c"
        folder.mkdir()
        (folder / "CMakeLists.txt").write_text(
            "cmake_minimum_required(VERSION 3.25)\nproject(only_c LANGUAGES C)\nfind_package(qsmpm 0.1 CONFIG REQUIRED)\n"
            f"add_executable(host {HERE / 'c/host.c'})\ntarget_link_libraries(host PRIVATE qsmpm::qsmpm m)\n")
        self.configure(folder, "only-c-build", f"-DCMAKE_PREFIX_PATH={self.prefix}")
        call("cmake", "--build", self.work / "only-c-build")
        self.check_c(call(self.work / "only-c-build/host"))

    def is_a_good_subproject(self) -> None:
        """As a part of another project it brings the library alone: no program, no tests, no installation."""
        told = self.configure(HERE / "subproject", "sub", f"-DQSMPM_SOURCE={TOP}")
        targets = re.search(r"targets of qsmpm: (.*)", told)[1].split(";")
        expect(sorted(targets) == ["qsmpm", "qsmpm_flags"], f"targets {targets}")
        expect("flags of the project are its own" in told, "the flags of the project have changed")

    def builds_as_a_subproject(self) -> None:
        """The same, built and run."""
        call("cmake", "--build", self.work / "sub", "--", "-j", "2", seconds=1500)
        own, theirs = numbers(call(self.work / "sub/host"), "own", "theirs")
        expect(0.0 < abs(own - theirs) < 0.02 * theirs, f"own law {own}, the library's {theirs}")

    # ---- C ----

    def flags(self, *options: str) -> list[str]:
        """What pkg-config says."""
        return call("pkg-config", *options, "qsmpm", PKG_CONFIG_PATH=str(self.lib / "pkgconfig")).split()

    def check_c(self, text: str) -> None:
        """What the C program must print."""
        own, theirs = numbers(text, "own", "theirs")
        expect(0.0 < abs(own - theirs) < 0.02 * theirs, text)
        expect("status 1 there is no model: create it first" in text, text)
        expect("status 6 " in text and "this model is for one phase only" in text, text)
        expect("called yes" in text and "view 2 x " in text and numbers(text, "heard")[0] >= 5, text)

    def linked_from_c(self) -> None:
        """A C program by pkg-config with the shared library, warnings as errors."""
        program = self.work / "host-shared"
        call("gcc", "-std=c11", "-Wall", "-Wextra", "-Werror", "-pedantic", "c/host.c", "-o", program,
             *self.flags("--cflags", "--libs"))
        self.check_c(call(program, LD_LIBRARY_PATH=str(self.lib)))

    def moves_and_loads_a_rigid_body(self) -> None:
        """Programs in Fortran, Fortran 77 and C push a plate, load it step by step, and read the same places and forces."""
        call("cmake", "--build", self.work / "modern", "--target", "plate", "legacy_plate", seconds=300)
        call("gcc", "-std=c11", "-Wall", "-Wextra", "-Werror", "-pedantic", "c/plate.c", "-o", self.work / "plate-c",
             *self.flags("--cflags", "--libs"))
        told = [call(program, LD_LIBRARY_PATH=str(self.lib)) for program in (
            self.work / "modern/plate", self.work / "modern/legacy_plate", self.work / "plate-c")]
        rows = [[(word, float(place), float(force)) for word, place, force in
                 re.findall(r"(MOVED|LOADED)\s+(\S+)\s+(\S+)", text)] for text in told]
        expect(rows[0] == rows[1] == rows[2] and [row[0] for row in rows[0]] == ["MOVED"] * 2 + ["LOADED"] * 2, f"{told}")
        (_, half, _), (_, place, pushed), (_, _, first), (_, down, last) = rows[0]
        expect(abs(half + 0.005) < 1e-12 and abs(place + 0.01) < 1e-12, told[0])
        expect(abs(first - 0.5 * (pushed + 40)) < 1e-5 and abs(last - 40) < 1e-5 and down < place, told[0])

    def linked_statically_from_c(self) -> None:
        """The same with the static library and what pkg-config --static says."""
        program = self.work / "host-static"
        libraries = ["-l:libqsmpm.a" if w == "-lqsmpm" else w for w in self.flags("--static", "--libs")]
        call("gcc", "c/host.c", "-o", program, *self.flags("--cflags"), *libraries)
        expect("libqsmpm" not in call("ldd", program), "the program is not linked statically")
        self.check_c(call(program))

    def interface_source_is_the_header(self) -> None:
        """The Fortran interface source has every function of the header with as many arguments."""
        header = (self.prefix / "include/qsmpm.h").read_text()
        source = (self.prefix / "share/qsmpm/fortran/qsmpm_c.f90").read_text()
        count = lambda text: 0 if text.strip() in ("", "void") else text.count(",") + 1  # noqa: E731
        in_c = {m[1]: count(m[2]) for m in re.finditer(r"^int (qsmpm_\w+)\(([^;]*?)\);", header, re.M | re.S)}
        in_fortran = {m[1]: count(m[2]) for m in re.finditer(r"function (qsmpm_\w+)\(([^)]*)\) bind", source)}
        expect(in_c == in_fortran and len(in_c) > 30, f"{set(in_c.items()) ^ set(in_fortran.items())}")
        exported = set(re.findall(r" T (qsmpm_\w+)", call("nm", "-D", self.lib / "libqsmpm.so")))
        expect(not set(in_c) - exported, f"not in the library: {set(in_c) - exported}")

    # ---- the page of the documentation ----

    def examples_of_the_page(self) -> None:
        """The four examples of docs/embedding.md print the last digit of a deck with their cards, and what it says: libraries of
        linear algebra choose by the processor, which the last two of sixteen digits show."""
        blocks = dict(re.findall(r"^```(fortran|c|f77|python|text)\n(.*?)^```", (TOP / "docs/embedding.md").read_text(),
                                 re.M | re.S))
        folder = self.work / "page"
        folder.mkdir()
        block = (HERE / "block.inp").read_text()
        (folder / "block.inp").write_text(block)
        cards = re.search(r"add_cards\((.*?)\)\n    run\.run", blocks["python"], re.S)[1]
        material, phase = eval(f"({cards})").split("*PHASE")  # noqa: S307 - the page's own string
        (folder / "deck.inp").write_text(block.replace("*BODY", material + "*BODY", 1) + "*PHASE" + phase + "\n")
        call(self.prefix / "bin/qsmpm", "run", "deck.inp", "--quiet", "--out", "deck", cwd=folder)
        settlement = last_settlement(folder / "deck")
        said = numbers(blocks["text"], "settlement")
        expect(len(said) == 1 and abs(said[0] / settlement - 1.0) < 1.0e-12, f"the deck settles {settlement:.16E}, the page says {said}")
        for name, text in (("page.f90", blocks["fortran"]), ("page.c", blocks["c"]), ("page.f", blocks["f77"]),
                           ("page.py", blocks["python"])):
            (folder / name).write_text(text)
        modules = next((self.prefix / "include/qsmpm").glob("*"))
        source = self.prefix / "share/qsmpm/fortran"
        shared = (f"-L{self.lib}", "-lqsmpm", f"-Wl,-rpath,{self.lib}")
        call("gfortran", "-Wall", "page.f90", f"-I{modules}", *shared, "-o", "fortran", cwd=folder)
        call("gcc", "-Wall", "-Werror", "page.c", f"-I{self.prefix / 'include'}", *shared, "-o", "c", cwd=folder)
        call("gfortran", "-std=legacy", source / "qsmpm_c.f90", source / "qsmpm_f77.f90", "page.f", *shared, "-o", "f77",
             cwd=folder)
        told = [call(folder / name, cwd=folder) for name in ("fortran", "c", "f77")]
        told.append(call(sys.executable, "page.py", cwd=folder, PYTHONPATH=str(TOP / "tools"), QSMPM_LIBRARY=str(self.lib)))
        for text in told:
            expect(numbers(text, "settlement") == [settlement], f"{settlement:.16E}, but {told}")

    # ---- Python ----

    def python(self, *words: object, seconds: int = 300) -> str:
        """Run Python with the package and the installed library."""
        return call(sys.executable, *words, seconds=seconds, PYTHONPATH=str(TOP / "tools"),
                    QSMPM_LIBRARY=str(self.lib))

    def steered_from_python(self) -> None:
        """A host that finds a limit load by bisection."""
        found = float(re.search(r"limit load ([\d.]+)", self.python("limit_load.py"))[1])
        # Twice the cohesion; the block is 0.1 % longer when it yields, steps are within 0.01 % of equilibrium and the
        # stabilisation carries up to half a per cent.
        expect(abs(found / 10.0 - 1.0) < 0.005, f"limit load {found}")

    def calls_a_umat_from_python(self) -> None:
        """A UMAT in a shared library, behind the shared library of a Python program, settles as the built-in law."""
        umat = self.work / "libelastic.so"
        call(self.prefix / "bin/build-umat", TOP / "verification/plugins/elastic_umat.f", "-o", umat)
        deck = (HERE / "block.inp").read_text().replace(
            "*UNIT WEIGHT", f"*USER MATERIAL, INTERFACE=UMAT, LIBRARY={umat}\n1000, 0.3\n*UNIT WEIGHT")
        (self.work / "umat.inp").write_text(deck)
        text = self.python("-c", f"""
import qsmpm
for deck in ({str(self.work / 'umat.inp')!r}, 'block.inp'):
    with qsmpm.Simulation(deck) as run:
        run.run()
        print(run.histories['settlement'])
""")
        own, theirs = map(float, text.split())
        # Rates of Cauchy and Kirchhoff stress, a volume strain apart.
        expect(0.0 < abs(own - theirs) < 0.02 * theirs, f"UMAT {own}, the library's {theirs}")

    def interleaved_runs_write_the_same_bytes(self) -> None:
        """Two analyses, one process, step about: their files are those of two runs of the command line."""
        decks = [TOP / "input/slope_e50_plane.inp", HERE / "block.inp"]
        for deck in decks:
            call(self.prefix / "bin/qsmpm", "run", deck, "--quiet", "--out", self.work / f"alone-{deck.stem}")
        self.python("-c", f"""
import qsmpm
runs = [qsmpm.Simulation(d) for d in {[str(d) for d in decks]!r}]
for run, name in zip(runs, {[d.stem for d in decks]!r}):
    run.record({str(self.work)!r} + '/together-' + name)
while not all(run.finished for run in runs):
    for run in runs:
        if not run.finished:
            run.advance()
for run in runs:
    run.close()
""")
        for deck in decks:
            self.same_files(self.work / f"alone-{deck.stem}", self.work / f"together-{deck.stem}")

    def cards_write_the_same_bytes(self) -> None:
        """A recorded run whose materials and phases come as cards has the files of the deck that has them."""
        block = (HERE / "block.inp").read_text()
        material = "*MATERIAL, NAME=stiff\n*ELASTIC\n5000, 0.3\n*MOHR COULOMB\n6, 25, 0\n*UNIT WEIGHT\n20, 22\n"
        phases = ["*PHASE, NAME=grout\n*CHANGE MATERIAL\nblock, stiff\n*END PHASE\n",
                  "*PHASE, NAME=flood\n*WATER LEVEL, UNIT WEIGHT=10\n0, 0.4\n*END PHASE\n",
                  "*PHASE, NAME=factor, TYPE=SAFETY\n*SAFETY, TOLERANCE=0.1\n*END PHASE\n",
                  "*PHASE, NAME=drawdown, PARENT=flood\n*WATER LEVEL, TYPE=NONE\n*END PHASE\n"]
        for name, text in (("whole", block.replace("*BODY", material + "*BODY", 1) + "".join(phases)), ("added", block)):
            (self.work / f"cards-{name}").mkdir()
            (self.work / f"cards-{name}/job.inp").write_text(text)
        call(self.prefix / "bin/qsmpm", "run", "job.inp", "--quiet", "--out", "out", cwd=self.work / "cards-whole")
        self.python("-c", f"""
import qsmpm
with qsmpm.Simulation({str(self.work / 'cards-added/job.inp')!r}) as run:
    run.add_cards({material + ''.join(phases[:3])!r})
    run.record({str(self.work / 'cards-added/out')!r})
    run.run()
    run.add_cards({phases[3]!r})
    run.run()
""")
        self.same_files(self.work / "cards-whole/out", self.work / "cards-added/out", log=False)

    def same_files(self, one: pathlib.Path, two: pathlib.Path, log: bool = True) -> None:
        """Compare folders; processor seconds are no result, and a log may count other phases."""
        names = sorted(str(p.relative_to(one)) for p in one.rglob("*") if p.is_file())
        expect(names == sorted(str(p.relative_to(two)) for p in two.rglob("*") if p.is_file()), f"other files: {two}")
        expect(any(n.endswith(".vtu") for n in names) and "results.h5" in names, f"no results in {one}")
        for name in names:
            if name == "job.log" and not log:
                continue
            if name == "job.log":
                lines = [[line for line in (folder / name).read_text().splitlines() if not line.startswith("time: ")]
                         for folder in (one, two)]
                expect(lines[0] == lines[1], f"{name} of {two.name} differs")
            elif name != "timing.json":
                expect(filecmp.cmp(one / name, two / name, shallow=False), f"{name} of {two.name} differs")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("build", nargs="?", type=pathlib.Path, default=TOP / "build")
    parser.add_argument("--long", action="store_true", help="build as a part of another project too")
    given = parser.parse_args()
    failed = skipped = 0
    with tempfile.TemporaryDirectory(prefix="qsmpm-embedding-") as folder:
        tests = Embedding(given.build.resolve(), pathlib.Path(folder))
        chosen: Sequence[Callable[[], None]] = [
            tests.installs, tests.holds_no_state, tests.found_by_cmake, tests.used_by_a_legacy_program,
            tests.steered_by_a_legacy_program, tests.steered_by_another_compiler,
            tests.warns_of_another_compiler, tests.refuses_another_minor_version, tests.found_by_a_c_project,
            tests.is_a_good_subproject, *([tests.builds_as_a_subproject] if given.long else []), tests.linked_from_c,
            tests.moves_and_loads_a_rigid_body, tests.linked_statically_from_c, tests.interface_source_is_the_header,
            tests.examples_of_the_page, tests.steered_from_python,
            tests.calls_a_umat_from_python,
            tests.interleaved_runs_write_the_same_bytes, tests.cards_write_the_same_bytes]
        for test in chosen:
            try:
                test()
            except Skipped as reason:
                skipped += 1
                print(f"skipped {test.__name__}: {reason}")
            except Exception as fault:  # noqa: BLE001 - any fault is a failed test
                failed += 1
                print(f"FAILED {test.__name__}: {type(fault).__name__}: {fault}")
            else:
                print(f"ok     {test.__name__}: {' '.join(str(test.__doc__).split())}")
    print(f"{len(chosen) - failed - skipped} passed, {failed} failed" + (f", {skipped} skipped" if skipped else ""))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
