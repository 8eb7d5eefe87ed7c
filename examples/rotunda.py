"""A room of curved solids: a dome with an eye, columns, niches, a hyperboloid and a ball, lit through the eye alone."""

from __future__ import annotations

import conicoid as co
from studio import Progress

RADIUS = 5.0
HEIGHT = 4.6


def columns(count: int = 12) -> co.Solid:
    """A ring of columns that are thicker in the middle, on round feet, under round heads."""
    shaft = co.Ellipsoid((0.3, 0.3, 7.0), (0, 0, 1.6), z_range=(-1.4, 2.1))
    foot = co.Cylinder((0, 0, 0), (0, 0, 0.2), 0.44)
    head = co.Cone((0, 0, 3.6), (0, 0, 3.9), 0.3, 0.5) | co.Cylinder((0, 0, 3.9), (0, 0, 4.0), 0.52)
    one = shaft | foot | head
    turned = [one.translate((3.9, 0, 0)).rotate("z", 360 * (k + 0.5) / count) for k in range(count)]
    return co.Union(turned)


def scene() -> co.Scene:
    """A drum and half a ball over it, hollow, with twelve niches; the light comes from above."""
    wall = 0.6
    drum = co.Cylinder((0, 0, -0.2), (0, 0, HEIGHT), RADIUS + wall) - co.Cylinder((0, 0, 0), (0, 0, 9), RADIUS)
    shells = co.Sphere(RADIUS + wall, (0, 0, HEIGHT)) - co.Sphere(RADIUS, (0, 0, HEIGHT))
    dome = shells - co.HalfSpace((0, 0, 1), HEIGHT)
    eye = co.Cylinder((0, 0, 6), (0, 0, 13), 1.15)
    ring = co.Cylinder((0, 0, 4.0), (0, 0, 4.35), 4.45) - co.Cylinder((0, 0, 3), (0, 0, 5), 3.4)
    niches = co.Union([co.Ellipsoid((0.5, 0.75, 1.5), (RADIUS, 0, 2.1)).rotate("z", 30 * k) for k in range(12)])
    shell = ((drum | dome) - eye) - niches
    plaster, stone = co.matte((0.78, 0.72, 0.62)), co.matte((0.7, 0.67, 0.62))
    floor = co.plastic(co.Checker((0.52, 0.44, 0.36), (0.2, 0.17, 0.16), scale=1.0, space=True), roughness=0.18)
    waist = co.OneSheetHyperboloid(9, 9, 2.2, z_range=(-0.5, 0.5)).translate((0, 0, 0.5))
    bodies = [
        co.Body(shell, plaster), co.Body(columns(), stone), co.Body(ring, stone),
        co.Body(co.Cylinder((0, 0, 0), (0, 0, 0.004), RADIUS), floor),
        co.Body(waist, co.matte((0.35, 0.34, 0.33))),
        co.Body(co.Sphere(0.62, (0, 0, 1.6)), co.materials.gold(roughness=0.12)),
    ]  # fmt: skip
    bodies.append(co.Body(co.Disc((0, 0, HEIGHT + RADIUS - 0.2), (0, 0, 1), 1.3), co.glow((34, 36, 40))))
    camera = co.Camera((0.35, -3.3, 1.5), (-0.1, 0.6, 2.9), field_of_view=88)
    return co.Scene(bodies, camera=camera, background=(0.0, 0.0, 0.0))


def picture(progress: Progress | None = None, scale: float = 1.0, samples: int = 80) -> co.Image:
    """The picture, `scale` times its full size."""
    size = round(400 * scale), round(400 * scale)
    image = scene().render(*size, samples, "path", depth=8, filter="gaussian", progress=progress)
    return image.developed(exposure=-0.1, tone="filmic")


if __name__ == "__main__":
    picture().save("rotunda.png")
