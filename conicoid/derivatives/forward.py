"""How crossings move: the implicit function at the wall, in columns of many crossings.

On the wall f(x; p) = 0 with x = o + t d. So dt = -(f_p + ∇f·(do + t dd)) / (∇f·d), dx = do + t dd + d dt; the normal
n = ∇f / |∇f| turns by (d∇f - n (n·d∇f)) / |∇f| with d∇f = H dx + ∇f_p; and uv by the chain rule through its map.

A number is a column of many crossings, or one float for all of them, as the numbers of a wall are that all are on.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from ..shapes.vector import FloatArray

Columns: TypeAlias = list[Any]
"""The x, y and z of many vectors, or the numbers of their walls."""
Table: TypeAlias = list[Any]
"""Numbers of walls by columns, each an array (walls,) or one float for all."""


@dataclass
class At:
    """Crossings (n,) on walls, in columns. Half of ∇f is g, and half of ∇f·d is rate."""

    wall: Any
    rows: Columns  # 25: form, anchor and map of each one's wall
    x: Columns
    d: Columns
    t: Any
    r: Columns
    g: Columns
    rate: Any


def at_walls(table: Table, wall: Any, x: Columns, d: Columns, t: Any) -> At:
    """Crossings at points x with walls whose numbers are in 25 columns of a table; on one wall, or each on its own."""
    rows = numbers_of(table, wall)
    r = [x[k] - rows[10 + k] for k in range(3)]
    g = gradient(rows, r)
    return At(wall, rows, x, d, t, r, g, dot(g, d))


def table_of(*parts: FloatArray) -> Table:
    """Numbers of walls, (walls, n) each, as columns; one float in place of a column of equal ones."""
    rows = np.ascontiguousarray(np.concatenate(parts, axis=1).T)
    same = (rows == rows[:, :1]).all(axis=1) if rows.shape[1] else np.zeros(len(rows), np.bool_)
    return [float(row[0]) if one else row for row, one in zip(rows, same, strict=True)]


def numbers_of(table: Table, wall: Any) -> Columns:
    """The numbers of walls from a table: floats of one, or of what all share, columns of many."""
    if isinstance(wall, int):
        return [row if isinstance(row, float) else float(row[wall]) for row in table]
    return [row if isinstance(row, float) else row.take(wall) for row in table]


def total(*terms: tuple[Any, Any]) -> Any:
    """Σ a b, without what is zero for all."""
    found = None
    for a, b in terms:
        if (isinstance(a, float) and a == 0.0) or (isinstance(b, float) and b == 0.0):
            continue
        part = b if isinstance(a, float) and a == 1.0 else a * b
        found = part if found is None else found + part
    return 0.0 if found is None else found


def times(form: Columns, v: Columns) -> Columns:
    """A v."""
    xx, yy, zz, xy, xz, yz = form[:6]
    x, y, z = v
    return [total((xx, x), (xy, y), (xz, z)), total((xy, x), (yy, y), (yz, z)), total((xz, x), (yz, y), (zz, z))]


def gradient(form: Columns, r: Columns) -> Columns:
    """Half of ∇f, A r + B."""
    return [plain_sum(a, form[6 + k]) for k, a in enumerate(times(form, r))]


def value(form: Columns, r: Columns, g: Columns) -> Any:
    """f at r, whose half gradient is g."""
    return plain_sum(plain_sum(dot(r, g), dot(r, form[6:9])), form[9])


def plain_sum(a: Any, b: Any) -> Any:
    """a + b, without what is zero for all."""
    if isinstance(b, float) and b == 0.0:
        return a
    return b if isinstance(a, float) and a == 0.0 else a + b


def dot(a: Columns, b: Columns) -> Any:
    return total((a[0], b[0]), (a[1], b[1]), (a[2], b[2]))


def unit(g: Columns) -> tuple[Columns, Any]:
    """(g / |g|, |g|)"""
    size = np.sqrt(dot(g, g))
    inverse = 1.0 / size
    return [total((component, inverse)) for component in g], size


def moved(at: At, do: Columns, dd: Columns, form: Columns | None) -> tuple[Any, Columns]:
    """(dt, dx) where rays change by do and dd, and walls by forms, if they do."""
    by_ray = [plain_sum(a, total((at.t, b))) for a, b in zip(do, dd, strict=True)]
    change = dot(at.g, by_ray)
    if form is not None:
        change = plain_sum(change, total((0.5, value(form, at.r, gradient(form, at.r)))))
    dt = -change / at.rate
    return dt, [plain_sum(a, total((dt, b))) for a, b in zip(by_ray, at.d, strict=True)]


def normals_moved(at: At, dx: Columns, form: Columns | None, side: Any) -> Columns:
    """dn of unit normals that look outward: `side` +1 where that is along ∇f, else -1."""
    n, size = unit(at.g)
    dg = times(at.rows, dx)
    if form is not None:
        dg = [plain_sum(a, b) for a, b in zip(dg, gradient(form, at.r), strict=True)]
    along, scale = dot(n, dg), side / size
    return [(a - total((b, along))) * scale for a, b in zip(dg, n, strict=True)]


def affine(rows: Columns, v: Columns, constant: bool) -> Columns:
    """Maps, 12 numbers, of columns: with their constant terms, or of changes alone."""
    found = []
    for k in range(3):
        a, b, c, d = rows[4 * k : 4 * k + 4]
        along = total((a, v[0]), (b, v[1]), (c, v[2]))
        found.append(plain_sum(along, d) if constant else along)
    return found


def uv_moved(at: At, dx: Columns, maps: Columns | None, angular: Any) -> Columns:
    """(du, dv): u is the angle of (a, b) in turns and v is c, or u is a and v is b."""
    own, change = affine(at.rows[13:], at.x, True), affine(at.rows[13:], dx, False)
    if maps is not None:
        change = [plain_sum(a, b) for a, b in zip(change, affine(maps, at.x, True), strict=True)]
    (a, b, _), (da, db, dc) = own, change
    if isinstance(angular, bool) and not angular:
        return [da, db]
    turn = (total((a, db)) - total((b, da))) / (2 * math.pi * (total((a, a)) + total((b, b))))
    if isinstance(angular, bool):
        return [turn, dc]
    return [np.where(angular, turn, da), np.where(angular, dc, db)]
