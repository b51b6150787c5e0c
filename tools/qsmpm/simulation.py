"""One analysis: made from a deck, stepped, loaded, looked at."""
from __future__ import annotations

import ctypes
import math
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from ctypes import POINTER, c_double, c_int, c_void_p
from dataclasses import dataclass

import numpy as np

from .errors import CLASSES, DeckError, Error, UserMaterialError
from .library import LOGGER, load, text_of
from .materials import SoilModel
from .points import Points


class _Handle:
    """The handle of the library; given back when nobody refers to it any more."""

    def __init__(self) -> None:
        self.library = load()
        self.pointer = c_void_p()
        self.callbacks: list[object] = []
        if self.library.qsmpm_create(ctypes.byref(self.pointer)):
            raise MemoryError("no handle for an analysis")

    def __del__(self) -> None:
        if getattr(self, "pointer", None):
            self.library.qsmpm_destroy(ctypes.byref(self.pointer))


@dataclass(frozen=True)
class PhaseResult:
    """How a phase has ended."""

    name: str
    """Its name."""
    ended_by: str
    """"not ended", "whole load", "limit load", "stop" or "lost"."""
    share: float
    """Load fraction at its end."""
    displacement: float
    """Largest displacement of a material point at its end."""
    factor_of_safety: tuple[float, float] | None
    """Factors that are stable and lost, where the phase has looked for them; infinity where none is lost: at least the stable one."""


class Simulation:
    """An analysis. Use it as a context manager, or close it, so that the files it writes are closed.

    `deck` is a path; `Simulation.from_text` takes a deck as text. `materials` gives materials of the deck models
    written in Python, `logger` hears the library's sentences and, with `verbosity` 2, a line for every step.
    """

    def __init__(self, deck: str | os.PathLike[str] | None = None, *, text: str | None = None, name: str = "analysis",
                 materials: Mapping[str, SoilModel] | None = None, logger: Callable[[str], None] | None = None,
                 verbosity: int = 1, threads: int = 1) -> None:
        if (deck is None) == (text is None):
            raise ValueError("give a deck or the text of one")
        self._closed = False
        self._handle = _Handle()
        self._models: dict[str, SoilModel] = {}
        if logger is not None:
            heard = LOGGER(lambda _user, line: logger(line.decode(errors="replace")))
            self._handle.callbacks.append(heard)
            self._call("set_logger", heard, None)
        self._call("set_verbosity", verbosity)
        self._call("set_threads", threads)
        if deck is not None:
            self._call("read_deck", os.fspath(deck).encode())
        else:
            self._call("parse_deck", str(text).encode(), name.encode())
        for material, model in (materials or {}).items():
            start, update = model.callbacks()
            self._handle.callbacks += [start, update, model]
            self._models[material] = model
            self._call("set_material", material.encode(), ctypes.byref(model.options()), start, update, None)
        self._call("initialise")

    @classmethod
    def from_text(cls, text: str, name: str = "analysis", **options: object) -> Simulation:
        """An analysis from the text of a deck."""
        return cls(text=text, name=name, **options)  # type: ignore[arg-type]

    # ---- calls ----

    def _open_handle(self) -> _Handle:
        if self._closed:
            raise Error("the analysis is closed")
        return self._handle

    def _call(self, name: str, *arguments: object) -> None:
        """Call a function of the library; a status is raised."""
        pointer, library = self._open_handle().pointer, self._open_handle().library
        status = getattr(library, "qsmpm_" + name)(pointer, *arguments)
        message = text_of(library.qsmpm_error, pointer) if status else ""
        for material, model in self._models.items():
            fault, model.fault = model.fault, None
            if fault is not None:
                report = f"material '{material}': {type(fault).__name__}: {fault}"
                if message and str(fault) not in message:
                    report = f"{message} ({report})"
                elif message:
                    report = message
                raise CLASSES.get(status or UserMaterialError.code, Error)(report, status or UserMaterialError.code) from fault
        if status == 0:
            return
        if status == DeckError.code:
            raise DeckError(message, status, self.messages if name in ("read_deck", "parse_deck") else "")
        raise CLASSES.get(status, Error)(message, status)

    def __enter__(self) -> Simulation:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the files that are written; memory is given back when the last array is gone."""
        if self._closed:
            return
        try:
            self._call("finish_record")
        finally:
            self._closed = True
            del self._handle

    @property
    def messages(self) -> str:
        """What the reader of the deck had to say, one sentence a line."""
        return text_of(self._open_handle().library.qsmpm_messages, self._handle.pointer)

    # ---- stepping ----

    def advance(self) -> None:
        """One accepted load step."""
        self._call("advance")

    def advance_to(self, share: float) -> None:
        """Step to a share of the present stage, or of the coming one between stages."""
        self._call("advance_to", share)

    def run(self) -> None:
        """Step to the end of the last stage."""
        self._call("run")

    def steps(self) -> Iterator[int]:
        """Advance step by step: `for number in run.steps(): ...`."""
        while not self.finished:
            self.advance()
            yield self.step

    @property
    def finished(self) -> bool:
        """Whether the last stage has ended."""
        return bool(self._handle.library.qsmpm_finished(self._handle.pointer)) if not self._closed else True

    def record(self, directory: str | os.PathLike[str]) -> None:
        """From now on write what a run of the command line writes."""
        self._call("record", os.fspath(directory).encode())

    def finish_record(self) -> None:
        """Close what is written."""
        self._call("finish_record")

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the whole state to a file."""
        self._call("save", os.fspath(path).encode())

    def load(self, path: str | os.PathLike[str]) -> None:
        """Read a state back that was saved with the same deck and stages."""
        self._call("load", os.fspath(path).encode())

    def checkpoint(self) -> None:
        """Copy state, loads and stages, in memory."""
        self._call("checkpoint")

    def restore_checkpoint(self) -> None:
        """Put the copy back."""
        self._call("restore_checkpoint")

    # ---- loads of the coming stage ----

    def add_stage(self, name: str, steps: int = 1) -> None:
        """Add a stage behind the last one; loads and fixities stay until they are changed."""
        self._call("add_stage", name.encode(), steps)

    def add_cards(self, cards: str) -> None:
        """Add materials and phases to the scene, as lines of its deck: *MATERIAL, *PHASE and what belongs to them."""
        self._call("add_cards", cards.encode())

    def end_stage(self) -> None:
        """End the present stage where it stands."""
        self._call("end_stage")

    def set_load_factor(self, factor: float) -> None:
        """Load factor at the end of the coming stage, by which its loads are multiplied."""
        self._call("set_load_factor", factor)

    def set_steps(self, steps: int) -> None:
        """Load steps that the coming stage is first cut into."""
        self._call("set_steps", steps)

    def set_time(self, duration: float, start: float | None = None) -> None:
        """How long the coming stage lasts, and when it starts if not at the end of the one before."""
        self._call("set_time", duration)
        if start is not None:
            self._call("set_start_time", start)

    def set_gravity(self, vector: Sequence[float]) -> None:
        """Gravity at the end of the coming stage; it multiplies the unit weights."""
        self._call("set_gravity", _three(vector))

    def set_traction(self, surface: str, vector: Sequence[float]) -> None:
        """Dead traction on a surface at the end of the coming stage."""
        self._call("set_traction", surface.encode(), _three(vector))

    def set_pressure(self, surface: str, pressure: float) -> None:
        """Pressure on a surface at the end of the coming stage."""
        self._call("set_pressure", surface.encode(), pressure)

    def set_water_level(self, name: str, level: float) -> None:
        """Level of water at the end of the coming stage, by the set of its row; for water at rest by its body, or ""."""
        self._call("set_water_level", name.encode(), level)

    def set_displacement(self, node_set: str, component: int, value: float) -> None:
        """Displacement of a node set over the coming stage; component 0, 1 or 2."""
        self._call("set_displacement", node_set.encode(), component + 1, value)

    def set_fixity(self, node_set: str, components: Sequence[int]) -> None:
        """Components (0, 1, 2) of a node set that are held from the coming stage on; none frees it."""
        held = [int(i) for i in components]
        if any(i not in (0, 1, 2) or i != given for i, given in zip(held, components, strict=True)):
            raise ValueError(f"components are 0, 1 and 2, not {tuple(components)}")
        self._call("set_fixity", node_set.encode(), (c_int * 3)(*(int(i in held) for i in range(3))))

    # ---- values ----

    def _shape(self, name: str) -> tuple[int, int]:
        rows, columns = c_int(), c_int()
        self._call("shape", name.encode(), ctypes.byref(rows), ctypes.byref(columns))
        return rows.value, columns.value

    def get(self, name: str) -> np.ndarray:
        """A copy of values by name, one row an item."""
        rows, columns = self._shape(name)
        values = np.empty((columns, rows))
        self._call("get", name.encode(), values.ctypes.data_as(POINTER(c_double)), values.size)
        return values

    def set(self, name: str, values: np.ndarray) -> None:
        """Set point_stress, point_state or point_force, one row a point."""
        array = np.ascontiguousarray(values, dtype=float)
        rows, columns = self._shape(name)
        if array.shape != (columns, rows):
            raise ValueError(f"{name} is an array {(columns, rows)}, not {array.shape}")
        self._call("set", name.encode(), array.ctypes.data_as(POINTER(c_double)), array.size)

    def number(self, name: str) -> float:
        """A value that is one number."""
        return float(self.get(name).item())

    def names(self, kind: str) -> list[str]:
        """Names of all of a kind: value, history, stage, surface, set, material, body."""
        found: list[str] = []
        while True:
            try:
                found.append(text_of(self._open_handle().library.qsmpm_name, self._handle.pointer, kind.encode(),
                                     len(found) + 1))
            except IndexError:
                return found

    @property
    def points(self) -> Points:
        """The material points."""
        return Points(self)

    @property
    def histories(self) -> dict[str, float]:
        """The present values of the histories of the deck."""
        return dict(zip(self.names("history"), self.get("histories")[:, 0].tolist(), strict=True))

    @property
    def time(self) -> float:
        """Time reached: that of the stages before and the share of the present one."""
        return self.number("time")

    @property
    def stage(self) -> int:
        """Number of the present stage, from 1."""
        return int(self.number("stage"))

    @property
    def coming_stage(self) -> int:
        """Number of the stage that begins next, 0 when none is to come."""
        return int(self.number("coming_stage"))

    @property
    def step(self) -> int:
        """Accepted steps so far."""
        return int(self.number("step"))

    @property
    def share(self) -> float:
        """Share of the present stage that is done."""
        return self.number("share")

    @property
    def load_factor(self) -> float:
        """Load factor of the present stage."""
        return self.number("load_factor")

    @property
    def strength_factor(self) -> float:
        """Factor that strengths are divided by at present."""
        return self.number("strength_factor")

    @property
    def phase_results(self) -> list[PhaseResult]:
        """How the phases have ended, with their factors of safety."""
        words = ("not ended", "whole load", "limit load", "stop", "lost")
        return [PhaseResult(name, words[int(ended)], share, displacement, (stable, lost or math.inf) if stable > 0 else None)
                for name, (ended, share, displacement, stable, lost)
                in zip(self.names("stage"), self.get("phase_results").tolist(), strict=True)]

    @property
    def compliance(self) -> float:
        """Compliance of the last accepted step relative to that of the first one of its stage."""
        return self.number("compliance")

    @property
    def limit_load(self) -> tuple[float, float, float] | None:
        """Load factors of the present stage: carried, refused, and the knee; none until its limit load is found.

        A stage asks for it with LIMIT COMPLIANCE of *CONTROLS.
        """
        carried, refused, knee = self.get("limit_load").ravel()
        return (float(carried), float(refused), float(knee)) if knee > 0 else None


def _three(vector: Sequence[float]) -> ctypes.Array[c_double]:
    """Three numbers, with zeros behind fewer."""
    values = [float(v) for v in vector]
    if len(values) > 3:
        raise ValueError("a vector has three components")
    return (c_double * 3)(*values, *[0.0] * (3 - len(values)))
