"""Exact decisions for rays and points that rounding leaves in doubt, and error bounds of reported crossings."""
