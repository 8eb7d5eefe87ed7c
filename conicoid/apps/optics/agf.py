"""Catalogues of glasses in Zemax's format (.agf): formulas of refractive indices by the names of glasses."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

from ..._util.files import Problem, SceneFileError, read_regular
from ..._util.text import format_count
from ..._util.validation import check_path as checked_path, describe_kind, format_value, warn
from ...materials.dispersion import CatalogueFormula, Dispersion, Schott, Sellmeier

LARGEST, MOST_LINES, LONGEST_LINE = 8_000_000, 200_000, 20_000
"""The most bytes of a file, its lines, and characters of a line."""
NUMBER = re.compile(r"[-+]?(?:\d++(?:\.\d*+)?|\.\d++)(?:[eE][-+]?\d{1,4})?\Z", re.ASCII)
"""A number of a file: Python's `float` takes underscores and digits of all scripts as well."""


class ZmxError(Exception):
    """An error in a line of the file; `line` counts from 1."""

    def __init__(self, line: int, where: str, message: str) -> None:
        super().__init__(message)
        self.line, self.where, self.message = line, where, message

    def of_file(self, name: str | os.PathLike[str]) -> SceneFileError:
        """Return the error for the file of that name."""
        return SceneFileError(name, [Problem(self.line, 1 if self.line else 0, self.where, self.message)])


_TERMS = {2: 3, 6: 4, 11: 5}
"""Number of Sellmeier's formulas -> terms."""
_FORMULAS = range(1, 14)


def load_agf(path: str | os.PathLike[str]) -> dict[str, Dispersion]:
    """Load the refractive indices of a catalogue of glasses in Zemax's format (.agf), by name.

    Parameters
    ----------
    path : path
        The file.

    Returns
    -------
    dict
        Name -> `Dispersion`, as `glasses=` of `co.load`, `load_zmx` and materials take them. Of two glasses of one name
        the first counts, as in Zemax. A glass that cannot be read is left out, and a warning names its line.

    Raises
    ------
    SceneFileError
        No glass can be read; a ValueError with the lines.
    FileNotFoundError
        If there is no such file.
    """
    file = Path(checked_path("load_agf", path))
    found: dict[str, Dispersion | None] = {}
    problems: list[Problem] = []
    try:
        lines = split_lines(decode_text(read_regular(file, LARGEST), os.fspath(file)))
    except ZmxError as error:
        raise error.of_file(file) from None
    begins = [line for line, text in enumerate(lines) if text.split()[:1] == ["NM"]]
    for begin, end in pairwise([*begins, len(lines)]):
        name = " ".join(lines[begin].split()[1:2])
        try:
            found.setdefault(name, _read_glass(lines[begin:end], begin + 1, name, file.name))
        except ZmxError as error:
            found.setdefault(name, None)
            problems += error.of_file(file).problems
    glasses = {name: glass for name, glass in found.items() if glass is not None}
    if not glasses:
        raise SceneFileError(file, problems or [Problem(0, 0, "", "holds no glass: no line begins with NM")])
    if problems:
        warn(f"{format_count(len(problems), 'glass', 'glasses')} left out:\n{SceneFileError(file, problems)}")
    return glasses


def _read_glass(lines: list[str], first: int, name: str, source: str) -> Dispersion:
    """Return a glass from its lines; the first begins with NM, and is line `first` of the file."""
    number = whole_number(first, "NM", lines[0].split()[1:], 1)
    row: list[float] = []
    span: tuple[float, float] | None = None
    last = "NM"
    for line, text in enumerate(lines[1:], first + 1):
        key, *rest = text.split() or [""]
        if last == "CD" and re.match(r"[-+.\d]", key):  # some makers break the line of coefficients
            row += _numbers(line, f"{name}: CD", [key, *rest])
            continue
        last = key
        if key == "CD":
            row = _numbers(line, f"{name}: CD", rest)
        elif key == "LD":
            low, high = (line_number(line, f"{name}: LD", rest, place) for place in (0, 1))
            span = (low, high) if low and high else None  # an end of 0 is no wavelength: the file states none
    return _formula(first, number, row, span, name, source)


def split_lines(text: str) -> list[str]:
    """Return the lines of a text; raise ZmxError if there are too many, or one is too long."""
    lines = text.splitlines()
    if len(lines) > MOST_LINES:
        raise ZmxError(0, "", f"has more than {MOST_LINES:,} lines")
    for number, line in enumerate(lines, 1):
        if len(line) > LONGEST_LINE:
            raise ZmxError(number, "", f"is longer than {LONGEST_LINE:,} characters")
    return lines


def line_number(line: int, where: str, rest: list[str], place: int) -> float:
    """Return the number at a place of a line; raise ZmxError for none."""
    text = rest[place] if place < len(rest) else ""
    value = float(text) if NUMBER.match(text) else math.nan
    if not math.isfinite(value) or (value and not 1e-100 <= abs(value) <= 1e100):
        raise ZmxError(line, where, f"must have a finite number at place {place + 1}, got {format_value(text)}")
    return value


def whole_number(line: int, where: str, rest: list[str], place: int) -> int:
    """Return the whole number at a place of a line; raise ZmxError for none."""
    value = line_number(line, where, rest, place)
    if value != int(value) or abs(value) > 1e6:
        raise ZmxError(line, where, f"must have a whole number at place {place + 1}, got {format_value(rest[place])}")
    return int(value)


def _numbers(line: int, where: str, rest: list[str]) -> list[float]:
    return [line_number(line, where, rest, place) for place in range(len(rest))]


def _formula(
    line: int, number: int, row: Sequence[float], span: tuple[float, float] | None, name: str, source: str
) -> Dispersion:
    """Return the refractive index of a glass, by a class of scene files where there is one."""
    if not row:
        raise ZmxError(line, name, "must have coefficients: a line CD with numbers")
    if number not in _FORMULAS:
        raise ZmxError(line, name, f"must have a formula from 1 to 13, got {number}")
    c = (*row, *[0.0] * 10)
    try:
        if number == 1:
            return Schott(c[:6], span, name, source)
        if number in _TERMS:
            ends = 2 * _TERMS[number]
            return Sellmeier(c[:ends:2], c[1:ends:2], 0.0, span, name, source)
        if number == 9:
            return Sellmeier((c[1], c[3]), (c[2], c[4]), c[0] - 1.0, span, name, source)
        return CatalogueFormula(number, tuple(row), span, name, source)
    except ValueError as error:
        raise ZmxError(line, name, str(error)[:200]) from None


def glasses_by_name(owner: str, glasses: Any) -> Mapping[str, Any]:
    """Return media by name: a mapping as it is, of None none, and of a path the catalogue in this file."""
    if glasses is None or isinstance(glasses, Mapping):
        return glasses or {}
    if isinstance(glasses, str | os.PathLike):
        return load_agf(glasses)
    raise TypeError(
        f"{owner}: glasses must map names to media or be the path of an .agf file, got {describe_kind(glasses)}"
    )


def decode_text(data: bytes, name: str) -> str:
    """Return the text of a file, by its byte order mark, else UTF-8, else Latin-1."""
    if len(data) > LARGEST:
        raise SceneFileError(name, [Problem(0, 0, "", f"is larger than {LARGEST:,} bytes")])
    # Zemax writes UTF-16, other programs and editors one of the others
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        text = data.decode("utf-16", errors="replace")
    else:
        try:
            text = data.decode("utf-8-sig")
        except UnicodeDecodeError:
            text = data.decode("latin-1")
    if "\0" in text:
        raise SceneFileError(name, [Problem(0, 0, "", "is no text: it holds NUL characters")])
    return text
