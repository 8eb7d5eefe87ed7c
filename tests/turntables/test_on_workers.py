"""Frames as tasks: the same files as without, taken where they are there, and made again where a worker died."""

from __future__ import annotations

import os
import signal
import sys

import pytest

import conicoid as co
from conicoid.scene import movies as frames
from tests.command_line import run

from .test_turntable import SCENE, SMALL


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_frames_of_workers_are_the_same(tmp_path):
    told = []
    co.turntable(SCENE, tmp_path / "near.gif", frames=5, **SMALL)
    with co.parallel.Processes(2) as pool:
        count = co.turntable(
            SCENE, tmp_path / "far.gif", frames=5, **SMALL, executor=pool, progress=lambda *step: told.append(step)
        )
        assert count == 5
        assert contents(tmp_path / "far-frames") == contents(tmp_path / "near-frames")
        assert (tmp_path / "far.gif").read_bytes() == (tmp_path / "near.gif").read_bytes()
        assert told == [(k + 1, 5) for k in range(5)]
        gone = sorted((tmp_path / "far-frames").iterdir())[:2]
        for path in gone:
            path.unlink()
        assert co.turntable(SCENE, tmp_path / "far.gif", frames=5, **SMALL, executor=pool) == 2
    assert contents(tmp_path / "far-frames") == contents(tmp_path / "near-frames")


@pytest.mark.deep
def test_frames_of_films_too(tmp_path):
    """With the shutter open, and without."""
    scene = co.Scene(
        [co.Body(co.Sphere(0.5), "red", "ball"), co.Box((-3, -3, -2), (3, 3, -1))],
        [co.AmbientLight(0.5), co.PointLight((1, -2, 3))],
        co.Camera((0, -6, 2), (0, 0, 0)),
        animation=[
            co.scene.BodyTrack("ball", (0, 1), translate=((0, 0, 0), (2, 0, 0))),
            co.scene.LightTrack(1, (0, 1), intensity=(0, 1)),
        ],
    )
    with co.parallel.Processes(2) as pool:
        for shutter in (0, 0.5):
            told: list[tuple[int, int]] = []
            names = [tmp_path / f"{where}-{shutter}.gif" for where in ("near", "far")]
            asked = dict(frames=4, shutter=shutter, **SMALL)
            assert co.animate(scene, names[0], **asked) == 4
            assert (
                co.animate(scene, names[1], **asked, executor=pool, progress=lambda *step, told=told: told.append(step))
                == 4
            )
            assert names[0].read_bytes() == names[1].read_bytes()
            assert told == [(k + 1, 4) for k in range(4)]
            assert co.animate(scene, names[1], **asked, executor=pool) == 0


class Dying(co.parallel.Processes):
    """Kills a process with its task, as soon as it has one, the first two times."""

    left = 2

    def submit(self, fn, /, *arguments, **keywords):
        if self.left and frames.render_frame in arguments:
            self.left -= 1
            super().submit(os.kill, self.pids[0], signal.SIGKILL) if len(self.pids) > 1 else None
        return super().submit(fn, *arguments, **keywords)


@pytest.mark.skipif(sys.platform == "win32", reason="SIGKILL")
def test_a_worker_that_dies_costs_its_frame(tmp_path):
    with Dying(2, retries=5) as pool:
        assert co.turntable(SCENE, tmp_path / "far.gif", frames=6, **SMALL, executor=pool) == 6
    co.turntable(SCENE, tmp_path / "near.gif", frames=6, **SMALL)
    assert (tmp_path / "far.gif").read_bytes() == (tmp_path / "near.gif").read_bytes()


def test_what_was_done_stays_when_one_cannot_be_made(tmp_path):
    class Stopping(Exception):
        pass

    def stop(done, count):
        if done == 3:
            raise Stopping

    with co.parallel.Processes(1) as pool, pytest.raises(Stopping):
        co.turntable(SCENE, tmp_path / "far.gif", frames=5, **SMALL, executor=pool, progress=stop)
    assert len(contents(tmp_path / "far-frames")) == 3
    assert co.turntable(SCENE, tmp_path / "far.gif", frames=5, **SMALL) == 2


def test_the_command(tmp_path):
    co.save(SCENE, tmp_path / "scene.yaml")
    options = "--width", 32, "--height", 24, "--samples", 1, "--frames", 3
    for name, more in (("near", ()), ("far", ("--workers", 1))):
        found = run("turntable", tmp_path / "scene.yaml", "-o", tmp_path / f"{name}.gif", *options, *more)
        assert found.exit_code == 0, found.stderr
    assert (tmp_path / "far.gif").read_bytes() == (tmp_path / "near.gif").read_bytes()
