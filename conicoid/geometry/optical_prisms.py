"""Prisms of glass: the triangular prism, the penta prism and the corner cube."""

from __future__ import annotations

import itertools
from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

from .._util.arrays import Vector
from .._util.validation import check_number, check_positive
from ..numerics import bigfloat_linalg as ex
from .bounds.support import corners_support, plane_uv
from .cell import Cell, Face
from .shape import PrimitiveSolid
from .surface import PlaneSurface


class FlatGlass(PrimitiveSolid, abstract=True):
    """A convex solid whose planes and corners are known to thousands of bits. Face i is plane i."""

    @abstractmethod
    def planes(self) -> list[PlaneSurface]:
        """Return the planes, outward, in the order of their numbers."""

    @abstractmethod
    def corners(self) -> Sequence[ex.Row]:
        """Return the corners, in any order."""

    def tree(self) -> Cell:
        return Cell(tuple(Face(surface, i, plane_uv(surface)) for i, surface in enumerate(self.planes())))

    def support(self, direction: Vector) -> float:
        return corners_support(self.corners(), direction)


@dataclass(frozen=True)
class Prism(FlatGlass):
    """A triangular prism, its edges along x: |x| <= length / 2, y >= -h / 2, |z| cos(a / 2) <= (h / 2 - y) sin(a / 2).

    a is `apex_angle` in degrees, between 0 and 180, at the edge y = h / 2, z = 0; both faces that meet there are
    `side` wide, so h = side cos(a / 2). 60 is the equilateral prism, 90 the right-angle or Porro prism, whose base is
    its hypotenuse.
    Faces: 0 towards -z, 1 towards +z, 2 base, 3 end at low x, 4 end at high x. uv: Cartesian coordinates on the plane
    as of `HalfSpace`.
    """

    apex_angle: float
    side: float
    length: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "apex_angle", check_number("Prism", "apex_angle", self.apex_angle))
        if not 0 < self.apex_angle < 180:
            raise ValueError(f"Prism: apex_angle must be between 0 and 180 degrees, got {self.apex_angle:g}")
        object.__setattr__(self, "side", check_positive("Prism", "side", self.side))
        object.__setattr__(self, "length", check_positive("Prism", "length", self.length))

    def _sizes(self) -> tuple[ex.BigFloat, ex.BigFloat, ex.BigFloat, ex.BigFloat]:
        """Return (sine and cosine of half the apex angle, half the height, half the base)."""
        s, c = ex.sin_cos_degrees(self.apex_angle / 2)
        side = ex.exact(self.side)
        return s, c, side * c / ex.exact(2.0), side * s

    def planes(self) -> list[PlaneSurface]:
        s, c, half, _ = self._sizes()
        end = self.length / 2
        return [
            PlaneSurface((0.0, s, -c), s * half, (0.0, half, 0.0)),
            PlaneSurface((0.0, s, c), s * half, (0.0, half, 0.0)),
            PlaneSurface((0.0, -1.0, 0.0), half, (0.0, -half, 0.0)),
            PlaneSurface((-1.0, 0.0, 0.0), end, (-end, 0.0, 0.0)),
            PlaneSurface((1.0, 0.0, 0.0), end, (end, 0.0, 0.0)),
        ]

    def corners(self) -> Sequence[ex.Row]:
        _, _, half, base = self._sizes()
        ends = (ex.exact(self.length / 2), -ex.exact(self.length / 2))
        return [(x, y, z) for x in ends for y, z in ((half, ex.ZERO), (-half, base), (-half, -base))]


@dataclass(frozen=True)
class PentaPrism(FlatGlass):
    """A penta prism: |x| <= length / 2, y >= 0, z >= 0, y <= side + (sqrt 2 - 1) z, z <= side + (sqrt 2 - 1) y.

    Light that enters along +z leaves along -y, however the prism is tilted about x: faces 2 and 3, which are at 45
    degrees and must be coated as mirrors, turn it by 90. The openings are `side` wide in y and z, `length` in x.
    y + z <= (1 + sqrt 2) side cuts off the part that a full beam does not need.
    Faces: 0 z = 0, 1 y = 0, 2 mirror opposite of 0, 3 mirror opposite of 1, 4 the fifth, 5 and 6 the ends at low and
    high x. uv: Cartesian coordinates on the plane as of `HalfSpace`.
    """

    side: float
    length: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "side", check_positive("PentaPrism", "side", self.side))
        object.__setattr__(self, "length", check_positive("PentaPrism", "length", self.length))

    def planes(self) -> list[PlaneSurface]:
        a, root, end = ex.exact(self.side), ex.sqrt(ex.exact(2.0)), self.length / 2
        lean = root - ex.ONE
        return [
            PlaneSurface((0.0, 0.0, -1.0), 0.0),
            PlaneSurface((0.0, -1.0, 0.0), 0.0),
            PlaneSurface((0.0, -lean, 1.0), a, (0.0, 0.0, a)),
            PlaneSurface((0.0, 1.0, -lean), a, (0.0, a, 0.0)),
            PlaneSurface((0.0, 1.0, 1.0), a + a * root, (0.0, a, a * root)),
            PlaneSurface((-1.0, 0.0, 0.0), end, (-end, 0.0, 0.0)),
            PlaneSurface((1.0, 0.0, 0.0), end, (end, 0.0, 0.0)),
        ]

    def corners(self) -> Sequence[ex.Row]:
        a, zero, far = ex.exact(self.side), ex.ZERO, ex.exact(self.side) * ex.sqrt(ex.exact(2.0))
        section = ((zero, zero), (a, zero), (far, a), (a, far), (zero, a))
        ends = (ex.exact(self.length / 2), -ex.exact(self.length / 2))
        return [(x, y, z) for x, (y, z) in itertools.product(ends, section)]


@dataclass(frozen=True)
class CornerCube(FlatGlass):
    """The corner of a cube, a retroreflector: z >= 0, and sqrt 2 (x cos p + y sin p) + z <= height, p = 0, 120, 240.

    The three mirrors are perpendicular to each other and meet at (0, 0, height). Light that enters through the triangle
    z = 0 returns parallel to its incoming direction. A round one is ``CornerCube(height) & Cylinder(...)``.
    Faces: 0 the front z = 0, 1 to 3 the mirrors. uv: Cartesian coordinates on the plane as of `HalfSpace`.
    """

    height: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "height", check_positive("CornerCube", "height", self.height))

    def planes(self) -> list[PlaneSurface]:
        root, top = ex.sqrt(ex.exact(2.0)), (0.0, 0.0, self.height)
        normals = [(root * ex.sin_cos_degrees(p)[1], root * ex.sin_cos_degrees(p)[0], 1.0) for p in (0, 120, 240)]
        return [PlaneSurface((0.0, 0.0, -1.0), 0.0), *(PlaneSurface(n, self.height, top) for n in normals)]

    def corners(self) -> Sequence[ex.Row]:
        far, zero = ex.exact(self.height) * ex.sqrt(ex.exact(2.0)), ex.ZERO
        turns = [ex.sin_cos_degrees(p) for p in (60, 180, 300)]
        return [(zero, zero, ex.exact(self.height)), *((far * c, far * s, zero) for s, c in turns)]
