"""Formulas of the library as named on the command line: `function:van_langen(modulus=1000, strain=axial_strain)`.

An argument is a number, true or false, or a column of the result, `-column` for its negative.
"""

from __future__ import annotations

import inspect
import re
from dataclasses import dataclass

import numpy as np

from qsmpm_verify.reference import REFERENCES, Reference
from qsmpm_verify.results import Array, Curves
from qsmpm_verify.trouble import Trouble


@dataclass(frozen=True)
class Formula:
    """A function of the library, its fixed arguments and those that are columns of the result."""

    name: str
    function: Reference
    fixed: dict[str, float | bool]
    columns: dict[str, str]

    def along(self, curves: Curves, rows: Array) -> Array:
        """Its values for some rows of the curves."""
        given = {argument: signed_column(curves, name)[rows] for argument, name in self.columns.items()}
        try:
            return np.array([
                float(self.function(**self.fixed, **{a: float(v[i]) for a, v in given.items()}))
                for i in range(len(rows))
            ])  # fmt: skip
        except (ValueError, ArithmeticError, TypeError) as error:
            raise Trouble(f"function {self.name}: {error}") from error


def signed_column(curves: Curves, name: str) -> Array:
    """A column, or its negative if the name has a minus sign."""
    return -curves.column(name[1:]) if name.startswith("-") else curves.column(name)


def _argument(text: str) -> float | bool | str:
    """A number, a truth value, or the name of a column."""
    if text in ("true", "false"):
        return text == "true"
    try:
        return float(text)
    except ValueError:
        return text


def read_formula(text: str) -> Formula:
    """A formula from the text after `function:`; names and arguments are checked."""
    hit = re.fullmatch(r"\s*(\w+)\s*(?:\((.*)\))?\s*", text)
    if not hit:
        raise Trouble(f"function:{text}: the format is function:NAME(argument=value, argument=COLUMN)")
    name = hit[1]
    if name not in REFERENCES:
        raise Trouble(f"unknown function '{name}'; known are {', '.join(sorted(REFERENCES))}")
    known = inspect.signature(REFERENCES[name]).parameters
    fixed: dict[str, float | bool] = {}
    columns: dict[str, str] = {}
    for pair in filter(None, (part.strip() for part in (hit[2] or "").split(","))):
        word, sign, value = (part.strip() for part in pair.partition("="))
        if not sign or not value or word not in known:
            raise Trouble(f"function {name}: '{pair}' must be one of its arguments {', '.join(known)} with a value")
        if word in fixed or word in columns:
            raise Trouble(f"function {name}: '{word}' is given twice")
        given = _argument(value)
        if isinstance(given, str):
            columns[word] = given
        else:
            fixed[word] = given
    missing = [p for p in known if known[p].default is inspect.Parameter.empty and p not in fixed and p not in columns]
    if missing:
        raise Trouble(f"function {name}: missing argument {', '.join(missing)}")
    return Formula(name, REFERENCES[name], fixed, columns)
