"""What workers cost: two processes of one thread each against two threads of one process, and what a model needs.

    python benchmarks/workers.py [SCALE] [--dask] [--json FILE]

SCALE 1, if not given, is 10⁸ camera rays (a picture, and shadows) and 10⁷ rays whose spans are summed; 0.01 tries it
out. Each question is asked in turn of both, three times, and the fastest counts, by the clock: nothing else should
run. With --dask the workers are those of a scheduler of Dask, else `co.parallel.Processes`. Two minutes on two cores.

Then: bytes sent for each ray and brought back; tasks a second that a driver gets through, of those that do nothing;
bytes a second that it takes in; and what a scene is in bytes. docs/cluster.md puts these together.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import logging
import os
import pickle
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

import conicoid as co
from conicoid.parallel import processes
from conicoid.parallel.shared_state import shared_scene, source_version
from conicoid.parallel.workers import ScheduledTask, Scheduler

TWO, TIMES = 2, 3
SAMPLES = 8
WINDOW = 300  # tasks on their way, as a hundred workers have them


def crowd(count: int = 1000) -> Any:
    """Balls about the origin, and a camera that sees all of them."""
    rng = np.random.default_rng(1)
    return co.Scene([co.Spheres(rng.uniform(-1, 1, (count, 3)), 0.06)], camera=co.Camera((3, 2, 1.5), (0, 0, 0)))


def nested() -> Any:
    """Ten ellipsoids in one another, as a head has them: every ray has many spans."""
    turned = (
        co.Ellipsoid((0.9 - 0.08 * k, 0.7 - 0.06 * k, 0.8 - 0.07 * k)).rotate((0, 0, 1), 13 * k) for k in range(10)
    )
    return co.Scene(list(turned))


class Counted(co.parallel.Processes):
    """Processes that count the bytes of their messages."""

    sent = 0

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Any:
        self.sent += len(pickle.dumps((fn, args, kwargs), protocol=5))
        return super().submit(fn, *args, **kwargs)


@contextlib.contextmanager
def counted_answers() -> Iterator[list[int]]:
    """The bytes that come back from processes within the block."""
    plain, total = processes.receive, [0]

    def receive(pipe: Any) -> bytes:
        data = plain(pipe)
        total[0] += len(data)
        return data

    processes.receive = receive
    try:
        yield total
    finally:
        processes.receive = plain


def questions(scale: float) -> dict[str, tuple[int, Callable[[Any], Any]]]:
    """By name: how many rays, and the question, of an executor or of None."""
    balls, head, side = crowd(), nested(), round((1e8 * scale / SAMPLES) ** 0.5)
    camera, wide = balls.camera, round((1e8 * scale) ** 0.5)
    shadows = co.Rays.from_camera(camera, wide, wide)
    views = max(1, round(1e7 * scale / 1e5))
    scan = co.ct.cone(np.arange(views) * 360 / views, 250, 400, 3, 2, spacing=(0.012, 0.012))
    values = np.linspace(0.1, 1, 10)
    logging.getLogger("conicoid").setLevel(logging.ERROR)  # that they lie in one another is meant
    return {
        f"picture, {SAMPLES} rays a pixel": (
            side * side * SAMPLES,
            lambda how: balls.render(side, side, samples=SAMPLES, integrator="normals", executor=how),
        ),
        "shadows (occluded)": (wide * wide, lambda how: balls.occluded(shadows, executor=how)),
        "sums of spans (project)": (
            int(np.prod(scan.shape)),
            lambda how: co.ct.project(head, scan, values, executor=how),
        ),
    }


def seconds(question: Callable[[Any], Any], how: Any) -> float:
    begin = time.perf_counter()
    question(how)
    return time.perf_counter() - begin


def compared(scale: float, pool: Any) -> dict[str, Any]:
    """Rates of both, million rays a second, and the second's share of the first's."""
    co.set_threads(TWO)
    found = {}
    for question in questions(min(scale, 0.002)).values():
        question[1](None), question[1](pool)  # everything is made ready
    for name, (rays, question) in questions(scale).items():
        here, there = [], []
        for _ in range(TIMES):
            here.append(seconds(question, None))
            there.append(seconds(question, pool))
        found[name] = dict(
            rays=rays, threads=rays / min(here) / 1e6, workers=rays / min(there) / 1e6, share=min(here) / min(there)
        )
        print(f"{name:<28}{rays:>13,} rays  threads {found[name]['threads']:7.2f} M/s  "
              f"workers {found[name]['workers']:7.2f} M/s  share {found[name]['share']:.3f}", flush=True)  # fmt: skip
    return found


def bytes_of_rays(scale: float) -> dict[str, Any]:
    """Bytes sent and brought back for each ray."""
    found = {}
    for name, (rays, question) in questions(min(scale, 0.05)).items():
        with Counted(TWO) as pool, counted_answers() as back:
            question(pool)
        found[name] = dict(sent=pool.sent / rays, back=back[0] / rays)
        print(f"{name:<28}sent {found[name]['sent']:.5f} bytes a ray, back {found[name]['back']:.3f}", flush=True)
    return found


def taken_in(pool: Any, count: int, size: int) -> float:
    """Return seconds in which a driver completes so many tasks that do nothing, with answers of so many bytes."""
    workers = co.parallel.Workers(pool, window=WINDOW if size < 1000 else None)
    pieces = (ScheduledTask(k, k + 1, (size,)) for k in range(count))
    begin = time.perf_counter()
    for _ in Scheduler("benchmark", workers, bytes, ()).results(pieces, lambda *_: None, count):
        pass
    return time.perf_counter() - begin


def driver(pool: Any, scale: float) -> dict[str, float]:
    """Tasks and bytes a second that it gets through."""
    tasks, parts = max(100, round(5000 * scale)), max(4, round(100 * scale))
    taken_in(pool, 20, 10)
    found = dict(
        tasks_per_second=tasks / taken_in(pool, tasks, 10),
        bytes_per_second=parts * 8e6 / taken_in(pool, parts, 8_000_000),
    )
    print(f"driver: {found['tasks_per_second']:,.0f} tasks a second, {found['bytes_per_second'] / 1e6:,.0f} MB/s")
    return found


def scene_in_bytes(count: int = 100_000) -> dict[str, float]:
    """Return the size of a scene of so many bodies, in a message and as tables."""
    rng = np.random.default_rng(2)
    scene = co.Scene([co.Sphere(0.3, place) for place in rng.uniform(-50, 50, (count, 3))])
    recipe = shared_scene(scene)
    begin = time.process_time()
    recipe.share_tables(source_version(), None)
    path, _ = recipe.reference().tables or ("", b"")
    found = dict(bodies=count, recipe=len(recipe.data), tables=os.path.getsize(path), made=time.process_time() - begin)
    sizes = f"{found['recipe'] / 1e6:.1f} MB of recipe, {found['tables'] / 1e6:.1f} MB of tables"
    print(f"a scene of {count:,} balls: {sizes}")
    return found


def model(figures: dict[str, Any], task: float = 1.0) -> dict[str, float]:
    """Return how many workers of a thread one scheduler and one driver each keep busy, by the measurements."""
    driver, found = figures["driver"], {}
    found["tasks"] = driver["tasks_per_second"] * task
    print(f"model: tasks of {task:g} s keep {found['tasks']:,.0f} workers busy by their number")
    for name, rates in figures["rates"].items():
        bytes_of_worker = rates["workers"] / TWO * 1e6 * figures["bytes"][name]["back"]
        found[name] = driver["bytes_per_second"] / bytes_of_worker
        print(f"model: {name}: a worker brings {bytes_of_worker / 1e6:,.1f} MB/s, so {found[name]:,.0f} by their bytes")
    scene = figures["scene"]["recipe"] * 1000 / driver["bytes_per_second"]
    print(f"model: the recipe of the scene, to 1,000 workers without a shared disk: {scene:,.0f} s")
    return found


@contextlib.contextmanager
def two_workers(dask: bool) -> Iterator[Any]:
    if not dask:
        with co.parallel.Processes(TWO) as pool:
            yield pool
        return
    from distributed import Client, LocalCluster

    with (
        LocalCluster(n_workers=TWO, threads_per_worker=1, dashboard_address=":0") as cluster,
        Client(cluster) as client,
    ):
        yield client


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scale", nargs="?", type=float, default=1.0)
    parser.add_argument("--dask", action="store_true")
    parser.add_argument("--json")
    options = parser.parse_args()
    begin = time.perf_counter()
    with two_workers(options.dask) as pool:
        figures: dict[str, Any] = dict(rates=compared(options.scale, pool), driver=driver(pool, options.scale))
    figures |= dict(bytes=bytes_of_rays(options.scale), scene=scene_in_bytes())
    figures |= dict(model=model(figures), seconds=time.perf_counter() - begin)
    print(f"in {figures['seconds']:.0f} s")
    if options.json:
        with open(options.json, "w", encoding="utf-8") as file:
            json.dump(figures, file, indent=2)


if __name__ == "__main__":
    main()
