"""Families of cases, orders of convergence and growth, and the measures of all points."""

import math
import tempfile
import unittest
from pathlib import Path
from typing import Any

import numpy as np

from qsmpm_verify.cases import Case, CaseError, Quantity, load_all, load_file
from qsmpm_verify.judge import judge_quantity
from qsmpm_verify.measures import MEASURES
from qsmpm_verify.plots import column_figure
from qsmpm_verify.report import write_markdown
from qsmpm_verify.results import Points
from qsmpm_verify.runner import Run

HEAD = 'title="t"\ndeck="d"\nsource="s"\n[[case]]\n'
QUANTITY = '[[case.quantity]]\nname="q"\ncolumn="c"\n'
ORDER = QUANTITY + 'at_least=1.8\nreason="r"\norder_from='


def load(text: str) -> list[Case]:
    """The cases of a file with this text."""
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "x.toml"
        path.write_text(text)
        return load_file(path, Path(name))


class Families(unittest.TestCase):
    """What `each` makes of a case."""

    def test_one_case_an_entry_with_names_and_replacements(self) -> None:
        cases = load(HEAD + 'name="cells_{n}"\neach=[{n=16, h=3.125}, {n=64, h=0.5}]\nreplace=[["Y, 4", "Y, {h}, {n}"]]\n')
        self.assertEqual([c.name for c in cases], ["x/cells_16", "x/cells_64"])
        self.assertEqual([c.replace for c in cases], [(("Y, 4", "Y, 3.125, 16"),), (("Y, 4", "Y, 0.5, 64"),)])

    def test_a_lone_word_becomes_the_number_itself(self) -> None:
        text = 'name="n{n}"\neach=[{n=1, r=0.25, e="small"}, {n=2, r=0.125, e="long"}]\neffort="{e}"\n' + QUANTITY
        cases = load(HEAD + text + 'reference="{r}"\ntolerance=0.1\nreason="r"\n')
        self.assertEqual([c.quantities[0].reference for c in cases], [0.25, 0.125])
        self.assertEqual([c.effort for c in cases], ["small", "long"])

    def test_words_reach_into_tables_of_quantities(self) -> None:
        text = 'name="n{n}"\neach=[{n=1, m=3}]\n' + QUANTITY + 'reference={case="x/n{m}"}\ntolerance=0.1\nreason="r"\n'
        self.assertEqual(load(HEAD + text)[0].needs(), {"x/n3"})

    def test_braces_outside_a_family_stay(self) -> None:
        self.assertEqual(load(HEAD + 'name="a"\nreplace=[["{n}", "2"]]\n')[0].replace, (("{n}", "2"),))

    def test_mistakes_are_told(self) -> None:
        for text, word in (
            ('name="a{m}"\neach=[{n=1}]\n', r"\{m\} is not in each"),
            ('name="a{n}"\neach=[{n=1, m=2}]\n', "'m' of each is not used"),
            ('name="a{n}"\neach=[{n=1}, {m=1}]\n', "same words"),
            ('name="a{n}"\neach=[]\n', "at least one"),
            ('name="a{n}"\neach=3\n', "list of at least one table"),
            ('name="a{n}"\neach=[{n=true}]\n', "number or a text"),
            ('name="a{n}"\neach=[{n=[1]}]\n', "number or a text"),
            ('name="a"\neach=[{n=1}, {n=2}]\nreplace=[["x", "{n}"]]\n', "does not distinguish"),
        ):
            with self.subTest(text), self.assertRaisesRegex(CaseError, word):
                load(HEAD + text)


class Comparisons(unittest.TestCase):
    """Figures that are formed with another run."""

    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.runs = {}
        for name, error in (("coarse", 1e-2), ("fine", 1e-4), ("exact", 0.0)):
            folder = Path(temporary.name) / name
            folder.mkdir()
            (folder / "curves.csv").write_text(f"step,error\n1,5\n2,{error}\n")
            case = Case(f"a/{name}", "t", folder / "d", ())
            self.runs[case.name] = Run(case, folder, 0, 1.0)

    def verdict(self, name: str = "a/fine", **quantity: object):
        return judge_quantity(self.runs[name], Quantity("q", column="error", **quantity), self.runs)  # type: ignore[arg-type]

    def test_order_of_convergence(self) -> None:
        verdict = self.verdict(order_from={"case": "a/coarse", "refinement": 10}, at_least=1.99)
        self.assertAlmostEqual(verdict.value, 2.0, 12)
        self.assertTrue(verdict.held)
        self.assertFalse(self.verdict(order_from={"case": "a/coarse", "refinement": 10}, at_least=2.01).held)

    def test_growth(self) -> None:
        verdict = self.verdict(growth_from={"case": "a/coarse"}, at_most=0.011)
        self.assertAlmostEqual(verdict.value, 0.01, 12)
        self.assertTrue(verdict.held)
        self.assertFalse(self.verdict("a/coarse", growth_from={"case": "a/fine"}, at_most=1.1).held)

    def test_no_ratio_is_a_miss(self) -> None:
        for name, other in (("a/fine", "a/exact"), ("a/exact", "a/fine"), ("a/fine", "a/absent")):
            verdict = self.verdict(name, order_from={"case": other, "refinement": 2}, at_least=-1e9)
            self.assertIs(verdict.held, False)

    def test_mistakes_are_told(self) -> None:
        for text, word in (
            (ORDER + '{case="x/a"}\n', "order_from requires case and refinement"),
            (ORDER + '{case="x/a", refinement=1}\n', "above 1"),
            (ORDER + '{case="x/a", refinement="2"}\n', "above 1"),
            (ORDER + '{case="x/a", refinement=2}\nat="every"\n', "one value"),
            (ORDER + '{case="x/a", refinement=2}\nreference=1.0\n', "at_least or at_most"),
            (ORDER + '{case="x/a", refinement=2}\ngrowth_from={case="x/a"}\n', "either"),
            (QUANTITY + 'at_most=1\nreason="r"\ngrowth_from={case="x/a", refinement=2}\n', "growth_from requires case"),
            (QUANTITY + 'growth_from={case="x/a"}\n', "print = true"),
        ):
            with self.subTest(text), self.assertRaisesRegex(CaseError, word):
                load(HEAD + 'name="a"\n' + text)

    def test_the_other_case_must_exist(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            (Path(name) / "x.toml").write_text(HEAD + 'name="a"\n' + ORDER + '{case="x/b", refinement=2}\n')
            with self.assertRaisesRegex(CaseError, "x/b"):
                load_all(Path(name), Path(name))


class Measures(unittest.TestCase):
    """Figures of all points, against states made by hand."""

    def points(self, **fields: object) -> Points:
        return Points(Path("x"), 1, 1, 1.0, {name: np.array(values, float) for name, values in fields.items()})

    def test_stress_error_of_the_column_weighs_with_initial_volumes(self) -> None:
        points = self.points(
            position=[[0, 1, 0], [0, 4, 0]], displacement=[[0, -1, 0], [0, -4, 0]],
            stress=[[0, -16 + 2, 0, 0, 0, 0], [0, -4 - 1, 0, 0, 0, 0]], initial_volume=[3, 1], volume=[1, 3],
        )  # fmt: skip
        # s(X) = -2 (10 - X): -16 at X = 2, -4 at X = 8; errors 2 and 1 with weights 3 and 1 over 2*10.
        self.assertAlmostEqual(MEASURES["column_stress_error"](points, height=10.0, unit_weight=2.0), 7 / 4 / 20, 15)

    def test_position_error_of_the_column_vanishes_at_the_integral_of_the_stretch(self) -> None:
        starts, height, young, weight, cells = [5.0, 45.0], 50.0, 10.0, 0.8, 4000

        def stretch(x: float) -> float:
            low, high, q = 0.0, 4.0, weight * (height - x) / young
            for _ in range(60):
                middle = (low + high) / 2
                low, high = (middle, high) if middle * math.exp(middle) < q else (low, middle)
            return math.exp(-low)

        ends = [sum(stretch((i + 0.5) * x / cells) for i in range(cells)) * x / cells for x in starts]
        points = self.points(
            position=[[0, y, 0] for y in ends], displacement=[[0, y - x, 0] for x, y in zip(starts, ends)],
            initial_volume=[1, 3],
        )  # fmt: skip
        arguments = {"height": height, "unit_weight": weight, "young": young}
        # The midpoint rule with 4000 cells is off by 1e-8 of the height at most.
        self.assertLess(MEASURES["column_position_error"](points, **arguments), 1e-8)
        points.fields["position"][1, 1] += 0.2
        points.fields["displacement"][1, 1] += 0.2
        self.assertAlmostEqual(MEASURES["column_position_error"](points, **arguments), 0.75 * 0.2 / height, 7)

    def test_volume_within_counts_the_points_of_a_box(self) -> None:
        points = self.points(position=[[0, 1, 9], [0, 4, 9], [2, 1, 9]], volume=[1, 3, 5])
        self.assertEqual(MEASURES["volume_within"](points, low=[0, 0], high=[1, 2]), 1.0)
        self.assertEqual(MEASURES["volume_within"](points, low=[0, 0], high=[2, 4]), 9.0)

    def test_uniform_state_looks_at_the_worst_point(self) -> None:
        points = self.points(stress=[[0, -9, 0], [0, -9.9, 0]], volume=[0.1, 0.4], initial_volume=[1, 2])
        self.assertAlmostEqual(MEASURES["uniform_stress_error"](points, component=2, stress=-9.0), 0.1, 12)
        self.assertAlmostEqual(MEASURES["confined_strain_error"](points, strain=0.9), 0.1 / 0.9, 12)

    def test_uniform_pressure_counts_normal_stress_and_shear(self) -> None:
        points = self.points(stress=[[-2, -2, 0, 0.1], [-2, -1.6, 0, 0]])
        arguments: dict[str, Any] = {"pressure": 2.0, "components": [1, 2, 4]}
        self.assertAlmostEqual(MEASURES["uniform_pressure_error"](points, **arguments), 0.2, 12)
        self.assertAlmostEqual(MEASURES["uniform_pressure_rms"](points, **arguments), ((0.2**2 + 0.05**2) / 6) ** 0.5, 12)


class Page(unittest.TestCase):
    """Pictures on the page of figures."""

    def test_pictures_are_named_from_the_page(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            page = Path(name) / "docs" / "v.md"
            write_markdown([], "c", page, [page.parent / "figures" / "column_error.png"])
            self.assertTrue(page.read_text().endswith("|\n\n![column error](figures/column_error.png)\n"))

    def test_no_run_no_chart(self) -> None:
        self.assertIsNone(column_figure({"other_16": Path("x")}, Path("nowhere.png")))


if __name__ == "__main__":
    unittest.main()
