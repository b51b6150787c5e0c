#!/usr/bin/env python3
"""Run the tests of the Python packages and close with `N passed, N failed`.

Every line of the package of references must have run: that counts as one more test. What finds no program is skipped, and counted as such.
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
skipped = len(result.skipped)
print(f"{result.testsRun + 1 - bad - skipped} passed, {bad} failed" + (f", {skipped} skipped" if skipped else ""))
sys.exit(1 if bad or not result.testsRun else 0)
