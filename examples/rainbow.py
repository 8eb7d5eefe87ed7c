"""Rays of eleven colours through a prism and a drop of rain: each is traced, and drawn as a thread of light.

The drop sends most of what is mirrored once in it back at about 42°, red at a larger angle than blue.
"""

from __future__ import annotations

import itertools

import numpy as np

import conicoid as co
from studio import Progress

COLORS = [
    (0.66, (1.0, 0.02, 0.02)), (0.62, (1.0, 0.12, 0.0)), (0.59, (1.0, 0.38, 0.0)), (0.575, (0.95, 0.7, 0.0)),
    (0.55, (0.45, 0.9, 0.02)), (0.53, (0.1, 0.85, 0.1)), (0.5, (0.0, 0.7, 0.4)), (0.48, (0.0, 0.42, 0.9)),
    (0.46, (0.04, 0.16, 1.0)), (0.44, (0.16, 0.05, 1.0)), (0.42, (0.34, 0.02, 0.85)),
]  # fmt: skip
"""Wavelengths in μm, and their colours."""
THICK = 0.008
WHITE = co.glow((1.6, 1.6, 1.55))


def way(solid: co.Solid, n: float, origin: np.ndarray, direction: np.ndarray, mirrors: int) -> list[np.ndarray]:
    """The corners of a ray's way through glass of index n: in, `mirrors` times mirrored within, and out again."""
    scene, corners = co.Scene([solid]), [origin]
    rays = co.Rays(origin, direction)
    for wall in range(mirrors + 2):
        hits = scene.first_hit(rays)
        corners.append(np.asarray(hits.point))
        if 0 < wall <= mirrors:
            direction = co.reflect(direction, hits.normal)
        else:
            direction, _ = co.refract(direction, hits.normal, 1 / n if wall == 0 else n)
        rays = hits.spawn(direction)
    return [*corners, corners[-1] + 2.6 * np.asarray(direction)]


def threads(corners: list[np.ndarray], material: co.Material) -> list[co.Body]:
    """A way as thin cylinders."""
    return [co.Body(co.Cylinder(tuple(a), tuple(b), THICK), material) for a, b in itertools.pairwise(corners)]


def fan(solid: co.Solid, glass: str, start: np.ndarray, along: np.ndarray, mirrors: int) -> list[co.Body]:
    """The threads of one white ray: a white one up to the glass, one of each colour beyond."""
    bodies: list[co.Body] = []
    index = co.optics.glass(glass)
    for wavelength, color in COLORS:
        corners = way(solid, index(wavelength), start, along, mirrors)
        bodies += threads(corners[1:], co.glow(tuple(1.3 * part for part in color)))
        if wavelength == COLORS[0][0]:
            bodies = threads(corners[:2], WHITE) + bodies
    return bodies


def scene() -> co.Scene:
    """The prism on the left, the drop on the right, each ray by the index that was measured of flint and of water."""
    corners = [(np.sin(a), np.cos(a)) for a in np.radians((0, 120, 240))]
    sides = [(-x, 0.0, -z) for x, z in corners]
    prism = co.Polyhedron([*sides, (0, 1, 0), (0, -1, 0)], [0.5, 0.5, 0.5, 0.45, 0.45]).scale(0.95)
    prism = prism.translate((-2.1, 0, 0.1))
    drop = co.Sphere(0.95, (2.0, 0, 0.45))
    beam = np.array((np.cos(np.radians(24)), 0.0, np.sin(np.radians(24))))
    ray = np.array((-2.1 - 0.36, 0, 0.12)) - 2.4 * beam
    high = np.array((-1.4, 0.0, 0.45 + 0.86 * 0.95))
    rays = fan(prism, "F2", ray, beam, 0)
    rays += fan(drop, "water", high, np.array((1.0, 0.0, 0.0)), 1)
    clear = co.glass(1.333, specular=0.4), co.glass(1.5, specular=0.4)
    sky = co.Sky((0.10, 0.13, 0.2), (0.006, 0.008, 0.014), (0.05, 0.05, 0.07))
    camera = co.Camera((0, -9, 0.0), (0, 0, 0.0), field_of_view=22)
    panels = [
        co.Body(co.Disc((-6, -7, 6), (0.6, 0.7, -0.6), 2.2), co.glow((0.8, 0.85, 1.0))),
        co.Body(co.Disc((7, 3, 4), (-0.7, -0.3, -0.4), 2.4), co.glow((0.3, 0.36, 0.5))),
    ]
    bodies = [*rays, co.Body(drop, clear[0]), co.Body(prism, clear[1]), *panels]
    return co.Scene(bodies, co.AmbientLight(0), camera, sky)


def picture(progress: Progress | None = None, scale: float = 1.0, samples: int = 16) -> co.Image:
    """The picture, `scale` times its full size."""
    size = round(760 * scale), round(400 * scale)
    return scene().render(*size, samples, filter="gaussian", progress=progress)


if __name__ == "__main__":
    picture().save("rainbow.png")
