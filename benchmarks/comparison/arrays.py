"""Queries from a user's arrays of NumPy to the field that he reads, against the kernel alone, on 1, 2 and all threads.

The kernel alone is the same chunks of the same rays on as many threads, in arrays that it has filled before, and copies
no rays: what is beyond it are checks, copies, sorting, memory that nobody has touched, and the making of answers.

- `arrays-...`: the rate of a query, and that of the kernel alone.
- `beyond-...`: the time of a query less that of the kernel, on all threads, beside that of the kernel.
- `serial-...`: the intercept of Amdahl's law, T(n) = a + b / n, fitted to the time of a query on 1, 2, 4 and so on up
  to all threads, in percent of a + b. With 4 % sixteen cores are ten times as fast as one.
- `alone-...`: what the main thread does alone, in percent of the processor time of all threads. Other programs hardly
  change it.
- `counter`: nanoseconds of a core for a piece of one ray, on all threads and, as the peer, on one.
"""

from __future__ import annotations

import functools
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from conicoid._jit.machine_code import SHIPPED, shipped_kernel
from conicoid.apps.checks.check import check
from conicoid.apps.ct import parallel3d, project
from conicoid.apps.measures.measure import measure as measure_solid
from conicoid.geometry.primitives import Box, Sphere
from conicoid.kernels.threads import run_on, set_threads, thread_count
from conicoid.queries import line_integrals, points, points as distances, ray_queries, spans, voxel_columns
from conicoid.queries.hit_fields import check_rays
from conicoid.render import exposure
from conicoid.scene.scene import Scene

from .harness import Absent, BenchRow, Measured, Peer, Size
from .limits import LIMIT
from .scenes import balls, camera_rays, random_rays

ONE_THREAD = Peer("itself", "one thread", lambda: "")
KERNEL = Peer("itself", "the kernel alone", lambda: "")
_MODULES = distances, exposure, line_integrals, points, ray_queries, spans, voxel_columns
_SHARE = 4.0  # percent

Ask = Callable[[Scene, Any, Any], Any]

QUERIES: dict[str, tuple[str, int, Ask]] = {
    "camera": ("first_hit, camera", 1, lambda scene, origins, directions: scene.first_hit(origins, directions).t),
    "random": ("first_hit, random", 1, lambda scene, origins, directions: scene.first_hit(origins, directions).t),
    "occluded": ("occluded, camera", 1, lambda scene, origins, directions: scene.occluded(origins, directions)),
    "spans": ("spans, camera", 4, lambda scene, origins, directions: scene.spans(origins, directions).t_enter),
    "crossings": ("crossings, camera", 4, lambda scene, origins, directions: scene.crossings(origins, directions).t),
    "lengths": (
        "lengths by material, camera", 4,
        lambda scene, origins, directions: scene.lengths(origins, directions, by="material"),
    ),
    "contains": ("contains, random points", 1, lambda scene, at, _: scene.contains(at)),
    "body_at": ("body_at, random points", 1, lambda scene, at, _: scene.body_at(at)),
    "distance": ("distance, random points", 16, lambda scene, at, _: scene.distance(at).distance),
    "voxels": ("voxels, a cube", 4, lambda scene, at, _: scene.voxels(shape=round(len(at) ** (1 / 3)))),
    "picture": ("picture, 4 samples", 16, lambda scene, lines, _: scene.render(len(lines), len(lines), samples=4)),
    "project": ("project, parallel rays", 4, lambda scene, lines, _: project(scene, _scan(len(lines)), np.ones(1000))),
    "measure": ("measure of a ball less a box", 4, lambda _, at, __: measure_solid(Sphere(1.0) - Box(), rays=len(at))),
    "check": ("check", 16, lambda scene, at, _: check(scene, rays=len(at))),
}  # fmt: skip
"""By name: a title, by how much the number of rays is divided, and the query."""


def _scan(width: int) -> Any:
    """Return a scan with as many rays as a picture of a width, whose detector covers the balls."""
    return parallel3d(np.linspace(0.0, 180.0, 16, endpoint=False), width // 4, width // 4, spacing=8.0 / width)


@functools.cache
def _scene() -> Scene:
    scene = Scene(balls(1000).shapes())
    scene.prepare()
    return scene


def _query(name: str, size: Size, read_only: bool = False) -> tuple[Callable[[], Any], int]:
    """A query from arrays, and its number of rays or points; read_only: arrays that rays keep without a copy."""
    _, divisor, ask = QUERIES[name]
    count = size.rays // divisor
    lines: tuple[Any, Any]
    if name == "random":
        lines = random_rays(count)
    elif name in ("contains", "body_at", "distance", "voxels", "measure", "check"):
        place = np.random.default_rng(5).uniform(-1, 1, (count, 3))
        lines = place, place
    else:
        lines = camera_rays(int(count**0.5))
    origins, directions = (np.array(each, np.float64) for each in lines)
    origins.flags.writeable = directions.flags.writeable = not read_only
    return lambda: ask(_scene(), origins, directions), origins.size // 3


def kernel_of(query: Callable[[], Any]) -> Callable[[], None]:
    """The kernels of a query on the scene, by themselves: on the arrays of one call of the query."""
    calls: list[tuple[tuple[Any, ...], dict[str, Any]]] = []

    def keep(*arguments: Any, **named: Any) -> Any:
        calls.append((arguments, named))
        return run_on(*arguments, **named)

    for module in _MODULES:
        module.run_on = keep  # type: ignore[attr-defined]
    try:
        query()
    finally:
        for module in _MODULES:
            module.run_on = run_on  # type: ignore[attr-defined]
    for (_, work, *_), _ in calls:
        for array in getattr(work, "before", ()):
            if isinstance(array, np.ndarray) and array.base is None:
                array.flags.writeable = True  # a picture that is done is frozen

    def kernel() -> None:
        for arguments, named in calls:
            run_on(*arguments, **named)

    return kernel


def _seconds(run: Callable[[], Any]) -> float:
    begin = time.perf_counter()
    run()
    return time.perf_counter() - begin


@functools.cache
def wall_and_kernel(name: str, size: Size, threads: int) -> tuple[float, float]:
    """Shortest seconds of a query and of its kernel alone, run alternately after a turn that does not count."""
    query, _ = _query(name, size)
    set_threads(threads)
    try:
        kernel = kernel_of(_query(name, size, read_only=True)[0])
        turns = [(_seconds(query), _seconds(kernel)) for _ in range(size.runs + 1)][1:]
    finally:
        set_threads(None)
    return min(wall for wall, _ in turns), min(alone for _, alone in turns)


def rate(name: str, threads: int) -> Callable[[Size], Measured]:
    """Millions of rays a second; threads: 0 for all."""

    def measure(size: Size) -> Measured:
        count = _query(name, size)[1]
        wall, alone = wall_and_kernel(name, size, threads or thread_count())
        return Measured(count / wall / 1e6, count / alone / 1e6, alone / wall, "Mray/s")

    return measure


def beyond_kernel(name: str) -> Callable[[Size], Measured]:
    """Milliseconds on all threads that are not the kernel's, and the kernel's; the ratio: its share of the time."""

    def measure(size: Size) -> Measured:
        wall, alone = wall_and_kernel(name, size, thread_count())
        return Measured(1e3 * (wall - alone), 1e3 * alone, alone / wall, "ms")

    return measure


def serial_share(seconds: dict[int, float]) -> float:
    """The intercept of Amdahl's law in percent of the time on one thread, by least squares; from 0 to 100."""
    slope, intercept = np.polyfit([1 / threads for threads in seconds], list(seconds.values()), 1)
    return min(100.0, max(0.0, 100.0 * float(intercept / (intercept + slope))))


def serial(name: str) -> Callable[[Size], Measured]:
    """Measure the serial share of a query in percent; its limit is the largest share that the row allows."""

    def measure(size: Size) -> Measured:
        most = max(2, thread_count())
        counts = sorted({most, *(1 << k for k in range(most.bit_length()))})
        share = serial_share({threads: wall_and_kernel(name, size, threads)[0] for threads in counts})
        return Measured(share, _SHARE, _SHARE / max(share, 0.01), "%")

    return measure


def alone(name: str) -> Callable[[Size], Measured]:
    """Measure the work of the main thread while no other works, in percent: with two threads it else waits for them."""

    def measure(size: Size) -> Measured:
        query, _ = _query(name, size)
        set_threads(2)
        try:
            query()
            main, every = time.thread_time(), time.process_time()
            for _ in range(size.runs):
                query()
            share = 100.0 * (time.thread_time() - main) / max(time.process_time() - every, 1e-9)
        finally:
            set_threads(None)
        return Measured(share, _SHARE, _SHARE / max(share, 0.01), "%")

    return measure


def counter(size: Size) -> Measured:
    """Measure pieces that take hardly longer than to take them from the counter."""
    rays = np.ones(3 * size.rays)
    calls = [(rays, rays, 0, size.rays, np.zeros(1, np.int8))]

    def cost(threads: int) -> float:
        begin = time.process_time()
        pieces = SHIPPED.pieces(shipped_kernel(check_rays), *calls, 1, None)
        pieces.start(threads)
        while not pieces.wait(50):
            pass
        return 1e9 * (time.process_time() - begin) / size.rays

    if SHIPPED is None:
        raise Absent("no extension")
    ours, theirs = (min(cost(threads) for _ in range(size.runs)) for threads in (max(2, thread_count()), 1))
    return Measured(ours, theirs, theirs / ours, "ns")


_BALLS = "1,000 balls, from arrays"

ROWS = (
    *(
        BenchRow(
            f"arrays-{name}-{word}", QUERIES[name][0], f"{_BALLS}, {word} thread{'' if threads == 1 else 's'}", KERNEL,
            0.75, 0.9, rate(name, threads),
        )
        for name in ("camera", "random")
        for word, threads in (("1", 1), ("2", 2), ("all", 0))
    ),
    *(
        BenchRow(f"beyond-{name}", title, f"{_BALLS}, all threads", KERNEL, 0.0, 0.75, beyond_kernel(name))
        for name, (title, *_) in QUERIES.items()
    ),
    *(
        BenchRow(f"serial-{name}", title, f"{_BALLS}, serial share", LIMIT, 0.0, 1.0, serial(name))
        for name, (title, *_) in QUERIES.items()
    ),
    *(
        BenchRow(f"alone-{name}", title, f"{_BALLS}, the main thread", LIMIT, 0.0, 1.0, alone(name))
        for name, (title, *_) in QUERIES.items()
    ),
    BenchRow("counter", "checks of one ray", "pieces of the threads", ONE_THREAD, 0.0, 0.9, counter),
)  # fmt: skip
