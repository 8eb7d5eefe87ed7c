"""Measurements: one script a question, and `comparison`, the same rays in other programs."""
