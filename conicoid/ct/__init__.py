"""Projections for tomography: scans as ASTRA and RTK name them, and `project`, line integrals along all their rays.

Angles are in degrees. What a scan is made of is in `Geometry`; every constructor here makes one.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..shapes.elsewhere import no_attribute_of_module
from .circular import cone, fanflat, helical, parallel, parallel3d
from .geometry import Geometry
from .project import project
from .toolboxes import from_astra, rtk

__all__ = ["Geometry", "cone", "fanflat", "from_astra", "helical", "parallel", "parallel3d", "project", "rtk"]

if not TYPE_CHECKING:  # else checkers would let any name be asked for

    def __getattr__(name: str) -> Any:
        raise no_attribute_of_module("conicoid.ct", name, __all__)

    def __dir__() -> list[str]:
        return sorted(__all__)
