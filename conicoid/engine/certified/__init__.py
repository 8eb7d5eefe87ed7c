"""Doubtful rays and points decided with certainty, and bounds on what is told of crossings."""
