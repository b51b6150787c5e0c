"""The week: ranges of plans, and how many of them must hold."""

import math
import unittest
from pathlib import Path

from qsmpm_verify.cases import Case, load_all
from qsmpm_verify.judge import Verdict
from qsmpm_verify.places import TOP, WEEK
from qsmpm_verify.week import lines, plan_verdict, range_of


def verdict(name: str, seconds: float, **also: object) -> Verdict:
    """The exit code of a run."""
    return Verdict(name, "exit code", 0.0, "0", None, "exact", True, seconds, **also)  # type: ignore[arg-type]


class Week(unittest.TestCase):
    """Plans beside runs."""

    def test_a_range_is_read(self) -> None:
        self.assertEqual(range_of("2.1 to 1.5E+02 s: by 1 s of it"), (2.1, 150.0))
        self.assertIsNone(range_of("at least 2 s: 10 steps"))

    def share(self, *seconds: float) -> Verdict | None:
        names = [str(i) for i in range(len(seconds))]
        cases = {name: Case(name, "t", Path("d"), ()) for name in names}
        return plan_verdict({n: [verdict(n, s)] for n, s in zip(names, seconds)}, {n: (1.0, 2.0) for n in names}, cases)

    def test_eight_of_ten_must_hold(self) -> None:
        good, bad = self.share(*[1.5] * 8, 3.0, 0.5), self.share(*[1.5] * 7, 3.0, 0.5, 9.0)
        assert good and bad
        self.assertTrue(good.held)
        self.assertFalse(bad.held)

    def test_a_run_that_is_lost_tells_nothing_of_its_time(self) -> None:
        cases = {"a": Case("a", "t", Path("d"), ())}
        self.assertIsNone(plan_verdict({"a": [verdict("a", 9.0, expected=True)]}, {"a": (1.0, 2.0)}, cases))
        self.assertIsNone(plan_verdict({"a": [verdict("a", math.nan)]}, {"a": (1.0, 2.0)}, cases))

    def test_a_row_tells_seconds_and_range_once(self) -> None:
        rows = lines({"a": [verdict("a", 1.5), verdict("a", 1.5)]}, {"a": (1.0, 2.0)})
        self.assertEqual([row[-2:] for row in rows], [["1.50", "1 to 2"], ["", ""]])

    def test_every_scene_is_read_and_its_deck_is_there(self) -> None:
        """By default settings: no deck names a method or a rule of *CONTROLS."""
        for case in load_all(WEEK, TOP).values():
            text = case.deck.read_text(encoding="utf-8")
            self.assertNotIn("*METHOD", text)
            self.assertNotIn("TOLERANCE", text.replace("*SAFETY, TOLERANCE", ""))


if __name__ == "__main__":
    unittest.main()
