"""Bounds of shapes under any motion, and of their Boolean combinations."""
