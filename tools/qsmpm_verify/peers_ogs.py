"""OpenGeoSys: small deformation and hydro-mechanics (Taylor-Hood) on the mesh of a model.

A project file and meshes are written, the program of the package `ogs` in .venv-peers is run as a process of its own, and its
last result file is read. Constrained and loaded nodes are meshes of single nodes with their numbers in the
whole mesh. Loads increase linearly with time; in OpenGeoSys pressure is positive in compression, as here.
"""

from __future__ import annotations

import re
import subprocess
from functools import lru_cache
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from qsmpm_verify.peers_kratos import PYTHON
from qsmpm_verify.peers_model import Model, Solution
from qsmpm_verify.peers_runs import Finished, run_peer
from qsmpm_verify.results import Array
from qsmpm_verify.trouble import RunFailed, Trouble

PROGRAM = PYTHON.parent / "ogs"
ORDERS = {5: 1, 9: 2, 22: 2, 23: 3}
"""Integration order by VTK type: 1, 4, 3 and 9 points."""

QUADRATIC = (22, 23)


@lru_cache(maxsize=1)
def version() -> str:
    """`OpenGeoSys 6.5.9`; empty when it is not installed."""
    try:
        answer = subprocess.run([str(PROGRAM), "--version"], capture_output=True, text=True, timeout=60, check=True).stdout
    except (OSError, subprocess.SubprocessError):
        return ""
    hit = re.search(r"version:\s+(\S+)", answer)
    return f"OpenGeoSys {hit[1]}" if hit else ""


def _data(name: str, values: Array, kind: str = "Float64") -> str:
    """A table of a .vtu file, with sufficient digits to reproduce the numbers."""
    columns = f' NumberOfComponents="{values.shape[1]}"' if values.ndim == 2 else ""
    numbers = " ".join(str(value) for value in values.ravel().tolist())
    return f'<DataArray type="{kind}" Name="{name}"{columns} format="ascii">{numbers}</DataArray>'


def mesh_text(nodes: Array, cells: Array, vtk_type: int, fields: str = "") -> str:
    """A mesh in the format of OpenGeoSys; `fields` are tables of its nodes."""
    count, each = cells.shape
    places = np.column_stack([nodes, np.zeros(len(nodes))])
    return (
        '<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian"><UnstructuredGrid>\n'
        f'<Piece NumberOfPoints="{len(nodes)}" NumberOfCells="{count}">\n<PointData>{fields}</PointData>\n'
        f"<Points>{_data('Points', places)}</Points>\n<Cells>{_data('connectivity', cells.ravel(), 'Int64')}\n"
        f"{_data('offsets', each * np.arange(1, count + 1), 'Int64')}\n{_data('types', np.full(count, vtk_type), 'UInt8')}</Cells>\n"
        "</Piece></UnstructuredGrid></VTKFile>\n"
    )


def set_text(model: Model, chosen: Array) -> str:
    """Nodes of a model as a mesh of points, with their loads."""
    numbers = _data("bulk_node_ids", chosen, "UInt64")
    loads = "".join(_data(f"load_{axis}", model.forces[chosen, i]) for i, axis in enumerate("xy"))
    return mesh_text(model.nodes[chosen], np.arange(len(chosen))[:, None], 1, numbers + loads)


def _property(name: str, value: float) -> str:
    return f"<property><name>{name}</name><type>Constant</type><value>{value!r}</value></property>"


def _medium(model: Model) -> str:
    solid = _property("density", 1.0)
    if model.flow is None:
        return f"<phases><phase><type>Solid</type><properties>{solid}</properties></phase></phases>"
    water = _property("viscosity", 1.0) + _property("density", 1e-9)
    pores = _property("porosity", 0.5) + _property("biot_coefficient", 1.0) + _property("reference_temperature", 293.15)
    return (
        f"<phases><phase><type>AqueousLiquid</type><properties>{water}</properties></phase>"
        f"<phase><type>Solid</type><properties>{solid}</properties></phase></phases>"
        f"<properties>{pores}{_property('permeability', model.flow.mobility)}</properties>"
    )


def _at(mesh: str, axis: int, kind: str, parameter: str) -> str:
    return f"<mesh>{mesh}</mesh><type>{kind}</type><component>{axis}</component><parameter>{parameter}</parameter>"


def _variable(name: str, components: int, order: int, held: str, loads: str = "") -> str:
    return (
        f"<process_variable><name>{name}</name><components>{components}</components><order>{order}</order>"
        f"<initial_condition>zero_{components}</initial_condition><boundary_conditions>{held}</boundary_conditions>"
        f"<source_terms>{loads}</source_terms></process_variable>"
    )


def _parameters(model: Model, loaded: bool) -> str:
    constants = {"young": model.young, "poisson": model.poisson, "zero_1": 0.0}
    return "".join(
        [f"<parameter><name>{name}</name><type>Constant</type><value>{value!r}</value></parameter>" for name, value in constants.items()]
        + ["<parameter><name>zero_2</name><type>Constant</type><values>0 0</values></parameter>"]
        + [
            f"<parameter><name>all_{axis}</name><type>MeshNode</type><mesh>loaded</mesh><field_name>load_{axis}</field_name></parameter>"
            f"<parameter><name>now_{axis}</name><type>CurveScaled</type><curve>ramp</curve><parameter>all_{axis}</parameter></parameter>"
            for axis in ("xy" if loaded else "")
        ]
    )


def project_text(model: Model, sets: list[str]) -> str:
    """The project; `sets` names the meshes of nodes in addition to the whole mesh."""
    flow = model.flow
    duration, steps = (flow.duration, flow.steps) if flow else (1.0, 1)
    held = "".join(f"<boundary_condition>{_at(f'held_{axis}', i, 'Dirichlet', 'zero_1')}</boundary_condition>" for i, axis in enumerate("xy"))
    loads = "".join(f"<source_term>{_at('loaded', i, 'Nodal', f'now_{axis}')}</source_term>" for i, axis in enumerate("xy") if "loaded" in sets)
    variables = _variable("displacement", 2, 2 if model.vtk_type in QUADRATIC else 1, held, loads)
    names = "<process_variable>displacement</process_variable>"
    if flow:
        names = "<displacement>displacement</displacement><pressure>pressure</pressure>"
        variables += _variable("pressure", 1, 1, f"<boundary_condition>{_at('open', 0, 'Dirichlet', 'zero_1')}</boundary_condition>")
    text = f"""<OpenGeoSysProject>
<meshes>{"".join(f"<mesh>{name}.vtu</mesh>" for name in ["whole", *sets])}</meshes>
<processes><process><name>P</name><type>{"HYDRO_MECHANICS" if flow else "SMALL_DEFORMATION"}</type>
<integration_order>{ORDERS[model.vtk_type]}</integration_order>
<constitutive_relation><type>LinearElasticIsotropic</type><youngs_modulus>young</youngs_modulus><poissons_ratio>poisson</poissons_ratio></constitutive_relation>
<process_variables>{names}</process_variables><secondary_variables/>
<specific_body_force>{model.weight[0]!r} {model.weight[1]!r}</specific_body_force></process></processes>
<media><medium id="0">{_medium(model)}</medium></media>
<time_loop><processes><process ref="P"><nonlinear_solver>newton</nonlinear_solver>
<convergence_criterion><type>DeltaX</type><norm_type>INFINITY_N</norm_type><reltol>1e-9</reltol></convergence_criterion>
<time_discretization><type>BackwardEuler</type></time_discretization>
<time_stepping><type>FixedTimeStepping</type><t_initial>0</t_initial><t_end>{duration!r}</t_end>
<timesteps><pair><repeat>{steps}</repeat><delta_t>{duration / steps!r}</delta_t></pair></timesteps></time_stepping></process></processes>
<output><type>VTK</type><prefix>at</prefix><suffix>_{{:timestep}}</suffix><data_mode>Ascii</data_mode>
<timesteps><pair><repeat>1</repeat><each_steps>{steps}</each_steps></pair></timesteps>
<variables/></output></time_loop>
<parameters>{_parameters(model, "loaded" in sets)}</parameters>
<curves><curve><name>ramp</name><coords>0 {duration!r}</coords><values>0 1</values></curve></curves>
<process_variables>{variables}</process_variables>
<nonlinear_solvers><nonlinear_solver><name>newton</name><type>Newton</type><max_iter>5</max_iter>
<linear_solver>direct</linear_solver></nonlinear_solver></nonlinear_solvers>
<linear_solvers><linear_solver><name>direct</name><eigen><solver_type>SparseLU</solver_type><scaling>true</scaling></eigen></linear_solver></linear_solvers>
</OpenGeoSysProject>
"""
    ElementTree.fromstring(text)
    return text


def files_of(model: Model) -> dict[str, str]:
    """All files of a run by name."""
    if model.flow and model.vtk_type not in QUADRATIC:
        raise Trouble("OpenGeoSys: groundwater flow requires quadratic cells")
    chosen = {f"held_{axis}": np.array([node for node, held in model.held if held == i]) for i, axis in enumerate("xy")}
    chosen["loaded"] = np.flatnonzero(np.abs(model.forces).sum(axis=1))
    if model.flow:
        chosen["open"] = model.flow.open
    sets = {name: set_text(model, numbers) for name, numbers in chosen.items() if len(numbers)}
    meshes = {"whole": mesh_text(model.nodes, model.cells, model.vtk_type), **sets}
    return {"model.prj": project_text(model, list(sets)), **{f"{name}.vtu": text for name, text in meshes.items()}}


def read_fields(text: str) -> dict[str, Array]:
    """Tables of the nodes in a .vtu result file in ASCII format."""
    found = {}
    for data in ElementTree.fromstring(text).iterfind(".//PointData/DataArray"):
        values = np.array([float(word) for word in (data.text or "").split()])
        found[data.get("Name", "")] = values.reshape(-1, int(data.get("NumberOfComponents") or 1))
    return found


def solution_of(model: Model, text: str) -> Solution:
    """Results of a .vtu file at the nodes of a model; nodal forces are reactions of the supports and loads at constrained nodes."""
    fields = read_fields(text)
    if len(fields.get("displacement", ())) != len(model.nodes):
        raise RunFailed("OpenGeoSys wrote no displacements at the nodes of the model")
    held = sorted({node for node, _ in model.held})
    reaction = (fields["NodalForces"] - model.forces)[held].sum(axis=0)
    return Solution(fields["displacement"], reaction, fields["pressure"][:, 0] if model.flow else None)


def solve(model: Model, folder: Path, fresh: bool = False) -> tuple[Solution, Finished]:
    """Run OpenGeoSys on a model."""
    last = f"at_{model.flow.steps if model.flow else 1}.vtu"
    run = run_peer([str(PROGRAM), "model.prj"], version(), files_of(model), [last], folder, fresh=fresh)
    return solution_of(model, (folder / last).read_text(encoding="utf-8")), run
