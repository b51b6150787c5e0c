#!/usr/bin/env python3
"""The self-weight column in Kratos: 50 m, E = 10 kPa, nu = 0, 0.8 kN/m3, 40 steps.

    kratos_column.py CELLS [POINTS A CELL, a square number] [STEPS]

Prints the stress error sum |s - s(X)| V / (g l0 sum V), s(X) = -g (l0 - X), with V the initial volume as
in tools/qsmpm_verify/measures.py, and sum |s - s(X)| v / (g l0 sum V) with the final volume v. The law is
neo-Hookean: the exact stress does not depend on it.
"""

import math
import sys

import KratosMultiphysics.MPMApplication as mpm

from kratos_scene import Run, Scene, tell

HEIGHT, WEIGHT = 50.0, 800.0

cells = int(sys.argv[1])
across = math.isqrt(int(sys.argv[2])) if len(sys.argv) > 2 else 2
steps = int(sys.argv[3]) if len(sys.argv) > 3 else 40
dx, dy = 1.0 / across, HEIGHT / cells / across
squares = [((i + 0.5) * dx, (j + 0.5) * dy) for j in range(cells * across) for i in range(across)]
scene = Scene(
    low=(0.0, 0.0), high=(1.0, HEIGHT), cells=(1, cells), squares=squares, size=(dx, dy), density=WEIGHT,
    law="HyperElasticNeoHookeanPlaneStrain2DLaw", constants={"YOUNG_MODULUS": 1.0e4, "POISSON_RATIO": 0.0},
    held=lambda x, y: "xy" if y < 1e-9 else "x", steps=steps, gravity=(0.0, -1.0))
run = Run(scene)
ended = "done"
for _ in range(steps):
    try:
        run.step()
    except RuntimeError as trouble:
        ended = str(trouble).strip().splitlines()[0][:80]
        break
stress, volume = run.values(mpm.MP_CAUCHY_STRESS_VECTOR), run.values(mpm.MP_VOLUME)
distance = [abs(s[1] + WEIGHT * (HEIGHT - place[1])) / (WEIGHT * HEIGHT) for s, place in zip(stress, squares)]
tell(run, ended, error=sum(distance) / len(distance),
     error_now=sum(d * v for d, v in zip(distance, volume)) / HEIGHT,
     top=run.values(mpm.MP_COORD)[-1][1])
