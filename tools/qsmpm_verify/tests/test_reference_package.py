"""The package of references: names, docstrings, page, and the doors to scipy."""

import inspect
import math
import unittest
from pathlib import Path

from qsmpm_verify import reference as ref
from qsmpm_verify.reference import arguments, numerics, page

TOP = Path(__file__).resolve().parents[3]


class Names(unittest.TestCase):
    def test_every_figure_of_every_family_is_found_by_name(self):
        names = [name for family in ref.FAMILIES for name in ref.functions(family)]
        self.assertEqual(len(names), len(set(names)))
        self.assertEqual(set(names) - set(ref.REFERENCES), {"cantilever_tip"})
        for name in ("van_langen", "van_langen_paper_steps", "column_height_hencky", "column_height_rate",
                     "column_height_paper_steps", "slope_elastic_settlement", "prandtl_footing"):  # fmt: skip
            self.assertIn(name, ref.REFERENCES)

    def test_bare_names_work_and_unknown_ones_do_not(self):
        self.assertEqual(ref.column_height_rate(1.0, 1.0, 0.0), 1.0)
        self.assertEqual(ref.van_langen(0.5), 1.0)
        with self.assertRaises(AttributeError):
            ref.no_such_reference

    def test_every_argument_is_typed_and_every_result_a_number(self):
        for name, function in ref.REFERENCES.items():
            for parameter in inspect.signature(function).parameters.values():
                self.assertIn(parameter.annotation, ("float", "bool"), f"{name}: {parameter}")


class Page(unittest.TestCase):
    def test_every_docstring_has_all_entries(self):
        for family in ref.FAMILIES:
            self.assertTrue(inspect.getdoc(family))
            for function in ref.functions(family).values():
                self.assertEqual(set(page.entries(function)), {"What", *page.ENTRIES})

    def test_a_missing_entry_is_told(self):
        def bare() -> float:
            """Something.

            Formula: 1
            """
            return 1.0

        with self.assertRaisesRegex(ValueError, "bare has no Units, Range, Assumes, Source, Check"):
            page.entries(bare)

    def test_the_page_in_docs_is_this_one(self):
        text = page.markdown()
        self.assertEqual(text, (TOP / "docs" / "references.md").read_text())
        for name in ref.REFERENCES:
            self.assertIn(f"`{name}(", text)
        for line in text.splitlines():
            if line.startswith("|"):
                self.assertEqual(line.replace("\\|", "").count("|"), 8, line)


class Arguments(unittest.TestCase):
    def test_figures_out_of_range_are_told_with_name_and_value(self):
        for call, words in (
            (lambda: arguments.within("x", 2.0, 0.0, 1.0), "x = 2 must be between 0 and 1"),
            (lambda: arguments.between("x", 1.0, 0.0, 1.0), "x = 1 must be strictly between 0 and 1"),
            (lambda: arguments.positive(load=0.0), "load = 0 must be strictly between 0 and inf"),
            (lambda: arguments.not_negative(load=-1.0), "load = -1 must not be negative"),
            (lambda: arguments.poisson_ratio(0.5), "poisson = 0.5 must be strictly between -1 and 0.5"),
            (lambda: arguments.step_count(1.5), "steps = 1.5 must be an integer"),
            (lambda: arguments.friction_angle("friction", 90.0), "friction = 90 degrees"),
            (lambda: arguments.dilatancy_angle(30.0, 20.0), "dilatancy = 30 must be between 0 and 20"),
        ):
            with self.assertRaisesRegex(ValueError, words):
                call()

    def test_nothing_infinite_or_undefined_passes(self):
        for value in (math.nan, math.inf):
            for check in (arguments.positive, arguments.not_negative):
                self.assertRaises(ValueError, check, x=value)
        self.assertRaises(ValueError, arguments.within, "x", math.nan)


class Doors(unittest.TestCase):
    def test_root_needs_a_change_of_sign(self):
        self.assertAlmostEqual(numerics.root(lambda x: x * x - 2, 0, 2), math.sqrt(2), 13)
        self.assertRaises(ArithmeticError, numerics.root, lambda x: x * x + 2, 0, 2)

    def test_quadrature_that_is_uncertain_is_refused(self):
        self.assertAlmostEqual(numerics.integral(math.exp, 0, 1), math.e - 1, 12)
        self.assertRaises(ArithmeticError, numerics.integral, lambda x: 1 / x, 0, 1)

    def test_minimum_that_is_not_found_is_refused(self):
        self.assertAlmostEqual(numerics.minimum(lambda x: (x[0] - 1) ** 2 + x[1] ** 2 + 3, [0, 1]), 3, 10)
        self.assertRaises(ArithmeticError, numerics.minimum, lambda x: -x[0] - x[1], [0, 1])
        # y' = y^2 from 1 is at infinity at x = 1
        self.assertRaises(ArithmeticError, numerics.end_of_path, lambda x, y: [y[0] ** 2], 0, 2, [1])


if __name__ == "__main__":
    unittest.main()
