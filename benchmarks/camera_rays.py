"""Rays per second: first hits of camera rays on random capped quadrics, and on as many balls.

    python benchmarks/camera_rays.py [count] [width]

Ellipsoids, cylinders, cones and one-sheet hyperboloids between two planes, in any direction, fill
the cube [-1, 1]³; a pinhole camera at (0, 0, -3) looks along z. The rays come as a picture
(height, width, 3), as a flat list of its rows, and shuffled. Medians of five runs, after one that
is not counted.
"""

from __future__ import annotations

import math
import platform
import statistics
import sys
import time

import numpy as np

import conicoid as co
from conicoid.trace.threads import thread_count


def capped_quadrics(count: int, seed: int = 0) -> tuple[list[co.Shape], np.ndarray, np.ndarray]:
    """`count` solids, with the centers and radii of balls about as large."""
    rng = np.random.default_rng(seed)
    centers = rng.random((count, 3)) * 2 - 1
    radii = (rng.random(count) * 0.5 + 0.5) * 0.6 / count ** (1 / 3)
    axes = rng.normal(size=(count, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    shapes: list[co.Shape] = []
    for kind, center, r, axis in zip(rng.integers(0, 4, count), centers, radii, axes, strict=True):
        half = 0.6 * r
        if kind == 1:
            shapes.append(co.Cylinder(center - half * axis, center + half * axis, r))
            continue
        squares = [r**-2] * 3 if kind != 3 else [r**-2 / 0.2] * 3
        upright = (
            co.Ellipsoid.from_coefficients(*squares, z_range=(-half, half))
            if kind == 0
            else (co.EllipticCone if kind == 2 else co.OneSheetHyperboloid)(*squares, z_range=(-half, half))
        )
        turn = (np.cross((0, 0, 1), axis), math.degrees(math.acos(axis[2])))
        shapes.append(upright.rotate(*turn).translate(center))
    return shapes, centers, radii


def camera_rays(width: int) -> tuple[np.ndarray, np.ndarray]:
    """Origins and directions (width, width, 3)."""
    y, x = np.meshgrid(np.linspace(-0.5, 0.5, width), np.linspace(-0.5, 0.5, width), indexing="ij")
    directions = np.stack([x, y, np.ones_like(x)], axis=-1)
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    return np.broadcast_to((0.0, 0.0, -3.0), directions.shape), directions


def rate(scene: co.Scene, rays: co.Rays) -> float:
    """Million rays per second, median of five."""
    scene.first_hit(rays)
    seconds = []
    for _ in range(5):
        begin = time.perf_counter()
        scene.first_hit(rays)
        seconds.append(time.perf_counter() - begin)
    return math.prod(rays.shape) / statistics.median(seconds) / 1e6


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    width = int(sys.argv[2]) if len(sys.argv) > 2 else 1024
    shapes, centers, radii = capped_quadrics(count)
    picture = co.Rays(*camera_rays(width))
    order = np.random.default_rng(1).permutation(width * width)
    flat_o, flat_d = picture.origins.reshape(-1, 3), picture.directions.reshape(-1, 3)
    rays = {"picture": picture, "rows": co.Rays(flat_o, flat_d), "shuffled": co.Rays(flat_o[order], flat_d[order])}
    print(f"{platform.processor() or platform.machine()}, {thread_count()} threads, Python {platform.python_version()}")
    for name, items in (("capped quadrics", shapes), ("balls", [co.Spheres(centers, radii)])):
        scene = co.Scene(items)
        for order_name, bundle in rays.items():
            print(f"{count} {name}, {order_name}: {rate(scene, bundle):.1f} Mray/s")


if __name__ == "__main__":
    main()
