"""Records of surfaces, as kernels read them, and what rounding takes from their numbers."""

from __future__ import annotations

import functools
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from ...shapes import exact as ex
from ...shapes.number import Symbol
from ...shapes.rounded import is_float, larger, root, scale_of, sign_of_first
from ...shapes.surface import UPRIGHT, PlaneSurface, QuadricSurface, Surface
from ..tables import PLANE, QUADRIC, SPHERE

CENTERED = 2.0**-46
"""A ball whose center was rounded by more than this share of its radius is a general quadric, with its own bounds."""


@dataclass(frozen=True, slots=True)
class Record:
    """A surface as kernels read it, and what rounding took from its numbers."""

    kind: int
    numbers: tuple[float, ...]
    rests: tuple[float, ...]
    sense: float  # +1, or -1 where the record is the surface turned over


def rounded_record(surface: Surface) -> Record:
    """The record of a surface. A plane's normal leads with a positive number.

    Which side a ray within a plane counts to must not depend on who wrote it first.
    """
    kind, numbers = record_of(surface)
    rounded, lost = floats(numbers), rests(numbers)
    if kind != PLANE:
        return Record(kind, rounded, lost, 1.0)
    sense = sign_of_first(rounded[:3])
    return Record(kind, _turned(rounded, sense), _turned(lost, sense), sense)


def _turned(numbers: tuple[float, ...], sense: float) -> tuple[float, ...]:
    """A plane's normal and height times a sign, without negative zeros; its anchor as it is."""
    return (*(number * sense + 0.0 for number in numbers[:4]), *numbers[4:])


def record_of(surface: Surface) -> tuple[int, tuple[ex.Writable, ...]]:
    """(kind, numbers of the record before they are rounded)."""
    if isinstance(surface, PlaneSurface):
        anchor = floats(surface.anchor)
        factor = _factor(surface.normal)
        height = _height_of_anchor(surface, anchor)
        return PLANE, (*(_times(v, factor) for v in (*surface.normal, height)), *anchor)
    ball = _as_sphere(surface)
    if ball is not None:
        return SPHERE, ball
    factor = _factor(surface.squares)
    numbers = (*surface.squares, *surface.linear, surface.constant)
    rows = [w for line in surface.rows for w in line]
    return QUADRIC, (*surface.anchor, *rows, *(_times(v, factor) for v in numbers))


def _factor(values: Iterable[Any]) -> float:
    """2^n that brings the largest of some numbers near 1 and changes no digit."""
    return scale_of(functools.reduce(larger, (abs(ex.rounded(v)) for v in values)))


def _times(value: ex.Writable, factor: float) -> ex.Writable:
    """A product with a power of two, exact."""
    if isinstance(factor, Symbol) and type(value) in (Fraction, ex.Exact):  # a constant of a formula that is recorded
        return ex.exact(factor) * value
    if isinstance(value, Fraction):
        return value * Fraction(factor)
    return value * factor


def _height_of_anchor(surface: PlaneSurface, anchor: tuple[float, ...]) -> ex.Writable:
    """The height of an anchor over a plane, exactly."""
    if surface.over is None:  # without what division by a count of corners, or by n·n, has left of the exact anchor
        if not any(anchor):
            return -surface.offset
        return ex.dot(ex.exact_row(surface.normal), ex.exact_row(anchor), -ex.exact(surface.offset))
    aside = ex.minus(ex.exact_row(anchor), ex.exact_row(surface.anchor))
    return ex.dot(ex.exact_row(surface.normal), aside, surface.height)


def _as_sphere(surface: QuadricSurface) -> tuple[ex.Writable, ...] | None:
    """(center, radius) where the quadric is a sphere with its inside inside."""
    a, b, c = surface.squares
    if not (a == b == c and a > 0 and not any(surface.linear) and surface.constant > 0):
        return None
    if surface.rows is UPRIGHT:
        square = ex.rounded(surface.constant if a == 1 else ex.exact(surface.constant) / ex.exact(a))
        radius = root(square) if 1e-290 < square < 1e290 else 0.0
        if radius and a == 1 and ex.rational(radius) ** 2 == surface.constant:
            return _centered(surface, radius)
    rows = tuple(ex.exact_row(row) for row in surface.rows)
    gram = ex.multiply((rows[0], rows[1], rows[2]), ex.transpose((rows[0], rows[1], rows[2])))
    if ex.cancelling_sum((gram[0][0], -gram[1][1])) or ex.cancelling_sum((gram[0][0], -gram[2][2])):
        return None
    if gram[0][1] or gram[0][2] or gram[1][2]:
        return None
    quotient = ex.cancelling_sum((ex.exact(surface.constant) / (ex.exact(a) * gram[0][0]),))
    return _centered(surface, ex.cancelling_sum((ex.sqrt(quotient),)))


def _centered(surface: QuadricSurface, radius: ex.Writable) -> tuple[ex.Writable, ...] | None:
    """(center, radius), or None where rounding the center would move the sphere too far (`CENTERED`)."""
    if any(abs(rest) > CENTERED * ex.rounded(radius) for rest in rests(surface.anchor)):
        return None
    return (*surface.anchor, radius)


def floats(values: Iterable[Any]) -> tuple[float, ...]:
    """Each number rounded to float64."""
    return tuple(ex.rounded(v) for v in values)


def rests(values: Iterable[Any]) -> tuple[float, ...]:
    """What rounding to float64 takes from each number."""
    return tuple(0.0 if is_float(v) else _rest(v) for v in values)


def _rest(value: Any) -> float:
    """What rounding to float64 takes from a number."""
    if isinstance(value, Fraction):
        return float(value - Fraction(float(value)))
    rest = ex.cancelling_sum((value, -ex.exact(ex.rounded(value))))  # the last of many bits are noise
    return ex.rounded(rest)
