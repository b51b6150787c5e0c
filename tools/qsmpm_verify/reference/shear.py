"""Simple shear under three objective rates, and a rigid rotation under the update of the paper.

Simple shear: x = X + gamma Y, initially stress-free, so that s22 = -s11 and only the shear modulus G
matters. The `_normal` functions give s11, the others s12, tension positive.
Rigid rotation: the update with strain sym(R) - I and spin skew(R) of a rotation by a finite angle has the errors
below; a faulty code gives these values, the correct values are zero (or one).
"""

from __future__ import annotations

import math

from qsmpm_verify.reference.arguments import step_count


def shear_jaumann(shear: float, modulus: float = 1.0) -> float:
    """Shear stress s12 in simple shear, Jaumann rate.

    Formula: s12 = G sin(gamma)
    Units: shear gamma [-], modulus G [stress]; result [stress]
    Range: any gamma; the decrease beyond pi/2 is a defect of the law, not of a code
    Assumes: initially stress-free
    Source: Dienes 1979
    Check: Runge-Kutta integration of the rate with 2 x 2 matrices
    """
    return modulus * math.sin(shear)


def shear_jaumann_normal(shear: float, modulus: float = 1.0) -> float:
    """Normal stress s11 = -s22 in simple shear, Jaumann rate.

    Formula: s11 = G (1 - cos(gamma))
    Units: as shear_jaumann
    Range: any gamma
    Assumes: initially stress-free
    Source: Dienes 1979
    Check: Runge-Kutta integration of the rate with 2 x 2 matrices
    """
    return modulus * (1 - math.cos(shear))


def shear_green_naghdi(shear: float, modulus: float = 1.0) -> float:
    """Shear stress s12 in simple shear, Green-Naghdi rate.

    Formula: s12 = 2 G cos 2b (2 b - 2 tan 2b ln cos b - tan b), tan b = gamma / 2
    Units: as shear_jaumann
    Range: any gamma
    Assumes: initially stress-free
    Source: Dienes 1979
    Check: Runge-Kutta integration in axes rotated by the polar rotation
    """
    b = math.atan(shear / 2)
    return 2 * modulus * (math.cos(2 * b) * (2 * b - math.tan(b)) - 2 * math.sin(2 * b) * math.log(math.cos(b)))


def shear_green_naghdi_normal(shear: float, modulus: float = 1.0) -> float:
    """Normal stress s11 = -s22 in simple shear, Green-Naghdi rate.

    Formula: s11 = 4 G (cos 2b ln cos b + b sin 2b - sin^2 b), tan b = gamma / 2
    Units: as shear_jaumann
    Range: any gamma
    Assumes: initially stress-free
    Source: Dienes 1979
    Check: Runge-Kutta integration in axes rotated by the polar rotation
    """
    b = math.atan(shear / 2)
    return 4 * modulus * (math.cos(2 * b) * math.log(math.cos(b)) + b * math.sin(2 * b) - math.sin(b) ** 2)


def shear_logarithmic(shear: float, modulus: float = 1.0) -> float:
    """Shear stress s12 in simple shear, logarithmic rate, which is the Hencky law.

    Formula: s12 = 2 G asinh(gamma / 2) / sqrt(1 + gamma^2 / 4)
    Units: as shear_jaumann
    Range: any gamma; largest 1.325487 G at gamma = 3.01776
    Assumes: initially stress-free, Kirchhoff stress linear in ln V (J = 1)
    Source: Hencky 1928; Xiao, Bruhns & Meyers 1997
    Check: matrix logarithm of F F^T
    """
    return 2 * modulus * math.asinh(shear / 2) / math.sqrt(1 + shear * shear / 4)


def shear_logarithmic_normal(shear: float, modulus: float = 1.0) -> float:
    """Normal stress s11 = -s22 in simple shear, logarithmic rate.

    Formula: s11 = gamma s12 / 2
    Units: as shear_jaumann
    Range: any gamma
    Assumes: as shear_logarithmic
    Source: Hencky 1928
    Check: matrix logarithm of F F^T
    """
    return shear / 2 * shear_logarithmic(shear, modulus)


def shear_jaumann_paper_steps(shear: float, steps: float, modulus: float = 1.0) -> float:
    """Shear stress s12 of the Jaumann rate in n equal steps of the first-order update.

    Formula: s12 = -G Im((1 - i h)^n), h = gamma / n
    Units: shear [-], steps [-], modulus [stress]; result [stress]
    Range: n an integer; first order, relative error gamma h / 2 (too large)
    Assumes: spin applied to the stress at the start of the step
    Source: own derivation, s11 - G + i s12 rotates by -i d gamma
    Check: the update carried out with 2 x 2 matrices
    """
    count = step_count(steps)
    return float(-modulus * ((1 - 1j * shear / count) ** count).imag)


def shear_jaumann_midpoint_steps(shear: float, steps: float, modulus: float = 1.0) -> float:
    """Shear stress s12 of the Jaumann rate in n steps, half the rotation before and half after the increment.

    Formula: w = i G h p (1 - p^(2n)) / (1 - p^2), p = exp(-2 i atan(h/4)), s12 = Im w, h = gamma / n
    Units: as shear_jaumann_paper_steps
    Range: n an integer, gamma not zero; second order
    Assumes: rotation of Hughes & Winget 1980 (RATE=MIDPOINT)
    Source: own derivation, geometric series of w = s11 + i s12
    Check: the update carried out with 2 x 2 matrices; second order in the step
    """
    count = step_count(steps)
    h = shear / count
    if h == 0:
        return 0.0
    angle = 2 * math.atan(h / 4)
    turn = complex(math.cos(angle), -math.sin(angle))
    return float((1j * modulus * h * turn * (1 - turn ** (2 * count)) / (1 - turn**2)).imag)


def _angle(steps: float, turn: float) -> float:
    """Angle of one step [radian]."""
    return math.radians(turn) / step_count(steps)


def rigid_turn_false_strain(steps: float, turn: float = 360.0) -> float:
    """Sum of the in-plane strain increments R - I of a rigid rotation; zero is correct.

    Formula: n (cos a - 1), a = turn / n
    Units: steps n [-], turn [degree]; result [-]
    Range: n an integer
    Assumes: strain increment sym(R - I)
    Source: own derivation from eqs. 9-10 of Beuth et al. 2008
    Check: the update carried out with 2 x 2 matrices
    """
    return step_count(steps) * (math.cos(_angle(steps, turn)) - 1)


def rigid_turn_false_deviator(steps: float, turn: float = 360.0) -> float:
    """Factor by which the paper's update multiplies the magnitude of a deviatoric stress; one is correct.

    Formula: |1 + 2 (1 - cos a) + 2 i sin a|^n, a = turn / n; tends to exp(12 pi^2 / n) for a full rotation
    Units: steps n [-], turn [degree]; result [-]
    Range: n an integer
    Assumes: eq. 11 with spin skew(R), strain sym(R) - I and the -sigma tr(d eps) term
    Source: own derivation
    Check: the update carried out with 2 x 2 matrices
    """
    a = _angle(steps, turn)
    return math.hypot(1 + 2 * (1 - math.cos(a)), 2 * math.sin(a)) ** step_count(steps)


def rigid_turn_false_mean_stress(steps: float, turn: float = 360.0, shear: float = 1.0, lame: float = 1.0) -> float:
    """In-plane mean stress that the paper's update produces in a rigid rotation; zero is correct.

    Formula: (G + L) (1 - (1 + 2 (1 - cos a))^n), a = turn / n
    Units: steps n [-], turn [degree], shear modulus G and Lame's first constant L [stress]; result [stress]
    Range: n an integer; plane strain
    Assumes: as rigid_turn_false_deviator, initial mean stress zero
    Source: own derivation
    Check: the update carried out with 2 x 2 matrices
    """
    return (shear + lame) * (1 - (1 + 2 * (1 - math.cos(_angle(steps, turn)))) ** step_count(steps))


def rigid_turn_false_volume(steps: float, turn: float = 360.0) -> float:
    """Factor by which the volume update 1 + eps_kk changes a point in a rigid rotation; one is correct.

    Formula: (1 - 2 (1 - cos a))^n, a = turn / n
    Units: steps n [-], turn [degree]; result [-]
    Range: n an integer, steps below 60 degrees
    Assumes: volume multiplied by 1 + tr(sym(R - I)) in each step; det R = 1 is exact
    Source: own derivation from eq. 28 of Beuth et al. 2008
    Check: the update carried out with 2 x 2 matrices
    """
    a = _angle(steps, turn)
    if abs(a) >= math.pi / 3:
        raise ValueError(f"a step of {math.degrees(a):g} degrees inverts the volume")
    return (1 - 2 * (1 - math.cos(a))) ** step_count(steps)
