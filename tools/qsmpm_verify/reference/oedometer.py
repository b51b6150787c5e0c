"""One-dimensional compression between rigid, smooth walls, for three laws of large strain.

Engineering strain e = 1 - L/L0 and stress are positive in compression; the stretch is 1 - e. All
states are homogeneous, so that the deviation of a code from them is its error in time, not in space.
"""

from __future__ import annotations

import math

from qsmpm_verify.reference.arguments import between, poisson_ratio, positive, step_count


def constrained_modulus(young: float, poisson: float) -> float:
    """Modulus of one-dimensional compression.

    Formula: M = E (1 - nu) / ((1 + nu) (1 - 2 nu))
    Units: young [stress]; result [stress]
    Range: -1 < nu < 0.5
    Assumes: isotropic linear elasticity, no lateral strain
    Source: linear elasticity
    Check: Hooke's law in flexibility form solved for zero lateral strain
    """
    positive(young=young)
    poisson_ratio(poisson)
    return young * (1 - poisson) / ((1 + poisson) * (1 - 2 * poisson))


def lateral_modulus(young: float, poisson: float) -> float:
    """Lateral stress per axial strain in one-dimensional compression, Lame's first constant.

    Formula: L = E nu / ((1 + nu) (1 - 2 nu))
    Units: young [stress]; result [stress]
    Range: -1 < nu < 0.5
    Assumes: isotropic linear elasticity, no lateral strain
    Source: linear elasticity
    Check: Hooke's law in flexibility form solved for zero lateral strain
    """
    return constrained_modulus(young, poisson) * poisson / (1 - poisson)


def van_langen(strain: float, modulus: float = 1.0) -> float:
    """Axial Cauchy stress of the rate law (Jaumann rate with the -sigma tr(d eps) term).

    Formula: sigma = M e / (1 - e) = M (exp(eps_L) - 1), eps_L = -ln(1 - e)
    Units: strain e [-], modulus M [stress] (E for nu = 0); result [stress]
    Range: e < 1; negative e is extension
    Assumes: no lateral strain, no rotation, initially stress-free
    Source: van Langen 1991; Beuth et al. 2008, sect. 4.1; integral of d(lambda sigma) = M d lambda
    Check: Runge-Kutta integration of the rate; the exponential form
    """
    between("strain", strain, high=1.0)
    return modulus * strain / (1 - strain)


def van_langen_lateral(strain: float, young: float, poisson: float) -> float:
    """Lateral Cauchy stress of the rate law.

    Formula: sigma_lat = L e / (1 - e), L = E nu / ((1 + nu)(1 - 2 nu))
    Units: strain [-], young [stress]; result [stress]
    Range: e < 1, -1 < nu < 0.5
    Assumes: as van_langen; the ratio to the axial stress remains nu / (1 - nu)
    Source: own derivation, the lateral component of the same rate
    Check: Runge-Kutta integration of the three-dimensional rate
    """
    return van_langen(strain, lateral_modulus(young, poisson))


def van_langen_paper_steps(strain: float, steps: float, modulus: float = 1.0) -> float:
    """The rate law with n equal strain steps and the stress at the start of the step in -sigma tr(d eps).

    Formula: sigma = M e / (1 - e + e/n)
    Units: strain [-], steps n [-], modulus [stress]; result [stress]
    Range: e < 1, n an integer
    Assumes: d eps = d L / L with L at the start of the step (RATE=PAPER); (M + s_k) = (M + s_(k-1))(1 + d_k) telescopes
    Source: own derivation from eq. 11 of Beuth et al. 2008
    Check: the update carried out step by step
    """
    between("strain", strain, high=1.0)
    return modulus * strain / (1 - strain + strain / step_count(steps))


def van_langen_paper_steps_error(strain: float, steps: float) -> float:
    """Relative error of this scheme in the axial stress.

    Formula: error = -h / (1 - e + h), h = e/n
    Units: strain [-], steps [-]; result [-], negative is too low
    Range: e < 1, n an integer
    Assumes: as van_langen_paper_steps
    Source: own derivation
    Check: the update carried out step by step against the integrated rate
    """
    between("strain", strain, high=1.0)
    step = strain / step_count(steps)
    return -step / (1 - strain + step)


def van_langen_load_steps(stress: float, steps: float, modulus: float = 1.0) -> float:
    """Length L/L0 of the rate law under n equal load steps with the stress at the start of the step.

    Formula: L/L0 = (M - ds) / (M + s - ds), ds = s/n
    Units: stress s and modulus M [stress], steps n [-]; result [-]
    Range: s > -M (tension below M), ds < M: a larger step would invert the specimen
    Assumes: as van_langen_paper_steps, loads instead of displacements
    Source: own derivation
    Check: the update carried out step by step; the exact M/(M + s) for many steps
    """
    positive(modulus=modulus)
    between("stress", stress, low=-modulus)
    change = stress / step_count(steps)
    between("load step", change, high=modulus)
    return (modulus - change) / (modulus + stress - change)


def hencky_oedometer(strain: float, modulus: float = 1.0) -> float:
    """Axial Cauchy stress of the logarithmic law: Kirchhoff stress linear in the logarithmic strain.

    Formula: sigma = M eps_L exp(eps_L), eps_L = -ln(1 - e)
    Units: strain [-], modulus [stress]; result [stress]
    Range: e < 1
    Assumes: no lateral strain (KINEMATICS=LOGARITHMIC)
    Source: Hencky 1928; own derivation
    Check: finite differences of the strain energy M eps_L^2 / 2 per unit of initial volume
    """
    between("strain", strain, high=1.0)
    logarithmic = -math.log1p(-strain)
    return modulus * logarithmic * math.exp(logarithmic)


def hencky_oedometer_lateral(strain: float, young: float, poisson: float) -> float:
    """Lateral Cauchy stress of the logarithmic law.

    Formula: sigma_lat = L eps_L exp(eps_L), L = E nu / ((1 + nu)(1 - 2 nu))
    Units: strain [-], young [stress]; result [stress]
    Range: e < 1, -1 < nu < 0.5
    Assumes: as hencky_oedometer
    Source: own derivation
    Check: finite differences of the energy in the lateral stretch
    """
    return hencky_oedometer(strain, lateral_modulus(young, poisson))


def linear_oedometer(strain: float, modulus: float = 1.0) -> float:
    """Axial stress of the small-strain law, to which the two others tend.

    Formula: sigma = M e
    Units: strain [-], modulus [stress]; result [stress]
    Range: |e| << 1; the others differ from it by 1 + e and 1 + 3 e / 2 to first order
    Assumes: small strain, initial length in strain and area
    Source: Hooke
    Check: Hooke's law in flexibility form; slope at zero of the two laws of large strain
    """
    between("strain", strain, high=1.0)
    return modulus * strain
