"""The double cone and the bow tie."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from . import exact as ex
from .elliptic import EllipticSolid, Profile
from .validate import interval, positive
from .vector import Interval


@dataclass(frozen=True)
class DoubleCone(EllipticSolid):
    """x² + y² <= slope² z²: both nappes about z, `slope` > 0; with a `z_range` across the apex, the bow tie.

    Faces: 0 both nappes, 1 the cap at z_range[0], 2 the cap at z_range[1]. The apex has the axis for its normal.
    uv: (angle / 360, height scaled from the range to [0, 1]), v = z without one; on the caps (x, y) / radius.
    Source: the graphics textbook (PICA; the bow tie becomes the truncated cone as the range slides along the axis).
    """

    slope: float = 1.0
    z_range: Interval | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "slope", positive("DoubleCone", "slope", self.slope))
        object.__setattr__(self, "z_range", interval("DoubleCone", "z_range", self.z_range))

    @property
    def squares(self) -> tuple[Any, Any]:
        return 1.0, 1.0

    @property
    def profile(self) -> Profile:
        return 0, 0, ex.rational(self.slope) ** 2
