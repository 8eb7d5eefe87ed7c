"""How the cost of a scene grows with its size: time to build, memory, time a ray.

    python benchmarks/large_scenes.py [count ...]        # 1000 10000 100000 1000000; 10000000 takes half a minute

Balls in the cube [-1, 1]³ with radii 0.7 count^(-1/2), so that a line meets as many of them however many there are
(about 1.5 through the middle of the cube). Rays: a picture of 1024 x 1024 from (0, 0, -3), a million random ones
from within the cube, both by `first_hit`, and a thousand of those asked for in one small batch by one thread.
Each count runs in a process of its own, after a small scene that is not counted; rays: medians of three.
"""

from __future__ import annotations

import resource
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

import conicoid as co
from conicoid.kernels.threads import set_threads

WIDTH = 1024


def timed(work: Callable[[], Any]) -> tuple[float, Any]:
    start = time.perf_counter()
    result = work()
    return time.perf_counter() - start, result


def balls(count: int) -> co.Spheres:
    rng = np.random.default_rng(0)
    return co.Spheres(rng.uniform(-1, 1, (count, 3)), 0.7 * count**-0.5)


def picture() -> tuple[np.ndarray, np.ndarray]:
    y, x = np.meshgrid(*2 * [np.linspace(-0.5, 0.5, WIDTH)], indexing="ij")
    directions = np.stack([x, y, np.ones_like(x)], axis=-1)
    return np.broadcast_to((0.0, 0.0, -3.0), directions.shape), directions


def random_rays(count: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(1)
    return rng.uniform(-1, 1, (count, 3)), rng.normal(size=(count, 3))


def one_by_one(scene: co.Scene, rays: tuple[np.ndarray, np.ndarray]) -> None:
    """Rays far apart from their neighbours, so few that they are not worth sorting."""
    scene.first_hit(*(array[:1000] for array in rays))


def measure(count: int) -> None:
    rays, incoherent = picture(), random_rays(WIDTH * WIDTH)
    small = co.Scene([balls(20_000)])
    for each in (rays, incoherent):
        small.first_hit(*each)
    shape = balls(count)
    scene = co.Scene([shape])
    seconds, _ = timed(lambda: scene._prepared)
    memory, peak = scene.memory, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    times = []
    for each in (rays, incoherent):
        runs = [timed(lambda each=each: scene.first_hit(*each)) for _ in range(3)]
        times.append(statistics.median(seconds for seconds, _ in runs) / WIDTH**2 * 1e9)
    met = float((runs[-1][1].body >= 0).mean())
    set_threads(1)
    one_by_one(scene, incoherent)
    alone = statistics.median(timed(lambda: one_by_one(scene, incoherent))[0] for _ in range(9)) / 1000 * 1e9
    each = memory.tables / count, memory.tree / count
    print(
        f"{count:>10,}  {seconds:8.3f}  {each[0]:8.0f}  {each[1]:6.0f}  {peak:8.2f}"
        f"  {times[0]:7.0f}  {times[1]:7.0f}  {alone:7.0f}  {met:6.3f}",
        flush=True,
    )


def main() -> None:
    if sys.argv[1:2] == ["--one"]:
        measure(int(sys.argv[2]))
        return
    counts = [int(text) for text in sys.argv[1:]] or [1000, 10_000, 100_000, 1_000_000]
    print("           seconds to  bytes a cell for      peak         ns a ray        random")
    print("     balls    prepare    tables    tree       GiB  picture   random   alone     met")
    for count in counts:
        subprocess.run([sys.executable, __file__, "--one", str(count)], check=True)


if __name__ == "__main__":
    main()
