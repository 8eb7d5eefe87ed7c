"""Turntables and movies, in one process and on workers."""

import io
import os
import signal
import sys
from pathlib import Path

import numpy as np
import PIL.Image
import PIL.ImageSequence
import pytest

import conicoid as co
from conicoid.io.image_codecs import _durations
from conicoid.parallel.workers import inline_workers
from conicoid.scene import movies as frames
from conicoid.scene.movies import _views

from ..children import ROOT, child, needs_signals
from ..command_line import execute, failure, run

# --- Turntables: the contents of the file, rendered frames and frames from before

SMALL = dict(width=32, height=24, samples=1)
POSTS = [co.Body(co.Cylinder((2, 0, 0), (2, 0, 1), 0.3), "red", "post"), co.Body(co.Sphere(1), "white", "ball")]
SCENE = co.Scene(POSTS, lights=co.AmbientLight(1), background="black")


def _frames(path: Path) -> list[np.ndarray]:
    if path.suffix != ".mp4":
        with PIL.Image.open(path) as file:
            return [np.asarray(frame.convert("RGB")) for frame in PIL.ImageSequence.Iterator(file)]
    import av

    with av.open(str(path)) as movie:
        return [frame.reformat(format="rgb24", src_colorspace="ITU709").to_ndarray() for frame in movie.decode(video=0)]


@pytest.mark.parametrize(("suffix", "most"), [(".gif", 12), (".webp", 0), (".mp4", 12)])
def test_the_file_holds_the_frames(tmp_path, suffix, most):
    path = tmp_path / f"spin{suffix}"
    assert co.turntable(SCENE, path, frames=5, seconds=2, **SMALL) == 5
    views = list(_views(SCENE, None, 5, 32 / 24))
    found = _frames(path)
    for view, frame in zip(views, found, strict=True):
        expected = np.asarray(SCENE.render(**SMALL, camera=view)).astype(int)
        assert np.abs(frame - expected).mean() <= most
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["spin-frames", path.name]
    assert len(list((tmp_path / "spin-frames").iterdir())) == 5


def test_time_adds_up(tmp_path):
    assert sum(_durations(7, 2.0, 10)) == 2000
    assert set(_durations(7, 2.0, 10)) == {280, 290}
    path = tmp_path / "spin.gif"
    co.turntable(SCENE, path, frames=7, seconds=2, **SMALL)
    with PIL.Image.open(path) as file:
        assert file.info["loop"] == 0
        assert sum(frame.info["duration"] for frame in PIL.ImageSequence.Iterator(file)) == 2000
    import av

    co.turntable(SCENE, tmp_path / "spin.mp4", frames=7, seconds=2, **SMALL)
    with av.open(str(tmp_path / "spin.mp4")) as movie:
        assert movie.duration / av.time_base == pytest.approx(2, abs=0.02)
        assert movie.streams.video[0].codec_context.name == "h264"


def test_the_camera_goes_around_its_target():
    """The camera goes clockwise from above about `up` through the point, at one distance and height.

    A quarter turn is by hand.
    """
    camera = co.Camera((3, -4, 2), (3, 0, 0))
    views = list(_views(SCENE, camera, 4, 1))
    assert views[0] == camera
    assert [np.round(view.position, 12).tolist() for view in views[1:]] == [[-1, 0, 2], [3, 4, 2], [7, 0, 2]]
    assert {view.look_at for view in views} == {(3, 0, 0)}
    parallel = list(_views(SCENE, co.OrthographicCamera((0, 0, 5), (0, 0, 0), up=(0, 1, 0)), 2, 1))
    assert np.round(parallel[1].position, 12).tolist() == [0, 0, -5]


def test_a_fitting_camera_keeps_all_in_view_all_around():
    """The corners of the box are visible in every frame, and some nearly touch the edge."""
    scene = co.Scene(co.Box((0, 0, 0), (9, 1, 2)))
    corners = np.array([(x, y, z) for x in (0, 9) for y in (0, 1) for z in (0, 2)], float)
    places = np.array([view.project(corners, 80, 60) for view in _views(scene, None, 24, 80 / 60)]) / (80, 60)
    assert places.min() > 0
    assert places.max() < 1
    assert max(places.max(), 1 - places.min()) > 0.9


def test_frames_that_are_there_are_taken(tmp_path):
    once = dict(frames=4, folder=tmp_path / "frames", camera=co.Camera((9, 0, 4), (0, 0, 0)), **SMALL)
    assert co.turntable(SCENE, tmp_path / "a.gif", **once) == 4
    assert co.turntable(co.Scene(POSTS, co.AmbientLight(1), background="black"), tmp_path / "b.webp", **once) == 0
    assert len(_frames(tmp_path / "b.webp")) == 4
    assert co.turntable(SCENE, tmp_path / "a.gif", **(once | {"frames": 8})) == 4
    some = sorted((tmp_path / "frames").iterdir())
    some[0].unlink()
    some[1].write_bytes(some[1].read_bytes()[:-20])
    PIL.Image.new("RGB", (9, 9)).save(some[2])
    total = co.turntable(SCENE, tmp_path / "a.gif", **once)
    assert total + co.turntable(SCENE, tmp_path / "a.gif", **(once | {"frames": 8})) == 3
    some[0].unlink()
    os.mkfifo(some[0])  # no process reads from it
    with pytest.raises(OSError, match="is not a regular file"):
        co.turntable(SCENE, tmp_path / "a.gif", **(once | {"frames": 8}))


@pytest.mark.parametrize("change", [
    lambda scene: scene.replace("ball", co.Sphere(1.0000001)),
    lambda scene: scene.replace("ball", co.Body(co.Sphere(1), "#fffffe", "ball")),
    lambda scene: scene.replace("post", POSTS[0].shape.rotate("z", 1)),
    lambda scene: scene.replace(lights=co.AmbientLight(0.9)),
    lambda scene: scene.replace(background="#000001"),
    lambda scene: scene.replace("ball", co.Body(co.Sphere(1) - co.Sphere(0.2).painted("red"), "white", "ball")),
    lambda scene: scene.replace("ball", co.Spheres([(0, 0, 0)], 1.0)),
    lambda scene: scene.replace(camera=co.OrthographicCamera((9, 0, 0), (0, 0, 0), height=3)),
    dict(samples=2), dict(seed=1), dict(depth=0), dict(integrator="normals"), dict(width=34), dict(axes=True),
    dict(labels=True), dict(normals=True),
])  # fmt: skip
def test_stale_frames_are_not_taken(tmp_path, change):
    camera = co.Camera((9, 0, 4), (0, 0, 0))
    scene = SCENE.replace(camera=camera)
    assert co.turntable(scene, tmp_path / "a.gif", frames=1, **SMALL) == 1
    options = SMALL | (change if isinstance(change, dict) else {})
    changed = scene if isinstance(change, dict) else change(scene)
    assert co.turntable(changed, tmp_path / "a.gif", frames=1, **options) == 1
    assert co.turntable(changed, tmp_path / "a.gif", frames=1, **options) == 0


@pytest.mark.parametrize(("labels", "again"), [(False, 0), (True, 2)])
def test_names_matter_where_they_are_shown(tmp_path, labels, again):
    other = SCENE.replace("ball", co.Body(POSTS[1].shape, "white", "globe"))
    co.turntable(SCENE, tmp_path / "a.gif", frames=2, labels=labels, **SMALL)
    assert co.turntable(other, tmp_path / "a.gif", frames=2, labels=labels, **SMALL) == again


def test_frames_need_not_be_kept(tmp_path):
    co.turntable(SCENE, tmp_path / "a.gif", frames=2, keep=False, **SMALL)
    assert [entry.name for entry in tmp_path.iterdir()] == ["a.gif"]
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "notes.txt").write_text("x")
    co.turntable(SCENE, tmp_path / "a.gif", frames=2, keep=False, folder=tmp_path / "mine", **SMALL)
    assert [entry.name for entry in (tmp_path / "mine").iterdir()] == ["notes.txt"]


def test_progress(tmp_path):
    calls: list[float] = []
    co.turntable(SCENE, tmp_path / "a.gif", frames=3, progress=lambda done, count: calls.append(done / count), **SMALL)
    assert calls[-1] == 1
    assert {1 / 3, 2 / 3, 1.0} <= set(calls)


@pytest.mark.parametrize(("path", "options", "error", "message"), [
    ("a.avi", {}, ValueError, "turntable: movies are saved as .gif, .webp, .mp4, got '.*a.avi'"),
    ("a.mp4", dict(width=31), ValueError, "width and height of a .mp4 must be even, got 31 x 24"),
    ("a.gif", dict(frames=101, seconds=2), ValueError, "at most 50 frames a second, got 101 in 2 seconds"),
    ("a.gif", dict(frames=2, seconds=1400), ValueError, "a .gif shows a frame for at most 655 seconds, got 2 frames in"),
    ("a.webp", dict(frames=2, seconds=1e5), ValueError, "a .webp shows a frame for at most 16777 seconds, got 2 frames"),
    ("a.mp4", dict(frames=2, seconds=2001), ValueError, "a .mp4 shows a frame for at most 1000 seconds, got 2 frames in"),
    ("a.webp", dict(width=20_000), ValueError, "a .webp has at most 16383 pixels a side, got 20000 x 24"),
    ("a.gif", dict(frames=0), ValueError, "turntable: frames must be a whole number from 1 to 100000, got 0"),
    ("a.gif", dict(seconds=0), ValueError, "turntable: seconds must be > 0, got 0"),
    ("a.gif", dict(keep="no"), ValueError, "turntable: keep must be true or false, got 'no'"),
    ("a.gif", dict(samples=0), ValueError, "samples must be a whole number from 1"),
    ("a.gif", dict(camera="front"), TypeError, "turntable: camera must be a Camera"),
    ("none/a.gif", dict(frames=1), FileNotFoundError, "no such folder"),
])  # fmt: skip
def test_refusals(tmp_path, path, options, error, message):
    with pytest.raises(error, match=message):
        co.turntable(SCENE, tmp_path / path, **(SMALL | dict(frames=2) | options))
    assert list(tmp_path.iterdir()) == []


def test_a_missing_encoder_is_reported_before_the_work(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(
        ImportError, match=r"a .mp4 is written by PyAV: pip install 'conicoid\[video\]'; .gif and .webp"
    ):
        co.turntable(SCENE, tmp_path / "a.mp4", frames=2, **SMALL)
    assert list(tmp_path.iterdir()) == []


def test_a_full_disk_leaves_the_file_that_was_there(tmp_path, monkeypatch):
    path = tmp_path / "a.gif"
    co.turntable(SCENE, path, frames=2, **SMALL)
    before = path.read_bytes()

    def full(self, *arguments, **options):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(PIL.Image.Image, "save", full)
    with pytest.raises(OSError, match="No space left"):
        co.turntable(SCENE, path, frames=2, **SMALL)
    assert path.read_bytes() == before
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["a-frames", "a.gif"]


INTERRUPTED = """
import sys
import conicoid as co
scene = co.Scene([co.Sphere(1)])
def report(done, count):
    if done * 3 > count:
        print("begun", flush=True)
co.turntable(scene, sys.argv[1], frames=3, width=8, height=6, samples=1, folder=sys.argv[2])
co.turntable(scene, sys.argv[1], frames=3, width=320, height=240, samples=256, folder=sys.argv[3], progress=report)
"""


@needs_signals
def test_interrupted_films_are_resumed(tmp_path):
    """The earlier file stays as it was, frames are complete, and the first is not rendered again."""
    path, folder = tmp_path / "a.gif", tmp_path / "frames"
    with child(INTERRUPTED, path, tmp_path / "small", folder, cwd=ROOT) as running:
        assert running.line() == "begun", running.end()
        before = path.read_bytes()
        running.interrupt()
        code, _, errors = running.end()
    assert code not in (0, 1)
    assert errors.splitlines()[-1] == "KeyboardInterrupt"
    assert path.read_bytes() == before
    assert [entry.suffix for entry in folder.iterdir()] == [".png"] * len(list(folder.iterdir()))
    for frame in folder.iterdir():
        assert PIL.Image.open(io.BytesIO(frame.read_bytes())).size == (320, 240)
    assert 1 <= len(list(folder.iterdir())) < 3


# --- Films of scenes that move: their frames, which of them are rendered, and the command

TINY = dict(width=32, height=24, samples=2)
BALL = co.Scene(
    [co.Body(co.Sphere(0.5, (-1, 0, 0)), "red", "ball"), co.Box((-3, -3, -2), (3, 3, -1))],
    [co.AmbientLight(1)], co.Camera((0, -6, 2), (0, 0, 0)), "black",
    animation=co.scene.BodyTrack("ball", (0, 1), translate=((0, 0, 0), (2, 0, 0))),
)  # fmt: skip


@pytest.mark.parametrize("shutter", [0, 0.5])
def test_a_film_is_its_frames(tmp_path, shutter):
    path = tmp_path / "film.webp"
    assert co.animate(BALL, path, frames=4, shutter=shutter, **TINY) == 4
    for k, frame in enumerate(_frames(path)):
        time = k / 4
        if shutter == 0:
            image = BALL.at(time).render(**TINY)
        else:
            image = BALL.render(**TINY, shutter=(time, time + 0.125))
        assert (frame == np.asarray(image)).all()


def test_frames_that_are_there_are_not_made_again(tmp_path):
    path = tmp_path / "film.gif"
    assert co.animate(BALL, path, frames=4, **TINY) == 4
    assert co.animate(BALL, tmp_path / "film.webp", frames=4, **TINY) == 0
    assert co.animate(BALL, path, frames=8, shutter=1, **TINY) == 4, "every other one: the shutter is open as long"
    assert co.animate(BALL, path, frames=8, shutter=0, **TINY) == 8
    assert co.animate(BALL, path, frames=4, shutter=0, **TINY) == 0, "every other frame of eight"
    other = BALL.replace(animation=co.scene.BodyTrack("ball", (0, 1), translate=((0, 0, 0), (2, 0, 0.1))))
    assert co.animate(other, path, frames=4, shutter=0, keep=False, **TINY) == 4


def test_only_moving_bodies_are_prepared_for_each_frame(monkeypatch):
    """Every other shape of a moment is the one from the moment before, already prepared."""
    moved = BALL.at(0.4)
    assert moved.bodies[1].shape is BALL.bodies[1].shape
    assert moved.bodies[0].shape is not BALL.bodies[0].shape
    assert BALL.at(-1)._prepared is BALL._prepared


def test_the_command_animates(tmp_path):
    co.save(BALL, tmp_path / "scene.yaml")
    options = ("--width", 32, "--height", 24, "--samples", 2, "--frames", 3)
    first = execute("animate", tmp_path / "scene.yaml", "-o", tmp_path / "film.gif", *options)
    assert "3 frames of 32 x 24 pixels" in first.output
    again = run("animate", tmp_path / "scene.yaml", "-o", tmp_path / "film.gif", *options)
    assert "3 of them were there" in again.output
    execute("render", tmp_path / "scene.yaml", "-o", tmp_path / "a.png", *options[:6], "--shutter", "0,0.5")
    expected = BALL.render(32, 24, 2, shutter=(0, 0.5))
    assert (np.asarray(PIL.Image.open(tmp_path / "a.png")) == np.asarray(expected)).all()
    execute("render", tmp_path / "scene.yaml", "-o", tmp_path / "b.png", *options[:6], "--time", "0.5")
    assert (np.asarray(PIL.Image.open(tmp_path / "b.png")) == np.asarray(BALL.at(0.5).render(32, 24, 2))).all()


def test_scenes_without_animation_are_refused(tmp_path):
    co.save(BALL.replace(animation=()), tmp_path / "scene.yaml")
    assert "has no animation" in failure("animate", tmp_path / "scene.yaml", "-o", tmp_path / "film.gif")
    with pytest.raises(ValueError, match="shutter must be in"):
        co.animate(BALL, tmp_path / "a.gif", shutter=2)
    with pytest.raises(ValueError, match="seconds must be given"):
        co.animate(BALL, tmp_path / "a.gif", start=5)


# --- Frames as tasks: the same files as without, reused where they exist, and rendered again where a worker died


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_frames_of_workers_are_the_same(tmp_path):
    calls = []
    co.turntable(SCENE, tmp_path / "near.gif", frames=5, **SMALL)
    with co.parallel.Processes(2) as pool:
        count = co.turntable(
            SCENE, tmp_path / "far.gif", frames=5, **SMALL, executor=pool, progress=lambda *step: calls.append(step)
        )
        assert count == 5
        assert contents(tmp_path / "far-frames") == contents(tmp_path / "near-frames")
        assert (tmp_path / "far.gif").read_bytes() == (tmp_path / "near.gif").read_bytes()
        assert calls == [(k + 1, 5) for k in range(5)]
        files = sorted((tmp_path / "far-frames").iterdir())[:2]
        for path in files:
            path.unlink()
        assert co.turntable(SCENE, tmp_path / "far.gif", frames=5, **SMALL, executor=pool) == 2
    assert contents(tmp_path / "far-frames") == contents(tmp_path / "near-frames")


@pytest.mark.deep
@pytest.mark.parametrize("shutter", [0, 0.5])
def test_frames_of_films_too(tmp_path, shutter):
    calls, options = [], dict(frames=4, shutter=shutter, **SMALL)
    assert co.animate(BALL, tmp_path / "near.gif", **options) == 4
    with co.parallel.Processes(2) as pool:
        far = dict(path=tmp_path / "far.gif", executor=pool, progress=lambda *step: calls.append(step), **options)
        assert (co.animate(BALL, **far), co.animate(BALL, **far)) == (4, 0)
    assert (tmp_path / "near.gif").read_bytes() == (tmp_path / "far.gif").read_bytes()
    assert calls[:4] == [(k + 1, 4) for k in range(4)]


class DeadlyProcesses(co.parallel.Processes):
    """An executor that kills a process with its first task, twice."""

    left = 2

    def submit(self, fn, /, *arguments, **keywords):
        if self.left and frames.render_frame in arguments:
            self.left -= 1
            super().submit(os.kill, self.pids[0], signal.SIGKILL) if len(self.pids) > 1 else None
        return super().submit(fn, *arguments, **keywords)


@pytest.mark.skipif(sys.platform == "win32", reason="SIGKILL")
def test_a_worker_that_dies_costs_its_frame(tmp_path):
    with DeadlyProcesses(2, retries=5) as pool:
        assert co.turntable(SCENE, tmp_path / "far.gif", frames=6, **SMALL, executor=pool) == 6
    co.turntable(SCENE, tmp_path / "near.gif", frames=6, **SMALL)
    assert (tmp_path / "far.gif").read_bytes() == (tmp_path / "near.gif").read_bytes()


def test_finished_frames_stay_after_a_failure(tmp_path):
    class Stopping(Exception):
        pass

    def stop(done, count):
        if done == 3:
            raise Stopping

    with pytest.raises(Stopping):
        co.turntable(SCENE, tmp_path / "far.gif", frames=5, **SMALL, executor=inline_workers(), progress=stop)
    assert len(contents(tmp_path / "far-frames")) == 3
    assert co.turntable(SCENE, tmp_path / "far.gif", frames=5, **SMALL) == 2


def test_the_command_on_workers(tmp_path):
    co.save(SCENE, tmp_path / "scene.yaml")
    options = "--width", 32, "--height", 24, "--samples", 1, "--frames", 3
    for name, more in (("near", ()), ("far", ("--workers", 1))):
        execute("turntable", tmp_path / "scene.yaml", "-o", tmp_path / f"{name}.gif", *options, *more)
    assert (tmp_path / "far.gif").read_bytes() == (tmp_path / "near.gif").read_bytes()
