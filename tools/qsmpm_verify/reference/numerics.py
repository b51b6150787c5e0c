"""Root, quadrature, minimum and integration of a rate: typed interfaces to scipy.

No formulas of mechanics. Each function raises ArithmeticError instead of returning a value that
has not converged.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy import integrate, optimize  # type: ignore[import-untyped]

Function = Callable[[float], float]


def root(function: Function, low: float, high: float, tolerance: float = 1e-14) -> float:
    """The point between low and high where the function changes sign (Brent 1973), tolerance on the point."""
    if function(low) * function(high) > 0:
        raise ArithmeticError(f"no change of sign between {low:g} and {high:g}")
    return float(optimize.brentq(function, low, high, xtol=tolerance, rtol=max(tolerance, 1e-14), maxiter=500))


def integral(function: Function, low: float, high: float) -> float:
    """Adaptive Gauss-Kronrod quadrature, 1e-11 of the result."""
    # full_output: trouble is told by the error, not by a warning
    value, error = integrate.quad(function, low, high, epsabs=1e-13, epsrel=1e-11, limit=400, full_output=1)[:2]
    if not error <= 1e-8 * (1 + abs(value)):
        raise ArithmeticError(f"the quadrature is uncertain by {error:g}")
    return float(value)


def minimum(
    function: Callable[[Sequence[float]], float], start: Sequence[float], tolerance: float = 1e-8
) -> float:
    """Smallest value near a start of a function of a few variables, simplex search (Nelder & Mead 1965), tolerance on the point."""
    options = {"xatol": tolerance, "fatol": 1e-5 * tolerance, "maxiter": 2000}
    with np.errstate(all="ignore"):
        found = optimize.minimize(function, np.asarray(start), method="Nelder-Mead", options=options)
    if not found.success:
        raise ArithmeticError(f"no minimum found: {found.message}")
    return float(found.fun)


def end_of_path(
    rate: Callable[[float, Sequence[float]], list[float]], start: float, stop: float, state: Sequence[float]
) -> list[float]:
    """State at `stop` of d(state)/dx = rate(x, state) from `start`, relative accuracy 1e-10 (DOP853)."""
    found = integrate.solve_ivp(rate, [start, stop], list(state), method="DOP853", rtol=1e-10, atol=1e-14)
    if not found.success:
        raise ArithmeticError(f"the rate cannot be integrated: {found.message}")
    return [float(value) for value in found.y[:, -1]]
