"""Glass, water and mirror balls over a checked plane: refraction, the inverted image, total internal reflection (seed 000)."""

from __future__ import annotations

import conicoid as co


def columns() -> list[co.Body]:
    """Something to be seen through the balls, and upside down."""
    colors = ["#a62b2b", "#d29a35", "#2f7d5b", "#2b5f93", "#6d3a86"]
    bodies = []
    for i, color in enumerate(colors):
        x = 2.6 * (i - 2)
        bodies.append(co.Body(co.Cone((x, 7, 0), (x, 7, 3.2), 0.42, 0.34), co.lacquer(color)))
        bodies.append(co.Body(co.Sphere(0.5, (x, 7, 3.6)), co.lacquer(color)))
    return bodies


def scene() -> co.Scene:
    """Three balls, a prism that turns what is beside it by total reflection, and a drop with an air bubble."""
    clear = co.glass(absorption=(0.05, 0.02, 0.03))
    water = co.glass(co.WATER, absorption=(0.12, 0.03, 0.015))
    prism = co.Polyhedron([(0, -1, 0), (0, 0, -1), (0, 1, 1), (1, 0, 0), (-1, 0, 0)], [0, 0, 0.9, 0.75, 0.75])
    balls = [
        co.Body(co.Sphere(1.25, (-2.15, 0.4, 1.25)), clear),
        co.Body(co.Sphere(1.05, (0.75, 1.9, 1.05)), co.mirror(0.92)),
        co.Body(co.Sphere(0.95, (2.35, -0.45, 0.95)), water),
        co.Body(co.Sphere(0.28, (0.55, -1.75, 0.3)), co.glass(1.0, specular=0)),
        co.Body(co.Sphere(0.52, (0.5, -1.7, 0.52)), clear),
        co.Body(prism.rotate((0, 0, 1), 155).translate((-0.35, -0.9, 0)), clear),
    ]
    floor = co.Body(co.Plane((0, 0, 1), 0), co.matte(co.Checker("#f0ece2", "#3d4a57", scale=1.0, space=True)))
    light = [co.AmbientLight(0.3), co.DirectionalLight((0.55, 0.75, -0.9), (0.8, 0.77, 0.72))]
    camera = co.Camera((0.2, -8.6, 3.0), (0.1, 0, 0.95), field_of_view=34)
    return co.Scene([*balls, *columns(), floor], light, camera, co.Sky((0.18, 0.36, 0.68), (0.86, 0.9, 0.94)))


def picture(progress: object = None) -> co.Image:
    return scene().render(960, 540, samples=9, depth=12, progress=progress)


if __name__ == "__main__":
    picture().save("glass_water_mirror.png")
