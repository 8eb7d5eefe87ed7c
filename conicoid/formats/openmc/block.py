"""What an element of a lattice becomes, worked out once and placed wherever it is the same.

An element from which the cells around it cut what they cut from another is that other one, moved. Its block has the
bodies as they are about its centre, and blocks within it with their shifts. Shifts are fractions, so that a body
has the numbers that it would have if it had been worked out at its place.
"""

from __future__ import annotations

from bisect import bisect_right
from collections import Counter
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from itertools import accumulate
from typing import ClassVar, TypeAlias

import numpy as np

from ...shapes.material import Material
from ...shapes.repeated import Ints, Shifts
from .context import Context
from .left_out import LeftOut
from .placement import ORIGIN, Point

Path: TypeAlias = tuple[str, ...]


@dataclass(eq=False)
class Piece:
    """A cell in its surroundings, as it is about the centre of its block."""

    cell: int
    title: str
    path: Path
    context: Context
    material: Material

    count: ClassVar[int] = 1


@dataclass(eq=False)
class Placed:
    """A block within another."""

    block: Block
    shift: Point
    path: Path

    @property
    def count(self) -> int:
        """How many bodies it has."""
        return self.block.count


@dataclass(eq=False)
class Block:
    """Pieces, and blocks within, in the order of their bodies; and what was counted on the way."""

    items: list[Piece | Placed] = field(default_factory=list)
    count: int = 0
    materials: Counter[int | None] = field(default_factory=Counter)
    left_out: LeftOut = field(default_factory=LeftOut)

    def add(self, piece: Piece, material: int | None) -> None:
        """A body of a material."""
        self.items.append(piece)
        self.count += 1
        self.materials[material] += 1

    def place(self, block: Block, shift: Point, path: Path) -> None:
        """All bodies of another block, moved."""
        if block.count:
            self.items.append(Placed(block, shift, path))
        self.count += block.count
        self.materials.update(block.materials)
        self.left_out.add(block.left_out)

    @cached_property
    def _ends(self) -> list[int]:
        """The number after the last body of each item. To be asked for when all are there."""
        return list(accumulate(item.count for item in self.items))

    def at(self, number: int) -> tuple[Piece, Path]:
        """The piece that a body is, and the way to it."""
        block: Block = self
        way: Path = ()
        while True:
            which = bisect_right(block._ends, number)
            item = block.items[which]
            if isinstance(item, Piece):
                return item, (*way, *item.path)
            number -= block._ends[which] - item.count
            block, way = item.block, (*way, *item.path)

    def find(self, name: str, way: Path = ()) -> int | None:
        """The number of the body of a name, if there is one; `way` leads to this block."""
        for end, item in zip(self._ends, self.items, strict=True):
            path = (*way, *item.path)
            if isinstance(item, Piece):
                if placed_name(item.title, path) == name:
                    return end - 1
            elif f" @ {', '.join(path)}" in name:
                found = item.block.find(name, path)
                if found is not None:
                    return end - item.count + found
        return None


def placed_name(title: str, path: Path) -> str:
    """What a cell is called at a place: "cell 5 'fuel' @ cell 9, lattice 2 [3, 4]"."""
    return f"{title} @ {', '.join(path)}" if path else title


@dataclass
class Flat:
    """The bodies of a block one after the other: which piece each is, and its shift."""

    pieces: Ints
    shifts: Shifts


def flattened(block: Block) -> tuple[list[Piece], Flat]:
    """All pieces that there are, and the bodies of a block."""
    pieces: list[Piece] = []
    known: dict[int, Flat] = {}
    pending = [block]
    while pending:  # no recursion: universes may be many levels deep
        last = pending[-1]
        inner = [item.block for item in last.items if isinstance(item, Placed) and id(item.block) not in known]
        if inner:
            pending.append(inner[0])
            continue
        known[id(pending.pop())] = _flat(last, pieces, known)
    return pieces, known[id(block)]


def _flat(block: Block, pieces: list[Piece], known: dict[int, Flat]) -> Flat:
    """One block, those within being known."""
    tables: list[dict[Fraction, int]] = [{}, {}, {}]
    numbers: list[Ints] = [np.zeros(0, np.int32)]
    index: list[Ints] = [np.zeros((3, 0), np.int32)]
    for item in block.items:
        if isinstance(item, Piece):
            pieces.append(item)
            numbers.append(np.array([len(pieces) - 1], np.int32))
            at = [table.setdefault(shift, len(table)) for table, shift in zip(tables, ORIGIN, strict=True)]
            index.append(np.array(at, np.int32)[:, None])
            continue
        flat = known[id(item.block)]
        numbers.append(flat.pieces)
        rows = []
        for table, values, row, shift in zip(tables, flat.shifts.values, flat.shifts.index, item.shift, strict=True):
            moved = np.array([table.setdefault(value + shift, len(table)) for value in values], np.int32)
            rows.append(moved[row])
        index.append(np.array(rows))
    x, y, z = (tuple(table) for table in tables)
    return Flat(np.concatenate(numbers), Shifts((x, y, z), np.concatenate(index, axis=1)))
