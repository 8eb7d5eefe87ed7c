"""Rectangular and hexagonal lattices: their elements as prisms, the universes in them, and the space around them.

An element is a convex prism; a point in it is looked up in the element's universe relative to the element's center.
Outside the lattice the outer universe is repeated in the same way without end (OpenMC, "Geometry specification").
All elements are one, translated; MCNP's lattices have elements of their own (`mcnp/universes.py`).
The last part reads OpenMC's <lattice> and <hex_lattice> elements. Lengths are in cm.
"""

from __future__ import annotations

import dataclasses
import math
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import field
from fractions import Fraction
from functools import cached_property
from itertools import product

from ..._util.records import dataclass
from ..xml_tree import XmlElement
from .placement import ORIGIN, Extent, Point, UniversePlacement, add_points
from .region import PartUnion, SurfaceSide
from .surfaces import FlatSurface
from .values import OpenmcValues, count_words, format_title, quote_word

Index = tuple[int, ...]
LatticePlane = tuple[Point, Fraction]
"""(normal, offset): normal·x <= offset."""
ZERO, ONE, HALF = Fraction(0), Fraction(1), Fraction(1, 2)
ROOT3 = Fraction(math.sqrt(3.0))
"""√3 rounded to float64."""
HALF_ROOT3 = 3 / (2 * ROOT3)
"""√3/2 such that ROOT3 * HALF_ROOT3 is exactly 3/2: elements of a hexagonal lattice then fit without gaps, as the
lattice is the exact image of a regular one."""


@dataclasses.dataclass(frozen=True, slots=True)
class LatticePrism:
    """A convex prism: the inside of planes, with a box around it."""

    planes: tuple[LatticePlane, ...]
    extent: Extent

    def placed(self, place: UniversePlacement) -> LatticePrism:
        """Return the prism after the turn and the shift of a place, before its outer motion."""
        planes = (FlatSurface(*plane).placed(place) for plane in self.planes)
        return LatticePrism(tuple((plane.normal, plane.offset) for plane in planes), self.extent.placed(place))

    def sides(self) -> list[SurfaceSide]:
        """Return the inner sides of all planes."""
        return [SurfaceSide(FlatSurface(normal, offset), False) for normal, offset in self.planes]

    def outside(self) -> PartUnion:
        """Return the space beyond at least one plane."""
        return PartUnion(tuple(SurfaceSide(FlatSurface(normal, offset), True) for normal, offset in self.planes))


@dataclass(frozen=True)
class LatticeElement:
    """The element of index 0: its prism, the origin of the universe in it, and the translations to its neighbours.

    `ways` are these translations, one for each number of an index. For each way (w, low, high) of `reach`, w·x grows by
    one along this way and by zero along the others, and low <= w·x <= high in the element.
    """

    prism: LatticePrism
    origin: Point
    ways: tuple[Point, ...]
    reach: tuple[tuple[Point, Fraction, Fraction], ...]


@dataclass(frozen=True)
class LatticeTiles:
    """Elements around a box: their number, or a bound on it, known before any is listed, and their indices."""

    count: int
    indices: Iterator[Index]


@dataclass(frozen=True)
class Lattice(ABC):
    """Universes on a grid: every element is `first`, translated by the numbers of its index times the ways.

    `listing` is the text that names the universes. There may be millions, so that only the number of occurrences of
    each (`tally`) is computed until `universes` is used. `outer` is the universe outside the lattice, if any.
    """

    id: int
    name: str
    outer: int | None
    tally: Counter[int] = field(repr=False)
    listing: str = field(repr=False)
    element: XmlElement = field(repr=False, compare=False)
    first: LatticeElement

    def __str__(self) -> str:
        return format_title("lattice", self.id, self.name)

    @property
    def label(self) -> str:
        """Its name in the paths to its elements."""
        return f"lattice {self.id}"

    @property
    def size(self) -> int:
        """The number of elements."""
        return self.tally.total()

    @cached_property
    def universes(self) -> dict[Index, int]:
        """The universe of each element."""
        return dict(zip(self.order(), map(int, self.listing.split()), strict=True))

    @abstractmethod
    def order(self) -> Iterable[Index]:
        """Return the indices in the order in which a file lists the universes."""

    @property
    def tile_axes(self) -> tuple[int, ...]:
        """The places of an index in the order in which elements around the lattice are listed, the slowest first."""
        return tuple(range(len(next(iter(self.universes)))))

    def _shift(self, index: Index) -> Point:
        """Return the translation from the first element to another."""
        x, y, z = ORIGIN
        for steps, (a, b, c) in zip(index, self.first.ways, strict=False):
            # Most components are 0, and fractions are slow
            x, y, z = x + steps * a if a else x, y + steps * b if b else y, z + steps * c if c else z
        return x, y, z

    def center(self, index: Index) -> Point:
        """Return the origin of the universe in an element inside or outside the lattice."""
        return add_points(self.first.origin, self._shift(index))

    def prism(self, index: Index) -> LatticePrism:
        """Return the prism of an element inside or outside the lattice."""
        return self.first.prism.placed(UniversePlacement(shift=self._shift(index)))

    def prism_between(self, first: Index, last: Index) -> LatticePrism:
        """Return the prism that the planes of two elements enclose."""
        low, high = self.prism(first), self.prism(last)
        pairs = zip(low.planes, high.planes, strict=True)
        planes = tuple((normal, max(offset, other)) for (normal, offset), (_, other) in pairs)
        return LatticePrism(planes, low.extent.union(high.extent))

    @cached_property
    def hull(self) -> list[LatticePrism]:
        """Prisms whose union is the union of all elements: one if the elements fill it, else those of all elements."""
        if not self.universes:
            return []
        ends = [(min(axis), max(axis)) for axis in zip(*self.universes, strict=True)]
        low, high = (tuple(end[i] for end in ends) for i in (0, 1))
        is_full = len(self.universes) == math.prod(b - a + 1 for a, b in ends)
        # Hexagonal elements (more pairs of planes than ways) have a jagged union, unless they form one column.
        # One prism has six or eight planes, the union of all elements thousands
        is_box = len(self.first.prism.planes) == 2 * len(self.first.ways)
        if is_full and (is_box or low[:2] == high[:2]):
            return [self.prism_between(low, high)]
        return [self.prism(index) for index in self.universes]

    def tiles_around(self, extent: Extent) -> LatticeTiles | None:
        """Return all elements that reach into a box, and perhaps more; None if their number is infinite."""
        ends: list[tuple[int, int]] = []
        for functional, low, high in self.first.reach:
            least, most = extent.least(functional), extent.most(functional)
            # A lattice without end in a box without end has no list of elements
            if least is None or most is None:
                return None
            # Element i reaches from i + low to i + high of the functional. Exact, so that none only touches the box
            ends.append((math.floor(least - high) + 1, math.ceil(most - low)))
        axes = self.tile_axes
        ranges = [(*ends, (0, 1), (0, 1))[axis] for axis in axes]
        places = [axes.index(axis) for axis in range(len(axes))]
        indices = (tuple(steps[place] for place in places) for steps in grid_indices(ranges))
        # The ways of hexagons are slanted: along a flat box most indices in these ranges are of elements beside it
        box = self.first.prism.extent
        indices = (
            index for index in indices
            if not box.placed(UniversePlacement(shift=self._shift(index))).common(extent).is_empty
        )  # fmt: skip
        return LatticeTiles(math.prod(max(end - first, 0) for first, end in ranges), indices)


@dataclass(frozen=True)
class RectangularLattice(Lattice):
    """A lattice of boxes: element (i, j[, k]) spans one pitch from lower_left + pitch (i, j[, k]), in 2 or 3 axes."""

    shape: tuple[int, ...]

    def order(self) -> Iterable[Index]:
        """Return the indices level by level from the bottom, row by row from the top."""
        columns, rows, levels = (*self.shape, 1)[:3]
        flat = len(self.shape) == 2
        # The first row of a file is the one with the largest y, as it stands on paper
        for k, j, i in product(range(levels), reversed(range(rows)), range(columns)):
            yield (i, j) if flat else (i, j, k)


def box_element(lower_left: tuple[Fraction, ...], pitch: tuple[Fraction, ...]) -> LatticeElement:
    """Return the element (0, 0[, 0]) of boxes, infinite in z for two axes."""
    low: list[Fraction | None] = [None] * 3
    high: list[Fraction | None] = [None] * 3
    origin, planes, ways, reach = [ZERO] * 3, [], [], []
    for axis, (a, p) in enumerate(zip(lower_left, pitch, strict=True)):
        low[axis], high[axis], origin[axis] = a, a + p, a + HALF * p
        planes += _slab(_axis(axis, ONE), a, a + p)
        ways.append(_axis(axis, p))
        reach.append((_axis(axis, 1 / p), a / p, a / p + 1))
    extent = Extent((low[0], low[1], low[2]), (high[0], high[1], high[2]))
    return LatticeElement(
        LatticePrism(tuple(planes), extent), (origin[0], origin[1], origin[2]), tuple(ways), tuple(reach)
    )


@dataclass(frozen=True)
class HexagonalLattice(Lattice):
    """A lattice of regular hexagons, `pitch` between opposite sides, in rings about the one at `middle`.

    Orientation "y": two sides are parallel to the x axis; element (x, a) is centered at
    middle + pitch (√3/2 x, a + x/2). Orientation "x": two sides are parallel to the y axis; element (a, y) is
    centered at middle + pitch (a + y/2, √3/2 y). In three dimensions there are `levels` levels along z, centered at the
    z of `middle`. Source: OpenMC, HexLattice::get_local_position.
    """

    rings: int
    orientation: str
    middle: Point
    pitch: Fraction
    levels: int | None

    def order(self) -> Iterable[Index]:
        """Return the indices level by level from the bottom, each level as in `hexagon_order`."""
        level = hexagon_order(self.rings, self.orientation)
        return level if self.levels is None else ((i, j, k) for k in range(self.levels) for i, j in level)

    @property
    def tile_axes(self) -> tuple[int, ...]:
        """Levels, and in each its columns of hexagons (orientation "y") or rows."""
        level = (0, 1) if self.orientation == "y" else (1, 0)
        return level if self.levels is None else (2, *level)

    @cached_property
    def hull(self) -> list[LatticePrism]:
        """The hexagon through the centers of the outermost ring, which elements cover, and the prisms of that ring."""
        last = self.rings - 1
        ring = {index[:2] for index in self.universes if max(map(abs, (*index[:2], index[0] + index[1]))) == last}
        # The inner hexagon and the outermost ring cover all elements with far fewer planes than one prism for each.
        columns = [self._column(index) for index in sorted(ring)]
        # One ring has no inner hexagon
        return columns if last == 0 else [self._inner(last), *columns]

    def _column(self, index: Index) -> LatticePrism:
        """Return the prism of one hexagon through all levels."""
        if self.levels is None:
            return self.prism(index)
        return self.prism_between((*index, 0), (*index, self.levels - 1))

    def _inner(self, last: int) -> LatticePrism:
        """Return the hexagon through the centers of a ring; its sides are rotated by 30 degrees to an element's."""
        x, y, _ = self.middle
        column = self._column((0, 0))
        planes = []
        # With the rounded √3 of the elements, so that no sliver stays between hexagon and ring
        for normal, reach in (((ROOT3, 3 * ONE), 3), ((ROOT3, -3 * ONE), 3), ((ROOT3, ZERO), 3 * HALF)):
            a, b = normal if self.orientation == "y" else normal[::-1]
            base, way = a * x + b * y, reach * last * self.pitch
            planes += _slab((a, b, ZERO), base - way, base + way)
        sizes = HALF_ROOT3 * last * self.pitch, last * self.pitch
        wide, high = sizes if self.orientation == "y" else sizes[::-1]
        extent = Extent((x - wide, y - high, column.extent.low[2]), (x + wide, y + high, column.extent.high[2]))
        return LatticePrism((*planes, *column.planes[6:]), extent)


def hexagon_element(
    orientation: str, middle: Point, pitch: Fraction, axial_pitch: Fraction | None, levels: int
) -> LatticeElement:
    """Return the element (0, 0[, 0]) of a hexagonal lattice.

    Two pairs of sides have normals (√3, ±1) (exchanged for orientation "x"), the third pair has its normal along an
    axis. Columns are √3/2 of a pitch apart, and neighbours are shifted by half a pitch along them.
    """
    x, y, z = middle
    long, half, width = HALF_ROOT3 * pitch, HALF * pitch, pitch / ROOT3
    if orientation == "y":
        normals, wide, high = ((ROOT3, ONE), (ROOT3, -ONE), (ZERO, ONE)), width, half
        ways = [(long, half, ZERO), (ZERO, pitch, ZERO)]
    else:
        normals, wide, high = ((ONE, ROOT3), (ONE, -ROOT3), (ONE, ZERO)), half, width
        ways = [(pitch, ZERO, ZERO), (half, long, ZERO)]
    planes = []
    # Slanted normals have length 2, so half a pitch is 1 pitch in their units
    for (a, b), apothem in zip(normals, (pitch, pitch, half), strict=True):
        base = a * x + b * y
        planes += _slab((a, b, ZERO), base - apothem, base + apothem)
    # A hexagon reaches less than one way from its centre, so these bounds are safe
    (p, q, _), (r, s, _) = ways
    area = p * s - q * r
    across = (s / area, -r / area, ZERO), (-q / area, p / area, ZERO)
    reach = [(w, w[0] * x + w[1] * y - 1, w[0] * x + w[1] * y + 1) for w in across]
    bottom = top = None
    if axial_pitch is not None:
        # The levels are centred at the z of `middle`
        bottom, z = z - HALF * levels * axial_pitch, z + HALF * (1 - levels) * axial_pitch
        top = bottom + axial_pitch
        planes += _slab((ZERO, ZERO, ONE), bottom, top)
        ways.append((ZERO, ZERO, axial_pitch))
        reach.append(((ZERO, ZERO, 1 / axial_pitch), bottom / axial_pitch, top / axial_pitch))
    extent = Extent((x - wide, y - high, bottom), (x + wide, y + high, top))
    return LatticeElement(LatticePrism(tuple(planes), extent), (x, y, z), tuple(ways), tuple(reach))


def hexagon_order(rings: int, orientation: str) -> list[tuple[int, int]]:
    """Return the indices in the order in which a file lists a level: rows from the top, each from left to right."""
    reach = range(-rings + 1, rings)
    inside = [(i, j) for i, j in product(reach, reach) if abs(i + j) < rings]
    if orientation == "y":
        # y = a + x/2, here in halves of the pitch; x rises along a row.
        return sorted(inside, key=lambda index: (-(2 * index[1] + index[0]), index[0]))
    return sorted(inside, key=lambda index: (-index[1], index[0]))


def grid_indices(ends: list[tuple[int, int]]) -> Iterator[tuple[int, ...]]:
    """Yield all (i, j, ...) of ranges (first, end), lazily: there may be very many."""
    if not ends:
        yield ()
        return
    for i in range(*ends[0]):
        for rest in grid_indices(ends[1:]):
            yield (i, *rest)


def _slab(normal: Point, low: Fraction, high: Fraction) -> list[LatticePlane]:
    """Return the planes of low <= normal·x <= high."""
    x, y, z = normal
    return [((-x, -y, -z), -low), (normal, high)]


def _axis(axis: int, length: Fraction) -> Point:
    """Return a vector along an axis."""
    x, y, z = (length if i == axis else ZERO for i in range(3))
    return x, y, z


# Readers of OpenMC's lattice elements


def read_rectangular_lattice(element: XmlElement) -> RectangularLattice:
    """Return the lattice of a <lattice> element. Raise OpenmcElementError with all its errors."""
    values = OpenmcValues(element, "lattice")
    number, name = values.title()
    shape = values.attempt(lambda: _read_shape(values), None)
    # Without a shape the other values are not read, as their count is unknown
    axes = len(shape) if shape else 2
    lower_left = values.attempt(lambda: values.numbers("lower_left", axes), ()) if shape else ()
    pitch = values.attempt(lambda: _read_pitch(values, axes), ()) if shape else ()
    outer = values.attempt(lambda: values.optional_integer("outer"), None)
    universes: Counter[int] = Counter()
    if shape:
        count = shape[0] * shape[1] * (*shape, 1)[2]
        what = f"a lattice of {' x '.join(map(str, shape))}"
        universes = values.attempt(lambda: _read_universes(values, count, what), universes)
    values.finish()
    listing = values.require("universes")
    first = box_element(lower_left, pitch)
    return RectangularLattice(number, name, outer, universes, listing, element, first, shape or ())


def read_hexagonal_lattice(element: XmlElement) -> HexagonalLattice:
    """Return the lattice of a <hex_lattice> element. Raise OpenmcElementError with all its errors."""
    values = OpenmcValues(element, "lattice")
    number, name = values.title()
    rings, levels = values.attempt(lambda: _read_rings(values), (0, None))
    orientation = values.attempt(lambda: _read_orientation(values), "y")
    flat = levels is None
    outer = values.attempt(lambda: values.optional_integer("outer"), None)
    center: tuple[Fraction, ...] = ()
    pitch: tuple[Fraction, ...] = ()
    universes: Counter[int] = Counter()
    if rings:
        center = values.attempt(lambda: values.numbers("center", 2 if flat else 3), ())
        pitch = values.attempt(lambda: _read_pitch(values, 1 if flat else 2), ())
        # One in the middle, and 6 k in ring k
        count = (3 * rings * (rings - 1) + 1) * (levels or 1)
        what = f"a hexagonal lattice of {rings} rings" + ("" if flat else f" and {levels} levels")
        universes = values.attempt(lambda: _read_universes(values, count, what), universes)
    values.finish()
    x, y, z = (*center, Fraction(0))[:3]
    first = hexagon_element(orientation, (x, y, z), pitch[0], None if flat else pitch[1], levels or 1)
    return HexagonalLattice(
        number, name, outer, universes, values.require("universes"), element, first,
        rings, orientation, (x, y, z), pitch[0], levels,
    )  # fmt: skip


def _read_shape(values: OpenmcValues) -> tuple[int, ...] | None:
    shape = tuple(values.integers("dimension"))
    if len(shape) not in (2, 3) or min(shape) < 1:
        raise values.mistake(
            f"dimension must be two or three integers > 0, got {quote_word(values.require('dimension'))}"
        )
    return shape


def _read_rings(values: OpenmcValues) -> tuple[int, int | None]:
    rings, levels = values.integer("n_rings"), values.optional_integer("n_axial")
    if rings < 1 or (levels is not None and levels < 1):
        raise values.mistake(f"n_rings and n_axial must be > 0, got {rings if rings < 1 else levels}")
    return rings, levels


def _read_orientation(values: OpenmcValues) -> str:
    orientation = values.text("orientation") or "y"
    if orientation not in ("x", "y"):
        raise values.mistake(f"orientation must be x or y, got {quote_word(orientation)}")
    return orientation


def _read_pitch(values: OpenmcValues, count: int) -> tuple[Fraction, ...]:
    pitch = values.numbers("pitch", count)
    if min(pitch) <= 0:
        raise values.mistake(f"pitch must be > 0, got {float(min(pitch)):g}")
    return pitch


def _read_universes(values: OpenmcValues, count: int, what: str) -> Counter[int]:
    """Return how often each universe occurs; raise an error if their number is not `count`.

    The number is checked first, and no list of universes is built, as a file may name millions.
    """
    words = count_words(values.require("universes"))
    if words != count:
        raise values.mistake(f"universes: {what} needs {count}, got {words}")
    return values.integer_tally("universes")
