"""What stands at many places, worked out once: a block of bodies, and of blocks within, each with its shift.

An element of a lattice from which the cells around it cut what they cut from another is that other one, moved; and so
is a volume of GDML. A block has the bodies as they are about its centre. Shifts are fractions, so that a body has the
numbers that it would have if it had been worked out at its place.
"""

from __future__ import annotations

from bisect import bisect_right
from collections import Counter
from collections.abc import Hashable
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from itertools import accumulate
from typing import Any, ClassVar, Generic, TypeAlias, TypeVar

import numpy as np

from ...shapes.material import Material
from ...shapes.repeated import Ints, Shifts
from .context import Context
from .left_out import LeftOut
from .placement import ORIGIN, Point

Path: TypeAlias = tuple[str, ...]


@dataclass(eq=False)
class Piece:
    """A body at each place of its block, with the way to it in the block."""

    title: str
    path: Path
    material: Material

    count: ClassVar[int] = 1

    @property
    def form(self) -> Hashable:
        """Pieces of one form are one another, in their blocks."""
        return id(self)


@dataclass(eq=False)
class CellPiece(Piece):
    """A cell in its surroundings, as it is about the centre of its block."""

    cell: int
    context: Context

    @property
    def form(self) -> Hashable:
        """A pin that nothing cuts is as any other, whatever is cut of what is around it."""
        return self.cell, self.context


P = TypeVar("P", bound=Piece)


@dataclass(eq=False, slots=True)
class Placed(Generic[P]):
    """A block within another."""

    block: Block[P]
    shift: Point
    path: Path

    @property
    def count(self) -> int:
        """How many bodies it has."""
        return self.block.count


@dataclass(eq=False)
class Block(Generic[P]):
    """Pieces, and blocks within, in the order of their bodies; and what was counted on the way."""

    items: list[P | Placed[P]] = field(default_factory=list)
    count: int = 0
    materials: Counter[Any] = field(default_factory=Counter)
    left_out: LeftOut = field(default_factory=LeftOut)

    def add(self, piece: P, material: Any) -> None:
        """A body of a material."""
        self.items.append(piece)
        self.count += 1
        self.materials[material] += 1

    def place(self, block: Block[P], shift: Point, path: Path) -> None:
        """All bodies of another block, moved."""
        if block.count:
            self.items.append(Placed(block, shift, path))
        self.count += block.count
        for material, times in block.materials.items():
            self.materials[material] += times
        self.left_out.add(block.left_out)

    def take(self, other: Block[P]) -> None:
        """All items of another block, which is none of its own."""
        self.items += other.items
        self.count += other.count
        self.materials.update(other.materials)
        self.left_out.add(other.left_out)

    @cached_property
    def _ends(self) -> list[int]:
        """The number after the last body of each item. To be asked for when all are there."""
        return list(accumulate(item.count for item in self.items))

    def at(self, number: int) -> tuple[P, Path]:
        """The piece that a body is, and the way to it."""
        block: Block[P] = self
        way: Path = ()
        while True:
            which = bisect_right(block._ends, number)
            item = block.items[which]
            if not isinstance(item, Placed):
                return item, (*way, *item.path)
            number -= block._ends[which] - item.count
            block, way = item.block, (*way, *item.path)

    def find(self, name: str, way: Path = ()) -> int | None:
        """The number of the body of a name, if there is one; `way` leads to this block."""
        for end, item in zip(self._ends, self.items, strict=True):
            path = (*way, *item.path)
            if not isinstance(item, Placed):
                if self.called(item.title, path) == name:
                    return end - 1
            elif self.may_lead(path, name):
                found = item.block.find(name, path)
                if found is not None:
                    return end - item.count + found
        return None

    @staticmethod
    def called(title: str, path: Path) -> str:
        """The name of a piece at the end of a way."""
        return placed_name(title, path)

    @staticmethod
    def may_lead(path: Path, name: str) -> bool:
        """May the body of a name be in the block at the end of a way?"""
        return f" @ {', '.join(path)}" in name


def placed_name(title: str, path: Path) -> str:
    """What a cell is called at a place: "cell 5 'fuel' @ cell 9, lattice 2 [3, 4]"."""
    return f"{title} @ {', '.join(path)}" if path else title


@dataclass
class Flat:
    """The bodies of a block one after the other: which piece each is, and its shift."""

    pieces: Ints
    shifts: Shifts


def flattened(block: Block[P]) -> tuple[list[P], Flat]:
    """The different pieces that there are, and the bodies of a block."""
    pieces: list[P] = []
    forms: dict[Hashable, int] = {}
    known: dict[int, Flat] = {}
    pending = [block]
    while pending:  # no recursion: universes may be many levels deep
        last = pending[-1]
        inner = (item.block for item in last.items if isinstance(item, Placed) and id(item.block) not in known)
        first = next(inner, None)
        if first is not None:
            pending.append(first)
            continue
        known[id(pending.pop())] = _flat(last, pieces, forms, known)
    return pieces, known[id(block)]


def _flat(block: Block[P], pieces: list[P], forms: dict[Hashable, int], known: dict[int, Flat]) -> Flat:
    """One block, those within being known."""
    tables: list[dict[tuple[int, int], int]] = [{}, {}, {}]  # not by fractions, which are slow to look up
    numbers, index = np.empty(block.count, np.int32), np.empty((3, block.count), np.int32)
    begin = 0
    for item in block.items:
        end = begin + item.count
        if isinstance(item, Placed):
            flat, shift = known[id(item.block)], item.shift
            numbers[begin:end] = flat.pieces
            shifts = flat.shifts.values, flat.shifts.index
        else:
            numbers[begin] = forms.setdefault(item.form, len(pieces))
            if numbers[begin] == len(pieces):
                pieces.append(item)
            shift, shifts = ORIGIN, _UNMOVED
        for axis, (table, values, row) in enumerate(zip(tables, *shifts, strict=True)):
            by = shift[axis]
            moved = values if not by else [value + by if value else by for value in values]
            places = [table.setdefault(value.as_integer_ratio(), len(table)) for value in moved]
            index[axis, begin:end] = places[0] if len(places) == 1 else np.array(places, np.int32)[row]
        begin = end
    x, y, z = (tuple(Fraction(*ratio) for ratio in table) for table in tables)
    return Flat(numbers, Shifts((x, y, z), index))


_UNMOVED = ((Fraction(0),),) * 3, np.zeros((3, 1), np.int32)
