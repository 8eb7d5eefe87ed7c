"""TR cards: where an auxiliary system stands in the main one; and surfaces that are given in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

from ...shapes.rounded import root, sin_cos_degrees
from ..openmc.placement import (
    ORIGIN,
    STRAIGHT,
    Placement,
    Point,
    Rotation,
    Rows,
    departure,
    inverse,
    rotation_by_matrix,
)
from ..openmc.surfaces import TERMS, ConeSurface, FlatSurface, QuadricSurface, RoundSurface, Surface
from .vectors import UNIT, applied, cross, dot, plus, point, product, scaled, transposed

CROOKED = Fraction(1, 100)
"""How far a matrix may be from a rotation."""


@dataclass(frozen=True)
class Change:
    """x' = rows (x - origin): rows are the auxiliary axes in the main system, `origin` is where they meet there."""

    origin: Point = ORIGIN
    rows: Rows = UNIT
    is_free: bool = False  # two of the axes may be turned about the third

    @cached_property
    def rotation(self) -> Rotation:
        """How the contents move."""
        found = STRAIGHT if self.rows == UNIT else rotation_by_matrix(self.rows)
        assert found is not None
        return found

    @property
    def skew(self) -> float:
        """How far the matrix is from a rotation."""
        return departure(self.rows)

    def __hash__(self) -> int:
        return hash(self.origin)


def change_of(values: Sequence[Fraction | None], degrees: bool) -> Change:
    """Of the entries of a TR card: displacement, cosines or degrees, and m. Raises ValueError."""
    given = [*values]
    if not 1 <= len(given) <= 13:
        raise ValueError(f"a transformation has 1 to 13 numbers, got {len(given)}")
    flip = len(given) == 13 and given.pop() == -1
    if len(values) == 13 and not flip and values[-1] not in (1, None):
        raise ValueError("the last of 13 numbers of a transformation must be 1 or -1")
    shift = point([value or Fraction(0) for value in (*given, None, None, None)[:3]])
    rest = [None if value is None else _cosine(value) if degrees else value for value in given[3:]]
    rows, is_free = _rows([*rest, *[None] * (9 - len(rest))])
    back = inverse(rows)
    if back is None or departure(rows) > CROOKED:
        raise ValueError(
            f"the matrix of a transformation must be a rotation, it is {departure(rows):.2g} away from one"
        )
    return Change(scaled(applied(back, shift), -1) if flip else shift, rows, is_free)


def _cosine(angle: Fraction) -> Fraction:
    """Of degrees; halves and whole numbers exactly."""
    if angle % 60 == 0 or angle % 90 == 0:
        halves = {0: 2, 60: 1, 90: 0, 120: -1, 180: -2, 240: -1, 270: 0, 300: 1}
        return Fraction(halves[int(angle % 360)], 2)
    return Fraction(sin_cos_degrees(angle)[1])


def _rows(given: list[Fraction | None]) -> tuple[Rows, bool]:
    """All nine cosines of 9, 6, 5, 3 or none; and whether MCNP is free to choose some."""
    rows = [given[0:3], given[3:6], given[6:9]]
    columns = [given[i::3] for i in range(3)]
    count = sum(value is not None for value in given)
    if count == 0:
        return UNIT, False
    if count == 9:
        return (point(rows[0]), point(rows[1]), point(rows[2])), False  # type: ignore[arg-type]
    whole_rows = [i for i in range(3) if None not in rows[i]]
    whole_columns = [i for i in range(3) if None not in columns[i]]
    if count == 6 and len(whole_rows) == 2:
        return _two(rows, whole_rows), False
    if count == 6 and len(whole_columns) == 2:
        return transposed(_two(columns, whole_columns)), False
    if count == 5 and len(whole_rows) == len(whole_columns) == 1:
        return _cross_shaped(given, whole_rows[0], whole_columns[0]), False
    if count == 3 and whole_rows:
        return _one(rows, whole_rows[0]), True
    if count == 3 and whole_columns:
        return transposed(_one(columns, whole_columns[0])), True
    raise ValueError(
        "the matrix of a transformation is given by 9, 6, 5, 3 or none of its numbers, the 6 in two rows or columns, "
        f"the 5 in a row and a column, the 3 in a row or column; got {count} otherwise"
    )


def _two(lines: list[list[Fraction | None]], known: list[int]) -> Rows:
    """With the third line across two."""
    i, j = known
    third = 3 - i - j
    a, b = point(lines[i]), point(lines[j])  # type: ignore[arg-type]
    across = cross(a, b) if (j - i) % 3 == 1 else cross(b, a)
    found = {i: a, j: b, third: across}
    return found[0], found[1], found[2]


def _one(lines: list[list[Fraction | None]], known: int) -> Rows:
    """With two lines across one, the first of them as near to an axis as can be."""
    a = point(lines[known])  # type: ignore[arg-type]
    size = Fraction(root(dot(a, a)))
    if not size:
        raise ValueError("an axis of a transformation must not be zero")
    least = min(range(3), key=lambda i: (abs(a[i]), i))
    b = plus(UNIT[least], a, -a[least] / dot(a, a))
    b = scaled(b, 1 / Fraction(root(dot(b, b))))
    found = {known: a, (known + 1) % 3: b, (known + 2) % 3: scaled(cross(a, b), 1 / size)}
    return found[0], found[1], found[2]


def _cross_shaped(given: list[Fraction | None], row: int, column: int) -> Rows:
    """Of a rotation's row and column, which meet in c: the rest follows from its cofactors."""
    places = ((0, 0), (0, 1), (0, 2), (1, 0), (2, 0))
    at = [given[3 * ((row + i) % 3) + (column + j) % 3] for i, j in places]
    c, a, b, p, q = (value or Fraction(0) for value in at)
    s = a * a + b * b
    if not s:
        raise ValueError("the row and the column of a transformation must not lie along each other: give more numbers")
    block = (
        (c, a, b),
        (p, (-a * c * p - b * q) / s, (-b * c * p + a * q) / s),
        (q, (-a * c * q + b * p) / s, (-b * c * q - a * p) / s),
    )
    x, y, z = (point([block[(i - row) % 3][(j - column) % 3] for j in range(3)]) for i in range(3))
    return x, y, z


def moved(surface: Surface, change: Change) -> Surface:
    """A surface that is given in the auxiliary system, in the main one."""
    if change.rotation.motion.is_identity:
        return surface.placed(Placement(change.rotation.turn, change.origin))
    rows = change.rows
    if isinstance(surface, FlatSurface):
        normal = applied(transposed(rows), surface.normal)
        return FlatSurface(normal, surface.offset + dot(normal, change.origin))
    back = inverse(rows)
    assert back is not None
    if isinstance(surface, RoundSurface) and surface.axis is None:
        return RoundSurface(None, plus(change.origin, applied(back, surface.center)), surface.radius)
    matrix, linear, constant, shift = parts(surface)
    turned = product(transposed(rows), product(matrix, rows))
    place = plus(change.origin, applied(back, shift))
    return quadric(turned, applied(transposed(rows), linear), constant, place)


def parts(surface: RoundSurface | ConeSurface | QuadricSurface) -> tuple[Rows, Point, Fraction, Point]:
    """The matrix, the linear part and the constant of f about a point."""
    if isinstance(surface, QuadricSurface):
        f = dict(zip(TERMS, surface.coefficients, strict=True))
        xy, yz, xz = f["xy"] / 2, f["yz"] / 2, f["xz"] / 2
        matrix = ((f["xx"], xy, xz), (xy, f["yy"], yz), (xz, yz, f["zz"]))
        return matrix, (f["x"], f["y"], f["z"]), f["constant"], surface.shift
    along = -surface.square if isinstance(surface, ConeSurface) else Fraction(0)
    x, y, z = (scaled(UNIT[i], along if i == surface.axis else 1) for i in range(3))
    if isinstance(surface, ConeSurface):
        return (x, y, z), ORIGIN, Fraction(0), surface.apex
    return (x, y, z), ORIGIN, -(surface.radius**2), surface.center


def quadric(matrix: Rows, linear: Point, constant: Fraction, shift: Point = ORIGIN) -> QuadricSurface:
    """(x - shift)ᵀ matrix (x - shift) + linear·(x - shift) + constant"""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = matrix
    return QuadricSurface((xx, yy, zz, 2 * xy, 2 * yz, 2 * xz, *linear, constant), shift)


__all__ = ["Change", "change_of", "moved", "parts", "quadric"]
