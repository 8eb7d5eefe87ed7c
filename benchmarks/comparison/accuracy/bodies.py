"""The solids whose distances are measured: exact numbers for the reference, a shape for Conicoid.

A body is, in exact numbers, (x, y, z, 1) Q (x, y, z, 1)ᵀ <= 0 between slabs low <= n·x <= high. All lengths are floats
in the measured precision, so that every system gets the same solid to the bit.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any
from zlib import crc32

import numpy as np
import numpy.typing as npt

from conicoid.geometry.general_quadric import Quadric
from conicoid.geometry.primitives import Box, Cone, Cylinder, Sphere
from conicoid.geometry.shape import Shape

Floats = npt.NDArray[np.float64]
Row = tuple[Fraction, ...]
Vector = tuple[float, float, float]


@dataclass(frozen=True)
class ExactSlab:
    """low <= normal·x <= high."""

    normal: Row
    low: Fraction
    high: Fraction


@dataclass(frozen=True)
class ExactBall:
    """|x - center|² <= radius²."""

    center: Vector
    radius: float

    def quadric(self) -> list[Row]:
        c, r = _exact(self.center), Fraction(self.radius)
        return _about(c, [[Fraction(i == j) for j in range(3)] for i in range(3)], (Fraction(),) * 3, -r * r)

    def slabs(self) -> list[ExactSlab]:
        return []

    def shape(self) -> Shape:
        return Sphere(self.radius, self.center)


@dataclass(frozen=True)
class ExactBlock:
    """low <= x <= high on every axis."""

    low: Vector
    high: Vector

    def quadric(self) -> None:
        """It has none."""

    def slabs(self) -> list[ExactSlab]:
        axes = ([Fraction(i == j) for j in range(3)] for i in range(3))
        return [ExactSlab(tuple(n), *_exact((a, b))) for n, a, b in zip(axes, self.low, self.high, strict=True)]

    def shape(self) -> Shape:
        return Box(self.low, self.high)


@dataclass(frozen=True)
class ExactRevolution:
    """A closed cylinder (r0 = r1), cone (r1 = 0) or frustum about the axis from start to end.

    With q = x - start and a = end - start: 0 <= q·a <= a·a and a·a |q × a|² <= (r0 a·a + (r1 - r0) q·a)².
    """

    start: Vector
    end: Vector
    start_radius: float
    end_radius: float

    def _axis(self) -> tuple[Row, Row, Fraction]:
        start, end = _exact(self.start), _exact(self.end)
        a = tuple(q - p for p, q in zip(start, end, strict=True))
        return start, a, _dot(a, a)

    def quadric(self) -> list[Row]:
        start, a, n = self._axis()
        r, growth = Fraction(self.start_radius), Fraction(self.end_radius) - Fraction(self.start_radius)
        # |q × a|² = a·a q·q - (q·a)²
        factor = n + growth * growth
        square = [[n * n * (i == j) - factor * a[i] * a[j] for j in range(3)] for i in range(3)]
        return _about(start, square, tuple(-r * n * growth * x for x in a), -((r * n) ** 2))

    def slabs(self) -> list[ExactSlab]:
        start, a, n = self._axis()
        foot = _dot(start, a)
        return [ExactSlab(a, foot, foot + n)]

    def shape(self) -> Shape:
        if self.start_radius == self.end_radius:
            return Cylinder(self.start, self.end, self.start_radius)
        return Cone(self.start, self.end, self.start_radius, self.end_radius)


@dataclass(frozen=True)
class ExactQuadric:
    """The quadric of ten coefficients: xx x² + ... + xy x y + ... + x x + ... + constant <= 0."""

    coefficients: dict[str, float]

    def quadric(self) -> list[Row]:
        c = {name: Fraction(value) for name, value in self.coefficients.items()}
        half = Fraction(1, 2)
        xy, yz, xz, x, y, z = (half * c[name] for name in ("xy", "yz", "xz", "x", "y", "z"))
        return [(c["xx"], xy, xz, x), (xy, c["yy"], yz, y), (xz, yz, c["zz"], z), (x, y, z, c["constant"])]

    def slabs(self) -> list[ExactSlab]:
        return []

    def shape(self) -> Shape:
        return Quadric(coefficients=self.coefficients)


Body = ExactBall | ExactBlock | ExactRevolution | ExactQuadric


def inside(body: Body, points: Floats) -> npt.NDArray[np.bool_]:
    """Which of points (n, 3) lie in the body, in floats: good enough to choose rays by."""
    result = np.ones(len(points), bool)
    for slab in body.slabs():
        h = points @ np.array(slab.normal, float)
        result &= (float(slab.low) <= h) & (h <= float(slab.high))
    quadric: Any = body.quadric()
    if quadric is not None:
        whole = np.column_stack([points, np.ones(len(points))])
        result &= np.einsum("ni,ij,nj->n", whole, np.array(quadric, float), whole) <= 0
    return result


def _exact(numbers: Any) -> Row:
    return tuple(map(Fraction, numbers))


def _dot(a: Row, b: Row) -> Fraction:
    return sum((x * y for x, y in zip(a, b, strict=True)), Fraction())


def _about(center: Row, square: list[list[Fraction]], linear: Row, constant: Fraction) -> list[Row]:
    """Q of qᵀ square q + 2 linear·q + constant, q = x - center."""
    moved = tuple(linear[i] - _dot(tuple(square[i]), center) for i in range(3))
    rest = constant - _dot(linear, center) - _dot(moved, center)
    return [*((*square[i], moved[i]) for i in range(3)), (*moved, rest)]


# Random bodies to measure on, with the data that a generator of rays needs of each. Lengths that systems combine before
# they trace (ends of an axis, sides of a box) are drawn from a coarse grid, so that sums and differences of them are
# exact in the measured precision too.

Random = np.random.Generator
Points = Callable[[Random, int], tuple[Floats, Floats]]


@dataclass(frozen=True)
class Precision:
    """The precision of the inputs: all of them are such floats, the same for every system."""

    name: str
    dtype: npt.DTypeLike
    bits: int
    grid: int

    def rounded(self, array: Any) -> Floats:
        return np.asarray(array, float).astype(self.dtype).astype(float)

    def coarse(self, array: Any) -> Any:
        return np.round(np.asarray(array, float) * 2.0**self.grid) / 2.0**self.grid


SINGLE = Precision("float32", np.float32, 24, 10)
DOUBLE = Precision("float64", np.float64, 53, 26)


@dataclass(frozen=True)
class Subject:
    """A body about `center`, hardly wider than `size`.

    `rim(random, n)` gives points (n, 3) where rays may graze it, and normals there; `parallels(random, n)`
    directions (n, 3) along its axis, rulings, asymptotes or faces.
    """

    body: Body
    center: Floats
    size: float
    rim: Points
    parallels: Callable[[Random, int], Floats]


def ball(random: Random, precision: Precision, scale: float) -> Subject:
    center = precision.rounded(random.uniform(-4, 4, 3) * scale)
    radius = float(precision.rounded(random.uniform(0.5, 2) * scale))

    def rim(random: Random, n: int) -> tuple[Floats, Floats]:
        normals = unit(random.normal(size=(n, 3)))
        return center + radius * normals, normals

    return Subject(ExactBall(vector(center), radius), center, radius, rim, _axes)


def block(random: Random, precision: Precision, scale: float) -> Subject:
    low = precision.coarse(random.uniform(-4, 4, 3)) * scale
    sides = precision.coarse(random.uniform(0.5, 2, 3)) * scale
    center = low + sides / 2

    def rim(random: Random, n: int) -> tuple[Floats, Floats]:
        """Points of edges, and normals between those of the two sides."""
        signs = random.choice([-1.0, 1.0], (n, 3))
        signs[np.arange(n), random.integers(0, 3, n)] = 0
        places = np.where(signs == 0, random.uniform(-1, 1, (n, 3)), signs)
        return center + places * sides / 2, unit(signs * random.uniform(0.1, 1, (n, 3)))

    def parallels(random: Random, n: int) -> Floats:
        directions = unit(random.normal(size=(n, 3)))
        directions[np.arange(n), random.integers(0, 3, n)] = 0
        return directions

    size = float(np.linalg.norm(sides)) / 2
    return Subject(ExactBlock(vector(low), vector(low + sides)), center, size, rim, parallels)


def cylinder(random: Random, precision: Precision, scale: float) -> Subject:
    radius = float(precision.coarse(random.uniform(0.5, 2))) * scale
    return revolution(*_upright(random, precision, scale), radius, radius)


def cone(random: Random, precision: Precision, scale: float) -> Subject:
    radius = float(precision.coarse(random.uniform(0.5, 2))) * scale
    return revolution(*_upright(random, precision, scale), radius, 0.0)


def oblique(random: Random, precision: Precision, scale: float) -> Subject:
    """A cylinder or a frustum about any axis."""
    start, end = (precision.rounded(random.uniform(-3, 3, 3) * scale) for _ in range(2))
    radii = precision.rounded(random.uniform(0.3, 2, 2) * scale).tolist()
    return revolution(start, end, radii[0], radii[random.integers(0, 2)])


def _upright(random: Random, precision: Precision, scale: float) -> tuple[Floats, Floats]:
    """Ends of an axis along a coordinate axis, either way."""
    start = precision.coarse(random.uniform(-4, 4, 3)) * scale
    step = np.zeros(3)
    step[random.integers(0, 3)] = random.choice([-1, 1]) * precision.coarse(random.uniform(0.5, 3)) * scale
    return start, start + step


def revolution(start: Floats, end: Floats, r0: float, r1: float) -> Subject:
    axis = end - start
    length = float(np.linalg.norm(axis))

    def circle(random: Random, n: int) -> Floats:
        across = random.normal(size=(n, 3))
        across -= np.outer(across @ axis, axis) / length**2
        return unit(across)

    def rim(random: Random, n: int) -> tuple[Floats, Floats]:
        """Points of the side."""
        outward, height = circle(random, n), random.uniform(0.02, 0.98, (n, 1))
        radius = r0 + (r1 - r0) * height
        return start + height * axis + radius * outward, unit(outward * length + (r0 - r1) * axis / length)

    def parallels(random: Random, n: int) -> Floats:
        """Along rulings of the side, both ways."""
        return unit((axis + (r1 - r0) * circle(random, n)) * random.choice([-1, 1], (n, 1)))

    size = float(np.hypot(length / 2, max(r0, r1)))
    return Subject(ExactRevolution(vector(start), vector(end), r0, r1), (start + end) / 2, size, rim, parallels)


def quadric(random: Random, precision: Precision, scale: float) -> Subject:
    """An ellipsoid or a hyperboloid of one or two sheets, turned and moved, by ten coefficients.

    In its own frame x²/a² + y²/b² + s z²/c² <= k with s and k of ±1. The coefficients are rounded, and the surface that
    is meant is that of the rounded ones.
    """
    sign, level = ((1, 1), (-1, 1), (-1, -1))[random.integers(0, 3)]
    center, radii = random.uniform(-4, 4, 3) * scale, random.uniform(0.5, 2, 3) * scale
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
    square = turn @ np.diag(np.array([1, 1, sign]) * (scale / radii) ** 2) @ turn.T
    linear = -square @ center
    constant = center @ square @ center - level * scale**2
    values = np.array([*np.diag(square), *(2 * square[[0, 1, 0], [1, 2, 2]]), *(2 * linear), constant])
    names = ("xx", "yy", "zz", "xy", "yz", "xz", "x", "y", "z", "constant")
    body = ExactQuadric(dict(zip(names, precision.rounded(values).tolist(), strict=True)))

    def place(own: Floats) -> Floats:
        return np.asarray((own * radii) @ turn.T)

    def rim(random: Random, n: int) -> tuple[Floats, Floats]:
        own = _canonical(random, n, sign, level)
        return center + place(own), unit((own * (1, 1, sign) / radii) @ turn.T)

    def parallels(random: Random, n: int) -> Floats:
        """Along asymptotes; the ellipsoid has none."""
        if sign > 0:
            return _axes(random, n)
        angle = random.uniform(0, 2 * np.pi, n)
        return unit(place(np.column_stack([np.cos(angle), np.sin(angle), np.ones(n)])))

    return Subject(body, center, float(radii.max()) * (1 if sign > 0 else 1.5), rim, parallels)


def _canonical(random: Random, n: int, sign: int, level: int) -> Floats:
    """Points (n, 3) of x² + y² + sign z² = level."""
    if sign > 0:
        return unit(random.normal(size=(n, 3)))
    angle, reach = random.uniform(0, 2 * np.pi, n), random.uniform(-1.2, 1.2, n)
    other = np.sqrt(1 + reach**2)
    across, z = (other, reach) if level > 0 else (reach, other * random.choice([-1, 1], n))
    return np.column_stack([across * np.cos(angle), across * np.sin(angle), z])


def unit(vectors: Floats) -> Floats:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))


def vector(point: Floats) -> tuple[float, float, float]:
    x, y, z = point.tolist()
    return x, y, z


def _axes(random: Random, n: int) -> Floats:
    """Along the axes of coordinates, both ways."""
    directions = np.zeros((n, 3))
    directions[np.arange(n), random.integers(0, 3, n)] = random.choice([-1, 1], n)
    return directions


# The families of rays: each is a way in which distances go wrong.

BODIES = 20
"""How many random bodies share the rays of a family."""

_MARGIN = 1.2
"""Rays are aimed at a ball about the body, by this factor wider, so that some miss."""

FamilyRays = tuple[Floats, Floats]
Maker = Callable[[Subject, Random, int, Precision], FamilyRays]


@dataclass(frozen=True)
class Trial:
    """A body and rays (n, 3), all of them floats of the measured precision."""

    body: Body
    origins: Floats
    directions: Floats


@dataclass(frozen=True)
class RayFamily:
    """How rays are made, and how large the bodies are, as powers of two from and to."""

    name: str
    about: str
    make: Maker
    scales: tuple[int, int] = (0, 0)


def near(subject: Subject, random: Random, n: int, precision: Precision) -> FamilyRays:
    directions = precision.rounded(unit(random.normal(size=(n, 3))))
    distance = subject.size * random.uniform(3, 10, (n, 1))
    return precision.rounded(_aims(subject, random, n) - distance * directions), directions


def far(subject: Subject, random: Random, n: int, precision: Precision) -> FamilyRays:
    """Drawn again until they pass near the body: in float32 most rays from afar cannot be aimed well enough."""
    origins, directions = np.empty((n, 3)), np.empty((n, 3))
    distance = subject.size * 10 ** random.uniform(2, 8, (n, 1))
    left = np.arange(n)
    while len(left):
        d = precision.rounded(unit(random.normal(size=(len(left), 3))))
        o = precision.rounded(_aims(subject, random, len(left)) - distance[left] * d)
        passing = np.linalg.norm(np.cross(o - subject.center, d), axis=1)
        good = passing < _MARGIN * subject.size * np.linalg.norm(d, axis=1)
        origins[left[good]], directions[left[good]] = o[good], d[good]
        left = left[~good]
    return origins, directions


def grazing(subject: Subject, random: Random, n: int, precision: Precision) -> FamilyRays:
    """Beside a tangent by ±2^-k sizes, k from 1 to the bits of the precision; rounding moves them a little more."""
    points, normals = subject.rim(random, n)
    tangents = random.normal(size=(n, 3))
    tangents = unit(tangents - (tangents * normals).sum(axis=1, keepdims=True) * normals)
    beside = _powers(random, n, precision) * random.choice([-1, 1], (n, 1))
    starts = points + subject.size * (beside * normals - random.uniform(2, 10, (n, 1)) * tangents)
    return precision.rounded(starts), precision.rounded(tangents)


def parallel(subject: Subject, random: Random, n: int, precision: Precision) -> FamilyRays:
    """Along axis, rulings, asymptotes or faces; one half tilted by 2^-k, k from 1 to the bits of the precision."""
    directions = subject.parallels(random, n)
    tilts = unit(random.normal(size=(n, 3))) * _powers(random, n, precision) * random.integers(0, 2, (n, 1))
    directions = precision.rounded(directions + tilts)
    distance = subject.size * random.uniform(3, 10, (n, 1))
    return precision.rounded(_aims(subject, random, n) - distance * directions), directions


def within(subject: Subject, random: Random, n: int, precision: Precision) -> FamilyRays:
    """From points inside, every way."""
    origins = np.empty((0, 3))
    while len(origins) < n:
        points = precision.rounded(_aims(subject, random, n))
        origins = np.concatenate([origins, points[inside(subject.body, points)]])
    return origins[:n], precision.rounded(unit(random.normal(size=(n, 3))))


def _aims(subject: Subject, random: Random, n: int) -> Floats:
    """Points (n, 3), uniform in the ball about the body."""
    reach = _MARGIN * subject.size * random.random((n, 1)) ** (1 / 3)
    return subject.center + reach * unit(random.normal(size=(n, 3)))


def _powers(random: Random, n: int, precision: Precision) -> Floats:
    """2^-k (n, 1)."""
    return np.ldexp(1.0, -random.integers(1, precision.bits + 1, (n, 1)))


FAMILIES = (
    RayFamily("near", "3 to 10 sizes away", near),
    RayFamily("far", "10² to 10⁸ sizes away", far),
    RayFamily("grazing", "beside a tangent or an edge by ±2^-k sizes", grazing),
    RayFamily("tiny", "sizes of 10^-12 to 10^-6", near, (-40, -20)),
    RayFamily("huge", "sizes of 10^6 to 10^12", near, (20, 40)),
    RayFamily("parallel", "along axis, ruling, asymptote or face, half of them tilted by 2^-k", parallel),
    RayFamily("inside", "from points of the body", within),
)

SHAPES: dict[str, Callable[[Random, Precision, float], Subject]] = {
    "sphere": ball, "box": block, "cylinder": cylinder, "cone": cone, "oblique": oblique, "quadric": quadric,
}  # fmt: skip


def trials(shape: str, family: RayFamily, precision: Precision, rays: int) -> list[Trial]:
    """The rays of a family at bodies of a shape: the same for every system, every time."""
    random = np.random.default_rng(crc32(f"{shape} {family.name} {precision.name}".encode()))
    made = []
    for i in range(BODIES):
        subject = SHAPES[shape](random, precision, 2.0 ** random.integers(family.scales[0], family.scales[1] + 1))
        count = rays * (i + 1) // BODIES - rays * i // BODIES
        made.append(Trial(subject.body, *family.make(subject, random, count, precision)))
    return made
