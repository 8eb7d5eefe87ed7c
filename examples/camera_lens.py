"""A double Gauss lens from its prescription, cut open, with three beams: on the axis, and 10 and 14 degrees off it.

Its six elements are in two cemented pairs and two singles. The lens is the sample that CODE V and Zemax come with.
"""

from __future__ import annotations

import math

import numpy as np

import conicoid as co
from studio import Progress

INF, STOP = math.inf, 16.4
ROWS = [  # radius, thickness, refractive index at the helium line d, diameter
    (56.20238, 8.75, 1.622292, 66), (152.2858, 0.5, 1, 63), (37.68262, 12.5, 1.607379, 54), (INF, 3.8, 1.603417, 51),
    (24.2313, 16.369445, 1, 37), dict(thickness=13.747957, diameter=STOP, stop=True),
    (-28.37731, 3.8, 1.603417, 36), (INF, 11, 1.620408, 44), (-37.92546, 0.5, 1, 46), (177.41176, 7, 1.620408, 50),
    (-79.41143, 61.487536, 1, 50),
]  # fmt: skip
GLASSES = {1.622292: "#8fc1e3", 1.607379: "#5a9bd0", 1.603417: "#e0b060", 1.620408: "#7fbf9b"}
BEAMS = ("#c2402f", "#2f7d3b", "#4a4fb5")
FIELDS = (0, 10, 14)


def lens() -> co.optics.Prescription:
    """The lens, open to f / 4."""
    return co.optics.prescription(ROWS, 25, fields=FIELDS, name="double Gauss, f = 100")


def beams(system: co.optics.Prescription, radius: float = 0.25) -> list[co.Body]:
    """Five rays of each field as thin rods, from 30 in front of the lens to the image."""
    pupil = np.column_stack([np.zeros(5), np.linspace(-1, 1, 5)])
    rods = []
    for field, colour in zip(system.fields, BEAMS, strict=True):
        found = co.optics.trace(system, co.optics.beam(system, field, pupil=pupil))
        corners = np.concatenate([found.points, found.at(system.image)[None]])
        first = (-30 - corners[0, :, 2:]) / (corners[1, :, 2:] - corners[0, :, 2:])
        corners[0] += first * (corners[1] - corners[0])
        for ray in np.flatnonzero(found.arrived):
            rods += [
                co.Body(co.Cylinder(a, b, radius), colour)
                for a, b in zip(corners[:-1, ray], corners[1:, ray], strict=True)
            ]
    return rods


def scene() -> co.Scene:
    """Half of each element, seen from the side, and a screen in the image plane."""
    system = lens()
    half = co.HalfSpace((-1, 0, 0), 0)
    glass = [
        co.Body(body.shape & half, co.lacquer(GLASSES[body.material.refractive_index], reflectivity=0.04))
        for body in system.bodies
        if body.name != "stop"
    ]
    ring = co.Cylinder((0, 0, -0.4), (0, 0, 0.4), 26) - co.Cylinder((0, 0, -1), (0, 0, 1), STOP / 2)
    stop = co.Body(ring.translate((0, 0, system.vertices[5])) & half, "#303438")
    screen = co.Body(co.Box((0, -30, system.image), (30, 30, system.image + 1.2)), "#d8d4cb")
    lights = [co.AmbientLight(0.42), co.PointLight((-320, 260, -60), 0.62)]
    camera = co.Camera((-420, 60, 40), (0, 0, 55), up=(0, 1, 0), field_of_view=13)
    return co.Scene([*glass, stop, screen, *beams(system)], lights, camera, "white")


def picture(progress: Progress | None = None, scale: float = 1.0) -> co.Image:
    """The picture, `scale` times its full size."""
    return scene().render(round(640 * scale), round(330 * scale), samples=9, progress=progress)


if __name__ == "__main__":
    system = lens()
    print(co.optics.cardinal_points(system))
    for field in FIELDS:
        print(co.optics.spot(system, field))
    co.optics.layout(system, rays=7).save("camera_lens.svg")
    picture().save("camera_lens.png")
