"""Surfaces f = 0 of OpenMC and MCNP, in fractions: placed copies, relations to boxes, and solids.

The solid of a surface is its negative side, f <= 0. All surfaces have these methods: `placed` returns the surface after
the turn and the shift of a placement, `extent` a box around one side, `side_of` the side on which a box lies, and
`solid` the shape. Extents may be too large, and `side_of` may return 0 for "not known", but neither is ever wrong.
The last part reads OpenMC's <surface> elements. Lengths are in cm.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cached_property

from ..._util.arrays import Vector
from ..._util.records import dataclass
from ...geometry.general_quadric import Quadric
from ...geometry.primitives import HalfSpace, Sphere
from ...geometry.quadrics import EllipticCone, EllipticCylinder
from ...geometry.shape import Solid
from ...geometry.transform import IDENTITY_MOTION, Motion
from ...numerics.rational import cross, dot3
from ..importers import OmittedPart
from ..xml_tree import XmlElement
from .placement import (
    ORIGIN,
    UNBOUNDED,
    AxisTurn,
    Extent,
    ExtentEnd,
    Point,
    UniversePlacement,
    to_floats,
    try_floats,
)
from .values import OpenmcValues, format_title, quote_word

_CLEAR_MARGIN = 2.0**-40
"""Margin for sums in floats, as a share of their terms; rounding loses far less."""
_LARGEST_INTEGER = 2**53
"""The largest integer up to which floats hold each."""
_CROSS_AXES: dict[int | None, tuple[int, ...]] = {None: (0, 1, 2), 0: (1, 2), 1: (0, 2), 2: (0, 1)}
TERMS = ("xx", "yy", "zz", "xy", "yz", "xz", "x", "y", "z", "constant")
"""The terms of OpenMC's quadric, in the order of its coefficients."""


@dataclass(frozen=True)
class FlatSurface:
    """A plane, f = normal·x - offset."""

    normal: Point
    offset: Fraction

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def _hash(self) -> int:
        return _quick_hash((*self.normal, self.offset))

    @cached_property
    def floats(self) -> tuple[Vector, float] | None:
        """The normal and the offset, each number rounded once; None if they are too large.

        The normal consists of integers without a common factor where floats hold these. So the multiples of a plane are
        one plane, and 0.3 x = 0.21 is the plane x = 0.7.
        """
        if self.axis is None:
            size = _common_factor(self.normal)
        else:
            size = abs(self.normal[self.axis])
        if size == 1:
            return try_floats(self.normal, self.offset)
        x, y, z = (n / size for n in self.normal)
        return try_floats((x, y, z), self.offset / size)

    def placed(self, place: UniversePlacement) -> FlatSurface:
        """Return the plane after the turn and the shift of a placement: this object where they do not move it."""
        normal, offset = place.turn.apply(self.normal), self.offset
        for n, s in zip(normal, place.shift, strict=True):
            if n and s:
                offset += s if n == 1 else n * s
        return self if normal is self.normal and offset is self.offset else FlatSurface(normal, offset)

    @cached_property
    def axis(self) -> int | None:
        """The axis along which the normal lies, or None."""
        x, y, z = self.normal
        if x:
            return None if y or z else 0
        if y:
            return None if z else 1
        return 2 if z else None

    def extent(self, positive: bool) -> Extent:
        """Return a box around the side f >= 0 (`positive`) or f <= 0."""
        axis = self.axis
        if axis is None:
            return UNBOUNDED
        ends: list[ExtentEnd] = [None, None, None]
        ends[axis] = self.end
        sides = (ends[0], ends[1], ends[2])
        return Extent(low=sides) if positive == (self.normal[axis] > 0) else Extent(high=sides)

    @cached_property
    def end(self) -> Fraction:
        """Where a plane across an axis cuts that."""
        assert self.axis is not None
        return self.offset / self.normal[self.axis]

    @cached_property
    def direction(self) -> tuple[tuple[tuple[int, int], ...], Fraction, bool]:
        """The normal and offset over the first component of the normal, and whether that is positive.

        So parallel planes have equal normals. These are ratios of integers, whose hash is quick.
        """
        first = next(n for n in self.normal if n)
        return tuple((n / first).as_integer_ratio() for n in self.normal), self.offset / first, first > 0

    def side_of(self, extent: Extent) -> int:
        """Return -1 if f <= 0 in all of the extent, +1 if f >= 0 in all of it, else 0."""
        # Across an axis one comparison of fractions decides; a slanted plane needs products of them
        clear = self._clear_side_of(extent) if self.axis is None else None
        if clear is not None:
            return clear
        most = extent.most(self.normal)
        if most is not None and most <= self.offset:
            return -1
        least = extent.least(self.normal)
        return 1 if least is not None and least >= self.offset else 0

    def _clear_side_of(self, extent: Extent) -> int | None:
        """Return `side_of` as floats show it, None if it is close."""
        if self.floats is None or extent.floats is None:
            return None
        (normal, offset), least, most = self.floats, 0.0, 0.0
        size = abs(offset)
        for n, low, high in zip(normal, *extent.floats, strict=True):
            if n:
                a, b = (n * low, n * high) if n > 0 else (n * high, n * low)
                least, most = least + a, most + b
                size += sum(abs(end) for end in (a, b) if math.isfinite(end))
        margin = _CLEAR_MARGIN * size
        # `not <`, so that NaN counts as close
        if not margin < math.inf or abs(most - offset) <= margin or abs(least - offset) <= margin:
            return None
        return -1 if most < offset else int(least > offset)

    def solid(self, positive: bool = False) -> HalfSpace:
        """Return the half-space f <= 0, or f >= 0 if `positive`: one object for each side."""
        if positive not in self._solids:
            sign = -1 if positive else 1
            # What is too large for floats raises here
            (x, y, z), offset = self.floats or (to_floats(self.normal), float(self.offset))
            # + 0.0 turns -0.0 into 0.0, so that equal half-spaces have equal numbers.
            self._solids[positive] = HalfSpace((sign * x + 0.0, sign * y + 0.0, sign * z + 0.0), sign * offset + 0.0)
        return self._solids[positive]

    @cached_property
    def _solids(self) -> dict[bool, HalfSpace]:
        return {}


@dataclass(frozen=True)
class RoundSurface:
    """A cylinder about `axis`, or a sphere if `axis` is None: f = |x - center|² - radius², measured across the axis.

    Of radius 0, the innermost of equal rings say, it has no inside, and no volume is cut from its outside.
    """

    axis: int | None
    center: Point
    radius: Fraction

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def _hash(self) -> int:
        return _quick_hash((*self.center, self.radius))

    @cached_property
    def floats(self) -> tuple[Vector, float] | None:
        """The center and the radius, each rounded once; None if they are too large."""
        return try_floats(self.center, self.radius)

    @property
    def origin(self) -> Point:
        """The point that a placement moves."""
        return self.center

    @property
    def cross_axes(self) -> tuple[int, ...]:
        """The axes along which the distance is measured."""
        return _CROSS_AXES[self.axis]

    def placed(self, place: UniversePlacement) -> RoundSurface:
        """Return the surface after the turn and the shift of a placement."""
        axis = None if self.axis is None else place.turn.axis(self.axis)
        x, y, z = place.point(self.center)
        # A shift along the axis does not move a cylinder, and equal cylinders must stay equal
        return RoundSurface(axis, _drop_axis(axis, (x, y, z)), self.radius)

    def extent(self, positive: bool) -> Extent:
        """Return the box around the solid; the outside (`positive`) is unbounded."""
        return UNBOUNDED if positive else self._box

    @cached_property
    def _box(self) -> Extent:
        lows: list[ExtentEnd] = [None, None, None]
        highs: list[ExtentEnd] = [None, None, None]
        for i in self.cross_axes:
            lows[i], highs[i] = self.center[i] - self.radius, self.center[i] + self.radius
        return Extent((lows[0], lows[1], lows[2]), (highs[0], highs[1], highs[2]))

    def side_of(self, extent: Extent) -> int:
        """Return -1 if f < 0 in all of the extent, +1 if f > 0 in all of it, else 0."""
        if not self.radius:
            return 1
        if self.floats is not None and extent.floats is not None:
            clear = _clear_side_of_box(*self.floats, *extent.floats, self.cross_axes)
            if clear is not None:
                return clear
        least, most = extent.square_distances(self.center, self.cross_axes)
        square = self.radius**2
        if most is not None and most < square:
            return -1
        return 1 if least > square else 0

    def side_of_plane(self, plane: FlatSurface) -> int:
        """Return -1 if the whole solid lies strictly below a plane, +1 if it lies strictly above, else 0."""
        # The plane meets an endless cylinder somewhere
        if self.axis is not None and plane.normal[self.axis]:
            return 0
        clear = self._clear_side_of_plane(plane)
        if clear is not None:
            return clear
        # Compare squares in fractions: a square root would be rounded.
        height = sum((n * c for n, c in zip(plane.normal, self.center, strict=True)), -plane.offset)
        if height**2 <= self.radius**2 * sum(n * n for n in plane.normal):
            return 0
        return 1 if height > 0 else -1

    def _clear_side_of_plane(self, plane: FlatSurface) -> int | None:
        """Return the side of a plane as floats show it, which is nearly always; None if close or too large."""
        if self.floats is None or plane.floats is None:
            return None
        (center, radius), (normal, height) = self.floats, plane.floats
        terms = [n * c for n, c in zip(normal, center, strict=True)]
        reach, above = radius * math.hypot(*normal), sum(terms) - height
        # A difference above the margin has the sign that fractions would give.
        margin = _CLEAR_MARGIN * (sum(map(abs, terms)) + abs(height) + reach)
        if abs(above) < reach - margin:
            return 0
        return (1 if above > 0 else -1) if abs(above) > reach + margin else None

    def side_of_round(self, other: RoundSurface) -> int:
        """Return -1 if this solid lies strictly inside another one with the same axis, +1 if strictly outside, else 0.

        0 for another axis.
        """
        if self.axis != other.axis:
            return 0
        if self.floats is not None and other.floats is not None:
            (center, radius), (point, other_radius) = self.floats, other.floats
            apart, gap, reach = math.dist(center, point), other_radius - radius, other_radius + radius
            margin = _CLEAR_MARGIN * (sum(map(abs, center)) + sum(map(abs, point)) + reach)
            if min(abs(apart - gap), abs(apart - reach)) > margin:
                return -1 if apart < gap else int(apart > reach)
        square = sum(((a - b) ** 2 for a, b in zip(self.center, other.center, strict=True)), Fraction(0))
        exact_gap = other.radius - self.radius
        if exact_gap > 0 and square < exact_gap**2:
            return -1
        return int(square > (self.radius + other.radius) ** 2)

    def solid(self) -> Solid:
        """Return the ball, or the infinite cylinder."""
        center, radius = self.floats or (to_floats(self.center), float(self.radius))
        if self.axis is None:
            return Sphere(radius, center)
        return _move_shape(
            EllipticCylinder(1, 1), _orient_shape(self.axis, IDENTITY_MOTION.scale((radius, radius, 1)), center)
        )


@dataclasses.dataclass(frozen=True, slots=True)
class ConeSurface:
    """A cone of two nappes: f = (distance from the axis)² - square × (height over the apex)²."""

    axis: int
    apex: Point
    square: Fraction

    @property
    def origin(self) -> Point:
        """The point that a placement moves."""
        return self.apex

    def placed(self, place: UniversePlacement) -> ConeSurface:
        """Return the cone after the turn and the shift of a placement."""
        return ConeSurface(place.turn.axis(self.axis), place.point(self.apex), self.square)

    def extent(self, positive: bool) -> Extent:
        """Return all of space: both sides are unbounded."""
        return UNBOUNDED

    def side_of(self, extent: Extent) -> int:
        """Return 0: the side of a box is not computed for cones."""
        return 0

    def solid(self) -> Solid:
        """Return the infinite double cone."""
        return _move_shape(
            EllipticCone(1, 1, float(self.square)), _orient_shape(self.axis, IDENTITY_MOTION, to_floats(self.apex))
        )


@dataclass(frozen=True, eq=False)
class GeneralSurface:
    """A general quadric: f is the sum of `coefficients` times `TERMS` of x - shift.

    Surfaces are equal if fractions show that they are one with one inside: multiples of each other, about any points.
    """

    coefficients: tuple[Fraction, ...]
    shift: Point

    def __eq__(self, other: object) -> bool:
        return isinstance(other, GeneralSurface) and self._ratios == other._ratios

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def _hash(self) -> int:
        return _quick_hash(self._ratios)

    @cached_property
    def _ratios(self) -> tuple[Fraction, ...]:
        """The coefficients about the origin over the size of the first that is not 0."""
        xx, yy, zz, xy, yz, xz, *linear, constant = self.coefficients
        if any(self.shift):
            x, y, z = self.shift
            slopes = (2 * xx * x + xy * y + xz * z, xy * x + 2 * yy * y + yz * z, xz * x + yz * y + 2 * zz * z)
            for s, slope, factor in zip(self.shift, slopes, linear, strict=True):
                constant += s * (slope / 2 - factor)
            linear = [factor - slope for factor, slope in zip(linear, slopes, strict=True)]
        own = (xx, yy, zz, xy, yz, xz, *linear, constant)
        lead = abs(next(value for value in own if value))
        return own if lead == 1 else tuple(value / lead for value in own)

    @property
    def reversed(self) -> GeneralSurface:
        """The surface with its other side inside."""
        return GeneralSurface(tuple(-value for value in self.coefficients), self.shift)

    @property
    def origin(self) -> Point:
        """The point that a placement moves."""
        return self.shift

    def placed(self, place: UniversePlacement) -> GeneralSurface:
        """Return the quadric after the turn and the shift of a placement.

        The coefficients stay those about `shift`, which a translation does not change.
        """
        return GeneralSurface(_turn_coefficients(self.coefficients, place.turn), place.point(self.shift))

    @property
    def planes_around(self) -> list[tuple[Point, Fraction]]:
        """Planes (normal, offset) around an ellipsoid or an elliptic cylinder about `shift`; none for other quadrics.

        With q = x - shift and f = qᵀ M q - k, (row·q)² <= M[i][i] (qᵀ M q) for each row of M, by Cauchy and Schwarz.
        """
        xx, yy, zz, xy, yz, xz, *linear, constant = self.coefficients
        rows = (xx, xy / 2, xz / 2), (xy / 2, yy, yz / 2), (xz / 2, yz / 2, zz)
        squares = xx, yy, zz
        minors = [squares[i] * squares[j] - rows[i][j] ** 2 for i, j in ((0, 1), (1, 2), (0, 2))]
        if any(linear) or constant >= 0 or min(*squares, *minors, dot3(rows[0], cross(rows[1], rows[2]))) < 0:
            return []
        planes: list[tuple[Point, Fraction]] = []
        for row, square in zip(rows, squares, strict=True):
            if square:
                # Rounded up by far more than a root is
                far, middle = Fraction(math.sqrt(-square * constant) * (1 + 1e-12)), dot3(row, self.shift)
                planes += [(row, middle + far), ((-row[0], -row[1], -row[2]), far - middle)]
        return planes

    def extent(self, positive: bool) -> Extent:
        """Return all of space: bounds are not computed for general quadrics."""
        return UNBOUNDED

    def side_of(self, extent: Extent) -> int:
        """Return 0: the side of a box is not computed for general quadrics."""
        return 0

    def solid(self) -> Solid:
        """Return the quadric f <= 0.

        The terms but the constant are integers without a common factor where floats hold these: the multiples of a
        quadric are one surface, and those of the opposite sign the outside of a sphere, cylinder or cone that they are.
        """
        if outside := round_quadric([-c for c in self.coefficients], self.shift):
            return ~outside.solid()
        size = _common_factor(self.coefficients[:9])
        values = {name: float(value / size) for name, value in zip(TERMS, self.coefficients, strict=True) if value}
        quadric = Quadric(coefficients=values)
        return quadric.translate(to_floats(self.shift)) if any(self.shift) else quadric


CurvedSurface = RoundSurface | ConeSurface | GeneralSurface
Surface = FlatSurface | CurvedSurface


def _clear_side_of_box(center: Vector, radius: float, low: Vector, high: Vector, axes: Iterable[int]) -> int | None:
    """Return `RoundSurface.side_of` as floats show it; None if it is close. Infinite ends are ±inf."""
    least, most, size = 0.0, 0.0, radius * radius
    for i in axes:
        a, b, c = low[i], high[i], center[i]
        nearest, farthest = max(a - c, c - b, 0.0), max(c - a, b - c)
        least, most = least + nearest * nearest, most + farthest * farthest
        reach = max(abs(c), abs(a) if a > -math.inf else 0.0, abs(b) if b < math.inf else 0.0)
        size += 4.0 * reach * reach
    margin, square = _CLEAR_MARGIN * size, radius * radius
    if not margin < math.inf or abs(least - square) <= margin or abs(most - square) <= margin:
        return None
    return -1 if most < square else int(least > square)


def _common_factor(numbers: Sequence[Fraction]) -> Fraction:
    """Return the factor by which numbers are integers without a common one; 1 where floats do not hold these."""
    size = Fraction(math.gcd(*(n.numerator for n in numbers)), math.lcm(*(n.denominator for n in numbers)))
    return size if max(abs(n) for n in numbers) <= size * _LARGEST_INTEGER else Fraction(1)


def _quick_hash(values: tuple[Fraction, ...]) -> int:
    """Return a hash of fractions by numerators and denominators.

    The hash of `Fraction` is slow, because it must agree with the hashes of equal numbers of other types.
    """
    return hash(tuple(map(Fraction.as_integer_ratio, values)))


def _drop_axis(axis: int | None, point: Point) -> Point:
    """Return the point with 0 along the axis, so that equal cylinders have equal centers."""
    x, y, z = (Fraction(0) if i == axis else value for i, value in enumerate(point))
    return x, y, z


def _move_shape(shape: Solid, motion: Motion) -> Solid:
    """Return a shape with a motion. Raise ValueError if the motion is out of range."""
    motion.check(type(shape).__name__)
    return replace(shape, motion=motion)


def _orient_shape(axis: int, upright: Motion, place: Vector) -> Motion:
    """Return the motion that applies `upright`, then turns z to another axis, then translates.

    The sense of the turn does not matter: the shapes equal their mirror images.
    """
    if axis != 2:
        upright = upright.rotate((0, 1, 0), 90) if axis == 0 else upright.rotate((1, 0, 0), 90)
    return upright.translate(place) if any(place) else upright


def _turn_coefficients(coefficients: tuple[Fraction, ...], turn: AxisTurn) -> tuple[Fraction, ...]:
    """Return the coefficients after a turn, which exchanges the axes of each term, with signs."""
    result = dict.fromkeys(TERMS, Fraction(0))
    for name, value in zip(TERMS, coefficients, strict=True):
        if name == "constant":
            result[name] = value
            continue
        axes = ["xyz".index(letter) for letter in name]
        # Names of mixed terms are in alphabetical order
        letters = sorted("xyz"[turn.axis(axis)] for axis in axes)
        sign = math.prod(turn.signs[turn.axis(axis)] for axis in axes)
        result["".join(letters)] = sign * value
    return tuple(result.values())


# Readers of OpenMC's surface elements, by type

Coefficients = tuple[Fraction, ...]
TORUS_TYPES = ("x-torus", "y-torus", "z-torus")
BOUNDARIES = {
    "": "transmission", "transmit": "transmission", "reflect": "reflective", "reflecting": "reflective",
} | {name: name for name in ("transmission", "vacuum", "reflective", "white", "periodic")}  # fmt: skip
_ZERO, _ONE = Fraction(0), Fraction(1)


@dataclasses.dataclass(frozen=True, slots=True)
class OpenmcSurface:
    """A surface of a file, with its boundary condition."""

    id: int
    name: str
    surface: Surface
    boundary: str

    def __str__(self) -> str:
        return format_title("surface", self.id, self.name)


def read_surface(element: XmlElement) -> OpenmcSurface:
    """Return the surface of a <surface> element.

    Raise OpenmcElementError with all its errors, and OmittedPart for a torus, which is no quadric.
    """
    values = OpenmcValues(element, "surface")
    number, name = values.title()
    boundary = values.attempt(lambda: _boundary(values), "")
    kind = (values.text("type") or "").lower()
    if kind in TORUS_TYPES:
        values.finish()
        raise OmittedPart(f"{values.where} is a torus ({kind}), which is no quadric")
    surface = values.attempt(lambda: _read_surface_type(values), None)
    values.finish()
    assert surface is not None
    return OpenmcSurface(number, name, surface, boundary)


def _boundary(values: OpenmcValues) -> str:
    boundary = (values.text("boundary") or "").lower()
    if boundary not in BOUNDARIES:
        names = ", ".join(sorted(set(BOUNDARIES.values())))
        raise values.mistake(f"boundary must be one of {names}, got {quote_word(boundary)}")
    return BOUNDARIES[boundary]


def _read_surface_type(values: OpenmcValues) -> Surface | None:
    kind = values.require("type").lower()
    if kind not in _KINDS:
        raise values.mistake(f"type must be one of {', '.join(_KINDS)}, got {quote_word(kind)}")
    count, make = _KINDS[kind]
    try:
        return make(values.numbers("coeffs", count))
    except ValueError as error:
        raise values.mistake(str(error)) from None


def build_surface(kind: str, numbers: Coefficients) -> Surface:
    """Return the surface of a type with coefficients, as OpenMC defines them. Raise ValueError if they make none."""
    return _KINDS[kind][1](numbers)


def _plane(numbers: Coefficients) -> Surface:
    """Return the plane A x + B y + C z = D."""
    a, b, c, d = numbers
    if not (a or b or c):
        raise ValueError("coeffs must have a normal (A, B, C) that is not zero")
    return FlatSurface((a, b, c), d)


def _axis_plane(axis: int) -> Callable[[Coefficients], Surface]:
    def make(numbers: Coefficients) -> Surface:
        x, y, z = (_ONE if i == axis else _ZERO for i in range(3))
        return FlatSurface((x, y, z), numbers[0])

    return make


def _cylinder(axis: int) -> Callable[[Coefficients], Surface]:
    """Return a builder from two coordinates of the axis, in the order x, y, z, and the radius."""

    def make(numbers: Coefficients) -> Surface:
        coordinates = list(numbers[:2])
        # OpenMC lists y0 z0 of an x-cylinder, x0 z0 of a y-cylinder, x0 y0 of a z-cylinder
        coordinates.insert(axis, _ZERO)
        x, y, z = coordinates
        return RoundSurface(axis, (x, y, z), _radius(numbers[2]))

    return make


def _radius(value: Fraction) -> Fraction:
    if value < 0:
        raise ValueError(f"coeffs: the radius must be >= 0, got {float(value):g}")
    return value


def _sphere(numbers: Coefficients) -> Surface:
    x, y, z, radius = numbers
    return RoundSurface(None, (x, y, z), _radius(radius))


def _cone(axis: int) -> Callable[[Coefficients], Surface]:
    """Return a builder from the apex and the squared slope."""

    def make(numbers: Coefficients) -> Surface:
        x, y, z, square = numbers
        return ConeSurface(axis, (x, y, z), check_positive("coeffs: the R²", square))

    return make


def _quadric(numbers: Coefficients) -> Surface:
    """Return A x² + B y² + C z² + D xy + E yz + F xz + G x + H y + J z + K = 0; a plane if A to F are 0."""
    if not any(numbers[:9]):
        raise ValueError("coeffs must hold more than the constant K")
    if any(numbers[:6]):
        return round_quadric(numbers, ORIGIN) or GeneralSurface(tuple(numbers), ORIGIN)
    # A plane as FlatSurface has an extent and sides, which a quadric has not.
    x, y, z = numbers[6:9]
    return FlatSurface((x, y, z), -numbers[9])


def round_quadric(numbers: Sequence[Fraction], shift: Point) -> RoundSurface | ConeSurface | None:
    """Return the sphere, or the cylinder or cone along an axis, that a quadric is; None for another.

    The decimals of a file are exact: a cylinder that is written as a quadric is the same surface as one that is not.
    """
    squares, linear = numbers[:3], numbers[6:9]
    square = max(squares)
    others = [i for i in range(3) if squares[i] != square]
    axis = others[0] if others else None
    if square <= 0 or any(numbers[3:6]) or len(others) > 1:
        return None
    if axis is not None and (squares[axis] > 0 or (linear[axis] and not squares[axis])):
        return None
    x, y, z = (c - b / (2 * a) if a else _ZERO for a, b, c in zip(squares, linear, shift, strict=True))
    rest = sum((b * b / (4 * a) for a, b in zip(squares, linear, strict=True) if a), -numbers[9])
    if axis is not None and squares[axis]:
        return None if rest else ConeSurface(axis, (x, y, z), -squares[axis] / square)
    radius_squared = max(rest / square, _ZERO)
    radius = Fraction(math.isqrt(radius_squared.numerator), math.isqrt(radius_squared.denominator))
    return RoundSurface(axis, (x, y, z), radius) if radius and radius**2 == radius_squared else None


def check_positive(what: str, value: Fraction) -> Fraction:
    """Return a value above 0. Raise ValueError for others; `what` names it."""
    if value <= 0:
        raise ValueError(f"{what} must be > 0, got {float(value):g}")
    return value


_KINDS: dict[str, tuple[int, Callable[[Coefficients], Surface]]] = {
    "x-plane": (1, _axis_plane(0)), "y-plane": (1, _axis_plane(1)), "z-plane": (1, _axis_plane(2)),
    "plane": (4, _plane),
    "x-cylinder": (3, _cylinder(0)), "y-cylinder": (3, _cylinder(1)), "z-cylinder": (3, _cylinder(2)),
    "sphere": (4, _sphere),
    "x-cone": (4, _cone(0)), "y-cone": (4, _cone(1)), "z-cone": (4, _cone(2)),
    "quadric": (10, _quadric),
}  # fmt: skip
