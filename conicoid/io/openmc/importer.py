"""Import of OpenMC geometries: geometry.xml with materials.xml, or model.xml.

Three parts: the reader of <cell> elements; `read_openmc_geometry`, which reads and checks whole files and collects all
errors with their lines; and `read` and `import_file`, which expand the geometry into bodies, legend and notes.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import NoReturn, TypeVar

from ..._util.files import MAX_LISTED_PROBLEMS, MAX_PROBLEMS, Problem, SceneFileError
from ...materials.material import Material
from ..importers import (
    BodyLimits,
    ImportOptions,
    ImportResult,
    OmittedPart,
    limit_notes,
    select_bodies,
)
from ..scene_file.nodes import shorten
from ..xml_tree import XmlElement, read_xml
from . import geometry
from .expansion import ExpansionProgress, UniverseExpansion
from .geometry import CellGeometry, UniverseCell, UniverseNode, lattice_fillings
from .lattices import Lattice, read_hexagonal_lattice, read_rectangular_lattice
from .placement import NO_ROTATION, ORIGIN, CellRotation, Point, rotation_by_angles, rotation_by_matrix, rotation_error
from .region_expression import (
    LONGEST_REGION,
    MAX_HALF_SPACES,
    Region,
    count_half_spaces,
    list_half_spaces,
    parse_region,
)
from .surfaces import OpenmcSurface, read_surface
from .values import OpenmcElementError, OpenmcMaterial, OpenmcValues, find_unknown_names, join_limited, read_material


def read_cell(element: XmlElement, most: int = MAX_HALF_SPACES) -> UniverseCell:
    """Return the cell of a <cell> element.

    Parameters
    ----------
    element
        The element.
    most
        Most half-spaces of its region.

    Raises
    ------
    OpenmcElementError
        With all errors of the element.

    """
    values = OpenmcValues(element, "cell")
    number, name = values.title()
    materials = values.attempt(lambda: _cell_materials(values), ())
    fill = values.attempt(lambda: values.optional_integer("fill"), None)
    is_filled = values.text("fill") is not None
    if is_filled == (values.text("material") is not None):
        values.add_mistake(f"needs either a material or a fill, got {'both' if is_filled else 'neither'}")
    universe = values.attempt(lambda: values.optional_integer("universe"), None) or 0
    # Longer circles are found once all cells are read
    if fill is not None and fill == universe:
        values.add_mistake(f"is filled with the universe {fill} that it is in")
    region = values.attempt(lambda: _cell_region(values, most), None)
    rotation, skew = values.attempt(lambda: _cell_rotation(values), (NO_ROTATION, 0.0))
    translation = values.attempt(lambda: _cell_translation(values), ORIGIN)
    # Without a filling there is nothing that rotation and translation could move.
    if values.text("material") is not None and not is_filled:
        for what, attribute in (("rotated", "rotation"), ("translated", "translation")):
            if values.text(attribute) is not None:
                values.add_mistake(f"is {what}, but not filled with a universe or lattice")
    values.finish()
    return UniverseCell(number, name, universe, region, fill, materials, translation, rotation, skew, element)


def _cell_region(values: OpenmcValues, most: int) -> Region | None:
    # A list of numbers without operators
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
    # Several materials are those of the cell's places, in order ("distributed materials")
    return tuple(None if word.lower() == "void" else integer("material", word) for word in words)


def _cell_translation(values: OpenmcValues) -> Point:
    if values.text("translation") is None:
        return ORIGIN
    x, y, z = values.numbers("translation", 3)
    return x, y, z


def _cell_rotation(values: OpenmcValues) -> tuple[CellRotation, float]:
    """Return the rotation of three angles or of nine entries of a matrix, row by row, and its error as a rotation."""
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


# Reading of files into a checked geometry; every error is collected, with its line


def read_mesh(element: XmlElement) -> NoReturn:
    """Raise OmittedPart for a <dagmc_universe> element, or OpenmcElementError if its number is wrong."""
    values = OpenmcValues(element, "universe")
    values.title()
    values.finish()
    raise OmittedPart(f"{values.where} is a mesh (dagmc_universe), which is left out")


MAX_NESTING = 100
"""Most levels of universes within universes."""
NumberedItem = TypeVar("NumberedItem", OpenmcSurface, UniverseCell, Lattice)
MaterialTable = dict[int, OpenmcMaterial]


def read_openmc_geometry(path: str | os.PathLike[str]) -> CellGeometry:
    """Read the geometry of a geometry.xml, with the materials.xml beside it if there is one, or of a model.xml.

    Raise SceneFileError with all errors in both files.
    """
    material_lists: list[XmlElement] = []
    geometry = _read_geometry_file(path, material_lists)
    names = (name for element in (geometry.element, *material_lists) for name in find_unknown_names(element))
    return replace(geometry, unread=tuple(names))


def _read_geometry_file(path: str | os.PathLike[str], material_lists: list[XmlElement]) -> CellGeometry:
    """Return the geometry; append the elements that list materials to `material_lists`."""
    root = read_xml(path)
    if root.tag == "model":
        parts = root.all("geometry")
        if len(parts) != 1:
            message = f"holds {len(parts)} <geometry> elements, a model has one"
            raise SceneFileError(path, [Problem(root.line, root.column, "model", message)])
        # model.xml holds all in one file
        listing = root.all("materials")
        material_lists += listing[:1]
        materials, problems = _read_materials_file(listing[0]) if listing else (None, [])
        return _OpenmcReader(path, None if problems else materials, problems).read(parts[0])
    if root.tag != "geometry":
        message = f"is <{shorten(root.tag)}>, not <geometry> or <model>"
        raise SceneFileError(path, [Problem(root.line, root.column, "root element", message)])
    materials_path = Path(path).with_name("materials.xml")
    if not materials_path.is_file():
        return _OpenmcReader(path, None, []).read(root)
    materials_error = None
    try:
        material_lists.append(read_xml(materials_path))
        materials, problems = _read_materials_file(material_lists[0])
        if problems:
            raise SceneFileError(materials_path, problems)
    except SceneFileError as error:
        materials, materials_error = None, error
    return _read_with_materials(path, root, materials, materials_error)


def _read_with_materials(
    path: str | os.PathLike[str],
    root: XmlElement,
    materials: MaterialTable | None,
    materials_error: SceneFileError | None,
) -> CellGeometry:
    """Return the geometry with its materials; raise the errors of both files together.

    `materials` is None if the list is wrong: it may lack materials, so references to them are not checked.
    """
    try:
        geometry = _OpenmcReader(path, materials, []).read(root)
    except SceneFileError as error:
        if materials_error is None:
            raise
        others = [
            Problem(0, 0, _format_place(materials_error, problem), problem.message)
            for problem in materials_error.problems
        ]
        raise SceneFileError(path, [*others, *error.problems]) from None
    if materials_error is not None:
        raise materials_error
    return geometry


def _format_place(error: SceneFileError, problem: Problem) -> str:
    """Return the place of a problem in another file, such as "materials.xml:3:5: material"."""
    line = f":{problem.line}:{problem.column}" if problem.line else ""
    return f"{Path(error.path).name}{line}" + (f": {problem.where}" if problem.where else "")


def _read_materials_file(listing: XmlElement) -> tuple[MaterialTable, list[Problem]]:
    """Return the materials by number, and the errors."""
    table: MaterialTable = {}
    problems: list[Problem] = []
    for element in listing.all("material"):
        try:
            material = read_material(element)
            if material.id in table:
                raise OpenmcValues(element, "material").mistake(f"id {material.id} is taken by another material")
            table[material.id] = material
        except OpenmcElementError as mistake:
            problems.extend(mistake.problems)
        if len(problems) >= MAX_PROBLEMS:
            break
    return table, problems[:MAX_PROBLEMS]


class _OpenmcReader:
    """Reader of one <geometry> element.

    `broken` holds the numbers of elements that could not be read, so that references to them report no second error,
    and `omitted` the reasons why surfaces, universes and cells are left out.
    """

    def __init__(self, path: str | os.PathLike[str], materials: MaterialTable | None, problems: list[Problem]) -> None:
        self.path = path
        self.materials = materials
        self.problems = list(problems)
        self.universes: dict[int, list[UniverseCell]] = {}
        self.surfaces: dict[int, OpenmcSurface] = {}
        self.lattices: dict[int, Lattice] = {}
        self.half_spaces = 0
        self.omitted: dict[str, dict[int, str]] = {"surface": {}, "universe": {}, "cell": {}}
        self.broken: dict[str, set[int]] = {"surface": set(), "universe": set(), "lattice": set()}

    def read(self, root: XmlElement) -> CellGeometry:
        """Return the geometry. Raise SceneFileError with all errors."""
        # Surfaces first, then cells, then lattices: each kind refers to those before
        self.surfaces = self._each(root, "surface", read_surface)
        errors_before = len(self.problems)
        cells = self._each(root, "cell", self._cell)
        for cell in cells.values():
            self.universes.setdefault(cell.universe, []).append(cell)
        # Both kinds of lattices share one numbering
        self._each(root, "dagmc_universe", read_mesh)
        for number in self.omitted["universe"]:
            self.universes.setdefault(number, [])
        lattices = self._each(root, "lattice", read_rectangular_lattice)
        self.lattices = lattices | self._each(root, "hex_lattice", read_hexagonal_lattice, lattices)
        whole = len(self.problems) == errors_before and not self.broken["universe"]
        for cell in cells.values():
            # Each cell is checked, also after one that is wrong
            whole = self._check_cell(cell) and whole
        for lattice in self.lattices.values():
            whole = self._check_lattice(lattice) and whole
        if not root.all("cell") and not self.universes and not self.problems:
            self._report(root, "geometry", "holds no cells")
        counts = self._counts(root)
        # With errors in cells or lattices, an unused universe may only seem so: do not report a second error.
        number = self._root(root, counts) if whole and self.universes else 0
        self._raise()
        omitted = self.omitted["cell"]
        if omitted:
            cells = {number: cell for number, cell in cells.items() if number not in omitted}
            self.universes = {u: [c for c in inside if c.id in cells] for u, inside in self.universes.items()}
            counts = self._counts(root)
        left_out = (*self.omitted["universe"].values(), *geometry.omission_notes(omitted))
        return CellGeometry(
            self.surfaces, cells, self.universes, self.lattices, self.materials, number, counts, root, left_out=left_out
        )

    def _cell(self, element: XmlElement) -> UniverseCell:
        """Return a cell; note the universe of a broken one, so that references to it report no second error."""
        try:
            cell = read_cell(element, min(LONGEST_REGION, MAX_HALF_SPACES - self.half_spaces))
        except OpenmcElementError:
            self._note_broken(element, "universe", "universe")
            raise
        # Count half-spaces of all regions together, as the limit holds for the file.
        self.half_spaces += count_half_spaces(cell.region)
        return cell

    def _note_broken(self, element: XmlElement, kind: str, name: str) -> None:
        """Note the number in an attribute of an element that could not be read."""
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
        """Return all elements of a kind by number; report errors, and numbers that occur twice or in `others`."""
        items: dict[int, NumberedItem] = {}
        kind = tag.removeprefix("hex_").removeprefix("dagmc_")
        for element in root.all(tag):
            try:
                item = read(element)
            except OmittedPart as omission:
                self.omitted[kind][OpenmcValues(element, kind).integer("id")] = str(omission)
                continue
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
        """Report unknown surfaces, fillings and materials of a cell; return True if its filling exists."""
        element = cell.element
        if cell.region is not None:
            numbers = {half.surface for half in list_half_spaces(cell.region)}
            tori = sorted(numbers & self.omitted["surface"].keys())
            if tori:
                self.omitted["cell"][cell.id] = self.omitted["surface"][tori[0]]
            # A surface that could not be read has been reported already. `-` would go through all surfaces of the file
            known = self.surfaces, self.broken["surface"], tori
            unknown = sorted(number for number in numbers if not any(number in some for some in known))
            if unknown:
                plural = "s" if len(unknown) > 1 else ""
                self._report(element, str(cell), f"region refers to unknown surface{plural} {join_limited(unknown)}")
        is_there = cell.fill is None or self._is_fill(cell.fill)
        if not is_there:
            self._report(element, str(cell), f"fill {cell.fill} is neither a universe nor a lattice")
        if self.materials is not None:
            for material in cell.materials:
                # One problem for a cell is enough
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
        """Report unknown universes of a lattice; return True if all exist."""
        unknown = sorted(lattice_fillings(lattice).keys() - self.universes.keys() - self.broken["universe"])
        if unknown:
            plural = "s" if len(unknown) > 1 else ""
            self._report(lattice.element, str(lattice), f"refers to unknown universe{plural} {join_limited(unknown)}")
        return not unknown

    def _root(self, root: XmlElement, counts: dict[UniverseNode, int]) -> int:
        """Return the universe that fills nothing (OpenMC, find_root_universe); report if there is no single one."""
        used = {fill for cells in self.universes.values() for cell in cells if (fill := cell.fill) is not None}
        for lattice in self.lattices.values():
            used |= lattice_fillings(lattice).keys()
        free = sorted(set(self.universes) - used)
        if len(free) == 1:
            return free[0]
        if free:
            self._report(root, "geometry", f"has no single root universe: universes {join_limited(free)} fill nothing")
        elif counts:  # without counts there is a circle, which has been reported
            self._report(root, "geometry", "has no single root universe: every universe fills something")
        return 0

    def _counts(self, root: XmlElement) -> dict[UniverseNode, int]:
        """Return the number of bodies of each universe and lattice; report circles and too many levels."""
        inside = geometry.count_fillings(self.universes, self.lattices)
        order = geometry.topological_order(inside)
        circle = geometry.find_circle(inside, order)
        if circle:
            self._report(root, "geometry", f"has universes that contain themselves: {circle}")
            return {}
        # The expansion is recursive
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


# Import as bodies, legend and notes


def read(
    path: str | os.PathLike[str],
    *,
    void: bool = True,
    max_bodies: int | None = None,
    progress: ExpansionProgress | None = None,
) -> ImportResult:
    """Import an OpenMC geometry: a geometry.xml (with the materials.xml beside it) or a model.xml.

    A cell becomes one body for each of its places, named such as "cell 5 'fuel' @ cell 9, lattice 2 [3, 4]".

    Parameters
    ----------
    path
        The file.
    void
        Whether cells without material become invisible bodies, so that `scene.body_at` finds every cell.
    max_bodies
        Most bodies, which are counted before they are built; None allows 4,000,000 bodies, of them 500,000 that are no
        translated copies.
    progress
        Called as progress(done, most) with numbers of bodies: first with 0 done, then now and then.

    Returns
    -------
    ImportResult
        Bodies, legend, notes, remarks and the domain that the bodies fill.

    Raises
    ------
    SceneFileError
        A ValueError that lists all errors with their lines; also for too many bodies. Cells with tori, which are no
        quadrics, and meshes are left out with a remark.

    """
    geometry = read_openmc_geometry(path)
    expansion = UniverseExpansion(path, geometry, BodyLimits.of(max_bodies), void, progress)
    expansion.run()
    names = _material_names(expansion)
    facts, remarks = tuple(expansion.facts()), tuple(_remarks(expansion))
    return ImportResult(
        expansion.bodies, expansion.legend, facts + remarks, remarks, names, domain=expansion.domain, unit="cm"
    )


def import_file(path: str | os.PathLike[str], options: ImportOptions) -> ImportResult:
    """Import an OpenMC geometry by the options of all imports.

    Parameters
    ----------
    path
        The file.
    options
        Options of the import; `void`, `strict` and `only` apply.

    Raises
    ------
    SceneFileError
        See `read`.
    ValueError
        An option does not apply to OpenMC, or `only` names no body.

    """
    options.refuse_others("an OpenMC geometry", "void", "strict", "only")
    result = read(path, void=options.void, max_bodies=options.max_bodies, progress=options.progress)
    return result if options.only is None else select_bodies(result, options.only)


def _material_names(expansion: UniverseExpansion) -> dict[Material, str]:
    """Return the name of each material in scene files, such as "material 2 'Zircaloy'", as in the legend."""
    geometry, looks = expansion.geometry, expansion.looks
    return {looks[n]: "void" if n is None else str(geometry.material(n)) for n in expansion.materials}


def _remarks(expansion: UniverseExpansion) -> Iterator[str]:
    """Yield remarks about parts that differ from the file, or that the file may not intend."""
    geometry = expansion.geometry
    yield from limit_notes(geometry.left_out)
    yield from limit_notes(expansion.empty_places.notes(geometry))
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
    """Yield remarks about materials that got another name than in the file, because two have the same."""
    for number, name in geometry.material_names.items():
        listed = geometry.material(number).name
        if listed and listed != name:
            yield f"{geometry.material(number)}: is called {shorten(name)!r}, since another has its name"


def _undefined(expansion: UniverseExpansion) -> Iterator[str]:
    """Yield a remark if a check of the scene cannot look for points in no cell, or only in a part of space."""
    what, open_ = "undefined regions (points in no cell)", "boundary conditions do not enclose the model"
    if not expansion.void:
        yield f"{what} cannot be looked for: void is left out"
    elif expansion.domain is None:
        yield f"{what} cannot be looked for: {open_}, and no universe fills any of its cells"
    elif not expansion.is_enclosed:
        yield f"{what} can be looked for in filled cells only: {open_}"


def _cells(geometry: CellGeometry) -> Iterator[str]:
    """Yield remarks about cells that are read differently from the file."""
    for cell in geometry.cells.values():
        if len(cell.materials) > 1:
            listed = join_limited("void" if material is None else material for material in cell.materials)
            yield f"{cell}: has a material for each place ({listed}); the first is taken for all"
        if cell.skew > 1e-9:
            yield f"{cell}: its rotation matrix is {cell.skew:.2g} away from a rotation; it is applied as it is"
