"""From XML to a checked geometry: every mistake is collected, with its line."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

from ..errors import MOST, Problem, SceneFileError
from ..nodes import shortened
from . import counting
from .cell_reading import read_cell
from .geometry import Cell, Geometry, Node, fillings
from .lattice_reading import read_hexagonal, read_rectangular
from .lattices import Lattice
from .material_reading import NamedMaterial, read_material
from .region import LONGEST_REGION, MAX_HALF_SPACES, halves
from .surface_kinds import NamedSurface, read_surface
from .unread import unread
from .values import Mistake, Values, listed
from .xml_tree import Element, read_xml

MAX_NESTING = 100
"""Levels of universes within universes."""
Item = TypeVar("Item", NamedSurface, Cell, Lattice)
Materials = dict[int, NamedMaterial]


def read_geometry(path: str | os.PathLike[str]) -> Geometry:
    """The geometry of a geometry.xml, with the materials.xml beside it if there is one, or of a model.xml.

    Raises SceneFileError with every mistake found, in both files.
    """
    looked_at: list[Element] = []
    geometry = _read(path, looked_at)
    names = (name for element in (geometry.element, *looked_at) for name in unread(element))
    return replace(geometry, unread=tuple(names))


def _read(path: str | os.PathLike[str], looked_at: list[Element]) -> Geometry:
    """The geometry; lists of materials are added to `looked_at`."""
    root = read_xml(path)
    if root.tag == "model":
        parts = root.all("geometry")
        if len(parts) != 1:
            found = f"holds {len(parts)} <geometry> elements, a model has one"
            raise SceneFileError(path, [Problem(root.line, root.column, "model", found)])
        listing = root.all("materials")
        looked_at += listing[:1]
        materials, problems = _materials(listing[0]) if listing else (None, [])
        return _Reader(path, None if problems else materials, problems).read(parts[0])
    if root.tag != "geometry":
        found = f"is <{shortened(root.tag)}>, not <geometry> or <model>"
        raise SceneFileError(path, [Problem(root.line, root.column, "root element", found)])
    beside = Path(path).with_name("materials.xml")
    if not beside.is_file():
        return _Reader(path, None, []).read(root)
    wrong = None
    try:
        looked_at.append(read_xml(beside))
        materials, problems = _materials(looked_at[0])
        if problems:
            raise SceneFileError(beside, problems)
    except SceneFileError as error:
        materials, wrong = None, error
    return _beside(path, root, materials, wrong)


def _beside(
    path: str | os.PathLike[str], root: Element, materials: Materials | None, wrong: SceneFileError | None
) -> Geometry:
    """The geometry with the list of materials beside it; with None where the list is wrong, as it may lack some."""
    try:
        geometry = _Reader(path, materials, []).read(root)
    except SceneFileError as error:
        if wrong is None:
            raise
        others = [Problem(0, 0, _place(wrong, problem), problem.message) for problem in wrong.problems]
        raise SceneFileError(path, [*others, *error.problems]) from None
    if wrong is not None:
        raise wrong
    return geometry


def _place(error: SceneFileError, problem: Problem) -> str:
    """materials.xml:3:5: material"""
    line = f":{problem.line}:{problem.column}" if problem.line else ""
    return f"{Path(error.path).name}{line}" + (f": {problem.where}" if problem.where else "")


def _materials(listing: Element) -> tuple[Materials, list[Problem]]:
    """The materials by number, and what is wrong."""
    found: Materials = {}
    problems: list[Problem] = []
    for element in listing.all("material"):
        try:
            material = read_material(element)
            if material.id in found:
                raise Values(element, "material").mistake(f"id {material.id} is taken by another material")
            found[material.id] = material
        except Mistake as mistake:
            problems.extend(mistake.problems)
        if len(problems) >= MOST:
            break
    return found, problems[:MOST]


class _Reader:
    """Reads one geometry element."""

    def __init__(self, path: str | os.PathLike[str], materials: Materials | None, problems: list[Problem]) -> None:
        self.path = path
        self.materials = materials
        self.problems = list(problems)
        self.universes: dict[int, list[Cell]] = {}
        self.surfaces: dict[int, NamedSurface] = {}
        self.lattices: dict[int, Lattice] = {}
        self.half_spaces = 0
        self.broken: dict[str, set[int]] = {"surface": set(), "universe": set(), "lattice": set()}

    def read(self, root: Element) -> Geometry:
        for element in root.all("dagmc_universe"):
            self._report(element, "dagmc_universe", "is a mesh from a CAD program, which Conicoid cannot express")
            self._note_broken(element, "universe", "id")
        self.surfaces = self._each(root, "surface", read_surface)
        found = len(self.problems)
        cells = self._each(root, "cell", self._cell)
        for cell in cells.values():
            self.universes.setdefault(cell.universe, []).append(cell)
        lattices = self._each(root, "lattice", read_rectangular)
        self.lattices = lattices | self._each(root, "hex_lattice", read_hexagonal, lattices)
        whole = len(self.problems) == found and not self.broken["universe"]
        for cell in cells.values():
            whole = self._check_cell(cell) and whole
        for lattice in self.lattices.values():
            whole = self._check_lattice(lattice) and whole
        if not root.all("cell") and not self.problems:
            self._report(root, "geometry", "holds no cells")
        counts = self._counts(root)
        number = self._root(root, counts) if whole and cells else 0
        self._raise()
        return Geometry(self.surfaces, cells, self.universes, self.lattices, self.materials, number, counts, root)

    def _cell(self, element: Element) -> Cell:
        """A cell; what is known of a broken one is kept, so that nothing is said against those that refer to it."""
        try:
            cell = read_cell(element, min(LONGEST_REGION, MAX_HALF_SPACES - self.half_spaces))
        except Mistake:
            self._note_broken(element, "universe", "universe")
            raise
        self.half_spaces += 0 if cell.region is None else sum(1 for _ in halves(cell.region))
        return cell

    def _note_broken(self, element: Element, kind: str, name: str) -> None:
        values = Values(element, kind)
        number = values.attempt(lambda: values.optional_integer(name), 0)
        self.broken[kind].add(number or 0)

    def _each(
        self, root: Element, tag: str, read: Callable[[Element], Item], others: dict[int, Item] | None = None
    ) -> dict[int, Item]:
        """All elements of a kind by their number; one number for each."""
        items: dict[int, Item] = {}
        kind = tag.removeprefix("hex_")
        for element in root.all(tag):
            try:
                item = read(element)
            except Mistake as mistake:
                if kind in self.broken:
                    self._note_broken(element, kind, "id")
                for problem in mistake.problems:
                    self._add(problem)
                continue
            if item.id in items or item.id in (others or {}):
                self._report(element, str(item), f"id {item.id} is taken by another {kind}")
            items[item.id] = item
        return items

    def _check_cell(self, cell: Cell) -> bool:
        """Whether what fills it is there."""
        element = cell.element
        if cell.region is not None:
            found = {half.surface for half in halves(cell.region)}
            unknown = sorted(found - self.surfaces.keys() - self.broken["surface"])
            if unknown:
                plural = "s" if len(unknown) > 1 else ""
                self._report(element, str(cell), f"region refers to unknown surface{plural} {listed(unknown)}")
        is_there = cell.fill is None or self._is_fill(cell.fill)
        if not is_there:
            self._report(element, str(cell), f"fill {cell.fill} is neither a universe nor a lattice")
        if self.materials is not None:
            for material in cell.materials:
                if material is not None and material not in self.materials:
                    self._report(element, str(cell), f"material {material} is not in the list of materials")
                    break
        return is_there

    def _is_fill(self, number: int) -> bool:
        return (
            number in self.universes or number in self.lattices
            or number in self.broken["universe"] or number in self.broken["lattice"]
        )  # fmt: skip

    def _check_lattice(self, lattice: Lattice) -> bool:
        """Whether all universes in it are there."""
        unknown = sorted(fillings(lattice).keys() - self.universes.keys() - self.broken["universe"])
        if unknown:
            plural = "s" if len(unknown) > 1 else ""
            self._report(lattice.element, str(lattice), f"refers to unknown universe{plural} {listed(unknown)}")
        return not unknown

    def _root(self, root: Element, counts: dict[Node, int]) -> int:
        """The universe that fills nothing (OpenMC, find_root_universe)."""
        used = {fill for cells in self.universes.values() for cell in cells if (fill := cell.fill) is not None}
        for lattice in self.lattices.values():
            used |= fillings(lattice).keys()
        free = sorted(set(self.universes) - used)
        if len(free) == 1:
            return free[0]
        if free:
            self._report(root, "geometry", f"has no single root universe: universes {listed(free)} fill nothing")
        elif counts:  # else there is a circle, which is told
            self._report(root, "geometry", "has no single root universe: every universe fills something")
        return 0

    def _counts(self, root: Element) -> dict[Node, int]:
        """How many bodies each universe and each lattice has. Tells of circles and of too many levels."""
        inside = counting.links(self.universes, self.lattices)
        order = counting.in_order(inside)
        circle = counting.circle(inside, order)
        if circle:
            self._report(root, "geometry", f"has universes that contain themselves: {circle}")
            return {}
        if counting.depth(inside, order) > MAX_NESTING:
            self._report(root, "geometry", f"nests universes deeper than {MAX_NESTING} levels")
            return {}
        return counting.bodies(self.universes, inside, order)

    def _report(self, element: Element, where: str, message: str) -> None:
        self._add(Problem(element.line, element.column, where, message))

    def _add(self, problem: Problem) -> None:
        self.problems.append(problem)
        if len(self.problems) >= MOST:
            self._raise()

    def _raise(self) -> None:
        if self.problems:
            raise SceneFileError(self.path, self.problems)
