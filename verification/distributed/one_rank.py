"""Checks of one rank: the same program as the other one, and PETSc as a solver beside the direct ones."""

from __future__ import annotations

import re

from support import TOP, Check, Place, Run, distance, expect, with_solver

SPLINES = "BASIS=SPLINE2, INTEGRATION=POINTS, KINEMATICS=LOGARITHMIC, STABILISATION=GHOST, FACTOR=0.01"
# Curves of two solvers agree to so many times the TOLERANCE of the deck.
MARGIN = 10.0


def cut(cells: int, poisson: float, factor: float, steps: int, strength: str = "1, 25, 0", solver: str = "AUTO",
        method: str = "BASIS=STANDARD, INTEGRATION=POINTS, KINEMATICS=LOGARITHMIC", wide: float = 1.5,
        restart: str = "") -> str:  # fmt: skip
    """A vertical cut of 1 m in 3D with a free face, under growing weight; without strength an elastic cube."""
    law = f"*MOHR COULOMB\n{strength}\n" if strength else ""
    return f"""*HEADING
Vertical cut of 1 m under growing weight.
*UNITS, LENGTH=m, FORCE=kN
*MODEL, TYPE=3D
*GRID, ELEMENT=HEX8
X, 0, {wide}, {round(cells * wide)}
Y, 0, 1, {cells}
Z, 0, 1, {cells}
*NSET, NSET=base, PLANE=Y
0
*NSET, NSET=left, PLANE=X
0
*NSET, NSET=front, PLANE=Z
0
*NSET, NSET=back, PLANE=Z
1
*MATERIAL, NAME=soil
*ELASTIC
1000, {poisson}
{law}*UNIT WEIGHT
1
*BODY, NAME=cut, MATERIAL=soil, SHAPE=BOX
0, 1, 0, 1, 0, 1
*POINTS, BODY=cut, PER ELEMENT=8
*METHOD, {method}
*SOLVER, TYPE={solver}
*HISTORY, NAME=settlement, QUANTITY=DISPLACEMENT, COMPONENT=Y, SCALE=-1
1, 1, 0.5
{restart}*PHASE, NAME=gravity, LOAD FACTOR={factor}
*FIX
base, ALL
left, X
front, Z
back, Z
*GRAVITY
0, -1, 0
*CONTROLS, STEPS={steps}, NEWTON=FULL, TOLERANCE=1E-4, STABILISATION SHARE=1
*END PHASE
"""


LOST = cut(2, 0.3, 500.0, 1, solver="MUMPS").replace("*CONTROLS, ", "*CONTROLS, DAMPING=NO, SMALLEST STEP=0.1, ")
"""A weight that no increment of which is carried."""


def compare(place: Place, name: str, deck: str, bound: int, tolerance: float = 1.0e-4) -> Run:
    """Run a deck with MUMPS and with PETSC: curves, sweeps of the hardest correction, no fallback."""
    direct = place.run("qsmpm", deck.replace("{solver}", "MUMPS"), f"{name}-mumps")
    swept = place.run("qsmpm-mpi", deck.replace("{solver}", "PETSC"), f"{name}-petsc")
    apart, sweeps = distance(direct, swept), swept.profile["most_sweeps"]
    expect(swept.profile["solver"] == "PETSc GAMG", f"{name}: {swept.profile['solver']} solved in the end")
    expect(apart <= MARGIN * tolerance, f"{name}: curves {apart:.1e} apart, bound {MARGIN * tolerance:.1e}")
    expect(0 < sweeps <= bound, f"{name}: {sweeps} sweeps for one correction, bound {bound}")
    return swept


def no_sequential_library(place: Place) -> None:
    """qsmpm-mpi is linked with nothing of the sequential MUMPS, whose empty MPI would take the place of the real one."""
    linked = place.call("ldd", place.build / "qsmpm-mpi")
    expect("_seq" not in linked, linked)
    expect("libpetsc" in linked and "libmpi." in linked, f"no PETSc or no MPI:\n{linked}")
    expect("_seq" in place.call("ldd", place.build / "qsmpm"), "qsmpm has lost its sequential MUMPS")


def same_bytes(place: Place) -> None:
    """One rank gives the bytes of the program of one process: bands, MUMPS in double and single precision, IC(0)."""
    column = TOP / "input/column_logarithmic.inp"
    scenes = {"column": column.read_text()}
    for word in ("MUMPS", "MUMPS, PRECISION=SINGLE", "KRYLOV", "CHOLMOD"):
        scenes[word.split("=")[-1].lower()] = cut(6, 0.3, 4.0, 1, solver=word)
    for name, deck in scenes.items():
        alone = place.run("qsmpm", deck, f"{name}-alone")
        for ranks in (0,) if name == "column" else (1,):
            other = place.run("qsmpm-mpi", deck, f"{name}-{ranks}", ranks)
            expect(alone.curves == other.curves, f"{name}: other curves with {ranks or 'no'} mpirun -n")


def unit_tests(place: Place) -> None:
    """The unit tests of PETSc and of the other solvers hold in the program of many processes, rows of three ranks too."""
    said = place.call(place.build / "run_unit_tests-mpi", "petsc_solver", "linear_solver", "linear_system", "petsc_ranks")
    expect(", 0 failed" in said, said)
    said = place.call("mpirun", "-n", "3", place.build / "run_unit_tests-mpi", "petsc_ranks")
    expect(said.count("passed, 0 failed") == 3, f"3 ranks: {said}")


def multigrid_solves(place: Place) -> None:
    """PETSC takes few sweeps and gives the curves of MUMPS: elastic and failing bodies, splines, wedges."""
    compare(place, "elastic", cut(8, 0.3, 2.0, 1, strength="", solver="{solver}", wide=1.0), 20)
    compare(place, "failing", cut(6, 0.3, 7.5, 3, solver="{solver}"), 40)
    compare(place, "splines", cut(4, 0.3, 6.0, 2, solver="{solver}", method=SPLINES), 40)
    compare(place, "wedges", shortened("slope_e200_coarse.inp", 15), 90)


def multigrid_solves_larger(place: Place) -> None:
    """The same of larger bodies, nearly incompressible ones too, and of a slope on fine splines."""
    compare(place, "elastic", cut(14, 0.3, 2.0, 1, strength="", solver="{solver}", wide=1.0), 20)
    compare(place, "failing", cut(14, 0.3, 7.5, 5, solver="{solver}"), 40)
    compare(place, "incompressible", cut(14, 0.495, 6.2, 4, solver="{solver}"), 60)
    compare(place, "splines", cut(8, 0.3, 6.0, 2, solver="{solver}", method=SPLINES), 40)
    fine = shortened("slope_grid.inp", 15).replace("X, 0, 5, 50", "X, 0, 5, 200").replace("Y, 0, 1, 10", "Y, 0, 1, 40")
    compare(place, "slope", fine, 45)


def shortened(name: str, factor: int) -> str:
    """The first steps of a slope of input/, up to a load."""
    deck = with_solver(TOP / "input" / name, "TYPE={solver}")
    deck = deck.replace("LOAD FACTOR=100", f"LOAD FACTOR={factor}").replace("STEPS=100", "STEPS=5")
    return deck.replace("*CONSTANT LOAD TEST, REPEATS=10\n30, 100\n", "")


def gives_way(place: Place) -> None:
    """Where multigrid does not get there a direct solver does, the log says so, and the answer is that of MUMPS."""
    deck = cut(8, 0.49999999, 3.0, 1, strength="", solver="{solver}")
    deck = deck.replace("*UNIT WEIGHT", "*VOLUMETRIC LOCKING, TYPE=NONE\n*UNIT WEIGHT")
    direct = place.run("qsmpm", deck.replace("{solver}", "MUMPS"), "direct")
    swept = place.run("qsmpm-mpi", deck.replace("{solver}", "PETSC"), "swept")
    expect("PETSc GAMG does not precondition the equations: factors of double precision" in swept.log, swept.log)
    expect("PETSc" not in swept.profile["solver"], swept.profile["solver"])
    expect(distance(direct, swept) < 1.0e-3, f"curves {distance(direct, swept):.1e} apart")


def repeats(place: Place) -> None:
    """PETSC gives the same bytes again, whatever PETSC_OPTIONS and .petscrc say, and prints nothing."""
    deck = cut(6, 0.1, 9.0, 1, solver="PETSC")
    (place.work / ".petscrc").write_text("-log_view\n-qsmpm_ksp_monitor\n-qsmpm_ksp_gmres_cgs_refinement_type refine_always\n")
    first = place.run("qsmpm-mpi", deck, "first")
    other = place.run("qsmpm-mpi", deck, "other", HOME=str(place.work),
                      PETSC_OPTIONS="-log_view -qsmpm_ksp_initial_guess_nonzero -qsmpm_pc_gamg_sym_graph")  # fmt: skip
    expect(first.curves == other.curves, "other curves with other options in the environment")
    expect(not re.search("KSP|Vec|[Oo]ption", other.said), other.said)
    each = place.run("qsmpm-mpi", deck.replace("TYPE=PETSC", "TYPE=PETSC, KEEP FACTOR=NO"), "each")
    expect(each.profile["sweeps"] < first.profile["sweeps"], "KEEP FACTOR=NO takes no fewer sweeps: is it heard?")


def continues(place: Place) -> None:
    """A run with PETSC that is continued from its restart file gives the bytes of one that went through."""
    deck = cut(4, 0.3, 7.0, 20, solver="PETSC", restart="*RESTART, EVERY=1\n")
    through = place.run("qsmpm-mpi", deck, "through")
    part = place.stop("qsmpm-mpi", deck, "part", rows=5)
    expect(len(part.rows()) < len(through.rows()), "the run was through before it was stopped")
    rest = place.run("qsmpm-mpi", place.work / "part.inp", "part", restart=part.folder / "restart.h5")
    expect(through.curves == rest.curves, f"{through.rows()[-1]}\n{rest.rows()[-1]}")


def exit_codes(place: Place) -> None:
    """What mpirun returns is the exit code of the program, and a run that fails ends MPI in order."""
    wrong = place.run("qsmpm-mpi", "*HEADNG\n", "wrong", ranks=1, code=2)
    expect("HEADNG" in wrong.said and "without calling" not in wrong.said, wrong.said)
    alone = place.run("qsmpm", LOST, "alone", code=None)
    lost = place.run("qsmpm-mpi", LOST, "lost", ranks=1, code=None)
    expect(alone.code == lost.code and alone.code in (3, 4), f"codes {alone.code} and {lost.code}")
    expect("without calling" not in lost.said, lost.said)


CHECKS: list[Check] = [
    no_sequential_library, same_bytes, unit_tests, multigrid_solves, gives_way, repeats, continues, exit_codes,
]  # fmt: skip
LONG_CHECKS: list[Check] = [multigrid_solves_larger]
