"""Exact arithmetic for the few rays that error bounds leave open: integers of any length, no rounding at all."""

from .order import exact_ranks

__all__ = ["exact_ranks"]
