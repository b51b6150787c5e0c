"""Which method for which error at which cost: one table of all studies, as README.md has it."""

from __future__ import annotations

from collections.abc import Sequence

from qsmpm_verify.front import Sample, front, lasting_errors
from qsmpm_verify.pages import markdown_table
from qsmpm_verify.studies import Study

ASKED = (0.1, 0.01, 1e-3, 1e-4)


def cheapest(samples: Sequence[Sample], asked: float) -> Sample | None:
    """The cheapest run that claims no larger an error; none when no run does."""
    errors = lasting_errors(samples)
    return next((samples[i] for i in front(samples) if errors[i] <= asked), None)


def cell(samples: Sequence[Sample], asked: float) -> str:
    """Method, size and CPU seconds of the cheapest run."""
    found = cheapest(samples, asked)
    return "-" if found is None else f"{found.method}; {found.size:g}; {found.seconds:.2g} s"


def table_lines(taken: Sequence[tuple[Study, Sequence[Sample]]], command: str) -> list[str]:
    """The table as lines of a page."""
    header = ["scene: error", "size counts", *(f"at most {asked:g}" for asked in ASKED)]
    rows = [
        [f"{study.name.replace('_', ' ')}: {study.error.name}", study.size, *(cell(samples, a) for a in ASKED)]
        for study, samples in taken
    ]
    return [
        *markdown_table(header, rows), "",
        f"Method; size; CPU seconds of the cheapest run of `{command}` that claims the error on its grid and all finer ones; "
        "`-`: none of them does.",
    ]  # fmt: skip
