"""A plane-strain scene for the MPM application of Kratos Multiphysics: grid, points, ramp, results.

Runs in the environment of `tools/setup --peers`. The scripts beside this module describe one scene each
and print one JSON object on their last line. The grid and the body are built in memory, the load is ramped step by
step, and a step that Kratos reports as not converged is counted: Kratos itself continues.
"""

from __future__ import annotations

import json
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import KratosMultiphysics as km
import KratosMultiphysics.LinearSolversApplication  # noqa: F401  registers sparse_lu
import KratosMultiphysics.MPMApplication as mpm
from KratosMultiphysics.MPMApplication import mpm_implicit_dynamic_solver, mpm_quasi_static_solver

Place = tuple[float, float]


@dataclass
class Scene:
    """Input data. Lengths in m, forces in N, masses in kg."""

    #: Corners of the grid and its cells along x and y.
    low: Place
    high: Place
    cells: tuple[int, int]
    #: Centroids of the squares of material, one material point in each, and their edge length.
    squares: list[Place]
    size: Place
    density: float
    law: str
    constants: dict[str, float]
    #: Directions held at a place of the grid, out of "", "x", "y", "xy".
    held: Callable[[float, float], str]
    #: Steps, time at the end and Newton iterations allowed a step.
    steps: int
    end: float = 1.0
    max_iterations: int = 40
    tolerance: float = 1e-6
    dynamic: bool = False
    #: Acceleration at full load, and places with the forces there at full load.
    gravity: Place = (0.0, 0.0)
    forces: list[tuple[Place, Place]] = field(default_factory=list)


class Run:
    """A scene in Kratos."""

    def __init__(self, scene: Scene) -> None:
        km.Logger.GetDefaultOutput().SetSeverity(km.Logger.Severity.WARNING)
        km.ParallelUtilities.SetNumThreads(1)
        self.scene = scene
        self.model = km.Model()
        kind = mpm_implicit_dynamic_solver if scene.dynamic else mpm_quasi_static_solver
        self.solver = kind.CreateSolver(self.model, self._settings())
        self.solver.AddVariables()
        self.grid = self.model["Background_Grid"]
        self.body = self.model["Initial_MPM_Material"]
        self._make_grid()
        self._make_body()
        self._make_forces()
        self.solver.ImportModelPart()
        self.solver.PrepareModelPart()
        self.solver.AddDofs()
        self._read_material()
        self.solver.Initialize()
        self._hold()
        self.points = self.model["MPM_Material"]
        self.iterations = 0
        self.unconverged: list[int] = []
        self.done = 0

    def _settings(self) -> km.Parameters:
        return km.Parameters(json.dumps({
            "model_part_name": "MPM_Material",
            "domain_size": 2,
            "time_stepping": {"time_step": self.scene.end / self.scene.steps},
            "grid_model_import_settings": {"input_type": "use_input_model_part"},
            "model_import_settings": {"input_type": "use_input_model_part"},
            "material_import_settings": {"materials_filename": ""},
            "convergence_criterion": "residual_criterion",
            "residual_relative_tolerance": self.scene.tolerance,
            "residual_absolute_tolerance": 1e-9,
            "max_iteration": self.scene.max_iterations,
            "linear_solver_settings": {"solver_type": "LinearSolversApplication.sparse_lu"},
        }))

    def _make_grid(self) -> None:
        """Bilinear squares."""
        (x0, y0), (x1, y1), (nx, ny) = self.scene.low, self.scene.high, self.scene.cells
        properties = self.grid.CreateNewProperties(0)
        for j in range(ny + 1):
            for i in range(nx + 1):
                self.grid.CreateNewNode(1 + i + j * (nx + 1), x0 + (x1 - x0) * i / nx, y0 + (y1 - y0) * j / ny, 0.0)
        for j in range(ny):
            for i in range(nx):
                corner = 1 + i + j * (nx + 1)
                nodes = [corner, corner + 1, corner + nx + 2, corner + nx + 1]
                self.grid.CreateNewElement("Element2D4N", 1 + i + j * nx, nodes, properties)

    def _make_body(self) -> None:
        """One square around every material point, so that points are equally spaced."""
        part = self.body.CreateSubModelPart("Parts_body")
        properties = part.CreateNewProperties(1)
        node = self.grid.NumberOfNodes()
        half = (0.5 * self.scene.size[0], 0.5 * self.scene.size[1])
        first_element = self.grid.NumberOfElements()
        for number, (x, y) in enumerate(self.scene.squares, 1):
            corners = []
            for sx, sy in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
                node += 1
                part.CreateNewNode(node, x + sx * half[0], y + sy * half[1], 0.0)
                corners.append(node)
            part.CreateNewElement("MPMUpdatedLagrangian2D4N", first_element + number, corners, properties)
        self.last_node = node

    def _make_forces(self) -> None:
        """Points that carry a force and move with the material; Kratos locates them in the grid."""
        if not self.scene.forces:
            return
        part = self.grid.CreateSubModelPart("forces")
        properties = self.grid.CreateNewProperties(2)
        for number, ((x, y), _) in enumerate(self.scene.forces, 1):
            node = self.last_node + number
            part.CreateNewNode(node, x, y, 0.0)
            condition = part.CreateNewCondition("PointCondition2D1N", number, [node], properties)
            condition.Set(km.BOUNDARY, True)
            condition.Set(km.MARKER, False)
            condition.Set(km.MODIFIED, False)
            condition.SetValue(mpm.MATERIAL_POINTS_PER_CONDITION, 1)
            condition.SetValue(mpm.MPC_IS_NEUMANN, True)
            condition.SetValue(mpm.POINT_LOAD, km.Vector([0.0, 0.0, 0.0]))

    def _read_material(self) -> None:
        """Kratos reads laws from a file."""
        constants = {"THICKNESS": 1.0, "MATERIAL_POINTS_PER_ELEMENT": 1, "DENSITY": self.scene.density,
                     **self.scene.constants}
        table = {"properties": [{
            "model_part_name": "Initial_MPM_Material.Parts_body", "properties_id": 1,
            "Material": {"constitutive_law": {"name": self.scene.law}, "Variables": constants, "Tables": {}}}]}
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "materials.json"
            path.write_text(json.dumps(table))
            km.ReadMaterialsUtility(km.Parameters(json.dumps(
                {"Parameters": {"materials_filename": str(path)}})), self.model)

    def _hold(self) -> None:
        """Reset the displacements of the grid nodes to zero in every step."""
        for node in self.grid.Nodes:
            held = self.scene.held(node.X, node.Y)
            if "x" in held:
                node.Fix(km.DISPLACEMENT_X)
            if "y" in held:
                node.Fix(km.DISPLACEMENT_Y)

    def _load(self, share: float) -> None:
        """Loads at a fraction of the ramp."""
        info = self.points.ProcessInfo
        gravity = km.Vector([share * self.scene.gravity[0], share * self.scene.gravity[1], 0.0])
        for element in self.points.Elements:
            element.SetValuesOnIntegrationPoints(mpm.MP_VOLUME_ACCELERATION, [gravity], info)
        for condition, (_, force) in zip(self.points.Conditions, self.scene.forces):
            value = km.Vector([share * force[0], share * force[1], 0.0])
            condition.SetValuesOnIntegrationPoints(mpm.POINT_LOAD, [value], info)

    def step(self) -> bool:
        """The next step of the ramp; returns whether it converged."""
        self.now = self.solver.AdvanceInTime(getattr(self, "now", 0.0))
        self._load((self.done + 1) / self.scene.steps)
        self.solver.Predict()
        self.solver.InitializeSolutionStep()
        converged = self.solver.SolveSolutionStep()
        self.iterations += self.grid.ProcessInfo[km.NL_ITERATION_NUMBER]
        self.solver.FinalizeSolutionStep()
        self.done += 1
        if not converged:
            self.unconverged.append(self.done)
        return bool(converged)

    def values(self, variable: Any) -> list[Any]:
        """A variable of all material points."""
        info = self.points.ProcessInfo
        return [e.CalculateOnIntegrationPoints(variable, info)[0] for e in self.points.Elements]

    def nearest(self, x: float, y: float) -> int:
        """Index of the material point nearest to an initial position."""
        squares = self.scene.squares
        return min(range(len(squares)), key=lambda i: (squares[i][0] - x) ** 2 + (squares[i][1] - y) ** 2)


def peak_memory() -> int:
    """Peak memory of the process so far [bytes]."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmHWM:"):
            return 1024 * int(line.split()[1])
    return 0


def tell(run: Run, ended: str, **figures: Any) -> None:
    """Print the results of a run as one line of JSON; CPU seconds are those of the whole process."""
    used = time.process_time()
    print(json.dumps({
        "points": len(run.scene.squares), "steps": run.scene.steps, "steps_done": run.done,
        "iterations": run.iterations, "unconverged": len(run.unconverged),
        "first_unconverged": run.unconverged[0] if run.unconverged else None,
        "ended": ended, "cpu_seconds": used, "peak_memory_bytes": peak_memory(), **figures}))
