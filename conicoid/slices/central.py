"""Curves with a centre: ellipses, and branches of hyperbolas."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..shapes.vector import FloatArray
from .curve import NEAR, Curve, Pair, carried_onto, half_slope, roots_of, second_order, value


@dataclass(frozen=True, eq=False)
class _Central(Curve):
    """center + r C(t0 + t) axis + s S(t0 + t) (the axis turned to the left), C and S being cosine and sine of its kind.

    t = 0 is a place on it that is near to the middle of the window. Places and parameters are told from there, so that
    they keep their digits however far away the centre is.
    """

    center: Pair
    axis: Pair
    radii: Pair
    start: Pair = field(init=False)
    """C(t0) and S(t0)"""
    base: Pair = field(init=False)
    """The place of t = 0."""

    def __post_init__(self) -> None:
        c, s = self._own(-np.array(self.center)[None])
        start = self._nearest(float(c[0]), float(s[0]))
        place = carried_onto(self.conic, np.array(self.center)[None] + self._put(*map(np.array, start)))
        object.__setattr__(self, "start", start)
        object.__setattr__(self, "base", (float(place[0, 0]), float(place[0, 1])))

    def _nearest(self, c: float, s: float) -> Pair:
        """C and S of a place on the curve near to one that has these."""
        raise NotImplementedError

    @property
    def _sides(self) -> tuple[Pair, Pair]:
        (x, y), (r, s) = self.axis, self.radii
        return (r * x, r * y), (-s * y, s * x)

    def _put(self, c: Any, s: Any) -> FloatArray:
        """Differences of places, from those of C and S."""
        a, b = self._sides
        points: FloatArray = np.outer(c, a) + np.outer(s, b)
        return points

    def _own(self, away: Any) -> tuple[Any, Any]:
        """The contrary of `_put`."""
        (x, y), (r, s) = self.axis, self.radii
        return (away[:, 0] * x + away[:, 1] * y) / r, (away[:, 1] * x - away[:, 0] * y) / s

    def _terms(self, other: Any) -> Any:
        """(value at the centre, halves of both slopes, and the three terms of second order) of another conic."""
        a, b = self._sides
        c = self.center
        return (
            value(other, np.array(c)), half_slope(other, c, a), half_slope(other, c, b), second_order(other, a, a),
            second_order(other, a, b), second_order(other, b, b),
        )  # fmt: skip


class Ellipse(_Central):
    """An ellipse by an angle, in radians."""

    kind, closed = "ellipse", True

    def _nearest(self, c: float, s: float) -> Pair:
        length = math.hypot(c, s)
        return (c / length, s / length) if length > 0 else (1.0, 0.0)

    def plain(self, t: Any) -> FloatArray:
        (c, s), turn, less = self.start, np.sin(t), -2 * np.sin(np.asarray(t) / 2) ** 2
        return np.array(self.base) + self._put(c * less - s * turn, s * less + c * turn)

    def velocity(self, t: Any) -> FloatArray:
        (c, s), turn, whole = self.start, np.sin(t), np.cos(t)
        return self._put(-c * turn - s * whole, c * whole - s * turn)

    def parameter(self, points: Any) -> FloatArray:
        (c, s), (x, y) = self.start, self._own(points - np.array(self.base))
        result: FloatArray = np.arctan2(c * y - s * x, 1 + c * x + s * y)
        return result

    def candidates(self, others: FloatArray) -> tuple[FloatArray, Any]:
        """f = constant + 2 Re(first z + second z²) with z = exp(i t): where it is not too large to vanish anywhere.

        Without the second, for lines and between circles, the angle is known at once; else z is a root of degree four.
        """
        second, first, constant = self._waves(others.T)
        reach = 2 * (np.abs(first) + np.abs(second))
        meets = np.abs(constant) <= reach * (1 + NEAR)
        simple = meets & (np.abs(second) <= 1e-15 * np.maximum(np.abs(first), np.abs(constant)))
        turn = np.arccos(np.clip(-constant / (2 * np.abs(first)), -1, 1))[simple]
        middle = -np.angle(first)[simple]
        rest = np.flatnonzero(meets & ~simple)
        roots = [self._roots_of(second[k], first[k], constant[k]) for k in rest]
        t = np.concatenate([middle + turn, middle - turn, *roots]) - math.atan2(self.start[1], self.start[0])
        one = np.flatnonzero(simple)
        return t, np.concatenate([one, one, np.repeat(rest, [len(part) for part in roots])])

    def _waves(self, other: Any) -> tuple[Any, Any, Any]:
        f, along, over, aa, ab, bb = self._terms(other)
        return (aa - bb) / 4 - 0.5j * ab, along - 1j * over, f + (aa + bb) / 2

    def _roots_of(self, second: Any, first: Any, constant: Any) -> FloatArray:
        z = roots_of([second, first, constant, np.conj(first), np.conj(second)])
        result: FloatArray = np.angle(z[np.abs(np.abs(z) - 1) < NEAR])
        return result

    def box(self) -> tuple[float, float, float, float]:
        a, b = self._sides
        x, y = math.hypot(a[0], b[0]), math.hypot(a[1], b[1])
        return self.center[0] - x, self.center[1] - y, self.center[0] + x, self.center[1] + y


class Hyperbola(_Central):
    """One branch of a hyperbola, by hyperbolic cosine and sine."""

    kind = "hyperbola"

    def _nearest(self, c: float, s: float) -> Pair:
        return math.hypot(1.0, s), s

    def plain(self, t: Any) -> FloatArray:
        (c, s), turn, more = self.start, np.sinh(t), 2 * np.sinh(np.asarray(t) / 2) ** 2
        return np.array(self.base) + self._put(c * more + s * turn, s * more + c * turn)

    def velocity(self, t: Any) -> FloatArray:
        (c, s), turn, whole = self.start, np.sinh(t), np.cosh(t)
        return self._put(c * turn + s * whole, s * turn + c * whole)

    def parameter(self, points: Any) -> FloatArray:
        (c, s), (x, y) = self.start, self._own(points - np.array(self.base))
        result: FloatArray = np.arcsinh(c * y - s * x)
        return result

    def roots_with(self, other: Any) -> FloatArray:
        """Of w = exp(t): the polynomial of fourth degree whose positive roots are crossings."""
        f, along, over, aa, ab, bb = self._terms(other)
        second = (aa + bb) / 4
        w = roots_of([second + ab / 2, along + over, f + (aa - bb) / 2, along - over, second - ab / 2])
        result: FloatArray = np.log(w.real[(w.real > 0) & (np.abs(w.imag) < NEAR * np.abs(w))])
        return result - math.asinh(self.start[1])

    def crossings(self, others: FloatArray) -> tuple[FloatArray, FloatArray]:
        t, points = super().crossings(others)
        here = self._own(points - np.array(self.center))[0] > 0  # and not on the other branch
        return t[here], points[here]
