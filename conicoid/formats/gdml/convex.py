"""Convex solids of flat faces from their corners, and what encloses them in fractions."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Sequence
from fractions import Fraction
from functools import partial
from math import lcm

from ...shapes.base import Solid
from ...shapes.polyhedron import Polyhedron
from .placement import Point
from .reading import LeftOut
from .templates import Make

_FLAT = Fraction(1, 100_000)
"""How far a corner may be off the plane of its face, as a share of the size."""
Plane = tuple[Point, Fraction]


class Twisted(LeftOut):
    """A face is not flat."""


def cross(a: Point, b: Point) -> Point:
    """The vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def dot(a: Point, b: Point) -> Fraction:
    """The scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def minus(a: Point, b: Point) -> Point:
    """The difference."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def mean(points: Sequence[Point]) -> Point:
    """The mean of points."""
    x, y, z = (sum((point[i] for point in points), Fraction(0)) / len(points) for i in range(3))
    return x, y, z


def plane_through(points: Sequence[Point], inside: Point) -> Plane | None:
    """The plane of a face, outward; None where its corners enclose nothing. Raises LeftOut where it is not flat."""
    kept = [point for k, point in enumerate(points) if point != points[k - 1]]
    if len(kept) < 3:
        return None
    spokes = [minus(point, kept[0]) for point in kept[1:]]
    terms = [cross(a, b) for a, b in itertools.pairwise(spokes)]
    normal = tuple(sum((term[i] for term in terms), Fraction(0)) for i in range(3))
    size = max(abs(c) for spoke in spokes for c in spoke)
    largest = max(map(abs, normal))
    if largest <= size * size / 10**12:
        return None
    x, y, z = (c / largest for c in normal)
    outward: Point = (x, y, z)
    center = mean(kept)
    if dot(outward, minus(center, inside)) < 0:
        outward = (-x, -y, -z)
    if max(abs(dot(outward, minus(point, center))) for point in kept) > _FLAT * size:
        raise Twisted("a face of it is not flat")
    return _whole(outward), dot(_whole(outward), center)


def _whole(normal: Point) -> Point:
    """The same direction by whole numbers where these are short, so that it needs no rounding."""
    factor = lcm(*(c.denominator for c in normal))
    if factor.bit_length() > 50:
        return normal
    x, y, z = (c * factor for c in normal)
    return x, y, z


def convex(corners: Sequence[Point], faces: Sequence[Sequence[int]]) -> Make:
    """Inside the planes of faces, given by numbers of corners in any sense."""
    inside = mean(list(dict.fromkeys(corners)))
    found = [plane_through([corners[k] for k in face], inside) for face in faces]
    planes = list(dict.fromkeys(plane for plane in found if plane is not None))
    size = max(abs(c) for corner in corners for c in minus(corner, inside))
    for normal, offset in planes:
        if dot(normal, inside) >= offset:
            raise ValueError("it must enclose a volume")
        most = max(dot(normal, corner) for corner in corners)
        if most - offset > 2 * _FLAT * size * max(map(abs, normal)):
            raise LeftOut("it is not convex")
    if len(planes) < 4:
        raise ValueError("it must enclose a volume")
    return inside_of(planes)


def planes_of_convex(corners: Sequence[Point], faces: Sequence[Sequence[int]]) -> list[Plane] | None:
    """The planes of a closed surface that is convex, exactly, and whose faces are flat; None for any other."""
    edges = Counter((face[k - 1], face[k]) for face in faces for k in range(len(face)))
    if len(faces) < 4 or any(count != 1 or edges[b, a] != 1 for (a, b), count in edges.items()):
        return None
    inside = mean(corners)
    planes: dict[Plane, None] = {}
    for face in faces:
        try:
            plane = plane_through([corners[k] for k in face], inside)
        except LeftOut:
            return None
        if plane is None or any(dot(plane[0], corners[k]) != plane[1] for k in face):
            return None
        planes[plane] = None
    for normal, offset in planes:
        if dot(normal, inside) >= offset or any(dot(normal, corner) > offset for corner in corners):
            return None
    return list(planes)


def inside_of(planes: Sequence[Plane]) -> Make:
    """What is inside all of some planes."""
    normals = tuple((float(a), float(b), float(c)) for (a, b, c), _ in planes)
    exact = [(Fraction(a), Fraction(b), Fraction(c)) for a, b, c in normals]
    return partial(_polyhedron, normals, [(normal, offset) for normal, (_, offset) in zip(exact, planes, strict=True)])


def _polyhedron(normals: tuple[tuple[float, float, float], ...], planes: Sequence[Plane], shift: Point) -> Solid:
    return Polyhedron(normals, tuple(float(offset + dot(normal, shift)) for normal, offset in planes))


SIX_FACES = ((3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
"""Of eight corners, four around the bottom and four around the top."""
