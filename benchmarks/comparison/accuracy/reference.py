"""The first crossing of a ray with a body, in integers: what every system is measured against.

Floats are integers times powers of two, so the quadratic A t² + 2 B t + C <= 0 of a ray in a body is known exactly,
and so is the sign of its discriminant. Roots are taken with `math.isqrt` to some 300 bits. Nothing of Conicoid's
own arithmetic is used.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from .bodies import Body, Floats

BITS = 384
"""t is kept in units of 2^-BITS."""

_ONE = 1 << BITS
_ROOT_BITS = 320

Number = int | float
"""t in units of 2^-BITS; only the infinite ones are floats."""


class Tie(Exception):
    """The ray touches, meets an edge or starts on the surface. There systems differ by definition."""


@dataclass(frozen=True)
class ExactCrossings:
    """First crossings with t > 0 of n rays: high + low, inf for a miss. Rays with `tie` have no agreed answer."""

    high: Floats
    low: Floats
    tie: npt.NDArray[np.bool_]

    def errors(self, t: Floats) -> Floats:
        """|t - exact| (n,), right to the last bit but one; NaN where either is infinite."""
        with np.errstate(invalid="ignore"):
            return np.abs((t - self.high) - self.low)


def first_crossings(body: Body, origins: Floats, directions: Floats) -> ExactCrossings:
    """Of rays (n, 3), each a Python loop of some ten microseconds."""
    shift = _shift(origins, directions)
    equations = _Integers(body, shift)
    high, low, tie = np.full(len(origins), np.inf), np.zeros(len(origins)), np.zeros(len(origins), bool)
    for i, (o, d) in enumerate(zip(origins.tolist(), directions.tolist(), strict=True)):
        try:
            t = equations.first([_integer(x, shift) for x in o], [_integer(x, shift) for x in d])
        except Tie:
            tie[i] = True
            continue
        if t is not None:
            high[i], low[i] = _two_floats(t)
    return ExactCrossings(high, low, tie)


class _Integers:
    """A body with lengths in units of 2^-shift and its equations times whatever makes them whole."""

    def __init__(self, body: Body, shift: int) -> None:
        self.one = 1 << shift
        quadric: Any = body.quadric()
        self.quadric = None if quadric is None else _whole(quadric)
        # normal·X - low·2^shift >= 0 >= normal·X - high·2^shift, in one scale
        slabs = [(*slab.normal, -slab.low, -slab.high) for slab in body.slabs()]
        self.slabs = _whole(slabs) if slabs else []

    def first(self, o: list[int], d: list[int]) -> int | None:
        """t of the first crossing, None for a miss; raises Tie."""
        low, high = self._between(o, d)
        for a, b in self._inside(o, d):
            begin, end = max(a, low), min(b, high)
            if not _less(begin, end):
                continue
            for t in (begin, end):
                if _less(0, t) and not math.isinf(t):
                    return int(t)
        return None

    def _between(self, o: list[int], d: list[int]) -> tuple[Number, Number]:
        """What of the ray's line is between all slabs, from and to; from > to if nothing is."""
        low, high = -math.inf, math.inf
        for x, y, z, below, above in self.slabs:
            slope = x * d[0] + y * d[1] + z * d[2]
            height = x * o[0] + y * o[1] + z * o[2]
            ends = (height + below * self.one, height + above * self.one)
            if slope == 0:
                if 0 in ends:
                    raise Tie
                if not ends[0] > 0 > ends[1]:
                    return math.inf, -math.inf
                continue
            a, b = sorted((-end << BITS) // slope for end in ends)
            low, high = max(low, a), min(high, b)
        return low, high

    def _inside(self, o: list[int], d: list[int]) -> Iterator[tuple[Number, Number]]:
        """The intervals of the ray's line within the quadric, in order."""
        if self.quadric is None:
            yield -math.inf, math.inf
            return
        a, b, c = self._quadratic(o, d)
        inner, roots = _sign_and_roots(a, b, c)
        ends = (-math.inf, *roots, math.inf)
        # the sign of the quadratic alternates, beginning with that at minus infinity
        for k, (begin, end) in enumerate(pairwise(ends)):
            if (k % 2 == 0) == inner:
                yield begin, end

    def _quadratic(self, o: list[int], d: list[int]) -> tuple[int, int, int]:
        p, q = (*o, self.one), self.quadric
        assert q is not None
        towards = [row[0] * d[0] + row[1] * d[1] + row[2] * d[2] for row in q]
        at = [row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3] * p[3] for row in q]
        return (
            towards[0] * d[0] + towards[1] * d[1] + towards[2] * d[2],
            towards[0] * p[0] + towards[1] * p[1] + towards[2] * p[2] + towards[3] * p[3],
            at[0] * p[0] + at[1] * p[1] + at[2] * p[2] + at[3] * p[3],
        )


def _sign_and_roots(a: int, b: int, c: int) -> tuple[bool, list[int]]:
    """Whether a t² + 2 b t + c is negative towards minus infinity, and its roots in order; raises Tie."""
    if a == 0:
        if b == 0 and c == 0:
            raise Tie
        return (b > 0, [(-c << BITS) // (2 * b)]) if b else (c < 0, [])
    square = b * b - a * c
    if square == 0:
        raise Tie
    if square < 0:
        return a < 0, []
    guard = max(0, _ROOT_BITS - square.bit_length() // 2)
    root = math.isqrt(square << 2 * guard)
    q = -(b << guard) - root if b >= 0 else root - (b << guard)
    return a < 0, sorted(((q << BITS) // (a << guard), (c << guard + BITS) // q))


def _less(a: Number, b: Number) -> bool:
    """Return a < b; raise Tie where the bits do not decide, which is at 2^-300 and closer."""
    if math.isinf(a) or math.isinf(b):
        return a < b
    difference = int(b) - int(a)
    if abs(difference) <= (1 << 32) + ((abs(int(a)) + abs(int(b))) >> 256):
        raise Tie
    return difference > 0


def _shift(*arrays: Floats) -> int:
    """The bits behind the point of the finest of the numbers."""
    return max(x.as_integer_ratio()[1] for array in arrays for x in array.ravel().tolist()).bit_length() - 1


def _integer(x: float, shift: int) -> int:
    """x 2^shift."""
    above, below = x.as_integer_ratio()
    return (above << shift) // below


def _whole(rows: list[tuple[Fraction, ...]]) -> list[tuple[int, ...]]:
    """Rows times the common denominator of all."""
    common = math.lcm(*(x.denominator for row in rows for x in row))
    return [tuple(int(x * common) for x in row) for row in rows]


def _two_floats(t: int) -> tuple[float, float]:
    """Return the nearest float64, and the remainder."""
    high = t / _ONE
    above, below = high.as_integer_ratio()
    return high, (t - above * (_ONE // below)) / _ONE


# Errors counted: wrong answers per million, the spread of the errors of t in units in the last place.

EDGES = np.arange(-5, 55)
"""Bins of the histogram, powers of two: an error of e ulps is in bin k where 2^EDGES[k] <= e < 2^EDGES[k + 1]. The
first and the last bin take all beyond.
"""


@dataclass(frozen=True)
class SystemAnswer:
    """t (n,) of a system, inf for a miss, and its bounds on |t - exact|, where it gives any."""

    t: Floats
    bound: Floats | None = None


@dataclass(frozen=True)
class Spread:
    """Errors of t in ulps of float64 at the exact t, over all rays that both sides say hit.

    `bounds` is the histogram of the bounds, `bound_ratio` their median over the median error (None where that is
    0), `violations` how many errors exceed their bound.
    """

    median: float
    most: float
    largest: float
    histogram: list[int]
    bounds: list[int] | None = None
    bound_ratio: float | None = None
    violations: int | None = None


@dataclass
class Tally:
    """Wrong answers and errors of a system; rays without an agreed answer are left out of everything else."""

    rays: int = 0
    ties: int = 0
    hits: int = 0
    wrong_hits: int = 0
    wrong_misses: int = 0
    errors: list[Floats] = field(default_factory=list)
    bounds: list[Floats] = field(default_factory=list)
    violations: int = 0

    def add(self, exact: ExactCrossings, answer: SystemAnswer) -> None:
        agreed = ~exact.tie
        ours, theirs = np.isfinite(answer.t) & agreed, np.isfinite(exact.high) & agreed
        self.rays += int(agreed.sum())
        self.ties += int(exact.tie.sum())
        self.hits += int(theirs.sum())
        self.wrong_hits += int((ours & ~theirs).sum())
        self.wrong_misses += int((theirs & ~ours).sum())
        both = ours & theirs
        error, ulp = exact.errors(answer.t)[both], ulps(exact.high[both])
        self.errors.append(error / ulp)
        if answer.bound is not None:
            bound = answer.bound[both]
            self.bounds.append(bound / ulp)
            # the error is rounded twice by 2^-53: half an ulp below it is no proof of an excess
            self.violations += int((np.nextafter(error, 0) > bound).sum())

    def merge(self, other: Tally) -> None:
        """Take in what another has counted."""
        for name in ("rays", "ties", "hits", "wrong_hits", "wrong_misses", "errors", "bounds", "violations"):
            setattr(self, name, getattr(self, name) + getattr(other, name))

    def per_million(self, count: int) -> float:
        return 1e6 * count / max(self.rays, 1)

    def spread(self) -> Spread | None:
        """None where nothing was hit."""
        errors = np.concatenate([np.empty(0), *self.errors])
        if not len(errors):
            return None
        median, most = np.quantile(errors, (0.5, 0.999)).tolist()
        if not self.bounds:
            return Spread(median, most, float(errors.max()), histogram(errors))
        bounds = np.concatenate(self.bounds)
        ratio = float(np.median(bounds)) / median if median else None
        return Spread(median, most, float(errors.max()), histogram(errors), histogram(bounds), ratio, self.violations)


def histogram(errors: Floats) -> list[int]:
    """How many lie in each of the bins of `EDGES`."""
    with np.errstate(divide="ignore"):
        bins = np.clip(np.floor(np.log2(errors)), EDGES[0], EDGES[-1]) - EDGES[0]
    counts: list[int] = np.bincount(bins.astype(int), minlength=len(EDGES)).tolist()
    return counts


def ulps(t: Floats) -> Floats:
    """The distance from float64 to float64 at t."""
    spacing: npt.NDArray[np.float64] = np.spacing(np.abs(t))
    return spacing
