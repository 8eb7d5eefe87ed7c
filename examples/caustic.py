"""A glass ball and a glass ring on a table gather a small lamp's light in caustics."""

from __future__ import annotations

import conicoid as co
from studio import Progress


def scene() -> co.Scene:
    """A lamp low on the left, which throws long shadows with light in them."""
    table = co.matte((0.62, 0.58, 0.52))
    crystal, amber = co.glass(1.52), co.glass(1.5, absorption=(0.05, 0.5, 1.6))
    ring = co.Cylinder((0, 0, 0), (0, 0, 0.5), 0.8) - co.Cylinder((0, 0, -1), (0, 0, 1), 0.66)
    bodies = [
        co.Body(co.Plane((0, 0, 1), 0), table),
        co.Body(co.Sphere(0.8, (-0.35, 0.55, 0.8)), crystal),
        co.Body(ring.translate((1.25, -0.75, 0)), co.materials.gold(roughness=0.06)),
        co.Body(co.Ellipsoid((0.42, 0.42, 0.3), (-1.25, -0.85, 0.3)), amber),
        co.Body(co.Sphere(1.7, (-5.6, 1.3, 5.0)), co.glow((18, 16.2, 13.6))),
    ]
    camera = co.Camera((0.4, -6.2, 4.3), (0.3, 0.0, 0.3), field_of_view=28)
    return co.Scene(bodies, camera=camera, background=(0.012, 0.014, 0.02))


def picture(progress: Progress | None = None, scale: float = 1.0, samples: int = 1500) -> co.Image:
    """The picture, `scale` times its full size."""
    size = round(510 * scale), round(340 * scale)
    image = scene().render(*size, samples, "path", depth=12, filter="gaussian", noise=0.015, progress=progress)
    return image.developed(exposure=0.3, tone="filmic")


if __name__ == "__main__":
    picture().save("caustic.png")
