"""Catalogues of glasses in Zemax's format (.agf): formulas of refractive indices by the names of glasses."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..._util.files import Problem, SceneFileError, read_regular
from ..._util.validation import check_path as checked_path, describe_kind, format_value
from ...materials.dispersion import CATALOGUE_FORMULAS, CatalogueFormula, Dispersion, Schott, Sellmeier

LARGEST = 8_000_000
"""The most bytes of a file."""


_TERMS = {2: 3, 6: 4, 11: 5}
"""Number of Sellmeier's formulas -> terms."""


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
        the first counts, as in Zemax.

    Raises
    ------
    SceneFileError
        A ValueError with the line.
    FileNotFoundError
        If there is no such file.
    """
    file = Path(checked_path("load_agf", path))
    found: dict[str, Dispersion] = {}
    name, number, place, last = "", 0, 0, ""
    row: tuple[float, ...] = ()
    span: tuple[float, float] | None = None
    lines = decode_text(read_regular(file, LARGEST), os.fspath(file)).splitlines()
    for line, text in enumerate([*lines, "NM"], 1):
        key, *rest = text.split() or [""]
        try:
            if last == "CD" and re.match(r"[-+.\d]", key):  # some makers break the line of coefficients
                row = (*row, *map(float, (key, *rest)))
                continue
            last = key
            if key == "NM":
                if name:
                    found.setdefault(name, _formula(number, row, span, name, file.name))
                name, number, place, row, span = "", 0, line, (), None
                if line <= len(lines):
                    name, number = rest[0], int(float(rest[1]))
            elif key == "CD":
                row = tuple(map(float, rest))
            elif key == "LD" and name:
                low, high = float(rest[0]), float(rest[1])
                span = (low, high) if low and high else None  # an end of 0 is no wavelength: the file states none
        except IndexError:
            raise SceneFileError(file, [Problem(line, 1, key, f"must have more numbers, got {text[:60]!r}")]) from None
        except (ValueError, OverflowError) as error:
            where = place if key == "NM" and name else line
            raise SceneFileError(file, [Problem(where, 1, name or key, str(error)[:200])]) from None
    if not found:
        raise SceneFileError(file, [Problem(0, 0, "", "holds no glass: no line begins with NM")])
    return found


def _formula(number: int, row: tuple[float, ...], span: Any, name: str, source: str) -> Dispersion:
    """Return the refractive index of a glass, by a class of scene files where there is one."""
    if not row or not all(map(math.isfinite, row)):
        raise ValueError(f"must have coefficients, CD, that are finite numbers, got {format_value(row)}")
    c = (*row, *[0.0] * 10)
    if number == 1:
        return Schott(c[:6], span, name, source)
    if number in _TERMS:
        ends = 2 * _TERMS[number]
        return Sellmeier(c[:ends:2], c[1:ends:2], 0.0, span, name, source)
    if number == 4:  # the second term is b / (λ² - c), which is (b / c) (λ² / (λ² - c) - 1)
        far = c[4] ** 2
        last = c[3] / far if far else 0.0
        return Sellmeier((c[1], last), (c[2] ** 2, far), c[0] - last, span, name, source)
    if number == 9:
        return Sellmeier((c[1], c[3]), (c[2], c[4]), c[0] - 1.0, span, name, source)
    if number not in CATALOGUE_FORMULAS:
        raise ValueError(f"must have a formula from 1 to 13, got {number}")
    return CatalogueFormula(number, row, span, name, source)


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
