"""Solid templates: solids without a place, built at each place where they are needed; and their placements in blocks.

Building at the place keeps walls that coincide on paper equal in floating point: the translation is applied in
fractions to the numbers that describe the solid, which are then rounded once; quarter turns follow and are exact; other
rotations become a motion. `is_rigid` shows that rounding changes the structure of a solid at none of its places.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Sequence
from dataclasses import field, replace
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from typing import Literal

from ..._util.records import dataclass
from ...geometry.instances import Shift
from ...geometry.polyhedron import Polyhedron
from ...geometry.primitives import Box, Sphere
from ...geometry.quadrics import Ellipsoid
from ...geometry.revolution import Revolution
from ...geometry.shape import Difference, Intersection, Solid, Union
from ...geometry.transform import IDENTITY_MOTION, Motion, Translate
from ..openmc.placement import (
    NO_TURN,
    ORIGIN,
    AxisTurn,
    CellRotation,
    Point,
    UniversePlacement,
    add_points,
    motion_of_turn,
    split_shift,
    to_floats,
    turn_motion,
)
from ..openmc.universe_block import RIGID_TOLERANCE, plane_gaps

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


# Placements in the blocks of volumes.


@dataclass(frozen=True)
class GdmlPlacement:
    """A placement within a block: quarter turn and shift, then the motion `outer`, then the shift `lift` (mm).

    If all rotations are quarter turns, `outer` is the identity, `shift` is the whole translation, and the block may
    stand anywhere.
    """

    turn: AxisTurn = NO_TURN
    shift: Point = ORIGIN
    outer: Motion = IDENTITY_MOTION
    lift: Point = ORIGIN

    @property
    def is_straight(self) -> bool:
        """Return True for quarter turns and shifts only."""
        return not self.outer.steps

    @property
    def may_stand_anywhere(self) -> bool:
        """Return True if the rotation is about the own origin, so that a shift in the world moves it exactly."""
        return self.is_straight or not any(self.shift)

    def about_itself(self) -> tuple[GdmlPlacement, Point]:
        """Return the placement about its own origin, and the position of that origin."""
        if self.is_straight:
            return GdmlPlacement(self.turn), self.shift
        return GdmlPlacement(self.turn, ORIGIN, self.outer), self.lift

    def lifted(self, by: Point) -> GdmlPlacement:
        """Return the placement translated."""
        if self.is_straight:
            return GdmlPlacement(self.turn, add_points(self.shift, by), self.outer, self.lift)
        return GdmlPlacement(self.turn, self.shift, self.outer, add_points(self.lift, by))

    def inner(self, shift: Point, rotation: CellRotation) -> GdmlPlacement:
        """Return the placement of a daughter that is rotated and then shifted within this placement.

        Raise ValueError or OverflowError if its numbers make no motion.
        """
        # Fractions and quarter turns: the part of the motion that is exact
        before = UniversePlacement(self.turn, self.shift)
        # Quarter turns and shifts stay exact before `outer`; any other rotation begins a new outer motion.
        if rotation.motion.is_identity:
            daughter = before.inner(shift, rotation)
            return GdmlPlacement(daughter.turn, daughter.shift, self.outer, self.lift)
        if self.is_straight:
            return GdmlPlacement(outer=turn_motion(rotation.motion, self.turn), lift=before.point(shift))
        whole = before.inner(shift, rotation)
        return GdmlPlacement(outer=whole.outer.then(self.outer), lift=self.lift)

    @cached_property
    def key(self) -> Hashable:
        """Equal for placements that differ by a translation of their blocks; the outer motion counts by identity."""
        # Fractions and the fields of a motion are slow to hash, and so are the objects that hold them
        own = () if self.may_stand_anywhere else tuple(value.as_integer_ratio() for value in self.shift)
        return self.turn.sources, self.turn.signs, id(self.outer), own

    def at(self, whole: Point) -> UniversePlacement:
        """Return the placement in the world with `whole` in place of its last shift."""
        if self.is_straight:
            return UniversePlacement(self.turn, whole)
        _ = self.outer.reach  # which the longer motion takes over, of all places
        before, after = split_shift(self.outer, whole)
        outer = self.outer.then(Motion((Translate(to_floats(after)),))) if any(after) else self.outer
        return UniversePlacement(self.turn, add_points(self.shift, before), outer)


PlacedTemplate = tuple[SolidTemplate, GdmlPlacement]
"""A solid and its placement in a block."""


def place_solid(template: SolidTemplate, place: GdmlPlacement, shift: Shift) -> Solid:
    """Build a solid with the block that it stands in translated by `shift`; the first `MOST_HELD` are held.

    A daughter's solid stands in the bodies of both its volume and its mother.
    """
    x, y, z = whole = add_points(place.shift if place.is_straight else place.lift, shift)
    key = x.as_integer_ratio(), y.as_integer_ratio(), z.as_integer_ratio(), place.key
    found = template.held.get(key)
    if found is None or found[0] is not place.outer:  # a pickle has ids of before, which others may have now
        found = place.outer, template.at(place.at(whole))
        if len(template.held) < MOST_HELD:
            template.held[key] = found
    return found[1]


# Solids that rounding does not change.


def is_rigid(solid: Solid, far: Fraction) -> bool:
    """Return True if a solid has the same structure wherever it is built within the distance `far`, despite rounding.

    Each primitive must be thicker along the axes than `RIGID_TOLERANCE` times its largest coordinate.
    """
    pending = [solid]
    while pending:  # a loop in place of a recursion, as Booleans may be deep
        each = pending.pop()
        if isinstance(each, Union | Difference | Intersection):
            pending.extend(each.operands)
            continue
        least = _rounding_margin(each)
        # A unit in the last place of a coordinate is a share of 2^-53: a body whose thickness is far above that at its
        # farthest place keeps the order of its faces
        if least is None or least[0] <= RIGID_TOLERANCE * (2 * far + least[1]):
            return False
    return True


def _rounding_margin(solid: Solid) -> tuple[Fraction, Fraction] | None:
    """Return (least thickness that rounding must not close, largest coordinate); None for other kinds of solids."""
    if isinstance(solid, Box):
        ends = list(zip(map(Fraction, solid.low), map(Fraction, solid.high), strict=True))
        return min(b - a for a, b in ends), max(max(abs(a), abs(b)) for a, b in ends)
    if isinstance(solid, Sphere):
        return Fraction(solid.radius), max(map(abs, map(Fraction, solid.center)))
    if isinstance(solid, Ellipsoid):
        return min(map(Fraction, solid.radii)), max(map(abs, map(Fraction, solid.center)))
    if isinstance(solid, Revolution):
        # Radii do not move with the body: a shift along z is added to heights alone, and one across z is a translation
        heights = sorted({Fraction(z) for _, z in solid.profile})
        return min(b - a for a, b in pairwise(heights)), max(map(abs, heights))
    if isinstance(solid, Polyhedron):
        # Normals are the same everywhere
        planes = zip(solid.normals, solid.offsets, strict=True)
        gaps, reach = plane_gaps(
            ((Fraction(x), Fraction(y), Fraction(z)), Fraction(offset)) for (x, y, z), offset in planes
        )
        return min(gaps, default=reach or Fraction(1)), reach
    return None
