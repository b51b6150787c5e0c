"""The limit of a sequence of grids, or of steps, and the band around it.

Three results f1, f2, f3 on grids halved twice have the differences d1 = f2 - f1 and d2 = f3 - f2, and with r = d1/d2 the
observed order p = log2(r) (Richardson 1911; Roache 1994 for grid convergence). With r > 1 the sequence tends to
f3 + d2/(2**p - 1); the band is slightly wider than this correction, so that it contains the finest result: the
correction is reliable in magnitude, not in its digits. For an oscillating sequence with decreasing amplitude the limit is its last result, within the last amplitude.
A sequence whose differences do not decrease has no limit, and this is reported.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

# A method of second order shows a larger order by luck only; below the least one a sequence is as good as not converging.
LARGEST_ORDER = 2.0
LEAST_ORDER = 0.4
# A sequence of second order corrects by d1/12 after two halvings: less than that is two grids that agree by luck.
LEAST_SHARE = 1.0 / 12.0
# On every correction, as Roache (1994) has it for three grids.
SAFETY = 1.25
ROUNDING = 1e-6


@dataclass(frozen=True)
class Band:
    """A value and its uncertainty; order is None if it is assumed, note describes the sequence."""

    value: float
    half: float
    order: float | None
    note: str

    @property
    def low(self) -> float:
        """Lower bound."""
        return self.value - self.half

    @property
    def high(self) -> float:
        """Upper bound."""
        return self.value + self.half

    def apart(self, other: Band) -> float:
        """Distance of the other band from this one; 0 if they overlap."""
        return max(0.0, other.low - self.high, self.low - other.high)


def of_three(first: float, second: float, third: float) -> Band | None:
    """The band of three grids halved twice; None if the sequence has no limit."""
    before, last = second - first, third - second
    if last == 0.0:
        return Band(third, abs(before) * LEAST_SHARE * SAFETY, None, "the two finest grids agree")
    ratio = before / last
    if ratio < -1.0:
        return Band(third, SAFETY * abs(last), None, "oscillates with decreasing amplitude")
    if ratio <= 2.0**LEAST_ORDER:
        return None
    order = math.log2(ratio)
    used = min(order, LARGEST_ORDER)
    correction = last / (2.0**used - 1.0)
    return Band(third + correction, SAFETY * max(abs(correction), abs(before) * LEAST_SHARE), order, f"order {order:.1f}")


def of_two(first: float, second: float) -> Band:
    """The band of two grids: first order is assumed."""
    return Band(2 * second - first, abs(second - first), None, "two grids only: first order assumed")


def of_grids(figures: Sequence[float], width: float = 0.0) -> Band | None:
    """The band of the results of successively finer grids; the three finest count. Differences within the width of the results are ignored, and
    if results within their widths could converge with first order, first order is used."""
    if len(figures) >= 3:
        first, second, third = figures[-3:]
        before, last = second - first, third - second
        found = of_three(first, second, third)
        if found is None and max(abs(before), abs(last)) <= (1.0 + ROUNDING) * width:
            return Band(third, max(abs(before), abs(last)), None, "the grids agree within the bracket of the search")
        if found is None and before * last > 0.0 and abs(last) <= 0.5 * abs(before) + width:
            return Band(third + last, abs(last), None, "first order within the width of the results")
        return found
    return of_two(*figures) if len(figures) == 2 else None


def of_steps(change: float) -> tuple[float, float]:
    """Remaining error of the steps after they were halved once, and its band, both relative to the coarser result.

    For first order it is twice the change, for a higher order between the change and 4/3 of it; if the change is only the
    tolerance of the steps it is zero. The band contains all of these values.
    """
    return change, SAFETY * abs(change)


def agreed(bands: Sequence[Band]) -> tuple[Band, bool]:
    """The narrowest band, extended to those of other methods that it does not overlap; whether it was extended.

    Bands of more than three times its width are too uncertain to extend it, unless they are the majority and overlap one
    another: methods that agree are not ignored in favour of one with a narrower band.
    """
    best = min(bands, key=lambda band: band.half)
    low, high = best.low, best.high
    apart = [other for other in bands if best.apart(other) > 0]
    most = 2 * len(apart) > len(bands) and all(a.apart(b) == 0 for a in apart for b in apart)
    for other in apart:
        if most or other.half <= 3.0 * best.half:
            low, high = min(low, other.high), max(high, other.low)
    if most:
        near = min(apart, key=lambda band: band.half)
        low, high = min(low, near.low), max(high, near.high)
    stretched = (low, high) != (best.low, best.high)
    return Band((low + high) / 2, (high - low) / 2, best.order, best.note), stretched
