#!/usr/bin/env python3
"""Run the tests of the Python packages and close with `N passed, N failed`."""

import pathlib
import sys
import unittest

TOOLS = pathlib.Path(__file__).resolve().parents[1] / "tools"
sys.path.insert(0, str(TOOLS))
suite = unittest.TestSuite(unittest.TestLoader().discover(str(TOOLS / package / "tests"), top_level_dir=str(TOOLS))
                           for package in ("qsmpm_verify", "qsmpm_bench"))
result = unittest.TextTestRunner(stream=sys.stderr, verbosity=1).run(suite)
bad = len(result.failures) + len(result.errors)
print(f"{result.testsRun - bad} passed, {bad} failed")
sys.exit(1 if bad or not result.testsRun else 0)
