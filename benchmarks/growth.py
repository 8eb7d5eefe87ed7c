"""How the cost of a ray grows with a scene: balls of radius 0.7 N^(-1/2), so that about as many are hit.

    python benchmarks/growth.py [most]

Nanoseconds a ray, medians of five, for a camera's rays (1024 x 1024) and for 2^20 random ones; seconds to build the
tree; bytes a ball.
"""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Callable
from functools import partial

import conicoid as co
from conicoid.bench.report import machine
from conicoid.bench.scenes import camera_rays, growing_balls, random_rays


def median(run: Callable[[], object]) -> float:
    run()
    seconds = []
    for _ in range(5):
        begin = time.perf_counter()
        run()
        seconds.append(time.perf_counter() - begin)
    return statistics.median(seconds)


def main() -> None:
    most = int(float(sys.argv[1])) if len(sys.argv) > 1 else 1_000_000
    camera, random = co.Rays(*camera_rays(1024)), co.Rays(*random_rays(1 << 20))
    print("| balls | camera, ns/ray | random, ns/ray | build, s | bytes a ball |\n|---|---|---|---|---|")
    count = 10
    while count <= most:
        scene = co.Scene(growing_balls(count).shapes())
        begin = time.perf_counter()
        _ = scene.prepared
        built = time.perf_counter() - begin
        times = [median(partial(scene.first_hit, rays)) / (1 << 20) * 1e9 for rays in (camera, random)]
        memory = scene.memory
        each = (memory.tables + memory.tree) / count
        print(f"| {count:,} | {times[0]:.1f} | {times[1]:.0f} | {built:.2g} | {each:.0f} |", flush=True)
        count *= 10
    print("\n".join(machine([])))


if __name__ == "__main__":
    main()
