"""The net of a plane body: it fills the body to its outline, moves with it, and bridges nothing."""

from __future__ import annotations

import tempfile
import unittest
from pathlib import Path

import numpy as np

from qsmpm_verify.body_net import Net, net_of, nets_of
from qsmpm_verify.cells import cells_of
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


def quads(xs: Array, ys: Array) -> Mesh:
    """Cells between columns and rows."""
    n = len(xs)
    nodes = np.array([[x, y, 0.0] for y in ys for x in xs])
    cells = [np.array([k, k + 1, k + n + 1, k + n]) for j in range(len(ys) - 1) for k in range(j * n, j * n + n - 1)]
    return Mesh(nodes, cells, np.full(len(cells), 9))


def points_of(xs: Array, ys: Array, *corners: Array) -> Array:
    """Two by two points in each cell, those in polygons."""
    x, y = (np.sort(np.concatenate([0.75 * v[:-1] + 0.25 * v[1:], 0.25 * v[:-1] + 0.75 * v[1:]])) for v in (xs, ys))
    start = np.stack([v.ravel() for v in np.meshgrid(x, y)], axis=1)
    return start[Outline(corners).inside(start)]


class TestCells(unittest.TestCase):
    """Bodies in cells that are long one way, which guide what is near."""

    def made(self, xs: Array, ys: Array, start: Array, *corners: Array, place: Array | None = None) -> Net:
        cells = cells_of(quads(xs, ys))
        assert cells is not None
        filled = np.isin(np.arange(len(cells.corners)), cells.at(start))
        net = net_of(start, start if place is None else place, Outline(corners, cells=cells, filled=filled))
        assert net is not None
        return net

    def check(self, net: Net, size: float, around: float) -> None:
        """Area and length of the outline."""
        ends = net.now[net.outline]
        self.assertAlmostEqual(area(net) / size, 1.0, delta=2e-3)
        self.assertAlmostEqual(float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum()) / around, 1.0, delta=4e-3)

    def test_a_block_in_cells_up_to_20_times_as_long_as_high_is_whole(self) -> None:
        xs, ys = np.cumsum(np.concatenate([[0.0], np.geomspace(0.1, 2.0, 16)])), np.linspace(0, 3, 31)
        start = points_of(xs, ys, box := np.array([[0, 0], [xs[-1], 0], [xs[-1], 3], [0, 3.0]]))
        for outline in ((box,), ()):
            self.check(self.made(xs, ys, start, *outline), 3 * xs[-1], 2 * (3 + xs[-1]))
            self.check(self.made(ys, xs, start[:, ::-1], *(c[:, ::-1] for c in outline)), 3 * xs[-1], 2 * (3 + xs[-1]))

    def test_starts_that_have_moved_in_long_cells_have_no_gaps(self) -> None:
        xs, ys = np.linspace(0, 20, 11), np.linspace(0, 3, 31)
        start = points_of(xs, ys, box := np.array([[0, 0], [20, 0], [20, 3], [0, 3.0]]))
        inner = (np.abs(start - [10, 1.5]) < [9, 1.4]).all(axis=1)[:, None]
        moved = start + inner * np.random.default_rng(2).uniform(-0.02, 0.02, start.shape)
        self.check(self.made(xs, ys, moved, box), 60.0, 46.0)

    def test_long_cells_that_lean_guide_as_well(self) -> None:
        lean, ys = np.array([[1, 0.1], [0, 1]]), np.linspace(0, 3, 31)
        for xs in (np.linspace(0, 20, 11), np.cumsum(np.concatenate([[0.0], np.geomspace(0.1, 1.0, 20)]))):
            start = points_of(xs, ys, box := np.array([[0, 0], [xs[-1], 0], [xs[-1], 3], [0, 3.0]]))
            inner = (np.abs(start - [0.5 * xs[-1], 1.5]) < [0.4 * xs[-1], 1.3]).all(axis=1)[:, None]
            start = (start + inner * np.random.default_rng(2).uniform(-0.01, 0.01, start.shape)) @ lean.T
            mesh = quads(xs, ys)
            mesh.nodes[:, :2] = mesh.nodes[:, :2] @ lean.T
            net = net_of(start, start, Outline((box @ lean.T,), cells=cells_of(mesh), filled=np.ones(len(mesh.cells), dtype=bool)))
            assert net is not None
            self.check(net, 3 * xs[-1], 2 * (xs[-1] + np.hypot(3, 0.3)))

    def test_a_slope_in_long_cells_is_filled_to_its_face(self) -> None:
        slope = np.array([[0, 0], [30, 0], [30, 4], [18, 4], [8, 11], [0, 11.0]])
        xs, ys = np.linspace(0, 30, 16), np.linspace(0, 12, 101)
        self.check(self.made(xs, ys, points_of(xs, ys, slope), slope), 211.0, 30 + 4 + 12 + np.hypot(10, 7) + 8 + 11)

    def test_a_cut_of_narrow_cells_beside_long_ones_stays_open(self) -> None:
        ground = np.array([[0, 0], [30, 0], [30, 9], [10.5, 9], [10.5, 6], [10, 6], [10, 9], [0, 9.0]])
        pit = np.array([[10, 6], [10.5, 6], [10.5, 9], [10, 9.0]])
        xs, ys = np.concatenate([np.linspace(0, 10, 5), np.linspace(10.125, 12, 16), np.linspace(15, 30, 6)]), np.linspace(0, 10, 81)
        net = self.made(xs, ys, points_of(xs, ys, ground), ground, pit)
        self.check(net, 268.5, 84.0)
        middles = net.now[net.triangles].mean(axis=1)
        self.assertFalse(np.any((np.abs(middles - [10.25, 7.5]) < [0.2, 1.3]).all(axis=1)))

    def test_two_bodies_in_one_long_cell_are_not_bridged(self) -> None:
        left, right = np.array([[0, 0], [17.2, 0], [17.2, 5], [0, 5.0]]), np.array([[17.8, 0], [40, 0], [40, 5], [17.8, 5.0]])
        xs, ys = np.linspace(0, 40, 11), np.linspace(0, 6, 31)
        net = self.made(xs, ys, points_of(xs, ys, left, right), left, right)
        ends = net.now[net.triangles][..., 0]
        self.assertFalse(np.any((ends.min(axis=1) < 17.3) & (ends.max(axis=1) > 17.7)))

    def test_materials_whose_shapes_are_cells_are_not_bridged_over_a_wall(self) -> None:
        xs, ys = np.linspace(0, 9, 10), np.linspace(0, 4, 5)
        start = points_of(xs, ys, np.array([[0, 0], [9, 0], [9, 4], [0, 4.0]]))
        cells = cells_of(quads(xs, ys))
        wall = (np.abs(start[:, 0] - 4.5) < 0.5).astype(int)
        nets = nets_of(start, start, wall, Outline(cells=cells, filled=np.ones(36, dtype=bool), of_cells=True))
        self.assertAlmostEqual(sum(area(net) for net, _ in nets), 36.0, delta=0.1)

    def test_a_body_torn_in_long_cells_is_not_bridged(self) -> None:
        xs, ys = np.linspace(0, 20, 11), np.linspace(0, 3, 31)
        start = points_of(xs, ys, box := np.array([[0, 0], [20, 0], [20, 3], [0, 3.0]]))
        net = self.made(xs, ys, start, box, place=start + np.where(start[:, :1] > 10, [[4.0, 0]], [[0, 0.0]]))
        self.check(net, 60.0, 52.0)

    def test_cells_tell_where_a_place_is_and_count_in_columns_and_rows(self) -> None:
        mesh = quads(np.array([0, 1, 5.0]), np.array([0, 2, 3.0]))
        halves = [np.delete(c, k) for c in mesh.cells for k in (3, 1)]
        places = np.array([[0.5, 1.0], [3.0, 2.5], [7.0, 1.0], [-1.0, 4.0]])
        for found, count in ((cells_of(mesh), 4), (cells_of(Mesh(mesh.nodes, halves, np.full(8, 5))), 8)):
            assert found is not None
            self.assertEqual(((found.at(places) < 0).tolist(), len(found.corners)), ([False, False, True, True], count))
            np.testing.assert_allclose(found.even(places), [[0.5, 0.5], [1.5, 1.5], [2.5, 0.5], [-1.0, 3.0]])
            np.testing.assert_allclose(found.extents_at(places)[:3], [[1, 2], [4, 1], [4, 2]])
        leaning = mesh.nodes + 0.1 * mesh.nodes[:, [1, 0, 2]]
        turned = cells_of(Mesh(leaning, mesh.cells, mesh.types))
        assert turned is not None
        np.testing.assert_allclose(turned.even(places), places)
        self.assertIsNone(cells_of(Mesh(mesh.nodes, mesh.cells, np.full(4, 12))))


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
        moved = snapped(places, np.full((3, 2), 0.5), Outline((corners,)), np.array([0, 0, -1]))
        np.testing.assert_allclose(moved, [[2, 0], [4, 0.0], [2, 1.5]], atol=1e-12)
        wide = snapped(np.array([[3.2, 2.0], [2.0, 3.2]]), np.tile([1.0, 0.4], (2, 1)), Outline((corners,)), np.array([0, 0]))
        np.testing.assert_allclose(wide, [[4, 2], [2, 3.2]], atol=1e-12)


if __name__ == "__main__":
    unittest.main()
