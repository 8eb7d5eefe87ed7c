"""Placements of universes in the world, and boxes (`Extent`) in fractions.

Rotations by multiples of 90 degrees and translations are computed in fractions, so that surfaces which coincide on
paper get equal numbers, rounded once. From the first other rotation outward, the placement is a `Motion`, which is
exact to 3000 bits of its input. GDML and MCNP use the same placements.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction
from functools import cache, cached_property, lru_cache
from itertools import combinations
from typing import Any, TypeAlias

from ..._util.arrays import Matrix4, Vector
from ..._util.records import dataclass
from ...geometry.transform import IDENTITY_MOTION, Motion
from ...numerics.rational import cross

Point: TypeAlias = tuple[Fraction, Fraction, Fraction]
Rows: TypeAlias = tuple[Point, Point, Point]

ORIGIN: Point = (Fraction(0), Fraction(0), Fraction(0))


@dataclasses.dataclass(frozen=True, slots=True)
class AxisTurn:
    """A rotation or mirror that only exchanges axes: new[i] = signs[i] old[sources[i]]."""

    sources: tuple[int, int, int] = (0, 1, 2)
    signs: tuple[int, int, int] = (1, 1, 1)

    @classmethod
    def of(cls, rows: Sequence[Sequence[Any]]) -> AxisTurn | None:
        """Return the turn that a matrix is; None for a matrix that does more than exchange axes."""
        if any(sorted(map(abs, line)) != [0, 0, 1] for line in (*rows, *zip(*rows, strict=True))):
            return None
        a, b, c = (next(i for i in range(3) if row[i]) for row in rows)
        return cls((a, b, c), (int(rows[0][a]), int(rows[1][b]), int(rows[2][c])))

    def apply(self, point: Point) -> Point:
        """Return a point after the turn."""
        # Most placements have no turn, and identity is the quicker test
        if self is NO_TURN or self == NO_TURN:
            return point
        (a, b, c), (p, q, r) = self.sources, self.signs
        return (
            point[a] if p > 0 else -point[a],
            point[b] if q > 0 else -point[b],
            point[c] if r > 0 else -point[c],
        )

    def after(self, first: AxisTurn) -> AxisTurn:
        """Return the turn that applies `first`, then this one."""
        if self is NO_TURN or first is NO_TURN:
            return first if self is NO_TURN else self
        a, b, c = (first.sources[source] for source in self.sources)
        p, q, r = (sign * first.signs[source] for source, sign in zip(self.sources, self.signs, strict=True))
        return AxisTurn((a, b, c), (p, q, r))

    @property
    def inverse(self) -> AxisTurn:
        """The inverse turn."""
        if self is NO_TURN:
            return self
        a, b, c = (self.sources.index(i) for i in range(3))
        return AxisTurn((a, b, c), (self.signs[a], self.signs[b], self.signs[c]))

    def axis(self, axis: int) -> int:
        """Return the axis that an axis is taken to, without regard to its sign."""
        return self.sources.index(axis)

    @property
    def rows(self) -> Rows:
        """The matrix of the turn."""
        x, y, z = (
            tuple(Fraction(sign * (source == i)) for i in range(3))
            for source, sign in zip(self.sources, self.signs, strict=True)
        )
        return x, y, z  # type: ignore[return-value]


NO_TURN = AxisTurn()


def add_points(a: Point, b: Point) -> Point:
    """Return the sum, skipping zeros: most components of most shifts are 0, and fractions are slow."""
    (x, y, z), (p, q, r) = a, b
    return (x if not p else x + p if x else p), (y if not q else y + q if y else q), (z if not r else z + r if z else r)


@dataclasses.dataclass(frozen=True, slots=True)
class CellRotation:
    """The rotation that a cell applies to its filling: the quarter turn `turn`, or else `motion`."""

    turn: AxisTurn = NO_TURN
    motion: Motion = IDENTITY_MOTION


NO_ROTATION = CellRotation()


def rotation_by_angles(angles: Point) -> CellRotation:
    """Return the rotation of OpenMC's angles (φ, θ, ψ) in degrees: by ψ about z, then θ about y, then φ about x.

    OpenMC looks up a point r of the cell in the filling universe at R_z(-ψ) R_y(-θ) R_x(-φ) r (Cell::set_rotation and
    find_cell_inner); the rotation of the filling is the inverse of this.
    """
    if all(angle % 90 == 0 for angle in angles):  # exact: angles are fractions
        turn = NO_TURN
        for axis in (2, 1, 0):
            for _ in range(int(angles[axis] / 90) % 4):
                turn = _QUARTERS[axis].after(turn)
        return CellRotation(turn)
    motion = IDENTITY_MOTION
    for axis in (2, 1, 0):
        if angles[axis]:
            motion = motion.rotate(_AXES[axis], float(angles[axis]))
    return CellRotation(motion=motion)


def rotation_by_matrix(rows: Rows) -> CellRotation | None:
    """Return the rotation of the filling for a matrix M; None if M has no inverse.

    OpenMC looks up a point r of the cell at M r, so the filling moves by the inverse of M.
    """
    # The inverse of a signed permutation is its transpose
    turn = AxisTurn.of(tuple(zip(*rows, strict=True)))
    if turn is not None:
        return CellRotation(turn)
    back = invert_rows(rows)
    if back is None:
        return None
    return CellRotation(motion=IDENTITY_MOTION.transform(_matrix(back)))


def rotation_error(rows: Rows) -> float:
    """Return the distance of a matrix from a rotation: the largest entry of |M Mᵀ - 1|."""
    return max(
        abs(float(sum((a * b for a, b in zip(u, v, strict=True)), Fraction(-(i == j)))))
        for i, u in enumerate(rows)
        for j, v in enumerate(rows)
    )


@dataclass(frozen=True)
class UniversePlacement:
    """The placement x ↦ outer(turn x + shift) from a universe to the world."""

    turn: AxisTurn = NO_TURN
    shift: Point = ORIGIN
    outer: Motion = IDENTITY_MOTION

    def point(self, own: Point) -> Point:
        """Return a point of the universe after turn and shift, before the outer motion."""
        return add_points(self.turn.apply(own), self.shift)

    @property
    def back(self) -> UniversePlacement:
        """The inverse of turn and shift: from before the outer motion to the universe."""
        turn = self.turn.inverse
        x, y, z = turn.apply(self.shift)
        return UniversePlacement(turn, (-x, -y, -z))

    def inner(self, shift: Point, rotation: CellRotation = NO_ROTATION) -> UniversePlacement:
        """Return the placement of content that is rotated and then translated by `shift` within this placement."""
        if rotation.motion.is_identity:
            return UniversePlacement(self.turn.after(rotation.turn), self.point(shift), self.outer)
        # The turn and the shift so far go into the motion, and content starts again with exact fractions
        return UniversePlacement(outer=self.entry(shift, rotation).then(self.outer))

    def entry(self, shift: Point, rotation: CellRotation) -> Motion:
        """Return the motion from rotated content (no multiples of 90 degrees) to before the outer motion."""
        motion, whole = turn_motion(rotation.motion, self.turn), self.point(shift)
        return motion.translate(to_floats(whole)) if any(whole) else motion


@cache
def motion_of_turn(turn: AxisTurn) -> Motion:
    """Return a quarter turn as a motion."""
    return IDENTITY_MOTION.transform(_matrix(turn.rows))


@lru_cache(maxsize=1 << 12)
def turn_motion(motion: Motion, turn: AxisTurn) -> Motion:
    """Return a motion followed by a quarter turn, the same object for equal ones, which have products in common."""
    return motion if turn == NO_TURN else motion.then(motion_of_turn(turn))


def split_shift(motion: Motion, shift: Point) -> tuple[Point, Point]:
    """Return (before, after): motion(x) + shift is motion(x + before) + after.

    The part along an axis that the motion takes to an axis, such as that of a rotation, comes before. Content is built
    with that part in fractions, so that its walls across the axis are those of its surroundings.
    """
    before, after = list(ORIGIN), list(shift)
    for k, image in enumerate(motion.axis_images):
        if image is not None and shift[image[0]]:
            axis, sign = image
            before[k], after[axis] = sign * shift[axis], ORIGIN[axis]
    return (before[0], before[1], before[2]), (after[0], after[1], after[2])


def add_rounded(a: Fraction, b: Fraction) -> float:
    """Return the sum, rounded once."""
    # The quotient of two integers is rounded correctly; a Fraction would be reduced to lowest terms first, in vain.
    p, q = a.as_integer_ratio()
    r, s = b.as_integer_ratio()
    return (p * s + r * q) / (q * s)


def shift_point(point: Point, shift: Point) -> Vector:
    """Return a translated point, every coordinate rounded once."""
    return add_rounded(point[0], shift[0]), add_rounded(point[1], shift[1]), add_rounded(point[2], shift[2])


def to_floats(point: Point) -> Vector:
    """Return a point in floats, every coordinate rounded once."""
    return to_float(point[0]), to_float(point[1]), to_float(point[2])


def to_float(value: Fraction) -> float:
    """Return a fraction, rounded once, as `float` does in twice the time."""
    numerator, denominator = value.as_integer_ratio()
    return numerator / denominator


def try_floats(point: Point, number: Fraction) -> tuple[Vector, float] | None:
    """Return a point and a number in floats, each rounded once; None if they are too large."""
    try:
        return to_floats(point), to_float(number)
    except OverflowError:
        return None


def _matrix(rows: Rows) -> Matrix4:
    return (*((*to_floats(row), 0.0) for row in rows), (0.0, 0.0, 0.0, 1.0))


def invert_rows(rows: Rows) -> Rows | None:
    """Return the inverse of a matrix; None if its determinant is 0."""
    a, b, c = rows
    bc, ca, ab = cross(b, c), cross(c, a), cross(a, b)
    determinant = sum(x * y for x, y in zip(a, bc, strict=True))
    # Exact, so a matrix that is only nearly singular has an inverse
    if not determinant:
        return None
    x, y, z = (tuple(line[i] / determinant for line in (bc, ca, ab)) for i in range(3))
    return x, y, z


_AXES: tuple[Vector, Vector, Vector] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
# A quarter turn about x takes y to z: new (x, y, z) = old (x, -z, y).
_QUARTERS = (AxisTurn((0, 2, 1), (1, -1, 1)), AxisTurn((2, 1, 0), (1, 1, -1)), AxisTurn((1, 0, 2), (-1, 1, 1)))


# Boxes along the axes, with ends in fractions or infinite, that bound regions

ExtentEnd = Fraction | None


@dataclass(frozen=True)
class Extent:
    """The box low[i] <= x[i] <= high[i]; an end that is None is infinite."""

    low: tuple[ExtentEnd, ExtentEnd, ExtentEnd] = (None, None, None)
    high: tuple[ExtentEnd, ExtentEnd, ExtentEnd] = (None, None, None)

    @cached_property
    def floats(self) -> tuple[Vector, Vector] | None:
        """Both ends along each axis, rounded once or infinite; None if they are too large."""
        try:
            x, y, z = (-math.inf if end is None else to_float(end) for end in self.low)
            a, b, c = (math.inf if end is None else to_float(end) for end in self.high)
        except OverflowError:
            return None
        return (x, y, z), (a, b, c)

    def end(self, axis: int, lower: bool) -> ExtentEnd:
        """Return one of the six ends."""
        return (self.low if lower else self.high)[axis]

    def common(self, other: Extent) -> Extent:
        """Return the intersection of both boxes."""
        if other is UNBOUNDED or self is UNBOUNDED:  # saves slow comparisons of fractions
            return self if other is UNBOUNDED else other
        lows = [b if a is None or (b is not None and b > a) else a for a, b in zip(self.low, other.low, strict=True)]
        highs = [b if a is None or (b is not None and b < a) else a for a, b in zip(self.high, other.high, strict=True)]
        return Extent((lows[0], lows[1], lows[2]), (highs[0], highs[1], highs[2]))

    def union(self, other: Extent) -> Extent:
        """Return the smallest box around both boxes."""
        lows = [_union_end(min, a, b) for a, b in zip(self.low, other.low, strict=True)]
        highs = [_union_end(max, a, b) for a, b in zip(self.high, other.high, strict=True)]
        return Extent((lows[0], lows[1], lows[2]), (highs[0], highs[1], highs[2]))

    def placed(self, place: UniversePlacement) -> Extent:
        """Return the box after the turn and the shift of a placement, before its outer motion."""
        lows: list[ExtentEnd] = []
        highs: list[ExtentEnd] = []
        for source, sign, shift in zip(place.turn.sources, place.turn.signs, place.shift, strict=True):
            low, high = self.low[source], self.high[source]
            if sign < 0:
                low, high = None if high is None else -high, None if low is None else -low
            # Most shifts are 0 along an axis, and fractions are slow
            lows.append(low + shift if shift and low is not None else low)
            highs.append(high + shift if shift and high is not None else high)
        return Extent((lows[0], lows[1], lows[2]), (highs[0], highs[1], highs[2]))

    def within(self, planes: Sequence[tuple[Point, Fraction]]) -> Extent:
        """Return the box around its part where normal·x <= offset, for each of the planes (normal, offset).

        An end along an axis is a sum of the offsets of three planes, whose normals have this axis as the sum with the
        same weights, none of them negative. Of many planes only the first are used, so the box may be too large.
        """
        x, y, z = AxisTurn().rows
        ends = [*zip((x, y, z), self.high, strict=True)]
        ends += [(_negated(axis), end and -end) for axis, end in zip((x, y, z), self.low, strict=True)]
        box = self
        for three in combinations([*planes[:MOST_PLANES], *ends], 3):
            a, b, c = (normal for normal, _ in three)
            for axis, weights in enumerate(invert_rows((a, b, c)) or ()):
                used = [(weight, offset) for weight, (_, offset) in zip(weights, three, strict=True) if weight]
                known = [weight * offset for weight, offset in used if offset is not None]
                signs = {weight > 0 for weight, _ in used}
                if len(known) == len(used) and len(signs) == 1:
                    sides: list[ExtentEnd] = [None, None, None]
                    sides[axis] = sum(known, Fraction(0))
                    half = (sides[0], sides[1], sides[2])
                    box = box.common(Extent(high=half) if True in signs else Extent(low=half))
        return box

    @property
    def is_empty(self) -> bool:
        """True if the box has no volume."""
        return any(
            low is not None and high is not None and low >= high for low, high in zip(self.low, self.high, strict=True)
        )

    def least(self, normal: Point) -> ExtentEnd:
        """Return the least normal·x in the box; None if it is infinite."""
        return self._sum(normal, self.low, self.high)

    def most(self, normal: Point) -> ExtentEnd:
        """Return the largest normal·x in the box; None if it is infinite."""
        return self._sum(normal, self.high, self.low)

    @staticmethod
    def _sum(
        normal: Point, along: tuple[ExtentEnd, ExtentEnd, ExtentEnd], against: tuple[ExtentEnd, ExtentEnd, ExtentEnd]
    ) -> ExtentEnd:
        total = Fraction(0)
        for n, a, b in zip(normal, along, against, strict=True):
            if n:  # an infinite end does not matter along an axis across the normal
                end = a if n > 0 else b
                if end is None:
                    return None
                total += n * end
        return total

    def square_distances(self, center: Point, axes: Iterable[int]) -> tuple[Fraction, ExtentEnd]:
        """Return least and largest squared distance of the box from `center`, measured along some of the axes.

        The largest is None if the box is infinite along one of them.
        """
        least, most = Fraction(0), Fraction(0)
        bounded = True
        for i in axes:
            low, high, c = self.low[i], self.high[i], center[i]
            if low is not None and c < low:
                least += (low - c) ** 2
            elif high is not None and c > high:
                least += (c - high) ** 2
            if low is None or high is None:
                bounded = False
            else:
                most += max(c - low, high - c) ** 2
        return least, most if bounded else None


UNBOUNDED = Extent()
MOST_PLANES = 20
"""Most planes that `Extent.within` combines."""


def _negated(u: Point) -> Point:
    x, y, z = u
    return -x, -y, -z


def _union_end(choose: Callable[[Fraction, Fraction], Fraction], a: ExtentEnd, b: ExtentEnd) -> ExtentEnd:
    return None if a is None or b is None else choose(a, b)
