"""MCNP's lattices of parallelepipeds (LAT=1) and hexagonal prisms (LAT=2), whose elements are copies of a cell.

`parallelepiped_element` and `hexagonal_element` find the translations from the planes of the cell, and `CellLattice` is
the lattice of these elements.
"""

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
"""Largest asymmetry of the sides of a hexagon, as a share of half its width."""


@dataclass(frozen=True)
class LatticeSlab:
    """The slab low <= normal·x <= high."""

    normal: Point
    low: Fraction
    high: Fraction

    @property
    def half(self) -> Fraction:
        """Half the width, in units of the normal."""
        return (self.high - self.low) / 2

    @property
    def middle(self) -> Fraction:
        """The offset of the middle plane."""
        return (self.high + self.low) / 2


@dataclass(frozen=True)
class LatticeElement:
    """The element [0, 0, 0] of a lattice, and the translations (`ways`) to its neighbours."""

    slabs: tuple[LatticeSlab, ...]
    ways: tuple[Point, ...]
    extent: Extent
    reach: tuple[tuple[Point, Fraction, Fraction], ...]
    """For each way (w, low, high): w·x grows by one along this way and by zero along the others, and low <= w·x <= high
    in the element."""


@dataclass(frozen=True)
class CellLattice(Lattice):
    """A lattice of a cell: element [i, j, k], and the universe in it, are translated by i, j and k times the ways."""

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
        """The universe of each element that is not empty."""
        return self.entries

    def order(self) -> Iterable[Index]:
        """Return the indices of the elements."""
        return self.entries

    def center(self, index: Index) -> Point:
        """Return the origin of the universe in an element."""
        shift = ORIGIN
        for steps, way in zip(index, self.first.ways, strict=False):
            shift = add_scaled(shift, way, steps)
        return shift

    def prism(self, index: Index) -> LatticePrism:
        """Return the prism of an element."""
        return self._between(index, index)

    def _between(self, first: Index, last: Index) -> LatticePrism:
        """Return the prism that the planes of two elements enclose."""
        low, high = self.center(first), self.center(last)
        planes = []
        for slab in self.first.slabs:
            shifts = dot(slab.normal, low), dot(slab.normal, high)
            planes.append((slab.normal, slab.high + max(shifts)))
            planes.append((scale_vector(slab.normal, -1), -slab.low - min(shifts)))
        extents = [self.first.extent.placed(UniversePlacement(shift=shift)) for shift in (low, high)]
        return LatticePrism(tuple(planes), extents[0].union(extents[1]))

    @property
    def hull(self) -> list[LatticePrism]:
        """One prism if the elements fill it, else the prisms of all elements."""
        if not self.entries:
            return []
        ends = [(min(axis), max(axis)) for axis in zip(*self.entries, strict=True)]
        low, high = (tuple(end[i] for end in ends) for i in (0, 1))
        is_full = len(self.entries) == math.prod(b - a + 1 for a, b in ends)
        # Hexagonal elements (more slabs than ways) have a jagged union, unless they form one column.
        if is_full and (len(self.first.slabs) == len(self.first.ways) or low[:2] == high[:2]):
            return [self._between(low, high)]
        return [self.prism(index) for index in self.entries]

    @property
    def steps(self) -> list[Point]:
        return list(self.first.ways)

    def tiles_around(self, extent: Extent) -> LatticeTiles | None:
        """Return all elements that reach into a box, and perhaps more; None if the box is infinite across them."""
        ends: list[tuple[int, int]] = []
        for functional, low, high in self.first.reach:
            least, most = extent.least(functional), extent.most(functional)
            if least is None or most is None:
                return None
            # Element i reaches from i + low to i + high of the functional.
            ends.append((math.floor(least - high), math.ceil(most - low) + 1))
        ends += [(0, 1)] * (3 - len(ends))
        return LatticeTiles(math.prod(max(end - first, 0) for first, end in ends), grid_indices(ends))


def parallelepiped_element(slabs: list[LatticeSlab]) -> LatticeElement:
    """Return the element of LAT=1 from one to three slabs. Raise ValueError if their directions depend."""
    across = _slab_duals(slabs)  # along w[i] only slab i changes
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
    """Return True if an axis is in the span of normals, so that their slabs bound it."""
    if len(normals) == 3:
        return True
    if len(normals) == 2:
        return not cross(*normals)[axis]
    return not any(value for i, value in enumerate(normals[0]) if i != axis)


def hexagonal_element(slabs: list[LatticeSlab]) -> LatticeElement:
    """Return the element of LAT=2 from three slabs of sides and, if there is one, the slab of the ends.

    Raise ValueError if the sides make no hexagonal prism with a centre of symmetry.
    """
    a, b, c = slabs[:3]
    along = cross(a.normal, b.normal)
    if dot(along, c.normal):
        raise ValueError("LAT=2: the sides of a hexagonal prism must have one direction in common")
    u, v = _slab_duals([a, b])
    center = add_scaled(scale_vector(u, a.middle), v, b.middle)
    off = dot(c.normal, center) - c.middle
    if abs(off) > MAX_SKEW * c.half:
        raise ValueError("LAT=2: opposite sides of the hexagon must be as far from its centre as each other")
    # Equal to the file up to rounding, but exactly symmetric, so that elements fit without gaps.
    c = LatticeSlab(c.normal, c.low + off, c.high + off)
    # Three neighbouring corners; the other three are their opposites about the centre.
    corners = [_corner(a, b), _corner(b, c), _corner(c, _flip_slab(a))]
    for corner, slab in zip(corners, (c, a, b), strict=True):
        if abs(dot(slab.normal, corner)) >= slab.half:
            raise ValueError("LAT=2: the sides must be listed so that the fifth is between the third and the second")
    ways = [add_scaled(corners[0], corners[2], -1), add_scaled(corners[1], corners[0])]
    sides = [a, b, c]
    if len(slabs) > 3:
        end = slabs[3]
        rise = dot(end.normal, along)
        if not rise:
            raise ValueError("LAT=2: the ends of a hexagonal prism must lie across its sides")
        center = add_scaled(center, along, (end.middle - dot(end.normal, center)) / rise)
        corners = [add_scaled(p, along, -dot(end.normal, p) / rise) for p in corners]
        ways.append(scale_vector(along, (end.high - end.low) / rise))
        sides.append(end)
    lows: list[ExtentEnd] = []
    highs: list[ExtentEnd] = []
    for axis in range(3):
        half = max(abs(p[axis]) for p in corners) + (abs(ways[2][axis]) / 2 if len(ways) > 2 else 0)
        is_bounded = len(ways) > 2 or not along[axis]
        lows.append(center[axis] - half if is_bounded else None)
        highs.append(center[axis] + half if is_bounded else None)
    extent = Extent((lows[0], lows[1], lows[2]), (highs[0], highs[1], highs[2]))
    # A hexagon reaches less than one way from its centre, so these bounds are safe.
    reach = tuple((d, dot(d, center) - 1, dot(d, center) + 1) for d in dual_vectors(ways))
    return LatticeElement(tuple(sides), tuple(ways), extent, reach)


def _corner(a: LatticeSlab, b: LatticeSlab) -> Point:
    """Return the point where the upper sides of two slabs meet, relative to the centre."""
    u, v = _slab_duals([a, b])
    return add_scaled(scale_vector(u, a.half), v, b.half)


def _flip_slab(slab: LatticeSlab) -> LatticeSlab:
    return LatticeSlab(scale_vector(slab.normal, -1), -slab.high, -slab.low)


def _slab_duals(slabs: list[LatticeSlab]) -> list[Point]:
    """Return the dual vectors of the normals. Raise ValueError if the normals are dependent."""
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
    """Yield the indices in the order of a FILL: the first index runs fastest."""
    for k, j, i in product(*(range(low, high + 1) for low, high in reversed(ranges))):
        yield i, j, k
