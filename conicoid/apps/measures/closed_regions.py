"""Closed forms of Boolean combinations: prisms between planes and circular cylinders, and solids of revolution.

A solid is read from the tables of a scene as its surfaces f <= 0 and a Boolean function of their sides. Walls that
coincide are one surface there, so the number of a surface identifies its side.
"""

from __future__ import annotations

import contextlib
import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from ..._util.arrays import FloatArray
from ..._util.records import dataclass
from ...geometry.body import Body
from ...geometry.bounds.support import real_roots
from ...geometry.shape import Shape
from ...kernels.tables import BALL, CELL, PLANE as PLANE_KIND, REGION, SPHERE
from ...prepare.lowering import lower
from .closed_forms import Moments
from .hull import FittedBox, moved_parts

# A solid as surfaces and a Boolean function of their sides.

MOST_SURFACES, MOST_LEAVES = 48, 96
"""Solids of more are not tried."""
SAME_TOLERANCE = 1e-12
"""Directions and coefficients are equal up to this: the rounding that motions leave, far below a visible difference."""


@dataclass(frozen=True)
class RegionPlane:
    """The half-space normal·x <= offset; the normal is unit."""

    normal: FloatArray
    offset: float


@dataclass(frozen=True)
class RegionQuadric:
    """The solid x·A x + 2 b·x + c <= 0."""

    a: FloatArray
    b: FloatArray
    c: float

    def in_frame(self, axes: FloatArray, origin: FloatArray) -> RegionQuadric:
        """Return the quadric in coordinates along the columns of `axes`, counted from `origin`."""
        slope = self.a @ origin
        c = float(origin @ slope + 2 * self.b @ origin + self.c)
        return RegionQuadric(axes.T @ self.a @ axes, axes.T @ (slope + self.b), c)


Surfaces = dict[int, "RegionPlane | RegionQuadric"]
"""Surfaces by number."""


@dataclass(frozen=True)
class SurfaceRegion:
    """A Boolean function of sides of surfaces: leaves are intersections of sides, and gates count true inputs.

    An input of a gate comes from a leaf or a later gate. Gate 0 is the root, with parent -1.
    """

    surfaces: Surfaces
    leaves: Sequence[tuple[tuple[tuple[int, bool], ...], int, bool]]  # sides (surface, is negative), gate, negated
    gates: Sequence[tuple[int, int, bool]]  # parent, need, negated

    def contains(self, inside: dict[int, bool]) -> bool:
        """Return True if the region has the points on some sides; `inside` has f <= 0 for each surface."""
        counts = [0] * len(self.gates)
        for sides, gate, negated in self.leaves:
            counts[gate] += all(inside[surface] == negative for surface, negative in sides) != negated
        value = False
        # Parents have smaller numbers: inputs are complete before a gate is evaluated
        for gate in reversed(range(len(self.gates))):
            parent, need, negated = self.gates[gate]
            value = (counts[gate] >= need) != negated
            if parent >= 0:
                counts[parent] += value
        return value


def region_of(shape: Shape, origin: FloatArray) -> SurfaceRegion | None:
    """Return the region of a solid in coordinates counted from `origin`; None for sheets and for too many parts."""
    if shape.is_sheet or _leaves(shape) > MOST_LEAVES:
        return None
    tables = lower([Body(shape)]).tables
    # A list of solids has several entries
    if len(tables.entry_kind) != 1 or len(tables.surface_kind) > MOST_SURFACES:
        return None
    surfaces = {number: _surface(tables, number, origin) for number in range(len(tables.surface_kind))}
    kind, index = int(tables.entry_kind[0]), int(tables.entry_index[0])
    if kind == BALL:
        return SurfaceRegion(surfaces, [(((index, True),), 0, False)], [(-1, 1, False)])
    if kind == CELL:
        return SurfaceRegion(surfaces, [(tuple(_sides(tables, index)), 0, False)], [(-1, 1, False)])
    assert kind == REGION
    leaves = zip(tables.leaf_cell, tables.leaf_gate, tables.leaf_negated, strict=True)
    gates = zip(tables.gate_parent, tables.gate_need, tables.gate_negated, strict=True)
    return SurfaceRegion(
        surfaces,
        [(tuple(_sides(tables, int(cell))), int(gate), bool(negated)) for cell, gate, negated in leaves],
        [(int(parent), int(need), bool(negated)) for parent, need, negated in gates],
    )


def _leaves(shape: Shape) -> int:
    """Return the number of primitives of a shape, or MOST_LEAVES + 1 if there are more."""
    return sum(1 for _ in itertools.islice(moved_parts(shape), MOST_LEAVES + 1))


def _sides(tables: Any, cell: int) -> Iterator[tuple[int, bool]]:
    """Yield the faces of a cell as (surface, does the cell have its negative side?)."""
    if tables.cell_quadric[cell] >= 0:
        yield int(tables.cell_quadric[cell]), bool(tables.cell_face[cell] > 0)
    for row in range(int(tables.cell_first[cell]), int(tables.cell_first[cell + 1])):
        yield int(tables.plane_surface[row]), bool(tables.plane_face[row] > 0)


def _surface(tables: Any, number: int, origin: FloatArray) -> RegionPlane | RegionQuadric:
    """Return a surface of the tables in coordinates counted from `origin`."""
    kind, row = int(tables.surface_kind[number]), int(tables.surface_row[number])
    if kind == PLANE_KIND:
        normal, height, anchor = np.split(tables.planes[row], [3, 4])[0], tables.planes[row][3], tables.planes[row][4:7]
        length = float(np.linalg.norm(normal))
        return RegionPlane(normal / length, (float(normal @ (anchor - origin)) - float(height)) / length)
    if kind == SPHERE:
        center, radius = tables.spheres[row][:3], float(tables.spheres[row][3])
        return RegionQuadric(np.eye(3), np.zeros(3), -radius * radius).in_frame(np.eye(3), origin - center)
    record = tables.whole_quadrics([row])[0]
    anchor, rows, squares = record[:3], record[3:12].reshape(3, 3), record[12:15]
    linear, constant = record[15:18], float(record[18])
    own = RegionQuadric(rows.T @ np.diag(squares) @ rows, rows.T @ linear, -constant)
    return own.in_frame(np.eye(3), origin - anchor)


# Closed forms of prisms: solids between planes across an axis, whose sides are planes and circular cylinders along it.
#
# Examples are pins, pipes, boxes, hexagonal cans, and their intersections with lattices. In each layer between two of
# the planes the solid is a plane figure times an interval. The moments of the figure are integrals along its boundary
# (Green's theorem). The boundary is found piece by piece: every line and circle is cut where it crosses the others, and
# a piece belongs to the boundary if the solid is on one side of it alone.

_NEAR_SIDES = 1e-9
"""Curves may coincide if one passes a place of the other at less than this share of their sizes."""
_MOST_NEAR = 4
"""Curves near a place for which all combinations of sides are tried."""
_TOUCHING = 1e-12
"""Curves that cut off less than this share of a circle's height touch it: the area cut off is below rounding."""
_TINY = 1e-14
"""A piece shorter than this share of its ends' parameters comes from rounding."""
_PRISM_NODES, _PRISM_WEIGHTS = (np.array(a) for a in np.polynomial.legendre.leggauss(16))
_POWERS = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
"""Exponents (a, b) of the integrals of x^a y^b, in order."""
LENGTH = 6
"""Place of the boundary's length among the sums of a figure, behind those of `_POWERS`."""


def middle(low: float, high: float) -> float:
    """Return a number between two numbers that may be infinite."""
    if math.isinf(low):
        return 0.0 if math.isinf(high) else high - 1 - abs(high)
    return low + 1 + abs(low) if math.isinf(high) else low / 2 + high / 2


Inside = Callable[[dict[int, bool]], bool]
"""Does a figure have the points on some sides of curves, by number?"""


class NoClosedForm(Exception):
    """The solid has no closed form of this kind."""


@dataclass(frozen=True)
class SideLine:
    """The half-plane normal·x <= offset with a unit normal, and its line."""

    normal: FloatArray
    offset: float

    @property
    def reach(self) -> float:
        """The size of its numbers, to which rounding is in proportion."""
        return abs(self.offset)

    def height(self, points: FloatArray) -> FloatArray:
        """Return the signed distances (...) of points (..., 2), positive outside."""
        return points @ self.normal - self.offset

    def at(self, t: FloatArray) -> FloatArray:
        """Return points at lengths along the line, the inside on the left."""
        along = np.array([-self.normal[1], self.normal[0]])
        return self.offset * self.normal + np.multiply.outer(t, along)

    def cuts(self, other: SideLine | SideCircle) -> Iterator[float]:
        """Yield the lengths at which the line crosses another curve."""
        along = np.array([-self.normal[1], self.normal[0]])
        if isinstance(other, SideLine):
            slope = float(along @ other.normal)
            if abs(slope) > SAME_TOLERANCE:
                yield (other.offset - self.offset * float(self.normal @ other.normal)) / slope
            return
        foot, height = float(along @ other.center), float(self.normal @ other.center) - self.offset
        square = other.radius**2 - height**2
        if square > _TOUCHING * other.radius**2:
            yield from (foot - math.sqrt(square), foot + math.sqrt(square))

    def whole(self) -> tuple[float, float]:
        """Return the range of the parameter."""
        return -math.inf, math.inf


@dataclass(frozen=True)
class SideCircle:
    """The disc |x - center| <= radius, and its circle."""

    center: FloatArray
    radius: float

    @property
    def reach(self) -> float:
        """The size of its numbers, to which rounding is in proportion."""
        return self.radius

    def height(self, points: FloatArray) -> FloatArray:
        """Return the signed distances (...) of points (..., 2), positive outside."""
        return np.linalg.norm(points - self.center, axis=-1) - self.radius

    def at(self, t: FloatArray) -> FloatArray:
        """Return points at angles, counter-clockwise."""
        return self.center + self.radius * np.stack([np.cos(t), np.sin(t)], axis=-1)

    def cuts(self, other: SideLine | SideCircle) -> Iterator[float]:
        """Yield the angles at which the circle crosses another curve."""
        if isinstance(other, SideLine):
            cosine = (other.offset - float(other.normal @ self.center)) / self.radius
            middle = math.atan2(other.normal[1], other.normal[0])
        else:
            way = other.center - self.center
            distance = float(np.linalg.norm(way))
            if distance == 0:
                return
            cosine = (distance**2 + self.radius**2 - other.radius**2) / (2 * distance * self.radius)
            middle = math.atan2(way[1], way[0])
        if abs(cosine) < 1 - _TOUCHING:
            yield from (middle - math.acos(cosine), middle + math.acos(cosine))

    def whole(self) -> tuple[float, float]:
        """Return the range of the parameter."""
        return 0.0, 2 * math.pi


def prism_sums(region: SurfaceRegion, axes: FloatArray) -> tuple[FloatArray, float]:
    """Return the integrals (10,) of 1, x, y, z, xx, xy, xz, yy, yz, zz along `axes`, and the area of the boundary.

    Raise NoClosedForm if the region is not a bounded prism along the last axis.
    """
    caps: dict[int, float] = {}  # heights of planes across the axis
    flipped: set[int] = set()  # such planes with f <= 0 above them
    curves: dict[int, SideLine | SideCircle] = {}
    outer: set[int] = set()  # circles whose outside is f <= 0
    for number, surface in region.surfaces.items():
        if isinstance(surface, RegionPlane):
            x, y, z = surface.normal @ axes
            if math.hypot(x, y) <= SAME_TOLERANCE:
                caps[number] = surface.offset / z
                flipped |= {number} if z < 0 else set()
            elif abs(z) <= SAME_TOLERANCE:
                curves[number] = SideLine(np.array([x, y]) / math.hypot(x, y), surface.offset / math.hypot(x, y))
            else:
                raise NoClosedForm
        else:
            own = surface.in_frame(axes, np.zeros(3))
            size = own.a[0, 0]
            if size == 0 or np.abs(own.a - size * np.diag([1, 1, 0])).max() > SAME_TOLERANCE * abs(size):
                raise NoClosedForm
            center, scale = -own.b[:2] / size, float(np.linalg.norm(own.b[:2] / size)) + math.sqrt(abs(own.c / size))
            square = float(center @ center) - own.c / size
            if square <= 0 or abs(own.b[2] / size) > SAME_TOLERANCE * scale:
                raise NoClosedForm
            curves[number] = SideCircle(center, math.sqrt(square))
            outer |= {number} if size < 0 else set()
    return _prism_layers(region, caps, flipped, curves, outer)


def _prism_layers(
    region: SurfaceRegion,
    caps: dict[int, float],
    flipped: set[int],
    curves: dict[int, SideLine | SideCircle],
    outer: set[int],
) -> tuple[FloatArray, float]:
    """Return the integrals of all layers, and the area: sides of layers, and differences of figures between layers."""
    heights, pieces = sorted(set(caps.values())), _pieces_between(curves)

    def inside(z: float) -> Inside:
        """Return the figure at a height; curves count as insides of lines and circles, whatever the sign of f."""
        sides = {number: (z <= height) != (number in flipped) for number, height in caps.items()}
        return lambda turned: region.contains(sides | {n: value != (n in outer) for n, value in turned.items()})

    ends = [-math.inf, *heights, math.inf]
    figures = [inside(middle(a, b)) for a, b in itertools.pairwise(ends)]
    sums = [_figure(curves, pieces, figure) for figure in figures]
    if any(sums[0]) or any(sums[-1]):
        raise NoClosedForm  # without end along the axis
    total, area = np.zeros(10), 0.0
    for (low, high), layer in zip(itertools.pairwise(heights), sums[1:-1], strict=True):
        one, first, second = (((high**k - low**k) / k) for k in (1, 2, 3))
        a, x, y, xx, xy, yy = layer[:LENGTH]
        total += [a * one, x * one, y * one, a * first, xx * one, xy * one, x * first, yy * one, y * first, a * second]
        area += layer[LENGTH] * one
    for below, above in itertools.pairwise(figures):
        step: Inside = lambda turned, a=below, b=above: a(turned) != b(turned)  # type: ignore[misc]  # noqa: E731
        area += _figure(curves, pieces, step)[0]
    return total, float(area)


@dataclass(frozen=True)
class SidePiece:
    """A piece of a curve between its crossings with others, and the sides of all curves at a place on it.

    Curves that are `near` may pass the place so closely that their sides are uncertain.
    """

    number: int
    curve: SideLine | SideCircle
    ends: tuple[float, float]
    sides: dict[int, bool]
    near: list[int]

    @cached_property
    def sums(self) -> FloatArray:
        """The integrals along the piece with the figure on its left, and its length, (7,)."""
        return _along(self.curve, *self.ends)


def _pieces_between(curves: dict[int, SideLine | SideCircle]) -> list[SidePiece]:
    """Return all pieces of curves, which the figures at all heights share."""
    return [_piece(number, ends, curves) for number in curves for ends in _pieces(number, curves)]


def _piece(number: int, ends: tuple[float, float], curves: dict[int, SideLine | SideCircle]) -> SidePiece:
    """Return a piece of a curve, by the place on it that the fewest other curves come near to."""
    sides, near = _sides_on(number, _places(*ends)[0], curves)
    for t in _places(*ends)[1:] if near else ():
        others = _sides_on(number, t, curves)
        if len(others[1]) < len(near):
            sides, near = others
    if len(near) > _MOST_NEAR:
        raise NoClosedForm
    return SidePiece(number, curves[number], ends, sides, near)


def _figure(curves: dict[int, SideLine | SideCircle], pieces: list[SidePiece], inside: Inside) -> FloatArray:
    """Return the integrals of x^a y^b over a plane figure, and the length of its boundary, (7,)."""
    total = np.zeros(7)
    for piece in pieces:
        sense = _sense(piece, inside)
        if sense:
            if not np.isfinite(piece.ends).all():
                raise NoClosedForm  # without end across the axis
            total += piece.sums * np.array([*[sense] * LENGTH, 1])
    if not total[LENGTH] and inside(_sides_at(np.zeros(2), curves)):
        raise NoClosedForm  # all of the plane
    return total


def _pieces(number: int, curves: dict[int, SideLine | SideCircle]) -> Iterator[tuple[float, float]]:
    """Yield the pieces (begin, end) of a curve between its crossings with others."""
    curve = curves[number]
    first, last = curve.whole()
    cuts = [t for other, neighbour in curves.items() if other != number for t in curve.cuts(neighbour)]
    if isinstance(curve, SideCircle) and cuts:
        cuts = sorted(t % (2 * math.pi) for t in cuts)
        first, last = cuts[0], cuts[0] + 2 * math.pi
        cuts = cuts[1:]
    for begin, end in itertools.pairwise([first, *sorted(cuts), last]):
        if end - begin > _TINY * max(abs(begin), abs(end), 1e-300) or math.isinf(end - begin):
            yield begin, end  # tiny pieces come from rounding where several curves meet in a point


def _sense(piece: SidePiece, inside: Inside) -> int:
    """Return 1 if the figure lies on a curve's inside alone along a piece, -1 if on its outside alone, 0 otherwise.

    All combinations of the uncertain sides must agree.
    """
    found = set()
    for values in itertools.product((False, True), repeat=len(piece.near)):
        sides = piece.sides | dict(zip(piece.near, values, strict=True))
        found.add(int(inside(sides | {piece.number: True})) - int(inside(sides | {piece.number: False})))
    if len(found) > 1:
        raise NoClosedForm  # another curve nearly coincides with this one
    return found.pop()


def _places(begin: float, end: float) -> list[float]:
    """Return places to test along a piece: several, as another curve may touch it in one of them."""
    if math.isinf(begin) or math.isinf(end):
        return [middle(begin, end), 3.7 * middle(begin, end)]
    return [begin + share * (end - begin) for share in (0.5, 0.37, 0.71)]


def _sides_on(
    number: int, t: float, curves: dict[int, SideLine | SideCircle]
) -> tuple[dict[int, bool], list[int]]:  # fmt: skip
    """Return the sides of all curves at a point of one of them, and the others that pass through it or near it."""
    point = curves[number].at(np.array(t))
    reach, heights = float(np.abs(point).max()), {n: float(curve.height(point)) for n, curve in curves.items()}
    near = [
        n for n, height in heights.items() if n != number and abs(height) <= _NEAR_SIDES * max(reach, curves[n].reach)
    ]
    return {n: height <= 0 for n, height in heights.items()}, near


def _sides_at(point: FloatArray, curves: dict[int, SideLine | SideCircle]) -> dict[int, bool]:
    """Return for each curve whether a point is inside."""
    return {number: bool(curve.height(point) <= 0) for number, curve in curves.items()}


def _along(curve: SideLine | SideCircle, begin: float, end: float) -> FloatArray:
    """Return ∮ x^(a+1)/(a+1) y^b dy along a piece with the figure on its left, and its length, (7,).

    Gauss's rule is exact for lines, and nearly so for arcs of at most 45 degrees.
    """
    parts = max(1, math.ceil((end - begin) / (math.pi / 4))) if isinstance(curve, SideCircle) else 1
    cuts = np.linspace(begin, end, parts + 1)
    half = np.diff(cuts) / 2
    t = ((cuts[:-1] + half)[:, None] + half[:, None] * _PRISM_NODES).ravel()
    weight = (half[:, None] * _PRISM_WEIGHTS).ravel()
    x, y = curve.at(t).T
    if isinstance(curve, SideCircle):
        slope, speed = curve.radius * np.cos(t), curve.radius
    else:
        slope, speed = np.full(len(t), curve.normal[0]), 1.0
    sums = [float((x ** (a + 1) * y**b * slope) @ weight) / (a + 1) for a, b in _POWERS]
    return np.array([*sums, speed * (end - begin)])


# Closed forms of solids of revolution: planes across an axis, and quadrics of revolution about it.
#
# Examples are shells, caps, capped cylinders and cones, coated particles, tanks. At each height z every quadric is a
# circle r² = g(z), g a polynomial of second degree. Between the heights where circles meet or vanish, or planes lie,
# the same circles bound the solid, and all integrals are those of polynomials, for which Gauss's rule is exact.

_PROFILE_NODES, _PROFILE_WEIGHTS = (np.array(a) for a in np.polynomial.legendre.leggauss(5))
_NEAR_CIRCLES = 1e-9
"""Circles may coincide if their r² differ by at most this share of the largest."""


@dataclass(frozen=True)
class Profile:
    """The solid r² <= g(z) = g0 + g1 z + g2 z²; `outer` if f <= 0 is its outside."""

    g: tuple[float, float, float]
    outer: bool

    def at(self, z: FloatArray) -> FloatArray:
        """Return g at heights."""
        g0, g1, g2 = self.g
        return g0 + z * (g1 + z * g2)

    @property
    def square(self) -> bool:
        """Whether 4 g + g'² is the square of a linear function, as for cylinders, spheres and cones."""
        g0, g1, g2 = self.g
        a, b, c = 4 * g2 + 4 * g2 * g2, 4 * g1 + 4 * g1 * g2, 4 * g0 + g1 * g1
        return abs(b * b - 4 * a * c) <= 1e-10 * max(b * b, abs(4 * a * c), c * c * 1e-4) and (a, b, c) != (0, 0, 0)

    def speed(self, z: FloatArray) -> FloatArray:
        """Return √(4 g + g'²): the area of the surface for a unit of z, over π."""
        _, g1, g2 = self.g
        return np.sqrt(np.maximum(4 * self.at(z) + (g1 + 2 * g2 * z) ** 2, 0.0))


def revolved_sums(region: SurfaceRegion, axes: FloatArray, origin: FloatArray) -> tuple[FloatArray, float | None]:
    """Return the integrals (10,) of 1, x, y, z, xx, xy, xz, yy, yz, zz from `origin` along `axes`, and the area.

    The last axis is that of revolution. The area is None if it has no closed form. Raise NoClosedForm if the region is
    not a bounded solid of revolution about the axis.
    """
    caps: dict[int, tuple[float, bool]] = {}  # (height, is f <= 0 above?)
    profiles: dict[int, Profile] = {}
    for number, surface in region.surfaces.items():
        if isinstance(surface, RegionPlane):
            x, y, z = surface.normal @ axes
            if math.hypot(x, y) > SAME_TOLERANCE:
                raise NoClosedForm
            caps[number] = (surface.offset - float(surface.normal @ origin)) / z, z < 0
        else:
            profiles[number] = _profile(surface.in_frame(axes, origin))
    return _layer_sums(region, caps, profiles)


def _profile(own: RegionQuadric) -> Profile:
    """Return a quadric as a profile about the last axis; raise NoClosedForm for others."""
    size = own.a[0, 0]
    if size == 0:
        raise NoClosedForm
    a, b, c = own.a / size, own.b / size, own.c / size
    scale = math.sqrt(abs(c)) + abs(float(b[2]))
    off = np.abs(a - np.diag([1, 1, a[2, 2]])).max()
    if off > SAME_TOLERANCE * max(1.0, abs(a[2, 2])) or np.abs(b[:2]).max() > SAME_TOLERANCE * scale:
        raise NoClosedForm
    return Profile((-float(c), -2 * float(b[2]), -float(a[2, 2])), bool(size < 0))


def _layer_sums(
    region: SurfaceRegion, caps: dict[int, tuple[float, bool]], profiles: dict[int, Profile]
) -> tuple[FloatArray, float | None]:
    """Return the integrals of all layers, and the area: circles swept along z, and rings between layers."""
    # Heights of planes, and those where circles vanish or two of them meet
    heights = {height for height, _ in caps.values()}
    for profile in profiles.values():
        heights |= set(real_roots(profile.g[2], profile.g[1], profile.g[0]))
    for first, second in itertools.combinations(profiles.values(), 2):
        d0, d1, d2 = (a - b for a, b in zip(first.g, second.g, strict=True))
        if d0 or d1 or d2:
            heights |= set(real_roots(d2, d1, d0))
    cuts = sorted(height for height in heights if math.isfinite(height))
    ends = [-math.inf, *cuts, math.inf]
    total, area, has_area = np.zeros(10), 0.0, True
    rings: list[tuple[float, list[tuple[int, int]]]] = []
    for low, high in itertools.pairwise(ends):
        if low == high:
            continue
        circles = _circles(region, caps, profiles, middle(low, high))
        rings.append((low, circles))
        if not circles:
            continue
        if math.isinf(low) or math.isinf(high):
            raise NoClosedForm
        half = (high - low) / 2
        z, weight = low + half + half * _PROFILE_NODES, half * _PROFILE_WEIGHTS
        for number, sense in circles:
            g = np.maximum(profiles[number].at(z), 0.0)
            one, across = math.pi * sense * g * weight, math.pi / 4 * sense * g**2 * weight
            total += np.array([one.sum(), 0, 0, one @ z, across.sum(), 0, 0, across.sum(), 0, one @ z**2])
            has_area = has_area and profiles[number].square
            area += math.pi * float(profiles[number].speed(z) @ weight)
    for (_, below), (height, above) in itertools.pairwise(rings):
        area += _ring_area(profiles, height, below, above)
    return total, area if has_area else None


def _circles(
    region: SurfaceRegion, caps: dict[int, tuple[float, bool]], profiles: dict[int, Profile], z: float
) -> list[tuple[int, int]]:
    """Return the circles that bound the solid at a height: (number, 1 if it is inside of the circle, else -1)."""
    sides = {number: (z <= height) != turned for number, (height, turned) in caps.items()}
    squares = {number: float(profile.at(np.array(z))) for number, profile in profiles.items()}
    order = sorted(profiles, key=lambda number: squares[number])
    size = max([abs(square) for square in squares.values()], default=0.0)
    # From the axis outward
    sides |= {number: (squares[number] > 0) != profiles[number].outer for number in order}
    circles = []
    before = region.contains(sides)
    for place, number in enumerate(order):
        if squares[number] <= 0:
            continue
        later = order[place + 1] if place + 1 < len(order) else None
        sides = sides | {number: profiles[number].outer}
        after = region.contains(sides)
        if later is not None and squares[later] - squares[number] <= _NEAR_CIRCLES * size and len({before, after}) > 1:
            raise NoClosedForm  # circles that nearly coincide
        if before != after:
            circles.append((number, 1 if before else -1))
        before = after
    if before:
        raise NoClosedForm  # without end across the axis
    return circles


def _ring_area(
    profiles: dict[int, Profile], height: float, below: list[tuple[int, int]], above: list[tuple[int, int]]
) -> float:
    """Return the area of the figure that is solid on one side of a height alone."""
    ends: list[tuple[float, int]] = []
    for part, circles in enumerate((below, above)):
        for number, _ in circles:
            ends.append((max(float(profiles[number].at(np.array(height))), 0.0), part))
    inside = [bool(circles) and circles[0][1] > 0 for circles in (below, above)]
    area, last = 0.0, 0.0
    for square, part in sorted(ends):
        area += math.pi * (square - last) if inside[0] != inside[1] else 0.0
        inside[part], last = not inside[part], square
    return area


# A shape as a prism or a solid of revolution.

_MOST_AXES = 6
"""Axes that are tried."""


def closed_region(shape: Shape, box: FittedBox) -> tuple[Moments, float | None] | None:
    """Return the moments of a solid in the world, and its area or None; None if its surfaces allow no closed form."""
    region = region_of(shape, box.center)
    if region is None:
        return None
    for axis, origin in _axes(region):
        axes = _frame(axis)
        with contextlib.suppress(NoClosedForm):
            sums, area = prism_sums(region, axes)
            return _moments(sums, axes, box.center), area
        with contextlib.suppress(NoClosedForm):
            sums, some_area = revolved_sums(region, axes, origin)
            return _moments(sums, axes, box.center + origin), some_area
    return None


def _axes(region: SurfaceRegion) -> list[tuple[FloatArray, FloatArray]]:
    """Return possible axes of a prism or of a solid of revolution, each with a point on it.

    They are axes of quadrics, lines between centers, and normals of planes; z without any of these.
    """
    candidates: list[tuple[FloatArray, FloatArray]] = []

    def add(axis: FloatArray, origin: FloatArray) -> None:
        """Add an axis unless it is parallel to a known one, or there are enough."""
        if (
            all(np.linalg.norm(np.cross(axis, other)) > SAME_TOLERANCE for other, _ in candidates)
            and len(candidates) < _MOST_AXES
        ):
            candidates.append((axis, origin))

    quadrics = [surface for surface in region.surfaces.values() if isinstance(surface, RegionQuadric)]
    centers = [center for quadric in quadrics if (center := _center(quadric)) is not None]
    origin = centers[0] if centers else np.zeros(3)
    for quadric in quadrics:
        axis = _axis(quadric)
        if axis is not None:
            center = _center(quadric)
            add(axis, origin if center is None else center)
    for center in centers[1:]:
        way = center - origin
        if np.linalg.norm(way) > SAME_TOLERANCE * (1 + np.abs(origin).max()):
            add(way / np.linalg.norm(way), origin)
    for surface in region.surfaces.values():
        if isinstance(surface, RegionPlane):
            add(surface.normal, origin)
    if not candidates:
        add(np.array([0.0, 0.0, 1.0]), origin)
    return candidates


def _axis(quadric: RegionQuadric) -> FloatArray | None:
    """Return the direction of the axis of a quadric of revolution; None for spheres and other quadrics."""
    squares, axes = np.linalg.eigh(quadric.a)
    size = np.abs(squares).max()
    for k in range(3):
        one, other = np.delete(squares, k)
        if abs(one - other) <= 1e-9 * size < abs(squares[k] - one):
            axis: Any = axes[:, k]
            nearest = np.round(axis)
            return nearest if np.abs(axis - nearest).max() < SAME_TOLERANCE else axis
    return None


def _center(quadric: RegionQuadric) -> FloatArray | None:
    """Return the center, or a point of the axis if there are many; None if there is none, as for paraboloids."""
    center: Any = np.linalg.lstsq(quadric.a, -quadric.b, rcond=1e-9)[0]
    rest = np.abs(quadric.a @ center + quadric.b).max()
    result: FloatArray = center
    return result if rest <= SAME_TOLERANCE * max(np.abs(quadric.b).max(), 1e-300) or not quadric.b.any() else None


def _frame(axis: FloatArray) -> FloatArray:
    """Return orthonormal columns (3, 3), the last along an axis; all are axes of the world if that one is."""
    across = np.eye(3)[int(np.argmin(np.abs(axis)))]
    first = np.cross(across, axis)
    first = first / np.linalg.norm(first)
    return np.column_stack([first, np.cross(axis, first), axis])


def _moments(sums: FloatArray, axes: FloatArray, origin: FloatArray) -> Moments:
    """Return the moments from integrals of 1, x, y, z, xx, xy, xz, yy, yz, zz along axes from an origin."""
    volume = float(sums[0])
    if volume <= 0:
        return Moments(0.0, np.full(3, np.nan), np.zeros((3, 3)))
    mean = sums[1:4] / volume
    xx, xy, xz, yy, yz, zz = sums[4:] / volume
    spread = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) - np.outer(mean, mean)
    spread_in_world = axes @ spread @ axes.T
    return Moments(volume, origin + axes @ mean, (spread_in_world + spread_in_world.T) / 2)
