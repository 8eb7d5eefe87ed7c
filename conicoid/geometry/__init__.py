"""Shapes, Boolean combinations, motions and bodies: data only, no compiled code."""
