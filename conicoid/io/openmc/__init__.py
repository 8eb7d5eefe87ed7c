"""Import of OpenMC geometries: ``read(path)`` returns bodies, a legend and notes. See docs/openmc.md.

The format is that of OpenMC's documentation, "Geometry Specification". Where that leaves something open (rotations,
ring order, root universe), the reader follows the source code of OpenMC.
"""

from __future__ import annotations

from ..importers import ImportResult, LegendEntry, palette_color
from .importer import read

__all__ = ["ImportResult", "LegendEntry", "palette_color", "read"]
