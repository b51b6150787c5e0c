"""Points of other programs: what was stored, what a script prints, and what takes the place of what."""

import json
import math
import tempfile
import unittest
from pathlib import Path
from unittest import mock

from qsmpm_verify import peer_points
from qsmpm_verify.choosing import cells, cheapest, table_lines
from qsmpm_verify.drawing import label_of
from qsmpm_verify.front import Sample
from qsmpm_verify.places import STUDIES, TOP
from qsmpm_verify.plots import plain_number
from qsmpm_verify.studies import load_studies
from qsmpm_verify.trouble import RunFailed, Trouble

POINTS = [
    {"study": "column", "label": "K", "error": 0.02, "seconds": 2.0, "note": "n", "size": 32},
    {"study": "column", "label": "K", "error": 0.03, "seconds": 1.0},
    {"study": "cantilever", "label": "C", "error": 0.01, "seconds": 0.5, "note": "m"},
]
SCRIPT = """#!/bin/sh
echo x >> "$(dirname "$0")/calls"
[ "$3" = 128 ] && [ -e "$(dirname "$0")/stop" ] && { echo "element inverted"; exit 1; }
echo '{"error": 0.5, "down": 8.0}'
"""


class Peers(unittest.TestCase):
    """Stored and live points."""

    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        self.stored = self.folder / "peers.json"
        self.stored.write_text(json.dumps({"points": POINTS, "checks": []}))
        self.study = load_studies(STUDIES, TOP, ["column"])[0]

    def test_stored_points_are_grouped_by_label_and_ordered_by_cost(self) -> None:
        (other,) = peer_points.peer_points("column", self.stored)
        self.assertEqual((other.label, other.caveat, other.how), ("K", "n", "run"))
        self.assertEqual([p[1:] for p in other.points], [(0.03, 1.0), (0.02, 2.0)])
        self.assertTrue(math.isnan(other.points[0][0]))
        self.assertEqual(peer_points.peer_points("footing", self.stored), [])
        self.assertEqual(peer_points.peer_points("column", self.folder / "none.json"), [])

    def test_a_point_that_is_none_is_told(self) -> None:
        for point, text in (({"label": "K"}, "requires a label"), ({"label": "K", "error": 0, "seconds": 1}, "must be positive")):
            self.stored.write_text(json.dumps({"points": [{"study": "column", **point}]}))
            with self.assertRaisesRegex(Trouble, text):
                peer_points.peer_points("column", self.stored)
        self.stored.write_text("[]")
        with self.assertRaisesRegex(Trouble, "not a file of"):
            peer_points.peer_points("column", self.stored)

    def live(self) -> list[tuple[float, float, float]]:
        python = self.folder / "python"
        python.write_text(SCRIPT)
        python.chmod(0o755)
        with mock.patch.dict("os.environ", {"QSMPM_PEERS_PYTHON": str(python)}):
            study = peer_points.with_peers(self.study, True, self.folder / "o", lambda line: None)
        return list(next(o for o in study.others if o.label == "Kratos, standard MPM, 4 points").points)

    def test_scripts_run_once_and_their_error_is_read(self) -> None:
        for _ in range(2):
            found = self.live()
            self.assertEqual({p[1] for p in found}, {0.5})
            self.assertEqual(sorted(p[0] for p in found), [16, 32, 64, 128])
        self.assertEqual((self.folder / "calls").read_text(), "x\n" * 4)

    def test_a_script_that_fails_or_is_not_there_is_told(self) -> None:
        scene = peer_points.SCENES["column"]
        python = self.folder / "python"
        python.write_text("#!/bin/sh\necho element inverted; exit 1\n")
        python.chmod(0o755)
        with self.assertRaisesRegex(RunFailed, "element inverted"):
            peer_points.live_points("column", python, self.folder / "o", lambda line: None)
        with self.assertRaisesRegex(Trouble, "tools/setup --peers"):
            peer_points.live_points("column", self.folder / "none", self.folder / "o", lambda line: None)
        self.assertEqual(peer_points.live_points("footing", python, self.folder, lambda line: None), [])
        self.assertTrue((TOP / "tools" / "peers" / scene.script).is_file())

    def test_the_shorter_beam_moves_less(self) -> None:
        # half a point is 1/24 m of 10 m: about 0.5 % less, by the reach and by the arm of the load
        exact = peer_points.cantilever_error(2, {"down": 8.2539})
        self.assertTrue(0.003 < exact < 0.007, exact)
        self.assertLess(peer_points.cantilever_error(8, {"down": 8.2539}), 0.3 * exact)


class Choosing(unittest.TestCase):
    """The table of choices and the texts of a chart."""

    def setUp(self) -> None:
        self.samples = [Sample("s", "a", n, 0.2 / n**2, 0.1 * n) for n in (1, 2, 4)]

    def test_the_cheapest_run_is_told_once(self) -> None:
        self.assertEqual(cheapest(self.samples, 0.1).size, 2)  # type: ignore[union-attr]
        self.assertIsNone(cheapest(self.samples, 0.001))
        self.assertEqual(cells(self.samples), ["a; 2; 0.2 s", "a; 4; 0.4 s", "-", "-"])
        flat = [Sample("s", "b", 1, 0.02, 1.0)]
        self.assertEqual(cells(flat), ["b; 1; 1 s", "same", "-", "-"])
        lines = table_lines([(load_studies(STUDIES, TOP, ["column"])[0], flat)], "x")
        self.assertIn("| column: stress error over the base stress | cells over the height | b; 1; 1 s | same | - | - |", lines)

    def test_the_legend_tells_orders_that_are_some(self) -> None:
        self.assertEqual(label_of("a", self.samples), "a; order 2.0")
        self.assertEqual(label_of("a", self.samples[:2]), "a; order 2.0 (2 sizes)")
        self.assertEqual(label_of("a", self.samples[:1]), "a")
        rising = [Sample("s", "a", n, 0.1 * n, 1.0) for n in (1, 2)]
        self.assertEqual(label_of("a", rising), "a; no order")
        floored = [Sample("s", "a", n, 1e-9, 1.0, at_floor=True) for n in (1, 2)]
        self.assertEqual(label_of("a", floored), "a; at the floor")

    def test_ticks_are_plain(self) -> None:
        self.assertEqual([plain_number(v) for v in (0.02, 5.0, 2000.0, 5e-5, 1e4)], ["0.02", "5", "2000", "5e-5", "1e4"])


if __name__ == "__main__":
    unittest.main()
