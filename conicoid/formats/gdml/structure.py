"""GDML's <structure>: volumes with what is placed in them."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from ..nodes import shortened
from ..openmc.xml_tree import Element
from .colors import hint_of
from .materials import Materials, NamedMaterial, material_of
from .placement import ORIGIN, STRAIGHT, Point, Rotation, after, placed, scaled
from .reading import LeftOut, Mistake, Reading, known, local, reference, shown_name
from .solids import Solids
from .templates import Template
from .values import UNSCALED, Values, motion_of

MOST_PLACED = 2_000_000
"""Volumes that are placed in others, before those that stand at several places are counted more than once."""


@dataclass(eq=False)
class Volume:
    """A solid of a material, with volumes in it; an assembly has neither, only volumes."""

    name: str
    element: Element
    template: Template | None
    material: NamedMaterial | None
    source: Element | None = None  # of the solid
    daughters: list[Daughter] = field(default_factory=list)
    is_assembly: bool = False
    is_filled: bool = False  # by replicas, all of it
    is_container: bool = False  # around bodies of a scene that was exported: no body itself
    counted: int | None = None

    @property
    def is_open(self) -> bool:
        """Is it no level of its own, as what is in it stands beside it?"""
        return self.is_assembly or self.is_container


@dataclass(eq=False, slots=True)
class Daughter:
    """A volume within another: turned, then shifted."""

    label: str
    volume: Volume
    shift: Point = ORIGIN
    rotation: Rotation = STRAIGHT
    copy: int | None = None


@dataclass
class Structure:
    """What is known while volumes are read. `module` reads another file and gives one of its volumes."""

    reading: Reading
    solids: Solids
    sources: dict[str, Element]
    materials: Materials
    module: Callable[[Element], Volume]
    volumes: dict[str, Volume] = field(default_factory=dict)
    placed: int = 0
    colored: dict[tuple[NamedMaterial, str], NamedMaterial] = field(default_factory=dict)

    def read(self, section: Element) -> None:
        """All volumes; one may hold only those before it, as Geant4 demands, so that none holds itself."""
        for element in self.reading.each(section.children):
            tag = local(element)
            if tag in ("volume", "assembly"):
                self._attempt(element, Structure._volume)
            elif tag not in ("bordersurface", "skinsurface", "userinfo"):
                self.reading.remark(element, tag, "is nothing that is known in a structure, left out")

    def _attempt(self, element: Element, read: Callable[..., None], *of: Volume) -> None:
        try:
            read(self, *of, element)
        except Mistake as mistake:
            self.reading.report(mistake.element, _where(element), mistake.message)
        except LeftOut as left:
            self.reading.remark(element, _where(element), f"{left}; left out")
        except (ValueError, OverflowError) as error:
            self.reading.report(element, _where(element), str(error))

    def _volume(self, element: Element) -> None:
        name = self.reading.solved(element.attributes.get("name", ""), element)
        if not name:
            raise Mistake(element, "name must be given")
        volume = Volume(name, element, None, None, is_assembly=local(element) == "assembly")
        try:
            for child in element.children:
                if child.tag == "solidref":
                    solid = reference(self.reading, child)
                    if solid not in self.solids:
                        known(self.reading, dict(self.solids), solid, child, "solid")
                    volume.template, volume.source = self.solids[solid], self.sources.get(solid)
                elif child.tag == "materialref":
                    volume.material = self._colored(self._material(child), element)
            if not volume.is_assembly and not element.all("solidref"):
                raise Mistake(element, "must have a solidref")
        finally:
            self.volumes[name] = volume  # so that what refers to it is no second mistake
        if any(_is_container(child) for child in element.children):
            volume.template, volume.is_container = None, True
        readers = _readers()
        for child in self.reading.each(element.children):
            read = readers.get(local(child))
            if read is not None:
                self._attempt(child, read, volume)

    def _material(self, child: Element) -> NamedMaterial:
        name = reference(self.reading, child)
        found = material_of(self.reading, self.materials, name)
        if found is None:
            told = self.reading.suggest(name, self.materials)
            raise Mistake(child, f"there is no material {shortened(name)!r}{told}")
        return found

    def _colored(self, material: NamedMaterial, element: Element) -> NamedMaterial:
        """In the colour that a volume is to have; what is invisible stays so."""
        color = hint_of(self.reading, element)
        if color is None or color == material.color or material.is_thin:
            return material
        return self.colored.setdefault((material, color), replace(material, hint=color))

    def volume_in(self, element: Element) -> Volume:
        """The volume that a placement is of."""
        for child in element.children:
            if child.tag == "volumeref":
                found: Volume = known(self.reading, self.volumes, reference(self.reading, child), child, "volume")
                return found
            if child.tag == "file":
                return self.module(child)
        raise Mistake(element, "must have a volumeref or a file")

    def add(self, volume: Volume, daughter: Daughter) -> None:
        """One more placement. LeftOut where there are too many."""
        if daughter.volume is volume:
            raise Mistake(volume.element, "is placed in itself")
        self.placed += 1
        if self.placed > MOST_PLACED:
            raise Mistake(volume.element, f"there are more than {MOST_PLACED:,} placements")
        volume.daughters.append(daughter)

    def _physvol(self, volume: Volume, element: Element) -> None:
        inner = self.volume_in(element)
        shift, rotation, scale = motion_of(self.reading, element, placed)
        if scale is not UNSCALED and any(factor != 1 for factor in scale):
            rotation = after(rotation, scaled(scale))
        name = self.reading.solved(element.attributes.get("name", ""), element) or inner.name
        copy = None
        if "copynumber" in element.attributes:
            copy = Values(self.reading, element).integer("copynumber", most=2**31, least=-(2**31))
        self.add(volume, Daughter(shown_name(name), inner, shift, rotation, copy))


def _readers() -> dict[str, Callable[[Structure, Volume, Element], None]]:
    """What reads the elements that place volumes."""
    from . import divisions, repeats

    return {
        "physvol": Structure._physvol, "replicavol": repeats.replicas, "divisionvol": divisions.divisions,
        "paramvol": repeats.parameterised,
    }  # fmt: skip


def _where(element: Element) -> str:
    return f"{local(element)} {element.attributes.get('name', '')!r}"


def _is_container(element: Element) -> bool:
    """Does it say that a volume is only there because a world must be?"""
    given = element.attributes
    return element.tag == "auxiliary" and (given.get("auxtype"), given.get("auxvalue")) == ("Conicoid", "container")


def folder_file(path: str, name: str) -> str:
    """A file in the folder of another. Raises ValueError for one elsewhere."""
    if not name or os.path.basename(name) != name or name in (".", "..") or "\0" in name or "\\" in name:
        raise ValueError(f"file must be the name of a file in the same folder, got {shortened(name)!r}")
    folder = os.path.dirname(os.path.abspath(path))
    found = os.path.join(folder, name)
    if os.path.realpath(found) != os.path.join(os.path.realpath(folder), name):
        raise ValueError(f"file must be in the same folder, and {shortened(name)!r} is a link")
    return found
