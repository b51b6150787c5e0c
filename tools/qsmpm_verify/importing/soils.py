"""The table of soils: data that a drawing lacks, requested in a CSV file that contains the known values."""

from __future__ import annotations

import csv
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

from qsmpm_verify.importing.section import Section, Soil
from qsmpm_verify.trouble import Trouble

COLUMNS = [field.name for field in fields(Soil)]
UNITS = {"weight": "kN/m3", "saturated_weight": "kN/m3", "young": "kPa", "poisson": "-", "cohesion": "kPa", "friction": "deg", "dilation": "deg"}
NEEDED = ("weight", "cohesion", "friction")
YOUNG, POISSON, DILATION = 20_000.0, 0.3, 0.0
"""Default values: neither stiffness changes a factor of safety (docs/methods/safety.md); soil that does not
dilate is the conservative choice."""


def read_table(path: Path, section: Section) -> None:
    """Read the values of a table; an unknown soil or an invalid number is an error with its line."""
    try:
        rows = list(csv.DictReader(path.read_text(encoding="utf-8-sig").splitlines()))
    except OSError as error:
        raise Trouble(f"{path}: {error.strerror}") from error
    for line, row in enumerate(rows, start=2):
        words = {(key or "").split("[")[0].strip().lower(): (value or "").strip() for key, value in row.items()}
        unknown = [key for key in words if key not in COLUMNS]
        if unknown:
            raise Trouble(f"{path}:1: unknown column '{unknown[0]}'; known are {', '.join(COLUMNS)}")
        name = words.get("name", "")
        if name not in section.soils:
            raise Trouble(f"{path}:{line}: no soil '{name}' in the section; known are {', '.join(sorted(section.soils))}")
        for key, value in words.items():
            if key != "name" and value:
                numbers: dict[str, Any] = {key: number_at(value, key, path, line)}
                section.soils[name] = replace(section.soils[name], **numbers)


def number_at(value: str, key: str, path: Path, line: int) -> float:
    """An optional number of the table."""
    try:
        number = float(value)
    except ValueError:
        raise Trouble(f"{path}:{line}: {key} '{value}' is not a number") from None
    if not 0.0 <= number < 1.0e12:
        raise Trouble(f"{path}:{line}: {key} {value} is not in [0, 1e12)")
    return number


def missing(section: Section) -> list[str]:
    """Parameters that the deck requires and that are missing: `soil: number, number`."""
    return [
        f"{soil.name}: {', '.join(lacks)}"
        for soil in section.soils.values() if (lacks := [key for key in NEEDED if getattr(soil, key) is None])
    ]  # fmt: skip


def write_table(path: Path, section: Section) -> None:
    """The table with the known values; the others are empty."""
    with path.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow([f"{key} [{UNITS[key]}]" if key in UNITS else key for key in COLUMNS])
        for soil in section.soils.values():
            table.writerow(["" if (value := getattr(soil, key)) is None else value for key in COLUMNS])


def completed(soil: Soil, section: Section) -> Soil:
    """A soil with default values for missing ones, which are noted in the section."""
    taken = []
    if soil.young is None:
        taken.append(f"E = {YOUNG:g} kPa")
    if soil.poisson is None:
        taken.append(f"nu = {POISSON:g}")
    if soil.dilation is None:
        taken.append("psi = 0")
    if taken:
        section.notes.append(f"soil '{soil.name}': {', '.join(taken)} assumed, not defined in the file; a column of the table defines them")
    return Soil(
        soil.name, soil.weight, soil.weight if soil.saturated_weight is None else soil.saturated_weight,
        YOUNG if soil.young is None else soil.young, POISSON if soil.poisson is None else soil.poisson,
        soil.cohesion, soil.friction, DILATION if soil.dilation is None else soil.dilation,
    )  # fmt: skip
