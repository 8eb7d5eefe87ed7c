"""Convex decomposition of the solid inside flat faces, by the planes of the faces, in exact fractions.

The planes split space into convex regions, each completely inside or outside (binary space partition: Fuchs, Kedem and
Naylor 1980; for solids Thibault and Naylor 1987). The regions inside are the parts. Every plane of a part is that of a
face, so parts that touch share the plane to the bit, and there is no wall between them.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from .._util.arrays import FloatArray

Point = tuple[Any, Any, Any]
Ints = npt.NDArray[np.int8]
_CANDIDATE_PLANES = 12
"""The number of planes that are compared to find the best split."""
_CONVEX_GUESS_PLANES = 3
"""After so many planes with nothing on one side, the whole region is tested for convexity."""
_SIGN_MARGIN = 2.0**-40
"""A float sum of products beyond this share of its terms has the exact sign."""


class Facet(NamedTuple):
    """A part of a face: the number of its plane, and its corners, counter-clockwise from outside."""

    plane: int
    corners: tuple[Point, ...]

    def outward(self, plane: FlatPlane) -> int:
        """Return which side of its plane is inside at the facet: +1 for n·x <= d, -1 for the other."""
        normal = newell_normal(self.corners)
        return 1 if _dot(normal, plane.normal) > 0 else -1


class FlatPlane(NamedTuple):
    """The half-space normal·x <= offset in fractions; `about` holds the four numbers rounded to floats."""

    normal: Point
    offset: Any
    about: tuple[float, float, float, float]


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
    offset = _dot(normal, origin)
    return FlatPlane(normal, offset, (float(normal[0]), float(normal[1]), float(normal[2]), float(offset)))


def newell_normal(corners: Sequence[Point]) -> Point:
    """Return the normal of a polygon, twice its area long, to the side where the corners are counter-clockwise."""
    spokes = [_minus(corner, corners[0]) for corner in corners]
    total: Point = (Fraction(0),) * 3
    for a, b in itertools.pairwise(spokes):
        total = (
            total[0] + a[1] * b[2] - a[2] * b[1],
            total[1] + a[2] * b[0] - a[0] * b[2],
            total[2] + a[0] * b[1] - a[1] * b[0],
        )
    return total


def _minus(a: Point, b: Point) -> Point:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def _dot(a: Point, b: Point) -> Any:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def side_of_plane(plane: FlatPlane, point: Point) -> int:
    """Return the exact sign of normal·point - offset, from floats if these are certain."""
    a, b, c, d = plane.about
    terms = a * float(point[0]), b * float(point[1]), c * float(point[2]), -d
    total = sum(terms)
    if abs(total) > _SIGN_MARGIN * sum(map(abs, terms)):
        return 1 if total > 0 else -1
    exact = _dot(plane.normal, point) - plane.offset
    return int(exact > 0) - int(exact < 0)


class _PlaneSigns:
    """The exact signs of heights of corners above planes, each computed once.

    Corners are known by identity: faces that meet share them, so that few of the heights that are zero, about which
    floats say nothing, take fractions.
    """

    def __init__(self, planes: Sequence[FlatPlane], facets: Sequence[Facet]) -> None:
        self.planes = planes
        self._known = {(facet.plane, id(corner)): 0 for facet in facets for corner in facet.corners}
        self._held: list[Any] = [facets]  # keeps ids unique

    def of(self, number: int, corner: Point) -> int:
        """Return the sign of a corner's height above a plane."""
        key = number, id(corner)
        found = self._known.get(key)
        if found is None:
            self._held.append(corner)
            found = self._known[key] = side_of_plane(self.planes[number], corner)
        return found


class _ConvexRegion:
    """A convex region that may need a split: the facets in it, and the sides that bound it."""

    def __init__(self, facets: list[Facet], sides: tuple[PlaneSide, ...], known: _PlaneSigns) -> None:
        self.facets, self.sides, self.known = facets, sides, known
        self.planes = np.array([facet.plane for facet in facets])
        counts = [len(facet.corners) for facet in facets]
        self._starts = np.cumsum([0, *counts[:-1]])
        self._corners = [corner for facet in facets for corner in facet.corners]
        self._owners = np.repeat(np.arange(len(facets)), counts)
        self._about = np.array([tuple(map(float, corner)) for corner in self._corners])

    def heights(self, plane: FlatPlane, number: int) -> Ints:
        """Return the sign of the height of every corner above a plane, 0 for corners of the plane's own facets."""
        terms = self._about * plane.about[:3]
        total = terms.sum(axis=1) - plane.about[3]
        doubtful = np.abs(total) <= _SIGN_MARGIN * (np.abs(terms).sum(axis=1) + abs(plane.about[3]))
        signs: Ints = np.sign(total).astype(np.int8)
        own = self.planes[self._owners] == number
        signs[own] = 0
        for k in np.flatnonzero(doubtful & ~own).tolist():
            signs[k] = self.known.of(number, self._corners[k])
        return signs

    def signs(self, plane: FlatPlane, number: int) -> tuple[Ints, Ints]:
        """Return (least, greatest) of `heights` for each facet."""
        heights = self.heights(plane, number)
        return np.minimum.reduceat(heights, self._starts), np.maximum.reduceat(heights, self._starts)

    def convex(self, planes: Sequence[FlatPlane]) -> tuple[PlaneSide, ...] | None:
        """Return the sides of the inside if it is convex, behind every facet; else None."""
        senses: dict[int, int] = {}
        for facet in self.facets:
            outward = facet.outward(planes[facet.plane])
            if senses.setdefault(facet.plane, outward) != outward:
                return None
        for number, outward in senses.items():
            if (self.heights(planes[number], number) * outward > 0).any():
                return None
        return (*self.sides, *senses.items())


def convex_parts(planes: Sequence[FlatPlane], facets: Sequence[Facet], most: int) -> list[tuple[PlaneSide, ...]]:
    """Return the convex parts of the solid inside facets, each as the sides that bound it.

    Parameters
    ----------
    planes : sequence of FlatPlane
        The planes of the faces, no two equal, in either sense.
    facets : sequence of Facet
        The faces.
    most : int
        The largest number of parts.

    Raises
    ------
    ValueError
        For more parts.
    """
    parts: list[tuple[PlaneSide, ...]] = []
    reach = 2 * max(float(abs(c)) for facet in facets for corner in facet.corners for c in corner)
    known = _PlaneSigns(planes, facets)
    pending = [_ConvexRegion(list(facets), (), known)]
    while pending:
        region = pending.pop()
        plane, is_at_rim = _best(planes, region)
        whole = region.convex(planes) if is_at_rim else None
        if whole is not None:
            parts.append(_needed_sides(planes, whole, reach, len(region.sides)))
        else:
            front, back, own = _split(planes, plane, region)
            outwards = {facet.outward(planes[plane]) for facet in own}
            if len(outwards) == 2 and not (front and back):
                # The side without facets is inside or outside as a whole, so the facets in the plane have one sense
                # where they do not cancel. Where all of them cancel they bound nothing.
                area = sum(_dot(newell_normal(facet.corners), planes[plane].normal) for facet in own)
                if not area and (front or back):
                    pending.append(_ConvexRegion(front + back, region.sides, known))
                    continue
                if not area:  # nothing here says whether the region is inside
                    if _is_inside(facets, own[0]):
                        parts.append(_needed_sides(planes, region.sides, reach, len(region.sides)))
                    continue
                outwards = {1} if area > 0 else {-1} if area < 0 else outwards
            sides = {1: (*region.sides, (plane, 1)), -1: (*region.sides, (plane, -1))}
            for facets_there, side in ((back, 1), (front, -1)):
                if facets_there:
                    pending.append(_ConvexRegion(facets_there, sides[side], known))
                elif side in outwards:  # no facet is left on this side: all of it is inside
                    parts.append(_needed_sides(planes, sides[side], reach, len(sides[side])))
        if len(parts) > most:
            raise ValueError(f"faces must enclose at most {most:,} convex parts, found more")
    return parts


def _is_inside(facets: Sequence[Facet], at: Facet) -> bool:
    """Return True if the space about a facet that others cancel is inside, by the winding number.

    A ray begins in the middle of the facet's corners. It crosses another facet as often as the triangles about the
    first corner of that facet, each with its sign. A direction that meets an edge is replaced by another.
    """
    count = len(at.corners)
    x, y, z = (sum(corner[i] for corner in at.corners) / Fraction(count) for i in range(3))
    spokes = [[_minus(corner, (x, y, z)) for corner in facet.corners] for facet in facets]
    triangles = [(first, b, c) for first, *others in spokes for b, c in itertools.pairwise(others)]
    # Facets in one plane with the point are left at once, and neither cross the ray nor share an edge with it
    volumes = [(triangle, volume) for triangle in triangles if (volume := _determinant(*triangle))]
    for k in itertools.count(1):
        along = Fraction(1), Fraction(k, 7), Fraction(k * k, 11)
        winding = 0
        for (a, b, c), volume in volumes:
            shares = [_determinant(along, p, q) for p, q in ((a, b), (b, c), (c, a))]
            if 0 in shares:
                break
            if all((share > 0) == (volume > 0) for share in shares):
                winding += 1 if volume > 0 else -1
        else:
            return winding > 0
    raise AssertionError


def _determinant(a: Point, b: Point, c: Point) -> Any:
    return _dot(a, (b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]))


def _best(planes: Sequence[FlatPlane], region: _ConvexRegion) -> tuple[int, bool]:
    """Return (the plane to split a region by, True if the region may be convex).

    Some planes are compared. One with nothing on one side comes first, as it cuts no facet; otherwise the plane that
    cuts the fewest. The region may be convex if all compared planes, or `_CONVEX_GUESS_PLANES`, have an empty side.
    """
    step = max(1, len(region.facets) // _CANDIDATE_PLANES)
    best, least, rims = int(region.planes[0]), None, []
    for number in dict.fromkeys(region.planes[::step].tolist()):
        others = region.planes != number
        low, high = (each[others] for each in region.signs(planes[number], number))
        split = int(((low < 0) & (high > 0)).sum())
        front, back = int((high > 0).sum()), int((low < 0).sum())
        if not (front and back):
            rims.append(number)
            if len(rims) == _CONVEX_GUESS_PLANES:
                return rims[0], True
            continue
        cost = 8 * split + abs(len(low) - 2 * front) + 1
        if least is None or cost < least:
            best, least = number, cost
        if rims:
            break
    return (rims[0], least is None) if rims else (best, False)


def _split(
    planes: Sequence[FlatPlane], index: int, region: _ConvexRegion
) -> tuple[list[Facet], list[Facet], list[Facet]]:
    """Return (facets in front of a plane, facets behind it, facets in it)."""
    front: list[Facet] = []
    back: list[Facet] = []
    own: list[Facet] = []
    plane = planes[index]
    least, most = region.signs(plane, index)
    for facet, low, high in zip(region.facets, least.tolist(), most.tolist(), strict=True):
        if facet.plane == index:
            own.append(facet)
        elif high <= 0:
            back.append(facet)
        elif low >= 0:
            front.append(facet)
        else:
            signs = [region.known.of(index, corner) for corner in facet.corners]
            for side, there in ((1, front), (-1, back)):
                there.append(Facet(facet.plane, tuple(_clip_facet(plane, facet.corners, signs, side))))
    return front, back, own


def _clip_facet(plane: FlatPlane, corners: Sequence[Point], signs: Sequence[int], side: int) -> Iterator[Point]:
    """Yield the corners of the part of a polygon on one side of a plane (Sutherland and Hodgman 1974)."""
    for k, (corner, sign) in enumerate(zip(corners, signs, strict=True)):
        if sign * side >= 0:
            yield corner
        following, other = corners[(k + 1) % len(corners)], signs[(k + 1) % len(corners)]
        if sign * other < 0:
            a, b = _dot(plane.normal, corner) - plane.offset, _dot(plane.normal, following) - plane.offset
            t = a / (a - b)
            yield (
                corner[0] + t * (following[0] - corner[0]),
                corner[1] + t * (following[1] - corner[1]),
                corner[2] + t * (following[2] - corner[2]),
            )


def _needed_sides(
    planes: Sequence[FlatPlane], sides: tuple[PlaneSide, ...], reach: float, doubtful: int
) -> tuple[PlaneSide, ...]:
    """Return the sides on which a bounded convex part has a face; the others imply the rest.

    The first `doubtful` sides come from splits; on each of the others lies a facet. Floats decide in a cube of half the
    edge `reach`, which contains everything; fractions decide where floats cannot.
    """
    rows = np.array([[its * c for c in planes[number].about] for number, its in sides])
    rows[:, 3] /= reach  # in units of the reach, so that nothing overflows
    with np.errstate(under="ignore"):  # numbers so small are far below `_LOOSE`
        return tuple(side for k, side in enumerate(sides) if k >= doubtful or _has_face(rows, k, planes, sides))


def _has_face(rows: FloatArray, k: int, planes: Sequence[FlatPlane], sides: tuple[PlaneSide, ...]) -> bool:
    """Return True if a part has a face on its side k.

    `rows` (n, 4) are the normal and offset of each side n·x <= d, in units of the reach. The planes that cut off most
    come first, so that few others cut at all.
    """
    # A large square on the plane of side k, from which the other sides cut the face
    normal = rows[k, :3]
    across = int(np.abs(normal).argmax())
    first, second = (i for i in range(3) if i != across)
    corners = np.zeros((4, 3))
    corners[:, first], corners[:, second] = [(-1.0, 1.0, 1.0, -1.0), (-1.0, -1.0, 1.0, 1.0)]
    corners[:, across] = (rows[k, 3] - corners @ normal) / normal[across]
    left = np.ones(len(rows), bool)
    cuts: list[int] = []
    left[k] = False
    while left.any():
        numbers = np.flatnonzero(left)[: None if len(cuts) < _ENOUGH else 1]
        above = corners @ rows[numbers, :3].T - rows[numbers, 3] - _LOOSE  # loosened: an empty face is surely empty
        most = above.max(axis=0)
        left[numbers[most <= 0]] = False
        chosen = int(most.argmax())
        if most[chosen] <= 0:
            continue
        left[numbers[chosen]] = False
        cuts.append(int(numbers[chosen]))
        corners = _cut(corners, above[:, chosen])
        if len(corners) < 3:
            return False
        if len(cuts) == _ENOUGH and not _is_wide(corners):
            break
    if _is_wide(corners):
        return True
    others = [j for j in range(len(sides)) if j not in cuts]
    return _has_exact_face(planes, [sides[j] for j in (*cuts, *others)], sides[k][0])


def _cut(corners: FloatArray, heights: FloatArray) -> FloatArray:
    """Return the corners of the part of a polygon with heights <= 0."""
    following = np.concatenate([heights[1:], heights[:1]])
    inside, cut = heights <= 0, (heights < 0) != (following < 0)
    share = np.where(cut, heights / np.where(cut, heights - following, 1.0), 0.0)[:, None]
    points, kept = np.empty((2 * len(corners), 3)), np.empty(2 * len(corners), bool)
    points[::2], kept[::2], kept[1::2] = corners, inside, cut
    points[1::2] = corners + share * (np.concatenate([corners[1:], corners[:1]]) - corners)
    clipped: FloatArray = points[kept]
    return clipped


def _is_wide(corners: FloatArray) -> bool:
    """Return True if a polygon surely has an area, although its sides were loosened."""
    spokes = corners[1:] - corners[0]
    doubled = np.linalg.norm(np.cross(spokes[:-1], spokes[1:]).sum(axis=0))
    longest = float(np.linalg.norm(corners.max(axis=0) - corners.min(axis=0)))
    return bool(doubled > 64 * _LOOSE * (longest + _LOOSE))


def _has_exact_face(planes: Sequence[FlatPlane], sides: Sequence[PlaneSide], number: int) -> bool:
    """Return True if a part has a face on plane `number`, in fractions.

    `sides` are all sides of the part, those that cut off most first.
    """
    corners = _square(planes[number])
    for other, its in sides:
        if other != number and corners:
            signs = [its * side_of_plane(planes[other], corner) for corner in corners]
            there = [s * its for s in signs]
            corners = [] if min(signs) >= 0 else list(_clip_facet(planes[other], corners, there, -its))
    return len(corners) > 2


_ENOUGH = 8
"""After so many cuts by the plane that cuts off most, the other planes come in order."""
_LOOSE = 1e-9
"""The tolerance of float tests, as a share of the part's reach."""
_FAR = Fraction(1 << 340)
"""Far more than any coordinate of the domain."""


def _square(plane: FlatPlane) -> list[Point]:
    """Return the corners of a square on a plane, far larger than anything in the domain."""
    normal = plane.normal
    across = max(range(3), key=lambda i: abs(normal[i]))
    first, second = (i for i in range(3) if i != across)
    corners = []
    for u, v in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
        point = [Fraction(0)] * 3
        point[first], point[second] = u * _FAR, v * _FAR
        point[across] = (plane.offset - normal[first] * point[first] - normal[second] * point[second]) / normal[across]
        corners.append((point[0], point[1], point[2]))
    return corners
