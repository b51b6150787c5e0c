"""Earth pressure on rough walls: the integration along slip lines compared with the similarity solution, and bounds from both sides."""

import math
import unittest

from qsmpm_verify.reference.earth_pressure import passive_wall, rankine_active, rankine_passive

State = tuple[float, float]


def coulomb(friction: float, wall: float) -> float:
    """The plane wedge."""
    phi, delta = math.radians(friction), math.radians(wall)
    root = math.sqrt(math.sin(phi + delta) * math.sin(phi) / math.cos(delta))
    return (math.cos(phi) / (1 - root)) ** 2 / math.cos(delta)


def lancellotta(friction: float, wall: float) -> float:
    """A field of stress with one fan of discontinuities (Lancellotta 2002), of the whole push."""
    phi, delta = math.radians(friction), math.radians(wall)
    turn = math.asin(math.sin(delta) / math.sin(phi)) + delta
    root = math.sqrt(math.sin(phi) ** 2 - math.sin(delta) ** 2)
    return (math.cos(delta) + root) / (1 - math.sin(phi)) * math.exp(turn * math.tan(phi))


def similar(friction: float, wall: float, steps: int = 1200) -> float:
    """Mean stress gamma r chi(t), major stress at a(t) below the horizontal, t below the surface, from the wall on.

    chi at the wall is right when a vanishes just where the passive zone begins, t = 45 - phi/2, a slip line.
    """
    sine, slope = math.sin(math.radians(friction)), math.radians(wall)
    dip = (slope + math.asin(math.sin(slope) / sine)) / 2
    low, high = 0.5, 100.0
    while high - low > 1e-9 * high:
        middle = (low + high) / 2
        low, high = (low, middle) if levels_early(sine, (middle, dip), steps) else (middle, high)
    return low * (1 + sine * math.cos(2 * dip)) / math.cos(slope)


def levels_early(sine: float, state: State, steps: int) -> bool:
    """Whether the major stress is level before the passive zone is reached; not where a ray is a slip line before."""
    place, end = math.pi / 2, math.pi / 4 - math.asin(sine) / 2
    step = (end - place) / steps
    for _ in range(steps):
        if state[1] <= 0:
            return True
        if min(slip(sine, place, state[1]), slip(sine, place + step / 2, state[1])) <= 0:
            return False
        state = moved(state, rate(sine, place + step / 2, moved(state, rate(sine, place, state), step / 2)), step)
        place += step
    return False


def parts(sine: float, place: float, dip: float) -> State:
    return sine * math.sin(2 * (dip - place)), sine * math.cos(2 * (dip - place))


def slip(sine: float, place: float, dip: float) -> float:
    """Zero where a ray is a slip line."""
    s, c = parts(sine, place, dip)
    return s * s - c * (1 - c)


def moved(state: State, change: State, step: float) -> State:
    return state[0] + step * change[0], state[1] + step * change[1]


def rate(sine: float, place: float, state: State) -> State:
    """chi' and a' from equilibrium along and across the ray."""
    chi, dip = state
    s, c = parts(sine, place, dip)
    along, across = math.sin(place) - chi * (1 + 3 * c), math.cos(place) - 3 * chi * s
    below = slip(sine, place, dip)
    return (s * along - c * across) / below, (s * across - (1 - c) * along) / (2 * chi * below) + 1


class Rankine(unittest.TestCase):
    def test_active_and_passive_are_two_ends_of_one_circle(self) -> None:
        for depth, cohesion, friction in ((2.0, 0.0, 30.0), (3.0, 5.0, 20.0), (4.0, 12.0, 0.0)):
            active = rankine_active(depth, 18.0, cohesion, friction, 60.0)
            self.assertGreater(active, 0.0)
            # What is active below the weight is passive below itself.
            self.assertAlmostEqual(rankine_passive(0.0, 18.0, cohesion, friction, active), 18.0 * depth + 60.0, 9)

    def test_soil_that_stands_by_itself_presses_on_nothing(self) -> None:
        self.assertEqual(rankine_active(1.0, 18.0, 20.0, 25.0), 0.0)


class PassiveWall(unittest.TestCase):
    def test_is_the_similarity_solution(self) -> None:
        for friction, wall in ((30, 10), (30, 20), (40, 20)):
            # The shooting is of first order: 2e-4 with 1200 steps, half of it with twice as many.
            one, two = similar(friction, wall), similar(friction, wall, 2400)
            self.assertAlmostEqual(passive_wall(friction, wall) / (2 * two - one), 1.0, 4)

    def test_lies_between_the_bounds(self) -> None:
        for friction, wall in ((20, 10), (30, 10), (30, 20), (35, 15), (40, 20)):
            found = passive_wall(friction, wall)
            self.assertGreater(found, lancellotta(friction, wall))
            self.assertLess(found, coulomb(friction, wall))

    def test_meets_rankine_at_a_smooth_wall(self) -> None:
        self.assertAlmostEqual(passive_wall(30, 0), 3.0, 10)

    def test_rougher_than_the_sand_is_refused(self) -> None:
        self.assertRaises(ValueError, passive_wall, 30, 30)
        self.assertRaises(ValueError, passive_wall, 30, -1)
