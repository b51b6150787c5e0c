"""The value that a sequence of grids, or of steps, goes to, and the band around it.

Three figures f1, f2, f3 on grids halved twice have the differences d1 = f2 - f1 and d2 = f3 - f2, and with r = d1/d2 the
observed order p = log2(r) (Richardson 1911; Roache 1994 for what is told of grids). With r > 1 the sequence goes to
f3 + d2/(2**p - 1); the band is somewhat wider than that correction, so that it holds the finest figure itself: the
correction is trusted to its size, not to its digits. A sequence that swings with falling swings goes to its last figure, within the last swing.
One whose differences do not fall has no value, and says so.
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
    """A value and how far off it may be; order is none where it is assumed, note says what was found."""

    value: float
    half: float
    order: float | None
    note: str

    @property
    def low(self) -> float:
        """Lower end."""
        return self.value - self.half

    @property
    def high(self) -> float:
        """Upper end."""
        return self.value + self.half

    def apart(self, other: Band) -> float:
        """How far the other band lies outside this one; 0 where they meet."""
        return max(0.0, other.low - self.high, self.low - other.high)


def of_three(first: float, second: float, third: float) -> Band | None:
    """The band of three grids halved twice; none where the sequence goes nowhere."""
    before, last = second - first, third - second
    if last == 0.0:
        return Band(third, abs(before) * LEAST_SHARE * SAFETY, None, "the two finest grids agree")
    ratio = before / last
    if ratio < -1.0:
        return Band(third, SAFETY * abs(last), None, "swings, and the swings fall")
    if ratio <= 2.0**LEAST_ORDER:
        return None
    order = math.log2(ratio)
    used = min(order, LARGEST_ORDER)
    correction = last / (2.0**used - 1.0)
    return Band(third + correction, SAFETY * max(abs(correction), abs(before) * LEAST_SHARE), order, f"order {order:.1f}")


def of_two(first: float, second: float) -> Band:
    """The band of two grids: an order is assumed, the first."""
    return Band(2 * second - first, abs(second - first), None, "two grids only: first order assumed")


def of_grids(figures: Sequence[float], width: float = 0.0) -> Band | None:
    """The band of the figures of finer and finer grids; the three finest count. Differences within the width of the figures are none, and
    where figures within their widths would converge with the first order, that is taken."""
    if len(figures) >= 3:
        first, second, third = figures[-3:]
        before, last = second - first, third - second
        found = of_three(first, second, third)
        if found is None and max(abs(before), abs(last)) <= (1.0 + ROUNDING) * width:
            return Band(third, max(abs(before), abs(last)), None, "the grids agree as far as the search tells")
        if found is None and before * last > 0.0 and abs(last) <= 0.5 * abs(before) + width:
            return Band(third + last, abs(last), None, "the first order within the width of the figures")
        return found
    return of_two(*figures) if len(figures) == 2 else None


def of_steps(change: float) -> tuple[float, float]:
    """What remains of the error of steps after they were halved once, and its band, both beyond the coarser figure.

    Of first order it is twice the change, of a higher one between the change and 4/3 of it; where the change is but the
    tolerance of the steps it is nothing. The band holds all of these.
    """
    return change, SAFETY * abs(change)


def agreed(bands: Sequence[Band]) -> tuple[Band, bool]:
    """The narrowest band, stretched to those of other methods that it does not meet; whether it had to be.

    Bands of more than three times its width say too little to stretch it, unless they are most of all and meet one
    another: methods that agree are not left aside for one that is surer of itself.
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
