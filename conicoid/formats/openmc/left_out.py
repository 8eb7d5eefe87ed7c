"""What an import leaves out because it has no volume, counted so that it can be told."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field

from .geometry import Cell, Geometry
from .lattices import Lattice


@dataclass
class LeftOut:
    """How often each cell, and the elements of each lattice, were looked at and had no volume there."""

    cells: Counter[int] = field(default_factory=Counter)
    empty_cells: Counter[int] = field(default_factory=Counter)
    elements: Counter[int] = field(default_factory=Counter)
    empty_elements: Counter[int] = field(default_factory=Counter)

    def visit(self, item: Cell | Lattice, is_empty: bool) -> None:
        """One place of a cell, or of an element of a lattice."""
        seen, empty = (self.cells, self.empty_cells) if isinstance(item, Cell) else (self.elements, self.empty_elements)
        seen[item.id] += 1
        empty[item.id] += is_empty

    def add(self, other: LeftOut) -> None:
        """All places of another part of the model."""
        if not other.cells and not other.elements:
            return
        for mine, more in zip(vars(self).values(), vars(other).values(), strict=True):
            mine.update(more)

    @property
    def places(self) -> int:
        """Places of cells, and elements, that are left out."""
        return self.empty_cells.total() + self.empty_elements.total()

    def notes(self, geometry: Geometry) -> Iterator[str]:
        """A line for each cell and each lattice of which something is left out."""
        for number, empty in (+self.empty_cells).items():
            where = _where(empty, self.cells[number], "place")
            yield f"{geometry.cells[number]}: has no volume {where}, left out there"
        for number, empty in (+self.empty_elements).items():
            where = _where(empty, self.elements[number], "element")
            yield f"{where} of {geometry.lattices[number]} nothing lies in the cell around it, left out"


def _where(empty: int, seen: int, what: str) -> str:
    """in 3 of 264 places"""
    if empty == seen:
        return f"in its only {what}" if seen == 1 else f"in any of its {seen:,} {what}s"
    return f"in {empty:,} of {seen:,} {what}s"
