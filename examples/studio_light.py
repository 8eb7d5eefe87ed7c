"""Gold, copper and glass quadrics under a round studio lamp and a long one, by light transport."""

from __future__ import annotations

import conicoid as co
from studio import Progress, backdrop


def scene() -> co.Scene:
    """A hyperboloid of gold, a paraboloid of glass, a cone of copper, a ball of silver, an egg of porcelain."""
    waist = co.OneSheetHyperboloid(4.2, 4.2, 1.2, z_range=(-1.05, 1.05)).translate((-1.55, 0.4, 1.05))
    bowl = co.EllipticParaboloid(1.3, 1.3, z_range=(0.02, 1.1))
    bowl = bowl - co.EllipticParaboloid(1.3, 1.3).translate((0, 0, 0.09))
    stem = co.Cylinder((0, 0, -0.55), (0, 0, 0.1), 0.09) | co.Cylinder((0, 0, -0.62), (0, 0, -0.55), 0.5)
    cup = (bowl | stem).translate((0.35, -0.35, 0.62))
    cone = co.Cone((0, 0, 0), (0, 0, 1.5), 0.62, 0.0).translate((2.0, 0.9, 0))
    bodies = [
        *backdrop("#a8a29c", wall=7),
        co.Body(waist, co.materials.gold(roughness=0.2)),
        co.Body(cup, co.glass(1.52, absorption=(0.25, 0.06, 0.12))),
        co.Body(cone, co.materials.copper(roughness=0.3)),
        co.Body(co.Sphere(0.42, (1.6, -0.95, 0.42)), co.materials.silver(roughness=0.02)),
        co.Body(co.Ellipsoid((0.42, 0.42, 0.56), (-0.75, -1.15, 0.42)), co.plastic("#9c2a22")),
        co.Body(co.Disc((-3.2, -3.4, 5.6), (0.55, 0.6, -0.85), 2.3), co.glow((8.4, 8.0, 7.2))),
        co.Body(co.Cylinder((4.6, -2.6, 0.7), (4.6, 2.2, 2.9), 0.35), co.glow((6, 6.8, 8))),
    ]
    camera = co.Camera((0.2, -8.4, 2.5), (0.15, 0, 0.88), field_of_view=28, aperture=0.09, focus_distance=8.3)
    return co.Scene(bodies, camera=camera, background=(0.05, 0.055, 0.07))


def picture(progress: Progress | None = None, scale: float = 1.0, samples: int = 1200) -> co.Image:
    """The picture, `scale` times its full size."""
    size = round(510 * scale), round(324 * scale)
    image = scene().render(*size, samples, "path", depth=14, filter="gaussian", noise=0.015, progress=progress)
    return image.developed(exposure=0.6, tone="filmic")


if __name__ == "__main__":
    picture().save("studio_light.png")
