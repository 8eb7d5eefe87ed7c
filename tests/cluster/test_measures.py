"""Measures on workers."""

from __future__ import annotations

import os
import signal

import numpy as np
import pytest

import conicoid as co

from . import subject


def test_measures_of_workers_are_the_same():
    scene, lens = subject.scene(), co.Sphere(1) & co.Sphere(1, (0.5, 0.5, 0)) & co.Sphere(1, (0, 0.4, 0.3))
    with co.parallel.Processes(1) as pool:
        far, one = co.measure(scene, rays=600, executor=pool), co.measure(lens, rays=600, executor=pool)
    near = co.measure(scene, rays=600)
    assert np.array_equal(far.volume, near.volume)
    assert np.array_equal(far.volume_error, near.volume_error)
    assert [body.area for body in far] == [body.area for body in near]
    local = co.measure(lens, rays=600)
    assert (one.volume, one.area, one.volume_error) == (local.volume, local.area, local.volume_error)
    assert one.volume_error > 0  # it was sampled


LENS = (co.Sphere(1) & co.Sphere(1, (0.5, 0.5, 0)) & co.Sphere(1, (0, 0.4, 0.3))).rotate((1, 2, 3), 25)
FIELDS = "volume area centroid inertia volume_error area_error centroid_error inertia_error rays".split()


def told(measures):
    return {name: np.asarray(getattr(measures, name)).tolist() for name in FIELDS}


@pytest.mark.parametrize(
    "count",
    [
        2,
        pytest.param(1, marks=pytest.mark.deep),
        pytest.param(3, marks=pytest.mark.deep),
        pytest.param(4, marks=pytest.mark.deep),
    ],
)
def test_the_rays_of_one_shape_are_shared_out(count):
    """Whatever the workers and their BLAS: each piece has sums of its own, which are added in order."""
    done, near = [], told(co.measure(LENS, rays=200_000, seed=3))
    tasks = []

    class Counting(co.parallel.Processes):
        def submit(self, fn, /, *arguments, **keywords):
            tasks.append(fn)
            return super().submit(fn, *arguments, **keywords)

    with Counting(count) as pool:
        far = co.measure(LENS, rays=200_000, seed=3, executor=pool, progress=lambda *step: done.append(step))
    assert told(far) == near
    assert near["volume_error"] > 0
    assert len(tasks) > 6
    assert done[-1] == (200_000, 200_000)
    assert [step for step, _ in done] == sorted(step for step, _ in done)


@pytest.mark.deep
@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="SIGKILL")
def test_a_worker_dies_while_it_measures():
    with co.parallel.Processes(2, retries=3) as pool:
        killed = []

        def kill(*_):
            if not killed and pool.pids:
                killed.append(os.kill(pool.pids[0], signal.SIGKILL))

        far = co.measure(LENS, rays=60_000, executor=pool, progress=kill)
    assert killed
    assert told(far) == told(co.measure(LENS, rays=60_000))
