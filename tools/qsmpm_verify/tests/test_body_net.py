"""The net of a plane body: it fills the body to its outline, moves with it, and bridges nothing."""

from __future__ import annotations

import tempfile
import unittest
from pathlib import Path

import numpy as np

from qsmpm_verify.body_net import Net, net_of, nets_of
from qsmpm_verify.outlines import NOTHING, Outline, outline_of, snapped
from qsmpm_verify.results import Array, Mesh


def lattice(columns: int, rows: int, dx: float = 1.0, dy: float = 1.0) -> Array:
    """Points in the middles of cells dx by dy."""
    x, y = np.meshgrid((np.arange(columns) + 0.5) * dx, (np.arange(rows) + 0.5) * dy)
    return np.stack([x.ravel(), y.ravel()], axis=1)


def area(net: Net) -> float:
    """Area of the triangles where they are now, those turned over counted off."""
    a, b, c = (net.now[net.triangles[:, i]] for i in range(3))
    return float(0.5 * np.sum(np.linalg.det(np.stack([b - a, c - a], axis=1))))


def segments_of(corners: Array) -> Array:
    """Sides of a polygon."""
    return np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)


class TestNet(unittest.TestCase):
    """Nets of lattices."""

    def made(self, start: Array, place: Array, outline: Outline = NOTHING) -> Net:
        net = net_of(start, place, outline)
        assert net is not None
        return net

    def test_it_fills_a_block_to_its_sides_without_being_told_of_them(self) -> None:
        net = self.made(lattice(6, 4), lattice(6, 4))
        self.assertAlmostEqual(area(net), 24.0, places=9)
        np.testing.assert_allclose([net.now.min(axis=0), net.now.max(axis=0)], [[0, 0], [6, 4]], atol=1e-12)

    def test_points_further_apart_one_way_are_no_gap_inside_a_known_outline(self) -> None:
        start = lattice(8, 4, 1.0, 3.5)
        corners = np.array([[0, 0], [8, 0], [8, 14], [0, 14.0]])
        net = self.made(start, start, Outline((corners,)))
        self.assertAlmostEqual(area(net), 112.0, places=6)

    def test_soil_that_slides_over_the_base_of_its_mesh_is_drawn_down_to_it_and_no_further(self) -> None:
        start, corners = lattice(8, 4), np.array([[0, 0], [8, 0], [8, 4], [0, 4.0]])
        place = start + np.array([0.0, 1.0]) * np.where(start[:, 1:] < 1, 0.45 * np.sin(start[:, :1] * np.pi / 4), 0.0)
        sides = np.array([[0, 0], [12, 7.0]])
        free, held = self.made(start, place, Outline((corners,))), self.made(start, place, Outline((corners,), sides=sides))
        base = free.before[:, 1] < 1e-9
        self.assertTrue(free.now[base, 1].max() > 0.3 and free.now[base, 1].min() < -0.1, "without it the rim goes with the points")
        np.testing.assert_array_equal(held.now[base, 1], 0.0)
        np.testing.assert_allclose(held.now[~base & (held.before[:, 0] > 0)], free.now[~base & (free.before[:, 0] > 0)], atol=1e-12)
        up = self.made(start, start + [0.0, 1.2], Outline((corners,), sides=sides))
        self.assertAlmostEqual(float(up.now[:, 1].min()), 1.2, places=9)

    def test_it_turns_with_the_body(self) -> None:
        start = lattice(5, 5)
        turn = np.array([[0.6, -0.8], [0.8, 0.6]])
        still, moved = self.made(start, start), self.made(start, start @ turn.T)
        np.testing.assert_allclose(moved.now, still.now @ turn.T, atol=1e-12)

    def test_a_slanted_side_is_straight_where_the_outline_is_known(self) -> None:
        corners = np.array([[0, 0], [10, 0], [0, 10.0]])
        start = np.array([p for p in lattice(10, 10) if p.sum() < 9.6])
        net = self.made(start, start, Outline((corners,)))
        self.assertAlmostEqual(area(net), 50.0, delta=0.2)
        rim = net.now[np.unique(net.outline)]
        self.assertLess(np.max(rim.sum(axis=1)), 10 + 1e-9)
        for corner in corners:
            self.assertLess(np.min(np.linalg.norm(rim - corner, axis=1)), 1e-12)

    def test_no_triangle_lies_across_a_re_entrant_corner(self) -> None:
        corners = np.array([[0, 0], [8, 0], [8, 4], [4, 4], [4, 8], [0, 8.0]])
        start = np.array([p for p in lattice(24, 24, 1 / 3, 1 / 3) if min(p) < 4])
        net = self.made(start, start, Outline((corners,)))
        middles = net.now[net.triangles].mean(axis=1)
        a, b, c = (net.now[net.triangles[:, i]] for i in range(3))
        areas = 0.5 * np.abs(np.linalg.det(np.stack([b - a, c - a], axis=1)))
        self.assertEqual(np.sum(areas[middles.min(axis=1) > 4.001]), 0.0)
        self.assertAlmostEqual(float(areas.sum()), 48.0, delta=0.01)

    def test_two_bodies_and_a_hole_are_not_bridged(self) -> None:
        left = lattice(4, 4)
        pair = np.concatenate([left, left + [7.0, 0.0]])
        self.assertAlmostEqual(area(self.made(pair, pair)), 32.0, places=9)
        holed = np.array([p for p in lattice(9, 9) if max(abs(p - 4.5)) > 1.6])
        self.assertAlmostEqual(area(self.made(holed, holed)), 72.0, delta=1.0)

    def test_what_is_torn_apart_is_not_bridged(self) -> None:
        start = lattice(8, 4)
        torn = start + np.where(start[:, :1] > 4, [[10.0, 0.0]], [[0.0, 0.0]])
        net = self.made(start, torn)
        self.assertAlmostEqual(area(net), 32.0, delta=1e-6)
        middle = net.now[net.triangles].mean(axis=1)
        self.assertFalse(np.any((middle[:, 0] > 5) & (middle[:, 0] < 13)))

    def test_a_slip_surface_stays_filled(self) -> None:
        start = lattice(12, 6)
        slid = start + np.where(start[:, 1:] > 3, [[4.0, 0.0]], [[0.0, 0.0]])
        net = self.made(start, slid)
        inside = np.abs(net.now[net.triangles].mean(axis=1)[:, 1] - 3.0) < 0.2
        self.assertGreater(int(inside.sum()), 10)

    def test_what_was_dug_out_is_not_filled(self) -> None:
        ground = np.array([[0, 0], [12, 0], [12, 4], [8, 4], [8, 8], [4, 8], [4, 4], [0, 4.0]])
        pit = np.array([[8, 4], [12, 4], [12, 8], [8, 8.0]])
        start = np.array([p for p in lattice(24, 16, 0.5, 0.5) if p[1] < 4 or 4 < p[0] < 8])
        net = self.made(start, start, Outline((ground, pit)))
        self.assertAlmostEqual(area(net), 64.0, delta=1.0)

    def test_soil_does_not_reach_through_a_thin_wall_of_another_material(self) -> None:
        start = lattice(20, 8, 0.5, 0.5)
        wall = (start[:, 0] > 4) & (start[:, 0] < 5)
        left, right = np.array([[0, 0], [4, 0], [4, 4], [0, 4.0]]), np.array([[5, 0], [10, 0], [10, 4], [5, 4.0]])
        middle = np.array([[4, 0], [5, 0], [5, 4], [4, 4.0]])
        nets = nets_of(start, start, wall.astype(int), Outline((left, middle, right)))
        self.assertAlmostEqual(sum(area(net) for net, _ in nets), 40.0, delta=0.1)

    def test_a_lift_in_settled_ground_is_drawn_where_it_is(self) -> None:
        ground, lift = lattice(12, 6), lattice(12, 3) + [0.0, 5.0]
        place = np.concatenate([ground * [1.0, 5.0 / 6.0], lift])
        start = np.concatenate([ground, lift])
        nets = nets_of(start, place, np.zeros(len(start)), NOTHING)
        self.assertAlmostEqual(sum(area(net) for net, _ in nets), 96.0, delta=2.0)

    def test_materials_have_nets_of_their_own_and_few_points_none(self) -> None:
        start = lattice(4, 4)
        kinds = (start[:, 0] > 2).astype(int)
        self.assertEqual([len(m) for _, m in nets_of(start, start, kinds, NOTHING)], [8, 8])
        self.assertIsNone(net_of(start[:2], start[:2], NOTHING))
        self.assertIsNone(net_of(start[:4], start[:4], NOTHING), "points of one line span no area")


class TestOutlines(unittest.TestCase):
    """What the deck and the mesh tell of the bodies."""

    mesh = Mesh(
        np.array([[x, y, 0.0] for y in range(2) for x in range(4)]),
        [np.array([i, i + 1, i + 5, i + 4]) for i in range(3)], np.array([9, 9, 9]),
    )  # fmt: skip

    def told(self, body: str) -> Outline:
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "a.echo.inp").write_text(f"*HEADING\nx\n{body}")
            return outline_of(Path(folder), self.mesh, np.array([[0.5, 0.5], [1.5, 0.5]]))

    def test_shapes_of_the_deck(self) -> None:
        box = self.told("*BODY, NAME=a, MATERIAL=m, SHAPE=BOX\n0, 2, 0, 1d0\n")
        self.assertEqual((len(box.segments), list(box.inside(np.array([[1, 0.5], [2.5, 0.5]])))), (4, [True, False]))
        self.assertEqual(len(self.told("*BODY, NAME=a, MATERIAL=m, SHAPE=POLYGON\n0, 0\n2, 0\n0, 1\n").segments), 3)

    def test_cells_with_points_where_the_deck_names_no_shape(self) -> None:
        cells = self.told("*BODY, NAME=a, MATERIAL=m, SHAPE=ALL\n")
        self.assertEqual(len(cells.segments), 6)
        self.assertEqual(list(cells.inside(np.array([[1.9, 0.5], [2.5, 0.5], [9.0, 9.0]]))), [True, False, False])

    def test_places_go_to_the_outline_within_their_reach_and_one_into_each_corner(self) -> None:
        corners = np.array([[0, 0], [4, 0], [4, 4], [0, 4.0]])
        places = np.array([[2.0, 0.3], [3.8, 0.4], [2.0, 1.5]])
        moved = snapped(places, np.array([0.5, 0.5, 0.5]), segments_of(corners))
        np.testing.assert_allclose(moved, [[2, 0], [4, 0.0], [2, 1.5]], atol=1e-12)


if __name__ == "__main__":
    unittest.main()
