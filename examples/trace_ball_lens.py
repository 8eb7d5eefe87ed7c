"""A ball lens traced by hand: where do parallel rays meet? Paraxial theory: n R / (2 (n - 1)) from the centre."""

from __future__ import annotations

import numpy as np

import conicoid as co

RADIUS, INDEX = 1.0, co.materials.GLASS


def focal_length(height: float) -> float:
    """Distance from the ball's centre to where a ray at `height` over the axis crosses it again."""
    lens = co.Scene([co.Sphere(RADIUS)])
    rays = co.Rays([-5.0, 0.0, height], [1.0, 0.0, 0.0])
    for eta in (1 / INDEX, INDEX):  # into the glass, and out of it
        hits = lens.first_hit(rays)
        directions, total = co.refract(rays.directions, hits.normal, eta)
        assert not np.any(total)
        rays = hits.spawn(directions)
    (x, _, z), (dx, _, dz) = rays.origins, rays.directions
    return float(x - z * dx / dz)


if __name__ == "__main__":
    print(f"paraxial: {INDEX * RADIUS / (2 * (INDEX - 1)):.9f}")
    for height in (0.5, 0.1, 0.01, 0.001, 0.0001):
        print(f"height {height:<6} crosses the axis at {focal_length(height):.9f}")
