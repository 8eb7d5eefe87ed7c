"""A geometry as its file says it: cells, universes and lattices, referring to each other by number."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from functools import cached_property

from ...shapes.properties import Properties
from .lattices import Lattice
from .material_reading import NamedMaterial
from .placement import STRAIGHT, Point, Rotation
from .region import Region
from .surface_kinds import NamedSurface
from .unread import Unread
from .values import titled
from .xml_tree import Element

VOID = "void"
"""What the material of empty cells is called."""
Node = tuple[str, int]
"""A universe or a lattice, by its number: ("universe", 3)."""


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

    @property
    def step(self) -> tuple[str, ...]:
        """What it is called on the way to what fills it."""
        return (f"cell {self.id}",)

    def __str__(self) -> str:
        return titled("cell", self.id, self.name)


@dataclass(frozen=True)
class Geometry:
    """All of a file, checked: every number that is referred to exists, and nothing contains itself."""

    surfaces: dict[int, NamedSurface]
    cells: dict[int, Cell]
    universes: dict[int, list[Cell]]
    lattices: dict[int, Lattice]
    materials: dict[int, NamedMaterial] | None  # None where there is no list of materials
    root: int
    counts: dict[Node, int]  # how many bodies a universe or a lattice has, all that fill it expanded
    element: Element = field(repr=False, compare=False)
    unread: tuple[Unread, ...] = ()
    world: Region | None = None  # where the root's cells are to be, where the file says that

    def lattice_of(self, cell: Cell) -> Lattice | None:
        """The lattice that fills a cell; universes come first where both have the number (as in OpenMC)."""
        if cell.fill is None or cell.fill in self.universes:
            return None
        return self.lattices[cell.fill]

    def count(self, universe: int) -> int:
        """How many bodies a universe has."""
        return self.counts["universe", universe]

    def count_in(self, cell: Cell) -> int:
        """How many bodies a cell gives in one place."""
        if cell.fill is None:
            return 1
        return self.counts["universe" if cell.fill in self.universes else "lattice", cell.fill]

    def material(self, number: int) -> NamedMaterial:
        """The material of a number; one without a name where there is no list of materials."""
        known = (self.materials or {}).get(number)
        return NamedMaterial(number, "", Properties({"id": number})) if known is None else known

    @cached_property
    def material_names(self) -> dict[int, str]:
        """What the material of each number is called, of those that cells have: no two alike, and none "void"."""
        used = {number for cell in self.cells.values() for number in cell.materials[:1] if number is not None}
        given = {number: self.material(number).name or f"material {number}" for number in sorted(used)}
        times = Counter([*given.values(), VOID])
        names: dict[int, str] = {}
        taken = {name for name, count in times.items() if count == 1} | {VOID}
        for number, name in given.items():
            names[number] = name
            while times[name] > 1 and names[number] in {*taken, name}:
                names[number] += f" (material {number})"
            taken.add(names[number])
        return names

    @property
    def body_count(self) -> int:
        """How many bodies there are at most, before those without volume are left out."""
        return self.count(self.root)

    def where_most_are(self, limit: int) -> Cell | Lattice | None:
        """What is filled so that there are more bodies than a limit, the innermost such; None if no filling does it."""
        found: Cell | Lattice | None = None
        universe = self.root
        while self.count(universe) > limit:
            cell = max(self.universes[universe], key=self.count_in)
            lattice = self.lattice_of(cell)
            if cell.fill is None:
                break
            found = cell if lattice is None else lattice
            inside = [cell.fill] if lattice is None else fillings(lattice)
            universe = max(inside, key=self.count)
        return found


def fillings(lattice: Lattice) -> Counter[int]:
    """How often each universe stands in a lattice, the outer one counted once."""
    return lattice.tally + Counter([] if lattice.outer is None else [lattice.outer])
