"""Rectangular and hexagonal lattices: their elements as prisms, the universes in them, and the space around them.

An element is a convex prism; a point in it is looked up in the element's universe relative to the element's center.
Outside the lattice the outer universe is repeated in the same way without end (OpenMC, "Geometry specification").
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

from ..._util.dataclass import dataclass
from ..xml_tree import XmlElement
from .placement import Extent, Point, UniversePlacement
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
class LatticeTiles:
    """Elements around a box: their number, or a bound on it, known before any is listed, and their indices."""

    count: int
    indices: Iterator[Index]


@dataclass(frozen=True)
class Lattice(ABC):
    """Universes on a grid. Indices are OpenMC's; those of hexagonal lattices count from the central element.

    `listing` is the text that names the universes. There may be millions, so that only the number of occurrences of
    each (`tally`) is computed until `universes` is used. `outer` is the universe outside the lattice, if any.
    """

    id: int
    name: str
    outer: int | None
    tally: Counter[int] = field(repr=False)
    listing: str = field(repr=False)
    element: XmlElement = field(repr=False, compare=False)

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

    @abstractmethod
    def center(self, index: Index) -> Point:
        """Return the center of an element inside or outside the lattice; z is 0 in two dimensions."""

    @abstractmethod
    def prism(self, index: Index) -> LatticePrism:
        """Return the prism of an element inside or outside the lattice."""

    @property
    @abstractmethod
    def hull(self) -> list[LatticePrism]:
        """Prisms whose union is the union of all elements."""

    @property
    @abstractmethod
    def steps(self) -> list[Point]:
        """Independent translations from an element to its neighbours."""

    @abstractmethod
    def tiles_around(self, extent: Extent) -> LatticeTiles | None:
        """Return all elements that reach into a box, and perhaps more; None if their number is infinite."""


@dataclass(frozen=True)
class RectangularLattice(Lattice):
    """A lattice of boxes: element (i, j[, k]) spans one pitch from lower_left + pitch (i, j[, k]), in 2 or 3 axes."""

    shape: tuple[int, ...]
    lower_left: tuple[Fraction, ...]
    pitch: tuple[Fraction, ...]

    def order(self) -> Iterable[Index]:
        """Return the indices level by level from the bottom, row by row from the top."""
        columns, rows, levels = (*self.shape, 1)[:3]
        flat = len(self.shape) == 2
        # The first row of a file is the one with the largest y, as it stands on paper
        for k, j, i in product(range(levels), reversed(range(rows)), range(columns)):
            yield (i, j) if flat else (i, j, k)

    def center(self, index: Index) -> Point:
        middle = [a + (i + HALF) * p for a, i, p in zip(self.lower_left, index, self.pitch, strict=True)]
        x, y, z = (*middle, ZERO)[:3]
        return x, y, z

    def prism(self, index: Index) -> LatticePrism:
        return self._box(index, tuple(i + 1 for i in index))

    @cached_property
    def hull(self) -> list[LatticePrism]:
        return [self._box((0,) * len(self.shape), self.shape)]

    def _box(self, first: Index, end: Index) -> LatticePrism:
        """Return the prism from the element `first` to before the element `end`, infinite in z for two axes."""
        low: list[Fraction | None] = [None] * 3
        high: list[Fraction | None] = [None] * 3
        planes = []
        for axis, (a, p) in enumerate(zip(self.lower_left, self.pitch, strict=True)):
            low[axis], high[axis] = a + first[axis] * p, a + end[axis] * p
            planes.append((_axis(axis, -ONE), -(a + first[axis] * p)))
            planes.append((_axis(axis, ONE), a + end[axis] * p))
        return LatticePrism(tuple(planes), Extent((low[0], low[1], low[2]), (high[0], high[1], high[2])))

    @property
    def steps(self) -> list[Point]:
        return [_axis(axis, p) for axis, p in enumerate(self.pitch)]

    def tiles_around(self, extent: Extent) -> LatticeTiles | None:
        ends: list[tuple[int, int]] = []
        for axis, (a, p) in enumerate(zip(self.lower_left, self.pitch, strict=True)):
            low, high = extent.low[axis], extent.high[axis]
            if low is None or high is None:
                return None
            # Exact: fractions leave no doubt whether an element touches the box.
            ends.append((math.floor((low - a) / p), math.ceil((high - a) / p)))
        count = math.prod(max(end - first, 0) for first, end in ends)
        return LatticeTiles(count, grid_indices(ends))


@dataclass(frozen=True)
class HexagonalLattice(Lattice):
    """A lattice of regular hexagons, `pitch` between opposite sides, in rings about the one at `middle`.

    Orientation "y": two sides are parallel to the x axis; element (x, a) is centered at
    middle + pitch (√3/2 x, a + x/2). Orientation "x": two sides are parallel to the y axis; element (a, y) is
    centered at middle + pitch (a + y/2, √3/2 y). With `axial_pitch` there are `levels` levels along z, centered at
    the z of `middle`. Source: OpenMC, HexLattice::get_local_position.
    """

    rings: int
    orientation: str
    middle: Point
    pitch: Fraction
    axial_pitch: Fraction | None
    levels: int

    def order(self) -> Iterable[Index]:
        """Return the indices level by level from the bottom, each level as in `hexagon_order`."""
        level = hexagon_order(self.rings, self.orientation)
        if self.axial_pitch is None:
            return level
        return ((i, j, k) for k in range(self.levels) for i, j in level)

    def center(self, index: Index) -> Point:
        i, j = index[:2]
        x, y, z = self.middle
        if self.axial_pitch is not None and index[2:]:
            # The levels are centred at the z of `middle`
            z += (index[2] + HALF * (1 - self.levels)) * self.axial_pitch
        if self.orientation == "y":
            return x + HALF_ROOT3 * i * self.pitch, y + (j + HALF * i) * self.pitch, z
        return x + (i + HALF * j) * self.pitch, y + HALF_ROOT3 * j * self.pitch, z

    def prism(self, index: Index) -> LatticePrism:
        return self._column(index, self._levels(index[2], index[2] + 1) if index[2:] else None)

    @cached_property
    def hull(self) -> list[LatticePrism]:
        """The hexagon through the centers of the outermost ring, which elements cover, and the prisms of that ring."""
        levels = None if self.axial_pitch is None else self._levels(0, self.levels)
        last = self.rings - 1
        ring = {index[:2] for index in self.universes if max(map(abs, (*index[:2], index[0] + index[1]))) == last}
        # The inner hexagon and the outermost ring cover all elements with far fewer planes than one prism for each.
        columns = [self._column(index, levels) for index in sorted(ring)]
        # One ring has no inner hexagon
        return columns if last == 0 else [self._inner(last, levels), *columns]

    def _levels(self, first: int, end: int) -> tuple[Fraction, Fraction]:
        """Return the heights of the bottom of level `first` and the bottom of level `end`."""
        step = self.axial_pitch or ZERO
        return self.middle[2] + (first - HALF * self.levels) * step, self.middle[2] + (end - HALF * self.levels) * step

    def _column(self, index: Index, levels: tuple[Fraction, Fraction] | None) -> LatticePrism:
        """Return the prism of one hexagon.

        Two pairs of sides have normals (√3, ±1) (exchanged for orientation "x"), the third pair has the normal along
        an axis; `height` is the distance of the third pair's middle from the center, in pitches.
        """
        i, j = index[:2]
        mx, my, _ = self.middle
        if self.orientation == "y":
            slanted = (((ROOT3, ONE), 2 * i + j), ((ROOT3, -ONE), i - j))
            straight, height = (ZERO, ONE), j + HALF * i
        else:
            slanted = (((ONE, ROOT3), i + 2 * j), ((ONE, -ROOT3), i - j))
            straight, height = (ONE, ZERO), i + HALF * j
        planes = []
        for (a, b), k in slanted:  # these normals have length 2, so half a pitch is 1 pitch in their units
            base = a * mx + b * my
            planes += _slab((a, b, ZERO), base + (k - 1) * self.pitch, base + (k + 1) * self.pitch)
        base = straight[0] * mx + straight[1] * my

        planes += _slab((*straight, ZERO), base + (height - HALF) * self.pitch, base + (height + HALF) * self.pitch)
        return self._between(planes, levels, self.center(index), self.pitch / ROOT3, HALF * self.pitch)

    def _inner(self, last: int, levels: tuple[Fraction, Fraction] | None) -> LatticePrism:
        """Return the hexagon through the centers of a ring; its sides are rotated by 30 degrees to an element's."""
        mx, my, _ = self.middle
        planes = []
        # With the rounded √3 of the elements, so that no sliver stays between hexagon and ring
        for normal, reach in (((ROOT3, 3 * ONE), 3), ((ROOT3, -3 * ONE), 3), ((ROOT3, ZERO), 3 * HALF)):
            a, b = normal if self.orientation == "y" else normal[::-1]
            base, way = a * mx + b * my, reach * last * self.pitch
            planes += _slab((a, b, ZERO), base - way, base + way)
        return self._between(planes, levels, self.middle, HALF_ROOT3 * last * self.pitch, last * self.pitch)

    def _between(
        self,
        planes: list[LatticePlane],
        levels: tuple[Fraction, Fraction] | None,
        center: Point,
        wide: Fraction,
        high: Fraction,
    ) -> LatticePrism:
        """Return the prism of side planes between levels.

        The box around it reaches `wide` along x and `high` along y from the center; exchanged for orientation "x".
        """
        reach_x, reach_y = (wide, high) if self.orientation == "y" else (high, wide)
        if levels is not None:
            planes = planes + _slab((ZERO, ZERO, ONE), *levels)
        bottom, top = levels or (None, None)
        x, y, _ = center
        return LatticePrism(tuple(planes), Extent((x - reach_x, y - reach_y, bottom), (x + reach_x, y + reach_y, top)))

    @property
    def steps(self) -> list[Point]:
        p, half, long = self.pitch, HALF * self.pitch, HALF_ROOT3 * self.pitch
        # Two steps of the plane, from a center to the centers of two neighbours, span all translations.
        level = [] if self.axial_pitch is None else [(ZERO, ZERO, self.axial_pitch)]
        if self.orientation == "y":
            return [(long, half, ZERO), (ZERO, p, ZERO), *level]
        return [(p, ZERO, ZERO), (half, long, ZERO), *level]

    def tiles_around(self, extent: Extent) -> LatticeTiles | None:
        """Return elements by columns (or rows) of hexagons, with one more neighbour on every side."""
        across, along = (0, 1) if self.orientation == "y" else (1, 0)
        low, high = (extent.low[across], extent.low[along]), (extent.high[across], extent.high[along])
        if low[0] is None or low[1] is None or high[0] is None or high[1] is None:
            return None
        levels = 0, 1
        if self.axial_pitch is not None:
            if extent.low[2] is None or extent.high[2] is None:
                return None
            bottom, _ = self._levels(0, 0)
            levels = _whole_steps(extent.low[2] - bottom, extent.high[2] - bottom, self.axial_pitch)
        # Columns are √3/2 of a pitch apart, and neighbours are shifted by half a pitch along them
        columns = _whole_steps(low[0] - self.middle[across], high[0] - self.middle[across], HALF_ROOT3 * self.pitch)
        first, last = low[1] - self.middle[along], high[1] - self.middle[along]
        most = max(math.ceil((last - first) / self.pitch) + 4, 0)
        count = max(levels[1] - levels[0], 0) * max(columns[1] - columns[0], 0) * most
        return LatticeTiles(count, self._indices(levels, columns, first, last))

    def _indices(
        self, levels: tuple[int, int], columns: tuple[int, int], first: Fraction, last: Fraction
    ) -> Iterator[Index]:
        """Yield the indices of elements in levels and columns, from `first` to `last` along each column."""
        for k, i in grid_indices([levels, columns]):
            level = () if self.axial_pitch is None else (k,)
            start, end = (math.floor(first / self.pitch - HALF * i) - 1, math.ceil(last / self.pitch - HALF * i) + 1)
            for j in range(start, end + 1):
                yield (i, j, *level) if self.orientation == "y" else (j, i, *level)


def hexagon_order(rings: int, orientation: str) -> list[tuple[int, int]]:
    """Return the indices in the order in which a file lists a level: rows from the top, each from left to right."""
    reach = range(-rings + 1, rings)
    inside = [(i, j) for i, j in product(reach, reach) if abs(i + j) < rings]
    if orientation == "y":
        # y = a + x/2, here in halves of the pitch; x rises along a row.
        return sorted(inside, key=lambda index: (-(2 * index[1] + index[0]), index[0]))
    return sorted(inside, key=lambda index: (-index[1], index[0]))


def _whole_steps(low: Fraction, high: Fraction, step: Fraction) -> tuple[int, int]:
    """Return the range (first, end) of whole steps that covers low to high, with one more step at each end."""
    return math.floor(low / step) - 1, math.ceil(high / step) + 2


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
    return RectangularLattice(number, name, outer, universes, listing, element, shape or (), lower_left, pitch)


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
    return HexagonalLattice(
        number, name, outer, universes, values.require("universes"), element,
        rings, orientation, (x, y, z), pitch[0], None if flat else pitch[1], levels or 1,
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
