"""Motions as GDML can say them: exchanges of axes and shifts, turns about an axis by an angle, stretches.

Exchanges and shifts are composed in decimals, which is what readers do with them.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias

from ....shapes import exact as ex
from ....shapes.motion import Motion
from ....shapes.steps import Frame, Rotate, Scale, Step, Transform, Translate
from ...gdml.placement import placed, turned
from ...openmc.placement import ORIGIN, UNTURNED, Point, Turn, rotation_by_angles
from ..exported import Unsayable
from ..numbers import decimal

_RIGHT = 1e-9
"""How far a matrix may be from a turn that is written as angles."""


@dataclass(frozen=True)
class Set:
    """x ↦ turn x + shift"""

    turn: Turn = UNTURNED
    shift: Point = ORIGIN

    def then(self, other: Set) -> Set:
        """One, and then the other."""
        moved = other.turn.apply(self.shift)
        return Set(other.turn.after(self.turn), _plus(moved, other.shift))

    @property
    def back(self) -> Set:
        """The way back."""
        turn = self.turn.inverse
        x, y, z = turn.apply(self.shift)
        return Set(turn, (-x, -y, -z))


@dataclass(frozen=True)
class Spin:
    """A turn about an axis of coordinates, in degrees."""

    axis: int
    degrees: Fraction


@dataclass(frozen=True)
class Stretch:
    """Scaled along the axes, by factors above 0."""

    factors: tuple[float, float, float]


Move: TypeAlias = Set | Spin | Stretch
Moves: TypeAlias = tuple[Move, ...]


def joined(*parts: Iterable[Move]) -> Moves:
    """One after the other, neighbours of one kind composed where that is exact."""
    found: list[Move] = []
    for move in itertools.chain(*parts):
        if isinstance(move, Set) and found and isinstance(found[-1], Set):
            found[-1] = found[-1].then(move)
        else:
            found.append(move)
        if found[-1] == Set():
            found.pop()
    return tuple(found)


def moves_of(steps: Sequence[Step]) -> tuple[Moves, bool]:
    """Steps, and whether a number of them had to be rounded. Raises Unsayable for what is no turn, shift or scaling."""
    found: list[Move] = []
    is_rounded = False
    for step in steps:
        if isinstance(step, Translate):
            found.append(Set(shift=_decimals(step.offset)))
        elif isinstance(step, Scale):
            found += _scaling(step)
        elif isinstance(step, Rotate) and sum(map(bool, step.axis)) == 1:
            found.append(_spin(step))
        elif isinstance(step, Transform) and _exchange(step) is not None:
            turn = _exchange(step)
            assert turn is not None
            found.append(Set(turn, _decimals(tuple(row[3] for row in step.matrix[:3]))))
        else:
            more, rounded = _by_angles(step)
            found += more
            is_rounded = is_rounded or rounded
    made = joined(found)
    return made, is_rounded or _loses(steps, made)


def _loses(steps: Sequence[Step], moves: Moves) -> bool:
    """Were shifts added up, so that their sums may have been rounded?"""
    shifts = sum(isinstance(step, Translate) for step in steps)
    return shifts > sum(isinstance(move, Set) for move in moves) and shifts > 1


def _decimals(values: Iterable[float]) -> Point:
    x, y, z = map(decimal, values)
    return x, y, z


def _plus(a: Point, b: Point) -> Point:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def _scaling(step: Scale) -> list[Move]:
    x, y, z = (1 if factor > 0 else -1 for factor in step.factors)
    sizes = tuple(map(abs, step.factors))
    found: list[Move] = [Stretch(sizes)] if sizes != (1.0, 1.0, 1.0) else []  # type: ignore[arg-type]
    return [*found, Set(Turn(signs=(x, y, z)))]


def _spin(step: Rotate) -> Move:
    axis = next(i for i in range(3) if step.axis[i])
    degrees = decimal(step.degrees) * (1 if step.axis[axis] > 0 else -1)
    if degrees % 90:
        return Spin(axis, degrees)
    angles = [Fraction(0)] * 3
    angles[axis] = degrees
    return Set(rotation_by_angles((angles[0], angles[1], angles[2])).turn)


def _exchange(step: Transform) -> Turn | None:
    """The exchange of axes that a matrix is."""
    rows = [row[:3] for row in step.matrix[:3]]
    lines = [*rows, *zip(*rows, strict=True)]
    if any(sorted(map(abs, line)) != [0, 0, 1] for line in lines):
        return None
    sources = [next(i for i in range(3) if row[i]) for row in rows]
    a, b, c = (int(row[i]) for row, i in zip(rows, sources, strict=True))
    return Turn((sources[0], sources[1], sources[2]), (a, b, c))


def _by_angles(step: Step) -> tuple[list[Move], bool]:
    """A turn about any axis as three about x, y and z, to the nearest floats; and its shift."""
    rows, shift = Motion((step,)).affine
    m = [[ex.rounded(value) for value in row] for row in rows]
    for i, j in itertools.product(range(3), range(3)):
        if abs(sum(a * b for a, b in zip(m[i], m[j], strict=True)) - (i == j)) > _RIGHT:
            what = "Transform" if isinstance(step, Transform) else type(step).__name__
            raise Unsayable(f"a motion of it ({what}) is no chain of turns, shifts and scalings along the axes")
    found: list[Move] = []
    if _determinant(m) < 0:
        m = [[row[0], row[1], -row[2]] for row in m]
        found.append(Set(Turn(signs=(1, 1, -1))))
    y = math.asin(max(-1.0, min(1.0, -m[2][0])))
    if math.hypot(m[0][0], m[1][0]) > 1e-12:
        x, z = math.atan2(m[2][1], m[2][2]), math.atan2(m[1][0], m[0][0])
    else:
        x, z = math.atan2(-m[1][2], m[1][1]), 0.0
    for axis, angle in enumerate((x, y, z)):
        if angle:
            found.append(_spin(Rotate(_AXES[axis], math.degrees(angle))))
    moved = tuple(ex.rounded(value) for value in shift)
    found.append(Set(shift=_decimals(moved)))
    return found, not isinstance(step, Frame) or len(found) > 1


_AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def _determinant(m: list[list[float]]) -> float:
    (a, b, c), (d, e, f), (g, h, i) = m
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)


def relative(moves: Moves, frame: Moves) -> Moves:
    """What leads to `moves` within a frame that is placed by others: what both end with is left out."""
    mine, its = list(moves), list(frame)
    while mine and its and mine[-1] == its[-1]:
        mine.pop()
        its.pop()
    return joined(mine, [_back(move) for move in reversed(its)])


def _back(move: Move) -> Move:
    """The way back; stretches are none of frames."""
    if isinstance(move, Spin):
        return Spin(move.axis, -move.degrees)
    assert isinstance(move, Set)
    return move.back


# ---- Moves as rotations and positions ----


@dataclass(frozen=True)
class Place:
    """A rotation by three angles, in the sense of whatever it is for, then a shift."""

    angles: Point = ORIGIN
    shift: Point = ORIGIN
    moves: Moves = ()
    """The same as moves."""


def last_place(moves: Moves, is_placement: bool) -> tuple[Moves, Place]:
    """The last moves as one rotation and shift, and those before.

    Operands of Booleans turn about x, then y, then z; placements about z, y, x, the other way (`is_placement`).
    """
    rest = list(moves)
    shift = ORIGIN
    if rest and isinstance(rest[-1], Set):
        last = rest.pop()
        assert isinstance(last, Set)
        shift = last.shift
        if last.turn != UNTURNED:
            proper, mirror = _proper(last.turn)
            if mirror is not None:
                rest.append(Set(mirror))
            return tuple(rest), Place(_quarter_angles(proper, is_placement), shift, (Set(proper, shift),))
    angles = [Fraction(0)] * 3
    least = -1
    while rest and isinstance(rest[-1], Spin):
        axis = rest[-1].axis
        order = axis if is_placement else 2 - axis
        if order <= least:
            break
        angles[axis], least = (-rest[-1].degrees if is_placement else rest[-1].degrees), order
        rest.pop()
    return tuple(rest), Place((angles[0], angles[1], angles[2]), shift, moves[len(rest) :])


def mirror_of(move: Set) -> tuple[int, int, int] | None:
    """The signs of a mirror across planes of coordinates."""
    is_plain = move.turn.sources == (0, 1, 2) and move.shift == ORIGIN
    return move.turn.signs if is_plain and math.prod(move.turn.signs) < 0 else None


def _proper(turn: Turn) -> tuple[Turn, Turn | None]:
    """A turn, and the mirror that comes before it, if any."""
    a, b, c = turn.sources
    parity = 1 if (a, b, c) in ((0, 1, 2), (1, 2, 0), (2, 0, 1)) else -1
    if parity * math.prod(turn.signs) > 0:
        return turn, None
    mirror = Turn(signs=(1, 1, -1))
    return turn.after(mirror), mirror


def _quarter_angles(turn: Turn, is_placement: bool) -> Point:
    quarters = [Fraction(angle) for angle in (0, 90, 180, 270)]
    for x, y, z in itertools.product(quarters, repeat=3):
        found = (placed if is_placement else turned)((x, y, z))
        if found.turn == turn:
            return x, y, z
    raise AssertionError(turn)
