"""What an export may be asked for, what it gives, and how it refuses what a format cannot say."""

from __future__ import annotations

import importlib
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from decimal import Context, Decimal
from fractions import Fraction
from typing import Any

import numpy as np

from ..._util.arrays import BoxEnds
from ..._util.file_errors import MAX_LISTED_PROBLEMS, printable
from ..._util.safe_files import write_text
from ..._util.text import format_count
from ..._util.validation import check_callback, check_flag
from ...geometry.labels import count_bodies, is_clear, single_body
from ...geometry.shape import Solid
from ...materials.color import amount_rgb, linear_rgb, srgb_encode
from ...materials.material import Material
from ...numerics import bigfloat_linalg as ex
from ..importers import limit_notes
from ..scene_file.nodes import shorten
from ..scene_file.scene_file import WritableScene

_MESSAGE_WIDTH = 96


@dataclass(frozen=True)
class ExportOptions:
    """How a file is written.

    strict: is what the format says less of than the scene an error, in place of a remark?
    progress: progress(done, count) is called with numbers of bodies.
    """

    strict: bool = False
    progress: Callable[[int, int], Any] | None = None

    def __post_init__(self) -> None:
        check_flag("export", "strict", self.strict)
        check_callback("export", "progress", self.progress)


@dataclass(frozen=True)
class ExportResult:
    """The text of a file, and what there is to say of it: `notes` are all, `remarks` those that tell of a loss."""

    text: str
    notes: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()


class ExportUnsupported(Exception):
    """Why a format cannot say something; the message names the shape, the field and what to do."""


@dataclass
class ExportReport:
    """What is told of an export: bodies that cannot be said, and what is narrowed, by kind."""

    format: str
    refused: list[str] = field(default_factory=list)
    narrowed: dict[str, list[str]] = field(default_factory=dict)

    @contextmanager
    def about(self, name: str) -> Iterator[None]:
        """What cannot be said of a body is kept, so that all such bodies are told together."""
        try:
            yield
        except ExportUnsupported as error:
            self.refused.append(f"{quote_body(name)}: {error}")
        except OverflowError:
            self.refused.append(f"{quote_body(name)}: its numbers leave the range of float64")

    def narrow(self, kind: str, name: str) -> None:
        """A body of which the file says less than the scene; `kind` says what."""
        names = self.narrowed.setdefault(kind, [])
        if not names or names[-1] != name:
            names.append(name)

    def check(self) -> None:
        """Raises ValueError with the bodies that cannot be said, the first of many."""
        if not self.refused:
            return
        count = len(self.refused)
        head = f"{format_count(count, 'body')} cannot be said in {self.format}:"
        kept = [_cut_text(line, 2 * _MESSAGE_WIDTH) for line in self.refused[: MAX_LISTED_PROBLEMS // 2 - 1]]
        more = count - len(kept)
        tail = [f"... and {more:,} more like this"] if more else []
        raise ValueError("\n".join([head, *kept, *tail]))

    @property
    def remarks(self) -> tuple[str, ...]:
        """A line for each kind of narrowing, with the first bodies and how many there are."""
        return tuple(limit_notes(self._remarks()))

    def _remarks(self) -> Iterator[str]:
        for kind, names in self.narrowed.items():
            if names == [""]:
                yield kind
                continue
            shown = ", ".join(quote_body(name) for name in names[:3])
            more = f" and {len(names) - 3:,} more" if len(names) > 3 else ""
            yield f"{kind}: {shown}{more}"


def quote_body(name: str) -> str:
    """A body in messages."""
    return printable(shorten(name))


def _cut_text(text: str, width: int) -> str:
    return text if len(text) <= width else f"{text[: width // 2 - 3]} ... {text[3 - width // 2 :]}"


# The formats of other programs that Conicoid writes, each known by the suffix of the file.
#
# A format is a module with `exported(bodies, options)`, which gives an `Exported`, and is loaded when a file of it is
# written.


@dataclass(frozen=True)
class ExportFormat:
    """A format: its name in messages, its suffixes, and its module."""

    name: str
    suffixes: tuple[str, ...]
    module: str

    def write(self, scene: WritableScene, path: str | os.PathLike[str], options: ExportOptions) -> ExportResult:
        """Write a file, whole or not at all.

        Raises ValueError that names the bodies which the format cannot say, or for remarks where none are wanted
        (`strict`); OSError where the file cannot be written.
        """
        found: ExportResult = importlib.import_module(self.module, __package__).export_text(scene, options)
        if options.strict and found.remarks:
            told = "\n".join(limit_notes(found.remarks))
            raise ValueError(f"{os.fspath(path)}: would not say all of the scene, and strict is asked for:\n{told}")
        write_text(path, found.text)
        return found


EXPORT_FORMATS: tuple[ExportFormat, ...] = (
    ExportFormat("GDML", (".gdml",), ".gdml"),
    ExportFormat("OpenSCAD", (".scad", ".csg"), ".openscad"),
    ExportFormat("OpenMC", (".xml",), ".openmc"),
)


def find_export_format(path: str | os.PathLike[str]) -> ExportFormat | None:
    """The format that a file is to have, by its suffix; None for any other."""
    suffix = os.path.splitext(os.fspath(path))[1].lower()
    return next((each for each in EXPORT_FORMATS if suffix in each.suffixes), None)


# The bodies of a scene one by one, with the names and materials that a file gives them.

MAX_EXPORT_BODIES = 2_000_000
"""Bodies of one file."""


@dataclass(frozen=True)
class ExportBody:
    """A solid body: its name, which no other has, its solid, and its material, None for none."""

    name: str
    solid: Solid
    material: Material | None


def collect_solids(scene: WritableScene, report: ExportReport) -> list[ExportBody]:
    """All bodies; sheets are refused by name. Of many in one entry, each is one."""
    found = []
    for number, (name, body) in enumerate(_unique_names(scene)):
        if number >= MAX_EXPORT_BODIES:
            raise ValueError(f"export: a file has at most {MAX_EXPORT_BODIES:,} bodies, this scene has more")
        with report.about(name):
            if body.shape.is_sheet:
                raise ExportUnsupported(f"{type(body.shape).__name__} is a sheet, and such files have solids only")
            found.append(ExportBody(name, body.shape, body.material))
    _report_ignored(scene, report)
    return found


def _unique_names(scene: WritableScene) -> Iterator[tuple[str, Any]]:
    taken = {body.name for body in scene.bodies}
    number = 0
    for body in scene.bodies:
        count = count_bodies(body)
        for k in range(count):
            name = body.name or f"body {number}"
            if count > 1 and body.name:
                name = f"{name}[{k}]"
            while name != body.name and name in taken:
                name += "'"
            taken.add(name)
            yield name, single_body(body, k)
            number += 1


def _report_ignored(scene: WritableScene, report: ExportReport) -> None:
    """What no such file has: said once, as pictures are not what it is for."""
    parts = [name for name in ("lights", "camera", "background", "animation") if getattr(scene, name, None)]
    if parts:
        report.narrow(f"not said: {', '.join(parts)}", "")


def is_void(material: Material | None) -> bool:
    """Is it nothing that anybody would see: what importers make of void and of gases?"""
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
    """#rrggbb, and whether that is all of how the material looks: textures and mirrors are more than a colour."""
    material = material or Material()
    try:
        rgb = linear_rgb(material.color)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return "#cccccc", False
    channels = [round(255 * min(max(channel, 0.0), 1.0)) for channel in srgb_encode(rgb).tolist()]
    plain = not any(amount_rgb(material.reflectivity)) and not is_clear(material)
    return "#" + "".join(f"{channel:02x}" for channel in channels), plain


def has_same_color(a: Material, b: Material) -> bool:
    """Would both be said by the same colour?"""
    return hex_color(a) == hex_color(b)


# Which bodies may have points in common: pairs whose boxes do.


def overlapping_boxes(boxes: Sequence[BoxEnds]) -> Iterator[tuple[int, int]]:
    """Pairs (i, j), i < j, of boxes that overlap by more than a face, for each j in the order of i."""
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


# Numbers as decimals that readers turn into the same float64; and what is no float64, to forty digits.

MAX_DIGITS = 40
"""Of numbers that are no float64: more than readers keep, so that these round them as they would the exact ones."""
_MAX_LENGTH, _MAX_QUOTIENT_LENGTH = 60, 400
_CONTEXT = Context(prec=MAX_DIGITS)


def shortest_decimal(value: float) -> Fraction:
    """The shortest decimal that is read as a float64: 1/10 for 0.1. Sums of such are what people mean by them."""
    return Fraction(repr(value + 0.0))


def format_number(value: float | Fraction) -> str:
    """A number as text."""
    if isinstance(value, Fraction):
        near = float(value)
        if shortest_decimal(near) != value:
            return _format_digits(value)
        value = near
    text = repr(value + 0.0)
    return text[:-2] if text.endswith(".0") else text


def format_numbers(values: object) -> str:
    """Several numbers, with blanks between them."""
    return " ".join(format_number(value) for value in values)  # type: ignore[attr-defined]


def _format_digits(value: Fraction) -> str:
    """All digits where they end soon, else forty."""
    denominator = value.denominator
    twos = (denominator & -denominator).bit_length() - 1
    fives, rest = 0, denominator >> twos
    while rest % 5 == 0:
        fives, rest = fives + 1, rest // 5
    places = max(twos, fives)
    if rest == 1 and places <= _MAX_LENGTH:
        digits = abs(value.numerator) * 10**places // denominator
        if len(str(digits)) <= _MAX_LENGTH:
            return str(Decimal(digits if value >= 0 else -digits).scaleb(-places, Context(prec=2 * _MAX_LENGTH)))
    return str(_CONTEXT.divide(Decimal(value.numerator), Decimal(value.denominator)))


def shorten_fraction(value: ex.Writable) -> tuple[Fraction, bool]:
    """A number of many bits as a fraction that `word` says, and whether it is a float64: the decimal of that then."""
    if isinstance(value, (int, float)):
        return shortest_decimal(float(value)), True
    near = ex.rounded(value)
    if ex.cancelling_sum((ex.exact(value), -ex.exact(near))):
        return ex.fraction(value), False
    return shortest_decimal(near), True


def format_expression(value: Fraction) -> str:
    """A number for readers that know fractions: as it is where its digits end soon, else a quotient."""
    text = format_number(value)
    quotient = f"{value.numerator}/{value.denominator}"
    return text if Fraction(text) == value or len(quotient) > _MAX_QUOTIENT_LENGTH else quotient
