"""Certified answers: hard rays, the documented domain, intervals, bounces, and differences below rounding.

`tests/reference` has the exact answers.
"""
