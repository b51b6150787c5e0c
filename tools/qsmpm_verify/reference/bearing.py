"""Bearing capacity of strip footings: Tresca soil, surcharge and cohesion factors, soil with weight.

Average pressures, compression positive; friction angle in degrees.
"""

from __future__ import annotations

import functools
import math

import numpy as np

from qsmpm_verify.reference.arguments import friction_angle, not_negative, positive, within
from qsmpm_verify.reference.characteristics import ANGLE, SECTORS, X, Z, Array, Field, Soil, extrapolated, far_field, march
from qsmpm_verify.reference.numerics import root

def prandtl_footing(cohesion: float = 1.0) -> float:
    """Bearing pressure of a rigid strip footing on Tresca soil.

    Formula: q = (2 + pi) s_u
    Units: cohesion s_u [stress]; result [stress]
    Range: any strength; the same for smooth and rough footings, weight without effect
    Assumes: plane strain, no surface load beside the footing
    Source: Prandtl 1920
    Check: dissipation of Hill's mechanism, summed over thin sectors; integration along slip lines with phi = 0
    """
    return (2 + math.pi) * cohesion


def bearing_nq(friction: float) -> float:
    """Factor of the surcharge.

    Formula: Nq = exp(pi tan phi) tan^2(45 + phi/2)
    Units: friction [degree]; result [-]
    Range: 0 <= phi < 90
    Assumes: plane strain, soil without weight
    Source: Reissner 1924
    Check: Mohr's circles on either side of thin sectors of the fan; integration along slip lines
    """
    phi = friction_angle("friction", friction)
    return math.exp(math.pi * math.tan(phi)) * math.tan(math.pi / 4 + phi / 2) ** 2


def bearing_nc(friction: float) -> float:
    """Factor of the cohesion.

    Formula: Nc = (Nq - 1) cot phi; 2 + pi for phi = 0
    Units: friction [degree]; result [-]
    Range: 0 <= phi < 90
    Assumes: plane strain, soil without weight
    Source: Prandtl 1921
    Check: integration along slip lines; limit phi -> 0
    """
    phi = friction_angle("friction", friction)
    return 2 + math.pi if phi == 0 else (bearing_nq(friction) - 1) / math.tan(phi)


@functools.cache
def _ngamma_smooth(friction: float, fan: int) -> float:
    """Half the gradient of the pressure with the distance from the edge."""
    field = far_field(friction_angle("friction", friction), fan, 0.0)
    pressure = field.soil.vertical(field.base)
    return float((pressure[-1] - pressure[-2]) / (field.base[X, -2] - field.base[X, -1]) / 2)


def _ends_on_axis(field: Field, start: int) -> Array | None:
    """The slip line from a base node to the point where its major stress is vertical; None if the integration stops before."""
    line = field.line_from_base(start)
    after = int(np.argmax(line[ANGLE] > 0))
    if after == 0:
        return None
    part = -line[ANGLE, after - 1] / (line[ANGLE, after] - line[ANGLE, after - 1])
    end = line[:, after - 1] + part * (line[:, after] - line[:, after - 1])
    return np.column_stack([line[:, :after], end])


def _trapezium(values: Array, places: Array) -> float:
    """Integral of values over positions."""
    return float(np.sum((values[1:] + values[:-1]) / 2 * np.diff(places)))


@functools.cache
def _ngamma_rough(friction: float, fan: int) -> float:
    """Vertical equilibrium of the wedge under a footing whose base is a slip line near the edges."""
    phi = friction_angle("friction", friction)
    field = far_field(phi, fan, -(math.pi / 4 + phi / 2))
    start, line = 0, None
    # the farthest slip line from the base that still reaches the axis
    low, high = 0, field.base.shape[1] - 1
    while high - low > 1:
        middle = (low + high) // 2
        found = _ends_on_axis(field, middle)
        if found is None:
            high = middle
        else:
            low, start, line = middle, middle, found
    assert line is not None
    soil, sliding = field.soil, field.base[:, : start + 1]
    force = _trapezium(soil.vertical(sliding), -sliding[X])
    force += _trapezium(soil.vertical(line), -line[X]) + _trapezium(soil.shear(line), line[Z])
    wedge = _trapezium(line[Z], -line[X])
    return (force - wedge) / float(line[X, -1]) ** 2


def bearing_ngamma_smooth(friction: float) -> float:
    """Factor of the weight, smooth footing, q = g B Ngamma / 2.

    Formula: gradient of the pressure from the edge, dp/dx / (2 g), far from the edge; method of characteristics
    Units: friction [degree]; result [-]
    Range: 5 <= phi <= 45; accurate to 2e-5
    Assumes: plane strain, associated flow, no cohesion, surcharge -> 0
    Source: Sokolovskii 1965; own integration, agrees with Martin 2005
    Check: similarity solution s(omega), t(omega) of the same equations, integrated from the base to the passive zone
    """
    within("friction", friction, 5.0, 45.0)
    return extrapolated(_ngamma_smooth(friction, SECTORS), _ngamma_smooth(friction, 2 * SECTORS))


def bearing_ngamma_rough(friction: float) -> float:
    """Factor of the weight, rough footing, q = g B Ngamma / 2.

    Formula: vertical equilibrium of the wedge between base, axis and the slip line that is vertical on the axis
    Units: friction [degree]; result [-]
    Range: 5 <= phi <= 45; accurate to 5e-5
    Assumes: plane strain, associated flow, no cohesion, surcharge -> 0, full friction near the edges
    Source: Lundgren & Mortensen 1953; own integration, agrees with Martin 2005
    Check: similarity solution of the same equations, wedge included
    """
    within("friction", friction, 5.0, 45.0)
    return extrapolated(_ngamma_rough(friction, SECTORS), _ngamma_rough(friction, 2 * SECTORS))


def _smooth_field(soil: Soil, reach: float, fan: int) -> Field:
    """Integration along the passive boundary up to a distance, finer towards the edge."""
    grading = np.expm1(np.linspace(0, 6, 4 * fan + 1)[1:]) / math.expm1(6)
    return march(soil, reach * grading, fan, 0.0)


def _smooth_reach(soil: Soil, width: float, fan: int, low: float, high: float) -> float:
    """Distance between two given ones whose slip line ends on the axis of the footing."""

    def beyond_axis(reach: float) -> float:
        return -float(_smooth_field(soil, reach, fan).base[X, -1]) - width / 2

    while beyond_axis(high) < 0:
        low, high = high, 2 * high
    return root(beyond_axis, low, high, 1e-8 * width)


def _smooth_pressure(soil: Soil, width: float, reach: float, fan: int) -> float:
    """Average pressure under half the footing."""
    base = _smooth_field(soil, reach, fan).base
    return _trapezium(soil.vertical(base), -base[X]) / (width / 2)


def bearing_capacity_smooth(
    friction: float, cohesion: float, surcharge: float, unit_weight: float, width: float
) -> float:
    """Bearing pressure of a smooth strip footing on soil with cohesion, surcharge and weight together.

    Formula: mean vertical stress on the base, method of characteristics from the surcharge to the axis
    Units: friction [degree], cohesion, surcharge and result [stress], unit_weight [force/volume], width [length]
    Range: 0 <= phi <= 45, cohesion or surcharge above zero; accurate to 1e-5
    Assumes: plane strain, associated flow; above the sum c Nc + q Nq + g B Ngamma / 2
    Source: Sokolovskii 1965; own integration
    Check: limits c Nc + q Nq without weight and g B Ngamma / 2 with much weight; phi = 0 with weight
    """
    phi = friction_angle("friction", friction)
    within("friction", friction, 0.0, 45.0)
    not_negative(cohesion=cohesion, surcharge=surcharge, unit_weight=unit_weight)
    positive(width=width, edge_strength=cohesion + surcharge)
    soil = Soil(phi, cohesion, surcharge, unit_weight)
    coarse = _smooth_reach(soil, width, SECTORS, 1e-3 * width, width)
    fine = _smooth_reach(soil, width, 2 * SECTORS, 0.98 * coarse, 1.02 * coarse)
    pressures = _smooth_pressure(soil, width, coarse, SECTORS), _smooth_pressure(soil, width, fine, 2 * SECTORS)
    return extrapolated(*pressures)


def _wedge(field: Field, start: int) -> tuple[float, float] | None:
    """Width and mean pressure of the rough footing whose wedge begins at a base node; None if the integration stops before.

    Weightless soil: the base slides up to that node, the slip line from there to the axis resists the rest.
    """
    line = _ends_on_axis(field, start)
    if line is None:
        return None
    soil, sliding = field.soil, field.base[:, : start + 1]
    force = _trapezium(soil.vertical(sliding), -sliding[X])
    force += _trapezium(soil.vertical(line), -line[X]) + _trapezium(soil.shear(line), line[Z])
    half = -float(line[X, -1])
    return 2 * half, force / half


def _profile_march(ratio: float, fan: int, end: float) -> Field:
    """Soil with strength 1 at the surface and gradient 1, for a footing of width `ratio`."""
    grading = np.expm1(np.linspace(0, 6, 4 * fan + 1)[1:]) / math.expm1(6)
    return march(Soil(0.0, 1.0, 0.0, 0.0, 1.0), 3 * max(ratio, 1.2) * grading, fan, end)


def _profile_rough(ratio: float, fan: int) -> float:
    """Mean pressure under a rough footing: its base slides near the edges, or the fan ends before."""
    field = _profile_march(ratio, fan, -math.pi / 4)
    found = [_wedge(field, start) for start in range(field.base.shape[1] - 1)]
    wedges = [wedge for wedge in found if wedge is not None]
    if wedges[0][0] < ratio:
        after = int(np.argmax([width > ratio for width, _ in wedges]))
        near = wedges[max(0, after - 2) : after + 2]
        shape = np.polynomial.Polynomial.fit([w for w, _ in near], [q for _, q in near], len(near) - 1)
        return float(shape(ratio))

    def at(end: float) -> tuple[float, float]:
        wedge = _wedge(_profile_march(ratio, fan, end), 0)
        assert wedge is not None
        return wedge

    return at(root(lambda end: at(end)[0] - ratio, -math.pi / 4, -1e-6, 1e-12))[1]


def _profile_smooth(ratio: float, fan: int, low: float, high: float) -> tuple[float, float]:
    """Mean pressure under a smooth footing, and the extent of the integration."""
    soil = Soil(0.0, 1.0, 0.0, 0.0, 1.0)
    reach = _smooth_reach(soil, ratio, fan, low, high)
    return _smooth_pressure(soil, ratio, reach, fan), reach


def bearing_profile_rough(ratio: float) -> float:
    """Bearing pressure of a rough strip footing over the strength at the surface, s_u = s_0 + k z.

    Formula: vertical equilibrium of base and wedge, method of characteristics; q = F ((2 + pi) s_0 + k B / 4)
    Units: ratio = k B / s_0 [-]; result q / s_0 [-]
    Range: 0.01 <= k B / s_0 <= 30; accurate to 1e-4
    Assumes: plane strain, Tresca soil without weight, full adhesion
    Source: Davis & Booker 1973; own integration
    Check: slope at k = 0 from the work of Prandtl's mechanism (upper bound theorem), limit 2 + pi
    """
    within("ratio", ratio, 0.01, 30.0)
    return extrapolated(_profile_rough(ratio, SECTORS), _profile_rough(ratio, 2 * SECTORS))


def bearing_profile_smooth(ratio: float) -> float:
    """Bearing pressure of a smooth strip footing over the strength at the surface, s_u = s_0 + k z.

    Formula: mean vertical stress on the base, method of characteristics
    Units: ratio = k B / s_0 [-]; result q / s_0 [-]
    Range: 0.01 <= k B / s_0 <= 30; accurate to 1e-4
    Assumes: plane strain, Tresca soil without weight
    Source: Davis & Booker 1973; own integration
    Check: slope at k = 0 from the work of Hill's mechanism (upper bound theorem), limit 2 + pi
    """
    within("ratio", ratio, 0.01, 30.0)
    coarse, reach = _profile_smooth(ratio, SECTORS, 1e-3 * ratio, ratio)
    fine, _ = _profile_smooth(ratio, 2 * SECTORS, 0.98 * reach, 1.02 * reach)
    return extrapolated(coarse, fine)
