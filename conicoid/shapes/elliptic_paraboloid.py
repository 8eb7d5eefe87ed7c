"""The elliptic paraboloid."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from .elliptic import EllipticSolid, Profile
from .validate import interval, positive
from .vector import Interval


@dataclass(frozen=True)
class EllipticParaboloid(EllipticSolid):
    """A x² + E y² - z <= 0, cut by `z_range`: a bowl with its vertex at the origin, open upward.

    At z = h the section has the half-axes sqrt(h / A) and sqrt(h / E).
    Faces: 0 the paraboloid, 1 the cut at z_range[0], 2 the cut at z_range[1].
    uv: (angle of (x, y) / 360, height scaled from [max(0, low), high] to [0, 1]), v = z while there is no
    upper end; on the cuts (x, y) in units of the half-axes.
    Source: the ray tracing notes, canonical quadric 2a.
    """

    A: float
    E: float
    z_range: Interval | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "A", positive("EllipticParaboloid", "A", self.A))
        object.__setattr__(self, "E", positive("EllipticParaboloid", "E", self.E))
        object.__setattr__(self, "z_range", interval("EllipticParaboloid", "z_range", self.z_range))
        self.check_range()

    @property
    def squares(self) -> tuple[Any, Any]:
        return self.A, self.E

    @property
    def profile(self) -> Profile:
        return 0, 1, 0

    @property
    def extent(self) -> Interval:
        return 0.0, math.inf
