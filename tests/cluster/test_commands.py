"""Workers give the answers of one process: commands, measures, pictures, lazy rays."""

import contextlib
import errno
import os
import pickle
import signal
import sys

import numpy as np
import pytest

import conicoid as co
from conicoid.parallel.pictures import Checkpoint
from conicoid.parallel.workers import inline_workers

from ..command_line import execute, failure, run
from ..interruptions import Interruption
from . import subject

# --- `conicoid trace --chunk` and `conicoid render` with workers write the same files as without


def traced(folder, rays, output, *options):
    execute("trace", folder / "scene.yaml", folder / rays, "-o", folder / output, *options)
    return folder / output


@pytest.mark.parametrize("rays", ["rays.npy", "rays.csv", "picture.npy"])
def test_chunks_write_the_same(folder, rays):
    for options in ((), ("--spans",)):
        whole = traced(folder, rays, "whole.csv", *options)
        parts = traced(folder, rays, "parts.csv", *options, "--chunk", 37)
        assert parts.read_bytes() == whole.read_bytes()
    whole, parts = traced(folder, rays, "whole.npz"), traced(folder, rays, "parts.npz", "--chunk", 37)
    assert co.Hits.load(parts) == co.Hits.load(whole)
    assert sorted(path.suffix for path in folder.iterdir() if path.is_dir()) == []


def test_workers_write_the_same(folder):
    pytest.importorskip("OpenEXR")
    whole = traced(folder, "rays.npy", "whole.csv")
    assert traced(folder, "rays.npy", "parts.csv", "--chunk", 100, "--workers", 1).read_bytes() == whole.read_bytes()
    options = "--width", 70, "--height", 40
    for name, more in (("here", ()), ("there", ("--workers", 1, "--resume", folder / "tiles"))):
        assert run("render", folder / "scene.yaml", "-o", folder / f"{name}.exr", *options, *more).exit_code == 0
    assert (folder / "here.exr").read_bytes() == (folder / "there.exr").read_bytes()
    assert not (folder / "tiles").exists()  # the picture is complete


def test_mistakes(folder, tmp_path):
    scene = folder / "scene.yaml"

    (tmp_path / "done.zarr").mkdir()
    bad = np.load(folder / "rays.npy")
    bad[300, 3:] = 0
    np.save(folder / "bad.npy", bad)
    for message, rays, output, *options in (
        ("--resume goes with --chunk", "rays.npy", "x.csv", "--resume"),
        ("done.zarr: is a folder without parts to go on with", "rays.npy", "done.zarr", "--resume"),
        ("ray 300: direction must not be zero", "bad.npy", "x.csv", "--chunk", 64),
        ("--resume goes on with it", "bad.npy", "x.csv", "--chunk", 64),
        ("holds results of other rays", "rays.npy", "x.csv", "--chunk", 64, "--resume"),
    ):
        assert message in failure("trace", scene, folder / rays, "-o", folder / output, *options)
    assert "give either --workers or --cluster" in failure(
        "render", scene, "-o", folder / "x.png", "--workers", 2, "--cluster", "tcp://127.0.0.1:1"
    )


# --- Measures on workers


LENS = (co.Sphere(1) & co.Sphere(1, (0.5, 0.5, 0)) & co.Sphere(1, (0, 0.4, 0.3))).rotate((1, 2, 3), 25)
FIELDS = "volume area centroid inertia volume_error area_error centroid_error inertia_error rays".split()


def numbers(measures):
    return {name: np.asarray(getattr(measures, name)).tolist() for name in FIELDS}


@pytest.mark.parametrize("count", [2, *(pytest.param(count, marks=pytest.mark.deep) for count in (1, 3, 4))])
def test_the_rays_of_one_shape_are_shared_out(count, processes, noted_calls):
    """Each piece has sums of its own, which are added in order, whatever the workers and their BLAS."""
    done, near = [], numbers(co.measure(LENS, rays=200_000, seed=3))
    tasks = noted_calls(co.parallel.Processes, "submit")
    with contextlib.nullcontext(processes) if count == 2 else co.parallel.Processes(count) as pool:
        far = co.measure(LENS, rays=200_000, seed=3, executor=pool, progress=lambda *step: done.append(step))
    assert numbers(far) == near
    assert near["volume_error"] > 0
    scene = subject.scene()
    far, local = ([*map(numbers, co.measure(scene, rays=600, **options))] for options in (dict(executor=processes), {}))
    assert far == local
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
    assert numbers(far) == numbers(co.measure(LENS, rays=60_000))


# --- Pictures in tiles on workers, and pictures that continue after the driver was stopped


def test_tiles_of_workers_to_the_bit(processes):
    scene = subject.scene()
    local = scene.render(100, 70, samples=2, axes=True)
    calls = []
    for chunk in (1, 5, None):
        executor = co.parallel.Workers(processes, chunk=chunk)
        far = scene.render(100, 70, samples=2, axes=True, executor=executor, progress=lambda *step: calls.append(step))
        assert np.array_equal(far.pixels, local.pixels)
    assert calls[-1] == (4 * 3, 4 * 3)  # tiles of 32 pixels


def test_a_picture_goes_on(tmp_path):
    scene, file = subject.scene(), tmp_path / "tiles"
    local = scene.render(100, 70, samples=1)
    workers = inline_workers()
    workers.chunk = 1
    with pytest.raises(KeyboardInterrupt):
        scene.render(100, 70, samples=1, resume=file, executor=workers, progress=Interruption(5))
    with open(file, "ab") as cut:
        cut.write(b"what was being written when the power went")
    calls = []
    image = scene.render(100, 70, samples=1, resume=file, executor=workers, progress=lambda *step: calls.append(step))
    assert np.array_equal(image.pixels, local.pixels)
    assert calls[0][0] == 5  # tiles 0 to 3 are in the file, and one is new
    image = scene.render(100, 70, samples=1, resume=file, progress=Interruption())  # all of them are in the file
    assert np.array_equal(image.pixels, local.pixels)
    with pytest.raises(ValueError, match="holds parts of other work"):
        scene.render(100, 70, samples=2, resume=file)


def test_other_files_are_not_touched(tmp_path):
    file = tmp_path / "letter.txt"
    file.write_text("Dear reader, this is no checkpoint.")
    with pytest.raises(ValueError, match="holds parts of something else"):
        subject.scene().render(40, 40, resume=file)
    assert file.read_text() == "Dear reader, this is no checkpoint."


def test_damaged_parts_are_done_again(tmp_path):
    file = tmp_path / "parts"
    checkpoint = Checkpoint(file, b"key")
    for k in range(3):
        checkpoint.add(k, k + 1, bytes([k]) * 10)
    checkpoint.close()
    data = bytearray(file.read_bytes())
    data[-15] ^= 1  # in the last part
    file.write_bytes(data)
    reopened = Checkpoint(file, b"key")
    assert list(reopened.records()) == [(0, 1, b"\0" * 10), (1, 2, b"\1" * 10)]
    reopened.add(2, 3, b"new")
    reopened.close()
    last = Checkpoint(file, b"key")
    assert list(last.records())[2] == (2, 3, b"new")
    last.close()


@pytest.mark.skipif(sys.platform != "linux", reason="/dev/full is Linux's")
def test_a_full_disk_is_named():
    checkpoint = object.__new__(Checkpoint)
    checkpoint.path, checkpoint.file = "/dev/full", open("/dev/full", "wb")  # noqa: SIM115
    with pytest.raises(OSError, match="No space left") as caught:
        checkpoint.add(0, 1, b"data")
    assert (caught.value.errno, caught.value.filename) == (errno.ENOSPC, "/dev/full")
    with pytest.raises(OSError, match="No space left"):
        checkpoint.close()


# --- Rays that workers make as they trace them, and answers that no process holds as a whole

CAMERAS = [co.Camera((5, 1, 2), (0, 0, 0)), co.OrthographicCamera((5, 1, 2), (0, 0, 0), height=3)]


@pytest.mark.parametrize("camera", CAMERAS)
def test_rays_of_cameras_to_the_bit(camera):
    lazy, rays = co.Rays.from_camera(camera, 33, 20), camera.rays(33, 20)
    assert lazy.shape == rays.shape
    assert lazy.to_rays() == rays
    assert lazy.part(100, 140) == co.Rays(rays.origins.reshape(-1, 3), rays.directions.reshape(-1, 3))[100:140]
    assert len(pickle.dumps(lazy)) < 500  # however many rays there are


SCAN = co.ct.parallel3d([0, 90], 7, 11)


@pytest.mark.parametrize(
    "lazy", [co.Rays.from_camera(CAMERAS[0], 7, 11), co.Rays.from_scan(SCAN)], ids=["camera", "scan"]
)
def test_parts_that_are_not_in_the_list_are_refused(lazy):
    assert lazy.part(lazy.size, lazy.size).shape == (0,)
    for begin, end in ((lazy.size - 7, lazy.size + 1), (lazy.size, lazy.size + 1), (-3, 4), (4, 3)):
        with pytest.raises(
            IndexError, match=f"^part: begin and end must lie within 0 and {lazy.size}, got {begin} and"
        ):
            lazy.part(begin, end)
    with pytest.raises(ValueError, match="^part: shape must be one of 10 rays"):
        lazy.part(0, 10, (3, 3))


def test_queries_take_them(processes):
    scene, lazy = subject.scene(), co.Rays.from_camera(CAMERAS[0], 33, 20)
    rays = lazy.to_rays()
    for options in ({}, dict(executor=co.parallel.Workers(processes, chunk=100))):
        assert scene.first_hit(lazy, **options) == scene.first_hit(rays)
        assert scene.spans(lazy, **options) == scene.spans(rays)
        sums = scene.line_integral(subject.VALUES, lazy, **options)
        assert np.array_equal(sums, scene.line_integral(subject.VALUES, rays))
    with pytest.raises(TypeError, match="is no array of numbers"):
        np.asarray(lazy)
    with pytest.raises(TypeError, match="from_camera: camera must be a Camera"):
        co.Rays.from_camera("camera", 3, 3)


def parts_of(rays, directory):
    """Return the same rays in every form that `stream` takes."""
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
    expected = scene.first_hit(rays)
    for name, form in parts_of(rays, tmp_path):
        parts = list(scene.stream(form, chunk=17))
        assert max(part.size for part in parts) <= 17, name
        assert np.array_equal(np.concatenate([part.t for part in parts]), expected.t), name
        assert np.array_equal(np.concatenate([part.normal for part in parts]), expected.normal, equal_nan=True), name


@pytest.mark.parametrize(("query", "options"), [
    ("occluded", {}), ("lengths", {}), ("line_integral", dict(values=subject.VALUES)), ("spans", dict(t_max=7.0)), ("crossings", {}),
])  # fmt: skip
def test_every_query_streams(query, options, processes):
    scene, rays = subject.scene(), subject.rays(100)
    whole = (
        getattr(scene, query)(*options.values(), rays)
        if "values" in options
        else getattr(scene, query)(rays, **options)
    )
    for executor in (None, processes):
        parts = list(scene.stream(rays, query, chunk=31, executor=executor, **options))
        joined = type(whole).concatenate(parts) if query in ("spans", "crossings") else np.concatenate(parts)
        assert np.array_equal(joined, whole) if isinstance(whole, np.ndarray) else joined == whole


def test_unstreamable_files_are_refused():
    scene = subject.scene()
    for call, error, message in (
        (
            lambda: scene.stream(subject.rays(3), "span"),
            ValueError,
            r"stream: query must be one of first_hit.*\(did you mean 'spans'\?\)",
        ),
        (lambda: scene.stream(subject.rays(3), "line_integral"), TypeError, "stream: line_integral needs values="),
        (lambda: list(scene.stream(5)), TypeError, "stream: rays must be Rays, arrays or an iterable of such"),
        (lambda: list(scene.stream(np.zeros((4, 5)))), ValueError, r"rays: origins must be an array of shape \(n, 6\)"),
    ):
        with pytest.raises(error, match=message):
            call()
