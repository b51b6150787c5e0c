#!/usr/bin/env python3
"""Elastic scenes at small load in the MPM application of Kratos: the slope under self-weight, Cook's membrane.

    kratos_elastic.py slope|cook CELLS [POINTS A CELL, a square number]

slope: 45 degrees, 1 m high, 1 m crest, nu = 0.33; CELLS over the height; settlement `crest` of the crest for E = 1 and
weight 1. cook: nu = 1/3, CELLS on the clamped side; rise `middle` of the middle of the end for E = 1 and load 1.
Loads are small, so that displacements are small; the law is neo-Hookean. Material points are placed where
their squares are inside the body; at an inclined side this omits or adds parts of squares. The displacement of a
corner is that of the nearest point.
"""

import math
import sys

import KratosMultiphysics.MPMApplication as mpm

from kratos_scene import Run, Scene, tell

name, cells = sys.argv[1], int(sys.argv[2])
across = math.isqrt(int(sys.argv[3])) if len(sys.argv) > 3 else 2
law = "HyperElasticNeoHookeanPlaneStrain2DLaw"
if name == "slope":
    small = 1e-6
    d = 1.0 / cells / across
    squares = [((i + 0.5) * d, (j + 0.5) * d) for j in range(cells * across) for i in range(2 * cells * across)
               if (i + 0.5) * d + (j + 0.5) * d < 2.0 + 1e-9]
    scene = Scene(
        low=(0.0, 0.0), high=(3.0, 1.25), cells=(3 * cells, cells + cells // 4), squares=squares, size=(d, d),
        density=1.0, law=law, constants={"YOUNG_MODULUS": 1.0 / small, "POISSON_RATIO": 0.33},
        held=lambda x, y: "xy" if y < 1e-9 else ("x" if x < 1e-9 or x > 3.0 - 1e-9 else ""), steps=1,
        gravity=(0.0, -1.0), tolerance=1e-8)
    place, figure, scale = (1.0, 1.0), "crest", -1.0 / small
else:
    small = 1e-6
    h = 44.0 / cells
    d = h / across
    columns = round(48.0 / d)
    dx = 48.0 / columns
    squares = [((i + 0.5) * dx, (j + 0.5) * d) for j in range(round(64.0 / d)) for i in range(columns)
               if 44.0 * (i + 0.5) * dx / 48.0 <= (j + 0.5) * d <= 44.0 + 16.0 * (i + 0.5) * dx / 48.0]
    end = [square for square in squares if square[0] > 48.0 - dx]
    rows = math.ceil(64.0 / h)
    scene = Scene(
        low=(0.0, 0.0), high=(48.0 + 48.0 / columns * across, rows * h), cells=(columns // across + 1, rows),
        squares=squares, size=(dx, d), density=1.0, law=law,
        constants={"YOUNG_MODULUS": 1.0, "POISSON_RATIO": 1.0 / 3.0}, held=lambda x, y: "xy" if x < 1e-9 else "",
        steps=1, tolerance=1e-8, forces=[(square, (0.0, small / len(end))) for square in end])
    place, figure, scale = (48.0, 52.0), "middle", 1.0 / small
run = Run(scene)
ended = "done"
try:
    run.step()
except RuntimeError as trouble:
    ended = str(trouble).strip().splitlines()[0][:80]
moved = run.values(mpm.MP_DISPLACEMENT)[run.nearest(*place)][1]
tell(run, ended, **{figure: scale * moved})
