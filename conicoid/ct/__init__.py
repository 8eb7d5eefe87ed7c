"""Projections for tomography: scans as ASTRA and RTK name them, and `project`, line integrals along all their rays.

Angles are in degrees. What a scan is made of is in `Geometry`; every constructor here makes one.
"""

from __future__ import annotations

from .circular import cone, fanflat, helical, parallel, parallel3d
from .geometry import Geometry
from .project import project
from .toolboxes import from_astra, rtk

__all__ = ["Geometry", "cone", "fanflat", "from_astra", "helical", "parallel", "parallel3d", "project", "rtk"]
