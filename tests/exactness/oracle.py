"""The right answers for many rays: the filter where it is certain, exact arithmetic where it is not."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .exact import ExactRay, as_pair, distance
from .filtered import Filtered, traced
from .local import located
from .traced import SKIPPED, Shape, crossings
from .wide import Array

CELLS = 1 << 22
"""Rays × gaps × forms at a time."""


@dataclass
class Answers:
    """Every crossing of the whole line of every ray, in order.

    `offsets` (N + 1,) into rows: t = high + low within slack, `sign` of the exact t, entering, face, form, body.
    `hard` (N,): rays that took exact arithmetic.
    """

    offsets: Array
    high: Array
    low: Array
    slack: Array
    sign: Array
    entering: Array
    face: Array
    form: Array
    body: Array
    hard: Array

    @property
    def ray(self) -> Array:
        return np.repeat(np.arange(len(self.offsets) - 1), np.diff(self.offsets))


class Oracle:
    """A shape, where it is and how large."""

    def __init__(self, shape: Shape, center: Any, size: float) -> None:
        self.shape, self.local = shape, located(shape, center, size)

    def answers(self, origins: Array, directions: Array) -> Answers:
        parts = []
        forms = len(self.shape.forms)
        chunk = max(64, min(4096, CELLS // (forms * (2 * forms + 1))))
        for begin in range(0, len(origins), chunk):
            rows = slice(begin, begin + chunk)
            parts.append(self._chunk(origins[rows], directions[rows]))
        return _joined(parts)

    def _chunk(self, origins: Array, directions: Array) -> Answers:
        with np.errstate(all="ignore"):
            easy = traced(self.shape, self.local, origins, directions)
        unclear = np.abs(easy.high) * (1 - 2.0**-50) <= easy.slack  # which side of the origin?
        easy.decided[easy.ray[unclear]] = False
        return _with_exact(self.shape, easy, origins, directions)

    def error(
        self, origin: Array, direction: Array, number: int, t: float, start: int = SKIPPED
    ) -> tuple[float, float]:
        """(lower, upper) bounds of |t - exact t| of a ray's crossing."""
        found = crossings(self.shape, ExactRay(origin, direction), start)
        return distance(found[number].root, t)


def _with_exact(shape: Shape, easy: Filtered, origins: Array, directions: Array) -> Answers:
    """Rows of hard rays among those of easy ones."""
    keep = easy.decided[easy.ray]
    columns = [
        x[keep] for x in (easy.ray, easy.high, easy.low, easy.slack, easy.entering, easy.face, easy.form, easy.body)
    ]
    sign = np.sign(columns[1])
    rows: list[tuple[Any, ...]] = []
    for i in np.flatnonzero(~easy.decided).tolist():
        for c in crossings(shape, ExactRay(origins[i], directions[i])):
            high, low = as_pair(c.root)
            slack = 2.0**-100 * abs(high) + 1e-320
            rows.append((i, high, low, slack, c.entering, c.face, c.root.index, c.body, c.root.sign))
    extra = list(zip(*rows, strict=True)) if rows else [()] * 9
    columns = [np.concatenate([a, np.array(b, dtype=a.dtype)]) for a, b in zip([*columns, sign], extra, strict=True)]
    order = np.argsort(columns[0], kind="stable")
    ray, *rest, sign = (column[order] for column in columns)
    offsets = np.concatenate([[0], np.cumsum(np.bincount(ray, minlength=len(origins)))])
    high, low, slack, entering, face, form, body = rest
    return Answers(offsets, high, low, slack, sign, entering, face, form, body, ~easy.decided)


def _joined(parts: list[Answers]) -> Answers:
    """Chunks end to end."""
    bases = np.cumsum([0, *(p.offsets[-1] for p in parts)])
    offsets = np.concatenate([[0], *(p.offsets[1:] + base for p, base in zip(parts, bases, strict=False))])
    names = ("high", "low", "slack", "sign", "entering", "face", "form", "body", "hard")
    return Answers(offsets, *(np.concatenate([getattr(p, name) for p in parts]) for name in names))
