"""The section of a body with the plane x = 0 as paths of SVG, z to the right and y up.

Spheres, ellipsoids and paraboloids are exact: SVG has elliptic arcs and parabolas. Hyperbolas, which it does not have,
are drawn by pieces of cubics that are within a millionth of their width.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence
from typing import Any, TypeAlias

import numpy as np

from ..shapes.base import Shape
from ..shapes.conic import Conic, ConicSheet
from ..shapes.conic_wall import ConicWall
from ..shapes.lens import Lens, Mirror
from ..shapes.prism import FlatGlass
from ..shapes.sphere import Sphere
from ..shapes.stop import Stop

Point: TypeAlias = tuple[float, float]
"""(z, y)"""

_CLOSE = 1e-6
_MOST_PIECES = 512


def outline(shape: Shape) -> str | None:
    """The path of a section in the shape's own frame; None where it is not one of those that are known here."""
    if isinstance(shape, Lens):
        return _closed(_down(shape.front), _up(shape.back))
    if isinstance(shape, Mirror):
        return _mirror(shape)
    if isinstance(shape, Conic):
        return _closed(_down(shape.wall), "")
    if isinstance(shape, ConicSheet):
        return _sheet(shape.wall, shape.hole / 2)
    if isinstance(shape, Stop):
        inner, outer = shape.aperture / 2, shape.diameter / 2
        return " ".join(f"{_move((0.0, sign * outer))} {_line((0.0, sign * inner))}" for sign in (1, -1))
    if isinstance(shape, Sphere):
        r = shape.radius
        return f"{_move((-r, 0.0))} {_arc(r, r, 1, (r, 0.0))} {_arc(r, r, 1, (-r, 0.0))} Z"
    if isinstance(shape, FlatGlass):
        return _polygon(shape)
    return None


def placed(shape: Shape) -> str | None:
    """The attribute that puts the own frame where it is; None where the plane x = 0 is not carried to itself."""
    m = np.asarray(shape.under().matrix)
    if np.any(m[0, 1:] != 0) or np.any(m[1:, 0] != 0):
        return None
    if np.array_equal(m, np.eye(4)):
        return ""
    numbers = (m[2, 2], -m[1, 2], -m[2, 1], m[1, 1], m[2, 3], -m[1, 3])
    return f' transform="matrix({" ".join(written(float(x)) for x in numbers)})"'


def written(value: float) -> str:
    """A number as SVG has it."""
    return f"{value + 0.0:.12g}"


def _move(point: Point) -> str:
    return f"M {_at(point)}"


def _line(point: Point) -> str:
    return f"L {_at(point)}"


def _at(point: Point) -> str:
    return f"{written(point[0])} {written(-point[1])}"


def _arc(rx: float, ry: float, sweep: int, end: Point) -> str:
    return f"A {written(rx)} {written(ry)} 0 0 {sweep} {_at(end)}"


def _closed(*parts: str) -> str:
    return "M " + " ".join(part for part in parts if part).removeprefix("L ").removeprefix("M ") + " Z"


def _down(wall: ConicWall) -> str:
    """From the upper edge over the vertex to the lower edge."""
    return _across(wall, wall.edge, wall.semi, -wall.semi, -wall.edge)


def _up(wall: ConicWall) -> str:
    return _across(wall, -wall.edge, -wall.semi, wall.semi, wall.edge)


def _across(wall: ConicWall, first: float, start: float, end: float, last: float) -> str:
    """Flat from `first` to `start`, along the conic to `end`, and flat again."""
    rim = _height(wall, abs(start))
    flat = [_line((rim, first)), _line((rim, start))] if abs(first) > abs(start) else [_line((rim, start))]
    tail = [_line((rim, last))] if abs(last) > abs(end) else []
    return " ".join([*flat, curve(wall, start, end), *tail])


def _height(wall: ConicWall, y: float) -> float:
    return float(wall.vertex) + float(wall.sag(abs(y)))


def curve(wall: ConicWall, start: float, end: float) -> str:
    """Along a conic, from the height `start` to `end`; the pen is at its start."""
    target = (_height(wall, end), end)
    if wall.is_plane:
        return _line(target)
    radius, steep = wall.radius, 1 + wall.conic
    if steep > 0:
        sweep = int((radius < 0) == (end < start))
        return _arc(abs(radius) / steep, abs(radius) / math.sqrt(steep), sweep, target)
    if steep == 0:  # tangents at y and y' meet at z = y y' / (2 R)
        corner = (float(wall.vertex) + start * end / (2 * radius), (start + end) / 2)
        return f"Q {_at(corner)} {_at(target)}"
    return _hyperbola(wall, start, end)


def _hyperbola(wall: ConicWall, start: float, end: float) -> str:
    """Cubics with the hyperbola's own tangents."""
    pieces = 2
    while pieces < _MOST_PIECES and _error(wall, start, end, pieces) > _CLOSE * abs(end - start):
        pieces *= 2
    heights = np.linspace(start, end, pieces + 1).tolist()
    return " ".join(_cubic(wall, a, b) for a, b in itertools.pairwise(heights))


def _slope(wall: ConicWall, y: float) -> float:
    return y / (wall.radius * math.sqrt(1 - (1 + wall.conic) * (y / wall.radius) ** 2))


def _controls(wall: ConicWall, a: float, b: float) -> Sequence[Point]:
    third = (b - a) / 3
    return (_height(wall, a) + third * _slope(wall, a), a + third), (
        _height(wall, b) - third * _slope(wall, b),
        b - third,
    )


def _cubic(wall: ConicWall, a: float, b: float) -> str:
    first, second = _controls(wall, a, b)
    return f"C {_at(first)} {_at(second)} {_at((_height(wall, b), b))}"


def _error(wall: ConicWall, start: float, end: float, pieces: int) -> float:
    """How far the middles of the pieces lie from the hyperbola, which is where a cubic is worst."""
    heights = np.linspace(start, end, pieces + 1).tolist()
    worst = 0.0
    for a, b in itertools.pairwise(heights):
        (first, _), (second, _) = _controls(wall, a, b)
        middle = (_height(wall, a) + 3 * first + 3 * second + _height(wall, b)) / 8
        worst = max(worst, abs(middle - _height(wall, (a + b) / 2)))
    return worst


def _sheet(wall: ConicWall, hole: float) -> str:
    """The conic alone, in two pieces around a hole."""
    ends = [(wall.semi, hole), (-hole, -wall.semi)] if hole else [(wall.semi, -wall.semi)]
    return " ".join(f"{_move((_height(wall, a), a))} {curve(wall, a, b)}" for a, b in ends)


def _mirror(shape: Mirror) -> str:
    wall, back, hole = shape.front, shape.thickness, shape.hole / 2
    if not hole:
        return _closed(_down(wall), _line((back, -wall.edge)), _line((back, wall.edge)))
    pieces = [(wall.semi, hole), (-hole, -wall.semi)]
    return " ".join(
        f"{_move((_height(wall, a), a))} {curve(wall, a, b)} {_line((back, b))} {_line((back, a))} Z" for a, b in pieces
    )


def _polygon(shape: FlatGlass) -> str:
    """The section of a convex solid with planes: corners of its edges with the plane x = 0, in order."""
    corners = np.array([[float(c) for c in corner] for corner in shape.corners()])
    points: list[Any] = [c for c in corners if c[0] == 0]
    for a in corners[corners[:, 0] < 0]:
        points.extend(a + (b - a) * (a[0] / (a[0] - b[0])) for b in corners[corners[:, 0] > 0])
    section = convex([(float(p[2]), float(p[1])) for p in points])
    return " ".join([_move(section[0]), *map(_line, section[1:]), "Z"])


def convex(points: Iterable[Point]) -> list[Point]:
    """The corners of the convex hull, counter-clockwise (Andrew's monotone chain)."""
    ordered = sorted(set(points))
    hull: list[Point] = []
    for run in (ordered, ordered[::-1]):
        half: list[Point] = []
        for p in run:
            while len(half) > 1 and _turn(half[-2], half[-1], p) <= 0:
                half.pop()
            half.append(p)
        hull.extend(half[:-1])
    return hull


def _turn(a: Point, b: Point, c: Point) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
