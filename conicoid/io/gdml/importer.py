"""Import of GDML files: placed volumes become bodies.

`read_gdml` reads a file and its modules into a `GdmlGeometry`; `GdmlExpansion` expands the world into bodies: each
volume at each of its places, less the volumes placed in it; `import_file` does both by the options of all imports.

A volume is expanded once for each of its orientations, about its own origin, into a block. Wherever the volume stands
in that orientation, the block is translated. Translations are fractions, so that every body has the numbers that it
would have if it were built at its place.
"""

from __future__ import annotations

import os
from collections import ChainMap, Counter
from collections.abc import Callable, Iterator
from dataclasses import field
from typing import Any

from ..._util.files import MAX_PROBLEMS, Problem, SceneFileError, resolve_part
from ..._util.records import dataclass
from ..._util.text import format_count
from ...geometry.instances import Shift
from ...geometry.shape import Difference, Solid
from ...materials.material import Material
from ..importers import BodyLimits, ImportOptions, ImportResult, LegendEntry, OmittedPart, limit_notes, select_bodies
from ..openmc.placement import NO_ROTATION, ORIGIN
from ..openmc.universe_block import BlockBodies, BlockPiece, PlacePath, UniverseBlock, flatten_block
from ..scene_file.nodes import shorten
from ..xml_tree import XmlElement, read_xml
from .solid_template import GdmlPlacement, PlacedTemplate, is_rigid, place_solid
from .solids import SolidTable, read_solids
from .structure import LogicalVolume, StructureReader
from .values import (
    GAS_DENSITY,
    GdmlError,
    GdmlMaterial,
    GdmlReader,
    MaterialTable,
    local_tag,
    look_up,
    read_defines,
    read_materials,
    read_reference,
    strip_pointer,
)


@dataclass(eq=False)
class VolumePiece(BlockPiece):
    """A volume's solid, and the solids placed in it, which it loses."""

    volume: LogicalVolume
    own: PlacedTemplate
    displaced: tuple[PlacedTemplate, ...]

    def solid_at(self, shift: Shift) -> Solid:
        """Build the solid less the solids placed in it, with the block translated by `shift`.

        Raise OmittedPart, ValueError or OverflowError if the numbers make no solid there.
        """
        own = place_solid(*self.own, shift)
        if not self.displaced:
            return own
        return Difference((own, *[place_solid(*each, shift) for each in self.displaced]))


class VolumeBlock(UniverseBlock[VolumePiece]):
    """A block of volumes, which are named by their paths."""

    @staticmethod
    def path_name(title: str, path: PlacePath) -> str:
        """Return the name of a volume, such as world/calorimeter[3]/layer."""
        return "/".join((*path, title) if title else path)

    @staticmethod
    def may_lead(path: PlacePath, name: str) -> bool:
        """Return True if the name begins with the path."""
        # "world/a" leads "world/a/b", but not "world/ab"
        start = "/".join(path)
        return name.startswith(start) and name[len(start) : len(start) + 1] in ("", "/")


class VolumeBodies(BlockBodies[VolumePiece]):
    """The bodies of a GDML file."""

    def shape_at(self, kind: int, shift: Shift) -> Solid:
        """Build a volume less its daughters, translated by a shift. Raise ValueError if it cannot be built there."""
        try:
            return self._pieces[kind].solid_at(shift)
        except OmittedPart as left:
            raise ValueError(str(left)) from None

    def is_rigid(self, kind: int) -> bool:
        """Return True if rounding cannot change the structure of the piece at any of its places.

        All parts must be of kinds whose structure is the same everywhere, and none so thin that rounding may close it.
        """
        piece = self._pieces[kind]
        # A rotated piece is built from rounded matrices, and only the build of each place shows what rounding does to
        # it
        straight = all(place.is_straight for _, place in (piece.own, *piece.displaced))
        return straight and is_rigid(self.shape(int(self.members[kind][0])), self.farthest)


# Reading of a file and its modules

MAX_FILES = 200
MAX_FILE_DEPTH = 8
"""Most module files of one import, and most levels of modules within modules."""
_SECTIONS = ("define", "materials", "solids", "structure", "setup", "userinfo", "display", "parallel_world")


@dataclass(eq=False)
class GdmlGeometry:
    """A file that was read, its world volume, and the readers of the modules that it refers to."""

    path: str
    reading: GdmlReader
    structure: StructureReader
    world: LogicalVolume
    modules: list[GdmlReader]

    @property
    def readings(self) -> list[GdmlReader]:
        """The readers of the file and of all modules."""
        return [self.reading, *self.modules]


@dataclass
class _ModuleFiles:
    """Files read so far: `folder` by path, None for those with errors; `stack` are being read, outermost first.

    `materials` holds the first material of each name, of all files: Geant4 has one table for them.
    """

    root: str
    entities: bool
    materials: MaterialTable = field(default_factory=dict)
    folder: dict[str, GdmlGeometry | None] = field(default_factory=dict)
    stack: list[str] = field(default_factory=list)


def read_gdml(
    path: str | os.PathLike[str], entities: bool = False, root: str | os.PathLike[str] | None = None
) -> GdmlGeometry:
    """Read a GDML file and the modules that it refers to.

    Parameters
    ----------
    path
        The file.
    entities
        Whether to read files that the file includes by entities.
    root
        The folder that holds all other files that may be read; None for that of the file.

    Raises
    ------
    SceneFileError
        The file or one of its modules has errors; all errors of the first such file are listed.

    """
    within = os.path.dirname(os.path.abspath(path)) if root is None else os.fspath(root)
    return _read_file(os.fspath(path), _ModuleFiles(within, entities), None)


_HINT = ", such as files that are parts of it: entities=True (--entities) reads those within its folder"


def _read_file(path: str, files: _ModuleFiles, first: GdmlReader | None) -> GdmlGeometry:
    """Read one file; `first` is the reader of the file that refers to it, whose numbering of materials it continues."""
    parts = (lambda name: resolve_part(path, name, files.root)) if files.entities else None
    root = read_xml(path, doctype=True, parts=parts, hint="" if files.entities else _HINT)
    reading = GdmlReader(path)
    if first is not None:
        # Numbers of materials choose their colours, so that they go on through all files
        reading.counter = first.counter
    solids: SolidTable = {}
    # A file's own materials come first
    materials: ChainMap[str, GdmlMaterial] = ChainMap({}, files.materials)
    modules: list[GdmlReader] = []

    def module(element: XmlElement) -> LogicalVolume:
        geometry = _read_module(reading, element, files)
        modules.extend(one for one in geometry.readings if one not in modules)
        name = element.attributes.get("volname")
        # <file> without volname places the world volume of the module
        if not name:
            return geometry.world
        return look_up(reading, geometry.structure.volumes, name, element, "volume in the file")

    # Sections are read in the order of the file: names refer back only.
    structure = StructureReader(reading, solids, {}, materials, module)
    world = None
    # Programs repeat sections, and mix them
    for section in root.children:
        tag = local_tag(section)
        if tag == "define":
            read_defines(reading, section)
        elif tag == "materials":
            read_materials(reading, section, materials)
            for name, material in materials.maps[0].items():
                files.materials.setdefault(name, material)
        elif tag == "solids":
            structure.sources.update((child.attributes.get("name", ""), child) for child in section.children)
            read_solids(reading, section, solids)
        elif tag == "structure":
            structure.read(section)
        elif tag not in _SECTIONS:
            reading.remark(section, tag, "is no section that is known, left out")
    try:
        world = _find_world(reading, root, structure)
    except GdmlError as mistake:
        reading.report(mistake.element, "setup", mistake.message)
    if reading.problems or world is None:
        raise SceneFileError(path, reading.problems)
    return GdmlGeometry(path, reading, structure, world, modules)


def _find_world(reading: GdmlReader, root: XmlElement, structure: StructureReader) -> LogicalVolume:
    """Return the world of the setup "Default", or of the first setup."""
    setups = [child for child in root.children if local_tag(child) == "setup"]
    if not setups:
        raise GdmlError(root, "the file must have a setup element with the world")
    # Geant4 takes the setup by name, "Default" unless the program asks for another
    setup = next((one for one in setups if one.attributes.get("name") == "Default"), setups[0])
    if len(setups) > 1:
        name = setup.attributes.get("name", "")
        reading.remark(setup, f"setup {name!r}", f"is taken, one of {len(setups):,}")
    for child in setup.children:
        if child.tag == "world":
            name = read_reference(reading, child)
            return look_up(reading, structure.volumes, name, child, "volume")
    raise GdmlError(setup, "must have a world element")


def _read_module(reading: GdmlReader, element: XmlElement, files: _ModuleFiles) -> GdmlGeometry:
    """Return the geometry of a module, another file within the root; each file is read once."""
    name = element.attributes.get("name", "")
    try:
        path = resolve_part(reading.path, name, files.root)
    except ValueError as error:
        raise GdmlError(element, str(error)) from None
    own_path = os.path.realpath(reading.path)
    # A module that includes itself, directly or not, would never end
    if path in files.stack or path == own_path:
        raise GdmlError(element, f"file {shorten(name)!r} refers to itself, directly or through other files")
    if path not in files.folder:
        if len(files.folder) >= MAX_FILES or len(files.stack) >= MAX_FILE_DEPTH:
            raise GdmlError(element, f"at most {MAX_FILES} files are read, nested at most {MAX_FILE_DEPTH} levels deep")
        files.stack.append(own_path)
        # None until it is read without errors: files that refer to it ten times each would be read 10^8 times
        files.folder[path] = None
        try:
            files.folder[path] = _read_file(path, files, reading)
        finally:
            files.stack.pop()
    if (geometry := files.folder[path]) is None:
        raise GdmlError(element, f"file {shorten(name)!r} has errors, which are listed where it is first read")
    return geometry


def collect_remarks(geometry: GdmlGeometry) -> Iterator[list[str]]:
    """Yield the remarks of all files, grouped by kind."""
    for reading in geometry.readings:
        yield from reading.remarks.values()


# Expansion into bodies

MAX_VOLUME_DEPTH = 100
"""Most levels of volumes within volumes."""
PARTS_FOR_A_BODY = 4
"""Most primitives, for each body that the limit allows."""

NO_MATERIAL = Material((0.0, 0.0, 0.0), ambient=0.0, diffuse=0.0, transparency=1.0, name="no material")


@dataclass(frozen=True)
class ExpandedVolume:
    """An expanded volume: the solids that it displaces, its count of filled volumes, and its block, if it has one."""

    solids: tuple[PlacedTemplate, ...] = ()
    filled: int = 0
    block: VolumeBlock | None = None


_NO_VOLUMES = ExpandedVolume()


@dataclass
class GdmlExpansion:
    """Expands a geometry into bodies. `levels` is the number of levels of nested volumes that are opened.

    A volume is expanded once for each orientation, about its own origin, and this block is translated to its places.
    Within a volume that is rotated by angles other than quarter turns, every place is expanded on its own.
    """

    geometry: GdmlGeometry
    void: bool
    levels: int
    allowed: BodyLimits
    progress: Callable[[int, int], Any] | None = None
    whole: VolumeBlock = field(default_factory=VolumeBlock)
    bodies: VolumeBodies = field(init=False)
    looks: dict[GdmlMaterial | None, Material] = field(default_factory=lambda: {None: NO_MATERIAL})
    filled: int = 0
    cache: dict[tuple[int, int], tuple[int, int]] = field(default_factory=dict)
    blocks: dict[tuple[Any, ...], ExpandedVolume] = field(default_factory=dict)
    labels: dict[int, list[str]] = field(default_factory=dict)
    problems: dict[int, Problem] = field(default_factory=dict)
    most: int = 0
    singles: int = 0  # bodies that are no translated copies

    def run(self) -> None:
        """Expand the world into `bodies`. Raise SceneFileError for errors, and for too many before any is built."""
        world = self.geometry.world
        self.most, parts = self.count(world, self.levels, 0)
        allowed = self.allowed.bodies
        # Before any solid is made: files may expand into more than memory holds
        if self.most > allowed or parts > PARTS_FOR_A_BODY * allowed:
            raise self._too_many(
                format_count(self.most, "body") if self.most > allowed else format_count(parts, "solid"), allowed
            )
        # The counts above bound the work: only now volumes are expanded.
        self.expand(world, GdmlPlacement(), root_path(world), self.levels, self.whole)
        pieces, flat = flatten_block(self.whole)
        self.bodies = VolumeBodies(self.whole, pieces, flat)
        # Only the outermost place of each piece is built, where its numbers are largest
        for done, number in enumerate(self.bodies.outermost()):
            self._check(number, pieces[int(flat.pieces[number])])
            if self.progress is not None and done % 256 == 0:
                self.progress(number, len(self.bodies))
        if self.problems:
            raise SceneFileError(self.geometry.path, self.problems.values())

    def _too_many(self, found: str, allowed: int) -> SceneFileError:
        """Return the error for an expansion into more than the limit allows."""
        element, advice = (
            self.geometry.world.element,
            "raise it where there is memory for them, or open fewer levels (depth)",
        )
        message = f"expands into {found}; the limit is {allowed:,} (max_bodies): {advice}"
        return SceneFileError(self.geometry.path, [Problem(element.line, element.column, "", message)])

    @property
    def materials(self) -> dict[GdmlMaterial | None, int]:
        """The number of bodies of each material."""
        return self.whole.materials

    def count(self, volume: LogicalVolume, levels: int, depth: int) -> tuple[int, int]:
        """Return the numbers of bodies and primitives of a volume and all its descendants."""
        # Counted once for each volume: a lattice of lattices has more places than could be visited
        counts = self.cache.get((id(volume), levels))
        if counts is not None:
            return counts
        if depth > MAX_VOLUME_DEPTH:
            message = f"volumes nest deeper than {MAX_VOLUME_DEPTH} levels"
            raise SceneFileError(self.geometry.path, [Problem(volume.element.line, volume.element.column, "", message)])
        # Primitives are counted as well: one volume may be a union of a million
        bodies, parts = (0, 0) if volume.template is None else (1, volume.template.parts)
        if levels > 0 or volume.is_open:
            # `depth=1` shows what stands in the world, also where an assembly groups it
            inner = levels if volume.is_open else levels - 1  # assemblies and containers are no levels
            for daughter in volume.daughters:
                more_bodies, more_parts = self.count(daughter.volume, inner, depth + 1)
                bodies, parts = bodies + more_bodies, parts + more_parts
        self.cache[id(volume), levels] = bodies, parts
        return bodies, parts

    def expand(
        self, volume: LogicalVolume, place: GdmlPlacement, path: PlacePath, levels: int, block: VolumeBlock
    ) -> ExpandedVolume:
        """Add the bodies of a volume and of its descendants to a block.

        A volume that its daughters fill is no body; nor is one of gas or without material, unless `void` is set. Both
        still displace their mother.
        """
        own = None if volume.template is None else (volume.template, place)
        has_contents = bool(volume.daughters) and (levels > 0 or volume.is_open)
        if own is None:
            return self._daughters(volume, place, path, levels, block) if has_contents else _NO_VOLUMES
        content = _NO_VOLUMES
        if has_contents:
            inside = VolumeBlock()  # apart, as the volume's own body comes before those of its daughters
            inner = place if volume.inner_rotation is NO_ROTATION else place.inner(ORIGIN, volume.inner_rotation)
            content = self._daughters(volume, inner, path, levels, inside)
        is_filled = volume.is_filled and bool(content.solids)
        if not is_filled and (self.void or not (volume.material is None or volume.material.is_thin)):
            # Only bodies that are no translated copies take memory of their own, so they have a limit of their own
            look = self._look(volume.material)
            self.singles += 1
            if self.singles > self.allowed.singles:
                count = f"at least {format_count(self.singles, 'body')} that are no others moved"
                raise self._too_many(count, self.allowed.singles)
            block.add(VolumePiece("", path, look, volume, own, () if is_filled else content.solids), volume.material)
        if has_contents:
            block.take(inside)
        return ExpandedVolume((own,), content.filled + is_filled)

    def _daughters(
        self, volume: LogicalVolume, place: GdmlPlacement, path: PlacePath, levels: int, block: VolumeBlock
    ) -> ExpandedVolume:
        """Add the bodies of a volume's daughters to a block; return the solids that the daughters displace."""
        inner = levels if volume.is_open else levels - 1
        solids: list[PlacedTemplate] = []
        fill_count = 0
        for daughter, label in zip(volume.daughters, self._labels(volume), strict=True):
            try:
                daughter_place = place.inner(daughter.shift, daughter.rotation)
            except (ValueError, OverflowError) as error:
                self._report(volume, "/".join(path), error)
                continue
            expanded = self._shared(daughter.volume, daughter_place, (*path, label), inner, block)
            # The mother loses its daughters, but not their daughters: these lie within them, as GDML demands
            solids += expanded.solids
            fill_count += expanded.filled
        return ExpandedVolume(tuple(solids), fill_count)

    def _shared(
        self, volume: LogicalVolume, place: GdmlPlacement, path: PlacePath, levels: int, block: VolumeBlock
    ) -> ExpandedVolume:
        """Expand a volume as a block of its own, which all places of the same orientation share."""
        if not place.may_stand_anywhere:
            return self.expand(volume, place, path, levels, block)
        about, shift = place.about_itself()
        # Equal keys give equal bodies up to the shift. Volumes are compared by identity: each is one object.
        key = id(volume), levels, about.turn, None if about.is_straight else about.outer
        shared = self.blocks.get(key)
        if shared is None:
            inside = VolumeBlock()
            shared = self.expand(volume, about, (), levels, inside)
            shared = self.blocks[key] = ExpandedVolume(shared.solids, shared.filled, inside)
        assert shared.block is not None
        block.place(shared.block, shift, path)
        # The mother's body subtracts the daughters where they stand in it, so the shift of the block applies to them
        # too
        solids = shared.solids
        if any(shift):
            solids = tuple([(template, inner.lifted(shift)) for template, inner in solids])
        return ExpandedVolume(solids, shared.filled)

    def _look(self, material: GdmlMaterial | None) -> Material:
        if material not in self.looks:
            assert material is not None
            self.looks[material] = material.look
        return self.looks[material]

    def _check(self, number: int, piece: VolumePiece) -> None:
        """Build a body once, to report errors in its volume."""
        try:
            self.bodies.shape(number)
        except (ValueError, OverflowError) as error:
            self._report(piece.volume, self.bodies.name(number), error)

    def _report(self, volume: LogicalVolume, path: str, error: Exception) -> None:
        """Record the first error of a volume. Raise SceneFileError once there are `MAX_PROBLEMS`."""
        message = "a number is too large" if isinstance(error, OverflowError) else str(error)
        element = volume.element
        # One problem for each volume, however many places it has
        self.problems.setdefault(id(volume), Problem(element.line, element.column, path, message))
        # A wrong volume in a large detector may stand at each of a million places
        if len(self.problems) >= MAX_PROBLEMS:
            raise SceneFileError(self.geometry.path, self.problems.values())

    def _labels(self, volume: LogicalVolume) -> list[str]:
        """Return the unique labels of a volume's daughters."""
        if id(volume) not in self.labels:
            self.labels[id(volume)] = daughter_labels(volume)
        return self.labels[id(volume)]


def daughter_labels(volume: LogicalVolume) -> list[str]:
    """Return unique labels of a volume's daughters, such as layer and calorimeter[3] (a copy number).

    Labels that are still equal get #2, #3 and so on from the second on.
    """
    numbered = [
        daughter.label if daughter.copy is None else f"{daughter.label}[{daughter.copy}]"
        for daughter in volume.daughters
    ]
    # A label with #2 must not collide with a label of the file, so all of these are taken from the start.
    all_labels: set[str] = set(numbered)
    counts: Counter[str] = Counter()
    labels = []
    for label in numbered:
        counts[label] += 1
        unique = label
        if counts[label] > 1:
            while (unique := f"{label}#{counts[label]}") in all_labels:
                counts[label] += 1
            all_labels.add(unique)
        labels.append(unique)
    return labels


def root_path(world: LogicalVolume) -> PlacePath:
    """Return the first part of all paths: the name of the world, or nothing if the world is no body."""
    return () if world.is_container else (strip_pointer(world.name) or "world",)


# Import by the options of all formats


def import_file(path: str | os.PathLike[str], options: ImportOptions) -> ImportResult:
    """Import a GDML file: each volume at each of its places is a body, less the volumes in it, named by its path.

    Parameters
    ----------
    path
        The file.
    options
        Options of the import; `void`, `strict`, `only`, `depth`, `entities` and `root` apply.

    Raises
    ------
    SceneFileError
        The file has errors or expands into too many bodies.
    ValueError
        An option does not apply to GDML, or `only` names no body.

    """
    options.refuse_others("a GDML file", "void", "strict", "only", "depth", "entities", "root")
    geometry = read_gdml(path, options.entities, options.root)
    levels = MAX_VOLUME_DEPTH + 1 if options.depth is None else options.depth
    expansion = GdmlExpansion(geometry, options.void, levels, options.most, options.progress)
    expansion.run()
    facts, remarks = tuple(_facts(geometry, expansion)), tuple(_remarks(geometry))
    # Bodies of one look may come from several volumes, so the legend goes by material
    names = {
        expansion.looks[material]: "no material" if material is None else material.title
        for material in expansion.materials
    }
    result = ImportResult(expansion.bodies, _legend(expansion), facts + remarks, remarks, names, unit="mm")
    return result if options.only is None else select_bodies(result, options.only)


def _legend(expansion: GdmlExpansion) -> tuple[LegendEntry, ...]:
    entries = []
    for material, count in sorted(expansion.materials.items(), key=lambda item: item[0].number if item[0] else 0):
        if material is None:
            entries.append(LegendEntry(None, "no material", None, count))
        else:
            entries.append(LegendEntry(material.number, material.name, material.color, count))
    return tuple(entries)


def _facts(geometry: GdmlGeometry, expansion: GdmlExpansion) -> Iterator[str]:
    structures = [geometry.structure]
    solids, volumes = (sum(len(part) for part in parts) for parts in (
        [one.solids for one in structures], [one.volumes for one in structures],
    ))  # fmt: skip
    files = f", {format_count(len(geometry.modules), 'module')}" if geometry.modules else ""
    yield f"{format_count(solids, 'solid')}, {format_count(volumes, 'volume')}{files}"
    remark = f"; {format_count(expansion.filled, 'volume')} that others fill left out" if expansion.filled else ""
    yield format_count(len(expansion.bodies), "body") + remark
    thin = [material.name for material in expansion.materials if material is not None and material.is_thin]
    if thin:
        yield f"invisible, gases and what is thinner than {GAS_DENSITY:g} g/cm3: {', '.join(thin[:8])}"


def _remarks(geometry: GdmlGeometry) -> Iterator[str]:
    """Yield the first few remarks of each kind."""
    for remarks in collect_remarks(geometry):
        yield from limit_notes(remarks)
