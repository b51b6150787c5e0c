"""Errors of the library as exceptions: one class a status, the sentence of the library as text."""
from __future__ import annotations


class Error(RuntimeError):
    """A call into the library failed; the state is that of the last accepted step."""

    code = 1

    def __init__(self, message: str, code: int | None = None) -> None:
        super().__init__(message)
        if code is not None:
            self.code = code


class DeckError(Error):
    """The deck is not good; `messages` has its faults, one a line."""

    code = 2

    def __init__(self, message: str, code: int | None = None, messages: str = "") -> None:
        super().__init__(message + ("\n" + messages.rstrip() if messages.strip() else ""), code)
        self.messages = messages


class NotConvergedError(Error):
    """No equilibrium: the load is beyond what the body carries, or a step cannot be cut further."""

    code = 3


class LeftMeshError(Error):
    """A material point left the mesh."""

    code = 4


class SingularError(Error):
    """The equations are singular: a body without support."""

    code = 5


class UserMaterialError(Error):
    """A material of the program's own is out of order."""

    code = 6


class StoppedError(Error):
    """The run was stopped on request."""

    code = 128


CLASSES = {c.code: c for c in (DeckError, NotConvergedError, LeftMeshError, SingularError, UserMaterialError,
                               StoppedError)}
