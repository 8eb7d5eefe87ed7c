"""Compile every kernel now, rather than at first use."""

from __future__ import annotations


def warmup() -> None:
    """Compile and cache all kernels (about half a minute the first time, under a second later)."""
    from .ahead import JOBS, expect
    from .compile_jobs import CALLS
    from .scene import Scene
    from .shapes.sphere import Sphere

    expect(*JOBS)
    scene = Scene([Sphere(1.0), Sphere(1.0, (0.0, 0.0, 1.0)) - Sphere(0.5)])
    hits = scene.first_hit([(0.0, 0.0, 5.0)], [(0.0, 0.0, -1.0)])
    for _ in (hits.normal, hits.uv, hits.local_point):
        pass
    rays = hits.spawn(hits.normal)
    scene.occluded(rays)
    scene.spans(rays)
    scene.crossings(rays)
    scene.contains([(0.0, 0.0, 0.0)])
    scene.render(8, 8, samples=1)
    for call in CALLS.values():
        call()
