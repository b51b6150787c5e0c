#!/usr/bin/env python3
"""Factor of safety of the 45 degree slope by the phi-c reduction of Kratos' GeoMechanicsApplication.

    kratos_safety.py [CELLS [DILATANCY]]

Needs `pip install KratosGeoMechanicsApplication`. The slope of verification/cases/decks/slope_safety.inp, 1 m high, c = 1 kPa,
phi = 25, psi = 18 unless given, 15 kN/m3, in 6-node triangles, so many a height (6). Stage 1: elastic weight; stage 2:
ApplyCPhiReductionProcess. The program tells the factor in its log, which is printed.
"""
from __future__ import annotations

import json
import os
import pathlib
import sys
import tempfile

GEO = "KratosMultiphysics.GeoMechanicsApplication"


def mesh(n: int) -> str:
    """Triangles of six nodes in n rows and 3n/2 columns of the trapezoid 0, 0; 2, 0; 1, 1; 0, 1."""
    columns, rows = 2 * (3 * n // 2) + 1, 2 * n + 1
    label = {(i, j): 1 + i + columns * j for j in range(rows) for i in range(columns)}
    nodes = [f"{label[i, j]} {(2 - j / (rows - 1)) * i / (columns - 1)!r} {j / (rows - 1)!r} 0.0" for j in range(rows) for i in range(columns)]
    elements = []
    for j in range(0, rows - 1, 2):
        for i in range(0, columns - 1, 2):
            a = [(0, 0), (2, 0), (2, 2), (1, 0), (2, 1), (1, 1)]
            b = [(0, 0), (2, 2), (0, 2), (1, 1), (1, 2), (0, 1)]
            for corners in (a, b):
                elements.append(" ".join(str(label[i + p, j + q]) for p, q in corners))
    lines = ["Begin Properties 1", "End Properties", "Begin Nodes", *nodes, "End Nodes", "Begin Elements UPwSmallStrainElement2D6N"]
    lines += [f"{k} 1 {text}" for k, text in enumerate(elements, 1)] + ["End Elements"]
    parts = {"Material_1": (label.values(), range(1, len(elements) + 1)),
             "Side_Nodes": ([label[0, j] for j in range(rows)], []),
             "Base_Nodes": ([label[i, 0] for i in range(columns)], []), "All_Nodes": (label.values(), [])}
    for name, (members, cells) in parts.items():
        lines += [f"Begin SubModelPart {name}", "Begin SubModelPartNodes", *map(str, members), "End SubModelPartNodes",
                  "Begin SubModelPartElements", *map(str, cells), "End SubModelPartElements", "End SubModelPart"]
    return "\n".join(lines) + "\n"


def material(law: str, **more: float) -> dict:
    """One material, N and m."""
    variables = {"GEO_DRAINAGE_TYPE": "CONSTANT_PW_FIELD", "DENSITY_SOLID": 15000 / 9.81, "DENSITY_WATER": 0.0, "POROSITY": 0.0,
                 "BULK_MODULUS_SOLID": 1e9, "BULK_MODULUS_FLUID": 2e6, "PERMEABILITY_XX": 4.5e-13, "PERMEABILITY_YY": 4.5e-13,
                 "PERMEABILITY_XY": 0.0, "DYNAMIC_VISCOSITY": 8.9e-7, "BIOT_COEFFICIENT": 1.0, "RETENTION_LAW": "SaturatedLaw",
                 "SATURATED_SATURATION": 1.0, "YOUNG_MODULUS": 1e7, "POISSON_RATIO": 0.33, **more}
    return {"properties": [{"model_part_name": "PorousDomain.Material_1", "properties_id": 1,
                            "Material": {"constitutive_law": {"name": law}, "Variables": variables}}]}


def process(name: str, module: str, **parameters: object) -> dict:
    return {"process_name": name, "kratos_module": GEO, "python_module": module, "Parameters": parameters}


def stage(number: int) -> dict:
    """Settings of a stage, as those of the program's own test of the process."""
    first = number == 1
    vector = ("ApplyVectorConstraintTableProcess", "apply_vector_constraint_table_process")
    fixed = [process(*vector, model_part_name=f"PorousDomain.{part}", variable_name="DISPLACEMENT", active=[True, both, False],
                     is_fixed=[True, both, False], value=[0.0, 0.0, 0.0], table=[0, 0, 0]) for part, both in (("Side_Nodes", False), ("Base_Nodes", True))]
    fixed.append(process("ApplyScalarConstraintTableProcess", "apply_scalar_constraint_table_process", model_part_name="PorousDomain.All_Nodes",
                         variable_name="WATER_PRESSURE", fluid_pressure_type="Phreatic_Line", gravity_direction=1, is_fixed=True,
                         out_of_plane_direction=2, first_reference_coordinate=[0.0, -10.0, 0.0], second_reference_coordinate=[4.0, -10.0, 0.0],
                         specific_weight=1e4, table=[0, 0], value=0.0))
    if not first:
        fixed.append(process("ApplyCPhiReductionProcess", "apply_c_phi_reduction_process", model_part_name="PorousDomain.Material_1"))
    weight = process(*vector, model_part_name="PorousDomain.Material_1", variable_name="VOLUME_ACCELERATION", active=[False, True, False],
                     value=[0.0, -9.81, 0.0], table=[0, 0, 0])
    solver = {"solver_type": "U_Pw", "model_part_name": "PorousDomain", "domain_size": 2, "buffer_size": 2, "echo_level": 1,
              "model_import_settings": {"input_type": "mdpa", "input_filename": "mesh"} if first else {"input_type": "use_input_model_part"},
              "material_import_settings": {"materials_filename": f"material{number}.json"},
              "time_stepping": {"time_step": 1.0 if first else 0.1, "max_delta_time_factor": 1}, "clear_storage": False, "compute_reactions": False,
              "move_mesh_flag": False, "reform_dofs_at_each_step": False, "block_builder": True, "solution_type": "Quasi-Static",
              "scheme_type": "Backward_Euler", "reset_displacements": True, "strategy_type": "newton_raphson" if first else "line_search",
              "convergence_criterion": "residual_criterion", "residual_relative_tolerance": 1e-4, "residual_absolute_tolerance": 1e-4,
              "min_iterations": 3, "max_iterations": 150, "number_cycles": 20, "reduction_factor": 0.5, "increase_factor": 1.0,
              "max_line_search_iterations": 5, "first_alpha_value": 0.5, "second_alpha_value": 1.0, "min_alpha": 0.1, "max_alpha": 2.0,
              "line_search_tolerance": 0.5, "rotation_dofs": False,
              "linear_solver_settings": {"solver_type": "LinearSolversApplication.sparse_lu", "scaling": True},
              "body_domain_sub_model_part_list": ["Material_1"], "problem_domain_sub_model_part_list": ["Material_1"]}
    return {"problem_data": {"problem_name": f"stage{number}", "start_time": -1.0 if first else 0.0, "end_time": 0.0 if first else 2.0,
                             "echo_level": 1, "parallel_type": "OpenMP", "number_of_threads": 1},
            "solver_settings": solver, "processes": {"constraints_process_list": fixed, "loads_process_list": [weight]}, "output_processes": {}}


def main() -> None:
    """Run the two stages."""
    import KratosMultiphysics as kratos
    from KratosMultiphysics.GeoMechanicsApplication import geomechanics_analysis

    cells = int(sys.argv[1]) if len(sys.argv) > 1 else 6
    dilatancy = float(sys.argv[2]) if len(sys.argv) > 2 else 18.0
    with tempfile.TemporaryDirectory() as name:
        os.chdir(name)
        pathlib.Path("mesh.mdpa").write_text(mesh(cells))
        sharp = material("GeoMohrCoulombLawPlaneStrain", GEO_COHESION=1000.0, GEO_FRICTION_ANGLE=25.0, GEO_DILATANCY_ANGLE=dilatancy,
                         GEO_ENABLE_TENSION_CUT_OFF=False, GEO_TENSILE_STRENGTH=0.0)
        pathlib.Path("material1.json").write_text(json.dumps(material("GeoLinearElasticPlaneStrain2DLaw")))
        pathlib.Path("material2.json").write_text(json.dumps(sharp))
        model = kratos.Model()
        for number in (1, 2):
            settings = kratos.Parameters(json.dumps(stage(number)))
            geomechanics_analysis.GeoMechanicsAnalysis(model, settings).Run()


if __name__ == "__main__":
    main()
