#!/usr/bin/env python3
"""An elastic plane-strain scene by finite elements in the structural application of Kratos Multiphysics.

    kratos_fem.py MODEL.json RESULT.json

MODEL.json contains nodes, cells, constrained directions, nodal loads, weight, constants, the names of element and law, and the
number of load steps. RESULT.json contains displacements and the sum of the reactions. A step that does
not converge ends the run.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import KratosMultiphysics as km
import KratosMultiphysics.LinearSolversApplication  # noqa: F401  registers sparse_lu
import KratosMultiphysics.StructuralMechanicsApplication as sma
from KratosMultiphysics import python_linear_solver_factory


def make(part: km.ModelPart, scene: dict[str, Any]) -> None:
    """Nodes, elements, law, constraints."""
    for variable in (km.DISPLACEMENT, km.REACTION, km.VOLUME_ACCELERATION, sma.POINT_LOAD):
        part.AddNodalSolutionStepVariable(variable)
    part.ProcessInfo[km.DOMAIN_SIZE] = 2
    properties = part.CreateNewProperties(1)
    properties[km.YOUNG_MODULUS], properties[km.POISSON_RATIO] = scene["young"], scene["poisson"]
    properties[km.DENSITY], properties[km.THICKNESS] = 1.0, 1.0
    properties.SetValue(km.CONSTITUTIVE_LAW, km.KratosGlobals.GetConstitutiveLaw(scene["law"]).Clone())
    for number, (x, y) in enumerate(scene["nodes"], 1):
        part.CreateNewNode(number, x, y, 0.0)
    for number, cell in enumerate(scene["cells"], 1):
        part.CreateNewElement(scene["element"], number, [node + 1 for node in cell], properties)
    for number, (node, x, y) in enumerate(scene["forces"], 1):
        part.CreateNewCondition("PointLoadCondition2D1N", number, [node + 1], properties)
    for axis in "XY":
        degree = km.KratosGlobals.GetVariable(f"DISPLACEMENT_{axis}")
        km.VariableUtils().AddDof(degree, km.KratosGlobals.GetVariable(f"REACTION_{axis}"), part)
    for node, axis in scene["held"]:
        part.Nodes[node + 1].Fix((km.DISPLACEMENT_X, km.DISPLACEMENT_Y)[axis])


def load(part: km.ModelPart, scene: dict[str, Any], share: float) -> None:
    """Loads at a fraction of the ramp."""
    weight = km.Vector([share * scene["weight"][0], share * scene["weight"][1], 0.0])
    for node in part.Nodes:
        node.SetSolutionStepValue(km.VOLUME_ACCELERATION, weight)
    for number, x, y in scene["forces"]:
        part.Nodes[number + 1].SetSolutionStepValue(sma.POINT_LOAD, km.Vector([share * x, share * y, 0.0]))


def strategy_of(part: km.ModelPart) -> Any:
    """Newton's method with a direct solver, corrections down to 1e-8 of the displacement of the step."""
    solver = python_linear_solver_factory.ConstructSolver(
        km.Parameters('{"solver_type": "LinearSolversApplication.sparse_lu"}'))
    criterion = km.DisplacementCriteria(1e-8, 1e-14)
    criterion.SetEchoLevel(0)
    builder = km.ResidualBasedBlockBuilderAndSolver(solver)
    strategy = km.ResidualBasedNewtonRaphsonStrategy(
        part, km.ResidualBasedIncrementalUpdateStaticScheme(), criterion, builder, 40, True, False, True)
    strategy.SetEchoLevel(0)
    strategy.Initialize()
    return strategy


def main() -> None:
    """Read, ramp, write."""
    km.Logger.GetDefaultOutput().SetSeverity(km.Logger.Severity.WARNING)
    km.ParallelUtilities.SetNumThreads(1)
    scene = json.loads(Path(sys.argv[1]).read_text())
    model = km.Model()
    part = model.CreateModelPart("body", 2)
    make(part, scene)
    strategy = strategy_of(part)
    for step in range(1, scene["steps"] + 1):
        part.ProcessInfo[km.STEP] = step
        part.CloneTimeStep(step / scene["steps"])
        load(part, scene, step / scene["steps"])
        strategy.InitializeSolutionStep()
        strategy.Predict()
        if not strategy.SolveSolutionStep():
            sys.exit(f"step {step} of {scene['steps']} did not converge")
        strategy.FinalizeSolutionStep()
    moved = [list(node.GetSolutionStepValue(km.DISPLACEMENT))[:2] for node in part.Nodes]
    force = [sum(node.GetSolutionStepValue(km.REACTION)[axis] for node in part.Nodes) for axis in (0, 1)]
    Path(sys.argv[2]).write_text(json.dumps({"displacement": moved, "reaction": force}))


if __name__ == "__main__":
    main()
