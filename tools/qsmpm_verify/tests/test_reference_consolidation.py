"""Consolidation against finite differences in place and time."""

import unittest

import numpy as np

from qsmpm_verify.reference import consolidation as ref

CELLS, STEPS = 400, 4000


class Layer(unittest.TestCase):
    """One dimension."""

    def test_against_differences(self) -> None:
        """Implicit differences from full pressure, p = 0 at the top, no flow at the base."""
        end, h = 0.3, 1 / CELLS
        r = end / STEPS / h**2
        matrix = np.eye(CELLS) * (1 + 2 * r) - r * np.eye(CELLS, k=1) - r * np.eye(CELLS, k=-1)
        matrix[-1, -1] = 1 + r
        matrix[0, 0] = 1 + 3 * r
        inverse = np.linalg.inv(matrix)
        p = np.ones(CELLS)
        for _ in range(STEPS):
            p = inverse @ p
        self.assertAlmostEqual(ref.layer_settlement(end), 1 - p.mean(), delta=2e-4)
        self.assertAlmostEqual(ref.layer_pressure(end), p[-1], delta=2e-4)
        self.assertAlmostEqual(ref.layer_pressure(end, 0.5), (p[CELLS // 2] + p[CELLS // 2 - 1]) / 2, delta=2e-4)

    def test_ends(self) -> None:
        """Nothing has settled at first, all in the end."""
        self.assertAlmostEqual(ref.layer_settlement(1e-6), 2 * (1e-6 / np.pi) ** 0.5, delta=1e-4)
        self.assertAlmostEqual(ref.layer_settlement(5.0), 1.0, delta=1e-5)

    def test_ramp(self) -> None:
        """The mean of loads that came one after the other."""
        rise = 0.004
        for end in (0.004, 0.01):
            parts = [ref.layer_settlement(end - rise * (i + 0.5) / 2000) for i in range(2000)]
            self.assertAlmostEqual(ref.ramped_layer_settlement(end, rise), sum(parts) / 2000, delta=1e-5)
        self.assertAlmostEqual(ref.ramped_layer_settlement(0.001, 0.002), 0.5 * ref.ramped_layer_settlement(0.001, 0.001))


class TwoLayers(unittest.TestCase):
    """Soil below a more permeable layer."""

    def test_one_soil(self) -> None:
        """One layer, wherever it is cut."""
        for share in (0.0, 0.3, 1.0):
            self.assertAlmostEqual(ref.two_layer_settlement(0.2, 1.0, share), ref.layer_settlement(0.2), delta=1e-9)

    def test_differences(self) -> None:
        """Implicit differences, cells of one soil each, what flows between cells by both of their halves."""
        end, cells, steps, contrast = 0.02, 400, 4000, 50.0
        soil = np.where((np.arange(cells) + 0.5) / cells < 0.25, contrast, 1.0)
        between = 2 / (1 / soil[1:] + 1 / soil[:-1])
        flow = np.diag(np.append(between, 0.0)) + np.diag(np.append(2 * soil[0], between))
        flow -= np.diag(between, 1) + np.diag(between, -1)
        inverse = np.linalg.inv(np.eye(cells) + flow * cells**2 * end / steps)
        p = np.ones(cells)
        for _ in range(steps):
            p = inverse @ p
        self.assertAlmostEqual(ref.two_layer_settlement(end, contrast, 0.25), 1 - p.mean(), delta=3e-4)

    def test_much(self) -> None:
        """Sand that holds no pressure: the clay drains alone."""
        alone = 0.5 + 0.5 * ref.layer_settlement(0.06 / 0.25)
        self.assertAlmostEqual(ref.two_layer_settlement(0.06, 1e12), alone, delta=1e-5)


class ThickLayer(unittest.TestCase):
    """Large strains."""

    def test_closed_form(self) -> None:
        """Xie and Leo 2004: p/M = ln(1 + (exp(P/M) - 1) sum 2/m sin(m z) exp(-m^2 T)), m = (2 k + 1) pi/2."""
        load, time = 0.4, 0.3
        m = (2 * np.arange(200) + 1) * np.pi / 2
        z = (np.arange(2000) + 0.5) / 2000
        p = np.log(1 + (np.exp(load) - 1) * np.sum(2 / m[:, None] * np.sin(np.outer(m, z)) * np.exp(-(m[:, None] ** 2) * time), axis=0))
        settled = 1 - np.mean(np.exp(p - load))
        self.assertAlmostEqual(ref.thick_layer_settlement(time, load, power=2.0, cauchy=True), settled, delta=5e-4 * settled)

    def test_small_load(self) -> None:
        """Terzaghi's layer, whatever the law."""
        for void_ratio, index in ((0.0, 0.0), (1.8, 0.0), (1.8, 0.9)):
            found = ref.thick_layer_settlement(0.3, 1e-4, void_ratio, index) / 1e-4
            self.assertAlmostEqual(found, ref.layer_settlement(0.3), delta=2e-3)

    def test_permeability(self) -> None:
        """By hand: e = 1.1 of 1.8 at three quarters of the volume."""
        self.assertAlmostEqual(ref.permeability_ratio(0.75, 1.8, 0.7), 0.1)
        self.assertAlmostEqual(ref.permeability_ratio(0.75, 1.8), (1.1 / 1.8) ** 3 * 2.8 / 2.1)


class Round(unittest.TestCase):
    """The effect of Mandel and Cryer: the pressure in the middle rises before it falls."""

    def test_against_differences(self) -> None:
        """The cylinder, and the ball."""
        for power, pressure in ((1, ref.cylinder_pressure), (2, ref.ball_pressure)):
            middle, half = self.differences(power, 0.2, 0.1)
            self.assertAlmostEqual(pressure(0.1, 0.2), middle, delta=2e-3)
            self.assertAlmostEqual(pressure(0.1, 0.2, 0.5), half, delta=2e-3)

    @staticmethod
    def differences(power: int, poisson: float, end: float) -> tuple[float, float]:
        """M e = p + f with f from the equilibrium of the rim; e changes by what flows in through areas r^power."""
        steps = 2000
        shear = (1 - 2 * poisson) / (1 - poisson)
        n = 200
        h = 1 / n
        r = (np.arange(n) + 0.5) * h
        flow = np.zeros((n, n))
        for i in range(n):
            volume = r[i] ** power * h**2
            if i > 0:
                flow[i, i - 1] += (i * h) ** power / volume
                flow[i, i] -= (i * h) ** power / volume
            if i < n - 1:
                flow[i, i + 1] += ((i + 1) * h) ** power / volume
                flow[i, i] -= ((i + 1) * h) ** power / volume
            else:
                flow[i, i] -= 2 * 1.0 / volume
        # unknowns p (n) and f: e = p + f (times 1/M); rim: f - 2 power G/M int e r^power dr = -1
        dt = end / steps
        matrix = np.zeros((n + 1, n + 1))
        matrix[:n, :n] = np.eye(n) - dt * flow
        matrix[:n, n] = 1.0
        matrix[n, :n] = -power * shear * r**power * h
        matrix[n, n] = 1.0 - power * shear / (power + 1)
        inverse = np.linalg.inv(matrix)
        e = np.zeros(n)
        for _ in range(steps):
            x = inverse @ np.append(e, -1.0)
            e = x[:n] + x[n]
        return x[0], (x[n // 2] + x[n // 2 - 1]) / 2

    def test_the_middle_rises(self) -> None:
        """It begins at the load, and rises above it."""
        self.assertAlmostEqual(ref.cylinder_pressure(0.002, 0.0), 1.0, delta=0.1)
        self.assertGreater(ref.cylinder_pressure(0.08, 0.0), 1.15)
        self.assertGreater(ref.ball_pressure(0.05, 0.0), 1.4)
        self.assertAlmostEqual(ref.cylinder_pressure(0.3, 0.0, 1.0), 0.0, delta=1e-9)

    def test_column_that_empties(self) -> None:
        self.assertAlmostEqual(ref.emptying_column(0.05, 0.1, 2000, 0.1, outflow=True), 0.05, delta=2e-4)
        self.assertAlmostEqual(ref.emptying_column(0.2, 0.1, 2000, 0.1, outflow=True), 0.1, delta=1.5e-3)
        self.assertAlmostEqual(ref.emptying_column(0.02, 0.005, 200, 0.1), 0.9 / 400, delta=1e-6)
        # Stiff ground, half empty: the whole weight below the surface, less what is lost above it.
        self.assertAlmostEqual(ref.emptying_column(0.05, 0.1, 2000, 0.1), (0.5 - 0.0375) / 2000, delta=1e-6)


if __name__ == "__main__":
    unittest.main()
