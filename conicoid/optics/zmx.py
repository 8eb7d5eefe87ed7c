"""Lens files of Zemax: sequences of conics, as text."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..formats.errors import Problem, SceneFileError
from ..shapes.calls import explained
from ..shapes.validate import path as checked_path
from ..shapes.validate import shown, what
from .prescriptions import Prescription
from .row_media import Medium, by_abbe, catalogued, medium
from .rows import MOST_ROWS
from .zmx_system import system_of

LARGEST = 8_000_000
"""Bytes of a file."""
_LONGEST = 20_000
_MOST_LINES = 200_000
_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d{1,4})?\Z")
_UNITS = ("MM", "CM", "IN", "METER", "M")
_NO_GLASS = (1.5, 40.0)
"""What stands for index and Abbe number where the file does not say them."""


class Refused(Exception):
    """What a line says that cannot be had; `line` counts from 1."""

    def __init__(self, line: int, where: str, message: str) -> None:
        super().__init__(message)
        self.line, self.where, self.message = line, where, message


@dataclass
class Surface:
    """A surface as the file has it, and the lines where it says so."""

    number: int
    line: int
    kind: str = "STANDARD"
    curvature: float = 0.0
    thickness: float = 0.0
    glass: list[str] = field(default_factory=list)
    glass_line: int = 0
    semi: float = 0.0
    conic: float = 0.0
    hole: float = 0.0
    stop: bool = False
    comment: str = ""
    parameters: dict[str, tuple[float, int]] = field(default_factory=dict)
    kind_line: int = 0


@dataclass
class Lens:
    """A file as it is read."""

    surfaces: list[Surface] = field(default_factory=list)
    aperture: tuple[str, float] | None = None
    waves: dict[int, float] = field(default_factory=dict)
    wave_count: int = 0
    primary: int = 1
    field_kind: int = 0
    field_count: int = 1
    fields: list[float] = field(default_factory=list)
    name: str = ""
    unit: str = "MM"
    notes: list[str] = field(default_factory=list)


@explained
def load_zmx(path: str | os.PathLike[str], *, glasses: Mapping[str, Any] | None = None) -> Prescription:
    """The `Prescription` of a Zemax lens file (.zmx); its `scene` holds the lenses.

    Surfaces that are conics are read: STANDARD ones, and aspheres without aspheric terms. Any other type is refused by
    name, with its line; `left_out` of the prescription tells what was passed over. Lengths keep the file's unit.

    path: of the file, in UTF-16, UTF-8 or Latin-1.
    glasses: media by name, as for a `Row`: for glasses that neither `co.optics.glass` nor the file itself knows.
    Raises `SceneFileError`, a ValueError, with the line; a FileNotFoundError where there is no such file.
    """
    file = Path(checked_path("load_zmx", path))
    with open(file, "rb") as source:
        data = source.read(LARGEST + 1)
    return _read(_decoded(data, os.fspath(file)), os.fspath(file), glasses)


@explained
def read_zmx(text: str, *, glasses: Mapping[str, Any] | None = None) -> Prescription:
    """The `Prescription` of the text of a Zemax lens file, as `load_zmx` reads it.

    text: of the file. glasses: media by name, as for `load_zmx`.
    """
    if not isinstance(text, str):
        raise TypeError(f"read_zmx: text must be a text, got {what(text)}")
    if len(text) > LARGEST:
        raise SceneFileError("text", [Problem(0, 0, "", f"is longer than {LARGEST:,} characters")])
    return _read(text, "text", glasses)


def _read(text: str, name: str, glasses: Mapping[str, Any] | None) -> Prescription:
    if glasses is not None and not isinstance(glasses, Mapping):
        raise TypeError(f"load_zmx: glasses must map names to media, got {what(glasses)}")
    try:
        lens = _parsed(text)
        return system_of(lens, lambda surface: _medium(surface, lens, glasses or {}))
    except Refused as problem:
        raise SceneFileError(name, [Problem(problem.line, 1, problem.where, problem.message)]) from None
    except ValueError as error:
        raise SceneFileError(name, [Problem(0, 0, "", str(error))]) from None


def _decoded(data: bytes, name: str) -> str:
    """The text of a file, by its byte order mark, else UTF-8, else Latin-1."""
    if len(data) > LARGEST:
        raise SceneFileError(name, [Problem(0, 0, "", f"is larger than {LARGEST:,} bytes")])
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


def _parsed(text: str) -> Lens:
    lens = Lens()
    lines = text.splitlines()
    if len(lines) > _MOST_LINES:
        raise Refused(0, "", f"has more than {_MOST_LINES:,} lines")
    for number, line in enumerate(lines, 1):
        if len(line) > _LONGEST:
            raise Refused(number, "", f"is longer than {_LONGEST:,} characters")
        words = line.split()
        if not words:
            continue
        key, rest = words[0].upper(), words[1:]
        if key == "SURF":
            _new_surface(lens, number, rest)
        elif lens.surfaces and line[:1].isspace():
            _of_surface(lens, lens.surfaces[-1], number, key, rest)
        else:
            _of_system(lens, number, key, rest, line)
    if len(lens.surfaces) < 3:
        told = "SURF 0 is the object, the last one the image, and there is a lens between them"
        raise Refused(0, "", f"must have at least 3 surfaces: {told}; got {len(lens.surfaces)}")
    return lens


def _new_surface(lens: Lens, line: int, rest: list[str]) -> None:
    if len(lens.surfaces) > MOST_ROWS:
        raise Refused(line, "SURF", f"there are more than {MOST_ROWS:,} surfaces")
    expected = len(lens.surfaces)
    number = _whole(line, "SURF", rest, 0)
    if number != expected:
        raise Refused(line, "SURF", f"must be number {expected}, as they are counted in order, got {number}")
    lens.surfaces.append(Surface(number, line))


def _of_surface(lens: Lens, surface: Surface, line: int, key: str, rest: list[str]) -> None:
    """One line of a surface."""
    where = f"surface {surface.number}: {key}"
    if key == "TYPE":
        surface.kind, surface.kind_line = (rest[0].upper() if rest else ""), line
    elif key == "CURV":
        surface.curvature = _number(line, where, rest, 0)
    elif key == "DISZ":
        far = bool(rest) and rest[0].upper().startswith("INF")
        surface.thickness = math.inf if far else _number(line, where, rest, 0)
    elif key == "CONI":
        surface.conic = _number(line, where, rest, 0)
    elif key == "DIAM":
        surface.semi = _number(line, where, rest, 0)
    elif key == "GLAS":
        surface.glass, surface.glass_line = rest, line
    elif key == "STOP":
        surface.stop = True
    elif key == "COMM":
        surface.comment = " ".join(rest)[:200]
    elif key == "PARM":
        surface.parameters[rest[0] if rest else ""] = _number(line, where, rest, 1), line
    elif key == "CLAP":
        surface.hole = max(0.0, _number(line, where, rest, 1)) if len(rest) > 2 else 0.0
    elif key in _PASSED_OVER:
        lens.notes.append(f"line {line}: surface {surface.number}: {_PASSED_OVER[key]} ({key}) is passed over")


_PASSED_OVER = {
    "SQAP": "a rectangular aperture", "ELAP": "an elliptic aperture", "UDAD": "an aperture drawn by the user",
    "OBSC": "a round obscuration", "SQOB": "a rectangular obscuration", "ELOB": "an elliptic obscuration",
    "SPID": "a spider", "COAT": "a coating", "OBDC": "a decentred aperture",
}  # fmt: skip


def _of_system(lens: Lens, line: int, key: str, rest: list[str], whole: str) -> None:
    """One line that is of no surface."""
    if key == "MODE" and rest and rest[0].upper() != "SEQ":
        raise Refused(line, "MODE", f"must be SEQ, a sequence of surfaces, got {shown(rest[0])}")
    if key == "NAME":
        lens.name = whole.split(None, 1)[1].strip()[:200] if rest else ""
    elif key == "UNIT" and rest:
        lens.unit = rest[0].upper()
        if lens.unit not in _UNITS:
            raise Refused(line, "UNIT", f"must be one of {', '.join(_UNITS)}, got {shown(rest[0])}")
    elif key in ("ENPD", "FNUM", "OBNA"):
        lens.aperture = key, _number(line, key, rest, 0)
        if not lens.aperture[1] > 0:
            lens.aperture = None
    elif key == "FLOA":
        lens.aperture = key, 0.0
    elif key == "WAVM":
        lens.waves[_whole(line, key, rest, 0)] = _number(line, key, rest, 1)
    elif key == "WAVL":
        lens.waves = {i: _number(line, key, rest, i - 1) for i in range(1, min(len(rest), 24) + 1)}
    elif key == "PWAV":
        lens.primary = _whole(line, key, rest, 0)
    elif key == "FTYP":
        lens.field_kind = _whole(line, key, rest, 0)
        lens.field_count = _whole(line, key, rest, 2) if len(rest) > 2 else 1
        lens.wave_count = _whole(line, key, rest, 3) if len(rest) > 3 else 0
    elif key == "YFLN":
        lens.fields = [_number(line, key, rest, i) for i in range(min(len(rest), 100))]
    elif key == "MNUM" and rest and _whole(line, key, rest, 0) > 1:
        lens.notes.append(f"line {line}: of {rest[0][:9]} configurations (MNUM) the one that the surfaces say is read")


def _number(line: int, where: str, rest: list[str], place: int) -> float:
    """A number of a line."""
    text = rest[place] if place < len(rest) else ""
    value = float(text) if _NUMBER.match(text) else math.nan
    if not math.isfinite(value) or (value and not 1e-100 <= abs(value) <= 1e100):
        raise Refused(line, where, f"must have a finite number at place {place + 1}, got {shown(text)}")
    return value


def _whole(line: int, where: str, rest: list[str], place: int) -> int:
    value = _number(line, where, rest, place)
    if value != int(value) or abs(value) > 1e6:
        raise Refused(line, where, f"must have a whole number at place {place + 1}, got {shown(rest[place])}")
    return int(value)


def _medium(surface: Surface, lens: Lens, glasses: Mapping[str, Any]) -> Any:
    """The medium behind a surface: the caller's by that name, the catalogue's, or by the numbers of the line."""
    name, line, where = surface.glass[0], surface.glass_line, f"surface {surface.number}: GLAS"
    if name.upper() == "MIRROR":
        return "mirror"
    if name in glasses:
        try:
            found = medium("glasses", name, glasses[name])
        except (TypeError, ValueError) as error:
            raise Refused(line, where, str(error)) from None
        return found if found.is_air else Medium(name, found.refractive_index)
    if (known := catalogued(name)) is not None:
        return known
    if len(surface.glass) > 4:
        index, abbe = (_number(line, where, surface.glass, place) for place in (3, 4))
        model = surface.glass[1] not in ("0",)
        if index > 1 and abbe >= 0 and (model or (index, abbe) != _NO_GLASS):
            lens.notes.append(
                f"line {line}: surface {surface.number}: {name[:40]} by its index {index:g} and Abbe number {abbe:g}"
            )
            return by_abbe(name, index, abbe)
    told = f"is not in the catalogue: glasses={{{name[:40]!r}: index}} says its refractive index"
    raise Refused(line, where, f"{shown(name)} {told}")


__all__ = ["Lens", "Refused", "Surface", "load_zmx", "read_zmx"]
