"""Cheapest method for each error: one table of all studies, as in docs/charts.md."""

from __future__ import annotations

from collections.abc import Sequence

from qsmpm_verify.front import Sample, front, lasting_errors
from qsmpm_verify.pages import markdown_table
from qsmpm_verify.studies import Study

ASKED = (0.1, 0.03, 0.01, 1e-3)
LEGEND = (
    "Method; size; CPU seconds of the cheapest run that attains the error, on its grid and all finer ones;\n"
    "`same`: the run on the left also attains it; `-`: none does."
)


def cheapest(samples: Sequence[Sample], asked: float) -> Sample | None:
    """The cheapest run with an error not larger than requested; None if there is none."""
    errors = lasting_errors(samples)
    return next((samples[i] for i in front(samples) if errors[i] <= asked), None)


def cells(samples: Sequence[Sample]) -> list[str]:
    """Method, size and CPU seconds of the cheapest run for each error; `same` if the previous run also attains it."""
    found = [cheapest(samples, asked) for asked in ASKED]
    return [
        "-" if one is None else "same" if place and one is found[place - 1]
        else f"{one.method}; {one.size:g}; {one.seconds:.2g} s"
        for place, one in enumerate(found)
    ]  # fmt: skip


def table_cells(taken: Sequence[tuple[Study, Sequence[Sample]]]) -> tuple[list[str], list[list[str]]]:
    """Headings and rows."""
    header = ["scene: error", "size counts", *(f"at most {asked:g}" for asked in ASKED)]
    rows = [
        [f"{study.name.replace('_', ' ')}: {study.error.name}", study.size, *cells(samples)]
        for study, samples in taken
    ]  # fmt: skip
    return header, rows


def table_lines(taken: Sequence[tuple[Study, Sequence[Sample]]], command: str) -> list[str]:
    """The table as lines of a page."""
    return [*markdown_table(*table_cells(taken)), "", f"Written by `{command}`. {LEGEND}"]
