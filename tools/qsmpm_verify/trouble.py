"""What goes wrong and what the command returns for it: 2 when asked wrongly, 3 when a run failed."""


class Trouble(Exception):
    """Asked wrongly: a file that is missing or not right, a name nobody knows, units that do not match."""

    exit_code = 2


class RunFailed(Trouble):
    """The program did not do what was asked of it."""

    exit_code = 3
