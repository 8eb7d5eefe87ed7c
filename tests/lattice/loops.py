"""Is a ray within a polygon? Even-odd, as documented: in the view along the ray."""

from __future__ import annotations

import numpy as np
from flint import fmpz

from .columns import Array, Column
from .lines import Lines
from .motions import Row


def whole_points(loop: tuple[Row, ...]) -> tuple[list[list[dict[int, int]]], int]:
    """(vertices times a positive whole number, that number)"""
    common = fmpz(1)
    for point in loop:
        for x in point:
            for c in x.k.values():
                common = common.lcm(c.q)
    return [[{s: int(c.p * (common // c.q)) for s, c in x.k.items()} for x in point] for point in loop], int(common)


def in_loop(loop: tuple[Row, ...], lines: Lines) -> Array:
    """(rays,) Vertices seen along the ray, (u, v) = (d_z X - d_x Z, d_z Y - d_y Z) with z the longest axis of the direction
    (ties: z before x before y); an edge counts from its lower end inclusive, where u > 0."""
    size = np.abs(lines.directions)
    longest = np.where(
        (size[:, 2] >= size[:, 0]) & (size[:, 2] >= size[:, 1]), 2, np.where(size[:, 0] >= size[:, 1], 0, 1)
    )
    found = np.zeros(lines.count, bool)
    points, common = whole_points(loop)
    for axis, view in ((0, (1, 2, 0)), (1, (2, 0, 1)), (2, (0, 1, 2))):
        rays = np.flatnonzero(longest == axis)
        if len(rays):
            found[rays] = _within(points, common, lines, rays, view)
    return found


def _within(
    points: list[list[dict[int, int]]], common: int, lines: Lines, rays: Array, view: tuple[int, int, int]
) -> Array:
    o, d, w = lines.o[rays].T, lines.d[rays].T, lines.w[rays]
    iu, iv, iw = view
    seen = []
    for point in points:
        x = [_relative(point[i], o[i], w, common) for i in range(3)]
        u, v = (_column(d[iw]) * x[i] - _column(d[i]) * x[iw] for i in (iu, iv))
        seen.append((u, v, v.sign < 0))
    odd = np.zeros(len(rays), bool)
    for (ua, va, below_a), (ub, vb, below_b) in zip([seen[-1], *seen[:-1]], seen, strict=True):
        crosses = below_a != below_b
        if crosses.any():
            side = (ua * vb - ub * va).sign
            odd ^= crosses & np.where(below_a, side > 0, side < 0)
    return odd


def _column(x: Array) -> Column:
    return Column({1: x}, int(abs(x).max()))


def _relative(k: dict[int, int], o: Array, w: Array, common: int) -> Column:
    """common w (x - origin)"""
    wide = _column(w)
    found = Column({1: np.zeros_like(w)}, 0) - _column(o).times(common)
    for s, c in k.items():
        found = found + Column({s: wide.times(c).parts[1]}, wide.top * abs(c))
    return found
