"""OpenMC's cell elements."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import TypeVar

from ..._util.file_errors import MAX_LISTED_PROBLEMS, MAX_PROBLEMS, Problem, SceneFileError
from ...materials.material import Material
from ..importers import (
    BodyLimits,
    ImportOptions,
    ImportResult,
    LegendEntry,
    format_count,
    limit_notes,
    palette_color,
    select_bodies,
)
from ..scene_file.nodes import shorten
from ..xml_tree import XmlElement, read_xml
from . import geometry
from .expansion import ExpansionProgress, UniverseExpansion
from .geometry import CellGeometry, UniverseCell, UniverseNode, lattice_fillings
from .lattices import Lattice, read_hexagonal_lattice, read_rectangular_lattice
from .materials import OpenmcMaterial, read_material
from .placement import NO_ROTATION, ORIGIN, CellRotation, Point, rotation_by_angles, rotation_by_matrix, rotation_error
from .region import LONGEST_REGION, MAX_HALF_SPACES, Region, list_half_spaces, parse_region
from .surfaces import OpenmcSurface, read_surface
from .values import OpenmcElementError, OpenmcValues, find_unknown_names, join_limited


def read_cell(element: XmlElement, most: int = MAX_HALF_SPACES) -> UniverseCell:
    """A cell whose region has at most so many half-spaces. Raises Mistake."""
    values = OpenmcValues(element, "cell")
    number, name = values.title()
    materials = values.attempt(lambda: _cell_materials(values), ())
    fill = values.attempt(lambda: values.optional_integer("fill"), None)
    is_filled = values.text("fill") is not None
    if is_filled == (values.text("material") is not None):
        values.tell(f"needs either a material or a fill, got {'both' if is_filled else 'neither'}")
    universe = values.attempt(lambda: values.optional_integer("universe"), None) or 0
    if fill is not None and fill == universe:
        values.tell(f"is filled with the universe {fill} that it is in")
    region = values.attempt(lambda: _cell_region(values, most), None)
    rotation, skew = values.attempt(lambda: _cell_rotation(values), (NO_ROTATION, 0.0))
    translation = values.attempt(lambda: _cell_translation(values), ORIGIN)
    if values.text("material") is not None and not is_filled:
        for what, attribute in (("rotated", "rotation"), ("translated", "translation")):
            if values.text(attribute) is not None:
                values.tell(f"is {what}, but not filled with a universe or lattice")
    values.finish()
    return UniverseCell(number, name, universe, region, fill, materials, translation, rotation, skew, element)


def _cell_region(values: OpenmcValues, most: int) -> Region | None:
    if values.text("surfaces") is not None:
        raise values.mistake("has `surfaces`, an old form: write `region`")
    region = values.text("region")
    try:
        return parse_region(region, most) if region else None
    except ValueError as error:
        raise values.mistake(str(error)) from None


def _cell_materials(values: OpenmcValues) -> tuple[int | None, ...]:
    words = values.words("material")
    if words is None:
        return ()
    if not words:
        raise values.mistake("material must be an integer, 'void', or several of these, got nothing")
    integer = values.integer_word
    return tuple(None if word.lower() == "void" else integer("material", word) for word in words)


def _cell_translation(values: OpenmcValues) -> Point:
    if values.text("translation") is None:
        return ORIGIN
    x, y, z = values.numbers("translation", 3)
    return x, y, z


def _cell_rotation(values: OpenmcValues) -> tuple[CellRotation, float]:
    """By three angles or nine entries, row by row; and how far those are from a rotation."""
    if values.text("rotation") is None:
        return NO_ROTATION, 0.0
    numbers: tuple[Fraction, ...] = values.numbers("rotation", 3, 9)
    try:
        if len(numbers) == 3:
            x, y, z = numbers
            return rotation_by_angles((x, y, z)), 0.0
        a, b, c, d, e, f, g, h, i = numbers
        rows = ((a, b, c), (d, e, f), (g, h, i))
        rotation = rotation_by_matrix(rows)
        if rotation is None:
            raise values.mistake("rotation must be a matrix that can be inverted, its determinant is 0")
        return rotation, rotation_error(rows)
    except OverflowError:
        raise values.mistake("rotation must be in the range of double precision, and so its inverse") from None
    except ValueError as error:
        raise values.mistake(f"rotation cannot be expressed in double precision: {error}") from None


# From XML to a checked geometry: every mistake is collected, with its line.

MAX_NESTING = 100
"""Levels of universes within universes."""
NumberedItem = TypeVar("NumberedItem", OpenmcSurface, UniverseCell, Lattice)
MaterialTable = dict[int, OpenmcMaterial]


def read_openmc_geometry(path: str | os.PathLike[str]) -> CellGeometry:
    """The geometry of a geometry.xml, with the materials.xml beside it if there is one, or of a model.xml.

    Raises SceneFileError with every mistake found, in both files.
    """
    looked_at: list[XmlElement] = []
    geometry = _read_geometry_file(path, looked_at)
    names = (name for element in (geometry.element, *looked_at) for name in find_unknown_names(element))
    return replace(geometry, unread=tuple(names))


def _read_geometry_file(path: str | os.PathLike[str], looked_at: list[XmlElement]) -> CellGeometry:
    """The geometry; lists of materials are added to `looked_at`."""
    root = read_xml(path)
    if root.tag == "model":
        parts = root.all("geometry")
        if len(parts) != 1:
            found = f"holds {len(parts)} <geometry> elements, a model has one"
            raise SceneFileError(path, [Problem(root.line, root.column, "model", found)])
        listing = root.all("materials")
        looked_at += listing[:1]
        materials, problems = _read_materials_file(listing[0]) if listing else (None, [])
        return _OpenmcReader(path, None if problems else materials, problems).read(parts[0])
    if root.tag != "geometry":
        found = f"is <{shorten(root.tag)}>, not <geometry> or <model>"
        raise SceneFileError(path, [Problem(root.line, root.column, "root element", found)])
    beside = Path(path).with_name("materials.xml")
    if not beside.is_file():
        return _OpenmcReader(path, None, []).read(root)
    wrong = None
    try:
        looked_at.append(read_xml(beside))
        materials, problems = _read_materials_file(looked_at[0])
        if problems:
            raise SceneFileError(beside, problems)
    except SceneFileError as error:
        materials, wrong = None, error
    return _read_with_materials(path, root, materials, wrong)


def _read_with_materials(
    path: str | os.PathLike[str], root: XmlElement, materials: MaterialTable | None, wrong: SceneFileError | None
) -> CellGeometry:
    """The geometry with the list of materials beside it; with None where the list is wrong, as it may lack some."""
    try:
        geometry = _OpenmcReader(path, materials, []).read(root)
    except SceneFileError as error:
        if wrong is None:
            raise
        others = [Problem(0, 0, _format_place(wrong, problem), problem.message) for problem in wrong.problems]
        raise SceneFileError(path, [*others, *error.problems]) from None
    if wrong is not None:
        raise wrong
    return geometry


def _format_place(error: SceneFileError, problem: Problem) -> str:
    """materials.xml:3:5: material"""
    line = f":{problem.line}:{problem.column}" if problem.line else ""
    return f"{Path(error.path).name}{line}" + (f": {problem.where}" if problem.where else "")


def _read_materials_file(listing: XmlElement) -> tuple[MaterialTable, list[Problem]]:
    """The materials by number, and what is wrong."""
    found: MaterialTable = {}
    problems: list[Problem] = []
    for element in listing.all("material"):
        try:
            material = read_material(element)
            if material.id in found:
                raise OpenmcValues(element, "material").mistake(f"id {material.id} is taken by another material")
            found[material.id] = material
        except OpenmcElementError as mistake:
            problems.extend(mistake.problems)
        if len(problems) >= MAX_PROBLEMS:
            break
    return found, problems[:MAX_PROBLEMS]


class _OpenmcReader:
    """Reads one geometry element."""

    def __init__(self, path: str | os.PathLike[str], materials: MaterialTable | None, problems: list[Problem]) -> None:
        self.path = path
        self.materials = materials
        self.problems = list(problems)
        self.universes: dict[int, list[UniverseCell]] = {}
        self.surfaces: dict[int, OpenmcSurface] = {}
        self.lattices: dict[int, Lattice] = {}
        self.half_spaces = 0
        self.broken: dict[str, set[int]] = {"surface": set(), "universe": set(), "lattice": set()}

    def read(self, root: XmlElement) -> CellGeometry:
        for element in root.all("dagmc_universe"):
            self._report(element, "dagmc_universe", "is a mesh from a CAD program, which Conicoid cannot express")
            self._note_broken(element, "universe", "id")
        self.surfaces = self._each(root, "surface", read_surface)
        found = len(self.problems)
        cells = self._each(root, "cell", self._cell)
        for cell in cells.values():
            self.universes.setdefault(cell.universe, []).append(cell)
        lattices = self._each(root, "lattice", read_rectangular_lattice)
        self.lattices = lattices | self._each(root, "hex_lattice", read_hexagonal_lattice, lattices)
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
        return CellGeometry(self.surfaces, cells, self.universes, self.lattices, self.materials, number, counts, root)

    def _cell(self, element: XmlElement) -> UniverseCell:
        """A cell; what is known of a broken one is kept, so that nothing is said against those that refer to it."""
        try:
            cell = read_cell(element, min(LONGEST_REGION, MAX_HALF_SPACES - self.half_spaces))
        except OpenmcElementError:
            self._note_broken(element, "universe", "universe")
            raise
        self.half_spaces += 0 if cell.region is None else sum(1 for _ in list_half_spaces(cell.region))
        return cell

    def _note_broken(self, element: XmlElement, kind: str, name: str) -> None:
        values = OpenmcValues(element, kind)
        number = values.attempt(lambda: values.optional_integer(name), 0)
        self.broken[kind].add(number or 0)

    def _each(
        self,
        root: XmlElement,
        tag: str,
        read: Callable[[XmlElement], NumberedItem],
        others: dict[int, NumberedItem] | None = None,
    ) -> dict[int, NumberedItem]:
        """All elements of a kind by their number; one number for each."""
        items: dict[int, NumberedItem] = {}
        kind = tag.removeprefix("hex_")
        for element in root.all(tag):
            try:
                item = read(element)
            except OpenmcElementError as mistake:
                if kind in self.broken:
                    self._note_broken(element, kind, "id")
                for problem in mistake.problems:
                    self._add(problem)
                continue
            if item.id in items or item.id in (others or {}):
                self._report(element, str(item), f"id {item.id} is taken by another {kind}")
            items[item.id] = item
        return items

    def _check_cell(self, cell: UniverseCell) -> bool:
        """Whether what fills it is there."""
        element = cell.element
        if cell.region is not None:
            found = {half.surface for half in list_half_spaces(cell.region)}
            unknown = sorted(found - self.surfaces.keys() - self.broken["surface"])
            if unknown:
                plural = "s" if len(unknown) > 1 else ""
                self._report(element, str(cell), f"region refers to unknown surface{plural} {join_limited(unknown)}")
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
        unknown = sorted(lattice_fillings(lattice).keys() - self.universes.keys() - self.broken["universe"])
        if unknown:
            plural = "s" if len(unknown) > 1 else ""
            self._report(lattice.element, str(lattice), f"refers to unknown universe{plural} {join_limited(unknown)}")
        return not unknown

    def _root(self, root: XmlElement, counts: dict[UniverseNode, int]) -> int:
        """The universe that fills nothing (OpenMC, find_root_universe)."""
        used = {fill for cells in self.universes.values() for cell in cells if (fill := cell.fill) is not None}
        for lattice in self.lattices.values():
            used |= lattice_fillings(lattice).keys()
        free = sorted(set(self.universes) - used)
        if len(free) == 1:
            return free[0]
        if free:
            self._report(root, "geometry", f"has no single root universe: universes {join_limited(free)} fill nothing")
        elif counts:  # else there is a circle, which is told
            self._report(root, "geometry", "has no single root universe: every universe fills something")
        return 0

    def _counts(self, root: XmlElement) -> dict[UniverseNode, int]:
        """How many bodies each universe and each lattice has. Tells of circles and of too many levels."""
        inside = geometry.count_fillings(self.universes, self.lattices)
        order = geometry.sort_universes(inside)
        circle = geometry.find_circle(inside, order)
        if circle:
            self._report(root, "geometry", f"has universes that contain themselves: {circle}")
            return {}
        if geometry.nesting_depth(inside, order) > MAX_NESTING:
            self._report(root, "geometry", f"nests universes deeper than {MAX_NESTING} levels")
            return {}
        return geometry.count_bodies(self.universes, inside, order)

    def _report(self, element: XmlElement, where: str, message: str) -> None:
        self._add(Problem(element.line, element.column, where, message))

    def _add(self, problem: Problem) -> None:
        self.problems.append(problem)
        if len(self.problems) >= MAX_PROBLEMS:
            self._raise()

    def _raise(self) -> None:
        if self.problems:
            raise SceneFileError(self.path, self.problems)


# An OpenMC geometry as bodies, the legend of their colours, and what there is to say about it.


def read(
    path: str | os.PathLike[str],
    *,
    void: bool = True,
    max_bodies: int | None = None,
    progress: ExpansionProgress | None = None,
) -> ImportResult:
    """The bodies of an OpenMC geometry: a geometry.xml (with the materials.xml beside it) or a model.xml.

    A cell gives one body for each place where it stands, named such as "cell 5 'fuel' @ cell 9, lattice 2 [3, 4]".
    With `void`, cells without material are bodies too, invisible, so that `scene.body_at` finds every cell.
    progress(done, most) is called with numbers of bodies: first with none done, then now and then.
    Raises `SceneFileError`, a ValueError, that lists the mistakes found with their lines; also for tori and meshes,
    which are no quadrics, and for more than `max_bodies` bodies, which are counted before they are made; if that is
    not given, for more than 4,000,000, or 500,000 that are no others moved.
    """
    geometry = read_openmc_geometry(path)
    expansion = UniverseExpansion(path, geometry, BodyLimits.of(max_bodies), void, progress)
    expansion.run()
    names = _material_names(expansion)
    facts, remarks = tuple(_facts(expansion)), tuple(_remarks(expansion))
    legend = _legend(expansion)
    return ImportResult(expansion.bodies, legend, facts + remarks, remarks, names, domain=expansion.domain)


def import_file(path: str | os.PathLike[str], options: ImportOptions) -> ImportResult:
    """`read` by the options of all imports."""
    options.refuse_others("an OpenMC geometry", "void", "strict", "only")
    found = read(path, void=options.void, max_bodies=options.max_bodies, progress=options.progress)
    return found if options.only is None else select_bodies(found, options.only)


def _legend(expansion: UniverseExpansion) -> tuple[LegendEntry, ...]:
    geometry, entries = expansion.geometry, []
    given = {number: geometry.material(number).name for number in geometry.material_names}
    names = {number: name for number, name in geometry.material_names.items() if given[number]}
    for number, count in sorted(expansion.materials.items(), key=lambda item: (item[0] is None, item[0] or 0)):
        color = None if number is None else palette_color(number)
        entries.append(LegendEntry(number, "" if number is None else names.get(number, ""), color, count))
    return tuple(entries)


def _material_names(expansion: UniverseExpansion) -> dict[Material, str]:
    """What a scene file calls each material: material 2 'Zircaloy', as the legend does."""
    geometry, looks = expansion.geometry, expansion.looks
    return {looks[n]: "void" if n is None else str(geometry.material(n)) for n in expansion.materials}


def _facts(expansion: UniverseExpansion) -> Iterator[str]:
    """How large the model is, and what changes no shape."""
    geometry = expansion.geometry
    sizes = (
        (geometry.cells, "cell"), (geometry.surfaces, "surface"),
        (geometry.universes, "universe"), (geometry.lattices, "lattice"),
    )  # fmt: skip
    yield ", ".join(format_count(len(items), what) for items, what in sizes)
    empty = expansion.left_out.places
    without = f"; {format_count(empty, 'place')} without volume left out" if empty else ""
    yield format_count(len(expansion.bodies), "body") + without
    yield from _boundaries(geometry)


def _remarks(expansion: UniverseExpansion) -> Iterator[str]:
    """What is not as the file says, or may not be meant."""
    geometry = expansion.geometry
    yield from limit_notes(expansion.left_out.notes(geometry))
    yield from limit_notes(_cells(geometry))
    yield from limit_notes(
        f"{geometry.lattices[number]}: the cell around it may reach beyond it, and there is no outer universe"
        for number in sorted(expansion.open_lattices)
    )
    yield from limit_notes(_names(geometry))
    yield from map(str, geometry.unread[:MAX_LISTED_PROBLEMS])
    if len(geometry.unread) > MAX_LISTED_PROBLEMS:
        yield f"... and {len(geometry.unread) - MAX_LISTED_PROBLEMS:,} more names that are not read"
    yield from _undefined(expansion)
    if geometry.materials is None:
        yield "no list of materials: they are known by number only"


def _names(geometry: CellGeometry) -> Iterator[str]:
    """Materials that are told apart by more than their names in the file."""
    for number, name in geometry.material_names.items():
        given = geometry.material(number).name
        if given and given != name:
            yield f"{geometry.material(number)}: is called {shorten(name)!r}, since another has its name"


def _undefined(expansion: UniverseExpansion) -> Iterator[str]:
    """Where a check of the scene does not look for points in no cell."""
    told, open_ = "undefined regions (points in no cell)", "boundary conditions do not enclose the model"
    if not expansion.void:
        yield f"{told} cannot be looked for: void is left out"
    elif expansion.domain is None:
        yield f"{told} cannot be looked for: {open_}, and no universe fills any of its cells"
    elif not expansion.is_enclosed:
        yield f"{told} can be looked for in filled cells only: {open_}"


def _cells(geometry: CellGeometry) -> Iterator[str]:
    """What is not done as a cell says."""
    for cell in geometry.cells.values():
        if len(cell.materials) > 1:
            given = join_limited("void" if material is None else material for material in cell.materials)
            yield f"{cell}: has a material for each place ({given}); the first is taken for all"
        if cell.skew > 1e-9:
            yield f"{cell}: its rotation matrix is {cell.skew:.2g} away from a rotation; it is applied as it is"


def _boundaries(geometry: CellGeometry) -> Iterator[str]:
    """Boundary conditions are about particles: they change no shape."""
    kinds = Counter(surface.boundary for surface in geometry.surfaces.values())
    for kind in sorted(set(kinds) - {"transmission"}):
        numbers = [surface.id for surface in geometry.surfaces.values() if surface.boundary == kind]
        yield f"boundary {kind}: surface{'s' if len(numbers) > 1 else ''} {join_limited(numbers)}"
