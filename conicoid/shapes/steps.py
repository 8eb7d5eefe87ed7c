"""The steps that motions are made of: translations, turns, scalings, matrices and frames.

Each says where it takes points and how to come back, in 3000 bits; by what factor it changes all lengths, where there
is one; and, in floats, how far it can reach, which is enough to tell that numbers stay within their domain.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, TypeAlias

from . import exact as ex
from .carried import said
from .rounded import along_least
from .vector import Matrix4, Vector

Affine: TypeAlias = tuple[ex.Rows, ex.Row]
"""x ↦ rows x + shift"""

NOWHERE: ex.Row = (ex.ZERO, ex.ZERO, ex.ZERO)
"""The shift of what keeps the origin."""
CLEAR = 2.0**-40
"""A determinant above this share of the product of its rows is not zero, and known to four digits."""


class Reach(NamedTuple):
    """Bounds, in floats that may be some ulps off: no entry of a motion is larger, nor one of its inverse."""

    stretch: float
    """of the norm of the linear part"""
    back: float
    """of the norm of its inverse; inf where floats leave open whether there is one"""
    shift: float
    """of the length of the shift"""

    def then(self, other: Reach) -> Reach:
        """Of one motion after the other."""
        return Reach(self.stretch * other.stretch, self.back * other.back, self.shift * other.stretch + other.shift)


STAYS = Reach(1.0, 1.0, 0.0)


class _Step:
    """What all steps share: a step is seldom alone in having to say what it does, so it remembers that."""

    def __getstate__(self) -> dict[str, Any]:
        return said(self)

    @cached_property
    def forth_and_back(self) -> tuple[Affine, Affine]:
        """`affine` and `inverse`, worked out once."""
        return self.affine(), self.inverse()

    def affine(self) -> Affine:
        """Where it takes points."""
        raise NotImplementedError

    def inverse(self) -> Affine:
        """Where it takes them from."""
        raise NotImplementedError


@dataclass(frozen=True)
class Translate(_Step):
    """x ↦ x + offset"""

    offset: Vector

    def affine(self) -> Affine:
        return ex.IDENTITY, ex.exact_row(self.offset)

    def inverse(self) -> Affine:
        x, y, z = ex.exact_row(self.offset)
        return ex.IDENTITY, (-x, -y, -z)

    def similarity(self) -> ex.Exact | None:
        return ex.ONE

    def reach(self) -> Reach:
        return Reach(1.0, 1.0, _size(self.offset))


@dataclass(frozen=True)
class Rotate(_Step):
    """Right-handed turn about `axis` through the origin, in degrees (Rodrigues' formula)."""

    axis: Vector
    degrees: float

    def affine(self) -> Affine:
        return self._rows(), NOWHERE

    def inverse(self) -> Affine:
        return ex.transpose(self._rows()), NOWHERE

    def similarity(self) -> ex.Exact | None:
        return ex.ONE

    def reach(self) -> Reach:
        return STAYS

    def _rows(self) -> ex.Rows:
        s, c = ex.sin_cos_degrees(self.degrees)
        along = [i for i in range(3) if self.axis[i]]
        if len(along) == 1:
            return _about(along[0], s if self.axis[along[0]] > 0 else -s, c)
        x, y, z = ex.unit(ex.exact_row(self.axis))
        k = 1 - c
        return (
            (ex.dot((x * x, c), (k, ex.ONE)), ex.dot((x * y, -z), (k, s)), ex.dot((x * z, y), (k, s))),
            (ex.dot((x * y, z), (k, s)), ex.dot((y * y, c), (k, ex.ONE)), ex.dot((y * z, -x), (k, s))),
            (ex.dot((x * z, -y), (k, s)), ex.dot((y * z, x), (k, s)), ex.dot((z * z, c), (k, ex.ONE))),
        )


@dataclass(frozen=True)
class Scale(_Step):
    """x ↦ (kx x, ky y, kz z); negative factors mirror."""

    factors: Vector

    def affine(self) -> Affine:
        return _diagonal(ex.exact_row(self.factors)), NOWHERE

    def inverse(self) -> Affine:
        x, y, z = ex.exact_row(self.factors)
        return _diagonal((1 / x, 1 / y, 1 / z)), NOWHERE

    def similarity(self) -> ex.Exact | None:
        x, y, z = map(abs, self.factors)
        return ex.exact(x) if x == y == z else None

    def reach(self) -> Reach:
        x, y, z = map(abs, self.factors)
        return Reach(max(x, y, z), 1 / min(x, y, z), 0.0)


@dataclass(frozen=True)
class Transform(_Step):
    """x ↦ M x in homogeneous coordinates; the last row of M is (0, 0, 0, 1)."""

    matrix: Matrix4

    def affine(self) -> Affine:
        rows = tuple(ex.exact_row(row[:3]) for row in self.matrix[:3])
        return (rows[0], rows[1], rows[2]), ex.exact_row(row[3] for row in self.matrix[:3])

    def inverse(self) -> Affine:
        rows, shift = self.affine()
        back = ex.inverse(rows)
        x, y, z = ex.apply(back, shift)
        return back, (-x, -y, -z)

    def similarity(self) -> ex.Exact | None:
        """The root of the Gram matrix, where that is a multiple q of the identity: |det| / q, which is rational."""
        rows, _ = self.affine()
        square = ex.dot(rows[0], rows[0])
        if any(ex.dot(rows[i], rows[j]) for i, j in ((0, 1), (0, 2), (1, 2))):
            return None
        return ex.sqrt(square) if square == ex.dot(rows[1], rows[1]) == ex.dot(rows[2], rows[2]) else None

    def reach(self) -> Reach:
        a, b, c = (row[:3] for row in self.matrix[:3])
        across = (b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0])
        volume = abs(a[0] * across[0] + a[1] * across[1] + a[2] * across[2])
        x, y, z = _size(a), _size(b), _size(c)
        # The columns of the adjugate are cross products of two rows, no longer than the product of their lengths
        back = 1.01 * (x * y + y * z + z * x) / volume if volume > CLEAR * (x * y * z) else math.inf
        return Reach(x + y + z, back, _size(row[3] for row in self.matrix[:3]))


@dataclass(frozen=True)
class Frame(_Step):
    """Own coordinates to a frame with its origin at `origin` and z along `axis`.

    x points to `reference`, projected across the axis (Sasaki 2021, equation 2, with the projection
    that the errata ask for); without one, to the coordinate axis that is least along `axis`.
    """

    origin: Vector
    axis: Vector | ex.Row
    reference: Vector | None = None

    def affine(self) -> Affine:
        return ex.transpose(self._axes()), ex.exact_row(self.origin)

    def inverse(self) -> Affine:
        rows = self._axes()
        x, y, z = ex.apply(rows, ex.exact_row(self.origin))
        return rows, (-x, -y, -z)

    def similarity(self) -> ex.Exact | None:
        return ex.ONE

    def reach(self) -> Reach:
        return Reach(1.0, 1.0, _size(self.origin))

    def _axes(self) -> ex.Rows:
        """The directions of x, y and z."""
        z = ex.unit(ex.exact_row(self.axis))
        if self.reference is None:
            towards = ex.exact_row(along_least(ex.exact_row(self.axis)))
        else:
            towards = ex.minus(ex.exact_row(self.reference), ex.exact_row(self.origin))
        along = ex.dot(towards, z)
        aside = ex.minus(towards, (along * z[0], along * z[1], along * z[2]))
        across, size = ex.cross(z, towards), ex.sqrt(ex.dot(aside, aside))  # z × aside is z × towards, and as long
        x, y = ((row[0] / size, row[1] / size, row[2] / size) for row in (aside, across))
        return x, y, z


Step: TypeAlias = Translate | Rotate | Scale | Transform | Frame


def _size(values: Iterable[float]) -> float:
    """The sum of magnitudes, which no length exceeds."""
    return sum(map(abs, values))


def _diagonal(factors: ex.Row) -> ex.Rows:
    x, y, z = factors
    return (x, ex.ZERO, ex.ZERO), (ex.ZERO, y, ex.ZERO), (ex.ZERO, ex.ZERO, z)


def _about(axis: int, s: ex.Exact, c: ex.Exact) -> ex.Rows:
    """The turn about a coordinate axis with this sine and cosine."""
    o, i = ex.ZERO, ex.ONE
    if axis == 0:
        return (i, o, o), (o, c, -s), (o, s, c)
    return ((c, o, s), (o, i, o), (-s, o, c)) if axis == 1 else ((c, -s, o), (s, c, o), (o, o, i))
