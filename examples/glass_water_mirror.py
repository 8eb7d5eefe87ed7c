"""Glass, water and mirror balls over a checked plane: refraction, inverted images, total reflection."""

from __future__ import annotations

import conicoid as co
from studio import Progress


def columns() -> list[co.Body]:
    """Columns that are visible through the balls, upside down."""
    bodies = []
    for i, color in enumerate(["#a62b2b", "#d29a35", "#2f7d5b", "#2b5f93", "#6d3a86"]):
        x, y = 2.3 * (i - 2), 5.5 - 0.35 * (i - 2) ** 2
        bodies.append(co.Body(co.Cone((x, y, 0), (x, y, 1.9), 0.4, 0.3), co.lacquer(color)))
        bodies.append(co.Body(co.Sphere(0.46, (x, y, 2.2)), co.lacquer(color)))
    return bodies


def scene() -> co.Scene:
    """Glass, mirror and water; in front a ball with a bubble of air, and a cube whose sides reflect totally."""
    glass = co.glass(absorption=(0.06, 0.02, 0.03))
    water = co.glass(co.materials.WATER, absorption=(0.16, 0.04, 0.02))
    air = co.glass(co.materials.AIR, specular=0)
    cube = co.Box((-0.45, -0.45, 0), (0.45, 0.45, 0.9)).rotate((0, 0, 1), 28).translate((-0.75, -2.15, 0))
    things = [
        co.Body(co.Sphere(1.25, (-2.1, 0.3, 1.25)), glass),
        co.Body(co.Sphere(1.1, (0.45, 1.6, 1.1)), co.mirror(0.92)),
        co.Body(co.Sphere(1.0, (2.35, -0.2, 1.0)), water),
        co.Body(co.Sphere(0.33, (0.78, -1.9, 0.62)), air, name="bubble"),
        co.Body(co.Sphere(0.6, (0.78, -1.9, 0.6)), glass),
        co.Body(cube, co.glass(absorption=(0.75, 0.2, 0.4))),
    ]
    squares = co.Checker("#f0ece2", "#3d4a57", scale=1.0, space=True)
    floor = co.Body(co.Disc((0, 0, 0), (0, 0, 1), 11), co.matte(squares))
    light = [co.AmbientLight(0.3), co.DirectionalLight((0.6, 0.75, -0.95), (0.8, 0.77, 0.72))]
    camera = co.Camera((0.3, -9.6, 4.0), (0.15, 0, 0.85), field_of_view=29)
    return co.Scene([*things, *columns(), floor], light, camera, co.Sky((0.12, 0.28, 0.58), (0.66, 0.76, 0.85)))


def picture(progress: Progress | None = None, scale: float = 1.0) -> co.Image:
    """The picture, `scale` times its full size."""
    return scene().render(round(960 * scale), round(540 * scale), samples=9, depth=12, progress=progress)


if __name__ == "__main__":
    picture().save("glass_water_mirror.png")
