"""What two and what three crossed cylinders have in common (Archimedes, Steinmetz): 16/3 and 8 (2 - √2) radii cubed."""

from __future__ import annotations

import conicoid as co
from studio import ROOM, Progress, backdrop, lights

COLORS = ("#c2622d", "#2b5f93", "#e0a526")


def crossed(count: int) -> list[co.Solid]:
    """`count` cylinders of radius 1 along the axes, each painted in its colour."""
    rods = [co.Cylinder((-1.6, 0, 0), (1.6, 0, 0), 1), co.Cylinder((0, -1.6, 0), (0, 1.6, 0), 1)]
    rods += [co.Cylinder((0, 0, -1.6), (0, 0, 1.6), 1)]
    return [rod.painted(co.blinn_phong(color, 0.4)) for rod, color in zip(rods[:count], COLORS, strict=False)]


def scene() -> co.Scene:
    """Their common part in front, and the cylinders themselves behind it."""
    bodies = []
    for count, x in ((2, -1.35), (3, 1.35)):
        rods = [rod.rotate((0, 0, 1), 35) for rod in crossed(count)]
        bodies.append(co.Intersection(rods).translate((x, -0.6, 1)))
        lift = 0.45 if count == 2 else 0.72
        bodies.append(co.Union(rods).scale(0.45).translate((1.35 * x, 3.3, lift)))
    camera = co.Camera((0, -10.2, 8.2), (0, 0.75, 0.75), field_of_view=25)
    return co.Scene([*bodies, *backdrop()], lights=lights(camera), camera=camera, background=ROOM)


def picture(progress: Progress | None = None, scale: float = 1.0) -> co.Image:
    """The picture, `scale` times its full size."""
    return scene().render(round(600 * scale), round(440 * scale), samples=9, progress=progress)


if __name__ == "__main__":
    picture().save("steinmetz.png")
