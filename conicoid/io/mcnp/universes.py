"""Universes of MCNP decks: fillings and transformations of cells, and lattices (LAT=1 boxes, LAT=2 hexagons).

`parallelepiped_element` and `hexagonal_element` find the translations from the planes of the cell, and `CellLattice` is
the lattice of these elements.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import field, replace
from fractions import Fraction
from functools import cached_property
from itertools import product

from ..._util.records import dataclass
from ...numerics.rational import cross, dot3
from ..openmc.geometry import UniverseCell
from ..openmc.lattices import Index, Lattice, LatticeElement, LatticePrism
from ..openmc.placement import NO_ROTATION, ORIGIN, Extent, ExtentEnd, Point
from ..openmc.region_expression import HalfSpaceNode, IntersectionNode, Region, list_half_spaces
from ..openmc.surfaces import FlatSurface, OpenmcSurface
from .cards import FIRST_FREE_KEY, MAX_ENTRIES, CellCard, McnpMaterials, expand_entries, parse_integer, parse_number
from .transformations import FrameChange, add_scaled, dual_vectors, parse_transformation, scale_vector

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
class CellLattice(Lattice):
    """A lattice of a cell, whose universes have their origins where the planes of element [0, 0, 0] have theirs."""

    entries: dict[Index, int] = field(repr=False)
    cell: int

    def __str__(self) -> str:
        return f"lattice of cell {self.cell}"

    @property
    def label(self) -> str:
        return "lattice"

    @cached_property
    def universes(self) -> dict[Index, int]:
        """The universe of each element that is not empty."""
        return self.entries

    def order(self) -> Iterable[Index]:
        """Return the indices of the elements."""
        return self.entries


def _slab_element(
    slabs: Iterable[LatticeSlab],
    ways: Iterable[Point],
    extent: Extent,
    reach: Iterable[tuple[Point, Fraction, Fraction]],
) -> LatticeElement:
    """Return the element between the planes of slabs."""
    planes = [
        plane for slab in slabs
        for plane in ((slab.normal, slab.high), (scale_vector(slab.normal, -1), -slab.low))
    ]  # fmt: skip
    return LatticeElement(LatticePrism(tuple(planes), extent), ORIGIN, tuple(ways), tuple(reach))


def parallelepiped_element(slabs: list[LatticeSlab]) -> LatticeElement:
    """Return the element of LAT=1 from one to three slabs. Raise ValueError if their directions depend."""
    across = _slab_duals(slabs)  # along w[i] only slab i changes
    ways = tuple(scale_vector(w, slab.high - slab.low) for w, slab in zip(across, slabs, strict=True))
    center = _sum_points(scale_vector(w, slab.middle) for w, slab in zip(across, slabs, strict=True))
    lows: list[ExtentEnd] = []
    highs: list[ExtentEnd] = []
    for axis in range(3):
        is_bounded = _is_in_span([slab.normal for slab in slabs], axis)
        # The box of a parallelepiped: half of each edge, to both sides of the centre
        half = sum((abs(way[axis]) for way in ways), Fraction(0)) / 2
        lows.append(center[axis] - half if is_bounded else None)
        highs.append(center[axis] + half if is_bounded else None)
    reach = tuple(
        (scale_vector(s.normal, 1 / (s.high - s.low)), s.low / (s.high - s.low), s.high / (s.high - s.low))
        for s in slabs
    )
    return _slab_element(slabs, ways, Extent((lows[0], lows[1], lows[2]), (highs[0], highs[1], highs[2])), reach)


def _is_in_span(normals: list[Point], axis: int) -> bool:
    """Return True if an axis is in the span of normals, so that their slabs bound it."""
    if len(normals) == 3:
        return True
    if len(normals) == 2:
        # Two slabs bound what lies in the plane of their normals
        return not cross(*normals)[axis]
    return not any(value for i, value in enumerate(normals[0]) if i != axis)


def hexagonal_element(slabs: list[LatticeSlab]) -> LatticeElement:
    """Return the element of LAT=2 from three slabs of sides and, if there is one, the slab of the ends.

    Raise ValueError if the sides make no hexagonal prism with a centre of symmetry.
    """
    a, b, c = slabs[:3]
    along = cross(a.normal, b.normal)
    # Exactly, since the sides are planes along one direction also in rounded decks
    if dot3(along, c.normal):
        raise ValueError("LAT=2: the sides of a hexagonal prism must have one direction in common")
    u, v = _slab_duals([a, b])
    center = add_scaled(scale_vector(u, a.middle), v, b.middle)
    off = dot3(c.normal, center) - c.middle
    # Decks hold a side of sqrt(3)/2 with a few digits
    if abs(off) > MAX_SKEW * c.half:
        raise ValueError("LAT=2: opposite sides of the hexagon must be as far from its centre as each other")
    # Equal to the file up to rounding, but exactly symmetric, so that elements fit without gaps.
    c = LatticeSlab(c.normal, c.low + off, c.high + off)
    # Three neighbouring corners; the other three are their opposites about the centre.
    corners = [_corner(a, b), _corner(b, c), _corner(c, LatticeSlab(scale_vector(a.normal, -1), -a.high, -a.low))]
    for corner, slab in zip(corners, (c, a, b), strict=True):
        # The corner of two sides lies outside the third slab where the order of the sides is another one
        if abs(dot3(slab.normal, corner)) >= slab.half:
            raise ValueError("LAT=2: the sides must be listed so that the fifth is between the third and the second")
    ways = [add_scaled(corners[0], corners[2], -1), add_scaled(corners[1], corners[0])]
    sides = [a, b, c]
    if len(slabs) > 3:
        end = slabs[3]
        rise = dot3(end.normal, along)
        if not rise:
            raise ValueError("LAT=2: the ends of a hexagonal prism must lie across its sides")
        center = add_scaled(center, along, (end.middle - dot3(end.normal, center)) / rise)
        corners = [add_scaled(p, along, -dot3(end.normal, p) / rise) for p in corners]
        ways.append(scale_vector(along, (end.high - end.low) / rise))
        sides.append(end)
    lows: list[ExtentEnd] = []
    highs: list[ExtentEnd] = []
    for axis in range(3):
        # Corners at half height; both ends lie half a way along the axis from there
        half = max(abs(p[axis]) for p in corners) + (abs(ways[2][axis]) / 2 if len(ways) > 2 else 0)
        is_bounded = len(ways) > 2 or not along[axis]
        lows.append(center[axis] - half if is_bounded else None)
        highs.append(center[axis] + half if is_bounded else None)
    extent = Extent((lows[0], lows[1], lows[2]), (highs[0], highs[1], highs[2]))
    # A hexagon reaches less than one way from its centre, so these bounds are safe.
    reach = tuple((d, dot3(d, center) - 1, dot3(d, center) + 1) for d in dual_vectors(ways))
    return _slab_element(sides, ways, extent, reach)


def _corner(a: LatticeSlab, b: LatticeSlab) -> Point:
    """Return the point where the upper sides of two slabs meet, relative to the centre."""
    u, v = _slab_duals([a, b])
    return add_scaled(scale_vector(u, a.half), v, b.half)


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


# Universes of MCNP decks: fillings of cells, transformations of cells, and lattices.
#
# `read_filling` and `read_trcl` read FILL and TRCL of a cell card. `UniverseBuilder` turns cells into the records of a
# `CellGeometry`. A universe in a lattice element that has a transformation of its own is wrapped into a new universe
# with one anonymous cell, which carries the transformation.

FillEntry = tuple[int, FrameChange | None]
"""A universe and its transformation, if it has one."""


@dataclass(frozen=True)
class CellFilling:
    """The filling of a cell: entries in the order of the index `ranges`; without ranges one entry that fills all."""

    entries: tuple[FillEntry, ...]
    ranges: tuple[tuple[int, int], ...] = ()


def read_transformation(words: list[str], degrees: bool, changes: Mapping[int, FrameChange]) -> FrameChange:
    """Return a transformation from the number of a TR card or from its entries.

    Number 0 is the identity. Raise ValueError for wrong entries and unknown numbers.
    """
    values = expand_entries(words)
    if len(values) != 1:
        return parse_transformation(values, degrees)
    key = parse_integer("a transformation", values[0] if values[0] is not None else "j")
    if not key:
        return FrameChange()
    if key not in changes:
        raise ValueError(f"the transformation tr{key} is not in the data block")
    return changes[key]


def read_trcl(cell: CellCard, changes: Mapping[int, FrameChange]) -> FrameChange | None:
    """Return the transformation of a cell (TRCL), or None. Raise ValueError if it is wrong."""
    parameter = cell.words("trcl")
    if parameter is None:
        return None
    words, degrees = parameter
    # "trcl=5" and "trcl=(5)" name a card, "trcl=(1 0 0)" is a displacement
    inner = words[1:-1] if words[:1] == ["("] and words[-1:] == [")"] else words
    if not inner or "(" in inner or ")" in inner:
        raise ValueError("trcl must be a number of a TR card, or numbers in parentheses")
    return read_transformation(inner, degrees, changes)


def read_filling(cell: CellCard, changes: Mapping[int, FrameChange]) -> CellFilling | None:
    """Return the filling of a cell (FILL), or None; universe 0 is no filling. Raise ValueError if it is wrong."""
    parameter = cell.words("fill")
    if parameter is None:
        return None
    words, degrees = parameter
    read = lambda inner: read_transformation(inner, degrees, changes)  # noqa: E731
    if ":" not in words:
        entries = _read_fill_entries(words, read)
        if len(entries) != 1:
            raise ValueError(
                f"fill must be one universe, or ranges such as 0:2 0:2 0:0 with universes, got {len(entries)}"
            )
        # Universe 0 is the world
        return None if not entries[0][0] else CellFilling(tuple(entries))
    ranges = []
    for axis in range(3):
        part = words[3 * axis : 3 * axis + 3]
        if len(part) < 3 or part[1] != ":":
            raise ValueError("fill: needs three ranges, such as 0:2 0:2 0:0")
        low, high = parse_integer("fill: a range", part[0]), parse_integer("fill: a range", part[2])
        if low > high:
            raise ValueError(f"fill: the range {low}:{high} is empty")
        ranges.append((low, high))
    # Before the list is read: three short ranges may ask for more elements than memory holds
    count = math.prod(high - low + 1 for low, high in ranges)
    if count > MAX_ENTRIES:
        raise ValueError(f"fill: {count:,} elements, at most {MAX_ENTRIES:,} are read")
    entries = _read_fill_entries(words[9:], read)
    if len(entries) != count:
        raise ValueError(f"fill: the ranges hold {count:,} universes, got {len(entries):,}")
    return CellFilling(tuple(entries), tuple(ranges))


def _read_fill_entries(words: list[str], read: Callable[[list[str]], FrameChange]) -> list[FillEntry]:
    """Return universes, each with the transformation in parentheses after it, if there is one."""
    entries: list[FillEntry] = []
    plain: list[str] = []

    def flush() -> None:
        # The universe before a parenthesis is prepended, as a shortcut after it may refer to it ("5 (1) 3r").
        before = [entries[-1][0]] if entries else []
        values = expand_entries([*map(str, before), *plain])[len(before) :]
        # nJ skips entries, and 0 is the default of FILL: there is no element
        entries.extend((abs(parse_integer("fill: a universe", value or Fraction(0))), None) for value in values)
        plain.clear()

    at = 0
    while at < len(words):
        if words[at] != "(":
            plain.append(words[at])
            at += 1
            continue
        if ")" not in words[at:]:
            raise ValueError("fill: a ')' is missing")
        end = words.index(")", at)
        flush()
        if not entries:
            raise ValueError("fill: a transformation needs a universe before it")
        entries[-1] = entries[-1][0], read(words[at + 1 : end])
        at = end + 1
    flush()
    if len(entries) > MAX_ENTRIES:
        raise ValueError(f"fill: has more than {MAX_ENTRIES:,} universes")
    return entries


# Cells and lattices as the records of a CellGeometry


@dataclass(frozen=True)
class AnonymousCell(UniverseCell):
    """A cell that the deck does not have, made for the cell `owner`; it adds nothing to paths."""

    owner: int = 0

    @property
    def step(self) -> tuple[str, ...]:
        """Nothing: paths name cells of the deck only."""
        return ()

    def __str__(self) -> str:
        return f"cell {self.owner}"


@dataclass
class UniverseBuilder:
    """Builder of the cells by universe and of the lattices of a deck.

    `outside` holds the cells of importance 0 and `root_outside` those among them outside universes; `broken` universes
    have cells that could not be read; `refers` holds the universes that each cell refers to; `wrapped` caches universes
    with a transformation.
    """

    surfaces: Mapping[int, OpenmcSurface]
    materials: McnpMaterials
    changes: Mapping[int, FrameChange]
    cells: dict[int, list[UniverseCell]] = field(default_factory=dict)
    lattices: dict[int, Lattice] = field(default_factory=dict)
    cards: list[CellCard] = field(default_factory=list)
    outside: list[int] = field(default_factory=list)
    root_outside: list[int] = field(default_factory=list)
    broken: set[int] = field(default_factory=set)
    refers: dict[int, tuple[CellCard, set[int]]] = field(default_factory=dict)
    wrapped: dict[tuple[int, FrameChange], int] = field(default_factory=dict)
    body_count: int = 0

    def universe_of(self, cell: CellCard) -> int:
        """Return the number of a cell's universe; 0 for the world, and if the card has no valid number."""
        words = cell.keywords.get("u")
        try:
            return abs(parse_integer("u", words[0])) if words else 0
        except ValueError:
            return 0

    def add(self, cell: CellCard, unmoved: Region | None, region: Region | None, trcl: FrameChange | None) -> None:
        """Add a cell.

        Parameters
        ----------
        cell
            The cell.
        unmoved, region
            Its region before and after `trcl` moved it; None for all of space.
        trcl
            Its transformation, which also moves its filling.

        Raises
        ------
        ValueError
            The filling or the lattice is wrong.

        """
        words = cell.keywords.get("u", ["0"])
        if len(words) != 1:
            raise ValueError(f"u must be one integer, got {len(words)} words")
        # A negative number says that nothing cuts the cell, which saves time in MCNP; the cell is the same
        universe = abs(parse_integer("u", words[0]))
        filling = read_filling(cell, self.changes)
        kind = self._lattice_kind(cell)
        # Particles end in a cell of importance 0: it is the outside world, and no body
        if is_outside(cell):
            self.outside.append(cell.number)
            if not universe:
                self.root_outside.append(cell.number)
            return
        if kind:
            self._lattice(cell, universe, (unmoved, region), filling, trcl, kind)
        elif filling is None:
            self._put(universe, self._matter(cell, universe, region, cell.number))
        else:
            self._filled(cell, universe, region, filling, trcl)

    def _lattice_kind(self, cell: CellCard) -> int:
        words = cell.keywords.get("lat")
        if words is None:
            return 0
        if words not in (["1"], ["2"]):
            raise ValueError("lat must be 1 (parallelepipeds) or 2 (hexagonal prisms)")
        return int(words[0])

    def _put(self, universe: int, cell: UniverseCell) -> None:
        self.cells.setdefault(universe, []).append(cell)

    def _matter(self, cell: CellCard, universe: int, region: Region | None, key: int) -> UniverseCell:
        """Return a cell with a material or void."""
        material = None if not cell.material else self.materials.key(cell.material, cell.density or Fraction(1))
        args = (key, "", universe, region, None, (material,), ORIGIN, NO_ROTATION, 0.0, cell.card.element)
        return UniverseCell(*args) if key == cell.number else AnonymousCell(*args, owner=cell.number)

    def _holder(
        self, cell: CellCard, universe: int, region: Region | None, fill: int, change: FrameChange | None, key: int
    ) -> UniverseCell:
        """Return a cell filled with a universe or lattice, which `change` moves."""
        change = change or FrameChange()
        args = (
            key, "", universe, region, fill, (), change.origin, change.rotation, change.skew, cell.card.element,
        )  # fmt: skip
        return UniverseCell(*args) if key == cell.number else AnonymousCell(*args, owner=cell.number)

    def _filled(
        self, cell: CellCard, universe: int, region: Region | None, filling: CellFilling, trcl: FrameChange | None
    ) -> None:
        if filling.ranges:
            raise ValueError("fill: ranges are for lattices: lat is missing")
        ((fill, change),) = filling.entries
        # Universes that fill each other in a longer circle are found when the geometry is checked
        if fill == universe:
            raise ValueError(f"is filled with the universe {fill} that it is in")
        self.refers[cell.number] = cell, {fill}
        # A transformation of the filling replaces that of the cell.
        self._put(universe, self._holder(cell, universe, region, fill, change or trcl, cell.number))

    def _lattice(
        self,
        cell: CellCard,
        universe: int,
        regions: tuple[Region | None, Region | None],
        filling: CellFilling | None,
        trcl: FrameChange | None,
        kind: int,
    ) -> None:
        """Add a lattice and the cell that it fills; a transformation moves the whole lattice with its content.

        A universe with a transformation of its own does not inherit that of the cell (the manual, on FILL): then the
        planes are moved, and each universe by itself. `regions` are those before and after `trcl`.
        """
        content = filling or CellFilling(((universe, None),))
        is_moved = trcl is not None and any(change is not None for _, change in content.entries)
        if is_moved:
            content = replace(content, entries=tuple((fill, change or trcl) for fill, change in content.entries))
            trcl = None
        first = _lattice_element(regions[is_moved], self.surfaces, kind)
        dimensions = len(first.ways)
        ranges = content.ranges or ((0, 0),) * 3
        # Without planes across a direction all elements along it are one
        for axis in range(dimensions, 3):
            if ranges[axis][0] != ranges[axis][1]:
                raise ValueError(f"fill: the lattice has no planes across its direction {axis + 1}, and a range for it")
        elements: dict[Index, int] = {}
        for index, entry in zip(index_order(list(ranges)), content.entries, strict=True):
            number = self._entry(cell, universe, entry)
            if number is not None:
                elements[index] = number
        self.refers[cell.number] = cell, {u for u, _ in content.entries if u and u != universe}
        # Without ranges the one entry fills the lattice without end.
        outer = None if content.ranges else next(iter(elements.values()), None)
        key = self._key()
        tally = Counter(elements.values())
        self.lattices[key] = CellLattice(key, "", outer, tally, "", cell.card.element, first, elements, cell.number)
        self._put(universe, self._holder(cell, universe, None, key, trcl, cell.number))

    def _entry(self, cell: CellCard, universe: int, entry: FillEntry) -> int | None:
        """Return the universe of an element; None for 0 (empty).

        The number of the lattice's own universe stands for the material of the lattice cell. Universes with a
        transformation, and this material, are wrapped into a new universe.
        """
        fill, change = entry
        if not fill:
            return None
        if fill == universe:  # negative numbers stand for the materials of lattice cells
            change, fill = FrameChange(), -cell.number
        elif change is None:
            return fill
        if (fill, change) not in self.wrapped:
            number = self.wrapped[fill, change] = self._key()
            if fill < 0:
                self._put(number, self._matter(cell, number, None, self._key()))
            else:
                self._put(number, self._holder(cell, number, None, fill, change, self._key()))
        return self.wrapped[fill, change]

    def _key(self) -> int:
        """Return a new number for a universe, cell or lattice that the deck does not number."""
        self.body_count += 1
        return FIRST_FREE_KEY + self.body_count

    def missing(self) -> Iterator[tuple[CellCard, str]]:
        """Yield errors, with their cells: unknown universes."""
        for cell, fills in self.refers.values():
            unknown = sorted(fills - self.cells.keys() - self.broken)
            if unknown:
                plural = "s" if len(unknown) > 1 else ""
                yield cell, f"fill: no cells are in the universe{plural} {', '.join(map(str, unknown[:10]))}"

    def crowded(self) -> Iterator[str]:
        """Yield remarks about lattices that share a universe with other cells."""
        for lattice in self.lattices.values():
            assert isinstance(lattice, CellLattice)
            card, universe = self.refers[lattice.cell][0].card, self.universe_of(self.refers[lattice.cell][0])
            # The manual wants a lattice to be alone, as it fills all of space where its FILL has no ranges
            if len(self.cells[universe]) > 1:
                what = "other cells are in its universe; a point in several is in the one listed first"
                yield f"line {card.line}: {lattice}: {what}"

    def readable(self, circle: str) -> str:
        """Return a circle of universes without the numbers that the deck does not have."""
        # Numbers of objects that the deck does not have (from FIRST_FREE_KEY on) are longer than any of its own.
        steps = [step for step in circle.split(" → ") if len(step) < 15 + len("universe ") - 5]
        return " → ".join(step for step in steps if "lattice" not in step)


def is_outside(cell: CellCard) -> bool:
    """Return True if the card has importances and all are 0. Raise ValueError if one is no number."""
    importances = [words for name, words in cell.keywords.items() if name.startswith("imp")]
    if any(len(words) != 1 for words in importances):
        raise ValueError(f"imp must be one number, got {max(map(len, importances))}")
    values = [parse_number(words[0]) for words in importances]
    # A cell may be outside for one particle only, as a filter is for photons; then it is a body
    return bool(values) and not any(values)


def _lattice_element(region: Region | None, surfaces: Mapping[int, OpenmcSurface], kind: int) -> LatticeElement:
    """Return the element [0, 0, 0] of a lattice, from its planes in the order in which the cell lists them."""
    sides = [] if region is None else list(list_half_spaces(region))
    what = "a parallelepiped, of two, four or six planes" if kind == 1 else "a hexagonal prism, of six or eight planes"
    planes = [_element_plane(side, surfaces) for side in sides]
    is_plain = isinstance(region, HalfSpaceNode) or (
        region is not None and all(isinstance(p, HalfSpaceNode) for p in region.parts)
    )
    if not is_plain or None in planes or len(planes) not in ((2, 4, 6) if kind == 1 else (6, 8)):
        raise ValueError(f"lat: the cell must be {what}")
    if not isinstance(region, HalfSpaceNode | IntersectionNode):
        raise ValueError(f"lat: the cell must be {what}")
    slabs = []
    for i in range(0, len(planes), 2):
        first, second = planes[i], planes[i + 1]
        assert first is not None
        assert second is not None
        slabs.append(_element_slab(first, second))
    return parallelepiped_element(slabs) if kind == 1 else hexagonal_element(slabs)


def _element_plane(side: HalfSpaceNode, surfaces: Mapping[int, OpenmcSurface]) -> FlatSurface | None:
    """Return the plane of a side with its normal out of the cell; None for other surfaces."""
    plane = surfaces[side.surface].surface
    if not isinstance(plane, FlatSurface):
        return None
    return FlatSurface(scale_vector(plane.normal, -1), -plane.offset) if side.positive else plane


def _element_slab(first: FlatSurface, second: FlatSurface) -> LatticeSlab:
    """Return the slab between two opposite planes. Raise ValueError if they are not opposite."""
    if any(cross(first.normal, second.normal)) or dot3(first.normal, second.normal) >= 0:
        raise ValueError("lat: the planes must be listed in opposite pairs, for the directions 1, -1, 2, -2 and so on")
    # Scale the second plane to minus the normal of the first.
    times = dot3(first.normal, first.normal) / -dot3(first.normal, second.normal)
    low = -second.offset * times
    if low >= first.offset:
        raise ValueError("lat: there is nothing between two opposite planes")
    return LatticeSlab(first.normal, low, first.offset)
