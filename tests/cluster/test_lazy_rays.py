"""Rays that are made where they are traced, and answers that are never held as a whole."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import conicoid as co

from . import subject

CAMERAS = [co.Camera((5, 1, 2), (0, 0, 0)), co.OrthographicCamera((5, 1, 2), (0, 0, 0), height=3)]


@pytest.mark.parametrize("camera", CAMERAS)
def test_rays_of_cameras_to_the_bit(camera):
    lazy, rays = co.Rays.from_camera(camera, 33, 20), camera.rays(33, 20)
    assert lazy.shape == rays.shape
    assert lazy.to_rays() == rays
    assert lazy.part(100, 140) == co.Rays(rays.origins.reshape(-1, 3), rays.directions.reshape(-1, 3))[100:140]
    assert len(pickle.dumps(lazy)) < 500  # however many rays they are


def test_queries_take_them():
    scene, lazy = subject.scene(), co.Rays.from_camera(CAMERAS[0], 33, 20)
    rays = lazy.to_rays()
    with co.parallel.Processes(1) as pool:
        for how in ({}, dict(executor=co.parallel.Workers(pool, chunk=100))):
            assert scene.first_hit(lazy, **how) == scene.first_hit(rays)
            assert scene.spans(lazy, **how) == scene.spans(rays)
            assert np.array_equal(
                scene.line_integral(subject.VALUES, lazy, **how), scene.line_integral(subject.VALUES, rays)
            )
    with pytest.raises(TypeError, match="is no array of numbers"):
        np.asarray(lazy)
    with pytest.raises(TypeError, match="from_camera: camera must be a Camera"):
        co.Rays.from_camera("camera", 3, 3)


def parts_of(rays, directory):
    """The same rays as everything that `stream` takes."""
    flat = np.concatenate([rays.origins.reshape(-1, 3), rays.directions.reshape(-1, 3)], axis=1)
    np.save(directory / "rays.npy", flat)
    on_disk = np.load(directory / "rays.npy", mmap_mode="r")
    yield "Rays", rays
    yield "array", flat
    yield "memory map", on_disk
    yield "pair", (on_disk[:, :3], on_disk[:, 3:])
    yield "generator", ((flat[a : a + 13, :3], flat[a : a + 13, 3:]) for a in range(0, len(flat), 13))
    yield (
        "parts of records",
        (np.frombuffer(b"-" + flat[a : a + 50].tobytes(), offset=1).reshape(-1, 6) for a in (0, 50)),
    )


def test_streams_of_anything(tmp_path):
    scene, rays = subject.scene(), subject.rays(100)
    wanted = scene.first_hit(rays)
    for name, given in parts_of(rays, tmp_path):
        parts = list(scene.stream(given, chunk=17))
        assert max(part.size for part in parts) <= 17, name
        assert np.array_equal(np.concatenate([part.t for part in parts]), wanted.t), name
        assert np.array_equal(np.concatenate([part.normal for part in parts]), wanted.normal, equal_nan=True), name


def test_every_query_streams():
    scene, rays = subject.scene(), subject.rays(100)
    for executor in (None, co.parallel.Processes(1)):
        how = dict(chunk=31, executor=executor)
        assert np.array_equal(np.concatenate(list(scene.stream(rays, "occluded", **how))), scene.occluded(rays))
        assert np.array_equal(np.concatenate(list(scene.stream(rays, "lengths", **how))), scene.lengths(rays))
        total = np.concatenate(list(scene.stream(rays, "line_integral", values=subject.VALUES, **how)))
        assert np.array_equal(total, scene.line_integral(subject.VALUES, rays))
        spans = list(scene.stream(rays, "spans", t_max=7.0, **how))
        assert np.array_equal(np.concatenate([s.t_exit for s in spans]), scene.spans(rays, t_max=7.0).t_exit)
        assert np.array_equal(
            np.concatenate([s.t_exit_error for s in spans]), scene.spans(rays, t_max=7.0).t_exit_error
        )
        found = list(scene.stream(rays, "crossings", **how))
        assert np.array_equal(np.concatenate([c.normal for c in found]), scene.crossings(rays).normal)
        if executor is not None:
            executor.shutdown()


def test_what_cannot_be_streamed():
    scene = subject.scene()
    with pytest.raises(ValueError, match=r"stream: query must be one of first_hit.*\(did you mean 'spans'\?\)"):
        scene.stream(subject.rays(3), "span")
    with pytest.raises(TypeError, match="stream: line_integral needs values="):
        scene.stream(subject.rays(3), "line_integral")
    with pytest.raises(TypeError, match="stream: rays must be Rays, arrays or an iterable of such"):
        list(scene.stream(5))
    with pytest.raises(ValueError, match=r"rays: origins must be an array of shape \(n, 6\)"):
        list(scene.stream(np.zeros((4, 5))))


def test_numbers_that_are_not_aligned():
    # As they come out of messages and records: NumPy says of such that their elements are of another kind
    def odd(values):
        array = np.asarray(values, float)
        return np.frombuffer(b"-" + array.tobytes(), offset=1).reshape(array.shape)

    scene, rays = subject.scene(), subject.rays(50)
    ends, points = np.linspace(3, 9, 50), np.clip(rays.origins, -1, 1)
    assert not odd(ends).flags.aligned
    assert scene.first_hit(odd(rays.origins), odd(rays.directions), 0, odd(ends)) == scene.first_hit(
        rays, None, 0, ends
    )
    assert np.array_equal(scene.lengths(rays, None, 0, odd(ends)), scene.lengths(rays, None, 0, ends))
    assert np.array_equal(scene.contains(odd(points)), scene.contains(points))
