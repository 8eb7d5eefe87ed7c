"""Worker processes that are killed or stopped while they work."""

import os
import random
import signal
import sys
import threading
import time

import pytest

import conicoid as co

from . import subject

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals")


def kill_workers(pids, times, signals, done):
    """Send signals to random processes of those that `pids` returns, so many times, while work goes on."""
    rng = random.Random(7)
    while times[0] > 0 and not done.is_set():
        time.sleep(rng.uniform(0.05, 0.4))
        if alive := pids():
            pid = rng.choice(alive)
            os.kill(pid, signals[0])
            if len(signals) > 1:
                time.sleep(rng.uniform(0.05, 0.4))
                os.kill(pid, signals[1])
            times[0] -= 1


@pytest.mark.parametrize(
    ("times", "signals"),
    [
        (2, (signal.SIGKILL,)),
        pytest.param(20, (signal.SIGKILL,), marks=pytest.mark.deep),
        pytest.param(20, (signal.SIGSTOP, signal.SIGCONT), marks=pytest.mark.deep),
    ],
)
def test_no_result_is_lost(times, signals):
    scene, rays = subject.scene(), subject.rays(3000)
    expected, left, done = scene.first_hit(rays), [times], threading.Event()
    with co.parallel.Processes(2, retries=20) as pool:
        executor = co.parallel.Workers(pool, chunk=500, retries=20)
        killer = threading.Thread(target=kill_workers, args=(lambda: pool.pids, left, signals, done))
        killer.start()
        while left[0] > 0:
            assert scene.first_hit(rays, executor=executor) == expected
        killer.join()
        assert scene.first_hit(rays, executor=executor) == expected
