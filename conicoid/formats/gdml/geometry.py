"""A GDML file, read: the volume that is the world, and what there is to say."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass, field

from ..errors import SceneFileError
from ..nodes import shortened
from ..openmc.xml_tree import Element, read_xml
from .defines import read_defines
from .materials import Materials, read_materials
from .reading import Mistake, Reading, known, local, reference
from .solids import Solids, read_solids
from .structure import Structure, Volume, folder_file

MOST_FILES = 200
DEEPEST_FILES = 8
_SECTIONS = ("define", "materials", "solids", "structure", "setup", "userinfo", "display", "parallel_world")


@dataclass(eq=False)
class Geometry:
    """A file and the modules that it refers to."""

    path: str
    reading: Reading
    structure: Structure
    world: Volume
    modules: list[Reading]

    @property
    def readings(self) -> list[Reading]:
        """Of the file and of all modules."""
        return [self.reading, *self.modules]


@dataclass
class _Files:
    """The files that are read."""

    entities: bool
    folder: dict[str, Geometry] = field(default_factory=dict)
    open: list[str] = field(default_factory=list)


def read_geometry(path: str | os.PathLike[str], entities: bool = False) -> Geometry:
    """All of a file. Raises SceneFileError with all mistakes in it, or in the first module that has some.

    entities: are files of its folder read that it takes in by entities?
    """
    return _read(os.fspath(path), _Files(entities), None)


_HINT = ", such as files that are parts of it: entities=True (--entities) reads those in its folder"


def _read(path: str, files: _Files, first: Reading | None) -> Geometry:
    parts = (lambda name: folder_file(path, name.removeprefix("./"))) if files.entities else None
    root = read_xml(path, doctype=True, parts=parts, hint="" if files.entities else _HINT)
    reading = Reading(path)
    if first is not None:
        reading.counter = first.counter
    solids: Solids = {}
    materials: Materials = {}
    modules: list[Reading] = []

    def module(element: Element) -> Volume:
        found = _module(reading, element, files)
        modules.extend(one for one in found.readings if one not in modules)
        name = element.attributes.get("volname")
        if not name:
            return found.world
        volume: Volume = known(reading, found.structure.volumes, name, element, "volume in the file")
        return volume

    structure = Structure(reading, solids, {}, materials, module)
    world = None
    for section in root.children:
        tag = local(section)
        if tag == "define":
            read_defines(reading, section)
        elif tag == "materials":
            read_materials(reading, section, materials)
        elif tag == "solids":
            structure.sources.update((child.attributes.get("name", ""), child) for child in section.children)
            read_solids(reading, section, solids)
        elif tag == "structure":
            structure.read(section)
        elif tag not in _SECTIONS:
            reading.remark(section, tag, "is no section that is known, left out")
    try:
        world = _world(reading, root, structure)
    except Mistake as mistake:
        reading.report(mistake.element, "setup", mistake.message)
    if reading.problems or world is None:
        raise SceneFileError(path, reading.problems)
    return Geometry(path, reading, structure, world, modules)


def _world(reading: Reading, root: Element, structure: Structure) -> Volume:
    """The world of the setup "Default", or else of the first."""
    setups = [child for child in root.children if local(child) == "setup"]
    if not setups:
        raise Mistake(root, "the file must have a setup element with the world")
    chosen = next((one for one in setups if one.attributes.get("name") == "Default"), setups[0])
    if len(setups) > 1:
        name = chosen.attributes.get("name", "")
        reading.remark(chosen, f"setup {name!r}", f"is taken, one of {len(setups):,}")
    for child in chosen.children:
        if child.tag == "world":
            name = reference(reading, child)
            found: Volume = known(reading, structure.volumes, name, child, "volume")
            return found
    raise Mistake(chosen, "must have a world element")


def _module(reading: Reading, element: Element, files: _Files) -> Geometry:
    """Another file of the folder."""
    name = element.attributes.get("name", "")
    try:
        path = folder_file(reading.path, name)
    except ValueError as error:
        raise Mistake(element, str(error)) from None
    here = os.path.abspath(reading.path)
    if path in files.open or path == here:
        raise Mistake(element, f"file {shortened(name)!r} refers to itself, through others perhaps")
    if path not in files.folder:
        if len(files.folder) >= MOST_FILES or len(files.open) >= DEEPEST_FILES:
            raise Mistake(element, f"at most {MOST_FILES} files are read, nested at most {DEEPEST_FILES} levels deep")
        files.open.append(here)
        try:
            files.folder[path] = _read(path, files, reading)
        finally:
            files.open.pop()
    return files.folder[path]


def remarks_of(geometry: Geometry) -> Iterator[list[str]]:
    """Remarks, by kind."""
    for reading in geometry.readings:
        yield from reading.remarks.values()


__all__ = ["Geometry", "read_geometry", "remarks_of"]
