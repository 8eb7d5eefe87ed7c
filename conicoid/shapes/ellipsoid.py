"""The ellipsoid and, cut by two planes, the barrel."""

from __future__ import annotations

import functools
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import Any

from . import exact as ex
from .calls import explained
from .elliptic import EllipticSolid, Profile
from .motion import Motion, Translate
from .rounded import hypot, larger
from .support import elliptic_support, inverse_root
from .validate import interval, positive, vector
from .vector import Interval, Vector, VectorLike

_DEFAULT_RADII: Vector = (1.0, 2.0, 3.0)


@dataclass(frozen=True)
class Ellipsoid(EllipticSolid):
    """(x / a)² + (y / b)² + (z / c)² <= 1 about `center`, (a, b, c) = `radii`.

    `z_range` cuts it: low <= z <= high, measured from the center. `coefficients` = (A, E, H), if
    given, stand instead of the radii and are kept to the bit: A x² + E y² + H z² <= 1.

    Faces: 0 the ellipsoid, 1 the cut at low, 2 the cut at high.
    uv: (angle of (x, y) / 360, height scaled from the lowest to the highest point of face 0 to [0, 1]);
    on the cuts (x, y) in units of the half-axes of the cut.
    Sources: the ray tracing notes (canonical quadric 1) and the graphics textbook (ALLIPS, ALLOID).
    """

    radii: VectorLike = _DEFAULT_RADII
    center: VectorLike = (0.0, 0.0, 0.0)
    z_range: Interval | None = None
    coefficients: Vector | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        radii = vector("Ellipsoid", "radii", self.radii)
        for i, r in enumerate(radii):
            if not r > 0:
                positive("Ellipsoid", f"radii[{i}]", r)
        if self.coefficients is not None:
            given, radii = radii, self._from_coefficients()
            if self.radii is not _DEFAULT_RADII and given != radii:  # a motion gives both again
                raise ValueError(f"Ellipsoid: radii must be left out where coefficients are given, got {given}")
        object.__setattr__(self, "radii", radii)
        object.__setattr__(self, "center", vector("Ellipsoid", "center", self.center))
        object.__setattr__(self, "z_range", interval("Ellipsoid", "z_range", self.z_range))
        self.check_range()

    def _from_coefficients(self) -> Vector:
        a, e, h = vector("Ellipsoid", "coefficients", self.coefficients)
        a, e, h = (positive("Ellipsoid", name, value) for name, value in zip("AEH", (a, e, h), strict=True))
        object.__setattr__(self, "coefficients", (a, e, h))
        return inverse_root(a), inverse_root(e), inverse_root(h)

    @classmethod
    @explained
    def from_coefficients(
        cls, A: float, E: float, H: float, center: Any = (0.0, 0.0, 0.0), z_range: Any = None
    ) -> Ellipsoid:
        """A x² + E y² + H z² <= 1 about `center`, cut by `z_range`, with A, E, H > 0; they are kept as they are."""
        given = (positive("Ellipsoid", "A", A), positive("Ellipsoid", "E", E), positive("Ellipsoid", "H", H))
        return cls(center=center, z_range=z_range, coefficients=given)

    @property
    def placement(self) -> Motion:
        return Motion((Translate(self.center),))

    @cached_property
    def equation(self) -> tuple[Any, Any, Any, Any]:
        """(sx, sy, sz, k) of sx x² + sy y² + sz z² <= k, exact; a ball has squares 1."""
        if self.coefficients is not None:
            return (*self.coefficients, 1.0)
        largest = ex.rational(functools.reduce(larger, self.radii)) ** 2
        sx, sy, sz = (largest / ex.rational(r) ** 2 for r in self.radii)
        return sx, sy, sz, largest

    @property
    def squares(self) -> tuple[Any, Any]:
        return self.equation[0], self.equation[1]

    @property
    def profile(self) -> Profile:
        _, _, sz, k = self.equation
        return k, 0, -sz

    @property
    def extent(self) -> Interval:
        return -self.radii[2], self.radii[2]

    def _reaches_into(self, low: float, high: float) -> bool:
        """The same without fractions where radii are given: then g > 0 is |z| < c, exactly."""
        if self.coefficients is not None:
            return super()._reaches_into(low, high)
        bottom, top = self.extent
        return low < top and high > bottom

    def support(self, direction: Vector) -> float:
        a, b, c = self.radii
        if not self.caps:
            return hypot(a * direction[0], b * direction[1], c * direction[2])
        _, _, sz, k = self.equation
        return elliptic_support(a, b, (1, 0, -Fraction(sz) / Fraction(k)), *self.heights, direction)
