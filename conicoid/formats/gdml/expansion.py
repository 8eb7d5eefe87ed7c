"""The bodies of a GDML geometry: each volume at each of its places, less what is placed in it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from ...shapes.base import Solid
from ...shapes.body import Body
from ...shapes.material import Material
from ...shapes.region import Difference
from ..errors import MOST, Problem, SceneFileError
from ..imports.imported import counted
from .geometry import Geometry
from .materials import NamedMaterial
from .placement import Placement
from .reading import LeftOut
from .structure import Daughter, Volume

DEEPEST = 100
"""Levels of volumes in volumes."""
PARTS_FOR_A_BODY = 4
"""Primitives for each body that is allowed."""

NO_MATERIAL = Material((0.0, 0.0, 0.0), ambient=0.0, diffuse=0.0, transparency=1.0, name="no material")


@dataclass
class Expansion:
    """Makes the bodies of a geometry. `levels`: how many of nested volumes are opened."""

    geometry: Geometry
    void: bool
    levels: int
    max_bodies: int
    progress: Callable[[int, int], Any] | None = None
    bodies: list[Body] = field(default_factory=list)
    materials: Counter[NamedMaterial | None] = field(default_factory=Counter)
    looks: dict[NamedMaterial | None, Material] = field(default_factory=lambda: {None: NO_MATERIAL})
    filled: int = 0
    known: dict[tuple[int, int], tuple[int, int]] = field(default_factory=dict)
    labels: dict[int, list[str]] = field(default_factory=dict)
    problems: dict[int, Problem] = field(default_factory=dict)
    most: int = 0

    def run(self) -> None:
        """All of it. Raises SceneFileError for mistakes, and for too many bodies before any is made."""
        world = self.geometry.world
        self.most, parts = self.count(world, self.levels, 0)
        if self.most > self.max_bodies or parts > PARTS_FOR_A_BODY * self.max_bodies:
            found = counted(self.most, "body") if self.most > self.max_bodies else counted(parts, "solid")
            told = "raise it where there is memory for them, or open fewer levels (depth)"
            message = f"expands into {found}; the limit is {self.max_bodies:,} (max_bodies): {told}"
            raise SceneFileError(self.geometry.path, [Problem(world.element.line, world.element.column, "", message)])
        self.expand(world, Placement(), world_name(world), self.levels)
        if self.problems:
            raise SceneFileError(self.geometry.path, self.problems.values())
        self.bodies = [body for body in self.bodies if body is not None]

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

    def expand(self, volume: Volume, placement: Placement, path: str, levels: int) -> list[Solid]:
        """The bodies of a volume and of all in it. Gives what of its surroundings it displaces."""
        slot = len(self.bodies)
        own = self._solid(volume, placement, path)
        if own is not None:
            self.bodies.append(None)  # type: ignore[arg-type]
        displaced: list[Solid] = []
        if levels > 0 or volume.is_open:
            inner = levels if volume.is_open else levels - 1
            for daughter, label in zip(volume.daughters, self._labels(volume), strict=True):
                there = self._there(volume, daughter, placement, path)
                if there is None:
                    continue
                displaced += self.expand(daughter.volume, there, f"{path}/{label}" if path else label, inner)
            if own is not None and volume.is_filled and displaced:
                self.filled += 1
                return [own]
        if own is None:
            return displaced
        self._place(slot, volume, Difference((own, *displaced)) if displaced else own, path)
        return [own]

    def _place(self, slot: int, volume: Volume, solid: Solid, path: str) -> None:
        material = volume.material
        if not self.void and (material is None or material.is_thin):
            return
        if material not in self.looks:
            assert material is not None
            self.looks[material] = material.look
        self.bodies[slot] = Body(solid, self.looks[material], path)
        done = self.materials.total()
        self.materials[material] += 1
        if self.progress is not None and done % 256 == 0:
            self.progress(done, self.most)

    def _solid(self, volume: Volume, placement: Placement, path: str) -> Solid | None:
        if volume.template is None:
            return None
        try:
            return volume.template.at(placement)
        except LeftOut as left:
            self.geometry.reading.remark(volume.element, path, f"{left}; left out there")
        except (ValueError, OverflowError) as error:
            self._report(volume, path, error)
        return None

    def _there(self, volume: Volume, daughter: Daughter, placement: Placement, path: str) -> Placement | None:
        try:
            return placement.inner(daughter.shift, daughter.rotation)
        except (ValueError, OverflowError) as error:
            self._report(volume, path, error)
            return None

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


def world_name(volume: Volume) -> str:
    """The first part of every path; nothing for a world that is no body."""
    from .reading import shown_name

    return "" if volume.is_container else shown_name(volume.name) or "world"
