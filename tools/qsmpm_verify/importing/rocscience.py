"""Projects of Rocscience as text: archives that contain sections of `key: value`, for Slide2 (slide.py) and RS2 (rs2.py).

The format is not published. It is taken from two readers that others derived from files of the vendor: xslope (Apache licence)
for Slide2 7 and 9 and RS2 11, slidepyv6 (MIT) for Slide 6. Data on which they differ, or that they do not know, are requested or omitted.
"""

from __future__ import annotations

import re
import zipfile
from dataclasses import dataclass
from pathlib import Path

from qsmpm_verify.importing.gsz import FOOT, LARGEST, POUNDS_PER_CUBIC_FOOT, POUNDS_PER_SQUARE_FOOT
from qsmpm_verify.importing.section import Section
from qsmpm_verify.trouble import Trouble

PAIR = re.compile(r"([A-Za-z_]\w*):\s*(\[[^\]]*\]|\{[^}]*\}|\S+)")


@dataclass(frozen=True)
class Units:
    """Metres, kPa and kN/m3 in the units of a project."""

    metres: float
    stress: float
    weight: float


UNITS = {
    "metric": Units(1.0, 1.0, 1.0), "metric kpa": Units(1.0, 1.0, 1.0), "metric mpa": Units(1.0, 1000.0, 1000.0),
    "imperial": Units(FOOT, POUNDS_PER_SQUARE_FOOT, POUNDS_PER_CUBIC_FOOT), "imperial psf": Units(FOOT, POUNDS_PER_SQUARE_FOOT, POUNDS_PER_CUBIC_FOOT),
}  # fmt: skip


def units_of(name: str, section: Section, path: Path) -> Units:
    """The units of a project."""
    word = " ".join(name.replace('"', " ").lower().split())
    if word not in UNITS:
        raise Trouble(f"{path}: units '{name}' are not supported; known are {', '.join(UNITS)}: save it in one of them, or export DXF")
    if "imperial" in word:
        section.notes.append("in feet and pounds; converted to m and kN")
    return UNITS[word]


def texts_of(path: Path, wanted: tuple[str, ...]) -> dict[str, str]:
    """Texts by name: of the files with these endings in an archive, or of the file itself."""
    if not path.is_file():
        raise Trouble(f"{path}: no such file")
    if not zipfile.is_zipfile(path):
        return {path.name: path.read_bytes().decode("latin-1")}
    with zipfile.ZipFile(path) as archive:
        inside = [info for info in archive.infolist() if info.filename.lower().endswith(wanted)]
        if not inside or any(info.file_size > LARGEST for info in inside):
            raise Trouble(f"{path}: no model in this archive: no file that ends with {' or '.join(wanted)}")
        return {info.filename: archive.read(info).decode("latin-1") for info in inside}


def sections_of(text: str) -> dict[str, list[str]]:
    """Lines by the heading above them: a line without indentation that ends with a colon."""
    found: dict[str, list[str]] = {}
    body: list[str] = []
    for line in text.splitlines():
        if line[:1].strip() and line.rstrip().endswith(":"):
            body = found.setdefault(line.rstrip()[:-1], [])
        else:
            body.append(line.rstrip())
    return found


def pairs_of(line: str) -> dict[str, str]:
    """Values by their keys in a line."""
    return {key: value.rstrip(",") for key, value in PAIR.findall(line)}


def settings_of(lines: list[str]) -> dict[str, str]:
    """One setting per line; the value may be on the next line."""
    found: dict[str, str] = {}
    last = ""
    for line in lines:
        key, colon, value = line.partition(":")
        if colon:
            last = key.strip()
            found[last] = value.strip().strip('"')
        elif last and not found[last]:
            found[last] = line.strip()
    return found


def number(words: dict[str, str], key: str) -> float | None:
    """A number of a line, None if there is none."""
    try:
        return float(words[key])
    except (KeyError, ValueError):
        return None


def times(value: float | None, factor: float) -> float | None:
    """A number in another unit."""
    return None if value is None else value * factor


def whole(words: dict[str, str], key: str) -> int:
    """An integer, 0 if there is none."""
    return int(number(words, key) or 0.0)
