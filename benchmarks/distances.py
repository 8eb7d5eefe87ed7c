"""Distances of points from walls, beside the closest points of fine meshes of the same bodies.

    python benchmarks/distances.py [points] [steps]

Bodies of revolution, each as it is and as a mesh of `steps` steps around (512), about 2 steps² triangles. Open3D's
`RaycastingScene.compute_closest_points` is Embree's rtcPointQuery in float32, on all its threads; Embree by itself has
it for C alone. Nanoseconds a point (the least of three turns) for as many points (10^5) anywhere about the body;
Open3D's over ours; and the largest error: ours as it is told, theirs against ours. The last row is a block of 5 x 5 x 5
drilled balls, of a mesh with an eighth of the steps. Open3D is left out where it is not installed.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import Any

import numpy as np
from comparison.harness import machine

import conicoid as co


def arc(radius: float, first: float, last: float, steps: int, height: float = 0.0) -> Any:
    """Points (distance from the axis, height) on a circle about a point of the axis, between angles from the pole."""
    angles = np.linspace(first, last, steps)
    return np.stack([radius * np.sin(angles), height + radius * np.cos(angles)], axis=1)


def line(*corners: tuple[float, float], steps: int) -> Any:
    """Points along straight lines."""
    parts = [np.linspace(a, b, steps) for a, b in pairwise(corners)]
    return np.concatenate(parts)


def bodies(steps: int) -> dict[str, tuple[co.Solid, Any]]:
    """Name: (the body, its outline from pole to pole, or closed)."""
    bore, rim = np.arcsin(0.5), np.sqrt(0.75)
    lens = np.arccos(0.75)
    return {
        "ball": (co.Sphere(1), arc(1, 0, np.pi, steps)),
        "cylinder": (
            co.Cylinder((0, 0, -1), (0, 0, 1), 0.5),
            line((0, 1), (0.5, 1), (0.5, -1), (0, -1), steps=steps // 3),
        ),
        "cone": (co.Cone((0, 0, 0), (0, 0, 1.5), 1, 0), line((0, 1.5), (1, 0), (0, 0), steps=steps // 2)),
        "spheroid": (co.Ellipsoid((0.5, 0.5, 1)), arc(1, 0, np.pi, steps) * (0.5, 1)),
        "lens": (
            co.Sphere(2, (0, 0, -1.5)) & co.Sphere(2, (0, 0, 1.5)),
            np.concatenate([arc(2, 0, lens, steps // 2, -1.5), arc(2, np.pi - lens, np.pi, steps // 2, 1.5)]),
        ),
        "drilled ball": (
            co.Sphere(1) - co.Cylinder((0, 0, -2), (0, 0, 2), 0.5),
            np.concatenate([arc(1, bore, np.pi - bore, steps), line((0.5, -rim), (0.5, rim), steps=steps // 2)]),
        ),
    }


def mesh(outline: Any, steps: int) -> tuple[Any, Any]:
    """(vertices, triangles) of an outline turned about the z axis."""
    angles = np.linspace(0, 2 * np.pi, steps, endpoint=False)
    radius, height = outline[:, :1], outline[:, 1:]
    vertices = np.stack(
        [radius * np.cos(angles), radius * np.sin(angles), np.broadcast_to(height, (len(outline), steps))], axis=-1
    )
    row, column = np.meshgrid(np.arange(len(outline) - 1), np.arange(steps), indexing="ij")
    after = (column + 1) % steps
    a, b, c, d = row * steps + column, row * steps + after, (row + 1) * steps + column, (row + 1) * steps + after
    triangles = np.concatenate([np.stack([a, c, b], axis=-1), np.stack([b, c, d], axis=-1)]).reshape(-1, 3)
    return vertices.reshape(-1, 3).astype(np.float32), triangles.astype(np.uint32)


def least(run: Callable[[], Any], count: int) -> tuple[float, Any]:
    """(nanoseconds for each of `count`, the answer): the least of three turns, after one that is not counted."""
    answer, seconds = run(), []
    for _ in range(3):
        begin = time.perf_counter()
        answer = run()
        seconds.append(time.perf_counter() - begin)
    return min(seconds) * 1e9 / count, answer


def open3d_scene(vertices: Any, triangles: Any) -> Any:
    """A mesh in Open3D's scene; None where Open3D is not installed."""
    try:
        import open3d
    except ImportError:
        return None
    scene = open3d.t.geometry.RaycastingScene()
    scene.add_triangles(open3d.core.Tensor(vertices), open3d.core.Tensor(triangles))
    return lambda points: scene.compute_closest_points(open3d.core.Tensor(points))["points"].numpy()


def cases(steps: int) -> Iterator[tuple[str, co.Scene, Any]]:
    """(name, scene, (vertices, triangles)): each body by itself, and a block of them."""
    for name, (shape, outline) in bodies(steps).items():
        yield name, co.Scene([shape]), mesh(outline, steps)
    shape, outline = bodies(max(24, steps // 8))["drilled ball"]
    vertices, triangles = mesh(outline, max(24, steps // 8))
    places = np.stack(np.meshgrid(*[np.arange(-2, 3) * 0.8] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    many = (0.3 * vertices[None] + places[:, None]).reshape(-1, 3).astype(np.float32)
    more = (triangles[None] + (len(vertices) * np.arange(len(places)))[:, None, None]).reshape(-1, 3)
    scene = co.Scene([shape.scale(0.3).translate(tuple(place)) for place in places.tolist()])
    yield f"{len(places)} drilled balls", scene, (many, more.astype(np.uint32))


def main(count: int = 100_000, steps: int = 512) -> None:
    points = np.random.default_rng(0).uniform(-2, 2, (count, 3))
    print("\n".join(machine([])))
    columns = (
        "body",
        "bound, ns",
        "exact, ns",
        "its error",
        "Open3D, ns",
        "/ bound",
        "/ exact",
        "triangles",
        "its error",
    )
    print(f"| {' | '.join(columns)} |\n|{'---|' * len(columns)}")
    for name, scene, (vertices, triangles) in cases(steps):
        bound, _ = least(lambda scene=scene: scene.distance(points), count)
        exact, found = least(lambda scene=scene: scene.distance(points, exact=True), count)
        row = [name, f"{bound:.0f}", f"{exact:.0f}", f"{found.error.max():.0e}"]
        peer = open3d_scene(vertices, triangles)
        if peer is None:
            row += ["not installed", "", "", f"{len(triangles):,}", ""]
        else:
            took, nearest = least(lambda peer=peer: peer(points.astype(np.float32)), count)
            off = np.abs(np.linalg.norm(nearest - points, axis=1) - np.abs(found.distance)).max()
            row += [
                f"{took:.0f}",
                f"{took / bound:.2f}",
                f"{took / exact:.2f}",
                f"{len(triangles):,}",
                f"{off:.0e}",
            ]
        print(f"| {' | '.join(row)} |", flush=True)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:3]))
