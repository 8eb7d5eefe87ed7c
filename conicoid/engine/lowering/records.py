"""Records of surfaces, as kernels read them, and what rounding takes from their numbers."""

from __future__ import annotations

import math
from collections.abc import Iterable
from fractions import Fraction
from typing import Any

from ...shapes import exact as ex
from ...shapes.surface import UPRIGHT, PlaneSurface, QuadricSurface, Surface
from ..tables import PLANE, QUADRIC, SPHERE

_CENTERED = 2.0**-46
"""A ball whose center was rounded by more than this share of its radius is a general quadric, with its own bounds."""


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
    largest = max(abs(float(v)) for v in values)
    return math.ldexp(1.0, -math.frexp(largest)[1]) if largest else 1.0


def _times(value: ex.Writable, factor: float) -> ex.Writable:
    """A product with a power of two, exact."""
    if isinstance(value, Fraction):
        return value * Fraction(factor)
    return value * factor


def _height_of_anchor(surface: PlaneSurface, anchor: tuple[float, ...]) -> ex.Writable:
    """The height of an anchor over a plane, exactly."""
    offset: ex.Writable = surface.offset
    if not any(anchor):
        return -offset
    return ex.dot(ex.exact_row(surface.normal), ex.exact_row(anchor), -ex.exact(offset))


def _as_sphere(surface: QuadricSurface) -> tuple[ex.Writable, ...] | None:
    """(center, radius) where the quadric is a sphere with its inside inside."""
    a, b, c = surface.squares
    if not (a == b == c and a > 0 and not any(surface.linear) and surface.constant > 0):
        return None
    if surface.rows is UPRIGHT:
        square = float(surface.constant) if a == 1 else float(ex.exact(surface.constant) / ex.exact(a))
        radius = math.sqrt(square) if 1e-290 < square < 1e290 else 0.0
        if radius and a == 1 and Fraction(radius) ** 2 == surface.constant:
            return _centered(surface, radius)
    rows = tuple(ex.exact_row(row) for row in surface.rows)
    gram = ex.multiply((rows[0], rows[1], rows[2]), ex.transpose((rows[0], rows[1], rows[2])))
    if gram[0][1] or gram[0][2] or gram[1][2]:
        return None
    if ex.cancelling_sum((gram[0][0], -gram[1][1])) or ex.cancelling_sum((gram[0][0], -gram[2][2])):
        return None
    return _centered(surface, ex.sqrt(ex.exact(surface.constant) / (ex.exact(a) * gram[0][0])))


def _centered(surface: QuadricSurface, radius: ex.Writable) -> tuple[ex.Writable, ...] | None:
    """(center, radius), or None where rounding the center would move the sphere too far (`_CENTERED`)."""
    if any(abs(rest) > _CENTERED * float(radius) for rest in rests(surface.anchor)):
        return None
    return (*surface.anchor, radius)


def floats(values: Iterable[Any]) -> tuple[float, ...]:
    """Each number rounded to float64."""
    return tuple(float(v) for v in values)


def rests(values: Iterable[Any]) -> tuple[float, ...]:
    """What rounding to float64 takes from each number."""
    return tuple(0.0 if isinstance(v, (float, int)) else _rest(v) for v in values)


def _rest(value: Any) -> float:
    """What rounding to float64 takes from a number."""
    if isinstance(value, Fraction):
        return float(value - Fraction(float(value)))
    rest = ex.cancelling_sum((value, -ex.exact(float(value))))  # the last of many bits are noise
    return float(rest)
