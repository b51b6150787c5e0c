"""Modified Cam-Clay from isotropic normal consolidation: closed paths of undrained, drained and confined tests.

M slope of the critical state line, lambda and kappa slopes of the v - ln p lines, v0 specific volume and p0 mean
stress at the start. Triaxial compression, compression positive, effective stress; eta = q/p. Strains are
those of the small-strain form with constant v = v0. Ellipse q^2 = M^2 p (p_c - p), associated flow.
"""

from __future__ import annotations

import math

from qsmpm_verify.reference.arguments import between, not_negative, poisson_ratio, positive
from qsmpm_verify.reference.numerics import root


def _soil(slope: float, lam: float, kappa: float) -> float:
    """Lam = 1 - kappa/lambda of a checked soil."""
    positive(slope=slope, lam=lam)
    not_negative(kappa=kappa)
    between("kappa", kappa, high=lam)
    return 1 - kappa / lam


def cam_clay_undrained_pressure(ratio: float, slope: float, lam: float, kappa: float) -> float:
    """Mean stress over p0 on the undrained path at a stress ratio eta.

    Formula: p / p0 = (M^2 / (M^2 + eta^2))^(1 - kappa/lambda)
    Units: ratio eta, slope M, lam, kappa [-]; result [-]
    Range: 0 <= eta <= M, 0 <= kappa < lambda
    Assumes: constant volume, isotropic normal consolidation at p0
    Source: Roscoe & Burland 1968
    Check: Runge-Kutta integration of the elastic-plastic rate
    """
    power = _soil(slope, lam, kappa)
    if not 0 <= ratio <= slope:
        raise ValueError(f"ratio = {ratio:g} must be between 0 and the slope {slope:g}")
    return float((slope**2 / (slope**2 + ratio**2)) ** power)


def cam_clay_undrained_strength(slope: float, lam: float, kappa: float) -> float:
    """Undrained shear strength over p0, triaxial compression.

    Formula: s_u / p0 = M / 2 * 2^-(1 - kappa/lambda)
    Units: [-]
    Range: 0 <= kappa < lambda
    Assumes: as cam_clay_undrained_pressure, at eta = M
    Source: Wroth 1984
    Check: Runge-Kutta integration of the elastic-plastic rate towards eta = M
    """
    return slope / 2 * cam_clay_undrained_pressure(slope, slope, lam, kappa)


def _drained(ratio: float, slope: float) -> None:
    """Reject stress ratios that a drained triaxial test does not reach."""
    between("slope", slope, 0.0, 3.0)
    if not 0 <= ratio <= slope:
        raise ValueError(f"ratio = {ratio:g} must be between 0 and the slope {slope:g}")


def cam_clay_drained_pressure(ratio: float, slope: float) -> float:
    """Mean stress over p0 in drained triaxial compression at a stress ratio eta, constant cell pressure.

    Formula: p / p0 = 3 / (3 - eta)
    Units: [-]
    Range: 0 <= eta <= M < 3
    Assumes: dq = 3 dp
    Source: equilibrium
    Check: integration along the stress path in small steps
    """
    _drained(ratio, slope)
    return 3 / (3 - ratio)


def cam_clay_drained_volume_strain(ratio: float, slope: float, lam: float, kappa: float, volume: float) -> float:
    """Volumetric strain in drained triaxial compression at a stress ratio eta.

    Formula: eps_v = (kappa ln(p/p0) + (lambda - kappa) ln((p/p0)(1 + eta^2/M^2))) / v0, p/p0 = 3/(3 - eta)
    Units: all [-], volume = v0 > 1; result [-], compression positive
    Range: 0 <= eta <= M < 3
    Assumes: small-strain form, v = v0
    Source: Roscoe & Burland 1968
    Check: Runge-Kutta integration of the elastic-plastic rate
    """
    _soil(slope, lam, kappa)
    between("volume", volume, low=1.0)
    pressure = cam_clay_drained_pressure(ratio, slope)
    return (kappa * math.log(pressure) + (lam - kappa) * math.log(pressure * (1 + (ratio / slope) ** 2))) / volume


def cam_clay_drained_shear_strain(
    ratio: float, slope: float, lam: float, kappa: float, volume: float, poisson: float
) -> float:
    """Deviatoric strain eps_q = 2/3 (eps_1 - eps_3) in drained triaxial compression at a stress ratio eta.

    Formula: eps_q = (lambda - kappa)/v0 (-ln(1 - eta/M)/(3 - M) - ln(1 + eta/M)/(3 + M) + 6 ln(1 - eta/3)/(9 - M^2) \
+ ln((M + eta)/(M - eta))/M - (2/M) atan(eta/M)) + 2 (1 + nu) kappa ln(3/(3 - eta)) / (3 (1 - 2 nu) v0)
    Units: all [-], volume = v0 > 1; result [-]
    Range: 0 <= eta < M < 3; infinite at eta = M
    Assumes: small-strain form, v = v0, constant Poisson's ratio, shear modulus proportional to p
    Source: own integration of the flow rule 2 eta / (M^2 - eta^2)
    Check: Runge-Kutta integration of the elastic-plastic rate
    """
    _soil(slope, lam, kappa)
    _drained(ratio, slope)
    between("ratio", ratio, high=slope)
    between("volume", volume, low=1.0)
    poisson_ratio(poisson)
    x = ratio / slope
    plastic = (
        -math.log1p(-x) / (3 - slope)
        - math.log1p(x) / (3 + slope)
        + 6 * math.log1p(-ratio / 3) / (9 - slope**2)
        + math.log((1 + x) / (1 - x)) / slope
        - 2 / slope * math.atan(x)
    )
    elastic = 2 * (1 + poisson) * kappa / (3 * (1 - 2 * poisson)) * math.log(3 / (3 - ratio))
    return ((lam - kappa) * plastic + elastic) / volume


def cam_clay_confined_ratio(slope: float, lam: float, kappa: float, poisson: float) -> float:
    """Stress ratio eta to which one-dimensional compression tends.

    Formula: lambda = 1.5 ((lambda - kappa) 2 eta / (M^2 - eta^2) + kappa eta 2 (1 + nu) / (9 (1 - 2 nu)))
    Units: all [-]; result eta [-]
    Range: 0 <= kappa < lambda, -1 < nu < 0.5
    Assumes: no lateral strain, eps_v = 1.5 eps_q, constant stress ratio
    Source: Roscoe & Burland 1968 with elastic strain; own derivation
    Check: Runge-Kutta integration of confined compression from an isotropic state
    """
    _soil(slope, lam, kappa)
    poisson_ratio(poisson)
    elastic = kappa * 2 * (1 + poisson) / (9 * (1 - 2 * poisson))

    def excess(ratio: float) -> float:
        flow = (lam - kappa) * 2 * ratio
        return 1.5 * (flow + elastic * ratio * (slope**2 - ratio**2)) - lam * (slope**2 - ratio**2)

    return root(excess, 0.0, slope)


def cam_clay_confined_k0(slope: float, lam: float, kappa: float, poisson: float) -> float:
    """Lateral over axial stress to which one-dimensional compression tends.

    Formula: K0 = (3 - eta) / (3 + 2 eta), eta of cam_clay_confined_ratio
    Units: all [-]; result [-]
    Range: as cam_clay_confined_ratio, eta < 3
    Assumes: as cam_clay_confined_ratio
    Source: definition of eta
    Check: Runge-Kutta integration of confined compression from an isotropic state
    """
    ratio = cam_clay_confined_ratio(slope, lam, kappa, poisson)
    return (3 - ratio) / (3 + 2 * ratio)
