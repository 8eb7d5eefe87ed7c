"""A polygon by even-odd, and a triangle by areas, as the ray tracing notes do it where the plane is met."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from . import sources
from .blocks import Block
from .blocks import Line as Words
from .line import Line
from .numbers import as_float, rounded, vector
from .polynomial import Polynomial
from .steps import Board

_MOST = 24
"""Edges of a polygon that are told one by one."""


def outline_board(corners: Sequence[Sequence[float]], plane: Polynomial, line: Line) -> Board:
    """Drop a coordinate, move the point to the origin, count the edges that meet the positive u axis."""
    places = line.roots(plane)
    if not places:
        return Board((Words("the ray is parallel to the plane", sources.PLANE, 2),), {})
    point, normal = line.at(places[0]), [2 * half for half in plane.ten[6:9]]
    dropped = max(range(3), key=lambda k: abs(normal[k]))
    kept = [k for k in range(3) if k != dropped]
    shifted = [tuple(Fraction(corner[k]) - point[k] for k in kept) for corner in corners]
    words: list[Block] = [
        Words(f"the plane is met at t = {rounded(places[0])}, at {vector(point)}", sources.POLYGON, 2),
        Words(f"its normal {vector(normal)} is largest along {'xyz'[dropped]}: that coordinate is dropped", "", 2),
        Words(f"moved to the point: {', '.join(map(vector, shifted[:_MOST]))}{_more(shifted)}", "", 2),
    ]
    numbers, count = {}, 0
    for k, ((ua, va), (ub, vb)) in enumerate(zip(shifted, [*shifted[1:], shifted[0]], strict=True)):
        if (va < 0) == (vb < 0):
            continue
        at = ua - va * (ub - ua) / (vb - va)
        count += at > 0
        numbers[f"edge {k + 1}"] = as_float(at)
        if k < _MOST:
            side = "> 0: counted" if at > 0 else "≤ 0: not counted"
            words.append(Words(f"edge {k + 1} crosses the u axis at u = {rounded(at)} {side}", "", 2))
    numbers["crossings"] = count
    odd = "odd: inside" if count % 2 else "even: outside"
    words.append(Words(f"{count} crossing{'s' if count != 1 else ''}, {odd}", "", 2))
    if len(corners) == 3:
        words += _areas(shifted, numbers)
    return Board(tuple(words), numbers)


def _more(values: Sequence[object]) -> str:
    return " ..." if len(values) > _MOST else ""


def _areas(corners: Sequence[tuple[Fraction, ...]], numbers: dict[str, float]) -> list[Block]:
    """Barycentric coordinates of the origin, as ratios of areas."""
    a, b, c = corners

    def area(p: tuple[Fraction, ...], q: tuple[Fraction, ...], r: tuple[Fraction, ...]) -> Fraction:
        return ((q[0] - p[0]) * (r[1] - p[1]) - (r[0] - p[0]) * (q[1] - p[1])) / 2

    whole, zero = area(a, b, c), (Fraction(0), Fraction(0))
    if not whole:
        return []
    shares = [area(zero, b, c) / whole, area(a, zero, c) / whole, area(a, b, zero) / whole]
    numbers |= {name: as_float(share) for name, share in zip(("alpha", "beta", "gamma"), shares, strict=True)}
    inside = "inside" if min(shares) > 0 else ("on an edge" if min(shares) == 0 else "outside")
    told = ", ".join(f"{name} = {rounded(share)}" for name, share in zip("αβγ", shares, strict=True))
    return [Words(f"as a triangle: {told}: {inside}", sources.AREAS, 2)]
