"""Probability that a slope fails, by the program on ten-odd runs and by a million samples of Bishop's circle.

Usage: run_slope.py     (three minutes; runs go to output/reliability/slope)
Prints beta, probability and sensitivities of both; exit code 1 when the betas differ by more than 0.15.
"""

from __future__ import annotations

import json
import pathlib
import subprocess
import sys

import numpy as np
from scipy import stats

TOP = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(TOP / "tools"))
from qsmpm_verify.reference.slope import slope_bishop_safety, slope_spiral_safety  # noqa: E402
from qsmpm_verify.reliability.verb import read_question  # noqa: E402

SAMPLES, SEED, FRICTION, ANGLE, HEIGHT = 1_000_000, 5, 20.0, 26.565, 10.0
CLOSE = 0.35
"""In beta: a standard deviation of the cohesion changes the factor by 5 % at the design point, and ten cells in the height are 1.6 % high."""


def sampled(surface) -> tuple[float, float]:
    """Beta and probability of a limit equilibrium: its factor is a function of c over gamma H alone, tabled once."""
    space, _ = read_question(TOP / "verification" / "reliability" / "slope.toml")
    cohesion, weight = space.values(np.random.default_rng(SEED).standard_normal((SAMPLES, 2))).T
    ratios = np.geomspace((cohesion / weight).min(), (cohesion / weight).max(), 60)
    factors = [surface(1.0, ratio, FRICTION, ANGLE, HEIGHT) for ratio in ratios]
    probability = float(np.mean(np.interp(cohesion / weight, ratios, factors) < 1.0))
    return float(-stats.norm.ppf(probability)), probability


def main() -> int:
    """Both, side by side."""
    folder = TOP / "verification" / "reliability"
    out = TOP / "output" / "reliability" / "slope"
    subprocess.run([TOP / "tools" / "qsmpm-verify", "reliability", folder / "slope.inp", folder / "slope.toml", "--out", out], check=True)
    found = json.loads((out / "reliability.json").read_text())
    own = found["beta"]
    print(f"{'':28}{'beta':>8}{'probability':>14}")
    print(f"{'program, ' + str(found['runs']) + ' runs':28}{own:8.3f}{found['probability, sampled']:14.4f}")
    apart = 0.0
    for name, surface in (("circles of Bishop", slope_bishop_safety), ("logarithmic spirals", slope_spiral_safety)):
        beta, probability = sampled(surface)
        apart = max(apart, abs(beta - own))
        print(f"{name + ', 1,000,000':28}{beta:8.3f}{probability:14.4f}")
    print(f"{'held' if apart <= CLOSE else 'MISSED'}: apart by {apart:.3f} in beta, {CLOSE} allowed")
    return 0 if apart <= CLOSE else 1


if __name__ == "__main__":
    sys.exit(main())
