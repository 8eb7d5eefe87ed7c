"""MCNP's lattices: parallelepipeds (LAT=1) and hexagonal prisms (LAT=2), whose elements are copies of a cell."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import product

from ..openmc.lattices import Index, Lattice, LatticePrism, LatticeTiles, grid_indices
from ..openmc.placement import ORIGIN, Extent, ExtentEnd, Point, UniversePlacement
from .transformations import add_scaled, cross, dot, dual_vectors, scale_vector

MAX_SKEW = Fraction(1, 10_000)
"""How far the sides of a hexagon may be from being symmetric, as a share of its width."""


@dataclass(frozen=True)
class LatticeSlab:
    """low <= normal·x <= high"""

    normal: Point
    low: Fraction
    high: Fraction

    @property
    def half(self) -> Fraction:
        return (self.high - self.low) / 2

    @property
    def middle(self) -> Fraction:
        return (self.high + self.low) / 2


@dataclass(frozen=True)
class LatticeElement:
    """The element [0, 0, 0], and the ways to the next ones."""

    slabs: tuple[LatticeSlab, ...]
    ways: tuple[Point, ...]
    extent: Extent
    reach: tuple[tuple[Point, Fraction, Fraction], ...]
    """For each way a functional that grows by one along it, and by no other, and between what ends the element lies."""


@dataclass(frozen=True)
class CellLattice(Lattice):
    """Element [i, j, k] is the cell moved by i, j and k times the ways; so is the universe in it."""

    first: LatticeElement
    entries: dict[Index, int] = field(repr=False)
    cell: int

    def __str__(self) -> str:
        return f"lattice of cell {self.cell}"

    @property
    def label(self) -> str:
        return "lattice"

    @property
    def universes(self) -> dict[Index, int]:
        return self.entries

    def order(self) -> Iterable[Index]:
        return self.entries

    def center(self, index: Index) -> Point:
        """Where the origin of the universe is."""
        shift = ORIGIN
        for steps, way in zip(index, self.first.ways, strict=False):
            shift = add_scaled(shift, way, steps)
        return shift

    def prism(self, index: Index) -> LatticePrism:
        return self._between(index, index)

    def _between(self, first: Index, last: Index) -> LatticePrism:
        """What the planes of two elements enclose."""
        low, high = self.center(first), self.center(last)
        planes = []
        for slab in self.first.slabs:
            shifts = dot(slab.normal, low), dot(slab.normal, high)
            planes.append((slab.normal, slab.high + max(shifts)))
            planes.append((scale_vector(slab.normal, -1), -slab.low - min(shifts)))
        extents = [self.first.extent.placed(UniversePlacement(shift=shift)) for shift in (low, high)]
        return LatticePrism(tuple(planes), extents[0].around(extents[1]))

    @property
    def hull(self) -> list[LatticePrism]:
        """One prism where the elements fill it, else all of them."""
        if not self.entries:
            return []
        ends = [(min(axis), max(axis)) for axis in zip(*self.entries, strict=True)]
        low, high = (tuple(end[i] for end in ends) for i in (0, 1))
        is_full = len(self.entries) == math.prod(b - a + 1 for a, b in ends)
        if is_full and (len(self.first.slabs) == len(self.first.ways) or low[:2] == high[:2]):
            return [self._between(low, high)]
        return [self.prism(index) for index in self.entries]

    @property
    def steps(self) -> list[Point]:
        return list(self.first.ways)

    def tiles_around(self, extent: Extent) -> LatticeTiles | None:
        ends: list[tuple[int, int]] = []
        for functional, low, high in self.first.reach:
            least, most = extent.least(functional), extent.most(functional)
            if least is None or most is None:
                return None
            ends.append((math.floor(least - high), math.ceil(most - low) + 1))
        ends += [(0, 1)] * (3 - len(ends))
        return LatticeTiles(math.prod(max(end - first, 0) for first, end in ends), grid_indices(ends))


def parallelepiped_element(slabs: list[LatticeSlab]) -> LatticeElement:
    """LAT=1, of one to three pairs of planes. Raises ValueError."""
    across = _slab_duals(slabs)
    ways = tuple(scale_vector(w, slab.high - slab.low) for w, slab in zip(across, slabs, strict=True))
    center = _sum_points(scale_vector(w, slab.middle) for w, slab in zip(across, slabs, strict=True))
    lows: list[ExtentEnd] = []
    highs: list[ExtentEnd] = []
    for axis in range(3):
        is_bounded = _is_in_span([slab.normal for slab in slabs], axis)
        half = sum((abs(way[axis]) for way in ways), Fraction(0)) / 2
        lows.append(center[axis] - half if is_bounded else None)
        highs.append(center[axis] + half if is_bounded else None)
    reach = tuple(
        (scale_vector(s.normal, 1 / (s.high - s.low)), s.low / (s.high - s.low), s.high / (s.high - s.low))
        for s in slabs
    )
    return LatticeElement(
        tuple(slabs), ways, Extent((lows[0], lows[1], lows[2]), (highs[0], highs[1], highs[2])), reach
    )


def _is_in_span(normals: list[Point], axis: int) -> bool:
    if len(normals) == 3:
        return True
    if len(normals) == 2:
        return not cross(*normals)[axis]
    return not any(value for i, value in enumerate(normals[0]) if i != axis)


def hexagonal_element(slabs: list[LatticeSlab]) -> LatticeElement:
    """LAT=2, of three pairs of sides, and the ends. Raises ValueError."""
    a, b, c = slabs[:3]
    along = cross(a.normal, b.normal)
    if dot(along, c.normal):
        raise ValueError("LAT=2: the sides of a hexagonal prism must have one direction in common")
    u, v = _slab_duals([a, b])
    center = add_scaled(scale_vector(u, a.middle), v, b.middle)
    off = dot(c.normal, center) - c.middle
    if abs(off) > MAX_SKEW * c.half:
        raise ValueError("LAT=2: opposite sides of the hexagon must be as far from its centre as each other")
    c = LatticeSlab(
        c.normal, c.low + off, c.high + off
    )  # what the file says to rounding, and elements fit without gaps
    corners = [_corner(a, b), _corner(b, c), _corner(c, _flip_slab(a))]
    for corner, slab in zip(corners, (c, a, b), strict=True):
        if abs(dot(slab.normal, corner)) >= slab.half:
            raise ValueError("LAT=2: the sides must be listed so that the fifth is between the third and the second")
    ways = [add_scaled(corners[0], corners[2], -1), add_scaled(corners[1], corners[0])]
    kept = [a, b, c]
    if len(slabs) > 3:
        end = slabs[3]
        rise = dot(end.normal, along)
        if not rise:
            raise ValueError("LAT=2: the ends of a hexagonal prism must lie across its sides")
        center = add_scaled(center, along, (end.middle - dot(end.normal, center)) / rise)
        corners = [add_scaled(p, along, -dot(end.normal, p) / rise) for p in corners]
        ways.append(scale_vector(along, (end.high - end.low) / rise))
        kept.append(end)
    lows: list[ExtentEnd] = []
    highs: list[ExtentEnd] = []
    for axis in range(3):
        half = max(abs(p[axis]) for p in corners) + (abs(ways[2][axis]) / 2 if len(ways) > 2 else 0)
        is_bounded = len(ways) > 2 or not along[axis]
        lows.append(center[axis] - half if is_bounded else None)
        highs.append(center[axis] + half if is_bounded else None)
    extent = Extent((lows[0], lows[1], lows[2]), (highs[0], highs[1], highs[2]))
    reach = tuple((d, dot(d, center) - 1, dot(d, center) + 1) for d in dual_vectors(ways))
    return LatticeElement(tuple(kept), tuple(ways), extent, reach)


def _corner(a: LatticeSlab, b: LatticeSlab) -> Point:
    """Where the upper sides of two slabs meet, about the centre."""
    u, v = _slab_duals([a, b])
    return add_scaled(scale_vector(u, a.half), v, b.half)


def _flip_slab(slab: LatticeSlab) -> LatticeSlab:
    return LatticeSlab(scale_vector(slab.normal, -1), -slab.high, -slab.low)


def _slab_duals(slabs: list[LatticeSlab]) -> list[Point]:
    try:
        return dual_vectors([slab.normal for slab in slabs])
    except (ValueError, ZeroDivisionError):
        raise ValueError("the pairs of planes of a lattice must have different directions") from None


def _sum_points(points: Iterable[Point]) -> Point:
    whole = ORIGIN
    for each in points:
        whole = add_scaled(whole, each)
    return whole


def index_order(ranges: list[tuple[int, int]]) -> Iterable[Index]:
    """The indices in the order of a FILL: the first runs fastest."""
    for k, j, i in product(*(range(low, high + 1) for low, high in reversed(ranges))):
        yield i, j, k
