"""The cylinder given by two axis points, a reference point and a radius, from a start to an end angle (Sasaki 2021)."""

from __future__ import annotations

import conicoid as co
from studio import ROOM, Progress, backdrop, lights


def scene() -> co.Scene:
    """An open patch of 250°, its axis and reference point, and a closed wedge of the same kind."""
    p1, p2, p3 = (-1.7, 0.2, 1.35), (1.5, 0.9, 1.75), (-1.9, -1.2, 1.35)
    squares = co.Checker("#1d5c86", "#f1ebdd", scale=(1 / 24, 1 / 8))
    patch = co.Body(
        co.CylinderPatch(p1, p2, 1.25, 60, 310, reference=p3), co.blinn_phong(squares, specular=0.4, shininess=120)
    )
    brass = co.metal("#d9a64a")
    axis = co.Body(co.Cylinder(p1, p2, 0.035), brass)
    points = [co.Body(co.Sphere(0.085, p), brass) for p in (p1, p2)]
    mark = co.Body(co.Sphere(0.085, p3), co.lacquer("#b3131b"))
    arm = co.Body(co.Cylinder(p1, p3, 0.022), brass)
    sector = co.Cylinder((3.5, 0.2, 0), (3.5, 0.2, 1.1), 0.95, -160, 120, reference=(3.5, -2, 0))
    wedge = co.Body(sector, co.lacquer("#c4572b"))
    camera = co.Camera((-3.0, -11.5, 4.6), (0.75, 0, 1.2), field_of_view=23)
    return co.Scene([patch, axis, arm, *points, mark, wedge, *backdrop()], lights(camera), camera, ROOM)


def picture(progress: Progress | None = None, scale: float = 1.0) -> co.Image:
    """The picture, `scale` times its full size."""
    return scene().render(round(800 * scale), round(520 * scale), samples=9, progress=progress)


if __name__ == "__main__":
    picture().save("cylinder_patch.png")
