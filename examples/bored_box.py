"""The classic of constructive solid geometry: a cube, rounded by a sphere, with three bores."""

from __future__ import annotations

import conicoid as co
from studio import ROOM, Progress, backdrop, lights

RED, BLUE, GREEN = co.blinn_phong("#b3261e", 0.25), co.lacquer("#1f5f8b"), co.blinn_phong("#6b8f3e", 0.3)

CUBE, BALL = co.Box(), co.Sphere(1.34)
BORES = [
    co.Cylinder((-1, 0, 0), (1, 0, 0), 0.62),  # as long as the cube: their ends lie in its faces
    co.Cylinder((0, -1, 0), (0, 1, 0), 0.62),
    co.Cylinder((0, 0, -1), (0, 0, 1), 0.62),
]


def solid() -> co.Solid:
    """Each face in the colour of the solid that it comes from."""
    bores = [bore.painted(GREEN) for bore in BORES]
    return (CUBE.painted(RED) & BALL.painted(BLUE)) - bores[0] - bores[1] - bores[2]


def scene() -> co.Scene:
    """The solid, and its parts behind it."""
    parts = [
        (solid().rotate((0, 0, 1), 28).translate((0, 0, 1)), RED),
        (CUBE.rotate((0, 0, 1), 28).scale(0.5).translate((-2.2, 1.5, 0.5)), RED),
        (BALL.scale(0.5).translate((-1.95, -0.5, 0.67)), BLUE),
        ((BORES[0] | BORES[1] | BORES[2]).rotate((0, 0, 1), 28).scale(0.5).translate((2.2, 0.3, 0.5)), GREEN),
    ]
    camera = co.Camera((0.0, -9.6, 5.8), (0.0, 0.1, 0.78), field_of_view=23)
    bodies = [co.Body(shape, finish) for shape, finish in parts]
    return co.Scene([*bodies, *backdrop()], lights=lights(camera), camera=camera, background=ROOM)


def picture(progress: Progress | None = None, scale: float = 1.0) -> co.Image:
    """The picture, `scale` times its full size."""
    return scene().render(round(600 * scale), round(440 * scale), samples=9, progress=progress)


if __name__ == "__main__":
    picture().save("bored_box.png")
