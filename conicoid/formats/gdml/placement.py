"""How GDML turns and mirrors: about x, then y, then z; Booleans as written, placements the other way."""

from __future__ import annotations

from fractions import Fraction

from ...shapes.motion import STILL
from ..openmc.placement import ORIGIN, STRAIGHT, UNTURNED, Placement, Point, Rotation, Turn, moved, rotation_by_angles

__all__ = [
    "ORIGIN",
    "STRAIGHT",
    "Placement",
    "Point",
    "Rotation",
    "Turn",
    "after",
    "moved",
    "placed",
    "scaled",
    "turned",
]

_NONE = Fraction(0)


def turned(angles: Point) -> Rotation:
    """In degrees, about x, then y, then z: what a Boolean does to its operand."""
    found = STRAIGHT
    for axis, angle in enumerate(angles):
        alone = [_NONE, _NONE, _NONE]
        alone[axis] = angle
        found = after(rotation_by_angles((alone[0], alone[1], alone[2])), found)
    return found


def placed(angles: Point) -> Rotation:
    """The inverse of `turned`: what a placement does to its volume (G4GDMLReadStructure::PhysvolRead)."""
    x, y, z = angles
    return rotation_by_angles((-x, -y, -z))


def scaled(factors: Point) -> Rotation:
    """Mirrors are exchanges of axes; other factors are motions. Raises ValueError for one that is zero."""
    if all(abs(factor) == 1 for factor in factors):
        x, y, z = (int(factor) for factor in factors)
        return Rotation(Turn(signs=(x, y, z)))
    return Rotation(motion=STILL.scale(tuple(map(float, factors))))


def after(last: Rotation, first: Rotation) -> Rotation:
    """`first`, then `last`."""
    if first.motion.is_identity and last.motion.is_identity:
        return Rotation(last.turn.after(first.turn))
    motion = STILL
    for part in (first, last):
        if part.turn != UNTURNED:
            rows = [(*map(float, row), 0.0) for row in part.turn.rows]
            motion = motion.transform((*rows, (0.0, 0.0, 0.0, 1.0)))
        motion = motion.then(part.motion)
    return Rotation(motion=motion)
