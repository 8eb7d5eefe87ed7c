"""Universes of MCNP decks: fillings of cells, transformations of cells, and lattices.

`read_filling` and `read_trcl` read FILL and TRCL of a cell card. `UniverseBuilder` turns cells into the records of a
`CellGeometry`. A universe in a lattice element that has a transformation of its own is wrapped into a new universe with
one anonymous cell, which carries the transformation.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from fractions import Fraction

from ..openmc.geometry import UniverseCell
from ..openmc.lattices import Index, Lattice
from ..openmc.placement import NO_ROTATION, ORIGIN
from ..openmc.region import HalfSpaceNode, IntersectionNode, Region, list_half_spaces
from ..openmc.surfaces import FlatSurface, OpenmcSurface
from .cards import FIRST_FREE_KEY, MAX_ENTRIES, CellCard, McnpMaterials, expand_entries, parse_integer, parse_number
from .lattices import CellLattice, LatticeElement, LatticeSlab, hexagonal_element, index_order, parallelepiped_element
from .transformations import FrameChange, cross, dot, parse_transformation, scale_vector

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
        entries.extend((abs(parse_integer("fill: a universe", _transformation_value(value))), None) for value in values)
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


def _transformation_value(value: Fraction | None) -> Fraction:
    """Return an entry that must not be skipped."""
    if value is None:
        raise ValueError("fill: jumps over a universe (nJ)")
    return value


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

    def add(self, cell: CellCard, region: Region | None, trcl: FrameChange | None) -> None:
        """Add a cell.

        Parameters
        ----------
        cell
            The cell.
        region
            Its region, already moved by `trcl`, except for lattices; None for all of space.
        trcl
            Its transformation, which also moves its filling.

        Raises
        ------
        ValueError
            The filling or the lattice is wrong.

        """
        words = cell.keywords.get("u", ["0"])
        if len(words) != 1:
            raise ValueError(f"u must be one integer, got {len(words)}")
        universe = abs(parse_integer("u", words[0]))
        filling = read_filling(cell, self.changes)
        kind = self._lattice_kind(cell)
        if is_outside(cell):
            self.outside.append(cell.number)
            if not universe:
                self.root_outside.append(cell.number)
            return
        if kind:
            self._lattice(cell, universe, region, filling, trcl, kind)
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
        if fill == universe:
            raise ValueError(f"is filled with the universe {fill} that it is in")
        self.refers[cell.number] = cell, {fill}
        # A transformation of the filling replaces that of the cell.
        self._put(universe, self._holder(cell, universe, region, fill, change or trcl, cell.number))

    def _lattice(
        self,
        cell: CellCard,
        universe: int,
        region: Region | None,
        filling: CellFilling | None,
        trcl: FrameChange | None,
        kind: int,
    ) -> None:
        """Add a lattice and the cell that it fills; a transformation moves the whole lattice with its content."""
        first = _lattice_element(region, self.surfaces, kind)
        dimensions = len(first.ways)
        known = filling or CellFilling(((universe, None),))
        if trcl is not None and any(change is not None for _, change in known.entries):
            raise ValueError(
                "a lattice has a trcl, and a universe in it a transformation: how they go together is unclear"
            )
        ranges = known.ranges or ((0, 0),) * 3
        for axis in range(dimensions, 3):
            if ranges[axis][0] != ranges[axis][1]:
                raise ValueError(f"fill: the lattice has no planes across its direction {axis + 1}, and a range for it")
        elements: dict[Index, int] = {}
        for index, entry in zip(index_order(list(ranges)), known.entries, strict=True):
            number = self._entry(cell, universe, entry)
            if number is not None:
                elements[index] = number
        self.refers[cell.number] = cell, {u for u, _ in known.entries if u and u != universe}
        # Without ranges the one entry fills the lattice without end.
        outer = None if known.ranges else next(iter(elements.values()), None)
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
        """Yield errors, with their cells: unknown universes, and lattices that share a universe with other cells."""
        for cell, fills in self.refers.values():
            unknown = sorted(fills - self.cells.keys() - self.broken)
            if unknown:
                plural = "s" if len(unknown) > 1 else ""
                yield cell, f"fill: no cells are in the universe{plural} {', '.join(map(str, unknown[:10]))}"
        owners = {lattice.cell for lattice in self.lattices.values() if isinstance(lattice, CellLattice)}
        for cells in self.cells.values():
            for own in cells:
                if own.id in owners and len(cells) > 1:
                    yield self.refers[own.id][0], "lat: a lattice must be the only cell of its universe"

    def readable(self, circle: str) -> str:
        """Return a circle of universes without the numbers that the deck does not have."""
        # Numbers of objects that the deck does not have (from FIRST_FREE_KEY on) are longer than any of its own.
        steps = [step for step in circle.split(" → ") if len(step) < 15 + len("universe ") - 5]
        return " → ".join(step for step in steps if "lattice" not in step)


def is_outside(cell: CellCard) -> bool:
    """Return True if the card has importances and all are 0. Raise ValueError if one is no number."""
    importances = [words for name, words in cell.keywords.items() if name.startswith("imp")]
    if any(len(words) != 1 for words in importances):
        raise ValueError("imp must be one number")
    values = [parse_number(words[0]) for words in importances]
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
    if any(cross(first.normal, second.normal)) or dot(first.normal, second.normal) >= 0:
        raise ValueError("lat: the planes must be listed in opposite pairs, for the directions 1, -1, 2, -2 and so on")
    # Scale the second plane to minus the normal of the first.
    times = dot(first.normal, first.normal) / -dot(first.normal, second.normal)
    low = -second.offset * times
    if low >= first.offset:
        raise ValueError("lat: there is nothing between two opposite planes")
    return LatticeSlab(first.normal, low, first.offset)
