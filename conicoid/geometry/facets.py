"""Flat faces in exact fractions: planes, facets, and winding numbers, which tell how often facets enclose a point."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from .._util.arrays import FloatArray, IndexArray, ignore_fp_errors
from ..numerics.rational import cross, dot3, minus
from .bounds.linear_program import integer_row

Point = tuple[Any, Any, Any]
SIGN_MARGIN = 2.0**-40
"""A float sum of products beyond this share of its terms has the exact sign."""


class Facet(NamedTuple):
    """A part of a face: the number of its plane, and its corners, counter-clockwise from outside."""

    plane: int
    corners: tuple[Point, ...]

    def outward(self, plane: FlatPlane) -> int:
        """Return which side of its plane is inside at the facet: +1 for n·x <= d, -1 for the other, 0 without area."""
        # Both are along one line: one entry tells
        k = next(k for k in range(3) if plane.normal[k])
        towards = newell_normal(self.corners)[k] * (1 if plane.normal[k] > 0 else -1)
        return int(towards > 0) - int(towards < 0)


class FlatPlane(NamedTuple):
    """The half-space normal·x <= offset in fractions; `about` holds the four numbers rounded to floats."""

    normal: Point
    offset: Any
    about: tuple[float, float, float, float]

    @classmethod
    def of(cls, normal: Point, offset: Any) -> FlatPlane:
        """Return the half-space of a normal and an offset in fractions."""
        return cls(normal, offset, (float(normal[0]), float(normal[1]), float(normal[2]), float(offset)))


PlaneSide = tuple[int, int]
"""A plane's number, and +1 for the side n·x <= d, -1 for the other."""


def fit_plane(corners: Sequence[Point]) -> FlatPlane | None:
    """Return the plane of a face by Newell's normal, outward for counter-clockwise corners; None without area."""
    origin = corners[0]
    normal = newell_normal(corners)
    if not any(normal):
        return None
    scale = max(abs(c) for c in normal)
    normal = (normal[0] / scale, normal[1] / scale, normal[2] / scale)
    return FlatPlane.of(normal, dot3(normal, origin))


def newell_normal(corners: Sequence[Point]) -> Point:
    """Return the normal of a polygon, twice its area long, to the side where the corners are counter-clockwise."""
    if not all(type(c) is Fraction for corner in corners for c in corner):
        return _sum_crosses(corners)
    *whole, unit = integer_row((*itertools.chain(*corners), _ONE))  # products of integers are quicker
    x, y, z = _sum_crosses([(whole[k], whole[k + 1], whole[k + 2]) for k in range(0, len(whole), 3)])
    return Fraction(x, unit * unit), Fraction(y, unit * unit), Fraction(z, unit * unit)


_ONE = Fraction(1)


def _sum_crosses(corners: Sequence[Point]) -> Point:
    """Return `newell_normal` by the spokes from the first corner."""
    spokes = [minus(corner, corners[0]) for corner in corners]
    total: Point = (0, 0, 0)
    for a, b in itertools.pairwise(spokes[1:]):
        total = (
            total[0] + a[1] * b[2] - a[2] * b[1],
            total[1] + a[2] * b[0] - a[0] * b[2],
            total[2] + a[0] * b[1] - a[1] * b[0],
        )
    return total


def side_of_plane(plane: FlatPlane, point: Point) -> int:
    """Return the exact sign of normal·point - offset, from floats if these are certain."""
    a, b, c, d = plane.about
    terms = a * float(point[0]), b * float(point[1]), c * float(point[2]), -d
    total = sum(terms)
    if abs(total) > SIGN_MARGIN * sum(map(abs, terms)):
        return 1 if total > 0 else -1
    exact = dot3(plane.normal, point) - plane.offset
    return int(exact > 0) - int(exact < 0)


class Probe(NamedTuple):
    """A point on a plane, in the middle of three corners by `_SHARES`, and the side of the plane that it looks at."""

    corners: tuple[Point, Point, Point]
    side: PlaneSide


class WindingNumbers:
    """The winding numbers of facets about points: how often the facets enclose them.

    A ray from the point crosses a facet as often as the triangles about the first corner of that facet, each with its
    sign. Seen along the ray, a triangle is crossed if the point is on the same side of its three edges. Floats decide
    beyond an error bound; in doubt, another direction follows, and fractions at last.
    """

    def __init__(self, planes: Sequence[FlatPlane], facets: Sequence[Facet]) -> None:
        self.planes = planes
        self.triangles = [
            (facet.plane, (facet.corners[0], b, c))
            for facet in facets
            for b, c in itertools.pairwise(facet.corners[1:])
        ]
        self._owners = np.array([plane for plane, _ in self.triangles])
        self._origin, self._size = facets[0].corners[0], 1.0
        about = self._floats(corners for _, corners in self.triangles)
        self._size = float(np.abs(about).max())
        self._about = about / self._size

    def _floats(self, triangles: Iterable[Sequence[Point]]) -> FloatArray:
        """Return the corners of triangles, (n, 3, 3), from the origin and in units of the size."""
        rows = [[float(c) for corner in corners for c in minus(corner, self._origin)] for corners in triangles]
        return np.array(rows).reshape(-1, 3, 3) / self._size

    @ignore_fp_errors
    def at(self, probes: Sequence[Probe]) -> list[int]:
        """Return the winding number on the side of each probe."""
        found: dict[int, int] = {}
        points = self._floats(probe.corners for probe in probes)
        points = np.einsum("c,pcx->px", np.array(_SHARES) / sum(_SHARES), points)
        is_near = (np.abs(points) < 2).all(axis=1)  # others, which could overflow, are for fractions
        points[~is_near] = 0.0
        normals = np.array([self.planes[probe.side[0]].about[:3] for probe in probes])
        senses = np.array([-probe.side[1] for probe in probes])
        own = np.array([probe.side[0] for probe in probes])
        left = np.arange(len(probes))
        for turn in _TURNS:
            if len(left):
                slopes = normals[left] @ turn[2]
                ways = np.sign(slopes) * senses[left]
                windings, is_sure = self._crossings(points[left] @ turn.T, ways, own[left], turn)
                is_sure &= (np.abs(slopes) > SIGN_MARGIN) & is_near[left]
                found.update(zip(left[is_sure].tolist(), windings[is_sure].tolist(), strict=True))
                left = left[~is_sure]
        return [found[k] if k in found else self._exact(probe) for k, probe in enumerate(probes)]

    def _crossings(
        self, points: FloatArray, ways: FloatArray, own: IndexArray, turn: FloatArray
    ) -> tuple[FloatArray, npt.NDArray[np.bool_]]:
        """Return (the winding number, True if it is sure) for rays up (way +1) or down (-1) from turned points.

        Triangles in a ray's own plane do not count.
        """
        corners = self._about @ turn.T
        edges = [_edge_rows(corners[:, k - 2, :2], corners[:, k - 1, :2]) for k in range(3)]
        heights = corners[:, :, 2]
        windings, is_sure = np.zeros(len(points)), np.ones(len(points), bool)
        flat = np.column_stack([points[:, :2], np.ones(len(points))])
        step = max(1, _MOST_PAIRS // len(corners))
        for begin in range(0, len(points), step):
            turns = [flat[begin : begin + step] @ rows for rows in edges]
            least, most = np.minimum.reduce(turns), np.maximum.reduce(turns)
            k, of = np.nonzero((least >= -_LOOSE_CROSSING) | (most <= _LOOSE_CROSSING))
            is_other = self._owners[of] != own[begin + k]
            k, of = k[is_other], of[is_other]
            sense = np.sign(turns[0][k, of])
            above = sum(turns[i][k, of] * (heights[of, i] - points[begin + k, 2]) for i in range(3))
            way = ways[begin + k]
            is_clear = (least[k, of] > _LOOSE_CROSSING) | (most[k, of] < -_LOOSE_CROSSING)
            is_clear &= np.abs(above) > 32 * _LOOSE_CROSSING
            is_sure[begin + k[~is_clear]] = False
            np.add.at(windings, begin + k, np.where(above * sense * way > 0, sense * way, 0.0))
        return windings, is_sure

    def _exact(self, probe: Probe) -> int:
        """Return the winding number in fractions. A direction along a plane or through an edge is replaced."""
        plane, side = probe.side
        shares = [Fraction(share, sum(_SHARES)) for share in _SHARES]
        x, y, z = (
            sum(s * c for s, c in zip(shares, places, strict=True)) for places in zip(*probe.corners, strict=True)
        )
        triangles = [(owner, [minus(corner, (x, y, z)) for corner in corners]) for owner, corners in self.triangles]
        volumes = [(owner, triangle, _determinant(*triangle)) for owner, triangle in triangles]
        for k in itertools.count(1):
            slope = dot3(self.planes[plane].normal, (Fraction(1), Fraction(k, 7), Fraction(k * k, 11)))
            sense = -1 if slope * side > 0 else 1
            along = Fraction(sense), Fraction(sense * k, 7), Fraction(sense * k * k, 11)
            winding = 0
            for owner, (a, b, c), volume in volumes:
                # A ray leaves at once the plane of a triangle that contains its start
                if not volume:
                    if not dot3(self.planes[owner].normal, along):
                        break
                    continue
                turns = [_determinant(along, p, q) for p, q in ((a, b), (b, c), (c, a))]
                if 0 in turns:
                    break
                if all((turn > 0) == (volume > 0) for turn in turns):
                    winding += 1 if volume > 0 else -1
            else:
                return winding
        raise AssertionError


def _edge_rows(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return (3, n) numbers whose product with (x, y, 1) is above 0 to the left of edges from a to b."""
    (x, y), (u, v) = a.T, (b - a).T
    return np.array([-v, u, v * x - u * y])


def _turn(a: int, b: int, c: int, d: int) -> FloatArray:
    """Return the rotation of a quaternion."""
    rows = [
        [a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)],
        [2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b)],
        [2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d],
    ]
    return np.array(rows) / (a * a + b * b + c * c + d * d)


_SHARES = 3, 4, 5
"""The weights of three corners: no middle of an edge or a face, where other corners may be."""
_TURNS = [_turn(7, 2, 3, 5), _turn(3, -5, 1, 4), _turn(2, 6, -1, 3)]
"""Rays run along z after these rotations."""
_LOOSE_CROSSING = 2.0**-42
"""Sums of three products of coordinates up to 2 are surely less wrong."""
PROBES = 4096
_MOST_PAIRS = 1 << 17
"""So many winding numbers, or pairs of a ray and a triangle, are computed together."""


def _determinant(a: Point, b: Point, c: Point) -> Any:
    return dot3(a, cross(b, c))
