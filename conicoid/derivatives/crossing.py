"""One crossing on a wall, and how it moves: the formulas, as kernels evaluate them.

On the wall f(x; p) = 0 with x = o + t d. So dt = -(f_p + ∇f·(do + t dd)) / (∇f·d), dx = do + t dd + d dt; the normal
n = ∇f / |∇f| turns by (d∇f - n (n·d∇f)) / |∇f| with d∇f = H dx + ∇f_p; and uv by the chain rule through its map.

A wall is a row of 25 numbers: its form and the form's anchor (`forms`), and three rows of four, its map to uv.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..compiler.jit import inline
from ..compiler.shapes import shaped
from ..engine.numbers.vectors import Vector, dot
from ..engine.tables import Floats, Ints, Longs, Signs
from .forms import FORM

WALL, CHANGE = 25, 22
"""Numbers of a wall, and of how it changes: its form and its map."""
ANCHOR, MAP_AT = FORM, FORM + 3
"""Where in a wall its anchor and its map begin; in a change the map follows the form."""


@shaped(place="n", side="n", lost="n", points="n 3", directions="n 3", t="n")
class Crossings(NamedTuple):
    """Crossings in the order of the rays."""

    place: Longs  # the row of the wall, -1 for a miss
    side: Ints  # +1 where the gradient points out of the body, -1 where into it
    lost: Signs  # 1: more than one wall is met, there is no derivative
    points: Floats
    directions: Floats
    t: Floats


@shaped(numbers="w 25", angular="w")
class WallRows(NamedTuple):
    """Walls by their rows."""

    numbers: Floats
    angular: Signs  # 1: u is an angle


class At(NamedTuple):
    """A crossing on its wall: the point, about the anchor too; half of ∇f is g, and half of ∇f·d is rate."""

    x: Vector
    r: Vector
    d: Vector
    t: float
    g: Vector
    rate: float


@inline
def scaled(factor: float, a: Vector) -> Vector:
    """factor a"""
    return factor * a[0], factor * a[1], factor * a[2]


@inline
def plus(a: Vector, b: Vector) -> Vector:
    """a + b"""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@inline
def inner(a: Vector, b: Vector) -> float:
    """a·b"""
    return dot(a[0], a[1], a[2], b[0], b[1], b[2])


@inline
def row_of(rows: Floats, i: int) -> Vector:
    """Row i of an array of three columns."""
    return rows[i, 0], rows[i, 1], rows[i, 2]


@inline
def times(forms: Floats, k: int, v: Vector) -> Vector:
    """A v for the form in row k."""
    xy, xz, yz = forms[k, 3], forms[k, 4], forms[k, 5]
    return (
        forms[k, 0] * v[0] + xy * v[1] + xz * v[2],
        xy * v[0] + forms[k, 1] * v[1] + yz * v[2],
        xz * v[0] + yz * v[1] + forms[k, 2] * v[2],
    )


@inline
def half_gradient(forms: Floats, k: int, r: Vector) -> Vector:
    """Half of ∇f, A r + B."""
    return plus(times(forms, k, r), (forms[k, 6], forms[k, 7], forms[k, 8]))


@inline
def at_wall(walls: WallRows, crossings: Crossings, i: int, k: int) -> At:
    """Crossing i on wall k."""
    w = walls.numbers
    x, d = row_of(crossings.points, i), row_of(crossings.directions, i)
    r = x[0] - w[k, ANCHOR], x[1] - w[k, ANCHOR + 1], x[2] - w[k, ANCHOR + 2]
    g = half_gradient(w, k, r)
    return At(x, r, d, crossings.t[i], g, inner(g, d))


@inline
def time_moved(at: At, by_ray: Vector, by_wall: float) -> float:
    """dt where the point of the ray moves by do + t dd and f by f_p."""
    change = inner(at.g, by_ray) + 0.5 * by_wall
    return 0.0 - change / at.rate


@inline
def form_at(forms: Floats, k: int, r: Vector, half: Vector) -> float:
    """f at r, whose half gradient is known: r·(A r + B) + r·B + C."""
    value: float = inner(r, plus(half, (forms[k, 6], forms[k, 7], forms[k, 8]))) + forms[k, 9]
    return value


@inline
def normal_moved(walls: WallRows, k: int, at: At, dx: Vector, of_gradient: Vector, side: float) -> Vector:
    """dn of the unit normal that looks outward, where ∇f_p / 2 is known."""
    size = math.sqrt(inner(at.g, at.g))
    n = scaled(1.0 / size, at.g)
    dg = plus(times(walls.numbers, k, dx), of_gradient)
    return scaled(side / size, plus(dg, scaled(-inner(n, dg), n)))


@inline
def mapped(rows: Floats, k: int, first: int, v: Vector, one: float) -> Vector:
    """Three rows of four, from a column on, of (v, one): a point with 1, a change with 0."""
    a, b, c = first, first + 4, first + 8
    return (
        rows[k, a] * v[0] + rows[k, a + 1] * v[1] + rows[k, a + 2] * v[2] + rows[k, a + 3] * one,
        rows[k, b] * v[0] + rows[k, b + 1] * v[1] + rows[k, b + 2] * v[2] + rows[k, b + 3] * one,
        rows[k, c] * v[0] + rows[k, c + 1] * v[1] + rows[k, c + 2] * v[2] + rows[k, c + 3] * one,
    )


@inline
def uv_moved(angular: bool, own: Vector, change: Vector) -> tuple[float, float]:
    """(du, dv): u is the angle of (a, b) in turns and v is c, or u is a and v is b."""
    if not angular:
        return change[0], change[1]
    a, b, _ = own
    return (a * change[1] - b * change[0]) / (2.0 * math.pi * (a * a + b * b)), change[2]
