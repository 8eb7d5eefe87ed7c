"""Scenes as OpenMC geometries."""
