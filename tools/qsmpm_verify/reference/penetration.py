"""Resistance of Tresca soil to deeply buried bodies around which it flows: factors on the undrained strength."""

from __future__ import annotations

import math

from qsmpm_verify.reference.arguments import within


def t_bar_factor(roughness: float) -> float:
    """Resistance of a cylinder that moves laterally through deep soil (T-bar, pile).

    Formula: N = pi + 2 D + 2 cos D + 4 (cos(D/2) + sin(D/2)), D = asin(alpha)
    Units: roughness alpha [-] = shear on the surface over s_u; result [-] = force / (s_u diameter)
    Range: 0 <= alpha <= 1; 9.1416 smooth, 11.940 rough
    Assumes: plane strain, no gap behind, lower bound (equal to the upper bound for alpha = 1)
    Source: Randolph & Houlsby 1984
    Check: quadrature of the tractions of the slip-line field around the cylinder
    """
    within("roughness", roughness, 0.0, 1.0)
    d = math.asin(roughness)
    return math.pi + 2 * d + 2 * math.cos(d) + 4 * (math.cos(d / 2) + math.sin(d / 2))


def deep_plate_factor() -> float:
    """Resistance of a thin plate that moves normal to its plane through deep soil, no gap behind.

    Formula: N = 3 pi + 2 = 11.42478
    Units: [-] = force / (s_u width)
    Range: plate of zero thickness; the same for smooth and rough plates
    Assumes: plane strain, flow around both edges
    Source: Meyerhof 1951; Rowe & Davis 1982
    Check: dissipation of the mechanism of two wedges and two fans, summed over thin sectors
    """
    return 3 * math.pi + 2
