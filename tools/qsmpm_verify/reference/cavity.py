"""Expansion of a cylindrical or spherical cavity in an infinite soil, large strain in the plastic zone.

Compression positive; a0 is the initial, a the current radius. `sphere` chooses the spherical cavity.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from qsmpm_verify.reference.arguments import (
    between, dilatancy_angle, friction_angle, not_negative, poisson_ratio, positive, within,
)  # fmt: skip
from qsmpm_verify.reference.numerics import end_of_path, integral, root


def cavity_tresca(expansion: float, rigidity: float, sphere: bool = False) -> float:
    """Pressure in a cavity in incompressible Tresca soil.

    Formula: (p - p0) / s_u = f (1 + ln Ir + ln(1 - (a0/a)^m)), cylinder f = 1, m = 2; sphere f = 4/3, m = 3
    Units: expansion a/a0 [-], rigidity Ir = G/s_u [-]; result [-]
    Range: Ir (1 - (a0/a)^m) >= 1: the wall has yielded
    Assumes: constant volume, elastic strain small beyond the plastic zone
    Source: Gibson & Anderson 1961; Hill 1950 (sphere)
    Check: quadrature of the equilibrium with the elastic-plastic shear stress at every radius
    """
    between("expansion", expansion, low=1.0)
    positive(rigidity=rigidity)
    power = 3 if sphere else 2
    reach = rigidity * (1 - expansion**-power)
    if reach < 1:
        raise ValueError(f"expansion = {expansion:g} is in the elastic range for rigidity = {rigidity:g}")
    return (4 / 3 if sphere else 1.0) * (1 + math.log(reach))


def cavity_tresca_limit(rigidity: float, sphere: bool = False) -> float:
    """Limit pressure in incompressible Tresca soil.

    Formula: (p - p0) / s_u = f (1 + ln Ir), cylinder f = 1, sphere f = 4/3
    Units: rigidity Ir = G/s_u [-]; result [-]
    Range: Ir >= 1
    Assumes: as cavity_tresca, a/a0 without bound
    Source: Gibson & Anderson 1961; Hill 1950 (sphere)
    Check: quadrature at a/a0 = 1e6
    """
    within("rigidity", rigidity, low=1.0)
    return (4 / 3 if sphere else 1.0) * (1 + math.log(rigidity))


class _Soil:
    """Constants of the cavity in Mohr-Coulomb soil, notation of Yu & Houlsby 1991."""

    def __init__(
        self, young: float, poisson: float, cohesion: float, friction: float, dilatancy: float, pressure: float,
        sphere: bool,
    ) -> None:  # fmt: skip
        positive(young=young, friction=friction)
        poisson_ratio(poisson)
        not_negative(cohesion=cohesion)
        phi = friction_angle("friction", friction)
        psi = dilatancy_angle(dilatancy, friction)
        self.k = 2 if sphere else 1
        self.young, self.nu, self.p0 = young, poisson, pressure
        self.shear = young / (2 * (1 + poisson))
        self.y = 2 * cohesion * math.cos(phi) / (1 - math.sin(phi))
        self.alpha = (1 + math.sin(phi)) / (1 - math.sin(phi))
        self.beta = (1 + math.sin(psi)) / (1 - math.sin(psi))
        self.excess = self.y + (self.alpha - 1) * pressure
        positive(strength=self.excess)
        self.delta = self.excess / (2 * (self.k + self.alpha) * self.shear)
        between("strain at yield", self.delta, high=1.0)
        self.q = (self.beta + self.k) / self.beta

    def pressure_at(self, reach: float) -> float:
        """Pressure in the cavity when the plastic zone ends at `reach` times its radius."""
        cap = self.y / (self.alpha - 1)
        wall = self.p0 + 2 * self.k * self.shear * self.delta + cap
        return float(wall * reach ** (self.k * (self.alpha - 1) / self.alpha)) - cap

    def least_expansion(self) -> float:
        """a/a0 at which the wall yields."""
        return 1 / (1 - self.delta)


def _lambda_one(soil: _Soil, r: float, gamma: float, xi: float) -> float:
    """The series of Yu & Houlsby, summed up to round-off."""
    total, factor = 0.0, 1.0
    for n in range(1000):
        power = n - gamma
        term = math.log(r) if abs(power) < 1e-12 else (r**power - 1) / power
        total += factor * term
        if n > gamma and abs(factor * term) <= 1e-17 * abs(total) < math.inf:
            return total
        factor *= xi / (n + 1)
    raise ArithmeticError("the series of the cavity does not converge: friction too small, or soil too soft")


def _series(soil: _Soil) -> tuple[float, float, float]:
    """gamma, eta and xi of Yu & Houlsby."""
    k, nu, alpha, beta = soil.k, soil.nu, soil.alpha, soil.beta
    gamma = alpha * (beta + k) / (k * (alpha - 1) * beta)
    eta = math.exp((beta + k) * (1 - 2 * nu) * (1 + (2 - k) * nu) * soil.excess / (soil.young * (alpha - 1) * beta))
    mixed = alpha * beta + k * (1 - 2 * nu) + 2 * nu - k * nu * (alpha + beta) / (1 - nu * (2 - k))
    xi = (1 - nu**2 * (2 - k)) * (1 + k) * soil.delta / ((1 + nu) * (alpha - 1) * beta) * mixed
    return gamma, eta, xi


def _expansion_by_series(soil: _Soil, pressure: float) -> float:
    """(a0/a)^((beta + k)/beta) at a pressure; it decreases to zero at the limit pressure."""
    gamma, eta, xi = _series(soil)
    ratio = (soil.k + soil.alpha) * (soil.y + (soil.alpha - 1) * pressure)
    r = ratio / (soil.alpha * (1 + soil.k) * soil.excess)
    return float(r**gamma * ((1 - soil.delta) ** soil.q - gamma / eta * _lambda_one(soil, r, gamma, xi)))


def _limit(soil: _Soil) -> float:
    """Pressure at which a0/a vanishes."""
    low = soil.pressure_at(1.0)
    high = 2 * low - soil.p0
    while _expansion_by_series(soil, high) > 0:
        high = 2 * high - soil.p0
    return root(lambda p: _expansion_by_series(soil, p), low, high)


def cavity_mohr_coulomb(
    expansion: float, young: float, poisson: float, cohesion: float, friction: float, dilatancy: float,
    pressure: float, sphere: bool = False,
) -> float:  # fmt: skip
    """Pressure in a cavity in Mohr-Coulomb soil, by the series.

    Formula: a/a0 = {R^-g / ((1 - d)^((b+k)/b) - (g/e) L1(R, x))}^(b/(b+k)), L1(R, x) = sum x^n (R^(n-g) - 1)/(n! (n-g))
    Units: expansion a/a0 [-], young, cohesion, initial pressure = p0 [stress], angles [degree]; result [stress]
    Range: wall has yielded; 0 < phi < 90, 0 <= psi <= phi
    Assumes: logarithmic strain in the plastic zone, small strain beyond, axial stress intermediate (cylinder)
    Source: Yu & Houlsby 1991
    Check: cavity_mohr_coulomb_quadrature; flow rule in differences of the field; Tresca for nearly zero friction
    """
    soil = _Soil(young, poisson, cohesion, friction, dilatancy, pressure, sphere)
    within("expansion", expansion, low=soil.least_expansion())
    wanted = expansion**-soil.q
    return root(lambda p: _expansion_by_series(soil, p) - wanted, soil.pressure_at(1.0) * (1 - 1e-12), _limit(soil))


def cavity_mohr_coulomb_limit(
    young: float, poisson: float, cohesion: float, friction: float, dilatancy: float, pressure: float,
    sphere: bool = False,
) -> float:  # fmt: skip
    """Limit pressure of a cavity in Mohr-Coulomb soil.

    Formula: (e/g) (1 - d)^((b+k)/b) = L1(R, x), symbols of cavity_mohr_coulomb
    Units: as cavity_mohr_coulomb
    Range: as cavity_mohr_coulomb
    Assumes: as cavity_mohr_coulomb, a/a0 without bound
    Source: Yu & Houlsby 1991
    Check: cavity_mohr_coulomb_quadrature at a/a0 = 10000
    """
    return _limit(_Soil(young, poisson, cohesion, friction, dilatancy, pressure, sphere))


def _stored(soil: _Soil, place: float) -> float:
    """b eps_r + k eps_theta of the elastic strain at `place` = r / (radius of the plastic front), tension positive."""
    k, nu, alpha = soil.k, soil.nu, soil.alpha
    cap = soil.y / (alpha - 1)
    radial = (soil.p0 + 2 * k * soil.shear * soil.delta + cap) * place ** (-k * (alpha - 1) / alpha) - cap
    hoop = (radial - soil.y) / alpha
    d_radial, d_hoop = soil.p0 - radial, soil.p0 - hoop
    if k == 1:
        part = (1 + nu) / soil.young
        eps_radial = part * ((1 - nu) * d_radial - nu * d_hoop)
        eps_hoop = part * ((1 - nu) * d_hoop - nu * d_radial)
    else:
        eps_radial = (d_radial - 2 * nu * d_hoop) / soil.young
        eps_hoop = ((1 - nu) * d_hoop - nu * d_radial) / soil.young
    return float(soil.beta * eps_radial + k * eps_hoop)


def _expansion_by_quadrature(soil: _Soil, reach: float) -> float:
    """(a0/a)^((beta + k)/beta) when the plastic zone ends at `reach` times the radius of the cavity."""
    inner = 1 / reach
    area = integral(lambda s: math.exp(-_stored(soil, s) / soil.beta) * s ** (soil.q - 1), inner, 1.0)
    return float(reach**soil.q * ((1 - soil.delta) ** soil.q - soil.q * area))


def cavity_mohr_coulomb_quadrature(
    expansion: float, young: float, poisson: float, cohesion: float, friction: float, dilatancy: float,
    pressure: float, sphere: bool = False,
) -> float:  # fmt: skip
    """The same pressure by quadrature over the plastic zone.

    Formula: a0^q = ((1 - d) b)^q - q int_a^b exp(-f(r)/beta) r^(q-1) dr, q = 1 + k/beta, \
f = beta eps_r + k eps_theta of the elastic strain
    Units: as cavity_mohr_coulomb
    Range: as cavity_mohr_coulomb
    Assumes: as cavity_mohr_coulomb
    Source: own derivation, flow rule beta d eps_r + k d eps_theta = 0 for the plastic strain
    Check: cavity_mohr_coulomb (the series), to 1e-9
    """
    soil = _Soil(young, poisson, cohesion, friction, dilatancy, pressure, sphere)
    within("expansion", expansion, low=soil.least_expansion())
    wanted = expansion**-soil.q
    high = 2.0
    while _expansion_by_quadrature(soil, high) > wanted:
        high *= 2
    return soil.pressure_at(root(lambda s: _expansion_by_quadrature(soil, s) - wanted, 1.0 - 1e-12, high))


class _Hencky:
    """Soil with Hencky's law and Mohr-Coulomb in Kirchhoff stress without dilatancy around a cavity, tension positive."""

    def __init__(self, young: float, poisson: float, cohesion: float, friction: float) -> None:
        positive(young=young, cohesion=cohesion)
        poisson_ratio(poisson)
        sine = math.sin(friction_angle("friction", friction))
        self.shear = young / (2 * (1 + poisson))
        self.plane = self.shear / (1 - 2 * poisson)
        self.ratio = (1 + sine) / (1 - sine)
        self.strength = 2 * cohesion * math.sqrt(self.ratio)

    def stress(self, radial: float, hoop: float) -> tuple[float, float, float, float]:
        """Kirchhoff stress, radial and hoop, and the derivatives of the radial one, at logarithmic strains."""
        mean = self.plane * (radial + hoop)
        half = self.shear * (radial - hoop)
        if self.ratio * (mean - half) - (mean + half) <= self.strength:
            return mean + half, mean - half, self.plane + self.shear, self.plane - self.shear
        half = ((self.ratio - 1) * mean - self.strength) / (self.ratio + 1)
        slope = 2 * self.ratio / (self.ratio + 1) * self.plane
        return mean + half, mean - half, slope, slope

    def rate(self, first: float, state: Sequence[float]) -> list[float]:
        """d(u, u')/dR, r = R + u: equilibrium d(tau_r/r')/dR = (tau_t R/r - tau_r/r')/R."""
        hoop_stretch, stretch = 1 + state[0] / first, 1 + state[1]
        radial, hoop, along, across = self.stress(math.log1p(state[1]), math.log1p(state[0] / first))
        out = (hoop / hoop_stretch - radial / stretch) / first
        bend = across * (stretch / hoop_stretch - 1) / (first * stretch)
        return [state[1], stretch**2 / (along - radial) * (out - bend)]

    def wall(self, slope: float, far: float) -> tuple[float, float]:
        """Displacement of the wall over its initial radius, and pressure, if the fixed rim at `far` has u' = -slope."""
        growth, stretch = end_of_path(self.rate, far, 1.0, [0.0, -slope])
        radial = self.stress(math.log1p(stretch), math.log1p(growth))[0]
        return growth, -radial / ((1 + growth) * (1 + stretch))


def cavity_growth_hencky(
    pressure: float, young: float, poisson: float, cohesion: float, friction: float, far: float
) -> float:
    """Displacement of the wall of a cylindrical cavity over its initial radius, soil initially stress-free.

    Formula: d(tau_r/r')/dR = (tau_t R/r - tau_r/r')/R, tau_r + tau_t = 2 (lambda + G) ln(r r'/R), r(far) = far
    Units: pressure, young, cohesion [stress], friction [degree], far = initial radius of the fixed rim over that of the \
wall [-]; result [-]
    Range: 0 < phi < 90, psi = 0, axial stress intermediate
    Assumes: Hencky's law and yield in Kirchhoff stress as KINEMATICS=LOGARITHMIC, finite strain everywhere
    Source: own derivation: without dilatancy ln(r r'/R) is elastic, so that the stress is independent of the path
    Check: cavity_mohr_coulomb for a stiff soil, Lame for a small pressure
    """
    positive(pressure=pressure)
    within("far", far, low=2.0)
    soil = _Hencky(young, poisson, cohesion, friction)
    low = high = pressure * (1 + poisson) / young / far**2
    while soil.wall(high, far)[1] < pressure:
        low, high = high, 1.5 * high
    slope = root(lambda k: soil.wall(k, far)[1] - pressure, 0.5 * low, high, tolerance=1e-14 * high)
    return soil.wall(slope, far)[0]


def tube_growth_hencky(pressure: float, young: float, poisson: float, outer: float) -> float:
    """Growth of the bore of an elastic tube under an inner pressure, over its initial radius, the rim free, ends fixed.

    Formula: d(tau_r/r')/dR = (tau_t R/r - tau_r/r')/R, tau = 2 G ln(stretch) + lambda ln(r r'/R), tau_r(outer) = 0
    Units: pressure, young [stress], outer = initial radius of the rim over that of the bore [-]; result [-]
    Range: outer > 1; below the limit pressure of the tube
    Assumes: Hencky's law in Kirchhoff stress as KINEMATICS=LOGARITHMIC, finite strain everywhere
    Source: own derivation
    Check: Lame for a small pressure
    """
    positive(pressure=pressure)
    between("outer", outer, low=1.0)
    soil = _Hencky(young, poisson, 1e6 * young, 30.0)
    free = (soil.plane - soil.shear) / (soil.plane + soil.shear)

    def bore(rim: float) -> tuple[float, float]:
        """Growth and pressure for the growth of the rim."""
        start = [outer * rim, math.expm1(-free * math.log1p(rim))]
        growth, stretch = end_of_path(soil.rate, outer, 1.0, start)
        radial = soil.stress(math.log1p(stretch), math.log1p(growth))[0]
        return growth, -radial / ((1 + growth) * (1 + stretch))

    low = high = pressure * (1 + poisson) / young / outer**2
    while bore(high)[1] < pressure:
        low, high = high, 1.2 * high
    rim = root(lambda r: bore(r)[1] - pressure, 0.1 * low, high, tolerance=1e-14 * high)
    return bore(rim)[0]
