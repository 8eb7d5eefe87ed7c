"""Lenses from spheres: a magnifying one is what two balls have in common, a diminishing one a disc less two balls."""

from __future__ import annotations

import math

import conicoid as co
from studio import Progress

WIDTH = 1.0  # radius of the glass
CURVE = 2.2  # radius of the balls
SAG = CURVE - math.sqrt(CURVE**2 - WIDTH**2)  # how far a ball bulges over the glass
EDGE = 0.05


def convex() -> co.Solid:
    """The two balls, apart so that the glass is 2 EDGE thick where the rim holds it; the axis is y."""
    apart = CURVE - SAG - EDGE
    balls = co.Sphere(CURVE, (0, apart, 0)) & co.Sphere(CURVE, (0, -apart, 0))
    return balls & co.Cylinder((0, -1, 0), (0, 1, 0), WIDTH)


def concave() -> co.Solid:
    """A disc, from which two balls are taken."""
    apart = CURVE + EDGE
    disc = co.Cylinder((0, -SAG - EDGE, 0), (0, SAG + EDGE, 0), WIDTH)
    return disc - co.Sphere(CURVE, (0, apart, 0)) - co.Sphere(CURVE, (0, -apart, 0))


def mounted(glass: co.Solid, depth: float) -> list[co.Body]:
    """A lens in a brass rim on a foot; they abut, the rim's bore being the edge of the glass."""
    lens = co.glass(absorption=(0.1, 0.03, 0.06), specular=0.9)
    brass = co.metal("#d8a657", reflectivity=0.6)
    tube = co.Cylinder((0, -depth, 0), (0, depth, 0), WIDTH)
    rim = co.Cylinder((0, -depth, 0), (0, depth, 0), WIDTH + 0.07) - tube
    post = co.Cylinder((0, 0, -1.6), (0, 0, -WIDTH), 0.055) - tube
    foot = co.Ellipsoid((0.52, 0.52, 0.16), (0, 0, -1.65), z_range=(0, 1)) | co.Sphere(0.1, (0, 0, -1.2))
    return [
        co.Body(part.translate((0, 0, 1.65)), finish) for part, finish in ((glass, lens), (rim | post | foot, brass))
    ]


def scene() -> co.Scene:
    """Both before a checked wall, nearer than the focal length of the one: it shows it upright and enlarged."""
    bodies = [
        co.Body(body.shape.rotate((0, 0, 1), turn).translate((x, 0, 0)), body.material)
        for glass, depth, x, turn in ((convex(), 0.1, -1.3, -8), (concave(), SAG + EDGE, 1.3, 8))
        for body in mounted(glass, depth)
    ]
    tiles = co.matte(co.Checker("#f0ece2", "#2b5f93", scale=0.3, space=True))
    wall = co.Body(co.Plane((0, -1, 0), -0.75), tiles)
    floor = co.Body(co.Plane((0, 0, 1), 0), co.lacquer("#6b4a35", reflectivity=0.02))
    light = [co.AmbientLight(0.45), co.PointLight((-4, -8, 13), (0.8, 0.78, 0.73))]
    camera = co.Camera((0, -12, 2.6), (0, 0, 1.42), field_of_view=18)
    return co.Scene([*bodies, wall, floor], light, camera, (0.7, 0.7, 0.7))


def picture(progress: Progress | None = None, scale: float = 1.0) -> co.Image:
    """The picture, `scale` times its full size."""
    return scene().render(round(570 * scale), round(380 * scale), samples=9, depth=8, progress=progress)


if __name__ == "__main__":
    picture().save("lenses.png")
