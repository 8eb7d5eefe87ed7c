"""A kinetic sculpture while its shutter is open: balls and rings turn about one post, each at a rate of its own."""

from __future__ import annotations

import math

import conicoid as co
from studio import Progress, backdrop

ARMS = [(3.35, 2.2, 202, 18), (2.65, 1.9, 325, -24), (1.95, 1.6, 55, 34), (1.25, 1.3, 250, -46)]
"""Height, length, place and turn in degrees of each arm."""


def arm(height: float, length: float, angle: float) -> tuple[co.Solid, co.Solid]:
    """A rod with a ring about the post, and a ball and a cup for the counterweight at its ends."""
    rod = co.Cylinder((-0.55 * length, 0, height), (length, 0, height), 0.035)
    hub = co.Cylinder((0, 0, height - 0.07), (0, 0, height + 0.07), 0.13)
    ball = co.Sphere(0.22 + 0.07 * length, (length, 0, height))
    cup = co.Sphere(0.24, (-0.55 * length, 0, height)) - co.HalfSpace((-1, 0.0, 0.4), 0.55 * length + 0.05)
    return (rod | hub | cup).rotate("z", angle), ball.rotate("z", angle)


def scene() -> co.Scene:
    """Its first second is one exposure."""
    bodies, tracks = [*backdrop("#dedad2", wall=8)], []
    paints = [
        co.plastic("#d01c14", roughness=0.25),
        co.materials.gold(roughness=0.2),
        co.plastic("#1460c0", roughness=0.25),
        co.plastic("#f0b400", roughness=0.25),
    ]
    for k, ((height, length, angle, turn), paint) in enumerate(zip(ARMS, paints, strict=True)):
        rod, ball = arm(height, length, angle)
        bodies += [co.Body(rod, co.materials.aluminium(roughness=0.2), f"rod {k}"), co.Body(ball, paint, f"ball {k}")]
        tracks += [co.scene.BodyTrack(f"{part} {k}", (0, 1), degrees=(0, turn)) for part in ("rod", "ball")]
    foot = co.Ellipsoid((0.85, 0.85, 0.35), z_range=(0, 1)) | co.Cylinder((0, 0, 0), (0, 0, 3.75), 0.05)
    bodies.append(co.Body(foot | co.Sphere(0.11, (0, 0, 3.78)), co.materials.copper(roughness=0.25)))
    bodies.append(co.Body(co.Disc((-4.5, -4.5, 8.5), (0.5, 0.5, -0.8), 1.7), co.glow((26, 24.6, 22.5))))
    view = math.radians(-8)
    camera = co.Camera((9.6 * math.sin(view), -9.6 * math.cos(view), 5.6), (0.05, 0, 1.8), field_of_view=33)
    return co.Scene(bodies, camera=camera, background=(0.12, 0.13, 0.15), animation=tracks)


def picture(progress: Progress | None = None, scale: float = 1.0, samples: int = 128) -> co.Image:
    """The picture, `scale` times its full size."""
    size = round(440 * scale), round(440 * scale)
    options = dict(depth=6, filter="gaussian", shutter=(0, 1), times=samples)
    image = scene().render(*size, samples, "path", progress=progress, **options)
    return image.developed(exposure=1.2, tone="filmic")


if __name__ == "__main__":
    picture().save("mobile.png")
