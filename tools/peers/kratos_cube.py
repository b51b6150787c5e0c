#!/usr/bin/env python3
"""A block under a rigid plate in Kratos: 0.8 m high, on rollers, pressed down by 0.2 m in 20 steps, E = 1 MPa, nu = 0.

    kratos_cube.py CELLS IN THE HEIGHT [POINTS A CELL, a square number [PENALTY]]

The plate is its own conforming boundary: points along the top of the block whose displacement is prescribed by a penalty.
Prints the error of the mean vertical stress against the neo-Hookean law (E/2)(l - 1/l) with l = 3/4, and the largest
error at a point. Plane strain is exact here: there is no lateral movement. With `constrained` contact instead of fixed the
results are the same.
"""

import json
import math
import sys

import KratosMultiphysics as km
import KratosMultiphysics.MPMApplication as mpm
from KratosMultiphysics.MPMApplication import apply_mpm_particle_dirichlet_condition_process as plate_process

from kratos_scene import Run, Scene, tell

HEIGHT, MOVE, YOUNG, STEPS = 0.8, -0.2, 1.0e6, 20

cells = int(sys.argv[1])
across = math.isqrt(int(sys.argv[2])) if len(sys.argv) > 2 else 2
penalty = float(sys.argv[3]) if len(sys.argv) > 3 else 1.0e10


class Pressed(Run):
    """The scene with a line of points along its top."""

    def _make_forces(self) -> None:
        part = self.grid.CreateSubModelPart("plate")
        properties = self.grid.CreateNewProperties(2)
        number = self.last_node
        for i in range(cells + 1):
            part.CreateNewNode(number + 1 + i, HEIGHT * i / cells, HEIGHT, 0.0)
        for i in range(cells):
            part.CreateNewCondition("LineCondition2D2N", 1 + i, [number + 2 + i, number + 1 + i], properties)
        self.plate = plate_process.Factory(km.Parameters(json.dumps({"Parameters": {
            "model_part_name": "Background_Grid.plate", "material_points_per_condition": 2, "penalty_coefficient": penalty,
            "value": [0.0, MOVE / STEPS, 0.0]}})), self.model)

    def _load(self, share: float) -> None:
        if not self.done:
            self.plate.ExecuteBeforeSolutionLoop()
        self.plate.ExecuteInitializeSolutionStep()


edge = HEIGHT / cells / across
squares = [((i + 0.5) * edge, (j + 0.5) * edge) for j in range(across * cells) for i in range(across * cells)]
scene = Scene(
    low=(0.0, 0.0), high=(HEIGHT, HEIGHT + HEIGHT / cells), cells=(cells, cells + 1), squares=squares, size=(edge, edge),
    density=1.0, law="HyperElasticNeoHookeanPlaneStrain2DLaw", constants={"YOUNG_MODULUS": YOUNG, "POISSON_RATIO": 0.0},
    held=lambda x, y: "xy" if y < 1e-9 else "x", steps=STEPS)
run = Pressed(scene)
ended = "done"
for _ in range(STEPS):
    try:
        run.step()
    except RuntimeError as trouble:
        ended = str(trouble).strip().splitlines()[0][:80]
        break
ratio = (HEIGHT + MOVE) / HEIGHT
exact = 0.5 * YOUNG * (ratio - 1 / ratio)
stress, volume = run.values(mpm.MP_CAUCHY_STRESS_VECTOR), run.values(mpm.MP_VOLUME)
mean = sum(s[1] * v for s, v in zip(stress, volume)) / sum(volume)
tell(run, ended, mean=mean, exact=exact, error=abs(mean / exact - 1), largest=max(abs(s[1] / exact - 1) for s in stress),
     top=max(place[1] for place in run.values(mpm.MP_COORD)))
