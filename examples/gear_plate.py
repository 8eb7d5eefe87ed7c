"""A gear with 324 bores: one Boolean of some seven hundred solids."""

from __future__ import annotations

import math

import conicoid as co
from studio import ROOM, Progress, backdrop, lights

THICK = 0.1  # half of the plate's thickness
TEETH, ROOT, TIP = 48, 2.74, 3.0
RINGS, HOLES = 9, 36  # each ring is turned by half a step, and its bores are larger by the same factor
FIRST, LAST = 1.06, 2.42


def gap() -> co.Solid:
    """The gap between two teeth, a wedge about +x: |y| <= 0.06 + 0.3 (x - ROOT)."""
    floor = ((-1, 0, 0), -ROOT)
    flanks = [((-0.3, y, 0), 0.06 - 0.3 * ROOT) for y in (-1, 1)]
    ends = [((1, 0, 0), 4.0), ((0, 0, 1), THICK), ((0, 0, -1), THICK)]
    normals, offsets = zip(floor, *flanks, *ends, strict=True)
    return co.Polyhedron(normals, offsets)


def bore(radius: float) -> co.Solid:
    """A hole through the plate, countersunk in front; it ends in the plate's own faces."""
    sink = 0.25 * radius
    hole = co.Cylinder((0, 0, -THICK), (0, 0, THICK), radius)
    return hole | co.Cone((0, 0, THICK - sink), (0, 0, THICK), radius, radius + sink)


def gear() -> co.Solid:
    """The gear about the z axis."""
    copper, dark = co.blinn_phong("#d8722c", specular=0.4), co.blinn_phong("#5f666e", specular=0.4)
    disc = co.Cylinder((0, 0, -THICK), (0, 0, THICK), TIP)
    hub = co.Cylinder((0, 0, -3 * THICK), (0, 0, 3 * THICK), 0.78)
    shaft = co.Cylinder((0, 0, -1), (0, 0, 1), 0.42) | co.Box((0.3, -0.11, -1), (0.56, 0.11, 1))
    cutters = [shaft.painted(copper)]
    cutters += [gap().rotate((0, 0, 1), 360 * k / TEETH).painted(dark) for k in range(TEETH)]
    for ring in range(RINGS):
        distance = FIRST * (LAST / FIRST) ** (ring / (RINGS - 1))
        hole = bore(0.046 * distance).translate((distance, 0, 0)).painted(copper)
        cutters += [hole.rotate((0, 0, 1), 360 * (k + ring / 2) / HOLES) for k in range(HOLES)]
    return co.Difference((disc | hub, *cutters))


def scene() -> co.Scene:
    """The gear on its teeth, and its shadow."""
    steel = co.blinn_phong("#aeb6be", specular=0.5, shininess=60, reflectivity=0.12)
    lowest = TIP * math.cos(math.radians(7))
    standing = gear().rotate((1, 0, 0), 83).rotate((0, 0, 1), -30).translate((-1.2, 0, lowest))
    camera = co.Camera((0.3, -16, 5.6), (0.45, 0, 2.72), field_of_view=25.5)
    return co.Scene([co.Body(standing, steel), *backdrop()], lights=lights(camera), camera=camera, background=ROOM)


def picture(progress: Progress | None = None, scale: float = 1.0) -> co.Image:
    """The picture, `scale` times its full size."""
    return scene().render(round(600 * scale), round(440 * scale), samples=9, progress=progress)


if __name__ == "__main__":
    picture().save("gear_plate.png")
