"""The hyperboloid of two sheets."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from .elliptic import EllipticSolid, Profile
from .validate import interval, positive
from .vector import Interval


@dataclass(frozen=True)
class TwoSheetHyperboloid(EllipticSolid):
    """A x² + E y² - H z² <= -1, cut by `z_range`: the two bowls about z, with vertices at z = ±1 / sqrt(H).

    At z = h the sections have the half-axes sqrt((H h² - 1) / A) and sqrt((H h² - 1) / E).
    Faces: 0 both bowls, 1 the cap at z_range[0], 2 the cap at z_range[1].
    uv: (angle of (x, y) / 360, height scaled from the range to [0, 1]), v = z without one; on the caps
    (x, y) in units of the half-axes.
    Source: the ray tracing notes, canonical quadric 3b.
    """

    A: float
    E: float
    H: float
    z_range: Interval | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "A", positive("TwoSheetHyperboloid", "A", self.A))
        object.__setattr__(self, "E", positive("TwoSheetHyperboloid", "E", self.E))
        object.__setattr__(self, "H", positive("TwoSheetHyperboloid", "H", self.H))
        object.__setattr__(self, "z_range", interval("TwoSheetHyperboloid", "z_range", self.z_range))
        self.check_range()

    @property
    def squares(self) -> tuple[Any, Any]:
        return self.A, self.E

    @property
    def profile(self) -> Profile:
        return -1, 0, self.H
