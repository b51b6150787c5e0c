#!/usr/bin/env python3
"""The Debian package: made, looked at, unpacked and used as it would lie on another machine; closes with N passed, M failed.

    verification/debian_package.py BUILD

Nothing is installed: the package is unpacked into a folder, and apt is asked (-s) whether the system could take it. Left out
where there is no dpkg.
"""

from __future__ import annotations

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

TOP = pathlib.Path(__file__).resolve().parents[1]
HERE = TOP / "verification" / "embedding"
# What there is to find, below /usr.
WANTED = (
    "bin/qsmpm", "bin/build-umat", "include/qsmpm.h", "lib/libqsmpm.a", "lib/libqsmpm.so", "lib/pkgconfig/qsmpm.pc",
    "lib/cmake/qsmpm/qsmpmConfig.cmake", "share/qsmpm/fortran/qsmpm_c.f90", "share/doc/qsmpm/copyright", "share/doc/qsmpm/LICENSE",
    "share/doc/qsmpm/docs/reference.md", "share/doc/qsmpm/docs/tutorial/README.md", "share/doc/qsmpm/input/slope_grid.inp",
)
passed = failed = 0


def check(name: str, held: bool, told: str = "") -> None:
    global passed, failed
    passed, failed = passed + bool(held), failed + (not held)
    print(("ok     " if held else "FAILED ") + name + ("" if held else f": {told[-400:]}"))


def call(*words: object, cwd: pathlib.Path | None = None, **more: str) -> subprocess.CompletedProcess[str]:
    """Run a command, and keep what it says."""
    environment = {"PATH": "/usr/bin:/bin:/usr/sbin:/sbin", "HOME": "/tmp", "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", **more}
    return subprocess.run([str(w) for w in words], cwd=cwd, env=environment, capture_output=True, text=True, timeout=600)


def look_at(package: pathlib.Path, build: pathlib.Path) -> None:
    """Its fields."""
    fields = dict(re.findall(r"^([A-Z][\w-]*): (.*)$", call("dpkg-deb", "-f", package).stdout, re.MULTILINE))
    version = re.search(r"VERSION ([\d.]+)", (TOP / "CMakeLists.txt").read_text().split("project(")[1])
    check("it has its name and version", fields.get("Package") == "qsmpm" and bool(version) and fields.get("Version") == version[1], str(fields))
    depends = fields.get("Depends", "")
    check("it depends on what is linked", all(n in depends for n in ("libhdf5", "libmumps", "libopenblas", "libgfortran5", "libmetis")), depends)
    linked = "cholmod" in call("ldd", build / "qsmpm").stdout
    check("on SuiteSparse only where it is linked", ("cholmod" in depends) == linked, depends)
    asked = call("apt-get", "-s", "--no-install-recommends", "install", package)
    check("the system could take it", asked.returncode == 0 and "Inst qsmpm" in asked.stdout, asked.stderr or asked.stdout)


def use(usr: pathlib.Path, work: pathlib.Path) -> None:
    """The program, an own model, a C program and a Fortran program by what was unpacked alone."""
    deck = usr / "share/doc/qsmpm/docs/tutorial/1_block.inp"
    run = call(usr / "bin/qsmpm", "run", deck, "--quiet", "--out", work / "out")
    check("the tutorial's first deck runs", run.returncode == 0 and (work / "out/results.h5").is_file(), run.stderr)
    model = call(usr / "bin/build-umat", usr / "share/doc/qsmpm/docs/tutorial/7_stiffening.f", "-o", work / "libstiffening.so")
    check("an own model is built", model.returncode == 0 and (work / "libstiffening.so").is_file(), model.stderr)
    flags = call("pkg-config", "--cflags", "--libs", "qsmpm", PKG_CONFIG_PATH=str(usr / "lib/pkgconfig")).stdout.split()
    built = call("gcc", HERE / "c/host.c", *flags, f"-Wl,-rpath,{usr / 'lib'}", "-lm", "-o", work / "host", cwd=work)
    check("a C program is built by pkg-config", built.returncode == 0, built.stderr)
    shutil.copy(HERE / "block.inp", work)
    told = call(work / "host", cwd=work)
    check("and runs", told.returncode == 0 and str(usr) in call("ldd", work / "host").stdout, told.stdout + told.stderr)


def main() -> int:
    """Make it and go through it."""
    build = pathlib.Path(sys.argv[1]).resolve()
    if not all(map(shutil.which, ("dpkg-deb", "dpkg-shlibdeps", "cpack"))):
        print("skipped: no dpkg and cpack here\n0 passed, 0 failed, 1 skipped")
        return 0
    with tempfile.TemporaryDirectory() as name:
        work = pathlib.Path(name)
        made = call("cpack", "--config", build / "CPackConfig.cmake", "-B", work)
        packages = list(work.glob("*.deb"))
        check("cpack makes one package", made.returncode == 0 and len(packages) == 1, made.stdout + made.stderr)
        if packages:
            look_at(packages[0], build)
            call("dpkg-deb", "-x", packages[0], work / "root")
            usr = work / "root" / "usr"
            missing = [n for n in WANTED if not (usr / n).exists()]
            check("everything is in it", not missing, ", ".join(missing))
            named = [str(p) for p in usr.rglob("*") if p.is_file() and p.suffix in (".cmake", ".pc", "", ".txt")
                     and p.read_bytes()[:4] != b"\x7fELF" and str(TOP) in p.read_text(errors="ignore")]
            check("no text in it names the source folder", not named, ", ".join(named))
            licences = {p.stem for p in (usr / "share/doc/qsmpm/licences").glob("*.txt")}
            text = (usr / "share/doc/qsmpm/copyright").read_text() if (usr / "share/doc/qsmpm/copyright").is_file() else ""
            linked = "cholmod" in call("ldd", build / "qsmpm").stdout
            check("licences of what is linked are in it", "libmumps-seq-dev" in licences and ("libsuitesparse-dev" in licences) == linked, str(licences))
            check("and it says under which it stands", ("GPL" in text.split("BSD 3-Clause License")[0]) == linked and "BSD 3-Clause" in text, text)
            use(usr, work)
    print(f"{passed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
