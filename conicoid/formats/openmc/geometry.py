"""A geometry as its file says it: cells, universes and lattices, referring to each other by number."""

from __future__ import annotations

from dataclasses import dataclass, field

from .lattices import Lattice
from .placement import STRAIGHT, Point, Rotation
from .region import Region
from .surface_kinds import NamedSurface, titled
from .xml_tree import Element


@dataclass(frozen=True)
class Cell:
    """A region of a universe, with a material (None: void) or filled with a universe or lattice.

    `region` None is all of space. What fills is rotated, then translated.
    """

    id: int
    name: str
    universe: int
    region: Region | None
    fill: int | None
    materials: tuple[int | None, ...]
    translation: Point
    rotation: Rotation
    skew: float  # how far a given matrix is from a rotation
    element: Element = field(repr=False, compare=False)

    @property
    def is_rotated(self) -> bool:
        return self.rotation != STRAIGHT

    def __str__(self) -> str:
        return titled("cell", self.id, self.name)


@dataclass(frozen=True)
class Geometry:
    """All of a file, checked: every number that is referred to exists, and nothing contains itself."""

    surfaces: dict[int, NamedSurface]
    cells: dict[int, Cell]
    universes: dict[int, list[Cell]]
    lattices: dict[int, Lattice]
    materials: dict[int, str] | None  # names by number, None where there is no list of materials
    root: int
    counts: dict[int, int]  # how many bodies a universe has, all that fill it expanded

    def lattice_of(self, cell: Cell) -> Lattice | None:
        """The lattice that fills a cell; universes come first where both have the number (as in OpenMC)."""
        if cell.fill is None or cell.fill in self.universes:
            return None
        return self.lattices[cell.fill]

    @property
    def body_count(self) -> int:
        """How many bodies there are at most, before those without volume are left out."""
        return self.counts[self.root]


def filled_by(cell: Cell, universes: dict[int, list[Cell]], lattices: dict[int, Lattice]) -> list[int]:
    """The universes that a cell is filled with, one for each place where it stands."""
    if cell.fill is None:
        return []
    if cell.fill in universes:
        return [cell.fill]
    lattice = lattices[cell.fill]
    outer = [] if lattice.outer is None else [lattice.outer]
    return [*lattice.universes.values(), *outer]
