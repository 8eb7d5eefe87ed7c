"""Bow tie to truncated cone: two planes slide along the axis of one cone.

KONYS in the graphics textbook (docs/theory.md), figures 3.2.5 and 3.2.6.
"""

from __future__ import annotations

import conicoid as co
from studio import ROOM, Progress, backdrop, lights

HEIGHT = 2.0
LOWER_PLANES = (-1.0, -0.7, -0.4, 0.0, 0.5)
PLACES = (-5.0, -2.9, -0.7, 1.9, 5.0)


def scene() -> co.Scene:
    """x² + y² <= slope² z² between two planes 2 apart, standing in a row; each next pair of planes is further up."""
    finishes = ["#8c1d2f", "#b5472d", "#d08a2c", "#4f7d4a", "#22577a"]
    bodies = []
    for low, x, color in zip(LOWER_PLANES, PLACES, finishes, strict=True):
        solid = co.DoubleCone(slope=0.55, z_range=(low, low + HEIGHT)).translate((x, 0, -low))
        bodies.append(co.Body(solid, co.lacquer(color)))
    camera = co.Camera((0, -17, 6.4), (0.15, 0, 0.95), field_of_view=18.5)
    return co.Scene([*bodies, *backdrop()], lights=lights(camera), camera=camera, background=ROOM)


def picture(progress: Progress | None = None, scale: float = 1.0) -> co.Image:
    """The picture, `scale` times its full size."""
    return scene().render(round(960 * scale), round(420 * scale), samples=9, progress=progress)


if __name__ == "__main__":
    picture().save("sliding_planes.png")
