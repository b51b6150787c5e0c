#!/usr/bin/env python3
"""The cantilever in Kratos: 10 m by 1 m, E = 12 MPa, nu = 0.2, plane strain, 100 kN at its end, 50 steps.

    kratos_cantilever.py [CELL SIZE] [POINTS A CELL, a square number]

Neo-Hookean. The dead load acts at the outermost material points: beyond them it would act on empty cells. `down` and
`inward` are those of these points, `tip_down` and `tip_inward` are extrapolated to the end of the beam.
"""

import math
import sys

import KratosMultiphysics.MPMApplication as mpm

from kratos_scene import Run, Scene, tell

LENGTH, LOAD = 10.0, 1.0e5

size = float(sys.argv[1]) if len(sys.argv) > 1 else 0.25
across = math.isqrt(int(sys.argv[2])) if len(sys.argv) > 2 else 6
dx = size / across
columns, rows = round(LENGTH / dx), round(1.0 / dx)
squares = [((i + 0.5) * dx, (j + 0.5) * dx - 0.5) for j in range(rows) for i in range(columns)]
scene = Scene(
    low=(0.0, -9.5), high=(11.0, 1.5), cells=(round(11.0 / size), round(11.0 / size)), squares=squares,
    size=(dx, dx), density=1.0, law="HyperElasticNeoHookeanPlaneStrain2DLaw",
    constants={"YOUNG_MODULUS": 1.2e7, "POISSON_RATIO": 0.2}, held=lambda x, y: "xy" if x < 1e-9 else "", steps=50,
    forces=[((LENGTH - 0.5 * dx, (j + 0.5) * dx - 0.5), (0.0, -LOAD / rows)) for j in range(rows)])
run = Run(scene)
ended = "done"
for _ in range(scene.steps):
    try:
        run.step()
    except RuntimeError as trouble:
        ended = str(trouble).strip().splitlines()[0][:80]
        break
moved = run.values(mpm.MP_DISPLACEMENT)


def mean_move(x: float, axis: int) -> float:
    """Mean displacement of the points of an initial cross-section."""
    return sum(moved[run.nearest(x, (j + 0.5) * dx - 0.5)][axis] for j in range(rows)) / rows


outermost, before = ([mean_move(LENGTH - share * dx, axis) for axis in (0, 1)] for share in (0.5, 1.5))
tip = [1.5 * last - 0.5 * other for last, other in zip(outermost, before)]
tell(run, ended, down=-outermost[1], inward=-outermost[0], tip_down=-tip[1], tip_inward=-tip[0],
     points_left=run.points.NumberOfElements(), loads_left=run.points.NumberOfConditions())
