"""From XML to a checked geometry: every mistake is collected, with its line."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import TypeVar

from ..errors import MOST, Problem, SceneFileError
from ..nodes import shortened
from .geometry import Cell, Geometry, filled_by
from .lattice_reading import read_hexagonal, read_rectangular
from .lattices import Lattice
from .placement import ORIGIN, STRAIGHT, Rotation, departure, rotation_by_angles, rotation_by_matrix
from .region import halves, parse_region
from .surface_kinds import NamedSurface, read_surface, titled
from .values import Mistake, Values, listed
from .xml_tree import Element, read_xml

MAX_NESTING = 100
"""Levels of universes within universes."""
Item = TypeVar("Item", NamedSurface, Cell, Lattice)


def read_geometry(path: str | os.PathLike[str]) -> Geometry:
    """The geometry of a geometry.xml, with the materials.xml beside it if there is one, or of a model.xml.

    Raises SceneFileError with every mistake found.
    """
    root = read_xml(path)
    if root.tag == "model":
        parts = root.all("geometry")
        if len(parts) != 1:
            found = f"holds {len(parts)} <geometry> elements, a model has one"
            raise SceneFileError(path, [Problem(root.line, root.column, "model", found)])
        listing = root.all("materials")
        materials = _materials(path, listing[0]) if listing else None
        return _Reader(path, materials).read(parts[0])
    if root.tag != "geometry":
        found = f"is <{shortened(root.tag)}>, not <geometry> or <model>"
        raise SceneFileError(path, [Problem(root.line, root.column, "root element", found)])
    beside = Path(path).with_name("materials.xml")
    return _Reader(path, _materials(beside, read_xml(beside)) if beside.is_file() else None).read(root)


def _materials(path: str | os.PathLike[str], listing: Element) -> dict[int, str]:
    """Number and name of each material."""
    names: dict[int, str] = {}
    problems = []
    for element in listing.all("material"):
        values = Values(element, "material")
        try:
            number = values.integer("id")
            if number in names:
                raise values.mistake(f"id {number} is taken by another material")
            names[number] = values.text("name") or ""
        except Mistake as mistake:
            problems.append(mistake.problem)
    if problems:
        raise SceneFileError(path, problems)
    return names


class _Reader:
    """Reads one geometry element."""

    def __init__(self, path: str | os.PathLike[str], materials: dict[int, str] | None) -> None:
        self.path = path
        self.materials = materials
        self.problems: list[Problem] = []
        self.universes: dict[int, list[Cell]] = {}
        self.surfaces: dict[int, NamedSurface] = {}
        self.lattices: dict[int, Lattice] = {}

    def read(self, root: Element) -> Geometry:
        for element in root.all("dagmc_universe"):
            self._report(element, "dagmc_universe", "is a mesh from a CAD program, which Conicoid cannot express")
        self.surfaces = self._each(root, "surface", read_surface)
        cells = self._each(root, "cell", read_cell)
        for cell in cells.values():
            self.universes.setdefault(cell.universe, []).append(cell)
        lattices = self._each(root, "lattice", read_rectangular)
        self.lattices = lattices | self._each(root, "hex_lattice", read_hexagonal, lattices)
        self._raise()
        for cell in cells.values():
            self._check_cell(cell)
        for lattice in self.lattices.values():
            self._check_lattice(lattice)
        if not cells:
            self._report(root, "geometry", "holds no cells")
        self._raise()
        counts = self._counts(root)
        return Geometry(self.surfaces, cells, self.universes, self.lattices, self.materials, self._root(root), counts)

    def _each(
        self, root: Element, tag: str, read: Callable[[Element], Item], others: dict[int, Item] | None = None
    ) -> dict[int, Item]:
        """All elements of a kind by their number; one number for each."""
        items: dict[int, Item] = {}
        for element in root.all(tag):
            try:
                item = read(element)
            except Mistake as mistake:
                self._add(mistake.problem)
                continue
            if item.id in items or item.id in (others or {}):
                self._report(element, str(item), f"id {item.id} is taken by another {tag.removeprefix('hex_')}")
            items[item.id] = item
        return items

    def _check_cell(self, cell: Cell) -> None:
        element = cell.element
        if cell.region is not None:
            unknown = sorted({half.surface for half in halves(cell.region)} - set(self.surfaces))
            if unknown:
                plural = "s" if len(unknown) > 1 else ""
                self._report(element, str(cell), f"region refers to unknown surface{plural} {listed(unknown)}")
        if cell.fill is not None and cell.fill not in self.universes and cell.fill not in self.lattices:
            self._report(element, str(cell), f"fill {cell.fill} is neither a universe nor a lattice")
        if self.materials is not None:
            for material in cell.materials:
                if material is not None and material not in self.materials:
                    self._report(element, str(cell), f"material {material} is not in the list of materials")
                    break

    def _check_lattice(self, lattice: Lattice) -> None:
        outer = () if lattice.outer is None else (lattice.outer,)
        unknown = sorted({*lattice.universes.values(), *outer} - set(self.universes))
        if unknown:
            plural = "s" if len(unknown) > 1 else ""
            self._report(lattice.element, str(lattice), f"refers to unknown universe{plural} {listed(unknown)}")

    def _root(self, root: Element) -> int:
        """The universe that fills nothing (OpenMC, find_root_universe)."""
        used = {fill for cells in self.universes.values() for cell in cells if (fill := cell.fill) is not None}
        for lattice in self.lattices.values():
            used |= {*lattice.universes.values()} | ({lattice.outer} if lattice.outer is not None else set())
        free = sorted(set(self.universes) - used)
        if len(free) != 1:
            found = f"universes {listed(free)} fill nothing" if free else "every universe fills something"
            self._report(root, "geometry", f"has no single root universe: {found}")
            self._raise()
        return free[0]

    def _counts(self, root: Element) -> dict[int, int]:
        """How many bodies each universe has; innermost first, without recursion. Refuses circles."""
        inside: dict[int, Counter[int]] = {}
        users: dict[int, list[int]] = {}
        for number, cells in self.universes.items():
            fills = Counter(u for cell in cells for u in filled_by(cell, self.universes, self.lattices))
            inside[number] = fills
            for fill in fills:
                users.setdefault(fill, []).append(number)
        waiting = {number: len(fills) for number, fills in inside.items()}
        ready = [number for number, count in waiting.items() if not count]
        counts: dict[int, int] = {}
        depth: dict[int, int] = {}
        while ready:
            number = ready.pop()
            own = sum(cell.fill is None for cell in self.universes[number])
            counts[number] = own + sum(times * counts[fill] for fill, times in inside[number].items())
            depth[number] = 1 + max((depth[fill] for fill in inside[number]), default=0)
            for user in users.get(number, ()):
                waiting[user] -= 1
                if not waiting[user]:
                    ready.append(user)
        if len(counts) < len(self.universes):
            self._report(root, "geometry", f"has universes that contain themselves: {self._circle(inside, counts)}")
        elif max(depth.values()) > MAX_NESTING:
            self._report(root, "geometry", f"nests universes deeper than {MAX_NESTING} levels")
        self._raise()
        return counts

    @staticmethod
    def _circle(inside: dict[int, Counter[int]], done: dict[int, int]) -> str:
        """One way round: universe 1 → universe 2 → universe 1."""
        number = min(set(inside) - set(done))
        way: list[int] = []
        while number not in way:
            way.append(number)
            number = min(fill for fill in inside[number] if fill not in done)
        return " → ".join(f"universe {u}" for u in [*way[way.index(number) :], number][:20])

    def _report(self, element: Element, where: str, message: str) -> None:
        self._add(Problem(element.line, element.column, where, message))

    def _add(self, problem: Problem) -> None:
        self.problems.append(problem)
        if len(self.problems) >= MOST:
            self._raise()

    def _raise(self) -> None:
        if self.problems:
            raise SceneFileError(self.path, self.problems)


def read_cell(element: Element) -> Cell:
    """Raises Mistake."""
    values = Values(element, "cell")
    number = values.integer("id")
    name = values.text("name") or ""
    values.where = titled("cell", number, name)
    if values.text("surfaces") is not None:
        raise values.mistake("has `surfaces`, an old form: write `region`")
    words, fill = values.words("material"), values.optional_integer("fill")
    if (words is None) == (fill is None):
        found = "neither" if fill is None else "both"
        raise values.mistake(f"needs either a material or a fill, got {found}")
    universe = values.optional_integer("universe") or 0
    if fill is not None and fill == universe:
        raise values.mistake(f"is filled with the universe {fill} that it is in")
    region = values.text("region")
    try:
        parsed = parse_region(region) if region else None
    except ValueError as error:
        raise values.mistake(str(error)) from None
    rotation, skew = _rotation(values, fill)
    translation = values.numbers("translation", 3) if values.text("translation") is not None else ORIGIN
    if fill is None and translation is not ORIGIN:
        raise values.mistake("is translated, but not filled with a universe or lattice")
    x, y, z = translation
    materials = _material_numbers(values, words)
    return Cell(number, name, universe, parsed, fill, materials, (x, y, z), rotation, skew, element)


def _material_numbers(values: Values, words: list[str] | None) -> tuple[int | None, ...]:
    if words is None:
        return ()
    if not words:
        raise values.mistake("material must be an integer, 'void', or several of these, got nothing")
    integer = values.integer_word
    return tuple(None if word.lower() == "void" else integer("material", word) for word in words)


def _rotation(values: Values, fill: int | None) -> tuple[Rotation, float]:
    """By three angles or nine entries, row by row; and how far those are from a rotation."""
    if values.text("rotation") is None:
        return STRAIGHT, 0.0
    if fill is None:
        raise values.mistake("is rotated, but not filled with a universe or lattice")
    numbers: tuple[Fraction, ...] = values.numbers("rotation", 3, 9)
    if len(numbers) == 3:
        x, y, z = numbers
        return rotation_by_angles((x, y, z)), 0.0
    a, b, c, d, e, f, g, h, i = numbers
    rows = ((a, b, c), (d, e, f), (g, h, i))
    rotation = rotation_by_matrix(rows)
    if rotation is None:
        raise values.mistake("rotation must be a matrix that can be inverted, its determinant is 0")
    return rotation, departure(rows)
