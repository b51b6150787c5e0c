#!/usr/bin/env python3
"""Run the tests of the Python packages and close with `N passed, N failed`.

Every line of the package of references must have run: that counts as one more test.
"""

import pathlib
import sys
import unittest

from line_coverage import LineCoverage

TOOLS = pathlib.Path(__file__).resolve().parents[1] / "tools"
sys.path.insert(0, str(TOOLS))
coverage = LineCoverage(TOOLS / "qsmpm_verify" / "reference")
coverage.start()
suite = unittest.TestSuite(unittest.TestLoader().discover(str(TOOLS / package / "tests"), top_level_dir=str(TOOLS))
                           for package in ("qsmpm", "qsmpm_verify", "qsmpm_bench"))
result = unittest.TextTestRunner(stream=sys.stderr, verbosity=1).run(suite)
coverage.stop()
print("references:", coverage.report())
bad = len(result.failures) + len(result.errors) + (not coverage.complete())
print(f"{result.testsRun + 1 - bad} passed, {bad} failed")
sys.exit(1 if bad or not result.testsRun else 0)
