"""The references against independent computations and printed figures."""

import math
import unittest

from qsmpm_verify import reference as ref


def integrate_oedometer(strain: float, substeps: int, modulus: float = 1.0) -> float:
    """d sigma = (M - sigma) d lambda / lambda (tension positive) by Runge-Kutta 4; compression out."""
    lam, sigma, h = 1.0, 0.0, -strain / substeps

    def rate(length: float, stress: float) -> float:
        return (modulus - stress) / length

    for _ in range(substeps):
        k1 = rate(lam, sigma)
        k2 = rate(lam + h / 2, sigma + h / 2 * k1)
        k3 = rate(lam + h / 2, sigma + h / 2 * k2)
        k4 = rate(lam + h, sigma + h * k3)
        sigma += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        lam += h
    return -sigma


def column_by_quadrature(stretch, height: float, cells: int = 20000) -> float:
    """Height of a column from its stretch at reference height X, midpoint rule."""
    h = height / cells
    return sum(stretch((i + 0.5) * h) for i in range(cells)) * h


class Oedometer(unittest.TestCase):
    def test_van_langen_is_the_integral_of_the_rate_law(self):
        for strain in (0.1, 0.5, 0.9):
            self.assertAlmostEqual(ref.van_langen(strain) / integrate_oedometer(strain, 4000), 1, 9)

    def test_van_langen_is_the_papers_exponential(self):
        for strain in (0.1, 0.5, 0.9):
            logarithmic = -math.log(1 - strain)
            self.assertAlmostEqual(ref.van_langen(strain, 3.0), 3 * (math.exp(logarithmic) - 1), 12)

    def test_first_order_steps_match_a_step_by_step_update(self):
        for steps in (10, 100):
            lam, sigma, d = 1.0, 0.0, 0.9 / steps
            for _ in range(steps):
                sigma += (1 - sigma) * (-d / lam)
                lam -= d
            self.assertAlmostEqual(ref.van_langen_paper_steps(0.9, steps), -sigma, 10)

    def test_first_order_steps_printed_figures(self):
        self.assertAlmostEqual(ref.van_langen_paper_steps(0.9, 10), 4.73684, 5)
        self.assertAlmostEqual(ref.van_langen_paper_steps(0.9, 100), 8.25688, 5)

    def test_hencky_is_another_law(self):
        self.assertAlmostEqual(ref.hencky_oedometer(0.5), 1.38629, 5)
        self.assertAlmostEqual(ref.hencky_oedometer(0.9), 23.0259, 4)

    def test_constrained_modulus(self):
        self.assertAlmostEqual(ref.constrained_modulus(1, 0.33), 1.48165, 5)
        self.assertAlmostEqual(ref.constrained_modulus(7, 0), 7, 14)


class Column(unittest.TestCase):
    def test_lambert_w_inverts(self):
        for x in (-0.3, -0.1, 0.0, 1e-8, 0.5, 4.0, 1e6):
            w = ref.lambert_w(x)
            self.assertAlmostEqual(w * math.exp(w), x, delta=1e-14 * (1 + abs(x)))
        self.assertRaises(ValueError, ref.lambert_w, -1)

    def test_hencky_height(self):
        self.assertAlmostEqual(ref.column_height_hencky(50, 10, 0.8), 24.059646, 6)
        own = column_by_quadrature(lambda x: math.exp(-ref.lambert_w(0.8 * (50 - x) / 10)), 50, 4000)
        self.assertAlmostEqual(ref.column_height_hencky(50, 10, 0.8), own, 5)

    def test_rate_height(self):
        self.assertAlmostEqual(ref.column_height_rate(50, 10, 0.8), 20.117974, 6)
        own = column_by_quadrature(lambda x: 1 / (1 + 0.8 * (50 - x) / 10), 50)
        self.assertAlmostEqual(ref.column_height_rate(50, 10, 0.8), own, 6)

    def test_first_order_gravity_steps(self):
        for steps, height in ((10, 17.994696), (40, 19.615190), (100, 19.918959), (1000, 20.098196)):
            self.assertAlmostEqual(ref.column_height_paper_steps(50, 10, 0.8, steps), height, 6)

    def test_first_order_gravity_steps_by_stepping(self):
        def stretch(x: float) -> float:
            lam, sigma, weight = 1.0, 0.0, 0.08 * (50 - x)
            for step in range(10):
                target = -weight * (step + 1) / 10
                lam *= 1 + (target - sigma) / (1 - sigma)
                sigma = target
            return lam

        self.assertAlmostEqual(
            ref.column_height_paper_steps(50, 10, 0.8, 10), column_by_quadrature(stretch, 50), 5
        )

    def test_one_step_is_the_limit_of_the_formula(self):
        # one step: stretch 1 - q, whose integral over 5 m with q = 0.08 (5 - X) is 5 - 0.04 * 25
        self.assertAlmostEqual(ref.column_height_paper_steps(5, 10, 0.8, 1), 4.0, 12)

    def test_base_stress(self):
        self.assertAlmostEqual(ref.column_base_stress(50, 0.8), 40, 12)


class Cantilever(unittest.TestCase):
    def test_elastica_of_mattiasson(self):
        for k, u, w in (
            (0.5, 0.01592, 0.16214),
            (1, 0.05643, 0.30172),
            (2, 0.16064, 0.49346),
            (5, 0.38763, 0.71379),
            (10, 0.55500, 0.81061),
        ):
            shortening, deflection = ref.cantilever_tip(k)
            self.assertAlmostEqual(shortening, u, 5)
            self.assertAlmostEqual(deflection, w, 5)

    def test_small_load_is_beam_theory(self):
        self.assertAlmostEqual(ref.cantilever_tip(1e-4)[1], 1e-4 / 3, 11)
        self.assertAlmostEqual(ref.cantilever_tip(1e-4, shear=0.5)[1], 1e-4 * (1 / 3 + 0.5), 10)

    def test_amples_beam(self):
        beam = dict(force=100.0, length=10.0, depth=1.0, young=12000.0, poisson=0.2)
        self.assertAlmostEqual(ref.beam_deflection(**beam), 8.1754, 4)
        self.assertAlmostEqual(ref.beam_shortening(**beam), 5.4804, 4)
        self.assertAlmostEqual(ref.beam_deflection(**beam, elastica=True), 8.0624, 4)
        self.assertAlmostEqual(ref.beam_shortening(**beam, elastica=True), 5.4613, 4)


class Failure(unittest.TestCase):
    def test_prandtl(self):
        self.assertAlmostEqual(ref.prandtl_footing(), 5.141593, 6)

    def test_log_spiral(self):
        """A coarse search over toe spirals finds the printed optimum from above."""

        def critical(phi: float, c: float) -> float:
            t, best, beta = math.tan(phi), math.inf, math.pi / 4
            for i in range(1, 120):
                start = math.radians(i * 0.75)
                for j in range(1, 120):
                    end = start + math.radians(j * 0.75)
                    if end >= math.pi - phi / 2:
                        break
                    g = math.exp((end - start) * t)
                    rise = math.sin(end) * g - math.sin(start)
                    if rise <= 1e-6:
                        continue
                    top = (math.cos(start) - math.cos(end) * g) - rise / math.tan(beta)
                    if top <= 1e-9:
                        continue
                    f1 = (
                        (3 * t * math.cos(end) + math.sin(end)) * g**3
                        - 3 * t * math.cos(start)
                        - math.sin(start)
                    ) / (3 * (1 + 9 * t * t))
                    f2 = top * (2 * math.cos(start) - top) * math.sin(start) / 6
                    f3 = (
                        g / 6 * (math.sin(end - start) - top * math.sin(end))
                        * (math.cos(start) - top + math.cos(end) * g)
                    )
                    weight = f1 - f2 - f3
                    if weight > 1e-9:
                        best = min(best, c * (g * g - 1) / (2 * t) / weight * rise)
            return best

        phi = math.radians(25)
        self.assertAlmostEqual(critical(phi, 1.0), ref.slope_associated_unit_weight(), delta=0.03)
        b = math.cos(phi)
        davis = critical(math.atan(b * math.tan(phi)), b)
        self.assertAlmostEqual(davis, ref.slope_davis_unit_weight(), delta=0.03)

    def test_elastic_slope_is_the_source_figure(self):
        """The finite-element figure 3.0344 kPa m at 10 kN/m3, stiff limit."""
        self.assertAlmostEqual(50 * ref.slope_elastic_settlement(10, 50), 3.0344, 4)


if __name__ == "__main__":
    unittest.main()
