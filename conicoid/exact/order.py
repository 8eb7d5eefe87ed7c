"""The crossings of one ray with some surfaces, in order, decided exactly."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cmp_to_key

from .forms import Form, Line
from .roots import ZERO, Root, compare, roots, sign

Place = Root | float  # a root, or an infinity


@dataclass(frozen=True)
class Verdict:
    """What a surface does to a ray: does it cross; the sign of a, of a rate or of the value all along; where."""

    crosses: bool
    sense: int
    low: Place = 0.0
    high: Place = 0.0


def verdict(form: Form, line: Line, starts: bool) -> Verdict:
    """The verdict on a surface; of the one that a ray starts on, the root nearest to t = 0 comes out as 0."""
    q = form.along(line)
    if form.is_flat:
        return _flat(sign(q.b), sign(q.c), starts, roots(q))
    found = roots(q)
    if not found:
        return Verdict(False, sign(q.a) or sign(q.c))
    if len(found) == 1:
        here = ZERO if starts else found[0]
        return Verdict(True, 0, here, math.inf) if q.b < 0 else Verdict(True, 0, -math.inf, here)
    low, high = found
    if starts:
        # low + high = -2 b / a
        if q.b == 0:
            return Verdict(False, sign(q.a))
        low, high = (ZERO, high) if (q.b < 0) == (q.a > 0) else (low, ZERO)
    return Verdict(True, sign(q.a), low, high)


def _flat(rate: int, height: int, starts: bool, found: Sequence[Root]) -> Verdict:
    if rate == 0:
        return Verdict(False, 0 if starts else height)
    here = ZERO if starts else found[0]
    return Verdict(True, rate, here, here)


def _compare(x: Place, y: Place) -> int:
    if isinstance(x, float) or isinstance(y, float):
        a, b = (value if isinstance(value, float) else 0.0 for value in (x, y))
        return (a > b) - (a < b)
    return compare(x, y)


def exact_ranks(places: Sequence[Place]) -> list[float]:
    """The rank of each place along a ray: equal for equal ones, 0 for the first, which is the ray's origin."""

    def later(i: int, j: int) -> int:
        return _compare(places[i], places[j])

    order = sorted(range(len(places)), key=cmp_to_key(later))
    rank = [0.0] * len(places)
    for k in range(1, len(order)):
        rank[order[k]] = rank[order[k - 1]] + (later(order[k - 1], order[k]) != 0)
    return [r - rank[0] for r in rank]
