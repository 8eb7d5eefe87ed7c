"""What a process that compiles ahead does (see `ahead`): the calls that make each job's kernels, on an empty scene.

It reads names of jobs, a line each, and ends at an empty line, or when the pipe is closed. It writes
"begin KERNEL", "made KERNEL" and "done JOB".
"""

from __future__ import annotations

import os
import queue
import sys
import threading
from collections.abc import Callable, Mapping
from functools import partial

from .compiler import ahead
from .compiler import cache as jit_cache
from .integrators import INTEGRATORS


def picture(integrator: str) -> None:
    """What renders."""
    from .scene import Scene

    Scene([]).render(1, 1, samples=1, integrator=integrator)


def rays() -> None:
    """First hits of coherent rays: enough of them that their coherence is tested."""
    import numpy as np

    from .scene import Scene

    Scene([]).first_hit(np.zeros((64, 64, 3)), (0.0, 0.0, 1.0))


def streams() -> None:
    """First hits of rays in no order: what begins before its origin is in order only where it is parallel."""
    import numpy as np

    from .scene import Scene

    every = np.random.default_rng(0).normal(size=(4096, 3))
    Scene([]).first_hit(every, every, t_min=-1.0)


def points() -> None:
    """Faces, points and normals of hits."""
    from .scene import Scene

    hits = Scene([]).first_hit((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    for _ in (hits.surface, hits.normal):
        pass


CALLS: dict[str, Callable[[], None]] = {
    **{each.kernel: partial(picture, each.name) for each in INTEGRATORS.values()},
    "rays": rays,
    "streams": streams,
    "points": points,
}


def tell(word: str, name: str) -> None:
    """A line to the process that waits."""
    sys.stdout.write(f"{word} {name}\n")
    sys.stdout.flush()


def _read(jobs: queue.SimpleQueue[str]) -> None:
    """Queue jobs as they are read; at the end of the pipe the process ends at once, without cleaning up."""
    while job := sys.stdin.readline().strip():
        jobs.put(job)
    os._exit(0)


def main(calls: Mapping[str, Callable[[], object]] = CALLS) -> None:
    """Do the jobs that come in by stdin."""
    ahead.alone()
    jit_cache.tell = tell
    jobs: queue.SimpleQueue[str] = queue.SimpleQueue()
    threading.Thread(target=_read, args=(jobs,), daemon=True).start()
    while True:
        job = jobs.get()
        calls[job]()
        tell("done", job)
