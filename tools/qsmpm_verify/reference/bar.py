"""A bar in tension with free sides, up to and beyond its largest load. Tension positive."""

from __future__ import annotations

import math

from qsmpm_verify.reference.arguments import positive, within


def bar_force_rate(stretch: float, poisson: float) -> float:
    """Axial force of the bar, rate law.

    Formula: P / (E A0) = (lambda^(-2 nu) - lambda^(-1)) / (1 - 2 nu); ln(lambda) / lambda for nu = 0.5
    Units: stretch lambda [-]; result [-], over E and the initial area
    Range: lambda > 0, 0 <= nu <= 0.5
    Assumes: stress only along the bar, homogeneous
    Source: own derivation, d sigma = (E - (1 - 2 nu) sigma) d lambda / lambda
    Check: Runge-Kutta integration of the three-dimensional rate with free sides
    """
    positive(stretch=stretch)
    within("poisson", poisson, 0.0, 0.5)
    if poisson == 0.5:
        return math.log(stretch) / stretch
    return float(stretch ** (-2 * poisson) - 1 / stretch) / (1 - 2 * poisson)


def bar_peak_stretch_rate(poisson: float) -> float:
    """Stretch at the largest force of the bar, rate law.

    Formula: lambda = (1 / (2 nu))^(1 / (1 - 2 nu)); e for nu = 0.5
    Units: [-]
    Range: 0 < nu <= 0.5; for nu = 0 the force tends to E A0 without a maximum
    Assumes: as bar_force_rate
    Source: own derivation
    Check: search for the maximum of the integrated rate
    """
    within("poisson", poisson, 0.0, 0.5)
    positive(poisson=poisson)
    if poisson == 0.5:
        return math.e
    return float((2 * poisson) ** (-1 / (1 - 2 * poisson)))


def bar_peak_force_rate(poisson: float) -> float:
    """Largest force of the bar, rate law: beyond it no equilibrium under load control.

    Formula: P / (E A0) at bar_peak_stretch_rate
    Units: [-]
    Range: 0 < nu <= 0.5
    Assumes: as bar_force_rate
    Source: own derivation
    Check: search for the maximum of the integrated rate
    """
    return bar_force_rate(bar_peak_stretch_rate(poisson), poisson)


def bar_force_hencky(stretch: float) -> float:
    """Axial force of the bar, logarithmic law, for any nu.

    Formula: P / (E A0) = ln(lambda) / lambda; largest 1/e at lambda = e
    Units: stretch lambda [-]; result [-], over E and the initial area
    Range: lambda > 0
    Assumes: stress only along the bar, homogeneous
    Source: Hencky 1928
    Check: finite differences of the energy minimised over the lateral stretch
    """
    positive(stretch=stretch)
    return math.log(stretch) / stretch


def bar_peak_force_hencky() -> float:
    """Largest force of the bar, logarithmic law.

    Formula: P / (E A0) = 1/e at lambda = e
    Units: [-]
    Range: any nu
    Assumes: as bar_force_hencky
    Source: own derivation
    Check: search for the maximum of the force
    """
    return math.exp(-1)
