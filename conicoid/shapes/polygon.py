"""The polygon, a flat sheet with straight edges."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

from . import exact as ex
from .base import PrimitiveSheet
from .cells import UV, PolygonSheet, flat, moved_uv
from .motion import Motion
from .support import points_support
from .surface import PlaneSurface
from .validate import vectors
from .vector import Vector

_FLATNESS = 64


@dataclass(frozen=True)
class Polygon(PrimitiveSheet):
    """A closed loop of `vertices` in a plane; inside by even-odd, so it may be concave or cross itself.

    The plane is Newell's; its normal sees the loop counter-clockwise. A vertex may lie off it by 64 units
    in the last place of the largest coordinate, more is refused. Face 0. uv: coordinates along the first edge
    and across it (normal × edge), from the first vertex, in units of that edge.
    Source: the ray tracing notes, "ray and polygon" (even-odd).
    """

    vertices: tuple[Vector, ...]

    def __post_init__(self) -> None:
        points = vectors("Polygon", "vertices", self.vertices, 3)
        object.__setattr__(self, "vertices", points)
        check_flat("Polygon", points)

    def sheet(self, motion: Motion) -> PolygonSheet:
        return polygon_sheet(self.vertices, motion, self._uv())

    def _uv(self) -> UV:
        points = [ex.exact_row(point) for point in self.vertices]
        edges = (_minus(point, points[0]) for point in points[1:])
        edge = next(e for e in edges if any(e))
        across = ex.cross(ex.unit(newell(points)), edge)
        return flat(_floats(edge), _floats(across), self.vertices[0])

    def support(self, direction: Vector) -> float:
        return points_support(self.vertices, direction)


def newell(points: Sequence[ex.Row]) -> ex.Row:
    """Twice the area vector of a closed loop, the sum of p_i × p_(i+1) (Newell), exact."""
    spokes = [_minus(point, points[0]) for point in points]
    terms = [ex.cross(a, b) for a, b in itertools.pairwise(spokes[1:])]
    x, y, z = (ex.cancelling_sum([term[i] for term in terms]) for i in range(3))
    return x, y, z


def check_flat(owner: str, vertices: Sequence[Vector]) -> None:
    """Refuse loops without area and loops that leave their plane."""
    points = [ex.exact_row(vertex) for vertex in vertices]
    normal = newell(points)
    if not any(normal):
        raise ValueError(
            f"{owner}: vertices must enclose an area, got {len(points)} points with none (Newell's sum is 0)"
        )
    unit, middle = ex.unit(normal), _middle(points)
    allowed = _FLATNESS * math.ulp(max(abs(c) for vertex in vertices for c in vertex))
    deviations = [abs(float(ex.dot(unit, _minus(point, middle)))) for point in points]
    worst = max(range(len(points)), key=deviations.__getitem__)
    if deviations[worst] > allowed:
        raise ValueError(
            f"{owner}: vertices must lie in a plane to {_FLATNESS} ulp of the largest coordinate ({allowed:.3g}), "
            f"got vertices[{worst}] = {vertices[worst]} at {deviations[worst]:.3g} from Newell's plane"
        )


def polygon_sheet(vertices: Sequence[Vector], motion: Motion, uv: UV) -> PolygonSheet:
    """A loop carried by a motion; its normal stays on the physical side, also under a mirror."""
    rows, shift = motion.affine
    points = [_carried(rows, shift, ex.exact_row(vertex)) for vertex in vertices]
    normal, middle = newell(points), _middle(points)
    if ex.determinant(rows) < 0:
        normal = (-normal[0], -normal[1], -normal[2])
    # The offset is that of any corner of a triangle; of other loops it is n·middle, divided last: so it is exact
    # wherever it is binary on paper
    offset = ex.dot(normal, points[0]) if len(points) == 3 else ex.dot(normal, _sum(points)) / len(points)
    plane = PlaneSurface(normal, offset, middle)
    return PolygonSheet(plane, tuple(points), moved_uv(uv, motion))


def _carried(rows: ex.Rows, shift: ex.Row, point: ex.Row) -> ex.Row:
    x, y, z = (ex.dot(row, point, t) for row, t in zip(rows, shift, strict=True))
    return x, y, z


def _sum(points: Sequence[ex.Row]) -> ex.Row:
    x, y, z = (ex.total(point[i] for point in points) for i in range(3))
    return x, y, z


def _middle(points: Sequence[ex.Row]) -> ex.Row:
    x, y, z = (total / len(points) for total in _sum(points))
    return x, y, z


def _minus(a: ex.Row, b: ex.Row) -> ex.Row:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def _floats(row: ex.Row) -> Vector:
    return ex.rounded(row[0]), ex.rounded(row[1]), ex.rounded(row[2])
