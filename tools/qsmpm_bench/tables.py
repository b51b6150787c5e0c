"""Tables of results as Markdown and CSV, and the sections of a page that the command writes."""

from __future__ import annotations

import csv
import io
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from qsmpm_bench.measure import BenchError, Spread, significant


@dataclass
class Table:
    """Rows of values under headings; a value is a text, a number or a Spread."""

    name: str
    columns: list[str]
    rows: list[list[Any]] = field(default_factory=list)
    title: str = ""
    note: str = ""

    def add(self, *values: Any) -> None:
        """Append a row, as long as the headings."""
        if len(values) != len(self.columns):
            raise BenchError(f"{self.name}: {len(values)} values under {len(self.columns)} headings")
        self.rows.append(list(values))

    def markdown(self) -> str:
        """The title, the table and the note."""
        lines = [f"**{self.title}**", ""] if self.title else []
        lines.append("| " + " | ".join(self.columns) + " |")
        lines.append("|" + "---|" * len(self.columns))
        lines += ["| " + " | ".join(shown(value) for value in row) + " |" for row in self.rows]
        if self.note:
            lines += ["", self.note]
        return "\n".join(lines) + "\n"

    def csv(self) -> str:
        """Rows of the CSV file: a Spread is written as its median, with two more columns for its minimum and maximum."""
        wide = [any(isinstance(row[i], Spread) for row in self.rows) for i in range(len(self.columns))]
        out = io.StringIO()
        writer = csv.writer(out, lineterminator="\n")
        head: list[str] = []
        for name, spread in zip(self.columns, wide):
            head += [name, f"{name} smallest", f"{name} largest"] if spread else [name]
        writer.writerow(head)
        for row in self.rows:
            cells: list[Any] = []
            for value, spread in zip(row, wide):
                if isinstance(value, Spread):
                    cells += [value.median, value.low, value.high]
                else:
                    cells += [value, "", ""] if spread else [value]
            writer.writerow("" if cell is None else cell for cell in cells)
        return out.getvalue()


def shown(value: Any) -> str:
    """A value as text in a table."""
    if value is None:
        return "-"
    if isinstance(value, Spread):
        return value.text()
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return significant(value)
    return str(value)


@dataclass
class Result:
    """Results of a subcommand."""

    name: str
    tables: list[Table] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)
    text: str = ""
    """Output of another program, printed verbatim."""

    def markdown(self) -> str:
        """Tables, remarks, text."""
        parts = [table.markdown() for table in self.tables]
        if self.remarks:
            parts.append("\n".join(f"- {remark}" for remark in self.remarks) + "\n")
        if self.text:
            parts.append(f"```\n{self.text.rstrip()}\n```\n")
        return "\n".join(parts)

    def plain(self) -> dict[str, Any]:
        """Data of a JSON file."""
        def cell(value: Any) -> Any:
            if isinstance(value, Spread):
                return {"median": value.median, "smallest": value.low, "largest": value.high}
            return value

        return {"remarks": self.remarks, "text": self.text,
                "tables": {table.name: [dict(zip(table.columns, map(cell, row))) for row in table.rows]
                           for table in self.tables}}


def section_marks(name: str) -> tuple[str, str]:
    """Marker lines of a page between which a subcommand writes."""
    return f"<!-- begin tools/bench {name} -->", f"<!-- end tools/bench {name} -->"


def write_section(page: str, name: str, body: str) -> str:
    """A page with the section of a subcommand replaced; a page without its markers is an error."""
    begin, end = section_marks(name)
    pattern = re.compile(re.escape(begin) + r"\n.*?" + re.escape(end), re.S)
    if len(pattern.findall(page)) != 1:
        raise BenchError(f"the page must have exactly one section between '{begin}' and '{end}'")
    return pattern.sub(lambda _: f"{begin}\n{body.strip()}\n{end}", page)


def write_files(result: Result, folder: Path) -> list[Path]:
    """NAME.md and a CSV file for each table."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / f"{result.name}.md"]
    paths[0].write_text(result.markdown(), encoding="utf-8")
    for table in result.tables:
        paths.append(folder / f"{result.name}_{table.name}.csv")
        paths[-1].write_text(table.csv(), encoding="utf-8")
    return paths
