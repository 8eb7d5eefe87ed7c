"""The crossings of one ray with some surfaces, in order, decided exactly."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cmp_to_key
from typing import Any

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


def exact_ranks(places: Sequence[Place]) -> list[float]:
    """The rank of each place along a ray: equal for equal ones, 0 for the first, which is the ray's origin.

    Places are told apart by floats around them first: hundreds of surfaces that a ray meets in one point are one place.
    """
    one: dict[Any, Place] = {}
    distinct = [one.setdefault(_name(place), place) for place in places]
    order = sorted(one.values(), key=_least)
    rank: dict[int, float] = {}
    begin, so_far = 0, 0.0
    while begin < len(order):
        end, most = begin + 1, _most(order[begin])
        while end < len(order) and _least(order[end]) <= most:
            most = max(most, _most(order[end]))
            end += 1
        near = sorted(order[begin:end], key=cmp_to_key(_compare))
        for k, place in enumerate(near):
            so_far += 1.0 if k == 0 or _compare(near[k - 1], place) != 0 else 0.0
            rank[id(place)] = so_far
        begin = end
    zero = rank[id(distinct[0])]
    return [rank[id(place)] - zero for place in distinct]


def _name(place: Place) -> Any:
    """The same for places that are known to be one."""
    if isinstance(place, float):
        return place
    return id(place) if place.name is None else place.name


def _least(place: Place) -> float:
    return place if isinstance(place, float) else place.ends[0]


def _most(place: Place) -> float:
    return place if isinstance(place, float) else place.ends[1]


def _compare(x: Place, y: Place) -> int:
    if isinstance(x, float) or isinstance(y, float):
        a, b = (value if isinstance(value, float) else 0.0 for value in (x, y))
        return (a > b) - (a < b)
    return compare(x, y)
