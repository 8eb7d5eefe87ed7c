"""Scenes as GDML files."""
