"""Solid templates: solids without a place, built at each place where they are needed.

Building at the place keeps walls that coincide on paper equal in floating point: the translation is applied in
fractions to the numbers that describe the solid, which are then rounded once; quarter turns follow and are exact; other
rotations become a motion.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Sequence
from dataclasses import field, replace
from fractions import Fraction
from functools import cached_property
from typing import Literal

from ..._util.dataclass import dataclass
from ...geometry.shape import Difference, Intersection, Solid, Union
from ...geometry.transform import Motion
from ..openmc.placement import (
    NO_TURN,
    ORIGIN,
    CellRotation,
    Point,
    UniversePlacement,
    motion_of_turn,
    split_shift,
    turn_motion,
)

SolidFactory = Callable[[Point], Solid]
"""Builds a solid, translated by a shift in mm."""
BooleanKind = Literal["union", "subtraction", "intersection"]
MOST_HELD = 1 << 11
"""Most solids that a template or a profile holds."""
MAX_SOLID_PARTS, MAX_BOOLEAN_DEPTH = 4_000, 100
"""Most primitives of one solid, and most levels of nested Booleans; a chain of one kind counts as one level."""


@dataclass(frozen=True)
class SourceElement:
    """A primitive as a file has it: its tag, its numbers and units by attribute, its parts, and its `shift` in mm."""

    tag: str
    values: tuple[tuple[str, Fraction | str], ...]
    parts: tuple[SourceElement, ...] = ()
    shift: Point = ORIGIN


@dataclass(eq=False)
class SharedSolid:
    """Builds a solid once, at the origin, for all places: one that takes long to cut into convex parts."""

    make: SolidFactory

    @cached_property
    def _solid(self) -> Solid:
        return self.make(ORIGIN)

    def __call__(self, shift: Point) -> Solid:
        x, y, z = map(float, shift)
        return self._solid.translate((x, y, z))


class SolidTemplate(ABC):
    """A solid that can be built at any placement. `parts` counts its primitives, `depth` its nested Booleans.

    `held` has some of the solids by their places in blocks (`VolumePiece`), with the motions that keys name by id.
    """

    parts: int
    depth: int
    held: dict[Hashable, tuple[Motion, Solid]]

    @abstractmethod
    def at(self, placement: UniversePlacement) -> Solid:
        """Build the solid at a placement. Raise ValueError or OverflowError if its numbers make no solid there."""


@dataclass(eq=False)
class PrimitiveTemplate(SolidTemplate):
    """A primitive: `make` builds it from its numbers, translated by a shift.

    `cache` holds some of the solids by their shifts before any turn. Solids keep `source`, if there is one, for the
    exporter.
    """

    make: SolidFactory
    source: SourceElement | None = None
    parts: int = 1
    depth: int = 0
    cache: dict[tuple[tuple[int, int], ...], Solid] = field(default_factory=dict)
    held: dict[Hashable, tuple[Motion, Solid]] = field(default_factory=dict)

    def at(self, placement: UniversePlacement) -> Solid:
        # The shift follows the turn, so the inverse turn brings it before the turn, where it is exact.
        shift = placement.turn.inverse.apply(placement.shift)
        key = tuple(value.as_integer_ratio() for value in shift)
        solid = self.cache.get(key)
        if solid is None:
            solid = self.make(shift)
            _ = solid.motion.reach  # which the motions of all copies take over
            if self.source is not None and solid.motion.is_identity:
                vars(solid)["_source"] = replace(self.source, shift=shift)
            if len(self.cache) < MOST_HELD:
                self.cache[key] = solid
        motion = placement.outer
        if placement.turn != NO_TURN:
            motion = motion_of_turn(placement.turn).then(motion)
        return solid if motion.is_identity else solid._moved(solid.motion.then(motion))


TemplateOperand = tuple[SolidTemplate, Point, CellRotation]
"""A template that is rotated and then shifted."""


def _inner_placement(placement: UniversePlacement, shift: Point, rotation: CellRotation) -> UniversePlacement:
    """Return `placement.inner`, with the part of the shift that the rotation keeps along an axis in fractions."""
    if rotation.motion.is_identity:
        return placement.inner(shift, rotation)
    before, after = split_shift(turn_motion(rotation.motion, placement.turn), placement.point(shift))
    motion = UniversePlacement(placement.turn).entry(placement.turn.inverse.apply(after), rotation)
    return UniversePlacement(shift=before, outer=motion.then(placement.outer))


@dataclass(eq=False)
class BooleanTemplate(SolidTemplate):
    """A Boolean of operands, each rotated and then shifted. Its placement is passed down to the primitives."""

    kind: BooleanKind
    operands: tuple[TemplateOperand, ...]
    parts: int
    depth: int
    held: dict[Hashable, tuple[Motion, Solid]] = field(default_factory=dict)

    def at(self, placement: UniversePlacement) -> Solid:
        solids = tuple(
            template.at(_inner_placement(placement, shift, rotation)) for template, shift, rotation in self.operands
        )
        if len(solids) == 1:
            return solids[0]
        return {"union": Union, "subtraction": Difference, "intersection": Intersection}[self.kind](solids)


def combine_templates(kind: BooleanKind, operands: Sequence[TemplateOperand]) -> BooleanTemplate:
    """Return a Boolean of operands, with nested Booleans of the same kind merged into it.

    Raise ValueError if it has more than `MAX_SOLID_PARTS` primitives or `MAX_BOOLEAN_DEPTH` levels.
    """
    merged: list[TemplateOperand] = []
    for number, (template, shift, rotation) in enumerate(operands):
        opens = isinstance(template, BooleanTemplate) and template.kind == kind and not any(shift)
        # (a - b) - c is a - b - c, but a - (b - c) is not: only the first operand of a subtraction can be merged.
        if opens and rotation == CellRotation() and (number == 0 or kind != "subtraction"):
            assert isinstance(template, BooleanTemplate)
            merged += template.operands
        else:
            merged.append((template, shift, rotation))
    parts, depth = sum(part.parts for part, _, _ in merged), 1 + max(part.depth for part, _, _ in merged)
    if parts > MAX_SOLID_PARTS:
        raise ValueError(f"must be of at most {MAX_SOLID_PARTS:,} solids, got {parts:,}")
    if depth > MAX_BOOLEAN_DEPTH:
        raise ValueError(f"must nest at most {MAX_BOOLEAN_DEPTH} levels of Booleans")
    return BooleanTemplate(kind, tuple(merged), parts, depth)
