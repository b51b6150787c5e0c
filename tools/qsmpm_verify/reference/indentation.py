"""Rigid bodies pressed into elastic ground of finite depth, without friction: axisymmetric indentation forces."""

from __future__ import annotations

import math

from qsmpm_verify.reference.arguments import between, not_negative, positive
from qsmpm_verify.reference.numerics import integral, root

FAR = 30.0
"""Depth over wave length beyond which ground on a rigid base behaves as a half space: 1 - L is 1e-23."""


def layer_integral(poisson: float) -> float:
    """Reduction of the settlement under a force on the surface by a rigid base: I in w = (1 - nu^2) F/(pi E) (1/r - I/h).

    Formula: I = int_0^inf (1 - L) dx, L = (2 k sinh 2x - 4 x)/(2 k cosh 2x + 1 + k^2 + 4 x^2), k = 3 - 4 nu
    Units: Poisson's ratio nu [-]; result [-]
    Range: 0 <= nu < 0.5
    Assumes: linear elasticity, ground bonded to its base, points near the force
    Source: Vorovich, Aleksandrov & Babeshko 1974
    Check: fit of Dimitriadis et al. 2002, (1.2876 - 1.4678 nu + 1.3442 nu^2)/(1 - nu), to 1 % from nu 0.3 on
    """
    between("poisson", poisson, -1e-12, 0.5)
    k = 3 - 4 * poisson

    def missing(x: float) -> float:
        return 1 - (2 * k * math.sinh(2 * x) - 4 * x) / (2 * k * math.cosh(2 * x) + 1 + k * k + 4 * x * x)

    return integral(missing, 0.0, FAR)


def flat_punch(young: float, poisson: float, radius: float, push: float, depth: float) -> float:
    """Force on a flat cylinder on ground of finite depth.

    Formula: F = 2 a E d/(1 - nu^2)/(1 - 2 I a/(pi h))
    Units: E [stress]; radius a, indentation d, depth h [length]; result [force]
    Range: a well below h
    Assumes: linear elasticity, no friction, first order in a/h
    Source: Johnson 1985, Contact Mechanics, 3.36; base by layer_integral
    Check: depth -> infinity
    """
    positive(young=young, radius=radius, push=push, depth=depth)
    half_space = 2 * radius * young * push / (1 - poisson**2)
    return half_space / (1 - 2 * layer_integral(poisson) * radius / (math.pi * depth))


def sphere_indentation(young: float, poisson: float, radius: float, push: float, depth: float) -> float:
    """Force on a sphere on ground of finite depth.

    Formula: F = 4/3 E/(1 - nu^2) R^0.5 d^1.5 (1 + 2 I (R d)^0.5/(pi h) + 4 I^2 R d/(pi h)^2)
    Units: E [stress]; radius R, indentation d, depth h [length]; result [force]
    Range: (R d)^0.5 well below h and R
    Assumes: linear elasticity, no friction
    Source: Hertz 1881; Dimitriadis et al. 2002
    Check: the route of round_cone with the profile of a sphere alone
    """
    positive(young=young, radius=radius, push=push, depth=depth)
    share = 2 * layer_integral(poisson) * math.sqrt(radius * push) / (math.pi * depth)
    return 4 / 3 * young / (1 - poisson**2) * math.sqrt(radius) * push**1.5 * (1 + share + share**2)


def round_cone(young: float, poisson: float, angle: float, tip: float, push: float, depth: float) -> float:
    """Force on a cone with a round tip on ground of finite depth.

    Formula: d - I F (1 - nu^2)/(pi E h) = a int f'/(a^2 - r^2)^0.5 dr, F = 2 E/(1 - nu^2) int r^2 f'/(a^2 - r^2)^0.5 dr;
        slope f' of a sphere up to where it meets the cone
    Units: E [stress]; angle of the tip [degree]; radius of the tip, indentation d from contact of the sharp cone, depth h [length]; result [force]
    Range: 90 < angle < 180
    Assumes: linear elasticity, slopes small, no friction, first order in a/h
    Source: Sneddon 1965; base by layer_integral
    Check: sharp on a half space, 2/pi E d^2 tan(angle/2)/(1 - nu^2); sphere_indentation
    """
    positive(young=young, push=push, depth=depth)
    not_negative(tip=tip)
    between("angle", angle, 90.0, 180.0)
    half = math.radians(angle / 2)
    modulus, slope, end = young / (1 - poisson**2), 1 / math.tan(half), tip * math.cos(half)
    base = layer_integral(poisson) / (math.pi * modulus * depth)

    def gradient(r: float) -> float:
        return r / math.sqrt(tip**2 - r**2) if r < end else slope

    def over(a: float, power: int) -> float:
        # r = a sin t, in two parts where the slope has a kink
        def part(t: float) -> float:
            return (a * math.sin(t)) ** power * gradient(a * math.sin(t))

        kink = math.asin(min(1.0, end / a))
        return integral(part, 0.0, kink) + integral(part, kink, math.pi / 2)

    def missing(a: float) -> float:
        return push - tip * (1 / math.sin(half) - 1) - a * over(a, 0) + base * 2 * modulus * over(a, 2)

    radius = root(missing, 1e-6 * push / slope, 4 * push / slope, 1e-12)
    return 2 * modulus * over(radius, 2)
