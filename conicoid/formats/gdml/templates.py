"""Solids before they stand anywhere: made where they are wanted, so that what coincides on paper gets equal numbers.

A translation is carried out in fractions on the numbers that describe a solid, which are then rounded once; quarter
turns follow, which are exact; other turns are a motion.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Literal

from ...shapes.base import Solid
from ...shapes.motion import STILL, Motion
from ...shapes.region import Difference, Intersection, Union
from ..openmc.placement import UNTURNED
from .placement import Placement, Point, Rotation

Make = Callable[[Point], Solid]
Kind = Literal["union", "subtraction", "intersection"]
MOST_PARTS, DEEPEST = 4_000, 100
"""Primitives of one solid, and Booleans within Booleans where these are no chain."""


class Template(ABC):
    """A solid to be made at places. `parts` counts its primitives, `depth` its Booleans within Booleans."""

    parts: int
    depth: int

    @abstractmethod
    def at(self, placement: Placement) -> Solid:
        """The solid there."""


@dataclass(eq=False)
class Primitive(Template):
    """A solid from numbers; `make` gives it moved by a shift."""

    make: Make
    parts: int = 1
    depth: int = 0
    known: dict[tuple[tuple[int, int], ...], Solid] = field(default_factory=dict)  # by terms of fractions

    def at(self, placement: Placement) -> Solid:
        x, y, z = placement.turn.inverse.apply(placement.shift)
        key = x.as_integer_ratio(), y.as_integer_ratio(), z.as_integer_ratio()
        found = self.known.get(key)
        if found is None:
            found = self.make((x, y, z))
            if len(self.known) < 64:
                self.known[key] = found
        if placement.turn is UNTURNED and placement.outer is STILL:
            return found
        motion = STILL if placement.turn == UNTURNED else _motion_of(placement)
        whole = found.motion.then(motion).then(placement.outer)
        if whole == found.motion:
            return found
        return found._moved(whole)


def _motion_of(placement: Placement) -> Motion:
    rows = [(*map(float, row), 0.0) for row in placement.turn.rows]
    return STILL.transform((*rows, (0.0, 0.0, 0.0, 1.0)))


Operand = tuple[Template, Point, Rotation]


@dataclass(eq=False)
class Combined(Template):
    """A Boolean of operands, each turned and then shifted."""

    kind: Kind
    operands: tuple[Operand, ...]
    parts: int
    depth: int

    def at(self, placement: Placement) -> Solid:
        made = tuple(template.at(placement.inner(shift, rotation)) for template, shift, rotation in self.operands)
        if len(made) == 1:
            return made[0]
        return {"union": Union, "subtraction": Difference, "intersection": Intersection}[self.kind](made)


def combined(kind: Kind, operands: Sequence[Operand]) -> Combined:
    """A Boolean; a chain of one kind is one. Raises ValueError where it is too large."""
    found: list[Operand] = []
    for number, (template, shift, rotation) in enumerate(operands):
        opens = isinstance(template, Combined) and template.kind == kind and not any(shift)
        if opens and rotation == Rotation() and (number == 0 or kind != "subtraction"):
            assert isinstance(template, Combined)
            found += template.operands
        else:
            found.append((template, shift, rotation))
    parts, depth = sum(part.parts for part, _, _ in found), 1 + max(part.depth for part, _, _ in found)
    if parts > MOST_PARTS:
        raise ValueError(f"must be of at most {MOST_PARTS:,} solids, got {parts:,}")
    if depth > DEEPEST:
        raise ValueError(f"must nest at most {DEEPEST} levels of Booleans")
    return Combined(kind, tuple(found), parts, depth)
