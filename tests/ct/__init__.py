"""Projections for tomography."""
