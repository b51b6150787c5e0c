"""Tests of the figures: medians, numbers as text, fits, tables, sections of a page."""

import csv
import io
import unittest

from qsmpm_bench.measure import BenchError, Spread, fitted_exponent, interleave, load_warning, Sample, significant
from qsmpm_bench.tables import Result, Table, section_marks, write_section


class Figures(unittest.TestCase):
    def test_spread_is_median_and_extremes(self) -> None:
        spread = Spread.of([3.0, 1.0, 2.0, 10.0])
        self.assertEqual((spread.median, spread.low, spread.high), (2.5, 1.0, 10.0))
        self.assertEqual(spread.text(), "2.5 (1-10)")
        self.assertEqual(Spread.of([0.125]).text(), "0.125")

    def test_nothing_has_no_median(self) -> None:
        with self.assertRaises(BenchError):
            Spread.of([])

    def test_significant_digits(self) -> None:
        wanted = {0.0: "0", 1.2345: "1.23", 1234.5: "1230", 123456.0: "123000", 1234567.0: "1.23e+06",
                  8.41234e-5: "8.41e-05", -0.01234: "-0.0123"}
        for value, text in wanted.items():
            self.assertEqual(significant(value), text)

    def test_exponent_of_a_power(self) -> None:
        sizes = [1e3, 1e4, 3e5]
        # A power law is met to round-off of the logarithms.
        self.assertAlmostEqual(fitted_exponent(sizes, [7.0 * size**1.3 for size in sizes]), 1.3, places=12)
        with self.assertRaises(BenchError):
            fitted_exponent([1.0], [1.0])

    def test_jobs_take_turns(self) -> None:
        order: list[str] = []

        def job(name: str):
            def run() -> Sample:
                order.append(name)
                return Sample(float(len(order)), 0.0, 0)
            return run

        samples = interleave({"a": job("a"), "b": job("b")}, 3)
        self.assertEqual(order, ["a", "b"] * 3)
        self.assertEqual([sample.cpu for sample in samples["b"]], [2.0, 4.0, 6.0])

    def test_a_busy_machine_is_told(self) -> None:
        self.assertEqual(load_warning(0.4), "")
        self.assertIn("0.60", load_warning(0.6))


class Tables(unittest.TestCase):
    def table(self) -> Table:
        table = Table("rates", ["scene", "CPU s", "target met"], title="Rates")
        table.add("slope", Spread(2.0, 1.5, 2.5), True)
        table.add("column", None, False)
        return table

    def test_markdown(self) -> None:
        lines = self.table().markdown().splitlines()
        self.assertEqual(lines[0], "**Rates**")
        self.assertEqual(lines[2:], ["| scene | CPU s | target met |", "|---|---|---|",
                                     "| slope | 2 (1.5-2.5) | yes |", "| column | - | no |"])

    def test_csv_has_the_spread_in_columns(self) -> None:
        rows = list(csv.reader(io.StringIO(self.table().csv())))
        self.assertEqual(rows[0], ["scene", "CPU s", "CPU s smallest", "CPU s largest", "target met"])
        self.assertEqual(rows[1], ["slope", "2.0", "1.5", "2.5", "True"])
        self.assertEqual(rows[2], ["column", "", "", "", "False"])

    def test_a_row_of_another_length_is_an_error(self) -> None:
        with self.assertRaises(BenchError):
            self.table().add("one", 2.0)

    def test_plain_figures_are_json(self) -> None:
        plain = Result("parts", [self.table()], ["fine"]).plain()
        self.assertEqual(plain["tables"]["rates"][0]["CPU s"], {"median": 2.0, "smallest": 1.5, "largest": 2.5})

    def test_section_of_a_page(self) -> None:
        begin, end = section_marks("size")
        page = f"above\n{begin}\nold\n{end}\nbelow\n"
        new = write_section(page, "size", "a \\1 b\n")
        self.assertEqual(new, f"above\n{begin}\na \\1 b\n{end}\nbelow\n")
        self.assertEqual(write_section(new, "size", "a \\1 b"), new)
        with self.assertRaises(BenchError):
            write_section(page, "parts", "text")


if __name__ == "__main__":
    unittest.main()
