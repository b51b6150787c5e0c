"""Flow nets: lines of equal head and of flow where there is water, none where it is dry, still or level."""

import tempfile
import unittest
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection

from qsmpm_verify.bodies import body_of
from qsmpm_verify.cpu_limit import run_limited
from qsmpm_verify.fields import scalar_field
from qsmpm_verify.flow_net import draw_net
from qsmpm_verify.places import PROGRAM
from qsmpm_verify.results import Array, read_mesh, read_points

BANK = """*MODEL, TYPE=PLANE STRAIN
*GRID
X, 0, 6, 12
Y, 0, 3, 6
*NSET, NSET=base, PLANE=Y
0
*NSET, NSET=left, PLANE=X
0
*NSET, NSET=right, PLANE=X
6
*MATERIAL, NAME=soil
*ELASTIC
1000, 0.3
*UNIT WEIGHT
18, 20
*PERMEABILITY
1
*BODY, NAME=ground, MATERIAL=soil, SHAPE=BOX
0, 6, 0, 3
*PHASE, NAME=flow
*FIX
base, ALL
left, X
right, X
*GRAVITY
0, -1
*WATER LEVEL, TYPE=SEEPAGE, UNIT WEIGHT=10
left, 2
right, 1
*END PHASE
"""
X, Y = np.meshgrid(np.linspace(0.0, 4.0, 41), np.linspace(0.0, 2.0, 21))
PLACE = np.stack([X.ravel(), Y.ravel()], axis=1)
HEAD = 5.0 - PLACE[:, 0]


class FlowNets(unittest.TestCase):
    def drawn(self, head: Array, flow: Array) -> tuple[list[Array], list[Array]]:
        """Lines of equal head, lines of flow."""
        figure, axes = plt.subplots()
        self.addCleanup(plt.close, figure)
        draw_net(axes, PLACE, head, flow)
        lines = [c for c in axes.collections if isinstance(c, LineCollection)]
        heads = [c for c in axes.collections if c not in lines]
        return ([path.vertices for c in heads for path in c.get_paths() if len(path.vertices)],
                [piece for c in lines for piece in c.get_segments()])  # fmt: skip

    def test_even_flow_runs_across_lines_of_equal_head(self) -> None:
        flow = np.tile([2.0, 0.0], (len(PLACE), 1))
        flow[PLACE[:, 1] > 1.05] = np.nan
        heads, lines = self.drawn(HEAD, flow)
        for line in heads:
            self.assertLess(np.ptp(line[:, 0]), 1e-6)
        self.assertGreater(len(heads), 5)
        for line in lines:
            self.assertLess(np.ptp(line[:, 1]), 1e-6)
        self.assertGreater(max(line[:, 0].max() for line in lines), 3.8)
        # Below the water alone.
        self.assertLess(max(line[:, 1].max() for line in [*heads, *lines]), 1.15)
        self.assertGreater(max(line[:, 1].max() for line in heads), 0.95)

    def test_no_line_goes_where_next_to_nothing_flows(self) -> None:
        flow = np.tile([2.0, 0.0], (len(PLACE), 1))
        flow[PLACE[:, 0] > 2.0] = [0.01, 0.0]
        self.assertLess(max(line[:, 0].max() for line in self.drawn(HEAD, flow)[1]), 2.2)

    def test_water_at_rest_and_dry_ground_have_no_net(self) -> None:
        still = np.zeros_like(PLACE)
        for head, flow in ((HEAD, still), (HEAD, still + np.nan), (np.full(len(PLACE), 3.0), still + 1.0)):
            self.assertEqual(self.drawn(head, flow), ([], []))

    @unittest.skipUnless(PROGRAM.is_file(), "the program is not built")
    def test_the_picture_of_heads_has_the_flow_where_there_is_water(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "bank.inp").write_text(BANK)
            self.assertEqual(run_limited([PROGRAM, "run", "bank.inp", "--out", "out", "--quiet"], 30, Path(folder)).code, 0)
            points, mesh = read_points(Path(folder) / "out"), read_mesh(Path(folder) / "out")
            flow = body_of(points, scalar_field(points, "head"), mesh).flow
            self.assertIsNone(body_of(points, scalar_field(points, "displacement"), mesh).flow)
        assert flow is not None
        dry = points.field("position")[:, 1] > 2.6
        self.assertTrue(np.isnan(flow[dry]).all())
        self.assertTrue((flow[points.field("position")[:, 1] < 1.0, 0] > 0.0).all())


if __name__ == "__main__":
    unittest.main()
