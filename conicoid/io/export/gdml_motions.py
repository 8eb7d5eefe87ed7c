"""Motions in the terms of GDML: exchanges of axes with shifts, spins about an axis, and stretches.

Exchanges and shifts are composed exactly, with shifts as the shortest decimals of floats, as readers do with them.
`split_last_placement` turns moves into the rotations and positions of elements.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import TypeAlias

from ..._util.records import dataclass
from ...geometry.transform import AxisFrame, Motion, Rotate, Scale, Step, Transform, Translate
from ...numerics import bigfloat as ex
from ..gdml.values import operand_rotation, placement_rotation
from ..openmc.placement import NO_TURN, ORIGIN, AxisTurn, Point, rotation_by_angles
from .exporters import UnsupportedExport, shortest_decimal

_RIGHT_ANGLE_TOLERANCE = 1e-9
"""Largest error of a product of rows, if a matrix is to be written as a rotation by angles."""


@dataclass(frozen=True)
class RigidMove:
    """x ↦ turn x + shift"""

    turn: AxisTurn = NO_TURN
    shift: Point = ORIGIN

    def then(self, other: RigidMove) -> RigidMove:
        """Return the move that is this one, then `other`."""
        moved = other.turn.apply(self.shift)
        return RigidMove(
            other.turn.after(self.turn),
            (moved[0] + other.shift[0], moved[1] + other.shift[1], moved[2] + other.shift[2]),
        )

    @property
    def back(self) -> RigidMove:
        """The inverse."""
        turn = self.turn.inverse
        x, y, z = turn.apply(self.shift)
        return RigidMove(turn, (-x, -y, -z))


@dataclass(frozen=True)
class AxisSpin:
    """A rotation about an axis of coordinates, in degrees."""

    axis: int
    degrees: Fraction


@dataclass(frozen=True)
class AxisStretch:
    """A scaling along the axes by factors above 0."""

    factors: tuple[float, float, float]


GdmlMove: TypeAlias = RigidMove | AxisSpin | AxisStretch
GdmlMoves: TypeAlias = tuple[GdmlMove, ...]


def join_moves(*parts: Iterable[GdmlMove]) -> GdmlMoves:
    """Return moves one after the other, with adjacent rigid moves composed (that is exact) and identities dropped."""
    moves: list[GdmlMove] = []
    for move in itertools.chain(*parts):
        if isinstance(move, RigidMove) and moves and isinstance(moves[-1], RigidMove):
            moves[-1] = moves[-1].then(move)
        else:
            moves.append(move)
        # A shift and its inverse, between a frame and what stands in it, cancel
        if moves[-1] == RigidMove():
            moves.pop()
    return tuple(moves)


def convert_steps(steps: Sequence[Step]) -> tuple[GdmlMoves, bool]:
    """Return steps as moves, and whether a number had to be rounded.

    Raise UnsupportedExport for a step that is no rotation, shift or scaling along the axes.
    """
    converted: list[GdmlMove] = []
    is_rounded = False
    for step in steps:
        if isinstance(step, Translate):
            converted.append(RigidMove(shift=_decimals(step.offset)))
        elif isinstance(step, Scale):
            converted += _convert_scaling(step)
        elif isinstance(step, Rotate) and sum(map(bool, step.axis)) == 1:
            converted.append(_convert_spin(step))
        elif isinstance(step, Transform) and (turn := AxisTurn.of([row[:3] for row in step.matrix[:3]])) is not None:
            converted.append(RigidMove(turn, _decimals(tuple(row[3] for row in step.matrix[:3]))))
        else:
            more, rounded = _three_spins(step)
            converted += more
            is_rounded = is_rounded or rounded
    moves = join_moves(converted)
    return moves, is_rounded or _is_lossy(steps, moves)


def _is_lossy(steps: Sequence[Step], moves: GdmlMoves) -> bool:
    """Return True if shifts were added up: their sums may differ from the scene's, which were rounded."""
    shifts = sum(isinstance(step, Translate) for step in steps)
    return shifts > sum(isinstance(move, RigidMove) for move in moves) and shifts > 1


def _decimals(values: Iterable[float]) -> Point:
    x, y, z = map(shortest_decimal, values)
    return x, y, z


def _convert_scaling(step: Scale) -> list[GdmlMove]:
    """Return the stretch and the mirror of a scaling."""
    x, y, z = (1 if factor > 0 else -1 for factor in step.factors)
    sizes = tuple(map(abs, step.factors))
    moves: list[GdmlMove] = [AxisStretch(sizes)] if sizes != (1.0, 1.0, 1.0) else []  # type: ignore[arg-type]
    return [*moves, RigidMove(AxisTurn(signs=(x, y, z)))]


def _convert_spin(step: Rotate) -> GdmlMove:
    """Return a rotation about an axis of coordinates; multiples of 90 degrees become exchanges of axes."""
    axis = next(i for i in range(3) if step.axis[i])
    degrees = shortest_decimal(step.degrees) * (1 if step.axis[axis] > 0 else -1)
    if degrees % 90:
        return AxisSpin(axis, degrees)
    angles = [Fraction(0)] * 3
    angles[axis] = degrees
    return RigidMove(rotation_by_angles((angles[0], angles[1], angles[2])).turn)


def _three_spins(step: Step) -> tuple[list[GdmlMove], bool]:
    """Return a rotation about any axis as spins about x, y and z, with its shift, and whether numbers are rounded.

    Raise UnsupportedExport if the matrix is no rotation, mirrored or not.
    """
    rows, shift = Motion((step,)).affine
    m = [[ex.rounded(value) for value in row] for row in rows]
    for i, j in itertools.product(range(3), range(3)):
        if abs(sum(a * b for a, b in zip(m[i], m[j], strict=True)) - (i == j)) > _RIGHT_ANGLE_TOLERANCE:
            what = "Transform" if isinstance(step, Transform) else type(step).__name__
            raise UnsupportedExport(f"a motion of it ({what}) is no chain of turns, shifts and scalings along the axes")
    moves: list[GdmlMove] = []
    # Angles hold no mirror, so it is split off as a change of sign
    if _determinant(m) < 0:
        m = [[row[0], row[1], -row[2]] for row in m]
        moves.append(RigidMove(AxisTurn(signs=(1, 1, -1))))
    # Rounding may put the sine a little beyond 1
    y = math.asin(max(-1.0, min(1.0, -m[2][0])))
    # At y = ±90 degrees only x - z or x + z is defined (gimbal lock): choose z = 0.
    if math.hypot(m[0][0], m[1][0]) > 1e-12:
        x, z = math.atan2(m[2][1], m[2][2]), math.atan2(m[1][0], m[0][0])
    else:
        x, z = math.atan2(-m[1][2], m[1][1]), 0.0
    for axis, angle in enumerate((x, y, z)):
        if angle:
            moves.append(_convert_spin(Rotate(_AXES[axis], math.degrees(angle))))
    moved = tuple(ex.rounded(value) for value in shift)
    moves.append(RigidMove(shift=_decimals(moved)))
    return moves, not isinstance(step, AxisFrame) or len(moves) > 1


_AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def _determinant(m: list[list[float]]) -> float:
    (a, b, c), (d, e, f), (g, h, i) = m
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)


def relative_moves(moves: GdmlMoves, frame: GdmlMoves) -> GdmlMoves:
    """Return the moves within a frame that is placed by `frame`: frame⁻¹ after `moves`, without their common end."""
    mine, its = list(moves), list(frame)
    while mine and its and mine[-1] == its[-1]:
        mine.pop()
        its.pop()
    return join_moves(mine, [_invert_move(move) for move in reversed(its)])


def _invert_move(move: GdmlMove) -> GdmlMove:
    """Return the inverse of a move of a frame; frames have no stretches."""
    if isinstance(move, AxisSpin):
        return AxisSpin(move.axis, -move.degrees)
    assert isinstance(move, RigidMove)
    return move.back


# Moves as rotations and positions.


@dataclass(frozen=True)
class ExportPlacement:
    """A rotation by three angles in degrees, in the sense of the element that it is for, then a shift."""

    angles: Point = ORIGIN
    shift: Point = ORIGIN
    moves: GdmlMoves = ()
    """The same placement as moves."""


def split_last_placement(moves: GdmlMoves, is_placement: bool) -> tuple[GdmlMoves, ExportPlacement]:
    """Return the moves before the last ones, and the last ones as one rotation and shift.

    Operands of Booleans rotate about x, then y, then z; placements (`is_placement`) about z, y, x, by negative angles.
    A mirror is never part of the rotation.
    """
    rest = list(moves)
    shift = ORIGIN
    if rest and isinstance(rest[-1], RigidMove):
        last = rest.pop()
        assert isinstance(last, RigidMove)
        shift = last.shift
        # A quarter turn that shifts follow is a rotation and a position of one element
        if last.turn != NO_TURN:
            proper, mirror = _split_mirror(last.turn)
            if mirror is not None:
                rest.append(RigidMove(mirror))
            return tuple(rest), ExportPlacement(
                _quarter_angles(proper, is_placement), shift, (RigidMove(proper, shift),)
            )
    angles = [Fraction(0)] * 3
    least = -1
    # Take spins from the end as long as they come in the order in which the element rotates.
    while rest and isinstance(rest[-1], AxisSpin):
        axis = rest[-1].axis
        order = axis if is_placement else 2 - axis
        if order <= least:
            break
        angles[axis], least = (-rest[-1].degrees if is_placement else rest[-1].degrees), order
        rest.pop()
    return tuple(rest), ExportPlacement((angles[0], angles[1], angles[2]), shift, moves[len(rest) :])


def mirror_signs(move: RigidMove) -> tuple[int, int, int] | None:
    """Return the signs of a move that is only a mirror across planes of coordinates; None for any other."""
    is_plain = move.turn.sources == (0, 1, 2) and move.shift == ORIGIN
    return move.turn.signs if is_plain and math.prod(move.turn.signs) < 0 else None


def _split_mirror(turn: AxisTurn) -> tuple[AxisTurn, AxisTurn | None]:
    """Split a turn into a proper rotation and the mirror that comes before it, if any."""
    a, b, c = turn.sources
    parity = 1 if (a, b, c) in ((0, 1, 2), (1, 2, 0), (2, 0, 1)) else -1
    if parity * math.prod(turn.signs) > 0:
        return turn, None
    mirror = AxisTurn(signs=(1, 1, -1))
    return turn.after(mirror), mirror


@functools.cache
def _quarter_angles(turn: AxisTurn, is_placement: bool) -> Point:
    """Return the angles, multiples of 90 degrees, of a proper rotation that exchanges axes."""
    quarters = [Fraction(angle) for angle in (0, 90, 180, 270)]
    # All 64 are tried with the reader's own function, so that writer and reader cannot differ
    for x, y, z in itertools.product(quarters, repeat=3):
        rotation = (placement_rotation if is_placement else operand_rotation)((x, y, z))
        if rotation.turn == turn:
            return x, y, z
    raise AssertionError(turn)
