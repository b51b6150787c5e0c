"""Run a command with a limit in CPU seconds.

On a loaded machine the wall-clock time of a run is many times its CPU time, so that a wall-clock limit would stop
runs that are not slower than usual. A limit in CPU seconds alone would never stop a run that sleeps: after
WALL_FACTOR times the limit, and at least a minute, of wall-clock time the command is stopped.
"""

from __future__ import annotations

import math
import os
import resource
import signal
import subprocess
import tempfile
import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO

WALL_FACTOR = 30.0
LEAST_WALL = 60.0


@dataclass(frozen=True)
class Ended:
    """End of a command."""

    code: int | None
    """Exit code, negative for a signal; None if a limit stopped it."""
    cpu: float
    """CPU seconds of the command and of the child processes it waited for."""
    output: str = ""
    errors: str = ""
    """Its output, unless written to a file."""
    reason: str = ""
    """The limit that stopped it, as a sentence."""

    @property
    def how(self) -> str:
        """The end as text."""
        if self.code is None:
            return self.reason
        return f"stopped by signal {-self.code}" if self.code < 0 else f"exit code {self.code}"


def run_limited(
    command: Sequence[str | Path], cpu_seconds: float, cwd: Path | None = None, env: Mapping[str, str] | None = None,
    output: IO[bytes] | None = None, wall: float | None = None,
) -> Ended:  # fmt: skip
    """Run a command to its end, or to the limit in CPU seconds, with all its child processes.

    The limit applies to each process, in whole seconds. Both streams go to `output` if it is given,
    otherwise separately to the result. `wall` replaces the wall-clock limit.
    """
    whole = max(1, math.ceil(cpu_seconds))
    wall = max(LEAST_WALL, WALL_FACTOR * cpu_seconds) if wall is None else wall
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        child = subprocess.Popen(
            [str(word) for word in command], stdin=subprocess.DEVNULL, stdout=output or out, stderr=output or err, cwd=cwd,
            env=env, start_new_session=True,
        )  # fmt: skip
        # The hard limit ends a process that handles the signal of the soft one.
        resource.prlimit(child.pid, resource.RLIMIT_CPU, (whole, whole + 1))
        late = threading.Event()

        def stop() -> None:
            late.set()
            end_group(child.pid)

        guard = threading.Timer(wall, stop)
        guard.start()
        try:
            _, status, usage = os.wait4(child.pid, 0)
        except BaseException:
            end_group(child.pid)
            raise
        finally:
            guard.cancel()
        child.returncode = os.waitstatus_to_exitcode(status)
        end_group(child.pid)
        said, told = (stream.read().decode("utf-8", "replace") for stream in (out, err) if stream.seek(0) == 0)
    cpu = usage.ru_utime + usage.ru_stime
    if late.is_set():
        return Ended(None, cpu, said, told, f"stopped after {wall:g} s of wall-clock time, {cpu:.1f} CPU s")
    if child.returncode == -signal.SIGXCPU or (child.returncode == -signal.SIGKILL and cpu > 0.9 * whole):
        return Ended(None, cpu, said, told, f"stopped after {whole} CPU s")
    return Ended(child.returncode, cpu, said, told)


def end_group(leader: int) -> None:
    """Stop remaining child processes of a command."""
    try:
        os.killpg(leader, signal.SIGKILL)
    except (ProcessLookupError, PermissionError):
        pass
