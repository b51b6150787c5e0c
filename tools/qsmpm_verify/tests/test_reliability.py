"""Reliability against closed forms: linear limits, lognormal quotients, correlation, and a deck whose answer is known."""

import contextlib
import io
import json
import math
import tempfile
import tomllib
import unittest
from pathlib import Path

import numpy as np
from scipy import stats

from qsmpm_verify.cli import main
from qsmpm_verify.places import PROGRAM
from qsmpm_verify.reliability.fields import lattice, read_field, with_partners, written
from qsmpm_verify.reliability.form import find_design, hypercube
from qsmpm_verify.reliability.variables import Space, make_space, read_variable
from qsmpm_verify.study.cards import read_deck
from qsmpm_verify.trouble import Trouble


def space_of(*tables: dict, correlation: float = 0.0) -> Space:
    """Variables called a, b, ... of a card that does not matter."""
    variables = [read_variable({"name": "ab"[i], "card": "ELASTIC", "column": "E", **table}) for i, table in enumerate(tables)]
    return make_space(variables, [("a", "b", correlation)] if correlation else [])


class Numbers(unittest.TestCase):
    def test_a_linear_limit_of_normal_numbers_is_exact(self) -> None:
        for rho in (0.0, 0.5, -0.5):
            space = space_of({"distribution": "normal", "mean": 20, "sd": 3}, {"distribution": "normal", "mean": 10, "sd": 2}, correlation=rho)
            found = find_design(lambda u, s=space: s.values(u)[:, 0] - s.values(u)[:, 1], 2)
            exact = 10.0 / math.sqrt(9 + 4 - 2 * rho * 6)
            self.assertAlmostEqual(found.beta, exact, places=6)
            self.assertAlmostEqual(found.probability / stats.norm.cdf(-exact), 1.0, delta=0.02)

    def test_a_quotient_of_lognormal_numbers_is_exact(self) -> None:
        # ln a - ln b is normal: (ln of the medians) over the root of the variances.
        space = space_of({"mean": 20, "cov": 0.3}, {"mean": 10, "cov": 0.2}, correlation=0.4)
        found = find_design(lambda u: np.log(space.values(u)[:, 0] / space.values(u)[:, 1]), 2)
        va, vb = math.log1p(0.09), math.log1p(0.04)
        apart = math.log(2.0) - 0.5 * (va - vb)
        exact = apart / math.sqrt(va + vb - 2 * math.log1p(0.4 * 0.3 * 0.2))
        self.assertAlmostEqual(found.beta, exact, places=4)
        # The difference has the same zero and another shape: what the search needs its rounds for.
        bent = find_design(lambda u: space.values(u)[:, 0] - space.values(u)[:, 1], 2)
        self.assertAlmostEqual(bent.beta, exact, delta=0.02)

    def test_numbers_have_the_moments_and_the_correlation_that_were_asked_for(self) -> None:
        space = space_of({"mean": 20, "cov": 0.3}, {"distribution": "uniform", "low": 1, "high": 3}, correlation=-0.6)
        x = space.values(np.random.default_rng(3).standard_normal((400_000, 2)))
        self.assertAlmostEqual(x[:, 0].mean(), 20.0, delta=0.05)
        self.assertAlmostEqual(x[:, 0].std(), 6.0, delta=0.05)
        self.assertAlmostEqual(np.corrcoef(x.T)[0, 1], -0.6, delta=0.01)
        gumbel = space_of({"distribution": "gumbel", "mean": 5, "sd": 1}).values(np.random.default_rng(3).standard_normal((400_000, 1)))
        self.assertAlmostEqual(gumbel.mean(), 5.0, delta=0.01)
        self.assertAlmostEqual(gumbel.std(), 1.0, delta=0.01)

    def test_a_mean_that_fails_has_a_negative_beta(self) -> None:
        space = space_of({"distribution": "normal", "mean": 8, "sd": 2})
        found = find_design(lambda u: space.values(u)[:, 0] - 10.0, 1)
        self.assertAlmostEqual(found.beta, -1.0, places=6)
        self.assertAlmostEqual(found.probability, stats.norm.cdf(1.0), delta=0.01)

    def test_a_hypercube_has_one_run_in_every_layer(self) -> None:
        layers = np.floor(stats.norm.cdf(hypercube(3, 50, 7)) * 50).astype(int)
        for column in layers.T:
            self.assertEqual(sorted(column.tolist()), list(range(50)))

    def test_a_field_has_the_moments_and_the_scales_that_were_asked_for(self) -> None:
        field = read_field({"name": "c", "of": "clay", "mean": 40, "cov": 0.3, "scales": [8, 2]})
        xs, ys = np.linspace(0, 40, 41), np.linspace(0, 10, 21)
        drawn = np.array([field.samples(xs, ys, 1, run) for run in range(400)])
        self.assertAlmostEqual(drawn.mean(), 40.0, delta=0.5)
        self.assertAlmostEqual(drawn.std(), 12.0, delta=0.4)
        logs = np.log(drawn) - np.log(drawn).mean()
        for along, steps, scale in ((2, 4, 8.0), (1, 2, 2.0)):
            distance = steps * (1.0 if along == 2 else 0.5)
            first, second = np.delete(logs, np.s_[-steps:], axis=along), np.delete(logs, np.s_[:steps], axis=along)
            self.assertAlmostEqual(float((first * second).mean() / logs.var()), math.exp(-2.0 * distance / scale), delta=0.03)
        self.assertTrue(np.array_equal(field.samples(xs, ys, 1, 7), drawn[7]))
        self.assertFalse(np.array_equal(field.samples(xs, ys, 2, 7), drawn[7]))

    def test_fields_of_one_material_have_the_correlation_that_was_asked_for(self) -> None:
        one = {"of": "clay", "mean": 40, "cov": 0.3, "scales": [2, 2]}
        fields = [read_field({"name": "c", **one}), read_field({"name": "E", "parameter": "E", **one, "distribution": "normal", "cov": 0.1})]
        xs = ys = np.linspace(0, 8, 17)
        for rho in (-0.6, 0.8):
            c, stiffness = with_partners(fields, [("c", "E", rho)])
            drawn = np.array([[f.samples(xs, ys, 1, run) for run in range(200)] for f in (c, stiffness)])
            self.assertAlmostEqual(float(np.corrcoef(drawn.reshape(2, -1))[0, 1]), rho, delta=0.02)
            self.assertAlmostEqual(drawn[1].std(), 4.0, delta=0.1)
            logs = drawn[1] - drawn[1].mean()
            self.assertAlmostEqual(float((logs[:, :, 1:] * logs[:, :, :-1]).mean() / logs.var()), math.exp(-0.5), delta=0.02)
            self.assertTrue(np.array_equal(drawn[0][3], fields[0].samples(xs, ys, 1, 3)))
        other = read_field({"name": "phi", "parameter": "phi", "of": "clay", "mean": 30, "cov": 0.1, "scales": [2, 1]})
        for pairs, why in (([("c", "phi", 0.5)], "must have the same scales"), ([("c", "c", 0.5)], "of two different fields"), ([("c", "E", 1.0)], "between -1 and 1"),
                           ([("c", "E", 0.5), ("E", "c", 0.5)], "correlated with one other field")):
            with self.assertRaisesRegex(Trouble, why):
                with_partners([*fields, other], pairs)
        for words, why in (({"parameter": "nu"}, "`parameter` must be one of c, phi, E, gamma, k"), ({"distribution": "normal"}, "out of range at some points"),
                           ({"parameter": "phi", "cov": 0.5}, "out of range at some points")):
            with self.assertRaisesRegex(Trouble, why):
                read_field({"name": "x", **one, **words})

    def test_what_cannot_be_is_refused(self) -> None:
        for words, why in (({"mean": 1}, "sd is missing"), ({"mean": 1, "sd": 1, "unit": 2}, "unknown word 'unit'"),
                           ({"mean": -1, "sd": 1}, "lognormal distribution must be above 0"), ({"distribution": "beta"}, "must be one of")):
            with self.assertRaisesRegex(Trouble, why):
                space_of(words)


COLUMN = """*MODEL, TYPE=PLANE STRAIN
*UNITS, LENGTH=m, FORCE=kN
*GRID, ELEMENT=QUAD4
X, 0, 1, 1
Y, 0, 1, 4
*NSET, NSET=base, PLANE=Y
0
*NSET, NSET=left, PLANE=X
0
*NSET, NSET=right, PLANE=X
1
*MATERIAL, NAME=clay
*ELASTIC
10000, 0
*UNIT WEIGHT
20
*BODY, NAME=column, MATERIAL=clay, SHAPE=BOX
0, 1, 0, 1
*HISTORY, NAME=settlement, QUANTITY=DISPLACEMENT, COMPONENT=Y, SCALE=-1
0.5, 1
*PHASE, NAME=weight
*FIX
base, ALL
left, X
right, X
*GRAVITY
0, -1
*CONTROLS, STEPS=1
*END PHASE
"""
QUESTION = """[[variable]]
name = "E"
card = "ELASTIC"
of = "clay"
column = "E"
mean = 10000
cov = 0.3
[response]
quantity = "settlement"
limit = 0.002
fails = "above"
"""


PRESSED = """*MODEL, TYPE=PLANE STRAIN
*UNITS, LENGTH=m, FORCE=kN
*GRID, ELEMENT=QUAD4
X, 0, 1, 2
Y, 0, 1, 2
*NSET, NSET=base, PLANE=Y
0
*NSET, NSET=left, PLANE=X
0
*NSET, NSET=top, PLANE=Y
1
*MATERIAL, NAME=clay
*ELASTIC
10000, 0.49
*MOHR COULOMB
40, 0, 0
*BODY, NAME=block, MATERIAL=clay, SHAPE=ALL
*METHOD, BASIS=FEM
*HISTORY, NAME=force, QUANTITY=REACTION, COMPONENT=Y, NSET=base
*PHASE, NAME=press
*FIX
base, Y
left, X
*PRESCRIBE
top, Y, -0.02
*CONTROLS, STEPS=5
*END PHASE
"""
FIELD = """[[field]]
name = "s_u"
of = "clay"
mean = 40
cov = 0.3
scales = {scales}
"""


@unittest.skipUnless(PROGRAM.is_file(), "the program is not built")
class Decks(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        (self.folder / "column.inp").write_text(COLUMN)
        (self.folder / "question.toml").write_text(QUESTION)

    def told(self, code: int, *words: str) -> str:
        output, errors = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(output), contextlib.redirect_stderr(errors):
            named = [str(self.folder / "column.inp"), str(self.folder / "question.toml"), "--out", str(self.folder / "out")]
            self.assertEqual(main(["reliability", *named, *words]), code, errors.getvalue())
        return output.getvalue() + errors.getvalue()

    def test_a_column_settles_too_much_as_often_as_its_stiffness_is_too_low(self) -> None:
        # settlement = weight H^2/(2 E): above 1.333 mm where E is below 7500, the geometry of so small a strain aside.
        (self.folder / "question.toml").write_text(QUESTION.replace("limit = 0.002", "limit = 0.0013333333"))
        spread = math.sqrt(math.log1p(0.09))
        exact = (math.log(4.0 / 3.0) - 0.5 * spread**2) / spread
        self.told(0)
        found = json.loads((self.folder / "out" / "reliability.json").read_text())
        self.assertAlmostEqual(found["beta"], exact, delta=0.02)
        self.assertAlmostEqual(found["design point"]["E"], 7500.0, delta=45.0)
        self.assertEqual(found["alpha"]["E"], -1.0)
        self.told(0, "--runs", "30", "--jobs", "2")
        sampled = json.loads((self.folder / "out" / "reliability.json").read_text())
        self.assertAlmostEqual(sampled["probability"], stats.norm.cdf(-exact), delta=3 * max(sampled["its standard error"], 0.005))

    def test_a_field_of_endless_scales_is_one_number(self) -> None:
        # Between plates that do not hold it clay bears 2 s_u on a width that has grown by 1/0.98.
        (self.folder / "column.inp").write_text(PRESSED)
        question = 'quantity = "force"\nat = "max"\nlimit = 60\n'
        (self.folder / "question.toml").write_text(f'{FIELD.format(scales="[1e6, 1e6]")}[response]\n{question}')
        self.told(0, "--runs", "12", "--jobs", "2")
        found = json.loads((self.folder / "out" / "reliability.json").read_text())
        field = read_field(tomllib.loads(FIELD.format(scales="[1e6, 1e6]"))["field"][0])
        ends = np.array([0.0, 1.0])
        margins = [2.0 / 0.98 * field.samples(ends, ends, 1, run)[0, 0] - 60.0 for run in range(12)]
        self.assertAlmostEqual(found["mean margin"], float(np.mean(margins)), delta=0.05)
        self.assertEqual(found["probability"], float(np.mean(np.array(margins) < 0.0)))
        fine = PRESSED.replace("X, 0, 1, 2", "X, 0, 1, 200").replace("Y, 0, 1, 2", "Y, 0, 1, 200")
        two = FIELD.format(scales="[1, 1]") + FIELD.format(scales="[1, 1]")
        for text, tables, why in ((fine, FIELD.format(scales="[1, 0.01]"), "samples; at most 20000 are supported"),
                                  (PRESSED, FIELD.format(scales="[1, 0.9]"), "cells of the *GRID are 0.5 wide along y, and a scale of 0.9 requires at most 0.45"),
                                  (PRESSED, two.replace('name = "s_u"', 'name = "s_u 2"', 1), "is also a variable or another field"),
                                  (PRESSED, two, "two fields have the same name")):
            (self.folder / "column.inp").write_text(text)
            (self.folder / "question.toml").write_text(f"{tables}[response]\n{question}")
            self.assertIn(why, self.told(2, "--runs", "2"))
        (self.folder / "question.toml").write_text(f'{FIELD.format(scales="[1]")}[response]\n{question}')
        self.assertIn("scales must be two lengths", self.told(2, "--runs", "2"))
        (self.folder / "question.toml").write_text(f'{FIELD.format(scales="[1, 1]")}[response]\n{question}')
        self.assertIn("requires sampling, for example --runs 200", self.told(2))

    def test_fields_of_stiffness_and_weight_of_endless_scales_are_two_numbers(self) -> None:
        table = """[[field]]
name = "E"
of = "clay"
parameter = "E"
mean = 10000
cov = 0.3
scales = [1e6, 1e6]
[[field]]
name = "weight"
of = "clay"
parameter = "gamma"
distribution = "normal"
mean = 20
cov = 0.1
scales = [1e6, 1e6]
[[correlation]]
between = ["E", "weight"]
rho = 0.5
"""
        (self.folder / "question.toml").write_text(table + QUESTION[QUESTION.index("[response]"):])
        self.told(0, "--runs", "10", "--jobs", "2")
        found = json.loads((self.folder / "out" / "reliability.json").read_text())
        read = tomllib.loads(table)
        stiffness, weight = with_partners([read_field(f) for f in read["field"]], [("E", "weight", 0.5)])
        ends = np.array([0.0, 1.0])
        exact = [0.5 * weight.samples(ends, ends, 1, run)[0, 0] / stiffness.samples(ends, ends, 1, run)[0, 0] for run in range(10)]
        self.assertAlmostEqual(found["mean margin"] / (0.002 - float(np.mean(exact))), 1.0, delta=0.01)
        self.assertEqual(found["runs without an answer"], 0)

    def test_samples_of_a_field_stand_in_a_file_that_the_deck_names(self) -> None:
        field = read_field(tomllib.loads(FIELD.format(scales="[2, 1]"))["field"][0])
        (self.folder / "column.inp").write_text(PRESSED)
        deck, text = read_deck(self.folder / "column.inp"), f"*MOHR COULOMB\n1, 0, 0\n{field.mark()}\n*BODY"
        drawn = []
        for times in (1.0, 2.0):
            found = written([field], deck, text, self.folder, 3, 5, times)
            self.assertRegex(found, r'1, 0, 0\n\*FIELD OF VALUES\nc, "\S+\.csv"\n\*BODY')
            path = Path(found.split('c, "')[1].split('"')[0])
            self.assertEqual(path.read_text().splitlines()[0], "x,y,c")
            drawn.append(np.loadtxt(path, delimiter=",", skiprows=1))
        self.assertEqual(drawn[0].shape, (25, 3))
        self.assertEqual([drawn[0][:, i].max() for i in (0, 1)], [1.0, 1.0])
        self.assertTrue(np.allclose(drawn[1][:, 2], 2.0 * drawn[0][:, 2]))
        angle = read_field({"name": "phi", "of": "clay", "parameter": "phi", "mean": 30, "cov": 0.1, "scales": [2, 1]})
        both = written([field, angle], deck, text, self.folder, 3, 5, 2.0)
        self.assertRegex(both, r'\n\*FIELD OF VALUES\nc, "\S+\.csv"\nphi, "\S+\.csv"\n\*BODY')
        steep = np.loadtxt(both.split('phi, "')[1].split('"')[0], delimiter=",", skiprows=1)[:, 2]
        self.assertTrue(np.allclose(np.tan(np.radians(steep)), 2.0 * np.tan(np.radians(angle.samples(*lattice(deck, angle), 3, 5).ravel())), rtol=1e-7))
        other = read_field(tomllib.loads(FIELD.format(scales="[2, 1]").replace("clay", "sand"))["field"][0])
        self.assertNotIn(field.mark(), other.mark())
        xs, ys = lattice(deck, field)
        self.assertTrue(np.allclose(drawn[0][:, 2].reshape(5, 5), field.samples(xs, ys, 3, 5), rtol=1e-8))

    def test_a_number_that_is_not_there_is_an_error(self) -> None:
        for old, new, why in (('"ELASTIC"', '"ELASTICS"', "there is no keyword"), ('column = "E"', 'column = "G"', "has no column 'G'"),
                              ('"clay"', '"sand"', "no keywords *ELASTIC of sand"), ("limit = 0.002", "", "limit of a history is missing"),
                              ('quantity = "settlement"', 'quantity = "uplift"', "no column")):
            (self.folder / "question.toml").write_text(QUESTION.replace(old, new))
            self.assertIn(why, self.told(2))


if __name__ == "__main__":
    unittest.main()
