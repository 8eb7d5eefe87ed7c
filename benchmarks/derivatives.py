"""The cost of derivatives beside that of their first hits: python benchmarks/derivatives.py [rays] [repeats]

For each scene the least time of several runs, of all processors together: of first hits, of these with all fields, and
with their `jvp` or `vjp` by all parameters and by the rays. The ratios are to first hits with all fields, in the same
run. The slopes of shapes, which are worked out once for each shape, are told apart.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

import conicoid as co


def scenes() -> dict[str, co.Scene]:
    """By name; a few bodies, many, and Booleans."""
    random = np.random.default_rng(0)
    centers = random.uniform(-9, 9, (1000, 3))
    block = co.Box((-6, -6, -6), (6, 6, 6)) - co.Sphere(5, (4, 3, 6)) - co.Cylinder((0, 0, -9), (0, 1, 9), 2)
    return {
        "one ellipsoid": co.Scene([co.Ellipsoid((7, 5, 6)).rotate((1, 2, 3), 30)]),
        "a bored block": co.Scene([block]),
        "100 cylinders": co.Scene([
            co.Cylinder(c, c + random.normal(size=3), r)
            for c, r in zip(centers[:100], random.uniform(0.3, 1.2, 100), strict=True)
        ]),
        "a lens": co.Scene([co.Lens(50, -40, 9, 20, -0.6, -1.2).scale(0.5)]),
        "1000 balls": co.Scene([co.Spheres(centers, random.uniform(0.2, 0.8, 1000))]),
    }  # fmt: skip


def least(call: Callable[[], Any], repeats: int) -> float:
    """The least time of some runs, in seconds of processors, which other programs do not change much."""
    times = []
    for _ in range(repeats):
        begin = time.process_time()
        call()
        times.append(time.process_time() - begin)
    return min(times)


def fields(hits: co.Hits) -> co.Hits:
    """The hits with what derivatives are of."""
    _ = hits.point, hits.normal, hits.uv
    return hits


def row(name: str, scene: co.Scene, rays: co.Rays, repeats: int) -> str:
    """A line of the table."""
    scene.prepare()
    parameters = co.parameters(scene)
    random = np.random.default_rng(1)
    tangent, do = random.normal(size=len(parameters)), random.normal(size=rays.origins.shape)
    hits = fields(scene.first_hit(rays))
    begin = time.process_time()
    hits.jvp(parameters, tangent)
    first = time.process_time() - begin
    asked = {"t": hits.hit * 1.0, "normal": np.where(hits.hit[..., None], random.normal(size=(*rays.shape, 3)), 0.0)}
    plain = least(lambda: scene.first_hit(rays), repeats)
    whole = least(lambda: fields(scene.first_hit(rays)), repeats)
    forward = least(lambda: fields(scene.first_hit(rays)).jvp(parameters, tangent, d_origins=do), repeats)
    backward = least(lambda: fields(scene.first_hit(rays)).vjp(parameters, **asked), repeats)
    share = float(np.mean(hits.hit))
    return (
        f"{name:<16}{share:>6.0%}{1e3 * plain:>10.1f}{1e3 * whole:>10.1f}{1e3 * forward:>10.1f}{1e3 * backward:>10.1f}"
        f"{forward / whole:>9.2f}{backward / whole:>9.2f}{1e3 * max(first - forward, 0):>12.1f}"
    )


def main(count: int = 200_000, repeats: int = 5) -> None:
    """Print the table."""
    random = np.random.default_rng(2)
    origins = random.normal(size=(count, 3)) * 20
    around = co.Rays(origins, random.uniform(-5, 5, (count, 3)) - origins)
    side = round(count**0.5)
    seen = co.Camera((20, -30, 15), (0, 0, 0)).rays(side, side)
    print(f"{count} rays, times of processors in ms")
    heads = (("hit", 6), ("t", 10), ("fields", 10), ("and jvp", 10), ("and vjp", 10), ("ratio", 9), ("ratio", 9))
    print(f"{'':<16}" + "".join(f"{head:>{width}}" for head, width in (*heads, ("slopes once", 12))))
    for name, scene in scenes().items():
        print(row(name, scene, around, repeats))
        print(row("  from a camera", scene, seen, repeats))


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:]))
