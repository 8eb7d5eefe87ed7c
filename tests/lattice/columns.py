"""Many numbers of a multiquadratic field at once: for each square-free s an array of whole numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from .field import product, sign_of

Array = npt.NDArray[Any]
SMALL = 1 << 62
ROUNDED = 2.0**-47
"""At most sixteen terms, each of three roundings, and their sum."""
MOST_BITS = 1000


class Column:
    """sum of parts[s] sqrt s; no entry of a part is larger than `top`. Parts are int64, or Python's integers if `top` is large."""

    __slots__ = ("parts", "top")

    def __init__(self, parts: dict[int, Array], top: int) -> None:
        self.top = top
        self.parts = parts if top < SMALL else {s: whole(x) for s, x in parts.items()}

    def _of(self, kind: Any) -> dict[int, Array]:
        return self.parts if kind is np.int64 else {s: whole(x) for s, x in self.parts.items()}

    def __add__(self, other: Column) -> Column:
        top = self.top + other.top
        kind = np.int64 if top < SMALL else object
        mine, its = dict(self._of(kind)), other._of(kind)
        for s, x in its.items():
            mine[s] = mine[s] + x if s in mine else x
        return Column(mine, top)

    def __neg__(self) -> Column:
        return Column({s: -x for s, x in self.parts.items()}, self.top)

    def __sub__(self, other: Column) -> Column:
        return self + -other

    def __mul__(self, other: Column) -> Column:
        top = 0
        sums: dict[int, int] = {}
        for p in self.parts:
            for q in other.parts:
                f, s = product(p, q)
                sums[s] = sums.get(s, 0) + f * self.top * other.top
        top = max(sums.values(), default=0)
        kind = np.int64 if top < SMALL else object
        mine, its = self._of(kind), other._of(kind)
        parts: dict[int, Array] = {}
        for p, x in mine.items():
            for q, y in its.items():
                f, s = product(p, q)
                z = x * y if f == 1 else x * y * f
                parts[s] = parts[s] + z if s in parts else z
        return Column(parts, top)

    def times(self, k: int) -> Column:
        top = self.top * abs(k)
        kind = np.int64 if top < SMALL else object
        return Column({s: x * k for s, x in self._of(kind).items()}, top)

    def __getitem__(self, index: Any) -> Column:
        return Column({s: x[index] for s, x in self.parts.items()}, self.top)

    def tight(self) -> Column:
        """The same, `top` as it is."""
        parts = {s: x for s, x in self.parts.items() if x.any()}
        top = max((int(abs(x).max()) for x in parts.values()), default=0)
        if top < SMALL:
            parts = {s: x.astype(np.int64) for s, x in parts.items()}
        shape = next(iter(self.parts.values())).shape if self.parts else (0,)
        return Column(parts or {1: np.zeros(shape, np.int64)}, top)

    @property
    def shape(self) -> tuple[int, ...]:
        return next(iter(self.parts.values())).shape

    @property
    def zero(self) -> Array:
        found = np.ones(self.shape, bool)
        for x in self.parts.values():
            found &= np.asarray(x == 0, bool)
        return found

    def floats(self) -> tuple[Array, Array, int]:
        """(value, bound of its error, e): the number is value 2^e."""
        shift = max(0, self.top.bit_length() - MOST_BITS)
        value, size = np.zeros(self.shape), np.zeros(self.shape)
        for s, x in self.parts.items():
            term = (x >> shift if shift else x).astype(np.float64) * math.sqrt(s)
            value += term
            size += np.abs(term)
            if shift:
                size += 2.0**47 * (math.isqrt(s) + 2)
        return value, size * ROUNDED, shift

    @property
    def sign(self) -> Array:
        """-1, 0 or 1 of each."""
        if len(self.parts) == 1:
            return np.sign(next(iter(self.parts.values()))).astype(np.int8)
        value, error, _ = self.floats()
        found = np.where(value > error, 1, np.where(value < -error, -1, 0)).astype(np.int8)
        open_ = (found == 0) & ~self.zero
        for where in zip(*np.nonzero(open_), strict=True):
            found[where] = sign_of({s: int(x[where]) for s, x in self.parts.items()})
        return found

    def at(self, where: Any) -> dict[int, int]:
        """One of them."""
        return {s: int(x[where]) for s, x in self.parts.items() if x[where]}


def whole(x: Array) -> Array:
    """As Python's integers."""
    return x if x.dtype == object else x.astype(object)


def combined(coefficients: dict[int, Array], values: Array, top: int) -> Column:
    """Of K (forms, m) for each s and values (m, rays), K values: (forms, rays). No |value| is above `top`."""
    most = max((int(abs(k).max()) for k in coefficients.values() if k.size), default=0)
    limit = most * top * values.shape[0]
    small = max(limit, most, top) < SMALL
    parts = {}
    for s, k in coefficients.items():
        if small:
            parts[s] = k.astype(np.int64) @ values.astype(np.int64)
        else:
            parts[s] = np.dot(whole(k), whole(values))
    return Column(parts, limit)


def stacked(rows: Sequence[Sequence[dict[int, int]]]) -> dict[int, Array]:
    """Numbers with whole coefficients, rows of them, as an array for each s."""
    every = sorted({s for row in rows for k in row for s in k} | {1})
    return {s: np.array([[k.get(s, 0) for k in row] for row in rows], dtype=object) for s in every}
