"""Which method for which error at which cost: one table of all studies, as docs/charts.md has it."""

from __future__ import annotations

from collections.abc import Sequence

from qsmpm_verify.front import Sample, front, lasting_errors
from qsmpm_verify.pages import markdown_table
from qsmpm_verify.studies import Study

ASKED = (0.1, 0.03, 0.01, 1e-3)
LEGEND = (
    "Method; size; CPU seconds of the cheapest run that claims the error, on its grid and all finer ones;\n"
    "`same`: the run on the left serves; `-`: none does."
)


def cheapest(samples: Sequence[Sample], asked: float) -> Sample | None:
    """The cheapest run that claims no larger an error; none when no run does."""
    errors = lasting_errors(samples)
    return next((samples[i] for i in front(samples) if errors[i] <= asked), None)


def cells(samples: Sequence[Sample]) -> list[str]:
    """Method, size and CPU seconds of the cheapest run for each error; `same` where that of the one before serves."""
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
