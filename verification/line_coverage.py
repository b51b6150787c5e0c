"""Lines of Python files that ran, from a trace function that leaves a routine alone once all of its lines have run.

It switches itself off when nothing is left to see. Only the standard library: a figure of coverage must not need a
package of its own.
"""

from __future__ import annotations

import pathlib
import sys
import types
from collections.abc import Callable, Iterator


def _routines(code: types.CodeType) -> Iterator[types.CodeType]:
    """A compiled routine and all routines inside it."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            yield from _routines(constant)


def _lines(code: types.CodeType) -> set[int]:
    """Lines that hold instructions of a routine itself; not line 0, nor the line of its `def`."""
    found = {line for _, _, line in code.co_lines() if line}
    return found - {code.co_firstlineno} if code.co_name != "<module>" else found


class LineCoverage:
    """Lines that ran of the files of one folder; start it before they are imported."""

    def __init__(self, folder: pathlib.Path) -> None:
        self.missed: dict[str, set[int]] = {}
        self.total = 0
        self._open: dict[types.CodeType, set[int]] = {}
        for path in sorted(folder.rglob("*.py")):
            every: set[int] = set()
            for routine in _routines(compile(path.read_text(), str(path), "exec")):
                every |= _lines(routine)
            self.missed[str(path)] = every
            self.total += len(every)
        self._left = self.total

    def start(self) -> None:
        """Watch from here on."""
        sys.settrace(self._called)

    def stop(self) -> None:
        """Watch no more."""
        sys.settrace(None)

    def _called(self, frame: types.FrameType, event: str, argument: object) -> Callable[..., object] | None:
        code = frame.f_code
        missed = self.missed.get(code.co_filename)
        if missed is None:
            return None
        here = self._open.get(code)
        if here is None:
            here = self._open[code] = _lines(code) & missed
        if not here:
            return None

        def ran(frame: types.FrameType, event: str, argument: object) -> Callable[..., object] | None:
            if event == "line" and frame.f_lineno in here:
                here.remove(frame.f_lineno)
                self._left -= frame.f_lineno in missed  # a lambda shares its line with the routine around it
                missed.discard(frame.f_lineno)
                if self._left == 0:
                    self.stop()
            return ran

        return ran

    def report(self) -> str:
        """Share that ran and, file by file, the lines that did not."""
        text = [f"{100 * (1 - self._left / self.total):.2f} % of {self.total} lines ran"]
        text += [f"  {path}: {', '.join(map(str, sorted(lines)))}" for path, lines in self.missed.items() if lines]
        return "\n".join(text)

    def complete(self) -> bool:
        """Whether every line ran."""
        return self.total > 0 and self._left == 0
