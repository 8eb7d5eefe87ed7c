"""Rays and answers as users hold them."""

from __future__ import annotations


# Queries on a prepared scene.
