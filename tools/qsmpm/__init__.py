"""QSMPM from Python: run decks, step them, look at the material points, change loads from results.

    import qsmpm

    with qsmpm.Simulation("input/oedometer.inp") as run:
        while not run.finished:
            run.advance()
            print(run.load_factor, run.histories)

The shared library is found by the variable QSMPM_LIBRARY, beside the package, in the prefix of this Python, by the
system, or in the build folder of the source tree. docs/embedding.md says more.
"""

from .errors import (
    DeckError,
    Error,
    LeftMeshError,
    NotConvergedError,
    SingularError,
    StoppedError,
    UserMaterialError,
)
from .library import api_version, has, library_path, version
from .materials import Increment, SoilModel, Update
from .pictures import to_pyvista
from .points import Points
from .simulation import PhaseResult, Simulation

__all__ = [
    "DeckError", "Error", "Increment", "LeftMeshError", "NotConvergedError", "PhaseResult", "Points", "Simulation", "SingularError",
    "SoilModel", "StoppedError", "Update", "UserMaterialError", "__version__", "api_version", "has", "library_path",
    "to_pyvista", "version",
]


def __getattr__(name: str) -> str:
    """`__version__`, that of the library, which is only loaded when it is asked for."""
    if name == "__version__":
        return version().split()[1]
    raise AttributeError(f"module 'qsmpm' has no attribute {name!r}")
