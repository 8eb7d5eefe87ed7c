"""Concave polygons by even-odd, and triangles with shared edges (the ray tracing notes)."""

from __future__ import annotations

import math

import conicoid as co
from studio import ROOM, Progress, backdrop, lights

GOLDEN = (1 + math.sqrt(5)) / 2


def star(points: int, step: int, radius: float, inner: float | None = None) -> list[tuple[float, float, float]]:
    """Corners of a star in the plane y = 0; a star polygon {points / step} unless an inner radius is given."""
    if inner is None:
        turns = [(step * k / points, radius) for k in range(points)]
    else:
        turns = [(k / (2 * points), radius if k % 2 == 0 else inner) for k in range(2 * points)]
    return [(r * math.sin(2 * math.pi * turn), 0, r * math.cos(2 * math.pi * turn)) for turn, r in turns]


def icosahedron(size: float) -> list[co.Triangle]:
    """Twenty triangles; neighbours share their edges, and every ray through one meets exactly one of them."""
    corners = [(0, a, b * GOLDEN) for a in (-1, 1) for b in (-1, 1)]
    corners += [(z, x, y) for x, y, z in corners] + [(y, z, x) for x, y, z in corners]
    corners = [tuple(size * c for c in corner) for corner in corners]
    near = 2 * size * 1.001
    return [
        co.Triangle(a, b, c)
        for i, a in enumerate(corners)
        for j, b in enumerate(corners[:i])
        for c in corners[:j]
        if max(math.dist(a, b), math.dist(b, c), math.dist(c, a)) < near
    ]


def scene() -> co.Scene:
    """A concave star, a star polygon {7/3} that even-odd takes apart, and a body of triangles."""
    concave = co.Polygon(star(5, 1, 1.25, 0.52)).rotate((1, 0, 0), -14).rotate((0, 0, 1), 24)
    crossed = co.Polygon(star(7, 3, 1.2)).rotate((1, 0, 0), -12).rotate((0, 0, 1), -26)
    concave, crossed = concave.translate((-2.4, 1.3, 1.2)), crossed.translate((2.5, 0.8, 1.17))
    palette = ["#8c1d2f", "#b5472d", "#d08a2c", "#4f7d4a", "#22577a", "#4b4279", "#8d3c78"]
    gem = []
    for k, face in enumerate(icosahedron(0.5)):
        paint = co.blinn_phong(palette[3 * k % 7], specular=0.2)
        gem.append(co.Body(face.rotate((1, 1, 0), 20).translate((0.05, -0.6, 0.93)), paint))
    stars = [co.Body(concave, co.lacquer("#e0a526")), co.Body(crossed, co.lacquer("#1f5f8b"))]
    camera = co.Camera((0.2, -10.5, 3.5), (0.1, 0, 1.1), field_of_view=27)
    return co.Scene([*stars, *gem, *backdrop()], lights=lights(camera), camera=camera, background=ROOM)


def picture(progress: Progress | None = None, scale: float = 1.0) -> co.Image:
    """The picture, `scale` times its full size."""
    return scene().render(round(800 * scale), round(500 * scale), samples=9, progress=progress)


if __name__ == "__main__":
    picture().save("polygons.png")
