#!/usr/bin/env python3
"""The slope in Kratos: 45 degrees, 1 m high, 1 m crest, c = 1 kPa, phi = 25, psi = 0, nu = 0.33, gamma to 100 kN/m3.

    kratos_slope.py static|dynamic [CELL SIZE] [STEPS] [E in Pa] [PSI in degrees]

static: its quasi-static solver, gamma increases with the steps; it ends when an element inverts.
dynamic: its implicit dynamic solver, gamma increases over 10 s, which reaches 100 kN/m3.
Prints the settlement of the point nearest to the crest at gamma = 10, 30, 50 and at the end, and the knee of the
curve: gamma at which the compliance of a step first exceeds ten times that of the first. The law requires angles in radians.
"""

import math
import sys

import KratosMultiphysics.MPMApplication as mpm

from kratos_scene import Run, Scene, tell

GAMMA, ACROSS = 1.0e5, 2

dynamic = sys.argv[1] == "dynamic"
size = float(sys.argv[2]) if len(sys.argv) > 2 else 0.125
steps = int(sys.argv[3]) if len(sys.argv) > 3 else (5000 if dynamic else 200)
young = float(sys.argv[4]) if len(sys.argv) > 4 else 5.0e4
psi = float(sys.argv[5]) if len(sys.argv) > 5 else 0.0
d = size / ACROSS
squares = [((i + 0.5) * d, (j + 0.5) * d) for j in range(round(1.0 / d)) for i in range(round(2.0 / d))
           if (i + 0.5) * d + (j + 0.5) * d < 2.0 + 1e-9]
density = GAMMA / 9.81
scene = Scene(
    low=(0.0, 0.0), high=(5.0, 1.25), cells=(round(5.0 / size), round(1.25 / size)), squares=squares, size=(d, d),
    density=density, law="HenckyMCPlasticPlaneStrain2DLaw",
    constants={"YOUNG_MODULUS": young, "POISSON_RATIO": 0.33, "COHESION": 1.0e3,
               "INTERNAL_FRICTION_ANGLE": math.radians(25.0), "INTERNAL_DILATANCY_ANGLE": math.radians(psi)},
    held=lambda x, y: "xy" if y < 1e-9 else ("x" if x < 1e-9 or x > 5.0 - 1e-9 else ""),
    steps=steps, end=10.0 if dynamic else 1.0, dynamic=dynamic, gravity=(0.0, -9.81))
run = Run(scene)
crest = run.nearest(1.0, 1.0)
ended, curve, moves = "done", {}, [0.0]
for number in range(1, steps + 1):
    try:
        run.step()
    except RuntimeError as trouble:
        ended = str(trouble).strip().splitlines()[0][:80]
        break
    gamma = 1e-3 * GAMMA * number / steps
    moves.append(-run.values(mpm.MP_DISPLACEMENT)[crest][1])
    if any(abs(gamma - wanted) < 1e-9 for wanted in (10, 30, 50, 100)):
        curve[f"{gamma:g}"] = moves[-1]
yields = [after - before for before, after in zip(moves, moves[1:])]
knee = next((1e-3 * GAMMA * number / steps for number, much in enumerate(yields, 1) if much > 10.0 * yields[0]), None)
tell(run, ended, knee=knee, reached=1e-3 * GAMMA * run.done / steps, settlement=curve)
