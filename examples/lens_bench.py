"""A bench with a lamp like a star, a lens and a screen: the star upside down on the screen is what the lens makes.

Nothing is drawn there: each path that leaves the screen finds the star through the lens, or does not.
"""

from __future__ import annotations

import math

import numpy as np

import conicoid as co
from studio import Progress

CURVE = 2.4
"""Radius of both faces of the lens, of index 1.6: its focal length is 2, in thin glass."""
WIDE = 0.6
OBJECT, SCREEN = -4.1, 4.1
AXIS = 1.45


def star(radius: float) -> co.Sheet:
    """Five points, in the plane x = 0, one of them up."""
    angles = np.radians(90 + 36 * np.arange(10))
    lengths = radius * np.where(np.arange(10) % 2 == 0, 1.0, 0.42)
    return co.Polygon([(0.0, r * math.cos(a), r * math.sin(a)) for a, r in zip(angles, lengths, strict=True)])


def lens() -> co.Solid:
    """What two balls have in common, within a cylinder along x."""
    apart = CURVE - (CURVE - math.sqrt(CURVE**2 - WIDE**2)) - 0.03
    balls = co.Sphere(CURVE, (apart, 0, 0)) & co.Sphere(CURVE, (-apart, 0, 0))
    return balls & co.Cylinder((-1, 0, 0), (1, 0, 0), WIDE)


def post(x: float, top: float) -> co.Solid:
    """A foot that rides on the rail, and a rod."""
    foot = co.Box((x - 0.22, -0.3, 0.16), (x + 0.22, 0.3, 0.36))
    return foot | co.Cylinder((x, 0, 0.3), (x, 0, top), 0.06)


def scene() -> co.Scene:
    """A dark room; the lens sits in a wide black board, so that no light passes beside it."""
    up = (0, 0, AXIS)
    rail = co.Box((-5.2, -0.14, 0.04), (5.2, 0.14, 0.16)) | co.Box((-5.2, -0.3, 0), (5.2, 0.3, 0.05))
    steel, black = co.matte((0.3, 0.3, 0.31)), co.matte((0.035, 0.035, 0.04))
    board = co.Box((-0.05, -1.35, -1.0), (0.05, 1.35, 1.35)) - co.Cylinder((-1, 0, 0), (1, 0, 0), WIDE)
    ring = co.Cylinder((-0.2, 0, 0), (0.2, 0, 0), WIDE + 0.08) - co.Cylinder((-1, 0, 0), (1, 0, 0), WIDE)
    house = co.Box((OBJECT - 0.5, -1.15, -1.1), (OBJECT, 1.15, 1.2))
    screen = co.Box((SCREEN, -1.15, -1.1), (SCREEN + 0.06, 1.15, 1.2))
    bodies = [
        co.Body(star(0.95).translate((OBJECT + 0.01, 0, AXIS)), co.glow((34, 25, 12)), "star"),
        co.Body(house.translate(up), co.matte((0.10, 0.13, 0.17))),
        co.Body(lens().translate(up), co.glass(1.6)),
        co.Body(ring.translate(up), co.matte((0.42, 0.2, 0.1))), co.Body(board.translate(up), black),
        co.Body(screen.translate(up), co.matte((0.86, 0.86, 0.86))),
        co.Body(rail, steel), co.Body(post(0, 0.55) | post(OBJECT - 0.25, 0.6) | post(SCREEN + 0.03, 0.5), steel),
        co.Body(co.Plane((0, 0, 1), 0), co.matte((0.2, 0.16, 0.13))),
        co.Body(co.Disc((-1, -5, 8), (0.1, 0.5, -1), 1.6), co.glow((3.4, 3.9, 5.0))),
    ]  # fmt: skip
    camera = co.Camera((-3.0, -8.6, 6.0), (0.1, 0, 0.75), field_of_view=37)
    return co.Scene(bodies, camera=camera, background=(0.006, 0.007, 0.01))


def picture(progress: Progress | None = None, scale: float = 1.0, samples: int = 3000) -> co.Image:
    """The picture, `scale` times its full size."""
    size = round(520 * scale), round(310 * scale)
    image = scene().render(*size, samples, "path", depth=8, filter="gaussian", noise=0.02, progress=progress)
    return image.developed(exposure=0.4, tone="filmic")


if __name__ == "__main__":
    picture().save("lens_bench.png")
