"""The hyperboloid of one sheet."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from .elliptic import EllipticSolid, Profile
from .validate import interval, positive
from .vector import Interval


@dataclass(frozen=True)
class OneSheetHyperboloid(EllipticSolid):
    """A x² + E y² - H z² <= 1, cut by `z_range`: the solid within the one-sheeted hyperboloid about z.

    At z = h the section has the half-axes sqrt((1 + H h²) / A) and sqrt((1 + H h²) / E).
    Faces: 0 the hyperboloid, 1 the cap at z_range[0], 2 the cap at z_range[1].
    uv: (angle of (x, y) / 360, height scaled from the range to [0, 1]), v = z without one; on the caps
    (x, y) in units of the half-axes.
    Source: the ray tracing notes, canonical quadric 3a.
    """

    A: float
    E: float
    H: float
    z_range: Interval | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "A", positive("OneSheetHyperboloid", "A", self.A))
        object.__setattr__(self, "E", positive("OneSheetHyperboloid", "E", self.E))
        object.__setattr__(self, "H", positive("OneSheetHyperboloid", "H", self.H))
        object.__setattr__(self, "z_range", interval("OneSheetHyperboloid", "z_range", self.z_range))

    @property
    def squares(self) -> tuple[Any, Any]:
        return self.A, self.E

    @property
    def profile(self) -> Profile:
        return 1, 0, self.H
