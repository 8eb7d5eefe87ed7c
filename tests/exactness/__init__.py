"""Certified answers: rays that are hard, the documented domain, intervals, bounces, and differences below rounding.

Exact answers are those of `tests/reference`.
"""
