"""Faces as triangles and quadrangles, which is what GDML has."""

from __future__ import annotations

import math
from fractions import Fraction
from functools import lru_cache

from ....shapes.polyhedron import Polyhedron
from ....shapes.vector import VectorLike
from ...gdml.convex import inside_of, planes_of_convex
from ...gdml.evaluator import evaluate
from ...gdml.placement import ORIGIN
from ..exported import Unsayable
from ..numbers import expression
from ..pieces import Corner, Faces

MOST = 20_000


@lru_cache(256)
def is_read_alike(piece: Faces) -> bool:
    """Do readers get the planes that it had, or the faces, if it had none?"""
    corners = [_read(corner) for corner in piece.corners]
    planes = planes_of_convex(corners, piece.faces)
    if planes is None or piece.planes is None:
        return planes is None and piece.planes is None and all(len(face) <= 4 for face in piece.faces)
    found = inside_of(planes)(ORIGIN)
    assert isinstance(found, Polyhedron)
    known = {_scaled(*plane) for plane in piece.planes}
    return all(_scaled(*plane) in known for plane in zip(found.normals, found.offsets, strict=True))


def _read(corner: Corner) -> Corner:
    x, y, z = (evaluate(expression(value), {}) for value in corner)
    return x, y, z


def _scaled(normal: VectorLike, offset: float) -> tuple[float, ...]:
    """By a power of two, which no rounding depends on."""
    x, y, z = normal
    _, exponent = math.frexp(max(abs(x), abs(y), abs(z)))
    return tuple(math.ldexp(value, -exponent) for value in (x, y, z, offset))


def rows_of(piece: Faces) -> list[list[Corner]]:
    """Each face, those of more than four corners cut into triangles."""
    rows: list[list[Corner]] = []
    for face in piece.faces:
        corners = [piece.corners[k] for k in face]
        rows += [corners] if len(corners) <= 4 else _triangles(corners)
    if len(rows) > MOST:
        raise Unsayable(f"it has {len(rows):,} faces, more than {MOST:,}")
    return rows


def _triangles(corners: list[Corner]) -> list[list[Corner]]:
    """A polygon without its ears, one after the other (Meisters 1975), by its projection where that is widest."""
    normal = _normal(corners)
    across = max(range(3), key=lambda i: abs(normal[i]))
    u, v = ((across + 1) % 3, (across + 2) % 3) if normal[across] > 0 else ((across + 2) % 3, (across + 1) % 3)
    left, found = list(corners), []
    while len(left) > 3:
        for k in range(len(left)):
            a, b, c = left[k - 1], left[k], left[(k + 1) % len(left)]
            if _side(a, b, c, u, v) > 0 and not any(_within(p, a, b, c, u, v) for p in left if p not in (a, b, c)):
                found.append([a, b, c])
                del left[k]
                break
        else:
            raise Unsayable("a face of it is no simple polygon")
    return [*found, left]


def _normal(corners: list[Corner]) -> Corner:
    """By Newell."""
    total = [Fraction(0)] * 3
    for a, b in zip(corners, [*corners[1:], corners[0]], strict=True):
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            total[i] += (a[j] - b[j]) * (a[k] + b[k])
    return total[0], total[1], total[2]


def _side(a: Corner, b: Corner, c: Corner, u: int, v: int) -> Fraction:
    return (b[u] - a[u]) * (c[v] - a[v]) - (b[v] - a[v]) * (c[u] - a[u])


def _within(p: Corner, a: Corner, b: Corner, c: Corner, u: int, v: int) -> bool:
    return _side(a, b, p, u, v) >= 0 and _side(b, c, p, u, v) >= 0 and _side(c, a, p, u, v) >= 0
