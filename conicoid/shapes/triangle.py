"""The triangle, the smallest flat sheet."""

from __future__ import annotations

from dataclasses import dataclass

from . import exact as ex
from .base import PrimitiveSheet
from .cells import NO_ROW, UV, PolygonSheet
from .motion import Motion
from .polygon import polygon_sheet
from .support import points_support
from .validate import vector
from .vector import Vector, VectorLike

CLEAR = 2.0**-45


@dataclass(frozen=True)
class Triangle(PrimitiveSheet):
    """The triangle a, b, c; its normal (b - a) × (c - a) sees them counter-clockwise.

    Face 0. uv: (β, γ), the barycentric weights of b and c in p = α a + β b + γ c, α + β + γ = 1.
    Source: the ray tracing notes, "barycentric coordinates".
    """

    a: VectorLike
    b: VectorLike
    c: VectorLike

    def __post_init__(self) -> None:
        for name in ("a", "b", "c"):
            object.__setattr__(self, name, vector("Triangle", name, getattr(self, name)))
        if not self._is_clear() and not any(ex.cross(*self._edges())):
            raise ValueError(f"Triangle: a, b, c must not lie on a line, got {self.a}, {self.b}, {self.c}")

    def _is_clear(self) -> bool:
        """Whether floats show that the corners are not on a line.

        Products of rounded differences are off by less than 2^-51 of themselves, and nothing underflows in the domain.
        """
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = self.a, self.b, self.c
        x, y, z, u, v, w = bx - ax, by - ay, bz - az, cx - ax, cy - ay, cz - az
        return any(abs(p - q) > CLEAR * (abs(p) + abs(q)) for p, q in ((y * w, z * v), (z * u, x * w), (x * v, y * u)))

    def _edges(self) -> tuple[ex.Row, ex.Row]:
        a, b, c = (ex.exact_row(point) for point in (self.a, self.b, self.c))
        return (b[0] - a[0], b[1] - a[1], b[2] - a[2]), (c[0] - a[0], c[1] - a[1], c[2] - a[2])

    def sheet(self, motion: Motion) -> PolygonSheet:
        return polygon_sheet((self.a, self.b, self.c), motion, self._uv())

    def _uv(self) -> UV:
        """β = (c - a) × n · (p - a) / n², γ = n × (b - a) · (p - a) / n², n = (b - a) × (c - a)."""
        to_b, to_c = self._edges()
        normal = ex.cross(to_b, to_c)
        square, start = ex.dot(normal, normal), ex.exact_row(self.a)
        rows = []
        for gradient in (ex.cross(to_c, normal), ex.cross(normal, to_b)):
            x, y, z = (component / square for component in gradient)
            rows.append((ex.rounded(x), ex.rounded(y), ex.rounded(z), -ex.rounded(ex.dot((x, y, z), start))))
        return UV(False, (rows[0], rows[1], NO_ROW))

    def support(self, direction: Vector) -> float:
        return points_support((self.a, self.b, self.c), direction)
