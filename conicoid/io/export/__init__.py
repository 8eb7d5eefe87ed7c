"""Export of scenes to GDML, OpenMC and OpenSCAD."""

from __future__ import annotations

from .exporters import EXPORT_FORMATS, ExportFormat, ExportOptions, ExportResult, find_export_format

__all__ = ["EXPORT_FORMATS", "ExportFormat", "ExportOptions", "ExportResult", "find_export_format"]
