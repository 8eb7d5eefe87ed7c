"""Cells as the records that the expansion takes, by universe; lattices, and cells that only turn or move."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from fractions import Fraction

from ..openmc.geometry import Cell
from ..openmc.lattices import Index, Lattice
from ..openmc.placement import ORIGIN, STRAIGHT
from ..openmc.region import Half, Region, halves
from ..openmc.surface_kinds import NamedSurface
from ..openmc.surfaces import FlatSurface
from .cell_cards import CellCard
from .fillings import Entry, Filling, filling_of
from .lattices import CellLattice, Element0, Slab, hexagonal, index_order, parallelepiped
from .materials import BEYOND, Materials
from .numbers import integer, number
from .transformations import Change
from .vectors import cross, dot, scaled


@dataclass(frozen=True)
class NamelessCell(Cell):
    """A cell that a deck does not have, on behalf of one that it has."""

    owner: int = 0

    @property
    def step(self) -> tuple[str, ...]:
        return ()

    def __str__(self) -> str:
        return f"cell {self.owner}"


@dataclass
class Universes:
    """Cells by universe, and lattices, of all cells that are added."""

    surfaces: Mapping[int, NamedSurface]
    materials: Materials
    changes: Mapping[int, Change]
    cells: dict[int, list[Cell]] = field(default_factory=dict)
    lattices: dict[int, Lattice] = field(default_factory=dict)
    cards: list[CellCard] = field(default_factory=list)
    outside: list[int] = field(default_factory=list)
    root_outside: list[int] = field(default_factory=list)
    broken: set[int] = field(default_factory=set)
    refers: dict[int, tuple[CellCard, set[int]]] = field(default_factory=dict)
    wrapped: dict[tuple[int, Change], int] = field(default_factory=dict)
    made: int = 0

    def universe_of(self, cell: CellCard) -> int:
        """Its number; 0 for the world, and where it is no number."""
        words = cell.given.get("u")
        try:
            return abs(integer("u", words[0])) if words else 0
        except ValueError:
            return 0

    def add(self, cell: CellCard, region: Region | None, trcl: Change | None) -> None:
        """A cell with its region, which is moved already, but for a lattice. Raises ValueError."""
        words = cell.given.get("u", ["0"])
        if len(words) != 1:
            raise ValueError(f"u must be one integer, got {len(words)}")
        universe = abs(integer("u", words[0]))
        filling = filling_of(cell, self.changes)
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
        words = cell.given.get("lat")
        if words is None:
            return 0
        if words not in (["1"], ["2"]):
            raise ValueError("lat must be 1 (parallelepipeds) or 2 (hexagonal prisms)")
        return int(words[0])

    def _put(self, universe: int, cell: Cell) -> None:
        self.cells.setdefault(universe, []).append(cell)

    def _matter(self, cell: CellCard, universe: int, region: Region | None, key: int) -> Cell:
        material = None if not cell.material else self.materials.key(cell.material, cell.density or Fraction(1))
        args = (key, "", universe, region, None, (material,), ORIGIN, STRAIGHT, 0.0, cell.card.element)
        return Cell(*args) if key == cell.number else NamelessCell(*args, owner=cell.number)

    def _holder(
        self, cell: CellCard, universe: int, region: Region | None, fill: int, change: Change | None, key: int
    ) -> Cell:
        """A cell that is filled, what fills it being moved."""
        change = change or Change()
        args = (
            key, "", universe, region, fill, (), change.origin, change.rotation, change.skew, cell.card.element,
        )  # fmt: skip
        return Cell(*args) if key == cell.number else NamelessCell(*args, owner=cell.number)

    def _filled(
        self, cell: CellCard, universe: int, region: Region | None, filling: Filling, trcl: Change | None
    ) -> None:
        if filling.ranges:
            raise ValueError("fill: ranges are for lattices: lat is missing")
        ((fill, change),) = filling.entries
        if fill == universe:
            raise ValueError(f"is filled with the universe {fill} that it is in")
        self.refers[cell.number] = cell, {fill}
        self._put(universe, self._holder(cell, universe, region, fill, change or trcl, cell.number))

    def _lattice(
        self,
        cell: CellCard,
        universe: int,
        region: Region | None,
        filling: Filling | None,
        trcl: Change | None,
        kind: int,
    ) -> None:
        """A universe of one cell that the lattice fills; a transformation moves all of it, and what is in it."""
        first = _element(region, self.surfaces, kind)
        dimensions = len(first.ways)
        known = filling or Filling(((universe, None),))
        if trcl is not None and any(change is not None for _, change in known.entries):
            raise ValueError(
                "a lattice has a trcl, and a universe in it a transformation: how they go together is unclear"
            )
        ranges = known.ranges or ((0, 0),) * 3
        for axis in range(dimensions, 3):
            if ranges[axis][0] != ranges[axis][1]:
                raise ValueError(f"fill: the lattice has no planes across its direction {axis + 1}, and a range for it")
        found: dict[Index, int] = {}
        for index, entry in zip(index_order(list(ranges)), known.entries, strict=True):
            number = self._entry(cell, universe, entry)
            if number is not None:
                found[index] = number
        self.refers[cell.number] = cell, {u for u, _ in known.entries if u and u != universe}
        outer = None if known.ranges else next(iter(found.values()), None)
        key = self._key()
        tally = Counter(found.values())
        self.lattices[key] = CellLattice(key, "", outer, tally, "", cell.card.element, first, found, cell.number)
        self._put(universe, self._holder(cell, universe, None, key, trcl, cell.number))

    def _entry(self, cell: CellCard, universe: int, entry: Entry) -> int | None:
        """The universe of an element: 0 is none, the lattice's own is the lattice cell's material."""
        fill, change = entry
        if not fill:
            return None
        if fill == universe:
            change, fill = Change(), -cell.number
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
        self.made += 1
        return BEYOND + self.made

    def missing(self) -> Iterator[tuple[CellCard, str]]:
        """Universes that cells refer to and that there are not; and lattices that share a universe."""
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
        """A way round without the numbers that a deck does not have."""
        steps = [step for step in circle.split(" → ") if len(step) < 15 + len("universe ") - 5]
        return " → ".join(step for step in steps if "lattice" not in step)


def is_outside(cell: CellCard) -> bool:
    """Is the importance 0 for all particles for which it is given?"""
    given = [words for name, words in cell.given.items() if name.startswith("imp")]
    if any(len(words) != 1 for words in given):
        raise ValueError("imp must be one number")
    values = [number(words[0]) for words in given]
    return bool(values) and not any(values)


def _element(region: Region | None, surfaces: Mapping[int, NamedSurface], kind: int) -> Element0:
    """The element [0, 0, 0] of a lattice, by its planes in the order in which the cell names them."""
    sides = [] if region is None else list(halves(region))
    what = "a parallelepiped, of two, four or six planes" if kind == 1 else "a hexagonal prism, of six or eight planes"
    planes = [_plane(side, surfaces) for side in sides]
    is_plain = isinstance(region, Half) or (region is not None and all(isinstance(p, Half) for p in region.parts))
    if not is_plain or None in planes or len(planes) not in ((2, 4, 6) if kind == 1 else (6, 8)):
        raise ValueError(f"lat: the cell must be {what}")
    if not isinstance(region, Half) and type(region).__name__ != "Both":
        raise ValueError(f"lat: the cell must be {what}")
    slabs = []
    for i in range(0, len(planes), 2):
        first, second = planes[i], planes[i + 1]
        assert first is not None
        assert second is not None
        slabs.append(_slab(first, second))
    return parallelepiped(slabs) if kind == 1 else hexagonal(slabs)


def _plane(side: Half, surfaces: Mapping[int, NamedSurface]) -> FlatSurface | None:
    """With its normal out of the cell."""
    plane = surfaces[side.surface].surface
    if not isinstance(plane, FlatSurface):
        return None
    return FlatSurface(scaled(plane.normal, -1), -plane.offset) if side.positive else plane


def _slab(first: FlatSurface, second: FlatSurface) -> Slab:
    if any(cross(first.normal, second.normal)) or dot(first.normal, second.normal) >= 0:
        raise ValueError("lat: the planes must be listed in opposite pairs, for the directions 1, -1, 2, -2 and so on")
    times = dot(first.normal, first.normal) / -dot(first.normal, second.normal)
    low = -second.offset * times
    if low >= first.offset:
        raise ValueError("lat: there is nothing between two opposite planes")
    return Slab(first.normal, low, first.offset)
