"""Parts of all exports: options and results, the report of losses and refusals, formats, bodies, colours, numbers.

A format is a module of this package with a function `export_text(scene, options)`.
"""

from __future__ import annotations

import importlib
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import field
from decimal import Context, Decimal
from fractions import Fraction
from functools import lru_cache
from typing import Any

import numpy as np

from ..._util.arrays import BoxEnds
from ..._util.files import MAX_LISTED_PROBLEMS, printable, write_text
from ..._util.records import dataclass
from ..._util.text import format_count
from ..._util.validation import check_callback, check_flag
from ...geometry.entries import LENGTH_UNITS
from ...geometry.instances import InstanceList
from ...geometry.labels import count_bodies, is_clear, single_body
from ...geometry.shape import Solid
from ...materials.color import amount_rgb, linear_rgb, srgb_encode
from ...materials.material import Material
from ...numerics import bigfloat as ex
from ..importers import limit_notes
from ..scene_file.nodes import shorten
from ..scene_file.scene_file import WritableScene

_MESSAGE_WIDTH = 96
"""Half the characters of a line in the list of bodies that a format refuses."""


@dataclass(frozen=True)
class ExportOptions:
    """Options of an export.

    Attributes
    ----------
    strict
        Raise ValueError, rather than add remarks, if the file holds less than the scene.
    progress
        Function that is called as progress(done, count) with numbers of bodies.
    """

    strict: bool = False
    progress: Callable[[int, int], Any] | None = None

    def __post_init__(self) -> None:
        check_flag("export", "strict", self.strict)
        check_callback("export", "progress", self.progress)


@dataclass(frozen=True)
class ExportResult:
    """The text of a file, all notes on it (`notes`), and those of them that report a loss (`remarks`)."""

    text: str
    notes: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()


class UnsupportedExport(Exception):
    """Raised if a format cannot hold a body; the message names the shape, the field and a remedy."""


@dataclass
class ExportReport:
    """The losses of an export: bodies that the format cannot hold, and bodies that it holds only in part, by kind."""

    format: str
    refusals: list[str] = field(default_factory=list)
    losses: dict[str, list[str]] = field(default_factory=dict)

    @contextmanager
    def about(self, name: str) -> Iterator[None]:
        """Collect the refusal of a body, so that `check` raises one error for all such bodies."""
        try:
            yield
        except UnsupportedExport as error:
            self.refusals.append(f"{quote_body(name)}: {error}")
        except OverflowError:
            self.refusals.append(f"{quote_body(name)}: its numbers leave the range of float64")

    def narrow(self, kind: str, name: str) -> None:
        """Record that the file holds less of a body than the scene; `kind` describes the loss."""
        names = self.losses.setdefault(kind, [])
        if not names or names[-1] != name:  # bodies come one after the other: once per body and kind
            names.append(name)

    def check(self) -> None:
        """Raise ValueError with the refused bodies, or the first of many."""
        if not self.refusals:
            return
        count = len(self.refusals)
        head = f"{format_count(count, 'body')} cannot be written as {self.format}:"
        listed = [_cut_text(line, 2 * _MESSAGE_WIDTH) for line in self.refusals[: MAX_LISTED_PROBLEMS // 2 - 1]]
        more = count - len(listed)
        tail = [f"... and {more:,} more like this"] if more else []
        raise ValueError("\n".join([head, *listed, *tail]))

    @property
    def remarks(self) -> tuple[str, ...]:
        """A line for each kind of loss, with the first bodies and the number of the others."""
        return tuple(limit_notes(self._remarks()))

    def _remarks(self) -> Iterator[str]:
        for kind, names in self.losses.items():
            if names == [""]:  # a loss of the scene, not of a body
                yield kind
                continue
            shown = ", ".join(quote_body(name) for name in names[:3])
            more = f" and {len(names) - 3:,} more" if len(names) > 3 else ""
            yield f"{kind}: {shown}{more}"


def quote_body(name: str) -> str:
    """Return the name of a body for messages, printable and short."""
    return printable(shorten(name))


def _cut_text(text: str, width: int) -> str:
    return text if len(text) <= width else f"{text[: width // 2 - 3]} ... {text[3 - width // 2 :]}"


# Formats, chosen by the suffix of the file. A format's module is imported when the first file of it is written.


@dataclass(frozen=True)
class ExportFormat:
    """A format: its name in messages, its suffixes, and its module."""

    name: str
    suffixes: tuple[str, ...]
    module: str

    def write(self, scene: WritableScene, path: str | os.PathLike[str], options: ExportOptions) -> ExportResult:
        """Write a scene to a file, which appears whole or not at all.

        Raise ValueError with the bodies that the format cannot hold, or with the remarks if `options.strict`. Raise
        OSError if the file cannot be written.
        """
        result: ExportResult = importlib.import_module(self.module, __package__).export_text(scene, options)
        if options.strict and result.remarks:
            remarks = "\n".join(limit_notes(result.remarks))
            raise ValueError(f"{os.fspath(path)}: would not hold all of the scene, and strict is set:\n{remarks}")
        write_text(path, result.text)
        return result


EXPORT_FORMATS: tuple[ExportFormat, ...] = (
    ExportFormat("GDML", (".gdml",), ".gdml"),
    ExportFormat("OpenSCAD", (".scad", ".csg"), ".openscad"),
    ExportFormat("OpenMC", (".xml",), ".openmc"),
)


def find_export_format(path: str | os.PathLike[str]) -> ExportFormat | None:
    """Return the format for the suffix of a path; None for any other suffix."""
    suffix = os.path.splitext(os.fspath(path))[1].lower()
    return next((each for each in EXPORT_FORMATS if suffix in each.suffixes), None)


def unit_factor(scene: WritableScene, unit: str) -> Fraction:
    """Return the size of a scene's unit of length in another one; 1 for a scene that states none."""
    return Fraction(1) if scene.unit is None else LENGTH_UNITS[scene.unit] / LENGTH_UNITS[unit]


def unit_notes(scene: WritableScene, unit: str) -> tuple[str, ...]:
    """Return a note on the unit of a file's lengths, unless the scene has the same one."""
    if scene.unit is None:
        return (f"the scene states no unit: its lengths are {unit} in the file",)
    return () if scene.unit == unit else (f"lengths are converted from {scene.unit} to {unit}",)


# Bodies of a scene one by one, with unique names.

MAX_EXPORT_BODIES = 2_000_000
"""Most bodies of one file."""


@dataclass(frozen=True)
class ExportBody:
    """A solid body: its unique name, its solid, and its material or None."""

    name: str
    solid: Solid
    material: Material | None


def collect_solids(scene: WritableScene, report: ExportReport) -> list[ExportBody]:
    """Return all bodies of a scene, each of an entry of many by itself.

    Sheets are reported as refused, empty bodies as left out. Raise ValueError for more than `MAX_EXPORT_BODIES`.
    """
    found = []
    for number, (name, body) in enumerate(_unique_names(scene)):
        if number >= MAX_EXPORT_BODIES:
            raise ValueError(f"export: a file has at most {MAX_EXPORT_BODIES:,} bodies, this scene has more")
        with report.about(name):
            if body.shape.is_sheet:
                raise UnsupportedExport(f"{type(body.shape).__name__} is a sheet, and such files have solids only")
            found.append(ExportBody(name, body.shape, body.material))
    if isinstance(scene.bodies, InstanceList) and len(found) == len(scene.bodies):
        scene.bodies.put_bounds([item.solid for item in found])
    _report_ignored(scene, report)
    filled = []
    for item in found:
        if (item.solid.bounds.low > item.solid.bounds.high).any():
            report.narrow("with nothing in it, and left out", item.name)
        else:
            filled.append(item)
    return filled


def _unique_names(scene: WritableScene) -> Iterator[tuple[str, Any]]:
    """Yield a unique name and the body for each body; unnamed ones get their number, copies an index in brackets."""
    names = {body.name for body in scene.bodies}
    number = 0
    for body in scene.bodies:
        count = count_bodies(body)
        for k in range(count):
            name = body.name or f"body {number}"
            if count > 1 and body.name:
                name = f"{name}[{k}]"
            while name != body.name and name in names:  # names of the scene stay as they are
                name += "'"
            names.add(name)
            yield name, single_body(body, k)
            number += 1


def _report_ignored(scene: WritableScene, report: ExportReport) -> None:
    """Report the parts of a scene that only pictures need; no export format holds them."""
    parts = [name for name in ("lights", "camera", "background", "animation") if getattr(scene, name, None)]
    if parts:
        report.narrow(f"not written: {', '.join(parts)}", "")


def is_void(material: Material | None) -> bool:
    """Return True for an invisible material, as importers make them for void and for gases."""
    return (
        material is not None
        and is_clear(material)
        and min(amount_rgb(material.transparency)) == 1
        and material.refractive_index == 1.0
        and not any(amount_rgb(material.absorption))
        and not any(amount_rgb(material.scattering))
        and not any(amount_rgb(material.emission))
    )


def hex_color(material: Material | None) -> tuple[str, bool]:
    """Return the colour of a material as #rrggbb, and whether its look is only that colour.

    Textures, mirrors and clear materials are more than a colour; textures become #cccccc.
    """
    material = material or Material()
    try:
        rgb = linear_rgb(material.color)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return "#cccccc", False
    channels = [round(255 * min(max(channel, 0.0), 1.0)) for channel in srgb_encode(rgb).tolist()]
    plain = not any(amount_rgb(material.reflectivity)) and not is_clear(material)
    return "#" + "".join(f"{channel:02x}" for channel in channels), plain


# Pairs of bodies that may overlap.


def overlapping_boxes(boxes: Sequence[BoxEnds]) -> Iterator[tuple[int, int]]:
    """Yield the pairs (i, j), i < j, of boxes that overlap by more than a face, sorted by j, then by i.

    Boxes are swept along x: only those that begin before a box ends are compared with it.
    """
    if len(boxes) < 2:
        return
    lows, highs = (np.array([box[end] for box in boxes]) for end in (0, 1))
    order = np.argsort(lows[:, 0], kind="stable")
    starts = lows[order, 0]
    found: dict[int, list[int]] = {}
    for place, i in enumerate(order.tolist()):
        last = int(np.searchsorted(starts, highs[i, 0], side="left"))
        others = order[place + 1 : last]
        meets = ((lows[others] < highs[i]) & (lows[i] < highs[others])).all(axis=1)
        for k in others[meets].tolist():
            found.setdefault(max(i, k), []).append(min(i, k))
    for later in sorted(found):
        yield from ((before, later) for before in sorted(found[later]))


# Numbers as decimals. A float64 is written so that readers get the same float64, other numbers to forty digits.

MAX_DIGITS = 40
"""Digits of numbers that are no float64: more than readers keep, so that they round them like the exact numbers."""
_MAX_LENGTH, _MAX_QUOTIENT_LENGTH = 60, 400
"""Most digits of an exact decimal, and most characters of an exact quotient."""
_CONTEXT = Context(prec=MAX_DIGITS)


@lru_cache(4096)
def shortest_decimal(value: float) -> Fraction:
    """Return the shortest decimal that is read as a float64: 1/10 for 0.1.

    Sums of these decimals are the sums that people mean: 0.1 + 0.2 gives 3/10.
    """
    return Fraction(repr(value + 0.0))  # + 0.0 turns -0.0 into 0.0


def format_number(value: float | Fraction) -> str:
    """Return a number as a decimal: the shortest one of a float64, else that of `_format_digits`."""
    if isinstance(value, Fraction):
        near = float(value)
        if shortest_decimal(near) != value:
            return _format_digits(value)
        value = near
    text = repr(value + 0.0)
    return text[:-2] if text.endswith(".0") else text


def format_numbers(values: object) -> str:
    """Return numbers as text, separated by blanks."""
    return " ".join(format_number(value) for value in values)  # type: ignore[attr-defined]


def _format_digits(value: Fraction) -> str:
    """Return a fraction as a decimal: exact if it has at most `_MAX_LENGTH` digits, else with `MAX_DIGITS` digits."""
    denominator = value.denominator
    twos = (denominator & -denominator).bit_length() - 1
    fives, rest = 0, denominator >> twos
    while rest % 5 == 0:
        fives, rest = fives + 1, rest // 5
    places = max(twos, fives)
    # A decimal ends if its denominator has no prime factors but 2 and 5.
    if rest == 1 and places <= _MAX_LENGTH:
        digits = abs(value.numerator) * 10**places // denominator
        if len(str(digits)) <= _MAX_LENGTH:
            return str(Decimal(digits if value >= 0 else -digits).scaleb(-places, Context(prec=2 * _MAX_LENGTH)))
    return str(_CONTEXT.divide(Decimal(value.numerator), Decimal(value.denominator)))


def shorten_fraction(value: ex.Writable) -> tuple[Fraction, bool]:
    """Return a number as a fraction for `format_number`, and whether it is a float64.

    For a float64 the fraction is its shortest decimal, for other numbers their exact value.
    """
    if isinstance(value, (int, float)):
        return shortest_decimal(float(value)), True
    near = ex.rounded(value)
    if ex.cancelling_sum((ex.exact(value), -ex.exact(near))):
        return ex.fraction(value), False
    return shortest_decimal(near), True


def format_expression(value: Fraction) -> str:
    """Return a number as an expression for readers that divide: a decimal if that is exact, else a quotient."""
    text = format_number(value)
    quotient = f"{value.numerator}/{value.denominator}"
    return text if Fraction(text) == value or len(quotient) > _MAX_QUOTIENT_LENGTH else quotient
