"""Error constants: every bound that decides where the fast formulas are not trusted. See docs/dev/exactness.md.

A crossing is doubtful long before rounding can change the answer: roundings are 2^-53 each, and a formula has some
dozen of them. Doubtful crossings are decided again, so a bound that is too wide costs time, and one that is too narrow
gives a wrong answer.
"""

RELATIVE = 2.0**-44
"""Error of t as a share of |o| and of |x|, for every surface."""
STARTING = 1024.0
"""Factor of the bounds for a ray that starts on a surface, since its origin was rounded to a point beside the surface:
of the share of |o| in the error of t, and of the least discriminant."""
BALL_OFF, BALL_FAR = 2.0**-21, 2.0**45
"""For a ball: error of t as a share of the radius, and the distance in radii beyond which nothing is certain."""
LEAST_OF_BALLS = 2.0**-31
"""Least certain discriminant of a sphere, for |d| = 1, as a share of r²."""
KAPPA, KAPPA_OF_BALLS, KAPPA_OF_PLANES = 2.0**-47, 2.0**-40, 2.0**-49
"""Relative error of a surface's record, from which its least certain discriminant follows (prepare/error_limits.py):
of a quadric whose anchor is exact, 64 roundings; of a sphere, whose center may be off by 2^-46 of its radius; of a
plane that was rounded."""
FAR = 2.0**45
"""Distance from a surface, as a multiple of its reach, beyond which nothing is certain of it."""
LOOP = 2.0**-44
"""Share of the terms of u and v (polygon_loop.py) by which rounding, that of a vertex too, may change them."""
POINT, POINT_AT_BALL = 2.0**-44, 2.0**-40
"""Share of the terms of a surface's value at a point by which it may be off; of a sphere's, of |p - c|² + r²."""
CANCELS, OBLIQUE = 2.0**-10, 2.0**-5
"""Share of its terms below which a sum is computed again in pairs of floats: for a quadric, for a plane."""
T_ERROR = 2.0**-6
"""Relative error bound of a t that is not doubtful: |t| is more than 2^-44 |o|, its error less than 2^-50 |o|."""
