"""The closed cylinder in free orientation (seed 004, CILIND and figure 3.2.3), here three that lean on each other's rods."""

from __future__ import annotations

import numpy as np

import conicoid as co
from studio import ROOM, backdrop, lights


def pierced(start: tuple[float, ...], end: tuple[float, ...], radius: float, finish: co.Material) -> list[co.Body]:
    """A closed cylinder, and a thin rod along its axis that shows how it stands in space."""
    a, b = np.array(start), np.array(end)
    along = (b - a) / np.linalg.norm(b - a)
    rod = co.Cylinder(tuple(a - 0.6 * along), tuple(b + 0.6 * along), 0.035)
    tip = co.Cone(tuple(b + 0.6 * along), tuple(b + 0.85 * along), 0.1, 0)
    steel = co.metal("#b9bec4", reflectivity=0.5)
    return [co.Body(co.Cylinder(start, end, radius), finish), co.Body(rod, steel), co.Body(tip, steel)]


def scene() -> co.Scene:
    """A big one that points up and to the right, and two small ones."""
    bands = co.Material(
        co.Checker("#d8452f", "#e8e2d6", scale=(1 / 12, 0.25)), specular=0.6, shininess=200, reflectivity=0.04, fresnel=True
    )
    bodies = [
        *pierced((-1.2, 0.9, 1.15), (0.9, -0.3, 2.5), 0.85, bands),
        *pierced((1.7, 0.2, 0.5), (3.0, 1.0, 0.85), 0.42, co.lacquer("#205a84")),
        *pierced((-2.6, -1.0, 0.55), (-1.5, -1.7, 0.6), 0.36, co.lacquer("#dca32a")),
    ]
    camera = co.Camera((0.5, -11, 4.2), (0.1, 0, 1.45), field_of_view=27)
    return co.Scene([*bodies, *backdrop()], lights=lights(), camera=camera, background=ROOM)


def picture(progress: object = None) -> co.Image:
    return scene().render(800, 560, samples=9, progress=progress)


if __name__ == "__main__":
    picture().save("free_cylinder.png")
