"""Zemax lens files (.zmx): parse their text, and make a prescription of it.

Only sequences of conics are supported.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable, Mapping
from dataclasses import field, replace
from itertools import zip_longest
from pathlib import Path
from typing import Any

from ..._util.files import Problem, SceneFileError, read_regular
from ..._util.records import dataclass
from ..._util.text import format_count
from ..._util.validation import check_path as checked_path, describe_kind, format_value
from ...io.importers import ImportOptions, ImportResult, select_bodies
from ...materials.dispersion import LINE_D, glasses
from . import prescriptions
from .agf import LARGEST, NUMBER, ZmxError, decode_text, glasses_by_name, line_number, split_lines, whole_number
from .medium import Medium, find_glass, medium_by_abbe, parse_medium
from .prescriptions import MOST_ROWS, Prescription, Row, prescription

_CONICS = ("STANDARD",)
_ASPHERES = ("EVENASPH", "ODDASPHE", "XASPHERE", "XOASPHER")
_ANGLE, _HEIGHT, _PARAXIAL_IMAGE, _REAL_IMAGE = 0, 1, 2, 3


# From the parsed file to a prescription.


def build_prescription(lens: ZmxLens, media: Mapping[int, Any]) -> Prescription:
    """Return the prescription of a file; `media` has the medium behind each surface by number, or None."""
    for surface in lens.surfaces:
        _check_kind(surface)
    # The first is the object and the last the image: neither is glass
    rows = [_row(surface, media[surface.number], lens.notes) for surface in lens.surfaces[1:-1]]
    distance = lens.surfaces[0].thickness
    waves = _wavelengths(lens)
    # Aperture and fields may depend on focal length and pupil: first a system with any aperture.
    system = prescription(rows, 1.0, object_distance=_far(distance), wavelengths=waves, name=lens.name)
    aperture = _aperture(lens, system)
    fields = _fields(lens, system)
    result = prescription(
        rows, aperture, object_distance=_far(distance), wavelengths=waves, fields=fields, name=lens.name
    )
    if not result.bodies:
        lens.notes.append("there are no bodies: no surface has glass, is a mirror, or is the stop")
    return replace(result, omissions=(*lens.notes, *_unknown_keywords(lens)), unit=_UNITS[lens.unit])


def _unknown_keywords(lens: ZmxLens) -> list[str]:
    """Return a note for each keyword that is not known, with its first line and the number of its lines."""
    return [
        f"line {line}: {key[:20]!r} is not known, and not read" + (f"; {count:,} lines begin so" if count > 1 else "")
        for key, (line, count) in lens.unknown.items()
    ]


def _far(distance: float) -> float:
    """Return the distance of the object; 0, and a distance beyond a light year, is infinite as that of a star."""
    return distance if 0 < distance < 1e10 else math.inf


def _check_kind(surface: ZmxSurface) -> None:
    """Refuse surfaces that are no conics."""
    line, where = surface.kind_line or surface.line, f"surface {surface.number}: TYPE"
    # An asphere whose terms are all 0 is a conic
    terms = [(f"PARM {key}", line) for key, (value, line) in surface.parameters.items() if value != 0]
    # Extended aspheres hold the number of terms, a radius, and the terms
    terms += [(f"XDAT {key}", line) for key, (value, line) in surface.extra.items() if value != 0 and key not in "12"]
    if surface.kind in _CONICS:
        return
    if surface.kind in _ASPHERES:
        if terms:
            reason = f"has the aspheric term {terms[0][0][:13]}, which makes it no conic"
            raise ZmxError(terms[0][1], where, f"{surface.kind} {reason}")
        return
    if surface.kind == "COORDBRK":
        message = "COORDBRK tilts or shifts the axis, and all surfaces must have one axis: "
        hint = "remove it, or write the surfaces before and behind it as files of their own, and move their bodies"
        raise ZmxError(line, where, message + hint)
    supported = f"only conics are: {', '.join((*_CONICS, *_ASPHERES))} (these without aspheric terms)"
    raise ZmxError(line, where, f"{surface.kind[:40]!r} is not supported; {supported}")


def _row(surface: ZmxSurface, next_medium: Any, notes: list[str]) -> Row:
    """Return the row of a surface, and add notes on the parts that it leaves out."""
    thickness = surface.thickness
    if math.isinf(thickness):
        raise ZmxError(surface.line, f"surface {surface.number}: DISZ", "must be finite, but for the object's")
    # Files hold curvatures, since a plane has no radius
    radius = 1 / surface.curvature if surface.curvature else math.inf
    reflects = next_medium == "mirror"
    if surface.hole and not reflects:
        note = f"line {surface.clap_line}: surface {surface.number}: the inner radius of an aperture (CLAP) is skipped"
        notes.append(f"{note}, as only mirrors have holes")
    # An aperture stops light; beyond it there is glass, which does nothing
    radius_of_opening = min((one for one in (abs(surface.semi), surface.opening) if one), default=0.0)
    try:
        return Row(
            radius, thickness, next_medium, 2 * radius_of_opening or None, surface.conic, surface.stop,
            2 * surface.hole if reflects else 0.0, surface.comment,
        )  # fmt: skip
    except (TypeError, ValueError) as error:
        raise ZmxError(surface.line, f"surface {surface.number}", str(error)) from None


def _wavelengths(lens: ZmxLens) -> tuple[float, ...]:
    """Return the wavelengths in use, the primary one first."""
    count = lens.wave_count or max(lens.waves, default=1)
    # Files list all 24 wavelengths; only the first `count` are in use.
    waves = [lens.waves[i] for i in sorted(lens.waves) if i <= min(count, 24) and lens.waves[i] > 0]
    primary = lens.waves.get(lens.primary, waves[0] if waves else LINE_D)
    return (primary, *(wave for wave in waves if wave != primary))


def _focal_length(system: Prescription) -> float:
    """Return the paraxial focal length, infinite if the system is afocal."""
    bend = prescriptions.system_matrix(system.thin(system.wavelength))[2]
    return -1 / bend if bend else math.inf


def _aperture(lens: ZmxLens, system: Prescription) -> float | None:
    """Return the diameter of the entrance pupil; None is that of the stop's image."""
    kind, value, option = lens.aperture or ("FLOA", 0.0, 0)
    near = not math.isinf(system.object_distance)
    if kind == "ENPD":
        return value
    # The f-number is that of the whole system, so the focal length had to come first
    if kind == "FNUM" and not (option and near):
        return abs(_focal_length(system)) / value
    if kind == "FNUM":  # 1 / (2 u') of the ray from a near object
        _, _, c, d = prescriptions.system_matrix(system.thin(system.wavelength))
        slope = abs(c * system.object_distance + d)
        return abs(system.object_distance + system.pupil) / (value * slope) if slope else None
    if kind == "OBNA" and near and value < (90 if option else 1):
        angle = math.radians(value) if option else math.asin(value)
        return 2 * (system.object_distance + system.pupil) * math.tan(angle)
    if kind == "OBNA":
        lens.notes.append(f"the aperture at the object (OBNA {value:g} {option}) is skipped: the stop's size counts")
    return None


def _fields(lens: ZmxLens, system: Prescription) -> tuple[float, ...]:
    """Return angles, or heights of a near object."""
    count = max(1, min(lens.field_count, 24))
    numbers, across = lens.fields[:count] or [0.0], lens.x_fields[:count]
    if any(across):
        # tan² of an angle, or the square of a height, is the sum of those of both components
        tan, angle_of = (_tan, _arctan) if lens.field_kind == _ANGLE else (float, float)
        pairs = zip_longest(across, numbers, fillvalue=0.0)
        numbers = [angle_of(math.hypot(tan(x), tan(y))) if x else y for x, y in pairs]
        lens.notes.append("fields beside the y axis (XFLN) are turned to it about the axis of the lens")
    far = math.isinf(system.object_distance)
    if lens.field_kind == (_ANGLE if far else _HEIGHT):
        return tuple(numbers)
    if far and lens.field_kind in (_PARAXIAL_IMAGE, _REAL_IMAGE):
        if lens.field_kind == _REAL_IMAGE and any(numbers):
            lens.notes.append("fields by real heights of the image are those of the paraxial heights")
        f = _focal_length(system)
        # The height of the image of a far point is f tan(angle)
        return tuple(math.degrees(math.atan(height / f)) for height in numbers)
    if not far and lens.field_kind == _ANGLE:
        # The chief ray goes to the middle of the entrance pupil
        return tuple(-math.tan(math.radians(angle)) * (system.object_distance + system.pupil) for angle in numbers)
    lens.notes.append(f"fields of the type {lens.field_kind} are skipped")
    return (0.0,)


def _tan(degrees: float) -> float:
    return math.tan(math.radians(degrees))


def _arctan(slope: float) -> float:
    return math.degrees(math.atan(slope))


# The parser of lens files.

_UNITS = {"MM": "mm", "CM": "cm", "IN": "in", "METER": "m", "M": "m"}
_NO_GLASS = (1.5, 40.0)
"""Index and Abbe number that stand for "not in the file"."""


class UnknownGlass(ZmxError):
    """A glass for which nothing gives an index."""


@dataclass
class ZmxSurface:
    """A surface in the terms of the file, with its line numbers."""

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
    opening: float = 0.0
    clap_line: int = 0
    stop: bool = False
    comment: str = ""
    parameters: dict[str, tuple[float, int]] = field(default_factory=dict)
    extra: dict[str, tuple[float, int]] = field(default_factory=dict)
    kind_line: int = 0


@dataclass
class ZmxLens:
    """The parsed file."""

    surfaces: list[ZmxSurface] = field(default_factory=list)
    aperture: tuple[str, float, int] | None = None
    waves: dict[int, float] = field(default_factory=dict)
    wave_count: int = 0
    primary: int = 1
    field_kind: int = 0
    field_count: int = 1
    fields: list[float] = field(default_factory=list)
    x_fields: list[float] = field(default_factory=list)
    name: str = ""
    unit: str = "MM"
    notes: list[str] = field(default_factory=list)
    unknown: dict[str, tuple[int, int]] = field(default_factory=dict)
    """Keyword -> (line of the first, number of lines)."""
    has_end: bool = False
    """Whether tolerances, configurations or the merit function have begun, which follow the surfaces."""


def load_zmx(
    path: str | os.PathLike[str], *, glasses: Mapping[str, Any] | str | os.PathLike[str] | None = None
) -> Prescription:
    """Load the `Prescription` of a Zemax lens file (.zmx); its `scene` holds the lenses.

    Surfaces that are conics are read: STANDARD ones, and aspheres without aspheric terms. Any other type is an error
    with its name and line; `omissions` of the prescription lists skipped parts. Lengths keep the file's
    `unit`.

    Parameters
    ----------
    path : path
        Of the file, in UTF-16, UTF-8 or Latin-1.
    glasses : Mapping or path, optional
        Media by name, as for a `Row`, or the path of a catalogue (.agf). They count before the catalogue of
        `co.optics.glass`, and before the index in the file.

    Returns
    -------
    Prescription

    Raises
    ------
    SceneFileError
        A ValueError with the line.
    FileNotFoundError
        If there is no such file.
    """
    file = Path(checked_path("load_zmx", path))
    return _read(decode_text(read_regular(file, LARGEST), os.fspath(file)), os.fspath(file), glasses)


def read_zmx(text: str, *, glasses: Mapping[str, Any] | str | os.PathLike[str] | None = None) -> Prescription:
    """Read the `Prescription` from the text of a Zemax lens file, as `load_zmx`.

    Parameters
    ----------
    text : str
        Of the file.
    glasses : Mapping or path, optional
        Media by name, or the path of a catalogue, as for `load_zmx`.

    Returns
    -------
    Prescription

    Raises
    ------
    SceneFileError
        A ValueError with the line.
    """
    if not isinstance(text, str):
        raise TypeError(f"read_zmx: text must be a text, got {describe_kind(text)}")
    if len(text) > LARGEST:
        raise SceneFileError("text", [Problem(0, 0, "", f"is longer than {LARGEST:,} characters")])
    return _read(text, "text", glasses)


def _read(text: str, name: str, glasses: Mapping[str, Any] | str | os.PathLike[str] | None) -> Prescription:
    """Return the prescription of a text; errors get the file's name."""
    media, by_name = {}, glasses_by_name("load_zmx", glasses)
    try:
        lens = _parse(text)
        missing = []
        for surface in lens.surfaces[1:-1]:
            try:
                media[surface.number] = _medium(surface, lens, by_name) if surface.glass else None
            except UnknownGlass as problem:
                missing.append(Problem(problem.line, 1, problem.where, problem.message))
        if missing:
            raise SceneFileError(name, missing)
        try:
            return build_prescription(lens, media)
        except ValueError as error:
            raise _error_of_rows(lens, str(error)) from None
    except ZmxError as problem:
        raise problem.of_file(name) from None


def _error_of_rows(lens: ZmxLens, message: str) -> ZmxError:
    """Return the error of a prescription in the file's numbers: its row i is the surface i + 1."""
    numbers = [int(row) + 1 for row in _ROW.findall(message)]
    line = lens.surfaces[numbers[0]].line if numbers else 0
    named = _ROW.sub(lambda row: f"surface {int(row[1]) + 1}", message.removeprefix("prescription: "))
    return ZmxError(line, "", named)


_ROW = re.compile(r"rows\[(\d{1,6})\]")


def _parse(text: str) -> ZmxLens:
    """Parse all lines of a text."""
    lens = ZmxLens()
    for number, line in enumerate(split_lines(text), 1):
        words = line.split()
        if not words:
            continue
        key, rest = words[0].upper(), words[1:]
        if key == "SURF":
            _new_surface(lens, number, rest)
        # Zemax indents the lines of a surface; other programs and pages do not, so that the keyword decides.
        elif lens.surfaces and not lens.has_end and (key in _SURFACE_KEYWORDS or line[:1].isspace()):
            _of_surface(lens, lens.surfaces[-1], number, key, rest)
        else:
            _of_system(lens, number, key, rest, line)
    if len(lens.surfaces) < 3:
        roles = "SURF 0 is the object, the last one the image, and there is a lens between them"
        raise ZmxError(0, "", f"must have at least 3 surfaces: {roles}; got {len(lens.surfaces)}")
    return lens


def _new_surface(lens: ZmxLens, line: int, rest: list[str]) -> None:
    """Begin a surface."""
    if len(lens.surfaces) > MOST_ROWS:
        raise ZmxError(line, "SURF", f"there are more than {MOST_ROWS:,} surfaces")
    expected = len(lens.surfaces)
    number = whole_number(line, "SURF", rest, 0)
    if number != expected:
        raise ZmxError(line, "SURF", f"must be number {expected}, as they are counted in order, got {number}")
    lens.surfaces.append(ZmxSurface(number, line))
    lens.has_end = False


def _of_surface(lens: ZmxLens, surface: ZmxSurface, line: int, key: str, rest: list[str]) -> None:
    """Parse one line of a surface."""
    where = f"surface {surface.number}: {key}"
    if key == "TYPE":
        surface.kind, surface.kind_line = (rest[0].upper() if rest else ""), line
    elif key == "CURV":
        surface.curvature = line_number(line, where, rest, 0)
    elif key == "DISZ":
        # The word INFINITY stands for an object at infinity.
        far = bool(rest) and rest[0].upper().startswith("INF")
        surface.thickness = math.inf if far else line_number(line, where, rest, 0)
    elif key == "CONI":
        surface.conic = line_number(line, where, rest, 0)
    elif key == "DIAM":
        surface.semi = line_number(line, where, rest, 0)
    elif key == "GLAS":
        surface.glass, surface.glass_line = rest, line
    elif key == "STOP":
        surface.stop = True
    elif key == "COMM":
        surface.comment = " ".join(rest)[:200]
    elif key == "PARM":
        surface.parameters[rest[0] if rest else ""] = line_number(line, where, rest, 1), line
    elif key == "XDAT":
        surface.extra[rest[0] if rest else ""] = line_number(line, where, rest, 1), line
    elif key == "CLAP":
        radii = [max(0.0, line_number(line, where, rest, place)) for place in range(min(len(rest), 2))]
        surface.hole, surface.opening = (*radii, 0.0, 0.0)[:2]
        surface.clap_line = line
    elif key in _IGNORED_KEYWORDS:
        lens.notes.append(f"line {line}: surface {surface.number}: {_IGNORED_KEYWORDS[key]} ({key}) is skipped")
    elif key not in _SURFACE_KEYWORDS:
        _of_system(lens, line, key, rest, " ".join((key, *rest)))


_IGNORED_KEYWORDS = {
    "SQAP": "a rectangular aperture", "ELAP": "an elliptic aperture", "UDAD": "an aperture drawn by the user",
    "OBSC": "a round obscuration", "SQOB": "a rectangular obscuration", "ELOB": "an elliptic obscuration",
    "SPID": "a spider", "COAT": "a coating", "OBDC": "a decentred aperture", "SCBD": "a tilt or shift of a surface",
}  # fmt: skip
"""Keywords of surfaces that are skipped with a note."""
_SURFACE_KEYWORDS = frozenset(
    "TYPE CURV DISZ CONI DIAM GLAS STOP COMM PARM XDAT CLAP FLAP HIDE MIRR SLAB POPS FIMP MEMA OEMA SSID VDSZ VPAR "
    "VCON VCUR PPAR PZUP MAZH SCOL EDGE".split()
) | frozenset(_IGNORED_KEYWORDS)
"""All known keywords of surfaces: those without effect here are drawing, width of glass, and how numbers were found."""
_NEUTRAL_KEYWORDS = frozenset(
    "VERS LANG PFIL NOTE BLNK AUTH GCAT PUSH SDMA ROPD PICB FWGN WWGN WWGT GLRS POLS GSTD NSCD COFN COTN HYPR DMFS "
    "IWDP LUID EERA STUD RCMF WAVN FCOM OMMA".split()
)
"""Keywords without effect on the prescription: names, weights, and settings of Zemax's own programs."""
_END_KEYWORDS = ("TOL", "MNUM", "MOFF")
_VIGNETTING = ("VDXN", "VDYN", "VCXN", "VCYN", "VANN", "ZVDX", "ZVDY", "ZVCX", "ZVCY", "ZVAN")


def _of_system(lens: ZmxLens, line: int, key: str, rest: list[str], whole: str) -> None:
    """Parse one line outside of surfaces."""
    if key == "MODE" and rest and rest[0].upper() != "SEQ":
        raise ZmxError(line, "MODE", f"must be SEQ, a sequence of surfaces, got {format_value(rest[0])}")
    lens.has_end = lens.has_end or (bool(lens.surfaces) and key in _END_KEYWORDS)
    if key == "NAME":
        lens.name = whole.split(None, 1)[1].strip()[:200] if rest else ""
    elif key == "UNIT" and rest:
        lens.unit = rest[0].upper()
        if lens.unit not in _UNITS:
            raise ZmxError(line, "UNIT", f"must be one of {', '.join(_UNITS)}, got {format_value(rest[0])}")
    elif key in ("ENPD", "FNUM", "OBNA"):
        option = whole_number(line, key, rest, 1) if key != "ENPD" and len(rest) > 1 else 0
        lens.aperture = key, line_number(line, key, rest, 0), option
        if not lens.aperture[1] > 0:
            lens.aperture = None
    elif key == "FLOA":
        lens.aperture = key, 0.0, 0
    elif key == "WAVM":
        lens.waves[whole_number(line, key, rest, 0)] = line_number(line, key, rest, 1)
    elif key == "WAVL":
        lens.waves = {i: line_number(line, key, rest, i - 1) for i in range(1, min(len(rest), 24) + 1)}
    elif key == "PWAV":
        lens.primary = whole_number(line, key, rest, 0)
    elif key == "FTYP":
        lens.field_kind = whole_number(line, key, rest, 0)
        lens.field_count = whole_number(line, key, rest, 2) if len(rest) > 2 else 1
        lens.wave_count = whole_number(line, key, rest, 3) if len(rest) > 3 else 0
        if _is_set(rest, 1):
            lens.notes.append(f"line {line}: telecentric aiming ({key}) is skipped")
    elif key == "YFLN":
        lens.fields = [line_number(line, key, rest, i) for i in range(min(len(rest), 100))]
    elif key == "XFLN":
        lens.x_fields = [line_number(line, key, rest, i) for i in range(min(len(rest), 100))]
    elif key in _SETTINGS:
        if (note := _SETTINGS[key](rest)) is not None:
            lens.notes.append(f"line {line}: {note} ({key}) is skipped")
    elif not (lens.has_end or key in _NEUTRAL_KEYWORDS or key == "MODE"):
        first, count = lens.unknown.get(key, (line, 0))
        lens.unknown[key] = first, count + 1


def _is_set(rest: list[str], place: int, default: float = 0.0) -> bool:
    """Return whether a line has a number at a place that differs from the one without effect."""
    return place < len(rest) and not (NUMBER.match(rest[place]) and float(rest[place]) == default)


def _vignetting(rest: list[str]) -> str | None:
    return "vignetting of fields" if any(_is_set(rest, place) for place in range(len(rest))) else None


def _environment(rest: list[str]) -> str | None:
    changes = _is_set(rest, 2) and (_is_set(rest, 0, 20.0) or _is_set(rest, 1, 1.0))
    return f"the change of glasses at {rest[0][:9]} degrees and {rest[1][:9]} atmospheres" if changes else None


def _configurations(rest: list[str]) -> str | None:
    return "each configuration but that of the surfaces" if _is_set(rest, 0, 1.0) and _is_set(rest, 0) else None


_SETTINGS: dict[str, Callable[[list[str]], str | None]] = {
    **dict.fromkeys(_VIGNETTING, _vignetting),
    "RAIM": lambda rest: "aiming of rays at the stop" if _is_set(rest, 1) else None,
    "GFAC": lambda rest: "apodization of the pupil" if _is_set(rest, 0) else None,
    "TELE": lambda rest: "telecentric aiming" if _is_set(rest, 0) else None,
    "AFOC": lambda rest: "the mode without a focus" if _is_set(rest, 0) else None,
    "ENVD": _environment,
    "MNUM": _configurations,
}
"""Keywords of the system -> the part that is skipped; None if the line changes nothing."""


_BETTER_MELTS = ("HTULTRA", "HTI", "HT")
"""Endings of Schott's names for melts that are clearer, of the same nominal index."""

_MISC_NAMES = {
    "SILICA": "fused silica", "F_SILICA": "fused silica", "ACRYLIC": "PMMA", "POLYCARB": "polycarbonate",
    "POLYSTYR": "polystyrene",
}  # fmt: skip
"""Names in Zemax's own catalogue of other media -> names in the catalogue here."""


def _other_names(name: str) -> list[str]:
    """Return names of the catalogue for a glass: large letters, without the mark of clear melts, today's for old."""
    large = name.upper()
    if large in _MISC_NAMES:
        return [_MISC_NAMES[large]]
    # Crystals and liquids have small letters in the catalogue; metals, which absorb, are no medium of a lens
    known = [each for each in glasses if each.upper() == large and not getattr(glasses[each], "k", ())]
    plain = next((large.removesuffix(end) for end in _BETTER_MELTS if large.endswith(end)), large)
    return [*known, plain, f"N-{plain}"]


def _medium(surface: ZmxSurface, lens: ZmxLens, glasses: Mapping[str, Any]) -> Any:
    """Return the medium behind a surface: the caller's by that name, the catalogue's, or by the numbers of the line."""
    name, line, where = surface.glass[0], surface.glass_line, f"surface {surface.number}: GLAS"
    if name.upper() == "MIRROR":
        return "mirror"
    if (known := next((each for each in (name, name.upper()) if each in glasses), None)) is not None:
        try:
            own = parse_medium("glasses", name, glasses[known])
        except (TypeError, ValueError) as error:
            raise ZmxError(line, where, str(error)) from None
        return own if own.is_air else Medium(name, own.refractive_index)
    if (catalogued := find_glass(name)) is not None:
        return catalogued
    if len(surface.glass) < 2 or surface.glass[1] == "0":  # else the numbers of the line define it
        for other in _other_names(name):
            if (catalogued := find_glass(other)) is not None:
                lens.notes.append(f"line {line}: surface {surface.number}: {name[:40]} by the formula of {other}")
                return catalogued
    if len(surface.glass) > 4:
        index, abbe = (line_number(line, where, surface.glass, place) for place in (3, 4))
        # Index and Abbe number count unless they are the placeholder of an unmarked glass.
        model = surface.glass[1] not in ("0",)
        if index > 1 and abbe >= 0 and (model or (index, abbe) != _NO_GLASS):
            lens.notes.append(
                f"line {line}: surface {surface.number}: {name[:40]} by its index {index:g} and Abbe number {abbe:g}"
            )
            return medium_by_abbe(name, index, abbe)
    hint = f"is not in the catalogue: glasses={{{name[:40]!r}: index}} gives its refractive index, or glasses=file.agf"
    raise UnknownGlass(line, where, f"{format_value(name)} {hint}")


# Zemax lens files for `co.load`: the scene of a prescription, by the options of all imports.


def import_file(path: str | os.PathLike[str], options: ImportOptions) -> ImportResult:
    """Import the bodies of a lens file; its notes list skipped parts. `load_zmx` returns the prescription itself."""
    options.refuse_others("a Zemax lens file", "strict", "only", "glasses")
    system = load_zmx(path, glasses=options.glasses)
    if len(system.bodies) > options.most.singles:
        raise ValueError(f"load: max_bodies must be at least {len(system.bodies)} for this file")
    first = f"{format_count(len(system.rows), 'surface')}, {format_count(len(system.bodies), 'body')}"
    result = ImportResult(system.bodies, (), (first, *system.omissions), system.omissions, unit=system.unit)
    return result if options.only is None else select_bodies(result, options.only)
