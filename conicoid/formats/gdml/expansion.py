"""The bodies of a GDML geometry: each volume at each of its places, less what is placed in it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from ...shapes.material import Material
from ..errors import MOST, Problem, SceneFileError
from ..imports.imported import counted
from ..imports.options import Most
from ..openmc.block import Path, flattened
from .geometry import Geometry
from .materials import NamedMaterial
from .placed import Place, Standing, VolumeBlock, VolumeBodies, VolumePiece
from .structure import Volume

DEEPEST = 100
"""Levels of volumes in volumes."""
PARTS_FOR_A_BODY = 4
"""Primitives for each body that is allowed."""

NO_MATERIAL = Material((0.0, 0.0, 0.0), ambient=0.0, diffuse=0.0, transparency=1.0, name="no material")


@dataclass(frozen=True)
class Made:
    """What a volume has become: what it displaces, how many volumes in it others fill, and its block."""

    solids: tuple[Standing, ...] = ()
    filled: int = 0
    block: VolumeBlock | None = None


@dataclass
class Expansion:
    """Makes the bodies of a geometry. `levels`: how many of nested volumes are opened.

    A volume is worked out once, about its own origin, for each way in which it is turned; where it stands, that block
    is moved. Within what is turned by other angles than quarter turns every place is worked out.
    """

    geometry: Geometry
    void: bool
    levels: int
    allowed: Most
    progress: Callable[[int, int], Any] | None = None
    whole: VolumeBlock = field(default_factory=VolumeBlock)
    bodies: VolumeBodies = field(init=False)
    looks: dict[NamedMaterial | None, Material] = field(default_factory=lambda: {None: NO_MATERIAL})
    filled: int = 0
    known: dict[tuple[int, int], tuple[int, int]] = field(default_factory=dict)
    blocks: dict[tuple[Any, ...], Made] = field(default_factory=dict)
    labels: dict[int, list[str]] = field(default_factory=dict)
    problems: dict[int, Problem] = field(default_factory=dict)
    most: int = 0
    alone: int = 0  # bodies that are no others moved

    def run(self) -> None:
        """All of it. Raises SceneFileError for mistakes, and for too many bodies before any is made."""
        world = self.geometry.world
        self.most, parts = self.count(world, self.levels, 0)
        allowed = self.allowed.bodies
        if self.most > allowed or parts > PARTS_FOR_A_BODY * allowed:
            raise self._too_many(
                counted(self.most, "body") if self.most > allowed else counted(parts, "solid"), allowed
            )
        self.expand(world, Place(), path_of(world), self.levels, self.whole)
        pieces, flat = flattened(self.whole)
        self.bodies = VolumeBodies(self.whole, pieces, flat)
        for done, number in enumerate(self.bodies.outermost()):
            self._check(number, pieces[int(flat.pieces[number])])
            if self.progress is not None and done % 256 == 0:
                self.progress(number, len(self.bodies))
        if self.problems:
            raise SceneFileError(self.geometry.path, self.problems.values())

    def _too_many(self, found: str, allowed: int) -> SceneFileError:
        """Refuses what expands into more than is allowed."""
        element, told = (
            self.geometry.world.element,
            "raise it where there is memory for them, or open fewer levels (depth)",
        )
        message = f"expands into {found}; the limit is {allowed:,} (max_bodies): {told}"
        return SceneFileError(self.geometry.path, [Problem(element.line, element.column, "", message)])

    @property
    def materials(self) -> Counter[NamedMaterial | None]:
        """How many bodies there are of each material."""
        return self.whole.materials

    def count(self, volume: Volume, levels: int, depth: int) -> tuple[int, int]:
        """Bodies and primitives of a volume and all in it."""
        found = self.known.get((id(volume), levels))
        if found is not None:
            return found
        if depth > DEEPEST:
            message = f"volumes nest deeper than {DEEPEST} levels"
            raise SceneFileError(self.geometry.path, [Problem(volume.element.line, volume.element.column, "", message)])
        bodies, parts = (0, 0) if volume.template is None else (1, volume.template.parts)
        if levels > 0 or volume.is_open:
            inner = levels if volume.is_open else levels - 1
            for daughter in volume.daughters:
                more, its = self.count(daughter.volume, inner, depth + 1)
                bodies, parts = bodies + more, parts + its
        self.known[id(volume), levels] = bodies, parts
        return bodies, parts

    def expand(self, volume: Volume, place: Place, path: Path, levels: int, block: VolumeBlock) -> Made:
        """Put the bodies of a volume, and of all in it, into a block."""
        own = None if volume.template is None else (volume.template, place)
        opened = levels > 0 or volume.is_open
        if own is None:
            displaced = self._daughters(volume, place, path, levels, block) if opened else Made()
            return Made(displaced.solids, displaced.filled)
        inside = VolumeBlock()
        found = self._daughters(volume, place, path, levels, inside) if opened else Made()
        is_filled = volume.is_filled and bool(found.solids)
        if not is_filled and (self.void or not (volume.material is None or volume.material.is_thin)):
            look = self._look(volume.material)
            self.alone += 1
            if self.alone > self.allowed.alone:
                told = f"at least {counted(self.alone, 'body')} that are no others moved"
                raise self._too_many(told, self.allowed.alone)
            block.add(VolumePiece("", path, look, volume, own, () if is_filled else found.solids), volume.material)
        block.take(inside)
        return Made((own,), found.filled + is_filled)

    def _daughters(self, volume: Volume, place: Place, path: Path, levels: int, block: VolumeBlock) -> Made:
        """All that is placed in a volume: what it displaces of its surroundings."""
        inner = levels if volume.is_open else levels - 1
        solids: list[Standing] = []
        filled = 0
        for daughter, label in zip(volume.daughters, self._labels(volume), strict=True):
            try:
                there = place.inner(daughter.shift, daughter.rotation)
            except (ValueError, OverflowError) as error:
                self._report(volume, "/".join(path), error)
                continue
            made = self._shared(daughter.volume, there, (*path, label), inner, block)
            solids += made.solids
            filled += made.filled
        return Made(tuple(solids), filled)

    def _shared(self, volume: Volume, place: Place, path: Path, levels: int, block: VolumeBlock) -> Made:
        """A volume as a block of its own, which stands wherever it is turned alike."""
        if not place.may_stand_anywhere:
            return self.expand(volume, place, path, levels, block)
        about, shift = place.about_itself()
        key = id(volume), levels, about.turn, None if about.is_straight else about.outer
        made = self.blocks.get(key)
        if made is None:
            inside = VolumeBlock()
            made = self.expand(volume, about, (), levels, inside)
            made = self.blocks[key] = Made(made.solids, made.filled, inside)
        assert made.block is not None
        block.place(made.block, shift, path)
        return Made(tuple((template, inner.lifted(shift)) for template, inner in made.solids), made.filled)

    def _look(self, material: NamedMaterial | None) -> Material:
        if material not in self.looks:
            assert material is not None
            self.looks[material] = material.look
        return self.looks[material]

    def _check(self, number: int, piece: VolumePiece) -> None:
        """Make a body, so that what is wrong is told."""
        try:
            self.bodies.shape(number)
        except (ValueError, OverflowError) as error:
            self._report(piece.volume, self.bodies.name(number), error)

    def _report(self, volume: Volume, path: str, error: Exception) -> None:
        told = "a number is too large" if isinstance(error, OverflowError) else str(error)
        element = volume.element
        self.problems.setdefault(id(volume), Problem(element.line, element.column, path, told))
        if len(self.problems) >= MOST:
            raise SceneFileError(self.geometry.path, self.problems.values())

    def _labels(self, volume: Volume) -> list[str]:
        """What daughters are called, no two alike: with the copy number where that tells them apart."""
        if id(volume) not in self.labels:
            self.labels[id(volume)] = labels_of(volume)
        return self.labels[id(volume)]


def labels_of(volume: Volume) -> list[str]:
    """layer, calorimeter[3]; of those that are still alike, the second gets a #2."""
    numbered = [
        daughter.label if daughter.copy is None else f"{daughter.label}[{daughter.copy}]"
        for daughter in volume.daughters
    ]
    taken: set[str] = set(numbered)
    seen: Counter[str] = Counter()
    found = []
    for label in numbered:
        seen[label] += 1
        unique = label
        if seen[label] > 1:
            while (unique := f"{label}#{seen[label]}") in taken:
                seen[label] += 1
            taken.add(unique)
        found.append(unique)
    return found


def path_of(world: Volume) -> Path:
    """The beginning of every path; nothing for a world that is no body."""
    from .reading import shown_name

    return () if world.is_container else (shown_name(world.name) or "world",)
