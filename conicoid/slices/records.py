"""Conics from the records of surfaces in the tables, which is quick, where they say enough.

A record is what rounding left of a surface's numbers, and what it took is kept to 2^-106 of them. Of surfaces whose
numbers are floats nothing was taken, and their conics are exact. Of others coefficients are known to about 98 bits:
where that leaves open whether one of them, or a determinant, is zero, the surface is asked for as it was written.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from ..engine.tables import PLANE, SPHERE
from .conic import Conic, Unclear, as_six
from .window import Window

if TYPE_CHECKING:
    from ..engine.prepared import Prepared

_OFF = 2.0**-98
_SURE = 2.0**60
"""A coefficient is at least so many times what it may be off by."""


class Records:
    """The records of a scene's surfaces, and a window."""

    def __init__(self, scene: Prepared, window: Window) -> None:
        self.tables, self.rest, self.window = scene.lowered.tables, scene.lowered.rest, window
        parts = window.corner, window.u, window.v
        corner, u, v = ([Fraction(float(x)) for x in part] for part in parts)
        self.middle = [c + a / 2 + b / 2 for c, a, b in zip(corner, u, v, strict=True)]
        self.sides = u, v
        self.sizes = np.abs(window.corner) + np.abs(window.u) + np.abs(window.v), np.abs(window.u), np.abs(window.v)

    def conic(self, surface: int) -> Conic:
        """What the window's plane cuts out of a surface. Raises Unclear."""
        kind, row = int(self.tables.surface_kind[surface]), int(self.tables.surface_row[surface])
        if kind == PLANE:
            numbers, rests = self.tables.planes[row], self.rest.planes[row]
            values, sizes = self._of_plane(_sums(numbers, rests)), self._size_of_plane(np.abs(numbers))
        elif kind == SPHERE:
            numbers = self.tables.spheres[row]
            rests = self.rest.spheres[row] if row < len(self.rest.spheres) else np.zeros(4)
            one = np.array([*numbers[:3], 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1, 0, 0, 0])
            full = [*_sums(numbers[:3], rests[:3]), *map(Fraction, one[3:].tolist()), _sums(numbers, rests)[3] ** 2]
            values = self._of_quadric(full)
            sizes = self._size_of_quadric(np.abs(np.append(one, numbers[3] ** 2)))
        else:
            numbers = self.tables.whole_quadrics([row])[0]
            rests = self.rest.quadrics[int(self.tables.quadrics[row, 3])]
            values, sizes = self._of_quadric(_sums(numbers, rests)), self._size_of_quadric(np.abs(numbers))
        is_exact = not rests.any()
        if not is_exact and any(abs(v) <= size * _OFF * _SURE for v, size in zip(values, sizes, strict=True) if size):
            raise Unclear
        unit = math.lcm(*(value.denominator for value in values))
        whole = [int(value * unit) for value in values]
        common = math.gcd(*whole) or 1
        return Conic(as_six([x // common for x in whole]), not is_exact, self.window.size, quick=True)

    def _of_plane(self, numbers: list[Fraction]) -> list[Fraction]:
        normal, above, anchor = numbers[:3], numbers[3], numbers[4:]
        away = [m - a for m, a in zip(self.middle, anchor, strict=True)]
        u, v = self.sides
        none = Fraction(0)
        return [none, none, none, _dot(normal, u) / 2, _dot(normal, v) / 2, _dot(normal, away) + above]

    def _size_of_plane(self, numbers: Any) -> list[float]:
        middle, u, v = self.sizes
        normal = numbers[:3]
        return [0.0, 0.0, 0.0, normal @ u, normal @ v, normal @ (middle + numbers[4:]) + numbers[3]]

    def _of_quadric(self, numbers: list[Fraction]) -> list[Fraction]:
        """Σ s y² + 2 b y - k with y = W (x - anchor), x = middle + s u + t v."""
        away = [m - a for m, a in zip(self.middle, numbers[:3], strict=True)]
        rows = [numbers[3 + 3 * k : 6 + 3 * k] for k in range(3)]
        s, b, k = numbers[12:15], numbers[15:18], numbers[18]
        p, q, r = ([_dot(row, part) for row in rows] for part in (*self.sides, away))
        return [
            _sum(s, p, p), _sum(s, p, q), _sum(s, q, q), _sum(s, p, r) + _dot(b, p), _sum(s, q, r) + _dot(b, q),
            _sum(s, r, r) + 2 * _dot(b, r) - k,
        ]  # fmt: skip

    def _size_of_quadric(self, numbers: Any) -> list[float]:
        middle, u, v = self.sizes
        rows, s, b = numbers[3:12].reshape(3, 3), numbers[12:15], numbers[15:18]
        p, q, r = rows @ u, rows @ v, rows @ (middle + numbers[:3])
        return [
            (s * p) @ p, (s * p) @ q, (s * q) @ q, (s * p) @ r + b @ p, (s * q) @ r + b @ q,
            (s * r) @ r + 2 * (b @ r) + numbers[18],
        ]  # fmt: skip


def _sums(numbers: Any, rests: Any) -> list[Fraction]:
    """Numbers with what rounding took from them."""
    return [Fraction(x) + Fraction(y) for x, y in zip(numbers.tolist(), rests.tolist(), strict=True)]


def _dot(a: list[Fraction], b: list[Fraction]) -> Fraction:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _sum(s: list[Fraction], a: list[Fraction], b: list[Fraction]) -> Fraction:
    return s[0] * a[0] * b[0] + s[1] * a[1] * b[1] + s[2] * a[2] * b[2]
