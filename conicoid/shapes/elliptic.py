"""What the surfaces with elliptic sections across z share: cell, caps, uv and bounds.

Each of them is sx x² + sy y² <= g(z) with g(z) = g0 + g1 z + g2 z², cut by low <= z <= high.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from fractions import Fraction
from functools import cached_property
from typing import Any, TypeAlias

from . import exact as ex
from .base import PrimitiveSolid
from .cells import PLAIN_UV, Cell, Face, around_z, flat
from .rounded import is_finite, root
from .support import elliptic_support, inverse_root
from .surface import PlaneSurface, QuadricSurface
from .vector import Interval, Vector

Profile: TypeAlias = tuple[Any, Any, Any]


class EllipticSolid(PrimitiveSolid, abstract=True):
    """A solid sx x² + sy y² <= g(z) about the z axis of its own frame, within `z_range`.

    Faces: 0 the curved surface (both nappes or bowls of it), 1 the cap at z_range[0], 2 the cap at
    z_range[1]. uv: on face 0 (angle of (x, y) about z / 360, height scaled from the range to [0, 1]);
    the range counts from where the surface begins, and if it is infinite v is z itself.
    On the caps (x, y) in units of the half-axes of the cap's ellipse.
    Source: the Clemson notes, "parameterization".
    """

    z_range: Interval | None

    @property
    @abstractmethod
    def squares(self) -> tuple[Any, Any]:
        """(sx, sy), exact and positive."""

    @property
    @abstractmethod
    def profile(self) -> Profile:
        """(g0, g1, g2), exact."""

    @property
    def extent(self) -> Interval:
        """The heights between which g >= 0, where that is an interval."""
        return -math.inf, math.inf

    def check_range(self) -> None:
        """Refuse a range in which there is nothing of the solid, or but a point: g <= 0 all over it."""
        if self.z_range is None or self._reaches_into(*self.z_range):
            return
        name, (low, high) = type(self).__name__, self.z_range
        raise ValueError(
            f"{name}: z_range must leave a part of the solid, which has nothing in it, got ({low}, {high})"
        )

    def _reaches_into(self, low: float, high: float) -> bool:
        """Whether g > 0 somewhere in the open range; exactly."""
        _, g1, g2 = (Fraction(g) for g in self.profile)
        summit = -g1 / (2 * g2) if g2 else Fraction(0)
        places = [Fraction(z) for z in (low, high) if math.isfinite(z)]
        if g2 < 0 and low < summit < high:
            places.append(summit)
        if any(self._g(z) > 0 for z in places):
            return True
        endless = [sense for z, sense in ((low, -1), (high, 1)) if math.isinf(z)]
        return any(g2 > 0 or (g2 == 0 and sense * g1 > 0) for sense in endless)

    @cached_property
    def widths(self) -> tuple[float, float]:
        """The half-axes of the section where g = 1."""
        sx, sy = self.squares
        return inverse_root(sx), inverse_root(sy)

    @property
    def heights(self) -> Interval:
        """The part of the extent in the range; low > high where there is none."""
        (low, high), (bottom, top) = self.z_range or (-math.inf, math.inf), self.extent
        return max(low, bottom), min(high, top)

    def tree(self) -> Cell:
        sx, sy = self.squares
        g0, g1, g2 = self.profile
        side = QuadricSurface((sx, sy, -g2), (0.0, 0.0, -g1 / 2), g0)
        low, high = self.heights
        return Cell((Face(side, 0, around_z(low, high) if low < high else PLAIN_UV), *self.caps))

    @cached_property
    def caps(self) -> list[Face]:
        """The planes of the range, without those that the surface does not reach."""
        caps = []
        for number, z, sense in ((1, self.z_range[0], -1.0), (2, self.z_range[1], 1.0)) if self.z_range else ():
            if is_finite(z) and not self._beyond(z, sense):
                plane = PlaneSurface((0.0, 0.0, sense), sense * z, (0.0, 0.0, z))
                caps.append(Face(plane, number, self._cap_uv(z)))
        return caps

    def _beyond(self, z: float, sense: float) -> bool:
        """Whether z lies on the outer side of an end of the surface: g concave, g <= 0 and falling outward."""
        _, g1, g2 = self.profile
        return bool(g2 <= 0 and self._g(z) <= 0 and sense * (g1 + 2 * ex.rational(g2) * ex.rational(z)) < 0)

    def _cap_uv(self, z: float) -> Any:
        square = self._g(z)
        if square <= 0:
            return PLAIN_UV
        (x, y), size = self.widths, root(square)
        return flat((x * size, 0.0, 0.0), (0.0, y * size, 0.0))

    def _g(self, z: float | Fraction) -> Any:
        g0, g1, g2 = (ex.rational(g) for g in self.profile)
        height = ex.rational(z)
        return g0 + height * (g1 + height * g2)

    def support(self, direction: Vector) -> float:
        return elliptic_support(*self.widths, self.profile, *self.heights, direction)
