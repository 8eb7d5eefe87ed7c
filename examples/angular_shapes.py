"""Shapes with ranges of angles, stacks of cones, and solids of flat faces, with their uv as checkers."""

from __future__ import annotations

import conicoid as co
from studio import ROOM, Progress, backdrop, lights

ROWS = [
    [
        co.SphereSection(1, 0.75, (25, 120), -40, 215, (0, 0, 0.5)),
        co.SphereSection(1, 0.5, (0, 125), -55, 245, (0, 0, 0.58)),
        co.Polycone([(0, 0.3, 1), (0.3, 0.3, 1), (0.3, 0.3, 0.6), (1.2, 0.3, 0.6), (1.7, 0.8, 0.9)], -10, 250),
        co.Tube((0, 0, 0), (0, 0, 1.6), 0.6, 0.95, -40, 215, (1, 0, 0)),
        co.Cone((0, 0, 0), (0, 0, 1.8), 1, 0.2, -30, 240, (1, 0, 0)),
    ],
    [
        co.Trapezoid((2, 1.6), (1, 1.2), (0, 1.3), (0.2, 0.1)).rotate("z", 25),
        co.Wedge(1.8, 1.6, 1.3, 0.9, 0.3).rotate("z", -30),
        co.RegularPrism(6, 0.95, (0, 1.2), 10),
        co.Pyramid(5, 1, (0, 1.6), 0.2, -60),
        co.Parallelepiped((-0.8, -0.7, 0), (1.3, 0, 0), (0.3, 1.2, 0), (0.3, 0.2, 1.2)).rotate("z", 20),
    ],
]
COLORS = ["#b3261e", "#1f5f8b", "#6b8f3e", "#c98a1b", "#6d4c8d"]


def scene() -> co.Scene:
    """Two rows: round solids, and flat ones behind them."""
    bodies = []
    for row, shapes in enumerate(ROWS):
        for place, (shape, color) in enumerate(zip(shapes, COLORS, strict=True)):
            paint = co.blinn_phong(co.Checker(color, "#efe9dd", 0.125), 0.25)
            bodies.append(co.Body(shape.translate((2.5 * (place - 2), 3.7 * row, 0)), paint))
    camera = co.Camera((0.0, -14.0, 12.0), (0.0, 1.75, 0.3), field_of_view=22)
    return co.Scene([*bodies, *backdrop()], lights=lights(camera), camera=camera, background=ROOM)


def picture(progress: Progress | None = None, scale: float = 1.0) -> co.Image:
    """The picture, `scale` times its full size."""
    return scene().render(round(840 * scale), round(400 * scale), samples=9, progress=progress)


if __name__ == "__main__":
    picture().save("angular_shapes.png")
