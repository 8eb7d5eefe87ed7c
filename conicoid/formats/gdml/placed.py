"""Volumes at their places: worked out once for each way in which they stand, and then moved."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

from ...shapes.base import Solid
from ...shapes.box import Box
from ...shapes.ellipsoid import Ellipsoid
from ...shapes.motion import STILL, Motion
from ...shapes.polyhedron import Polyhedron
from ...shapes.region import Difference, Intersection, Union
from ...shapes.repeated import Shift
from ...shapes.revolution import Revolution
from ...shapes.sphere import Sphere
from ..openmc.block import Block, Path, Piece
from ..openmc.imported_bodies import RIGID, PlacedBodies
from ..openmc.placement import UNTURNED, Turn, floats, plus, turned_by
from .placement import ORIGIN, Placement, Point, Rotation
from .reading import LeftOut
from .structure import Volume
from .templates import Template


@dataclass(frozen=True)
class Place:
    """Where something stands within a block: turned and shifted, then turned by `outer`, then shifted by `lift`.

    Where nothing turns by other angles than quarter turns, `shift` is all of it, and the block may stand anywhere.
    """

    turn: Turn = UNTURNED
    shift: Point = ORIGIN
    outer: Motion = STILL
    lift: Point = ORIGIN

    @property
    def is_straight(self) -> bool:
        """Is it only turned by quarter turns and shifted?"""
        return self.outer is STILL or self.outer.is_identity

    @property
    def may_stand_anywhere(self) -> bool:
        """Is it turned about its own origin, so that only a shift in the world says where it is?"""
        return self.is_straight or not any(self.shift)

    def about_itself(self) -> tuple[Place, Point]:
        """The place about its own origin, and where that is."""
        if self.is_straight:
            return Place(self.turn), self.shift
        return Place(self.turn, ORIGIN, self.outer), self.lift

    def lifted(self, by: Point) -> Place:
        """The whole moved."""
        if not any(by):
            return self
        if self.is_straight:
            return Place(self.turn, plus(self.shift, by), self.outer, self.lift)
        return Place(self.turn, self.shift, self.outer, plus(self.lift, by))

    def inner(self, shift: Point, rotation: Rotation) -> Place:
        """The place of what is rotated and then shifted within this."""
        before = Placement(self.turn, self.shift)
        if rotation.motion.is_identity:
            there = before.inner(shift, rotation)
            return Place(there.turn, there.shift, self.outer, self.lift)
        if self.is_straight:
            return Place(outer=turned_by(rotation.motion, self.turn), lift=before.point(shift))
        whole = before.inner(shift, rotation)
        return Place(outer=whole.outer.then(self.outer), lift=self.lift)

    def moved(self, by: Shift) -> Placement:
        """In the world, the block being moved."""
        if self.is_straight:
            return Placement(self.turn, plus(self.shift, by))
        whole = plus(self.lift, by)
        outer = self.outer.translate(floats(whole)) if any(whole) else self.outer
        return Placement(self.turn, self.shift, outer)


Standing = tuple[Template, Place]
"""A solid at a place of a block."""


@dataclass(eq=False)
class VolumePiece(Piece):
    """A volume's solid, and what is placed in it."""

    volume: Volume
    own: Standing
    displaced: tuple[Standing, ...]

    def made(self, shift: Shift) -> Solid:
        """The solid less what is placed in it, the block being moved. Raises LeftOut, ValueError, OverflowError."""
        own, *others = (template.at(place.moved(shift)) for template, place in (self.own, *self.displaced))
        return Difference((own, *others)) if others else own


class VolumeBlock(Block[VolumePiece]):
    """Volumes are called by the way to them."""

    @staticmethod
    def called(title: str, path: Path) -> str:
        """world/calorimeter[3]/layer"""
        return "/".join((*path, title) if title else path)

    @staticmethod
    def may_lead(path: Path, name: str) -> bool:
        """Is the way the beginning of the name?"""
        way = "/".join(path)
        return name.startswith(way) and name[len(way) : len(way) + 1] in ("", "/")


class VolumeBodies(PlacedBodies[VolumePiece]):
    """The bodies of a GDML file."""

    def made(self, kind: int, shift: Shift) -> Solid:
        """A volume less what is placed in it, moved by a shift. Raises ValueError where it cannot be made there."""
        try:
            return self._pieces[kind].made(shift)
        except LeftOut as left:
            raise ValueError(str(left)) from None

    def is_rigid(self, kind: int) -> bool:
        """Are its parts of kinds that rounding cannot change, and none of them so thin that it may close?"""
        piece = self._pieces[kind]
        straight = all(place.is_straight for _, place in (piece.own, *piece.displaced))
        return straight and is_rigid(self.shape(int(self.members[kind][0])), self.farthest)


def is_rigid(solid: Solid, far: Fraction) -> bool:
    """Has a solid the same structure wherever it is made within some distance, however its numbers are rounded?"""
    pending = [solid]
    while pending:
        each = pending.pop()
        if isinstance(each, Union | Difference | Intersection):
            pending.extend(each.operands)
            continue
        least = _least(each)
        if least is None or least[0] <= RIGID * (2 * far + least[1]):
            return False
    return True


def _least(solid: Solid) -> tuple[Fraction, Fraction] | None:
    """(the least thickness along an axis that rounding must leave, how far it reaches); None for other kinds."""
    if isinstance(solid, Box):
        ends = list(zip(map(Fraction, solid.low), map(Fraction, solid.high), strict=True))
        return min(b - a for a, b in ends), max(max(abs(a), abs(b)) for a, b in ends)
    if isinstance(solid, Sphere):
        return Fraction(solid.radius), max(map(abs, map(Fraction, solid.center)))
    if isinstance(solid, Ellipsoid):
        return min(map(Fraction, solid.radii)), max(map(abs, map(Fraction, solid.center)))
    if isinstance(solid, Revolution):
        heights = sorted({Fraction(z) for _, z in solid.profile})
        return min(b - a for a, b in pairwise(heights)), max(map(abs, heights))
    if isinstance(solid, Polyhedron):
        return _least_of_planes(solid)
    return None


def _least_of_planes(solid: Polyhedron) -> tuple[Fraction, Fraction]:
    """Between parallel planes, the normals being as they are wherever it stands."""
    planes: dict[tuple[Fraction, ...], set[Fraction]] = {}
    for normal, offset in zip(solid.normals, solid.offsets, strict=True):
        size = max(abs(Fraction(c)) for c in normal)
        unit = tuple(Fraction(c) / size for c in normal)
        sign = 1 if unit > ORIGIN else -1
        planes.setdefault(tuple(sign * c for c in unit), set()).add(sign * Fraction(offset) / size)
    gaps = [b - a for offsets in planes.values() for a, b in pairwise(sorted(offsets))]
    reach = max(abs(offset) for offsets in planes.values() for offset in offsets)
    return min(gaps, default=reach or Fraction(1)), reach
