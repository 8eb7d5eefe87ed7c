"""A fuel assembly of a pressurised-water reactor, read from OpenMC's XML, coloured by material and cut open.

Every rod is cut by one slanted plane, in front through the fuel, at the back through the empty plenum over
it; the water is cut off lower, like a level. The geometry stands in openmc/assembly, with dimensions in cm.
"""

from __future__ import annotations

from pathlib import Path

import conicoid as co
from conicoid.io import openmc
from studio import ROOM, Progress

ASSEMBLY = Path(__file__).with_name("openmc") / "assembly" / "geometry.xml"
WATER = 3
LEVEL = 352.0
"""Height of the water; the fuel ends at 365.76, the rods end at 384.2."""


def scene() -> co.Scene:
    """The upper part of the assembly without the parts that the cutters take away, the water's level at z = 0."""
    assembly = openmc.read(ASSEMBLY, void=False)
    water = next(entry.color for entry in assembly.legend if entry.material == WATER)
    bottom = co.HalfSpace((0, 0, -1), -LEVEL + 4)
    below = co.HalfSpace((0, 0, 1), LEVEL)
    slope = co.HalfSpace((0.45, -0.9, 1), LEVEL + 16)
    bodies = []
    for body in assembly.bodies:
        color = body.material.color
        finish = co.matte(color) if color == water else co.blinn_phong(color, specular=0.25, shininess=60)
        shape = body.shape & bottom & (below if color == water else slope)
        bodies.append(co.Body(shape.translate((0, 0, -LEVEL)), finish, body.name))
    floor = co.Body(co.Plane((0, 0, 1), -4), co.matte("#e9e6e1"))
    camera = co.Camera((24, -52, 60), (1.9, 1.5, 11.2), field_of_view=35)
    lights = [
        co.AmbientLight((0.26, 0.27, 0.29)),
        co.DirectionalLight((0.75, 0.6, -1), (0.72, 0.7, 0.66)),
        co.PointLight(camera.position, (0.2, 0.21, 0.23)),
    ]
    return co.Scene([*bodies, floor], lights=lights, camera=camera, background=ROOM)


def picture(progress: Progress | None = None, scale: float = 1.0) -> co.Image:
    """The picture, `scale` times its full size."""
    return scene().render(round(880 * scale), round(700 * scale), samples=4, progress=progress)


if __name__ == "__main__":
    picture().save("reactor_pin.png")
