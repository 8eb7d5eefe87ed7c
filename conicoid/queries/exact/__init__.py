"""Doubtful rays and points decided with certainty, and error bounds of reported crossings."""
