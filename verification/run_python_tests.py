#!/usr/bin/env python3
"""Run the tests of the Python packages and close with `N passed, N failed`.

Every line of the package of references must have run in its own tests: that counts as one more test. Only those tests are
watched, since watching doubles what every call costs. What finds no program is skipped, and counted as such.
"""

import pathlib
import sys
import unittest
from collections.abc import Iterator

from line_coverage import LineCoverage

TOOLS = pathlib.Path(__file__).resolve().parents[1] / "tools"
PACKAGES = ("qsmpm", "qsmpm_verify", "qsmpm_bench")
sys.path.insert(0, str(TOOLS))
AT_LAST = (
    "Factors.test_dry_and_submerged", "Factors.test_the_factor_of_taylor", "WithWeight.test_printed", "WithWeight.test_smooth_factor",
    "PassiveWall", "Bishop", "ThickLayer.test_small_load", "test_printed_davis_safeties", "makes_the_reduced_strengths_critical",
    "SimpleShear.test_any_earth_pressure", "Spiral.test_unit_weight",
)  # fmt: skip
"""Tests of references that are dear and run no line that others do not: where they come last, nothing is watched any more."""


def tests_of(suite: unittest.TestSuite) -> Iterator[unittest.TestCase]:
    """The tests of a suite of suites."""
    for entry in suite:
        if isinstance(entry, unittest.TestSuite):
            yield from tests_of(entry)
        else:
            yield entry


def run(pattern: str, but: str = "-") -> unittest.TestResult:
    """The tests of the files of a pattern in all packages, but those whose names hold a word."""
    found = (unittest.TestLoader().discover(str(TOOLS / package / "tests"), pattern, top_level_dir=str(TOOLS)) for package in PACKAGES)
    tests = [test for suite in found for test in tests_of(suite) if but not in test.id()]
    suite = unittest.TestSuite(sorted(tests, key=lambda test: any(name in test.id() for name in AT_LAST)))
    return unittest.TextTestRunner(stream=sys.stderr, verbosity=1).run(suite)


coverage = LineCoverage(TOOLS / "qsmpm_verify" / "reference")
coverage.start()
of_references = run("test_reference*.py")
coverage.stop()
results = [of_references, run("test_*.py", but=".test_reference")]
print("references:", coverage.report())
ran = sum(result.testsRun for result in results)
bad = sum(len(result.failures) + len(result.errors) for result in results) + (not coverage.complete())
skipped = sum(len(result.skipped) for result in results)
print(f"{ran + 1 - bad - skipped} passed, {bad} failed" + (f", {skipped} skipped" if skipped else ""))
sys.exit(1 if bad or not ran else 0)
