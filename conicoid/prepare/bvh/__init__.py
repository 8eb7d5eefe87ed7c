"""Bounding volume hierarchies: built, refitted, and written as tables."""
