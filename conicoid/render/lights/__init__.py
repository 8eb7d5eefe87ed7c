"""Where light comes from: lamps with an extent, points, parallel light and the surroundings, drawn by chance.

A source is a row of a table, whatever it is; which one a point asks is decided by chance, by what might arrive from
each. Directions to lamps are drawn by solid angle (balls) or by area (discs, polygons, cylinders).
"""
