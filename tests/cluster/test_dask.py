"""Dask: its executor, and arrays that stay lazy. The scheduler and its workers are real."""

import signal
import sys
import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import conicoid as co

from . import subject
from .schedulers import cluster
from .test_deaths import kill_workers

da = pytest.importorskip("dask.array")
distributed = pytest.importorskip("distributed")

pytestmark = pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning")
"""Warnings of sockets that Dask closes after its loop."""


def lazy(rays, *chunks):
    """Return the rays as arrays of Dask, in blocks of different sizes."""
    origins = da.from_array(rays.origins, chunks=(*chunks, 2))
    directions = da.from_array(rays.directions, chunks=(*(max(1, c // 2) for c in chunks), 3))
    return origins, directions


def check_arrays(scene, rays):
    """Compare every query of arrays of Dask, by the active scheduler."""
    lines, ends = lazy(rays, 2, 30), np.linspace(3, 9, rays.shape[-1])
    local, hits = scene.first_hit(rays, None, 0, ends), scene.first_hit(*lines, t_max=ends)
    fields = [name for name in dir(hits) if name not in ("blocks", "shape")]
    values = da.compute(*(getattr(hits, name) for name in fields))
    for name, found in zip(fields, values, strict=True):
        lazily, expected = getattr(hits, name), getattr(local, name)
        assert (lazily.shape, lazily.dtype, found.dtype) == (expected.shape, expected.dtype, expected.dtype), name
        assert np.array_equal(found, expected, equal_nan=expected.dtype.kind == "f"), name
    spans, expected = scene.spans(*lines), scene.spans(rays)
    sums = spans.counts, spans.lengths(), spans.line_integral(subject.VALUES), scene.occluded(*lines)
    counts, lengths, integral, occluded = da.compute(*sums)
    assert np.array_equal(counts.ravel(), np.diff(expected.offsets))
    assert np.array_equal(lengths, expected.lengths())
    assert np.array_equal(integral, expected.line_integral(subject.VALUES))
    assert np.array_equal(occluded, scene.occluded(rays))
    points = np.clip(rays.origins, -1, 1)
    assert np.array_equal(scene.body_at(da.from_array(points, chunks=20)).compute(), scene.body_at(points))
    assert np.array_equal(scene.contains(da.from_array(points, chunks=20)).compute(), scene.contains(points))


def test_arrays_are_lazy_and_the_same_to_the_bit():
    check_arrays(subject.scene(), subject.rays(5, 40))


def test_chunks_are_those_of_the_rays():
    scene, rays = subject.scene(), subject.rays(6, 40)
    origins = da.from_array(rays.origins, chunks=(2, 20, 3))
    hits = scene.first_hit(origins, rays.directions)
    assert hits.t.chunks == ((2, 2, 2), (20, 20))
    assert hits.point.chunks == ((2, 2, 2), (20, 20), (3,))
    assert scene.line_integral([1, 2, 3, 4], origins, (0, 0, 1)).chunks == ((2, 2, 2), (20, 20))
    persistent = hits.t.persist(scheduler="synchronous")
    assert float(persistent.min().compute(scheduler="synchronous")) == scene.first_hit(rays).t.min()


def test_spans_as_a_bag():
    scene, rays = subject.scene(), subject.rays(5, 40)
    origins, directions = lazy(rays, 5, 40)
    found = scene.spans(origins, directions).bag.map(lambda spans: spans.t_exit).compute(scheduler="synchronous")
    assert sorted(np.concatenate(found)) == sorted(scene.spans(rays).t_exit)


def test_mistakes_are_named_before_anything_is_computed():
    scene, rays = subject.scene(), subject.rays(40)
    origins = da.from_array(rays.origins, chunks=10)
    for call, error, message in (
        (lambda: scene.first_hit(origins), TypeError, "first_hit: directions are missing"),
        (
            lambda: scene.occluded(origins, np.zeros((40, 2))),
            ValueError,
            r"occluded: directions must be an array \(..., 3\) of known chunks",
        ),
        (
            lambda: scene.spans(origins, rays.directions[:7]),
            ValueError,
            "spans: origins, directions, t_min and t_max do not fit together",
        ),
        (
            lambda: scene.first_hit(origins, rays.directions, executor=ThreadPoolExecutor(1)),
            TypeError,
            "first_hit: executor must be left out for Dask's arrays",
        ),
        (lambda: scene.first_hit(origins, rays.directions).normals, AttributeError, "LazyHits has no field 'normals'"),
    ):
        with pytest.raises(error, match=message):
            call()


def test_a_scheduler_and_its_workers():
    scene, rays = subject.scene(), subject.rays(5, 40)
    with cluster(1, 2) as scheduler, distributed.Client(scheduler) as client:
        check_arrays(scene, rays)
        large, local = subject.large_scene(), subject.answers(scene, rays)
        assert large.first_hit(rays, executor=client) == large.first_hit(rays)
        for chunk in (70, rays.size):  # a part of the grid of the deep suite
            workers = co.parallel.Workers(client, chunk=chunk)
            assert subject.differences(local, subject.answers(scene, rays, executor=workers)) == []
        picture = scene.render(70, 70, executor=client)
        executor = client.get_executor()
    assert np.array_equal(picture.pixels, scene.render(70, 70).pixels)
    with pytest.raises(ValueError, match="first_hit: executor takes no more tasks"):
        scene.first_hit(rays, executor=executor)


def pids(scheduler):
    """Return the numbers of the workers' processes, from the nannies that watch them."""
    return [nanny.pid for nanny in scheduler.workers.values() if nanny.pid]


@pytest.mark.deep
@pytest.mark.skipif(sys.platform == "win32", reason="SIGKILL")
def test_workers_killed_twenty_times():
    scene, rays = subject.scene(), subject.rays(200_000)
    expected = scene.first_hit(rays)
    with cluster(3) as scheduler, distributed.Client(scheduler) as client:
        left, done = [20], threading.Event()
        killer = threading.Thread(target=kill_workers, args=(lambda: pids(scheduler), left, (signal.SIGKILL,), done))
        killer.start()
        executor = co.parallel.Workers(client, chunk=2000, retries=20)
        while left[0] > 0:
            assert np.array_equal(scene.first_hit(rays, executor=executor).t, expected.t)
        done.set()
        killer.join()
        assert scene.first_hit(rays, executor=executor) == expected
