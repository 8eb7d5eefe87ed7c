"""Scenes as files of other programs: which formats there are, what may be asked of all, and what they give."""

from __future__ import annotations

from .exporters import EXPORT_FORMATS, ExportFormat, ExportOptions, ExportResult, find_export_format

__all__ = ["EXPORT_FORMATS", "ExportFormat", "ExportOptions", "ExportResult", "find_export_format"]


# Scenes as GDML files.


# Scenes as OpenMC geometries.


# Scenes as OpenSCAD models.
