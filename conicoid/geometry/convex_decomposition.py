"""Convex decomposition of the solid inside flat faces, by the planes of the faces, in exact fractions.

The planes split space into convex regions, each completely inside or outside (binary space partition: Fuchs, Kedem and
Naylor 1980; for solids Thibault and Naylor 1987). The regions about which the faces wind more than 0 times are the
parts. Every plane of a part is that of a face, so parts that touch share the plane to the bit, and there is no wall
between them.
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from .._util.arrays import FloatArray
from .._util.records import dataclass
from ..numerics.rational import cross, dot3, minus
from .facets import (
    PROBES,
    SIGN_MARGIN,
    Facet,
    FlatPlane,
    PlaneSide,
    Point,
    Probe,
    WindingNumbers,
    newell_normal,
    side_of_plane,
)

Ints = npt.NDArray[np.int8]
_CANDIDATE_PLANES = 12
"""The number of planes that are compared to find the best split."""
_CONVEX_GUESS_PLANES = 3
"""After so many planes with nothing on one side, the whole region is tested for convexity."""


_PRUNING_STEP = 16
"""Whenever the sides of a region are a multiple of this, those without a face are dropped."""


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

    def __init__(self, facets: list[Facet], node: int, sides: tuple[PlaneSide, ...], known: _PlaneSigns) -> None:
        self.facets, self.node, self.sides, self.known = facets, node, sides, known
        self.overlaps = False
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
        doubtful = np.abs(total) <= SIGN_MARGIN * (np.abs(terms).sum(axis=1) + abs(plane.about[3]))
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
            if not outward or senses.setdefault(facet.plane, outward) != outward:
                return None
        for number, outward in senses.items():
            if (self.heights(planes[number], number) * outward > 0).any():
                return None
        return (*self.sides, *senses.items())


@dataclass
class _Node:
    """A convex region of the partition: a leaf, or the union of the nodes that name it as their parent."""

    parent: int
    sides: tuple[PlaneSide, ...]
    doubtful: int
    """So many of the first sides may have no face."""
    winding: int | None = None
    is_full: bool = True
    overlaps: bool = False


class ConvexParts(NamedTuple):
    """The convex parts of a solid, each as the sides that bound it, and whether pieces of the solid overlap."""

    parts: list[tuple[PlaneSide, ...]]
    overlap: bool


def convex_parts(planes: Sequence[FlatPlane], facets: Sequence[Facet], most: int) -> ConvexParts:
    """Return the convex parts of the points whose winding number is above 0.

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
    partition = _Partition(planes, facets)
    nodes = partition.nodes(most)
    overlap = False
    for node in reversed(nodes[1:]):
        if node.winding is not None:
            node.is_full, node.overlaps = node.winding > 0, node.winding > 1
            overlap |= node.winding not in (0, 1)
        parent = nodes[node.parent]
        parent.is_full &= node.is_full
        parent.overlaps |= node.overlaps
    parts, is_within = [], [False]
    for node in nodes[1:]:
        # Where pieces overlap, a region that is full is one part
        is_part = node.is_full and (node.winding is not None or node.overlaps)
        if is_part and not is_within[node.parent]:
            parts.append(_needed_sides(planes, node.sides, partition.reach, node.doubtful))
        is_within.append(is_part or is_within[node.parent])
    return ConvexParts(parts, overlap)


class _Partition:
    """The regions into which the planes of facets split space.

    The winding numbers of leaves are computed together. A convex leaf stands for a region that is outside around it;
    if pieces overlap there, the region is split further.
    """

    def __init__(self, planes: Sequence[FlatPlane], facets: Sequence[Facet]) -> None:
        self.planes, self._known = planes, _PlaneSigns(planes, facets)
        self._numbers = WindingNumbers(planes, facets)
        self.reach = 2 * max(float(abs(c)) for facet in facets for corner in facet.corners for c in corner)
        self._nodes = [_Node(0, (), 0)]
        self._probes: list[tuple[Probe, int, _ConvexRegion | None]] = []
        self._pending = [_ConvexRegion(list(facets), 0, (), self._known)]

    def nodes(self, most: int) -> list[_Node]:
        """Return all regions, each after its parent; raise ValueError for more than `most` leaves inside."""
        count = 0
        while self._pending or self._probes:
            if self._pending and len(self._probes) < PROBES:
                self._split(self._pending.pop())
                continue
            count += self._decide()
            if count > most:
                raise ValueError(f"faces must enclose at most {most:,} convex parts, found more")
        return self._nodes

    def _split(self, region: _ConvexRegion) -> None:
        """Split a region, or take it for a leaf."""
        planes, within = self.planes, len(region.sides)
        plane, is_at_rim = _best(planes, region)
        whole = region.convex(planes) if is_at_rim and not region.overlaps else None
        if whole is not None:
            probe = _probe_facets(region.facets, whole[within])
            self._add_leaf(probe, _Node(region.node, whole, within), region)
            return
        front, back, own = _split(planes, plane, region)
        if not (front and back) and _cancel(own, planes[plane]):
            if front or back:
                self._pending.append(_ConvexRegion(front + back, region.node, region.sides, self._known))
            else:
                self._add_leaf(_probe_facets(own, (plane, 1)), _Node(region.node, region.sides, within))
            return
        for facets, side in ((back, (plane, 1)), (front, (plane, -1))):
            sides = (*region.sides, side)
            if facets and not len(sides) % _PRUNING_STEP:  # a side without a face has none further in either
                sides = _needed_sides(planes, sides, self.reach, len(sides))
            node = _Node(region.node, sides, len(sides))
            if facets:
                self._pending.append(_ConvexRegion(facets, len(self._nodes), node.sides, self._known))
                self._nodes.append(node)
            else:
                self._add_leaf(_probe_facets(own, side), node)

    def _add_leaf(self, probe: Probe | None, node: _Node, convex: _ConvexRegion | None = None) -> None:
        probe = probe or _probe_side(self.planes, node.sides)
        if probe is not None:  # else the leaf is empty
            self._probes.append((probe, len(self._nodes), convex))
            self._nodes.append(node)

    def _decide(self) -> int:
        """Give the leaves their winding numbers, and return how many are inside."""
        count = 0
        windings = self._numbers.at([probe for probe, _, _ in self._probes])
        for winding, (_, place, convex) in zip(windings, self._probes, strict=True):
            node = self._nodes[place]
            if convex is not None and winding > 1:
                convex.overlaps = True
                self._pending.append(convex)
                node.parent, node.winding = 0, 0  # no longer a leaf of its region
                continue
            count += winding > 0
            node.winding = winding
            if convex is not None:
                self._nodes[node.parent].is_full = False
                node.winding -= winding < 1  # the number in front of the facets, at most
        self._probes.clear()
        return count


def _cancel(facets: Sequence[Facet], plane: FlatPlane) -> bool:
    """Return True if facets in one plane bound nothing: on each line, ends of their edges cancel one another."""
    if len(facets) < 2 or sum(dot3(newell_normal(facet.corners), plane.normal) for facet in facets):
        return False
    ends: Counter[tuple[Point, Point, Point]] = Counter()
    for facet in facets:
        for a, b in zip(facet.corners, (*facet.corners[1:], facet.corners[0]), strict=True):
            if a != b:
                low, high, sense = (a, b, 1) if a < b else (b, a, -1)
                lead = next(c for c in minus(high, low) if c)
                x, y, z = minus(high, low)
                along = x / lead, y / lead, z / lead
                line = along, cross(low, along)
                ends[*line, low] += sense
                ends[*line, high] -= sense
    return not any(ends.values())


def _probe_facets(facets: Sequence[Facet], side: PlaneSide) -> Probe | None:
    """Return a probe from a facet in a plane to one side of it; None if no facet there has an area."""
    for facet in facets:
        if facet.plane == side[0]:
            probe = _probe_polygon(facet.corners, side)
            if probe is not None:
                return probe
    return None


def _probe_side(planes: Sequence[FlatPlane], sides: tuple[PlaneSide, ...]) -> Probe | None:
    """Return a probe from a face of a convex region into it; None if the region is empty."""
    for side in reversed(sides):
        corners = exact_face(planes, sides, side[0])
        probe = _probe_polygon(corners, side) if corners else None
        if probe is not None:
            return probe
    return None


def _probe_polygon(corners: Sequence[Point], side: PlaneSide) -> Probe | None:
    """Return a probe between corners of a polygon that do not lie on a line."""
    a = corners[0]
    for b, c in itertools.pairwise(corners[1:]):
        if any(cross(minus(b, a), minus(c, a))):
            return Probe((a, b, c), side)
    return None


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
            a, b = dot3(plane.normal, corner) - plane.offset, dot3(plane.normal, following) - plane.offset
            t = a / (a - b)
            yield (
                corner[0] + t * (following[0] - corner[0]),
                corner[1] + t * (following[1] - corner[1]),
                corner[2] + t * (following[2] - corner[2]),
            )


def _needed_sides(
    planes: Sequence[FlatPlane], sides: tuple[PlaneSide, ...], reach: float, doubtful: int
) -> tuple[PlaneSide, ...]:
    """Return the sides on which a convex region has a face near the solid; there they imply the others.

    The first `doubtful` sides come from splits; on each of the others lies a facet. Floats decide in a cube of half the
    edge `reach`, which contains everything; fractions decide where floats cannot.
    """
    rows = np.array([[its * c for c in planes[number].about] for number, its in sides])
    rows[:, 3] /= reach  # in units of the reach, so that nothing overflows
    with np.errstate(under="ignore"):  # numbers so small are far below `_LOOSE`
        sure = _sure_faces(rows) if len(rows) <= _MOST_TRIPLED else np.zeros(len(rows), np.int8)
        return tuple(
            side
            for k, side in enumerate(sides)
            if k >= doubtful or sure[k] > 0 or (not sure[k] and _has_face(rows, k, planes, sides))
        )


_MOST_TRIPLED = 20
"""Of so many sides, all triples are compared together, three times as fast as one side after the other is cut."""
_LEAST_VOLUME = 1e-3
"""Triples of normals that span less are left out: they meet in no point that floats find."""


@lru_cache(maxsize=_MOST_TRIPLED)
def _triples(count: int) -> npt.NDArray[np.intp]:
    return np.array(list(itertools.combinations(range(count), 3)))


def _sure_faces(rows: FloatArray) -> Ints:
    """Return for each side 1 if a part surely has a face on it, -1 if it surely has none, and 0 if floats do not tell.

    `rows` are those of `_has_face`. There is no face if the other sides imply this one: if its normal is a sum of those
    of three, with shares that are not negative, and the same sum of their offsets is less than its offset (the dual of
    a linear program). There is one if some point of its plane is inside all other sides. The sides of a cube around
    everything count, too.
    """
    count = len(rows)
    bounded = np.concatenate([rows, np.eye(3, 4), -np.eye(3, 4)])
    bounded[count:, 3] = 1.0
    triples = _triples(len(bounded))
    a, b, c = (bounded[triples[:, i], :3] for i in range(3))
    crosses = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
    volumes = (a * crosses[:, 0]).sum(axis=1)
    clear = np.abs(volumes) > _LEAST_VOLUME
    triples, inverse = triples[clear], crosses[clear] / volumes[clear, None, None]
    offsets, is_own = bounded[triples, 3], (triples[:, :, None] == np.arange(count)).any(axis=1)
    shares = inverse @ rows[:, :3].T
    implied = np.where((shares < -1e-13).any(axis=1) | is_own, np.inf, np.einsum("ti,tik->tk", offsets, shares))
    found = -(implied.min(axis=0) < rows[:, 3] - _LOOSE).astype(np.int8)
    points = np.einsum("ti,tix->tx", offsets, inverse)
    inside = (points @ bounded[:, :3].T <= bounded[:, 3] + _LOOSE).all(axis=1)
    for k in np.flatnonzero(found == 0).tolist():
        corners = points[inside & is_own[:, k]]
        if len(corners):
            depth = rows[:, 3] - rows[:, :3] @ corners.mean(axis=0)
            depth[k] = 1.0 if abs(depth[k]) < 1e-12 else 0.0
            found[k] = depth.min() > 4 * _LOOSE
    return found


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
    return bool(exact_face(planes, [sides[j] for j in (*cuts, *others)], sides[k][0]))


def _cut(corners: FloatArray, heights: FloatArray) -> FloatArray:
    """Return the corners of the part of a polygon with heights <= 0."""
    following = np.concatenate([heights[1:], heights[:1]])
    inside, cut = heights <= 0, (heights < 0) != (following < 0)
    share = np.where(cut, heights / np.where(cut, heights - following, 1.0), 0.0)[:, None]
    points, kept = np.empty((2 * len(corners), 3)), np.empty(2 * len(corners), bool)
    points[::2], kept[::2], kept[1::2] = corners, inside, cut
    points[1::2] = corners + share * (np.concatenate([corners[1:], corners[:1]]) - corners)
    return points[kept]


def _is_wide(corners: FloatArray) -> bool:
    """Return True if a polygon surely has an area, although its sides were loosened."""
    spokes = corners[1:] - corners[0]
    doubled = np.linalg.norm(np.cross(spokes[:-1], spokes[1:]).sum(axis=0))
    longest = float(np.linalg.norm(corners.max(axis=0) - corners.min(axis=0)))
    return bool(doubled > 64 * _LOOSE * (longest + _LOOSE))


def exact_face(planes: Sequence[FlatPlane], sides: Sequence[PlaneSide], number: int) -> list[Point]:
    """Return the corners of the face of a part on plane `number`, in fractions; none without an area.

    `sides` are all sides of the part, those that cut off most first.
    """
    corners = _square(planes[number])
    for other, its in sides:
        if other != number and corners:
            signs = [its * side_of_plane(planes[other], corner) for corner in corners]
            there = [s * its for s in signs]
            corners = [] if min(signs) >= 0 else list(_clip_facet(planes[other], corners, there, -its))
    return corners


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
