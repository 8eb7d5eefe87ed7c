"""Scenes as OpenSCAD models."""
