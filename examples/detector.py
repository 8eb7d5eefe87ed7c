"""A collider's detector, cut open: tracker, calorimeters, coil and the iron with its chambers, ring in ring."""

from __future__ import annotations

import conicoid as co
from studio import Progress

LAYERS = [
    (0.30, 0.33, 2.4, "#e8e4d8"), (0.55, 0.58, 3.0, "#d9b45b"), (0.80, 0.83, 3.4, "#d9b45b"),
    (1.05, 1.08, 3.8, "#d9b45b"),
]  # fmt: skip
"""Silicon of the tracker: radii, length, colour."""


def tube(inner: float, outer: float, length: float) -> co.Solid:
    """Along x."""
    whole = co.Cylinder((-length / 2, 0, 0), (length / 2, 0, 0), outer)
    return whole - co.Cylinder((-length, 0, 0), (length, 0, 0), inner)


def wedges(inner: float, outer: float, length: float, count: int, gap: float) -> co.Solid:
    """A tube in `count` parts, `gap` apart."""
    slots = [
        co.Box((-length, -gap / 2, 0), (length, gap / 2, 2 * outer)).rotate("x", 360 * k / count) for k in range(count)
    ]
    return tube(inner, outer, length) - co.Union(slots)


def scene() -> co.Scene:
    """Everything less the quarter that faces the camera."""
    cut = co.HalfSpace((0, 1, 0), 0) & co.HalfSpace((0, 0, -1), 0)
    finish = {"rough": 0.25}
    parts: list[tuple[co.Solid, co.Material]] = [
        (tube(0.07, 0.09, 12.4), co.materials.aluminium(roughness=0.2)),
        *[(tube(a, b, length), co.plastic(color, roughness=finish["rough"])) for a, b, length, color in LAYERS],
        (wedges(1.25, 1.75, 5.0, 18, 0.03), co.plastic("#3f8f5b", roughness=0.3)),
        (wedges(1.82, 2.75, 5.6, 18, 0.05), co.plastic("#c4622d", roughness=0.3)),
        (tube(2.86, 3.22, 6.2), co.materials.copper(roughness=0.3)),
    ]
    for k in range(4):
        inner = 3.4 + 0.62 * k
        parts.append((wedges(inner, inner + 0.42, 6.6, 12, 0.08), co.plastic("#a8262c", roughness=0.35)))
        if k < 3:
            parts.append((wedges(inner + 0.46, inner + 0.58, 6.6, 12, 0.3), co.plastic("#d8d8d4", roughness=0.3)))
    for k, color in enumerate(("#3f8f5b", "#c4622d", "#c4622d")):
        for side in (-1, 1):
            disc = tube(0.35, 1.75 if k == 0 else 2.7, 0.35).translate((side * (2.75 + 0.5 * k), 0, 0))
            parts.append((disc, co.plastic(color, roughness=0.3)))
    for k in range(3):
        for side in (-1, 1):
            iron = tube(0.55, 5.6 - 0.1 * k, 0.4).translate((side * (4.6 + 0.62 * k), 0, 0))
            parts.append((iron, co.plastic("#a8262c", roughness=0.35)))
    bodies = [co.Body(shape - cut if k else shape, finish) for k, (shape, finish) in enumerate(parts)]
    bodies += [
        co.Body(co.Plane((0, 0, 1), -5.72), co.matte((0.55, 0.56, 0.58))),
        co.Body(co.Disc((-6, -14, 15), (0.4, 0.9, -1), 4.5), co.glow((9, 8.7, 8.2))),
    ]
    camera = co.Camera((-14.5, -19, 10.0), (0.3, 0, -0.75), field_of_view=32)
    return co.Scene(bodies, camera=camera, background=co.Sky((0.5, 0.56, 0.66), (0.7, 0.7, 0.72)))


def picture(progress: Progress | None = None, scale: float = 1.0, samples: int = 64) -> co.Image:
    """The picture, `scale` times its full size."""
    size = round(500 * scale), round(380 * scale)
    image = scene().render(*size, samples, "path", depth=5, filter="gaussian", progress=progress)
    return image.developed(exposure=0.7, tone="filmic")


if __name__ == "__main__":
    picture().save("detector.png")
