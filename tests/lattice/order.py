"""Which roots of a ray are equal, decided by algebra, and which come first.

Two quadratics share a root if the resultant (A1 C2 - A2 C1)² - (A1 B2 - A2 B1)(B1 C2 - B2 C1) is zero. If
A1 B2 - A2 B1 is not zero then, that root is -(A1 C2 - A2 C1) / (A1 B2 - A2 B1), and it is the root of either with slope
sign(2 A x + B). A root is named (slope, surface): slope 0 where the form falls, 1 where it rises.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cmp_to_key
from typing import Any

import numpy as np

from .columns import Array, Column
from .lines import Lines

FIRST_BITS = 128


@dataclass
class Order:
    """The roots of each ray in order, up to `width` of them: (rays, width), -1 and infinite beyond the last.

    `group` counts up from 0 where a root is not equal to the one before.
    """

    slope: Array
    surface: Array
    group: Array
    count: Array


def equal_pairs(lines: Lines, ray: Array, one: tuple[Array, Array], two: tuple[Array, Array]) -> Array:
    """Are roots (slope, surface) `one` and `two` of some rays equal?"""
    (s1, f1), (s2, f2) = one, two
    a1, b1, c1 = (x[f1, ray] for x in (lines.a, lines.b, lines.c))
    a2, b2, c2 = (x[f2, ray] for x in (lines.a, lines.b, lines.c))
    m, n, k = a1 * b2 - a2 * b1, a1 * c2 - a2 * c1, b1 * c2 - b2 * c1
    no_m, shared = m.zero, (n * n - m * k).zero
    signs_a = lines.signs[0]
    planes = (signs_a[f1, ray] == 0) & (signs_a[f2, ray] == 0)
    alike = signs_a[f1, ray] * signs_a[f2, ray] * _signed(s1) == _signed(s2)
    return np.where(
        planes,
        k.zero,
        np.where(no_m, n.zero & alike, shared & _at_common(a1, b1, m, n, s1) & _at_common(a2, b2, m, n, s2)),
    )


def _signed(slope: Array) -> Array:
    return 2 * slope - 1


def _at_common(a: Column, b: Column, m: Column, n: Column, slope: Array) -> Array:
    """Is the root with that slope -n / m?"""
    return ((b * m - (a * n).times(2)).sign * m.sign) == _signed(slope)


def compare(lines: Lines, ray: int, one: tuple[int, int], two: tuple[int, int]) -> int:
    """-1, 0, 1 for one < two, one = two, one > two"""
    if one == two:
        return 0
    pairs = [(np.array([s]), np.array([f])) for s, f in (one, two)]
    if one[1] != two[1] and equal_pairs(lines, np.array([ray]), *pairs)[0]:
        return 0
    bits = FIRST_BITS
    while True:
        p, q = lines.ball(*one, ray, bits), lines.ball(*two, ray, bits)
        if p < q:
            return -1
        if p > q:
            return 1
        bits *= 2
        assert bits < 1 << 17, "two roots that cannot be parted"


def ordered(lines: Lines) -> Order:
    """All roots of all rays, in order and in groups."""
    forms, rays = lines.a.shape
    t, error = (x.reshape(2 * forms, rays).T for x in lines.near)
    count = lines.crosses.reshape(2 * forms, rays).sum(axis=0)
    width = max(1, int(count.max(initial=0)))
    place = np.argsort(t, axis=1, kind="stable")[:, :width]
    rows = np.arange(rays)[:, None]
    t, error = t[rows, place], error[rows, place]
    here = np.arange(width) < count[:, None]
    slope, surface = np.where(here, place // forms, -1), np.where(here, place % forms, -1)
    new = np.ones((rays, width), bool)
    unclear = here[:, 1:] & here[:, :-1]
    with np.errstate(all="ignore"):
        unclear &= ~(t[:, 1:] - error[:, 1:] > t[:, :-1] + error[:, :-1])
    _settle(lines, slope, surface, new, unclear, np.isinf(error).any(axis=1))
    group = np.where(here, np.cumsum(new, axis=1) - 1, -1)
    return Order(slope, surface, group, count)


def _settle(lines: Lines, slope: Array, surface: Array, new: Array, unclear: Array, lost: Array) -> None:
    """Decide neighbours that overlap; rays whose order is not that of the floats are sorted one by one."""
    unclear &= ~lost[:, None]
    ray, k = np.nonzero(unclear)
    again = set(np.flatnonzero(lost).tolist())
    if len(ray):
        one, two = (slope[ray, k], surface[ray, k]), (slope[ray, k + 1], surface[ray, k + 1])
        same = equal_pairs(lines, ray, one, two) & (one[1] != two[1])
        new[ray[same], k[same] + 1] = False
        for i in np.flatnonzero(~same).tolist():
            p, q = ((int(x[0][i]), int(x[1][i])) for x in (one, two))
            if compare(lines, int(ray[i]), p, q) > 0:
                again.add(int(ray[i]))
    for i in again:
        _sort_one(lines, i, slope, surface, new)


def _sort_one(lines: Lines, ray: int, slope: Array, surface: Array, new: Array) -> None:
    used = int((surface[ray] >= 0).sum())
    roots: list[tuple[int, int]] = [(int(slope[ray, k]), int(surface[ray, k])) for k in range(used)]

    def by_place(p: Any, q: Any) -> int:
        return compare(lines, ray, p, q)

    roots.sort(key=cmp_to_key(by_place))
    for k, (s, f) in enumerate(roots):
        slope[ray, k], surface[ray, k] = s, f
        new[ray, k] = k == 0 or compare(lines, ray, roots[k - 1], (s, f)) != 0
