#!/usr/bin/env python3
"""Heave of an elastic column from whose top a part is dug, by Kratos' GeoMechanicsApplication, beside QSMPM and the closed form.

    kratos_excavation.py [--program FILE]

Needs `pip install KratosGeoMechanicsApplication`. The column of verification/cases/decks/stages_column.inp: 10 m high, the upper
4 m dug out, 20 kN/m3, in 6-node triangles of 1 m. Stage 1: elastic weight; stage 2: ApplyExcavationProcess.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

TOP = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(Path(__file__).resolve().parent))

import kratos_safety  # noqa: E402

HEIGHT, DUG, WEIGHT, YOUNG, POISSON = 10, 4, 20e3, 1e10, 0.25
MODULUS = YOUNG * (1 - POISSON) / ((1 + POISSON) * (1 - 2 * POISSON))
CUT = HEIGHT - DUG


def mesh() -> str:
    """Two triangles of six nodes a metre."""
    rows = 2 * HEIGHT + 1
    label = {(i, j): 1 + i + 3 * j for j in range(rows) for i in range(3)}
    corners = [(0, 0), (2, 0), (2, 2), (1, 0), (2, 1), (1, 1)], [(0, 0), (2, 2), (0, 2), (1, 1), (1, 2), (0, 1)]
    cells = [[label[i, j + k] for i, k in one] for j in range(0, rows - 1, 2) for one in corners]
    lines = ["Begin Properties 1", "End Properties", "Begin Nodes", *(f"{k} {i / 2} {j / 2} 0.0" for (i, j), k in label.items()), "End Nodes",
             "Begin Elements UPwSmallStrainElement2D6N", *(f"{k} 1 " + " ".join(map(str, cell)) for k, cell in enumerate(cells, 1)), "End Elements"]  # fmt: skip
    every = list(label.values())
    parts = {"Material_1": (every, range(1, len(cells) + 1)), "Side_Nodes": ([label[i, j] for j in range(rows) for i in (0, 2)], []),
             "Base_Nodes": ([1, 2, 3], []), "All_Nodes": (every, []),
             "Pit": ([k for (_, j), k in label.items() if j >= 2 * CUT], range(2 * CUT + 1, len(cells) + 1))}  # fmt: skip
    for name, (nodes, elements) in parts.items():
        lines += [f"Begin SubModelPart {name}", "Begin SubModelPartNodes", *map(str, nodes), "End SubModelPartNodes",
                  "Begin SubModelPartElements", *map(str, elements), "End SubModelPartElements", "End SubModelPart"]  # fmt: skip
    return "\n".join(lines) + "\n"


def stage(number: int) -> dict:
    """That of the slope, without its reduction of strength."""
    settings = kratos_safety.stage(number)
    fixed = settings["processes"]["constraints_process_list"]
    if number == 2:
        fixed[-1] = kratos_safety.process("ApplyExcavationProcess", "apply_excavation_process", model_part_name="PorousDomain.Pit",
                                          deactivate_soil_part=True)  # fmt: skip
        settings["problem_data"]["end_time"] = 1.0
        settings["solver_settings"]["time_stepping"]["time_step"] = 1.0
        settings["solver_settings"]["strategy_type"] = "newton_raphson"
    settings["solver_settings"]["residual_relative_tolerance"] = 1e-9
    return settings


def by_kratos(folder: Path) -> float:
    """Rise of the cut in stage 2."""
    import KratosMultiphysics as kratos
    from KratosMultiphysics.GeoMechanicsApplication import geomechanics_analysis

    os.chdir(folder)
    Path("mesh.mdpa").write_text(mesh())
    law = kratos_safety.material("GeoLinearElasticPlaneStrain2DLaw", YOUNG_MODULUS=YOUNG, POISSON_RATIO=POISSON, DENSITY_SOLID=WEIGHT / 9.81)
    model = kratos.Model()
    for number in (1, 2):
        Path(f"material{number}.json").write_text(json.dumps(law))
        geomechanics_analysis.GeoMechanicsAnalysis(model, kratos.Parameters(json.dumps(stage(number)))).Run()
    node = model["PorousDomain"].Nodes[1 + 1 + 3 * 2 * CUT]
    return float(node.GetSolutionStepValue(kratos.DISPLACEMENT_Y))


def by_qsmpm(program: Path, folder: Path) -> float:
    """Rise of the cut at the end of the excavation, the second phase."""
    deck = TOP / "verification" / "cases" / "decks" / "stages_column.inp"
    subprocess.run([program, "run", deck, "--quiet", "--out", folder / "out"], check=True, timeout=120)
    with (folder / "out" / "curves.csv").open() as file:
        return [float(row["cut [m]"]) for row in csv.DictReader(file) if row["phase"] == "2"][-1]


def main() -> None:
    """The three side by side."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=Path, default=TOP / "build" / "qsmpm")
    program = parser.parse_args().program.resolve()
    with tempfile.TemporaryDirectory() as name:
        own = by_qsmpm(program, Path(name))
        print(f"QSMPM {own:.6e}, closed form {WEIGHT * DUG * CUT / MODULUS:.6e}", flush=True)
        print(f"Kratos {by_kratos(Path(name)):.6e}")


if __name__ == "__main__":
    main()
