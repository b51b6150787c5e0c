"""Tests of the limit in CPU seconds."""

from __future__ import annotations

import subprocess
import tempfile
import time
import unittest
from pathlib import Path

from qsmpm_verify.cpu_limit import run_limited


class CpuLimit(unittest.TestCase):
    """With the shell."""

    def test_a_command_that_ends_by_itself_tells_code_streams_and_seconds(self) -> None:
        ended = run_limited(["sh", "-c", "echo told; echo wrong >&2; exit 3"], 5.0)
        self.assertEqual((ended.code, ended.output, ended.errors, ended.how), (3, "told\n", "wrong\n", "exit code 3"))
        self.assertLess(ended.cpu, 1.0)

    def test_a_command_that_computes_on_is_ended_by_its_cpu_seconds(self) -> None:
        ended = run_limited(["sh", "-c", "while :; do :; done"], 0.5)
        self.assertEqual((ended.code, ended.how), (None, "stopped after 1 CPU s"))
        self.assertLess(ended.cpu, 2.0)

    def test_a_command_that_ignores_the_signal_is_ended_all_the_same(self) -> None:
        ended = run_limited(["sh", "-c", "trap '' XCPU; while :; do :; done"], 0.5)
        self.assertEqual(ended.code, None)
        self.assertLess(ended.cpu, 4.0)

    def test_waiting_costs_no_cpu_seconds_and_is_ended_by_the_clock(self) -> None:
        self.assertEqual(run_limited(["sleep", "1.2"], 0.1).code, 0)
        ended = run_limited(["sleep", "50"], 0.1, wall=0.3)
        self.assertEqual(ended.code, None)
        self.assertIn("of wall-clock time", ended.how)

    def test_a_signal_is_told(self) -> None:
        ended = run_limited(["sh", "-c", "kill -SEGV $$"], 5.0)
        self.assertEqual((ended.code, ended.how), (-11, "stopped by signal 11"))

    def test_both_streams_go_into_a_file(self) -> None:
        with tempfile.TemporaryFile() as output:
            run_limited(["sh", "-c", "echo told; echo wrong >&2"], 5.0, output=output)
            output.seek(0)
            self.assertEqual(output.read(), b"told\nwrong\n")

    def test_what_a_command_has_left_behind_is_ended(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            run_limited(["sh", "-c", "sleep 50 & echo $! > left"], 5.0, cwd=Path(name))
            left = (Path(name) / "left").read_text().strip()
        time.sleep(0.1)
        state = subprocess.run(["ps", "-o", "stat=", "-p", left], capture_output=True, text=True, check=False).stdout
        self.assertTrue(not state.strip() or state.startswith("Z"), state)


if __name__ == "__main__":
    unittest.main()
