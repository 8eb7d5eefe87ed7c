"""Where a universe stands in the world.

Turns by multiples of 90 degrees and translations are carried out in fractions, so that surfaces
which coincide on paper get equal numbers, rounded once. From the first other rotation on, the
rest of the way outward is a `Motion`, which is exact to 3000 bits of what is given to it.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias

from ...shapes.motion import STILL, Motion
from ...shapes.vector import Matrix4, Vector

Point: TypeAlias = tuple[Fraction, Fraction, Fraction]
Rows: TypeAlias = tuple[Point, Point, Point]

ORIGIN: Point = (Fraction(0), Fraction(0), Fraction(0))


@dataclass(frozen=True, slots=True)
class Turn:
    """A rotation or mirror that only exchanges axes: new[i] = signs[i] old[sources[i]]."""

    sources: tuple[int, int, int] = (0, 1, 2)
    signs: tuple[int, int, int] = (1, 1, 1)

    def apply(self, point: Point) -> Point:
        if self is UNTURNED or self == UNTURNED:
            return point
        (a, b, c), (p, q, r) = self.sources, self.signs
        return (
            point[a] if p > 0 else -point[a],
            point[b] if q > 0 else -point[b],
            point[c] if r > 0 else -point[c],
        )

    def after(self, first: Turn) -> Turn:
        """`first`, then this."""
        if self is UNTURNED or first is UNTURNED:
            return first if self is UNTURNED else self
        a, b, c = (first.sources[source] for source in self.sources)
        p, q, r = (sign * first.signs[source] for source, sign in zip(self.sources, self.signs, strict=True))
        return Turn((a, b, c), (p, q, r))

    @property
    def inverse(self) -> Turn:
        if self is UNTURNED:
            return self
        a, b, c = (self.sources.index(i) for i in range(3))
        return Turn((a, b, c), (self.signs[a], self.signs[b], self.signs[c]))

    def axis(self, axis: int) -> int:
        """Where an axis goes, its sense aside."""
        return self.sources.index(axis)

    @property
    def rows(self) -> Rows:
        x, y, z = (
            tuple(Fraction(sign * (source == i)) for i in range(3))
            for source, sign in zip(self.sources, self.signs, strict=True)
        )
        return x, y, z  # type: ignore[return-value]


UNTURNED = Turn()


def plus(a: Point, b: Point) -> Point:
    """The sum; most numbers of most shifts are 0, and fractions are slow."""
    return a[0] + b[0] if b[0] else a[0], a[1] + b[1] if b[1] else a[1], a[2] + b[2] if b[2] else a[2]


@dataclass(frozen=True, slots=True)
class Rotation:
    """How a cell turns what fills it: x ↦ turn x, or else by `motion`."""

    turn: Turn = UNTURNED
    motion: Motion = STILL


STRAIGHT = Rotation()


def rotation_by_angles(angles: Point) -> Rotation:
    """OpenMC's (φ, θ, ψ) in degrees: the contents are turned by ψ about z, then θ about y, then φ about x.

    A point r of the cell is looked up in the filling universe at R_z(-ψ) R_y(-θ) R_x(-φ) r
    (OpenMC, Cell::set_rotation and find_cell_inner), of which that is the inverse.
    """
    if all(angle % 90 == 0 for angle in angles):
        turn = UNTURNED
        for axis in (2, 1, 0):
            for _ in range(int(angles[axis] / 90) % 4):
                turn = _QUARTERS[axis].after(turn)
        return Rotation(turn)
    motion = STILL
    for axis in (2, 1, 0):
        if angles[axis]:
            motion = motion.rotate(_AXES[axis], float(angles[axis]))
    return Rotation(motion=motion)


def rotation_by_matrix(rows: Rows) -> Rotation | None:
    """A point r of the cell is looked up at M r, so the contents move by the inverse of M; None if it has none."""
    columns = tuple(zip(*rows, strict=True))
    if all(sorted(map(abs, line)) == [0, 0, 1] for line in (*rows, *columns)):
        sources = tuple(next(i for i in range(3) if column[i]) for column in columns)
        signs = tuple(int(column[source]) for column, source in zip(columns, sources, strict=True))
        return Rotation(Turn(sources, signs))  # type: ignore[arg-type]
    back = inverse(rows)
    if back is None:
        return None
    return Rotation(motion=STILL.transform(_matrix(back)))


def departure(rows: Rows) -> float:
    """How far a matrix is from a rotation: the largest entry of |M Mᵀ - 1|."""
    return max(
        abs(float(sum((a * b for a, b in zip(u, v, strict=True)), Fraction(-(i == j)))))
        for i, u in enumerate(rows)
        for j, v in enumerate(rows)
    )


@dataclass(frozen=True)
class Placement:
    """x ↦ outer(turn x + shift), from a universe to the world."""

    turn: Turn = UNTURNED
    shift: Point = ORIGIN
    outer: Motion = STILL

    def point(self, own: Point) -> Point:
        """A point before the outer motion."""
        return plus(self.turn.apply(own), self.shift)

    @property
    def back(self) -> Placement:
        """From before the outer motion to the universe."""
        turn = self.turn.inverse
        x, y, z = turn.apply(self.shift)
        return Placement(turn, (-x, -y, -z))

    def inner(self, shift: Point, rotation: Rotation = STRAIGHT) -> Placement:
        """The placement of what is rotated and then translated by `shift` within this."""
        if rotation.motion.is_identity:
            return Placement(self.turn.after(rotation.turn), self.point(shift), self.outer)
        return Placement(outer=self.entry(shift, rotation).then(self.outer))

    def entry(self, shift: Point, rotation: Rotation) -> Motion:
        """From what is rotated by other angles than multiples of 90 degrees to before the outer motion."""
        motion, whole = turned_by(rotation.motion, self.turn), self.point(shift)
        return motion.translate(floats(whole)) if any(whole) else motion


def turned_by(motion: Motion, turn: Turn) -> Motion:
    """A motion, and then quarter turns."""
    return motion if turn == UNTURNED else motion.transform(_matrix(turn.rows))


def rounded_sum(a: Fraction, b: Fraction) -> float:
    """The sum, rounded once: a quotient of integers, as a fraction of it would only be brought to lowest terms."""
    p, q = a.as_integer_ratio()
    r, s = b.as_integer_ratio()
    return (p * s + r * q) / (q * s)


def moved(point: Point, shift: Point) -> Vector:
    """A point elsewhere, every number of it rounded once."""
    return rounded_sum(point[0], shift[0]), rounded_sum(point[1], shift[1]), rounded_sum(point[2], shift[2])


def floats(point: Point) -> Vector:
    x, y, z = (float(value) for value in point)
    return x, y, z


def _matrix(rows: Rows) -> Matrix4:
    return (*((*floats(row), 0.0) for row in rows), (0.0, 0.0, 0.0, 1.0))


def inverse(rows: Rows) -> Rows | None:
    a, b, c = rows
    bc, ca, ab = _cross(b, c), _cross(c, a), _cross(a, b)
    determinant = sum(x * y for x, y in zip(a, bc, strict=True))
    if not determinant:
        return None
    x, y, z = (tuple(line[i] / determinant for line in (bc, ca, ab)) for i in range(3))
    return x, y, z  # type: ignore[return-value]


def _cross(u: Point, v: Point) -> Point:
    return u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]


_AXES: tuple[Vector, Vector, Vector] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
# A quarter turn about x takes y to z: new (x, y, z) = old (x, -z, y)
_QUARTERS = (Turn((0, 2, 1), (1, -1, 1)), Turn((2, 1, 0), (1, 1, -1)), Turn((1, 0, 2), (-1, 1, 1)))
