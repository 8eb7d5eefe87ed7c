"""Slices of a scene by a plane with exact outlines, and scenes as voxels."""
