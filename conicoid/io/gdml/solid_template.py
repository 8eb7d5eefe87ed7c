"""Solids before they stand anywhere: made where they are wanted, so that what coincides on paper gets equal numbers.

A translation is carried out in fractions on the numbers that describe a solid, which are then rounded once; quarter
turns follow, which are exact; other turns are a motion.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Literal

from ...geometry.csg import Difference, Intersection, Union
from ...geometry.shape import Solid
from ...geometry.transform import IDENTITY_MOTION, Motion
from ..openmc.placement import NO_TURN, CellRotation, Point, UniversePlacement

SolidFactory = Callable[[Point], Solid]
BooleanKind = Literal["union", "subtraction", "intersection"]
MAX_SOLID_PARTS, MAX_BOOLEAN_DEPTH = 4_000, 100
"""Primitives of one solid, and Booleans within Booleans where these are no chain."""


class SolidTemplate(ABC):
    """A solid to be made at places. `parts` counts its primitives, `depth` its Booleans within Booleans."""

    parts: int
    depth: int

    @abstractmethod
    def at(self, placement: UniversePlacement) -> Solid:
        """The solid there."""


@dataclass(eq=False)
class PrimitiveTemplate(SolidTemplate):
    """A solid from numbers; `make` gives it moved by a shift."""

    make: SolidFactory
    parts: int = 1
    depth: int = 0
    known: dict[tuple[tuple[int, int], ...], Solid] = field(default_factory=dict)  # by terms of fractions

    def at(self, placement: UniversePlacement) -> Solid:
        x, y, z = placement.turn.inverse.apply(placement.shift)
        key = x.as_integer_ratio(), y.as_integer_ratio(), z.as_integer_ratio()
        found = self.known.get(key)
        if found is None:
            found = self.make((x, y, z))
            if len(self.known) < 64:
                self.known[key] = found
        if placement.turn is NO_TURN and placement.outer is IDENTITY_MOTION:
            return found
        motion = IDENTITY_MOTION if placement.turn == NO_TURN else _motion_of(placement)
        whole = found.motion.then(motion).then(placement.outer)
        if whole == found.motion:
            return found
        return found._moved(whole)


def _motion_of(placement: UniversePlacement) -> Motion:
    rows = [(*map(float, row), 0.0) for row in placement.turn.rows]
    return IDENTITY_MOTION.transform((*rows, (0.0, 0.0, 0.0, 1.0)))


TemplateOperand = tuple[SolidTemplate, Point, CellRotation]


@dataclass(eq=False)
class BooleanTemplate(SolidTemplate):
    """A Boolean of operands, each turned and then shifted."""

    kind: BooleanKind
    operands: tuple[TemplateOperand, ...]
    parts: int
    depth: int

    def at(self, placement: UniversePlacement) -> Solid:
        made = tuple(template.at(placement.inner(shift, rotation)) for template, shift, rotation in self.operands)
        if len(made) == 1:
            return made[0]
        return {"union": Union, "subtraction": Difference, "intersection": Intersection}[self.kind](made)


def combine_templates(kind: BooleanKind, operands: Sequence[TemplateOperand]) -> BooleanTemplate:
    """A Boolean; a chain of one kind is one. Raises ValueError where it is too large."""
    found: list[TemplateOperand] = []
    for number, (template, shift, rotation) in enumerate(operands):
        opens = isinstance(template, BooleanTemplate) and template.kind == kind and not any(shift)
        if opens and rotation == CellRotation() and (number == 0 or kind != "subtraction"):
            assert isinstance(template, BooleanTemplate)
            found += template.operands
        else:
            found.append((template, shift, rotation))
    parts, depth = sum(part.parts for part, _, _ in found), 1 + max(part.depth for part, _, _ in found)
    if parts > MAX_SOLID_PARTS:
        raise ValueError(f"must be of at most {MAX_SOLID_PARTS:,} solids, got {parts:,}")
    if depth > MAX_BOOLEAN_DEPTH:
        raise ValueError(f"must nest at most {MAX_BOOLEAN_DEPTH} levels of Booleans")
    return BooleanTemplate(kind, tuple(found), parts, depth)
