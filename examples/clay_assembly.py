"""The fuel assembly of OpenMC's XML as a model of clay, cut open, under an even sky and a soft lamp."""

from __future__ import annotations

from pathlib import Path

import conicoid as co
from conicoid.io import openmc
from studio import Progress

ASSEMBLY = Path(__file__).with_name("openmc") / "assembly" / "geometry.xml"
WATER = 3
LEVEL = 352.0


def scene() -> co.Scene:
    """All but the water, cut by a slanted plane; fuel is of darker clay."""
    assembly = openmc.read(ASSEMBLY, void=False)
    colors = {entry.material: entry.color for entry in assembly.legend}
    bottom, slope = co.HalfSpace((0, 0, -1), -LEVEL + 5), co.HalfSpace((0.5, -1.0, 1), LEVEL + 17)
    pale, dark = co.matte((0.72, 0.62, 0.53)), co.matte((0.46, 0.22, 0.14))
    bodies = []
    for body in assembly.bodies:
        if body.material.color == colors[WATER]:
            continue
        clay = dark if body.material.color == colors[1] else pale
        bodies.append(co.Body((body.shape & bottom & slope).translate((0, 0, -LEVEL)), clay, body.name))
    floor = co.Body(co.Plane((0, 0, 1), -5), co.matte((0.62, 0.58, 0.54)))
    lamp = co.Body(co.Disc((-26, -30, 62), (0.5, 0.6, -1.2), 13), co.glow((20, 18.2, 15.6)))
    camera = co.Camera((24, -44, 36), (1.6, 0.6, 8.8), field_of_view=39)
    return co.Scene([*bodies, floor, lamp], camera=camera, background=co.Sky((0.16, 0.19, 0.25), (0.2, 0.2, 0.21)))


def picture(progress: Progress | None = None, scale: float = 1.0, samples: int = 64) -> co.Image:
    """The picture, `scale` times its full size."""
    size = round(480 * scale), round(384 * scale)
    image = scene().render(*size, samples, "path", depth=5, filter="gaussian", progress=progress)
    return image.developed(exposure=0.9, tone="filmic")


if __name__ == "__main__":
    picture().save("clay_assembly.png")
