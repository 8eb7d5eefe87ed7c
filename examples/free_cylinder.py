"""The closed cylinder in free orientation: three of them, each with its axis.

CILIND in the graphics textbook (docs/theory.md), figure 3.2.3.
"""

from __future__ import annotations

import numpy as np

import conicoid as co
from studio import ROOM, Progress, backdrop, lights


def pierced(start: tuple[float, ...], end: tuple[float, ...], radius: float, color: str, stripes: int) -> list[co.Body]:
    """A closed cylinder with white stripes, and a thin rod along its axis that shows how it stands in space.

    The stripes are slices of the cylinder itself: they share its surface, and where bodies coincide the one
    listed first is seen.
    """
    a, b = np.array(start), np.array(end)
    along = (b - a) / np.linalg.norm(b - a)
    steel = co.metal("#b9bec4", reflectivity=0.8)
    rod = co.Cylinder(a - 0.6 * along, b + 0.6 * along, 0.035)
    tip = co.Cone(b + 0.6 * along, b + 0.85 * along, 0.1, 0)
    cylinder = co.Cylinder(start, end, radius)
    cuts = along @ a + np.linspace(0, np.linalg.norm(b - a), 2 * stripes + 2)[1:-1]
    rings = [cylinder & co.HalfSpace(along, high) & co.HalfSpace(-along, -low) for low, high in cuts.reshape(-1, 2)]
    return [
        *(co.Body(ring, co.lacquer("#ece7da")) for ring in rings),
        co.Body(cylinder, co.lacquer(color)),
        co.Body(rod, steel),
        co.Body(tip, steel),
    ]


def scene() -> co.Scene:
    """A big one that points up and to the right, and two small ones."""
    bodies = [
        *pierced((-1.2, 0.9, 1.15), (0.9, -0.3, 2.5), 0.85, "#b3261e", 3),
        *pierced((1.7, 0.2, 0.55), (3.0, 1.0, 0.95), 0.42, "#1f5f8b", 1),
        *pierced((-2.6, -0.9, 0.6), (-1.4, -1.8, 0.45), 0.36, "#e0a526", 1),
    ]
    camera = co.Camera((0.5, -11, 4.2), (0.15, 0, 1.35), field_of_view=26)
    return co.Scene([*bodies, *backdrop()], lights=lights(camera), camera=camera, background=ROOM)


def picture(progress: Progress | None = None, scale: float = 1.0) -> co.Image:
    """The picture, `scale` times its full size."""
    return scene().render(round(800 * scale), round(560 * scale), samples=9, progress=progress)


if __name__ == "__main__":
    picture().save("free_cylinder.png")
