"""Distances of points from the walls of a scene: certified lower bounds, and the nearest points themselves.

safety.py computes lower bounds for 64 points together; transport codes call such a bound the safety.
"""
