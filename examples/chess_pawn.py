"""A chess pawn, turned from quadrics of revolution: sphere, cones, hyperboloid, ellipsoids, cylinder."""

from __future__ import annotations

import conicoid as co
from studio import ROOM, Progress, backdrop, lights

THICK = 0.3  # of the board


def pawn() -> co.Solid:
    """A pawn that stands on z = 0, 1 wide and 1.55 high."""
    foot = co.Cylinder((0, 0, 0), (0, 0, 0.1), 0.5) - co.Cone((0, 0, 0), (0, 0, 0.03), 0.4, 0.37)
    bulge = co.Ellipsoid((0.5, 0.5, 0.11), (0, 0, 0.1), z_range=(0, 1))
    step = co.Cylinder((0, 0, 0.15), (0, 0, 0.24), 0.37)
    skirt = co.Ellipsoid((0.37, 0.37, 0.2), (0, 0, 0.24), z_range=(0, 1))
    # The neck: r² = 0.125² (1 + (z / 0.27)²) about its narrowest place
    neck = co.OneSheetHyperboloid(0.125**-2, 0.125**-2, 0.27**-2, z_range=(-0.62, 0.16)).translate((0, 0, 0.9))
    collar = co.Ellipsoid((0.29, 0.29, 0.055), (0, 0, 1.07)) | co.Cone((0, 0, 1.06), (0, 0, 1.15), 0.24, 0.14)
    head = co.Sphere(0.24, (0, 0, 1.31))
    return foot | bulge | step | skirt | neck | collar | head


def scene() -> co.Scene:
    """A black pawn that may take a white one, on a polished board."""
    ivory = co.lacquer("#e8d9b5", reflectivity=0.05)
    ebony = co.lacquer("#26201d", reflectivity=0.05)
    board = co.lacquer(co.Checker("#c9a06a", "#5a3a26", scale=1.15, space=True), specular=0.3, reflectivity=0.05)
    side = 1.15
    places = [(side * (x + 0.5), side * 1.5, ivory) for x in (-3, -2, -1, 1, 2)]
    places += [(0.5 * side, 0.5 * side, ivory), (-0.5 * side, -0.5 * side, ebony)]
    shape = pawn()
    bodies = [co.Body(shape.translate((x, y, THICK)), finish) for x, y, finish in places]
    top = co.Body(co.Box((-4 * side, -side, 0), (4 * side, 7 * side, THICK)), board)
    camera = co.Camera((-1.5, -8.9, 4.0), (0.05, 0.45, 0.86), field_of_view=22)
    return co.Scene([*bodies, top, *backdrop(wall=16)], lights=lights(camera), camera=camera, background=ROOM)


def picture(progress: Progress | None = None, scale: float = 1.0) -> co.Image:
    """The picture, `scale` times its full size."""
    return scene().render(round(600 * scale), round(440 * scale), samples=9, progress=progress)


if __name__ == "__main__":
    picture().save("chess_pawn.png")
