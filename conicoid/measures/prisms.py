"""Closed forms of prisms: solids between planes across an axis, whose sides are planes and circular cylinders along it.

Pins, pipes, boxes, hexagonal cans, and what lattices cut from them. In each layer between two of the planes the solid
is a plane figure times an interval. The figure's moments are integrals along its boundary (Green), which is found piece
by piece: every line and circle is cut where it meets the others, and a piece belongs to the boundary if the solid is on
one side of it only.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from ..shapes.vector import FloatArray
from .surfaces import ALIKE, Plane, Region

_NEAR = 1e-9
"""Curves that pass so near the middle of a piece of another, in units of its distance from 0 and 1, may be the same."""
_MOST_NEAR = 4
_TOUCHING = 1e-12
"""Curves that cut off less than this of a circle's height touch it: the area cut off is below all rounding."""
_TINY = 1e-14
_NODES, _WEIGHTS = (np.array(a) for a in np.polynomial.legendre.leggauss(16))
_POWERS = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
LENGTH = 6
"""Place of the boundary's length among the sums of a figure; before it are those of x^a y^b by `_POWERS`."""


def middle(low: float, high: float) -> float:
    """A number between two, either of which may be infinite."""
    if math.isinf(low):
        return 0.0 if math.isinf(high) else high - 1 - abs(high)
    return low + 1 + abs(low) if math.isinf(high) else low / 2 + high / 2


Inside = Callable[[dict[int, bool]], bool]


class Unknown(Exception):
    """There is no closed form here."""


@dataclass(frozen=True)
class Line:
    """normal·x <= offset, a unit normal."""

    normal: FloatArray
    offset: float

    def height(self, points: FloatArray) -> FloatArray:
        """How far outside points (..., 2) are."""
        result: FloatArray = points @ self.normal - self.offset
        return result

    def at(self, t: FloatArray) -> FloatArray:
        """Points by the length along the line, the inside on the left."""
        along = np.array([-self.normal[1], self.normal[0]])
        result: FloatArray = self.offset * self.normal + np.multiply.outer(t, along)
        return result

    def cuts(self, other: Line | Circle) -> Iterator[float]:
        """Where it meets another curve."""
        along = np.array([-self.normal[1], self.normal[0]])
        if isinstance(other, Line):
            slope = float(along @ other.normal)
            if abs(slope) > ALIKE:
                yield (other.offset - self.offset * float(self.normal @ other.normal)) / slope
            return
        foot, height = float(along @ other.center), float(self.normal @ other.center) - self.offset
        square = other.radius**2 - height**2
        if square > _TOUCHING * other.radius**2:
            yield from (foot - math.sqrt(square), foot + math.sqrt(square))

    def whole(self) -> tuple[float, float]:
        return -math.inf, math.inf


@dataclass(frozen=True)
class Circle:
    """|x - center| <= radius."""

    center: FloatArray
    radius: float

    def height(self, points: FloatArray) -> FloatArray:
        result: FloatArray = np.linalg.norm(points - self.center, axis=-1) - self.radius
        return result

    def at(self, t: FloatArray) -> FloatArray:
        """Points by the angle, counter-clockwise."""
        result: FloatArray = self.center + self.radius * np.stack([np.cos(t), np.sin(t)], axis=-1)
        return result

    def cuts(self, other: Line | Circle) -> Iterator[float]:
        """The angles at which it meets another curve."""
        if isinstance(other, Line):
            cosine = (other.offset - float(other.normal @ self.center)) / self.radius
            middle = math.atan2(other.normal[1], other.normal[0])
        else:
            way = other.center - self.center
            apart = float(np.linalg.norm(way))
            if apart == 0:
                return
            cosine = (apart**2 + self.radius**2 - other.radius**2) / (2 * apart * self.radius)
            middle = math.atan2(way[1], way[0])
        if abs(cosine) < 1 - _TOUCHING:
            yield from (middle - math.acos(cosine), middle + math.acos(cosine))

    def whole(self) -> tuple[float, float]:
        return 0.0, 2 * math.pi


def prism_sums(region: Region, axes: FloatArray) -> tuple[FloatArray, float]:
    """Integrals of 1, x, y, z, xx, xy, xz, yy, yz, zz along `axes`, (10,), and the area of the boundary.

    Raises Unknown for what is no bounded prism along the last axis.
    """
    caps: dict[int, float] = {}
    flipped: set[int] = set()
    curves: dict[int, Line | Circle] = {}
    outer: set[int] = set()  # circles whose outside is f <= 0
    for number, surface in region.surfaces.items():
        if isinstance(surface, Plane):
            x, y, z = surface.normal @ axes
            if math.hypot(x, y) <= ALIKE:
                caps[number] = surface.offset / z
                flipped |= {number} if z < 0 else set()
            elif abs(z) <= ALIKE:
                curves[number] = Line(np.array([x, y]) / math.hypot(x, y), surface.offset / math.hypot(x, y))
            else:
                raise Unknown
        else:
            own = surface.within(axes, np.zeros(3))
            size = own.a[0, 0]
            if size == 0 or np.abs(own.a - size * np.diag([1, 1, 0])).max() > ALIKE * abs(size):
                raise Unknown
            center, scale = -own.b[:2] / size, float(np.linalg.norm(own.b[:2] / size)) + math.sqrt(abs(own.c / size))
            square = float(center @ center) - own.c / size
            if square <= 0 or abs(own.b[2] / size) > ALIKE * scale:
                raise Unknown
            curves[number] = Circle(center, math.sqrt(square))
            outer |= {number} if size < 0 else set()
    return _layers(region, caps, flipped, curves, outer)


def _layers(
    region: Region, caps: dict[int, float], flipped: set[int], curves: dict[int, Line | Circle], outer: set[int]
) -> tuple[FloatArray, float]:
    """The sums of all layers from bottom to top, and the area: sides of layers, and what differs between them."""
    heights = sorted(set(caps.values()))

    def inside(z: float) -> Inside:
        sides = {number: (z <= height) != (number in flipped) for number, height in caps.items()}
        return lambda turned: region.contains(sides | {n: value != (n in outer) for n, value in turned.items()})

    ends = [-math.inf, *heights, math.inf]
    figures = [inside(middle(a, b)) for a, b in itertools.pairwise(ends)]
    sums = [_figure(curves, figure) for figure in figures]
    if any(sums[0]) or any(sums[-1]):
        raise Unknown  # without end along the axis
    total, area = np.zeros(10), 0.0
    for (low, high), layer in zip(itertools.pairwise(heights), sums[1:-1], strict=True):
        one, first, second = (((high**k - low**k) / k) for k in (1, 2, 3))
        a, x, y, xx, xy, yy = layer[:LENGTH]
        total += [a * one, x * one, y * one, a * first, xx * one, xy * one, x * first, yy * one, y * first, a * second]
        area += layer[LENGTH] * one
    for below, above in itertools.pairwise(figures):
        area += _figure(curves, lambda turned, a=below, b=above: a(turned) != b(turned))[0]  # type: ignore[misc]
    return total, float(area)


def _figure(curves: dict[int, Line | Circle], inside: Inside) -> FloatArray:
    """Integrals of x^a y^b over a plane figure, and the length of its boundary, (7,)."""
    total = np.zeros(7)
    for number, curve in curves.items():
        for begin, end in _pieces(number, curves):
            sense = _sense(number, (begin, end), curves, inside)
            if sense:
                if math.isinf(begin) or math.isinf(end):
                    raise Unknown  # without end across the axis
                total += _along(curve, begin, end) * np.array([*[sense] * LENGTH, 1])
    if not total[LENGTH] and inside(_sides_at(np.zeros(2), curves)):
        raise Unknown  # all of the plane
    return total


def _pieces(number: int, curves: dict[int, Line | Circle]) -> Iterator[tuple[float, float]]:
    curve = curves[number]
    first, last = curve.whole()
    cuts = [t for other, met in curves.items() if other != number for t in curve.cuts(met)]
    if isinstance(curve, Circle) and cuts:
        cuts = sorted(t % (2 * math.pi) for t in cuts)
        first, last = cuts[0], cuts[0] + 2 * math.pi
        cuts = cuts[1:]
    for begin, end in itertools.pairwise([first, *sorted(cuts), last]):
        if end - begin > _TINY * max(abs(begin), abs(end), 1e-300) or math.isinf(end - begin):
            yield begin, end  # where several curves meet in a point, rounding leaves pieces that are none


def _sense(number: int, ends: tuple[float, float], curves: dict[int, Line | Circle], inside: Inside) -> int:
    """1 where the figure lies on a curve's inside only, along a piece of it; -1 on its outside only; 0 both or none."""
    point, near = min((_seen(number, t, curves) for t in _places(*ends)), key=lambda seen: len(seen[1]))
    if len(near) > _MOST_NEAR:
        raise Unknown
    sides = _sides_at(point, curves)
    found = set()
    for values in itertools.product((False, True), repeat=len(near)):
        sides |= dict(zip(near, values, strict=True))
        found.add(int(inside(sides | {number: True})) - int(inside(sides | {number: False})))
    if len(found) > 1:
        raise Unknown  # another curve is all but the same
    return found.pop()


def _places(begin: float, end: float) -> list[float]:
    """Where to look along a piece: another curve may touch it in one of the places."""
    if math.isinf(begin) or math.isinf(end):
        return [middle(begin, end), 3.7 * middle(begin, end)]
    return [begin + share * (end - begin) for share in (0.5, 0.37, 0.71)]


def _seen(number: int, t: float, curves: dict[int, Line | Circle]) -> tuple[FloatArray, list[int]]:
    """A place on a curve, and which others are there, or all but there."""
    point = curves[number].at(np.array(t))
    return point, [n for n, curve in curves.items() if n != number and _is_near(curve, point)]


def _is_near(curve: Line | Circle, point: FloatArray) -> bool:
    size = max(float(np.abs(point).max()), curve.radius if isinstance(curve, Circle) else abs(curve.offset))
    return abs(float(curve.height(point))) <= _NEAR * size


def _sides_at(point: FloatArray, curves: dict[int, Line | Circle]) -> dict[int, bool]:
    return {number: bool(curve.height(point) <= 0) for number, curve in curves.items()}


def _along(curve: Line | Circle, begin: float, end: float) -> FloatArray:
    """∮ x^(a+1)/(a+1) y^b dy along a piece, the figure on the left, and its length. Gauss's rule: exact, or nearly."""
    parts = max(1, math.ceil((end - begin) / (math.pi / 4))) if isinstance(curve, Circle) else 1
    cuts = np.linspace(begin, end, parts + 1)
    half = np.diff(cuts) / 2
    t = ((cuts[:-1] + half)[:, None] + half[:, None] * _NODES).ravel()
    weight = (half[:, None] * _WEIGHTS).ravel()
    x, y = curve.at(t).T
    if isinstance(curve, Circle):
        slope, speed = curve.radius * np.cos(t), curve.radius
    else:
        slope, speed = np.full(len(t), curve.normal[0]), 1.0
    sums = [float((x ** (a + 1) * y**b * slope) @ weight) / (a + 1) for a, b in _POWERS]
    return np.array([*sums, speed * (end - begin)])
