"""The shared library: where it is, and the types of its functions (src/api/include/qsmpm.h)."""
from __future__ import annotations

import ctypes
import ctypes.util
import functools
import os
import pathlib
import sys
from ctypes import CFUNCTYPE, POINTER, Structure, c_char, c_char_p, c_double, c_int, c_void_p

NAME = "libqsmpm.so"
API_VERSION = 201


class ModelOptions(Structure):
    """qsmpm_model_options."""

    _fields_ = [(n, c_int) for n in ("state_count", "symmetric", "thread_safe", "reads_strain", "reads_gradient")] + [
        ("stiffness_scale", c_double), ("shear_scale", c_double)]


class CIncrement(Structure):
    """qsmpm_increment."""

    _fields_ = [("strain", c_double * 6), ("strain_start", c_double * 6), ("rotation", c_double * 9),
                ("gradient_start", c_double * 9), ("gradient_end", c_double * 9), ("phase", c_int), ("step", c_int),
                ("start", c_double), ("duration", c_double), ("point", c_int), ("cell", c_int),
                ("place", c_double * 3), ("cell_size", c_double), ("wants_tangent", c_int),
                ("elastic_tangent", c_int), ("time", c_double), ("time_increment", c_double)]


class CAnswer(Structure):
    """qsmpm_response."""

    _fields_ = [("plastic", c_int), ("share", c_double), ("tangent", c_double * 36), ("message", c_char * 256)]


LOGGER = CFUNCTYPE(None, c_void_p, c_char_p)
START = CFUNCTYPE(None, c_void_p, POINTER(c_double), POINTER(c_double))
UPDATE = CFUNCTYPE(c_int, c_void_p, POINTER(CIncrement), POINTER(c_double), POINTER(c_double), POINTER(CAnswer))

_H, _T, _V, _I, _D = c_void_p, c_char_p, POINTER(c_double), c_int, c_double
_PI = POINTER(c_int)
SIGNATURES: dict[str, list[object]] = {
    "api_version": [], "version": [_T, _I], "has": [_T], "create": [POINTER(_H)], "destroy": [POINTER(_H)],
    "error": [_H, _T, _I], "messages": [_H, _T, _I], "set_logger": [_H, LOGGER, c_void_p],
    "set_verbosity": [_H, _I], "set_threads": [_H, _I], "read_deck": [_H, _T], "parse_deck": [_H, _T, _T],
    "set_material": [_H, _T, POINTER(ModelOptions), START, UPDATE, c_void_p], "initialise": [_H], "advance": [_H],
    "advance_to": [_H, _D], "run": [_H], "finished": [_H], "record": [_H, _T], "finish_record": [_H],
    "save": [_H, _T], "load": [_H, _T], "checkpoint": [_H], "restore_checkpoint": [_H], "add_stage": [_H, _T, _I],
    "add_cards": [_H, _T], "end_stage": [_H],
    "set_load_factor": [_H, _D], "set_steps": [_H, _I], "set_time": [_H, _D], "set_start_time": [_H, _D],
    "set_gravity": [_H, _V], "set_traction": [_H, _T, _V],
    "set_pressure": [_H, _T, _D], "set_water_level": [_H, _T, _D], "set_displacement": [_H, _T, _I, _D],
    "set_fixity": [_H, _T, _PI],
    "shape": [_H, _T, _PI, _PI], "count": [_H, _T, _PI], "get": [_H, _T, _V, _I], "set": [_H, _T, _V, _I],
    "view": [_H, _T, POINTER(_V), _PI, _PI], "name": [_H, _T, _I, _T, _I],
}


def candidates() -> list[str]:
    """Where the library may be, the first that exists is taken."""
    given = os.environ.get("QSMPM_LIBRARY")
    if given:
        path = pathlib.Path(given)
        return [str(path / NAME if path.is_dir() else path)]
    here = pathlib.Path(__file__).resolve()
    places = [here.parent / NAME, *(pathlib.Path(sys.prefix) / lib / NAME for lib in ("lib", "lib64")),
              *(p / "lib" / NAME for p in here.parents[1:5]), here.parents[2] / "build" / NAME]
    found = [str(p) for p in places if p.is_file()]
    system = ctypes.util.find_library("qsmpm")
    return found + ([system] if system else [])


@functools.cache
def load() -> ctypes.CDLL:
    """The library with the types of its functions."""
    paths = candidates()
    if not paths:
        raise ImportError(f"{NAME} is not found: build it (cmake --build --preset release) or name it in QSMPM_LIBRARY")
    try:
        library = ctypes.CDLL(paths[0])
    except OSError as fault:
        raise ImportError(f"cannot load the library of QSMPM: {fault}") from fault
    for name, arguments in SIGNATURES.items():
        function = getattr(library, "qsmpm_" + name)
        function.argtypes = arguments
        function.restype = c_int
    theirs = library.qsmpm_api_version()
    if theirs // 100 != API_VERSION // 100:
        raise ImportError(f"{paths[0]} has version {theirs} of the interface, this package is for {API_VERSION}")
    return library


def library_path() -> str:
    """Path of the library in use."""
    return str(load()._name)


def text_of(function: object, *arguments: object) -> str:
    """Text that a function puts into a buffer behind its other arguments."""
    length = function(*arguments, None, 0)  # type: ignore[operator]
    if length < 0:
        raise IndexError("there is none of that number")
    buffer = ctypes.create_string_buffer(length + 1)
    function(*arguments, buffer, length + 1)  # type: ignore[operator]
    return buffer.value.decode()


def version() -> str:
    """Name, version and make of the library."""
    return text_of(load().qsmpm_version)


def api_version() -> int:
    """Version of the interface to C: 10000 major + 100 minor + patch."""
    return int(load().qsmpm_api_version())


def has(feature: str) -> bool:
    """Whether `suitesparse`, `openmp`, ... is in the library."""
    return bool(load().qsmpm_has(feature.encode()))
