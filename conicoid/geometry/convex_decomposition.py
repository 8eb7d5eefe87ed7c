"""A closed surface of flat faces as convex parts: by splitting space along the faces' own planes, in exact fractions.

The planes of faces split space into convex regions, each of which is all inside or all outside (Fuchs, Kedem and Naylor
1980; as solids Thibault and Naylor 1987). Those inside are the parts. Every plane of a part is that of a face, so parts
that touch share the plane to the bit, and walls between them are none.
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
"""Planes of which the one that splits best is taken."""
_CONVEX_GUESS_PLANES = 3
"""Planes with nothing on one side after which a region may be taken for convex, and is looked at as a whole."""
_SIGN_MARGIN = 2.0**-40
"""A sum of products of floats that is this far from zero, as a share of its terms, has their sign."""


class Facet(NamedTuple):
    """A part of a face: its plane's number, and its corners counter-clockwise as seen from outside."""

    plane: int
    corners: tuple[Point, ...]

    def outward(self, plane: FlatPlane) -> int:
        """Which side of its plane is inside at it: +1 for n·x <= d, -1 for the other."""
        normal = newell_normal(self.corners)
        return 1 if _dot(normal, plane.normal) > 0 else -1


class FlatPlane(NamedTuple):
    """normal·x <= offset, in fractions, and both as floats, about."""

    normal: Point
    offset: Any
    about: tuple[float, float, float, float]


PlaneSide = tuple[int, int]
"""A plane's number, and +1 for the side n·x <= d, -1 for the other."""


def fit_plane(corners: Sequence[Point]) -> FlatPlane | None:
    """The plane of a face by Newell's normal, outward where the corners are counter-clockwise; None for no area."""
    origin = corners[0]
    normal = newell_normal(corners)
    if not any(normal):
        return None
    scale = max(abs(c) for c in normal)
    normal = (normal[0] / scale, normal[1] / scale, normal[2] / scale)
    offset = _dot(normal, origin)
    return FlatPlane(normal, offset, (float(normal[0]), float(normal[1]), float(normal[2]), float(offset)))


def newell_normal(corners: Sequence[Point]) -> Point:
    """The normal of a polygon, twice its area long, towards where the corners are counter-clockwise; by any numbers."""
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
    """The sign of normal·point - offset, exactly; by floats where these leave no doubt."""
    a, b, c, d = plane.about
    terms = a * float(point[0]), b * float(point[1]), c * float(point[2]), -d
    total = sum(terms)
    if abs(total) > _SIGN_MARGIN * sum(map(abs, terms)):
        return 1 if total > 0 else -1
    exact = _dot(plane.normal, point) - plane.offset
    return int(exact > 0) - int(exact < 0)


class _ConvexRegion:
    """What is left to split: facets within a convex region, and the sides that bound it."""

    def __init__(self, facets: list[Facet], sides: tuple[PlaneSide, ...]) -> None:
        self.facets, self.sides = facets, sides
        self.planes = np.array([facet.plane for facet in facets])
        counts = [len(facet.corners) for facet in facets]
        self._starts = np.cumsum([0, *counts[:-1]])
        self._corners = [corner for facet in facets for corner in facet.corners]
        self._owners = np.repeat(np.arange(len(facets)), counts)
        self._about = np.array([tuple(map(float, corner)) for corner in self._corners])

    def heights(self, plane: FlatPlane, number: int) -> Ints:
        """`height` of all corners above a plane; 0 for those of its own facets."""
        terms = self._about * plane.about[:3]
        total = terms.sum(axis=1) - plane.about[3]
        doubtful = np.abs(total) <= _SIGN_MARGIN * (np.abs(terms).sum(axis=1) + abs(plane.about[3]))
        signs: Ints = np.sign(total).astype(np.int8)
        own = self.planes[self._owners] == number
        signs[own] = 0
        for k in np.flatnonzero(doubtful & ~own).tolist():
            signs[k] = side_of_plane(plane, self._corners[k])
        return signs

    def signs(self, plane: FlatPlane, number: int) -> tuple[Ints, Ints]:
        """(least, most) of the heights of each facet's corners."""
        heights = self.heights(plane, number)
        return np.minimum.reduceat(heights, self._starts), np.maximum.reduceat(heights, self._starts)

    def convex(self, planes: Sequence[FlatPlane]) -> tuple[PlaneSide, ...] | None:
        """The sides of what is inside, where that is all behind every facet; None where it is not."""
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
    """The convex parts of what facets enclose, each as the sides that bound it.

    planes: those of the faces, no two of them equal, in either sense. Raises ValueError for more than `most` parts.
    """
    found: list[tuple[PlaneSide, ...]] = []
    reach = 2 * max(float(abs(c)) for facet in facets for corner in facet.corners for c in corner)
    waiting = [_ConvexRegion(list(facets), ())]
    while waiting:
        region = waiting.pop()
        chosen, is_at_rim = _best(planes, region)
        whole = region.convex(planes) if is_at_rim else None
        if whole is not None:
            found.append(_needed_sides(planes, whole, reach))
        else:
            front, back, outward = _split(planes, chosen, region)
            sides = {1: (*region.sides, (chosen, 1)), -1: (*region.sides, (chosen, -1))}
            for facets_there, side in ((back, 1), (front, -1)):
                if facets_there:
                    waiting.append(_ConvexRegion(facets_there, sides[side]))
                elif side == outward:  # nothing more is there: all of it is inside
                    found.append(_needed_sides(planes, sides[side], reach))
        if len(found) > most:
            raise ValueError(f"faces must enclose at most {most:,} convex parts, found more")
    return found


def _best(planes: Sequence[FlatPlane], region: _ConvexRegion) -> tuple[int, bool]:
    """(the plane that splits the fewest facets, of some; has it, and another, nothing on one side?)."""
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


def _split(planes: Sequence[FlatPlane], chosen: int, region: _ConvexRegion) -> tuple[list[Facet], list[Facet], int]:
    """(facets in front of a plane, behind it, which side is inside at the plane: +1 behind, -1 in front)."""
    front: list[Facet] = []
    back: list[Facet] = []
    plane, outward = planes[chosen], 1
    least, most = region.signs(plane, chosen)
    for facet, low, high in zip(region.facets, least.tolist(), most.tolist(), strict=True):
        if facet.plane == chosen:
            outward = facet.outward(plane)
        elif high <= 0:
            back.append(facet)
        elif low >= 0:
            front.append(facet)
        else:
            signs = [side_of_plane(plane, corner) for corner in facet.corners]
            for side, there in ((1, front), (-1, back)):
                there.append(Facet(facet.plane, tuple(_clip_facet(plane, facet.corners, signs, side))))
    return front, back, outward


def _clip_facet(plane: FlatPlane, corners: Sequence[Point], signs: Sequence[int], side: int) -> Iterator[Point]:
    """The corners of the part of a polygon on one side of a plane (Sutherland and Hodgman 1974)."""
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


def _needed_sides(planes: Sequence[FlatPlane], sides: tuple[PlaneSide, ...], reach: float) -> tuple[PlaneSide, ...]:
    """Those of the sides of a bounded convex part that the others do not imply: those on which it has a face.

    By floats within a cube of half the edge `reach`, which holds all; where these do not show it, exactly.
    """
    rows = np.array([[its * c for c in planes[number].about] for number, its in sides])
    rows[:, 3] /= reach  # in units of the reach, so that nothing overflows
    with np.errstate(under="ignore"):  # what is that small is within what floats are loosened by
        return tuple(side for k, side in enumerate(sides) if _has_face(rows, k, planes, sides))


def _has_face(rows: FloatArray, k: int, planes: Sequence[FlatPlane], sides: tuple[PlaneSide, ...]) -> bool:
    """Has a part a face on its side k? rows: (n, 4), normal and offset in units of the reach of each side, n·x <= d.

    The planes that cut off most come first, so that few others do.
    """
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
        above = corners @ rows[numbers, :3].T - rows[numbers, 3] - _LOOSE  # loosened: what is empty is so for certain
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
    """The corners of what of a polygon has no height above 0."""
    following = np.roll(heights, -1)
    inside, cut = heights <= 0, (heights < 0) != (following < 0)
    share = np.where(cut, heights / np.where(cut, heights - following, 1.0), 0.0)[:, None]
    between = corners + share * (np.roll(corners, -1, axis=0) - corners)
    kept: FloatArray = np.stack([corners, between], axis=1)[np.stack([inside, cut], axis=1)]
    return kept


def _is_wide(corners: FloatArray) -> bool:
    """Has a polygon an area for certain, though its sides were loosened?"""
    spokes = corners[1:] - corners[0]
    doubled = np.linalg.norm(np.cross(spokes[:-1], spokes[1:]).sum(axis=0))
    longest = float(np.linalg.norm(corners.max(axis=0) - corners.min(axis=0)))
    return bool(doubled > 64 * _LOOSE * (longest + _LOOSE))


def _has_exact_face(planes: Sequence[FlatPlane], sides: Sequence[PlaneSide], number: int) -> bool:
    """Has a part a face on one of its planes, in fractions? sides: all of its own, those that cut off most first."""
    corners = _square(planes[number])
    for other, its in sides:
        if other != number and corners:
            signs = [its * side_of_plane(planes[other], corner) for corner in corners]
            there = [s * its for s in signs]
            corners = [] if min(signs) >= 0 else list(_clip_facet(planes[other], corners, there, -its))
    return len(corners) > 2


_ENOUGH = 8
"""Cuts, each of the plane that cuts off most, after which the others come in order."""
_LOOSE = 1e-9
"""By how much floats are loosened, as a share of the part's reach."""
_FAR = Fraction(1 << 340)


def _square(plane: FlatPlane) -> list[Point]:
    """A square on a plane, far larger than all that is in the domain."""
    normal = plane.normal
    across = max(range(3), key=lambda i: abs(normal[i]))
    first, second = (i for i in range(3) if i != across)
    found = []
    for u, v in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
        point = [Fraction(0)] * 3
        point[first], point[second] = u * _FAR, v * _FAR
        point[across] = (plane.offset - normal[first] * point[first] - normal[second] * point[second]) / normal[across]
        found.append((point[0], point[1], point[2]))
    return found
