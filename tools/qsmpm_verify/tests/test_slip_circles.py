"""Bishop's circles of layered sections: beside the closed forms of one soil, under water, with loads, mirrored, and what is no circle."""

import math
import unittest

from qsmpm_verify.reference.slope import slope_bishop_safety
from qsmpm_verify.slip_circles import Ground, Slope, bishop, on_circle

OUTLINE = ((0.0, 0.0), (60.0, 0.0), (60.0, 7.0), (40.0, 7.0), (24.0, 15.0), (0.0, 15.0))
CLAY = ((0.0, 0.0), (30.0, 0.0), (30.0, 10.0), (0.0, 10.0))


def slope(weight: float = 19.0, **more: object) -> Slope:
    """A slope of 1:2, 8 m high."""
    return Slope([Ground(OUTLINE, weight, weight, 8.0, 25.0)], **more)  # type: ignore[arg-type]


PLACE = (22.0, 41.0, 0.55)
"""Near the critical circle of the slope."""


class Circles(unittest.TestCase):
    def test_one_soil_has_the_factor_of_the_closed_integrals(self) -> None:
        factor, _ = bishop(slope())
        self.assertAlmostEqual(factor / slope_bishop_safety(19.0, 8.0, 25.0, math.degrees(math.atan(0.5)), 8.0), 1.0, delta=1e-3)

    def test_a_mirrored_slope_has_the_same_factor(self) -> None:
        mirrored = Slope([Ground(tuple((60.0 - x, y) for x, y in OUTLINE), 19.0, 19.0, 8.0, 25.0)])
        self.assertAlmostEqual(bishop(mirrored, 600, 24)[0], bishop(slope(), 600, 24)[0], delta=1e-6)

    def test_layers_of_one_soil_are_one(self) -> None:
        cut = [((0.0, 0.0), (60.0, 0.0), (60.0, 7.0), (40.0, 7.0), (36.0, 9.0), (0.0, 9.0)), ((0.0, 9.0), (36.0, 9.0), (24.0, 15.0), (0.0, 15.0))]
        parts = Slope([Ground(part, 19.0, 19.0, 8.0, 25.0) for part in cut])
        self.assertAlmostEqual(on_circle(parts, PLACE)[0], on_circle(slope(), PLACE)[0], delta=1e-9)
        weaker = Slope([parts.grounds[0], Ground(cut[1], 19.0, 19.0, 4.0, 25.0)])
        self.assertLess(on_circle(weaker, PLACE)[0], on_circle(slope(), PLACE)[0] - 0.05)

    def test_ground_deep_under_water_has_the_weight_that_buoyancy_leaves(self) -> None:
        under = slope(18.81, water=((0.0, 25.0), (1.0, 25.0)))
        self.assertAlmostEqual(on_circle(under, PLACE)[0] / on_circle(slope(9.0), PLACE)[0], 1.0, delta=5e-3)

    def test_a_load_is_as_fill_that_holds_nothing(self) -> None:
        fill = Ground(((10.0, 15.0), (20.0, 15.0), (20.0, 16.0), (10.0, 16.0)), 30.0, 30.0, 0.0, 0.0)
        place = (15.0, *PLACE[1:])
        loaded = on_circle(slope(loads=[(15.0, 20.0, 30.0)]), place)[0]
        free = on_circle(slope(), place)[0]
        self.assertLess(loaded, free - 0.02)
        filled = on_circle(Slope([*slope().grounds, Ground(((15.1, 15.0), *fill.outline[1:3], (15.1, 16.0)), 30.0, 30.0, 0.0, 0.0)]), place)[0]
        self.assertAlmostEqual(filled, loaded, delta=0.01)

    def test_a_circle_by_hand(self) -> None:
        # phi = 0 and level ground, half of it loaded: c times the arc 2.4 R and R, over the load and its arm.
        level = Slope([Ground(CLAY, 18.0, 18.0, 20.0, 0.0)], loads=[(15.0, 20.0, 100.0)])
        factor, circle = on_circle(level, (10.0, 20.0, 1.2), 3000)
        radius = 5.0 / math.sin(1.2)
        self.assertAlmostEqual(circle[2], radius, places=6)
        self.assertAlmostEqual(factor / (20.0 * 2.4 * radius**2 / (100.0 * 5.0 * 2.5)), 1.0, delta=5e-3)

    def test_what_is_no_circle_is_refused(self) -> None:
        for place in ((20.0, 70.0, 0.5), (20.0, 45.0, 1.56), (45.0, 50.0, 0.5), (40.0, 20.0, 0.5)):
            with self.assertRaises(ArithmeticError, msg=str(place)):
                on_circle(slope(), place)
        with self.assertRaises(ArithmeticError):
            bishop(Slope([Ground(CLAY, 18.0, 18.0, 20.0, 20.0)]))


if __name__ == "__main__":
    unittest.main()
