"""How the cost of a ray grows with a scene: balls of radius 0.7 N^(-1/2), so that about as many are hit.

    python benchmarks/growth.py [most] [peers]

Nanoseconds a ray, medians of five, for a camera's rays (1024 x 1024) and for 2^20 random ones; seconds to build the
tree; bytes a ball. With `peers`: of a camera's rays in Embree and Mitsuba instead, the least of seven turns.
"""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Callable
from functools import partial

from comparison.harness import machine
from comparison.scenes import camera_rays, growing_balls, random_rays

import conicoid as co


def median(run: Callable[[], object]) -> float:
    run()
    seconds = []
    for _ in range(5):
        begin = time.perf_counter()
        run()
        seconds.append(time.perf_counter() - begin)
    return statistics.median(seconds)


def with_peers(most: int) -> None:
    """The same camera's rays in Embree and in Mitsuba, in turn."""
    from comparison import peers as embree, peers as mitsuba

    origins, directions = camera_rays(1024)
    rays, flat = co.Rays(origins, directions), (origins.reshape(-1, 3), directions.reshape(-1, 3))
    print("| balls | Conicoid, ns/ray | Embree, rtcIntersect1 | Mitsuba, LLVM |\n|---|---|---|---|")
    count = 1000
    while count <= most:
        each = growing_balls(count)
        scene = co.Scene(each.shapes())
        with embree.EmbreeScene(each) as one, mitsuba.MitsubaScene(each, *flat, True) as other:

            def ours(scene: co.Scene = scene) -> float:
                begin = time.perf_counter()
                scene.first_hit(rays)
                return time.perf_counter() - begin

            turns = [(ours(), one.first_hits(*flat)[0], other.seconds()) for _ in range(8)][1:]
        least = (f"{min(column) / (1 << 20) * 1e9:.1f}" for column in zip(*turns, strict=True))
        print(f"| {count:,} | {' | '.join(least)} |", flush=True)
        count *= 10
    print("\n".join(machine([embree.EMBREE, mitsuba.MITSUBA])))


def main() -> None:
    most = int(float(sys.argv[1])) if len(sys.argv) > 1 else 1_000_000
    if sys.argv[2:] == ["peers"]:
        with_peers(most)
        return
    camera, random = co.Rays(*camera_rays(1024)), co.Rays(*random_rays(1 << 20))
    print("| balls | camera, ns/ray | random, ns/ray | build, s | bytes a ball |\n|---|---|---|---|---|")
    count = 10
    while count <= most:
        scene = co.Scene(growing_balls(count).shapes())
        begin = time.perf_counter()
        _ = scene._prepared
        built = time.perf_counter() - begin
        times = [median(partial(scene.first_hit, rays)) / (1 << 20) * 1e9 for rays in (camera, random)]
        memory = scene.memory
        each = (memory.tables + memory.tree) / count
        print(f"| {count:,} | {times[0]:.1f} | {times[1]:.0f} | {built:.2g} | {each:.0f} |", flush=True)
        count *= 10
    print("\n".join(machine([])))


if __name__ == "__main__":
    main()
