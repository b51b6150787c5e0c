"""Errors and the exit codes of the command: 2 for invalid input, 3 for a failed run."""


class Trouble(Exception):
    """Invalid input: a file that is missing or invalid, an unknown name, inconsistent units."""

    exit_code = 2


class RunFailed(Trouble):
    """The program did not do what was requested."""

    exit_code = 3
