"""Projections for tomography: scans with the names of ASTRA and RTK, and `project`, line integrals along their rays.

Angles are in degrees. `ScanGeometry` is the data of a scan; every constructor here makes one.
"""

from __future__ import annotations

from .project import project
from .scan_geometry import ScanGeometry, cone, fanflat, from_astra, helical, parallel, parallel3d, rtk

__all__ = ["ScanGeometry", "cone", "fanflat", "from_astra", "helical", "parallel", "parallel3d", "project", "rtk"]
