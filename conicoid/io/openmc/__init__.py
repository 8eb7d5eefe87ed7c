"""OpenMC's geometries as scenes: ``read(path)`` gives bodies, a legend and notes. See docs/openmc.md.

The file format is described in OpenMC's documentation, "Geometry Specification"; where that leaves
something open, the program itself was read (rotations, ring order, root universe).
"""

from __future__ import annotations

from ..importers import ImportResult, LegendEntry, palette_color
from .importer import read

__all__ = ["ImportResult", "LegendEntry", "palette_color", "read"]
