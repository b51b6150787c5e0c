#!/usr/bin/env python3
"""The program of many processes, qsmpm-mpi, beside the other one; closes with `N passed, N failed`.

    run_ranks.py [BUILD] [--long] [--check NAME ...] [--list]

Where BUILD (default build) has no qsmpm-mpi, because MPI or PETSc are not installed, that is said and its checks are skipped.
Each check is a function of a module of this folder; its first line says what it promises.
"""
from __future__ import annotations

import argparse
import concurrent.futures
import pathlib
import resource
import sys
import tempfile
from itertools import chain

import faults
import inside_outlines
import joint_files
import many_ranks
import migration
import more_scenes
import named_scenes
import one_rank
import phase_begins
import restarts
import shared_meshes
import shared_scenes
from support import TOP, Check, Place

MODULES = [one_rank, many_ranks, migration, shared_scenes, more_scenes, shared_meshes, named_scenes, phase_begins, faults, joint_files,
           restarts, inside_outlines]
CHECKS = [check for module in MODULES for check in module.CHECKS]
LONG_CHECKS = [check for module in MODULES for check in module.LONG_CHECKS]
AT_ONCE = 2
"""Checks that run at the same time, since ranks wait for each other as they start and end; those of BY_THE_CLOCK run alone."""
BY_THE_CLOCK = (faults, joint_files, restarts, many_ranks)
CPU_SECONDS = 60
"""What the short part may take, all processes together; printed beside what it took."""


def name_of(check: Check) -> str:
    """Module and function: two modules may have a check of one name."""
    return f"{check.__module__}.{check.__name__}"


def fault_of(check: Check, place: Place) -> str | None:
    """Run a check in a folder of its own; what is wrong, None for nothing."""
    place.work.mkdir()
    try:
        check(place)
    except (AssertionError, OSError) as wrong:
        return str(wrong)
    return None


def main() -> int:
    reader = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    reader.add_argument("build", nargs="?", type=pathlib.Path, default=TOP / "build")
    reader.add_argument("--long", action="store_true", help="the long checks too")
    reader.add_argument("--check", action="append", default=[], help="a check of this name alone, short or long; may be repeated")
    reader.add_argument("--list", action="store_true", help="the names of the checks, and no more")
    words = reader.parse_args()
    build = words.build.resolve()
    checks = CHECKS + (LONG_CHECKS if words.long or words.check else [])
    if words.list:
        print("\n".join(name_of(check) for check in checks))
        return 0
    checks = [check for check in checks if not words.check or name_of(check) in words.check]
    if not (build / "qsmpm-mpi").is_file():
        print(f"skipped: {build} has no qsmpm-mpi: tools/setup --mpi, then cmake -DQSMPM_MPI=ON")
        print(f"0 passed, 0 failed, {len(checks)} skipped")
        return 0
    failed = 0
    clocked = {module.__name__ for module in BY_THE_CLOCK}
    checks.sort(key=lambda check: check.__module__ in clocked)
    beside = [check for check in checks if check.__module__ not in clocked]
    with tempfile.TemporaryDirectory(prefix="qsmpm-ranks-") as folder, concurrent.futures.ThreadPoolExecutor(AT_ONCE) as pool:
        places = [Place(build, pathlib.Path(folder) / f"{number}-{check.__name__}") for number, check in enumerate(checks)]
        found = chain(pool.map(fault_of, beside, places), map(fault_of, checks[len(beside):], places[len(beside):]))
        for check, wrong in zip(checks, found, strict=True):
            name = (check.__doc__ or check.__name__).splitlines()[0]
            failed += wrong is not None
            print(f"ok     {name} ({name_of(check)})" if wrong is None else f"FAILED {name} ({name_of(check)})\n       {wrong}", flush=True)
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    print(f"{used.ru_utime + used.ru_stime:.1f} CPU seconds{'' if words.long or words.check else f' of {CPU_SECONDS}'}")
    print(f"{len(checks) - failed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
