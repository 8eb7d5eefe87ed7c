"""Projections for tomography: scans as ASTRA and RTK name them, and `project`, line integrals along all their rays.

Angles are in degrees. What a scan is made of is in `Geometry`; every constructor here makes one.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..._util.foreign_names import module_attribute_error
from .project import project
from .scan_geometry import ScanGeometry
from .trajectories import cone, fanflat, from_astra, helical, parallel, parallel3d, rtk

__all__ = ["ScanGeometry", "cone", "fanflat", "from_astra", "helical", "parallel", "parallel3d", "project", "rtk"]

if not TYPE_CHECKING:  # else checkers would let any name be asked for

    def __getattr__(name: str) -> Any:
        raise module_attribute_error("conicoid.apps.ct", name, __all__)

    def __dir__() -> list[str]:
        return sorted(__all__)
