"""Rectangular and hexagonal lattices: where their elements are, what they hold, and what lies outside.

An element is a convex prism; a point of it is looked up in the element's universe relative to the
element's center. Outside of the lattice the outer universe is repeated in the same way without end
(OpenMC, "Geometry specification").
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import product

from .extent import Extent
from .narrowing import AnyOf, Side
from .placement import Point
from .surface_kinds import titled
from .surfaces import FlatSurface
from .xml_tree import Element

Index = tuple[int, ...]
Planes = tuple[tuple[Point, Fraction], ...]
"""normal·x <= offset, for each."""
ZERO, ONE, HALF = Fraction(0), Fraction(1), Fraction(1, 2)
ROOT3 = Fraction(math.sqrt(3.0))
"""√3 as float64 has it; all of a hexagonal lattice is made of this number, so that its elements fit exactly."""


@dataclass(frozen=True, slots=True)
class Prism:
    """The inside of planes, with a box around it."""

    planes: Planes
    extent: Extent

    def sides(self) -> list[Side]:
        return [Side(FlatSurface(normal, offset), False) for normal, offset in self.planes]

    def outside(self) -> AnyOf:
        """Beyond at least one plane."""
        return AnyOf(tuple(Side(FlatSurface(normal, offset), True) for normal, offset in self.planes))


@dataclass(frozen=True)
class Lattice(ABC):
    """Universes on a grid; indices are OpenMC's, those of hexagonal lattices counted from the central element."""

    id: int
    name: str
    outer: int | None
    universes: dict[Index, int]
    element: Element = field(repr=False, compare=False)

    def __str__(self) -> str:
        return titled("lattice", self.id, self.name)

    @abstractmethod
    def center(self, index: Index) -> Point:
        """The center of an element, of the lattice or outside; 0 along z in two dimensions."""

    @abstractmethod
    def prism(self, index: Index) -> Prism:
        """The element itself."""

    @property
    @abstractmethod
    def hull(self) -> list[Prism]:
        """Prisms that together cover the elements of the lattice and no more."""

    @property
    @abstractmethod
    def steps(self) -> list[Point]:
        """The ways from an element to its neighbours, as far as they are independent."""

    @abstractmethod
    def indices_around(self, extent: Extent) -> Iterator[Index] | None:
        """All indices of elements that reach into a box, and perhaps more; None where they have no end."""


@dataclass(frozen=True)
class RectangularLattice(Lattice):
    """Element (i, j[, k]) spans pitch from lower_left + pitch (i, j[, k]); two or three dimensions."""

    shape: tuple[int, ...]
    lower_left: tuple[Fraction, ...]
    pitch: tuple[Fraction, ...]

    def center(self, index: Index) -> Point:
        middle = [a + (i + HALF) * p for a, i, p in zip(self.lower_left, index, self.pitch, strict=True)]
        x, y, z = (*middle, ZERO)[:3]
        return x, y, z

    def prism(self, index: Index) -> Prism:
        return self._box(index, tuple(i + 1 for i in index))

    @property
    def hull(self) -> list[Prism]:
        return [self._box((0,) * len(self.shape), self.shape)]

    def _box(self, first: Index, end: Index) -> Prism:
        low: list[Fraction | None] = [None] * 3
        high: list[Fraction | None] = [None] * 3
        planes = []
        for axis, (a, p) in enumerate(zip(self.lower_left, self.pitch, strict=True)):
            low[axis], high[axis] = a + first[axis] * p, a + end[axis] * p
            planes.append((_axis(axis, -ONE), -(a + first[axis] * p)))
            planes.append((_axis(axis, ONE), a + end[axis] * p))
        return Prism(tuple(planes), Extent((low[0], low[1], low[2]), (high[0], high[1], high[2])))

    @property
    def steps(self) -> list[Point]:
        return [_axis(axis, p) for axis, p in enumerate(self.pitch)]

    def indices_around(self, extent: Extent) -> Iterator[Index] | None:
        ranges = []
        for axis, (a, p) in enumerate(zip(self.lower_left, self.pitch, strict=True)):
            low, high = extent.low[axis], extent.high[axis]
            if low is None or high is None:
                return None
            ranges.append(range(math.floor((low - a) / p), math.ceil((high - a) / p)))
        return product(*ranges)


@dataclass(frozen=True)
class HexagonalLattice(Lattice):
    """Regular hexagons, `pitch` between opposite sides, in rings about the one at `center`.

    Orientation "y": two sides are parallel to the x axis; element (x, a) is centered at
    center + pitch (√3/2 x, a + x/2). Orientation "x": two sides are parallel to the y axis; element (a, y) is
    centered at center + pitch (a + y/2, √3/2 y). With `axial_pitch` there are `levels` levels along z, centered at
    center z. (OpenMC, HexLattice::get_local_position.)
    """

    rings: int
    orientation: str
    middle: Point
    pitch: Fraction
    axial_pitch: Fraction | None
    levels: int

    def center(self, index: Index) -> Point:
        i, j = index[:2]
        x, y, z = self.middle
        if self.axial_pitch is not None:
            z += (index[2] + HALF * (1 - self.levels)) * self.axial_pitch
        if self.orientation == "y":
            return x + ROOT3 * HALF * i * self.pitch, y + (j + HALF * i) * self.pitch, z
        return x + (i + HALF * j) * self.pitch, y + ROOT3 * HALF * j * self.pitch, z

    def prism(self, index: Index) -> Prism:
        return self._prism(index, 1)

    def _prism(self, index: Index, size: int) -> Prism:
        """An element, or a hexagon so many times as large."""
        i, j = index[:2]
        mx, my, _ = self.middle
        s, p, zero, one = ROOT3, self.pitch, ZERO, ONE
        # (normal, its product with the lattice's center, the height of the element's center in pitches);
        # a pair of sides with a normal of length 2 is twice as far away
        if self.orientation == "y":
            rows = (((s, one, zero), s * mx + my, 2 * i + j), ((s, -one, zero), s * mx - my, i - j))
            straight, middle, along = (zero, one, zero), my, j + HALF * i
        else:
            rows = (((one, s, zero), mx + s * my, i + 2 * j), ((one, -s, zero), mx - s * my, i - j))
            straight, middle, along = (one, zero, zero), mx, i + HALF * j
        planes = []
        for normal, base, height in rows:
            planes += _slab(normal, base + (height - size) * p, base + (height + size) * p)
        planes += _slab(straight, middle + (along - HALF * size) * p, middle + (along + HALF * size) * p)
        x, y, z = self.center(index)
        reach_x, reach_y = size * p / s, size * p * HALF
        if self.orientation == "x":
            reach_x, reach_y = reach_y, reach_x
        low: tuple[Fraction, Fraction, Fraction | None] = (x - reach_x, y - reach_y, None)
        high: tuple[Fraction, Fraction, Fraction | None] = (x + reach_x, y + reach_y, None)
        if self.axial_pitch is not None:
            bottom, top = z - HALF * self.axial_pitch, z + HALF * self.axial_pitch
            planes += _slab((zero, zero, one), bottom, top)
            low, high = (low[0], low[1], bottom), (high[0], high[1], top)
        return Prism(tuple(planes), Extent(low, high))

    @property
    def hull(self) -> list[Prism]:
        return [self.prism(index) for index in self.universes]

    @property
    def steps(self) -> list[Point]:
        p, half, long = self.pitch, HALF * self.pitch, ROOT3 * HALF * self.pitch
        level = [] if self.axial_pitch is None else [(ZERO, ZERO, self.axial_pitch)]
        if self.orientation == "y":
            return [(long, half, ZERO), (ZERO, p, ZERO), *level]
        return [(p, ZERO, ZERO), (half, long, ZERO), *level]

    def indices_around(self, extent: Extent) -> Iterator[Index] | None:
        flat = [*extent.low[:2], *extent.high[:2]]
        if None in flat or (self.axial_pitch is not None and (extent.low[2] is None or extent.high[2] is None)):
            return None
        return self._around(extent)

    def _around(self, extent: Extent) -> Iterator[Index]:
        """Columns (or rows) of hexagons first, then along each; a neighbour more on every side."""
        low, high = [float(v or 0) for v in extent.low], [float(v or 0) for v in extent.high]
        across, along = (0, 1) if self.orientation == "y" else (1, 0)
        p, wide = float(self.pitch), float(ROOT3 * HALF * self.pitch)
        m = [float(value) for value in self.middle]
        levels: list[Index] = [()]
        if self.axial_pitch is not None:
            step, bottom = float(self.axial_pitch), m[2] - 0.5 * self.levels * float(self.axial_pitch)
            first, last = math.floor((low[2] - bottom) / step) - 1, math.ceil((high[2] - bottom) / step) + 1
            levels = [(k,) for k in range(first, last + 1)]
        columns = range(math.floor((low[across] - m[across]) / wide) - 1, math.ceil((high[across] - m[across]) / wide) + 2)
        for level, i in product(levels, columns):
            first = math.floor((low[along] - m[along]) / p - 0.5 * i) - 1
            last = math.ceil((high[along] - m[along]) / p - 0.5 * i) + 1
            for j in range(first, last + 1):
                yield (i, j, *level) if self.orientation == "y" else (j, i, *level)


def ring_order(rings: int, orientation: str) -> list[tuple[int, int]]:
    """The indices in the order in which a file lists a level: rows from the top, each from left to right."""
    reach = range(-rings + 1, rings)
    inside = [(i, j) for i, j in product(reach, reach) if abs(i + j) < rings]
    if orientation == "y":
        # y = a + x/2, in halves of the pitch; x rises along a row
        return sorted(inside, key=lambda index: (-(2 * index[1] + index[0]), index[0]))
    return sorted(inside, key=lambda index: (-index[1], index[0]))


def _slab(normal: Point, low: Fraction, high: Fraction) -> list[tuple[Point, Fraction]]:
    x, y, z = normal
    return [((-x, -y, -z), -low), (normal, high)]


def _axis(axis: int, length: Fraction) -> Point:
    x, y, z = (length if i == axis else ZERO for i in range(3))
    return x, y, z
