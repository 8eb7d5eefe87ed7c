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

from ...geometry.transform import AxisFrame, Motion, Rotate, Scale, Step, Transform, Translate
from ...numerics import bigfloat_linalg as ex
from ..gdml.values import operand_rotation, placement_rotation
from ..openmc.placement import NO_TURN, ORIGIN, AxisTurn, Point, rotation_by_angles
from .exporters import ExportUnsupported, shortest_decimal

_RIGHT_ANGLE_TOLERANCE = 1e-9
"""How far a matrix may be from a turn that is written as angles."""


@dataclass(frozen=True)
class RigidMove:
    """x ↦ turn x + shift"""

    turn: AxisTurn = NO_TURN
    shift: Point = ORIGIN

    def then(self, other: RigidMove) -> RigidMove:
        """One, and then the other."""
        moved = other.turn.apply(self.shift)
        return RigidMove(other.turn.after(self.turn), _add_shifts(moved, other.shift))

    @property
    def back(self) -> RigidMove:
        """The way back."""
        turn = self.turn.inverse
        x, y, z = turn.apply(self.shift)
        return RigidMove(turn, (-x, -y, -z))


@dataclass(frozen=True)
class AxisSpin:
    """A turn about an axis of coordinates, in degrees."""

    axis: int
    degrees: Fraction


@dataclass(frozen=True)
class AxisStretch:
    """Scaled along the axes, by factors above 0."""

    factors: tuple[float, float, float]


GdmlMove: TypeAlias = RigidMove | AxisSpin | AxisStretch
GdmlMoves: TypeAlias = tuple[GdmlMove, ...]


def join_moves(*parts: Iterable[GdmlMove]) -> GdmlMoves:
    """One after the other, neighbours of one kind composed where that is exact."""
    found: list[GdmlMove] = []
    for move in itertools.chain(*parts):
        if isinstance(move, RigidMove) and found and isinstance(found[-1], RigidMove):
            found[-1] = found[-1].then(move)
        else:
            found.append(move)
        if found[-1] == RigidMove():
            found.pop()
    return tuple(found)


def convert_steps(steps: Sequence[Step]) -> tuple[GdmlMoves, bool]:
    """Steps, and whether a number of them had to be rounded. Raises Unsayable for what is no turn, shift or scaling."""
    found: list[GdmlMove] = []
    is_rounded = False
    for step in steps:
        if isinstance(step, Translate):
            found.append(RigidMove(shift=_decimals(step.offset)))
        elif isinstance(step, Scale):
            found += _convert_scaling(step)
        elif isinstance(step, Rotate) and sum(map(bool, step.axis)) == 1:
            found.append(_convert_spin(step))
        elif isinstance(step, Transform) and _convert_exchange(step) is not None:
            turn = _convert_exchange(step)
            assert turn is not None
            found.append(RigidMove(turn, _decimals(tuple(row[3] for row in step.matrix[:3]))))
        else:
            more, rounded = _three_spins(step)
            found += more
            is_rounded = is_rounded or rounded
    made = join_moves(found)
    return made, is_rounded or _is_lossy(steps, made)


def _is_lossy(steps: Sequence[Step], moves: GdmlMoves) -> bool:
    """Were shifts added up, so that their sums may have been rounded?"""
    shifts = sum(isinstance(step, Translate) for step in steps)
    return shifts > sum(isinstance(move, RigidMove) for move in moves) and shifts > 1


def _decimals(values: Iterable[float]) -> Point:
    x, y, z = map(shortest_decimal, values)
    return x, y, z


def _add_shifts(a: Point, b: Point) -> Point:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def _convert_scaling(step: Scale) -> list[GdmlMove]:
    x, y, z = (1 if factor > 0 else -1 for factor in step.factors)
    sizes = tuple(map(abs, step.factors))
    found: list[GdmlMove] = [AxisStretch(sizes)] if sizes != (1.0, 1.0, 1.0) else []  # type: ignore[arg-type]
    return [*found, RigidMove(AxisTurn(signs=(x, y, z)))]


def _convert_spin(step: Rotate) -> GdmlMove:
    axis = next(i for i in range(3) if step.axis[i])
    degrees = shortest_decimal(step.degrees) * (1 if step.axis[axis] > 0 else -1)
    if degrees % 90:
        return AxisSpin(axis, degrees)
    angles = [Fraction(0)] * 3
    angles[axis] = degrees
    return RigidMove(rotation_by_angles((angles[0], angles[1], angles[2])).turn)


def _convert_exchange(step: Transform) -> AxisTurn | None:
    """The exchange of axes that a matrix is."""
    rows = [row[:3] for row in step.matrix[:3]]
    lines = [*rows, *zip(*rows, strict=True)]
    if any(sorted(map(abs, line)) != [0, 0, 1] for line in lines):
        return None
    sources = [next(i for i in range(3) if row[i]) for row in rows]
    a, b, c = (int(row[i]) for row, i in zip(rows, sources, strict=True))
    return AxisTurn((sources[0], sources[1], sources[2]), (a, b, c))


def _three_spins(step: Step) -> tuple[list[GdmlMove], bool]:
    """A turn about any axis as three about x, y and z, to the nearest floats; and its shift."""
    rows, shift = Motion((step,)).affine
    m = [[ex.rounded(value) for value in row] for row in rows]
    for i, j in itertools.product(range(3), range(3)):
        if abs(sum(a * b for a, b in zip(m[i], m[j], strict=True)) - (i == j)) > _RIGHT_ANGLE_TOLERANCE:
            what = "Transform" if isinstance(step, Transform) else type(step).__name__
            raise ExportUnsupported(f"a motion of it ({what}) is no chain of turns, shifts and scalings along the axes")
    found: list[GdmlMove] = []
    if _determinant(m) < 0:
        m = [[row[0], row[1], -row[2]] for row in m]
        found.append(RigidMove(AxisTurn(signs=(1, 1, -1))))
    y = math.asin(max(-1.0, min(1.0, -m[2][0])))
    if math.hypot(m[0][0], m[1][0]) > 1e-12:
        x, z = math.atan2(m[2][1], m[2][2]), math.atan2(m[1][0], m[0][0])
    else:
        x, z = math.atan2(-m[1][2], m[1][1]), 0.0
    for axis, angle in enumerate((x, y, z)):
        if angle:
            found.append(_convert_spin(Rotate(_AXES[axis], math.degrees(angle))))
    moved = tuple(ex.rounded(value) for value in shift)
    found.append(RigidMove(shift=_decimals(moved)))
    return found, not isinstance(step, AxisFrame) or len(found) > 1


_AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def _determinant(m: list[list[float]]) -> float:
    (a, b, c), (d, e, f), (g, h, i) = m
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)


def relative_moves(moves: GdmlMoves, frame: GdmlMoves) -> GdmlMoves:
    """What leads to `moves` within a frame that is placed by others: what both end with is left out."""
    mine, its = list(moves), list(frame)
    while mine and its and mine[-1] == its[-1]:
        mine.pop()
        its.pop()
    return join_moves(mine, [_invert_move(move) for move in reversed(its)])


def _invert_move(move: GdmlMove) -> GdmlMove:
    """The way back; stretches are none of frames."""
    if isinstance(move, AxisSpin):
        return AxisSpin(move.axis, -move.degrees)
    assert isinstance(move, RigidMove)
    return move.back


# ---- Moves as rotations and positions ----


@dataclass(frozen=True)
class ExportPlacement:
    """A rotation by three angles, in the sense of whatever it is for, then a shift."""

    angles: Point = ORIGIN
    shift: Point = ORIGIN
    moves: GdmlMoves = ()
    """The same as moves."""


def split_last_placement(moves: GdmlMoves, is_placement: bool) -> tuple[GdmlMoves, ExportPlacement]:
    """The last moves as one rotation and shift, and those before.

    Operands of Booleans turn about x, then y, then z; placements about z, y, x, the other way (`is_placement`).
    """
    rest = list(moves)
    shift = ORIGIN
    if rest and isinstance(rest[-1], RigidMove):
        last = rest.pop()
        assert isinstance(last, RigidMove)
        shift = last.shift
        if last.turn != NO_TURN:
            proper, mirror = _split_mirror(last.turn)
            if mirror is not None:
                rest.append(RigidMove(mirror))
            return tuple(rest), ExportPlacement(
                _quarter_angles(proper, is_placement), shift, (RigidMove(proper, shift),)
            )
    angles = [Fraction(0)] * 3
    least = -1
    while rest and isinstance(rest[-1], AxisSpin):
        axis = rest[-1].axis
        order = axis if is_placement else 2 - axis
        if order <= least:
            break
        angles[axis], least = (-rest[-1].degrees if is_placement else rest[-1].degrees), order
        rest.pop()
    return tuple(rest), ExportPlacement((angles[0], angles[1], angles[2]), shift, moves[len(rest) :])


def mirror_signs(move: RigidMove) -> tuple[int, int, int] | None:
    """The signs of a mirror across planes of coordinates."""
    is_plain = move.turn.sources == (0, 1, 2) and move.shift == ORIGIN
    return move.turn.signs if is_plain and math.prod(move.turn.signs) < 0 else None


def _split_mirror(turn: AxisTurn) -> tuple[AxisTurn, AxisTurn | None]:
    """A turn, and the mirror that comes before it, if any."""
    a, b, c = turn.sources
    parity = 1 if (a, b, c) in ((0, 1, 2), (1, 2, 0), (2, 0, 1)) else -1
    if parity * math.prod(turn.signs) > 0:
        return turn, None
    mirror = AxisTurn(signs=(1, 1, -1))
    return turn.after(mirror), mirror


def _quarter_angles(turn: AxisTurn, is_placement: bool) -> Point:
    quarters = [Fraction(angle) for angle in (0, 90, 180, 270)]
    for x, y, z in itertools.product(quarters, repeat=3):
        found = (placement_rotation if is_placement else operand_rotation)((x, y, z))
        if found.turn == turn:
            return x, y, z
    raise AssertionError(turn)
