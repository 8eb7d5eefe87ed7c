"""What an import gives: bodies, the legend of their materials, and what there is to say about it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from itertools import islice
from typing import Any

from ...shapes.base import Solid
from ...shapes.body import Body
from ...shapes.material import Material
from ..errors import SHOWN, printable
from ..nodes import shortened


@dataclass(frozen=True)
class LegendEntry:
    """A material with its colour and how many bodies have it.

    `material` is its number in the file; None where it has none, and for void, whose `color` is None too.
    """

    material: int | None
    name: str
    color: str | None
    bodies: int

    def __str__(self) -> str:
        number = f"material {self.material}" if self.material is not None else "void" if self.color is None else ""
        name = printable(shortened(self.name))
        bodies = "body  " if self.bodies == 1 else "bodies"
        return f"{self.color or 'invisible':<9}  {number:<14} {self.bodies:>9,} {bodies}  {name}".rstrip()


@dataclass(frozen=True)
class Imported:
    """The parts of a scene, which `conicoid.Scene` and `conicoid.save` take, with `legend` and `notes`."""

    bodies: Sequence[Body]
    legend: tuple[LegendEntry, ...]
    notes: tuple[str, ...]
    """All that there is to say: how large it is, and the remarks."""
    remarks: tuple[str, ...] = ()
    """Those of the notes that tell what is not as the file says, or may not be meant."""
    material_names: Mapping[Material, str] = field(default_factory=dict)  # as in the legend, for scene files
    lights: tuple[Any, ...] = ()
    camera: Any = None
    background: Any = None
    domain: Solid | None = None
    """What bodies are to fill, where the file says that."""


def only_named(imported: Imported, pattern: str) -> Imported:
    """Only the bodies that a pattern names (`is_named`). Raises ValueError where it names none."""
    bodies = [body for body in imported.bodies if is_named(pattern, body.name or "")]
    if not bodies:
        raise ValueError(f"load: only {pattern!r} names none of {counted(len(imported.bodies), 'body')}")
    left = Counter(body.material for body in bodies)
    names = {material: name for material, name in imported.material_names.items() if material in left}
    told = f"{counted(len(bodies), 'body')} of {len(imported.bodies):,} named by {pattern!r}"
    notes = (*imported.notes, told)
    return replace(imported, bodies=bodies, legend=(), notes=notes, material_names=names, domain=None)


def is_named(pattern: str, name: str) -> bool:
    """Is a text in a name or, with * and ?, a pattern of all of it? Capital letters count."""
    if "*" in pattern or "?" in pattern:
        return fnmatchcase(name, pattern)
    return pattern in name


def counted(count: int, what: str) -> str:
    """3 cells"""
    plural = what[:-1] + "ies" if what.endswith("y") else what + "s"
    return f"{count:,} {what if count == 1 else plural}"


def first_few(notes: Iterable[str]) -> Iterator[str]:
    """The first few of many notes of a kind, and how many more there are."""
    kept = list(islice(notes := iter(notes), SHOWN))
    yield from kept
    more = sum(1 for _ in notes)
    if more:
        yield f"... and {more:,} more like this"
