"""Shining balls and a barrel: the truncated ellipsoid.

ALLIPS and ALLOID in the graphics textbook (docs/theory.md), figure 3.2.2.
"""

from __future__ import annotations

import conicoid as co
from studio import ROOM, Progress, backdrop, lights


def barrel() -> list[co.Body]:
    """An ellipsoid cut by two planes, with staves on uv, a sunk lid, and four hoops."""
    staves = co.blinn_phong(co.Checker("#a5672f", "#8f5526", scale=(1 / 28, 2)), specular=0.15, shininess=40)
    planks = co.blinn_phong(co.Checker("#94602f", "#85542a", scale=(0.3, 9)), specular=0.15, shininess=40)
    iron = co.metal("#8d9297", shininess=80, reflectivity=0.6)
    side = co.Ellipsoid((1.05, 1.05, 2.1), z_range=(-1.25, 1.25)) - co.Cylinder((0, 0, 1.13), (0, 0, 2), 0.74)
    hoops = [
        co.Ellipsoid((1.075, 1.075, 2.15), z_range=(z, z + 0.13)) - co.Ellipsoid((1.04, 1.04, 2.08))
        for z in (-1.2, -0.7, 0.57, 1.07)
    ]
    lid = co.Cylinder((0, 0, 1.05), (0, 0, 1.13), 0.74)
    rim = side & co.HalfSpace((0, 0, -1), -1.21)
    parts = [(lid, planks), (rim, co.matte("#8a5829")), (side, staves), *((hoop, iron) for hoop in hoops)]
    return [co.Body(part.translate((0, 0, 1.25)), finish) for part, finish in parts]


def scene() -> co.Scene:
    """The barrel among balls of many finishes."""
    balls = [
        (0.95, (2.25, 0.5), co.lacquer("#b3131b")),
        (0.62, (1.1, -1.35), co.lacquer("#e0a526")),
        (0.48, (-1.75, -1.2), co.lacquer("#1f5f8b")),
        (0.3, (0.05, -1.75), co.mirror(0.9)),
        (0.36, (2.75, -1.15), co.metal("#d8a657")),
        (0.7, (-2.3, 0.9), co.lacquer("#2e6e4e")),
        (0.22, (-0.75, -2.1), co.lacquer("#6d2a5c")),
    ]
    bodies = [co.Body(co.Sphere(r, (x, y, r)), finish) for r, (x, y), finish in balls]
    camera = co.Camera((0.4, -10.3, 4.7), (0.25, 0, 1.0), field_of_view=26)
    return co.Scene([*barrel(), *bodies, *backdrop()], lights=lights(camera), camera=camera, background=ROOM)


def picture(progress: Progress | None = None, scale: float = 1.0) -> co.Image:
    """The picture, `scale` times its full size."""
    return scene().render(round(880 * scale), round(560 * scale), samples=9, progress=progress)


if __name__ == "__main__":
    picture().save("balls_and_barrel.png")
