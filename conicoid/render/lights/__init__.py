"""Sources of light: lamps with an extent, point and parallel lights, and surroundings, sampled by chance.

A source of any kind is a row of a table. A point chooses one at random, weighed by the light that may arrive from each.
Directions to lamps are drawn by solid angle (balls, near polygons) or by area (discs, cylinders, other polygons).
"""
