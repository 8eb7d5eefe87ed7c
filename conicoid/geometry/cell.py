"""Boolean trees over cells, which all solids reduce to, and sheets clipped by such trees.

A *cell* is at most one quadric, cut by any number of planes. A *face* is one of its surfaces, together with the side
that is inside, a number that the user sees as ``hits.face``, and a map that gives its uv coordinates.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from .._util.arrays import Vector
from ..numerics import bigfloat as ex
from .surface import PlaneSurface, QuadricSurface, Surface
from .transform import Motion


@dataclass(frozen=True, slots=True)
class UV:
    """A map from own coordinates p to uv, by (a, b, c) = matrix (p, 1), a 3 × 4 matrix as a tuple of rows.

    An `angular` map has u = angle of (a, b) in turns, in [0, 1), and v = c. A planar one has u = a and v = b; it does
    not use c (`NO_ROW`).
    """

    angular: bool
    matrix: tuple[tuple[float, float, float, float], ...]


NO_ROW = (0.0, 0.0, 0.0, 0.0)
"""The third row of a planar map."""


def cylindrical_uv(low: float = 0.0, high: float = 1.0) -> UV:
    """Return the map (angle about z / 360, height scaled from [low, high] to [0, 1]); infinite ends do not scale z."""
    scale, shift = (1 / (high - low), -low / (high - low)) if high - low < float("inf") else (1.0, 0.0)
    return UV(True, ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, scale, shift)))


def cartesian_uv(u: Vector, v: Vector, origin: Vector = (0.0, 0.0, 0.0)) -> UV:
    """Return the map to the components of (p - origin) along the vectors u and v, divided by their squared lengths."""
    return UV(False, (component_row(u, origin), component_row(v, origin), NO_ROW))


def component_row(a: Vector, origin: Vector) -> tuple[float, float, float, float]:
    """Return one row of a map: the component of (p - origin) along the vector `a`, divided by its squared length."""
    n = a[0] * a[0] + a[1] * a[1] + a[2] * a[2]
    return a[0] / n, a[1] / n, a[2] / n, -(a[0] * origin[0] + a[1] * origin[1] + a[2] * origin[2]) / n


def transform_uv(uv: UV, motion: Motion) -> UV:
    """Return the same map from world coordinates, if `motion` carries own coordinates to the world."""
    if motion.is_identity:
        return uv
    back, shift = motion.inverse
    columns = ex.transpose(back)

    def row(own: tuple[float, float, float, float]) -> tuple[float, float, float, float]:
        a, b, c, d = (ex.exact(value) for value in own)
        x, y, z = ex.apply(columns, (a, b, c))
        return ex.rounded(x), ex.rounded(y), ex.rounded(z), ex.rounded(ex.dot((a, b, c), shift, d))

    return UV(uv.angular, tuple(row(own) for own in uv.matrix))


PLAIN_UV = cartesian_uv((1, 0, 0), (0, 1, 0))


@dataclass(frozen=True, slots=True)
class Face:
    """One surface of a cell. `inside` is +1 if surface <= 0 is inside, -1 if surface >= 0 is."""

    surface: Surface
    number: int
    uv: UV = PLAIN_UV
    inside: int = 1


@dataclass(frozen=True, slots=True)
class Cell:
    """The points inside all faces.

    At most one face is a quadric, and it comes first. Numbers rise along the tuple: of several crossings at one t, the
    face with the lower number counts.
    """

    faces: tuple[Face, ...]


@dataclass(frozen=True, slots=True)
class All:
    """The points inside every part; all of space without parts."""

    parts: tuple[Tree, ...]


@dataclass(frozen=True, slots=True)
class Any_:
    """The points inside at least one part; none without parts."""

    parts: tuple[Tree, ...]


@dataclass(frozen=True, slots=True)
class Not:
    """The points outside of the part."""

    part: Tree


Tree: TypeAlias = Cell | All | Any_ | Not
NOTHING = Any_(())


@dataclass(frozen=True, slots=True)
class SurfaceSheet:
    """The part of a surface in `clip`, all of it if None.

    The normal of the sheet is the gradient of the surface times `side`, +1 or -1.
    """

    surface: Surface
    clip: Tree | None = None
    side: int = 1
    one_sided: bool = False
    uv: UV = PLAIN_UV


@dataclass(frozen=True, slots=True)
class PolygonSheet:
    """The even-odd inside of a closed loop of points in a plane, with exact coordinates."""

    plane: PlaneSurface
    vertices: tuple[ex.Row, ...]
    uv: UV = PLAIN_UV


__all__ = [
    "NOTHING",
    "UV",
    "All",
    "Any_",
    "Cell",
    "Face",
    "Not",
    "PlaneSurface",
    "PolygonSheet",
    "QuadricSurface",
    "SurfaceSheet",
    "Tree",
    "cartesian_uv",
    "cylindrical_uv",
    "transform_uv",
]
