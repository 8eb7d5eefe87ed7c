"""Films of scenes that move: their frames, which of them are made, and the command."""

from __future__ import annotations

import numpy as np
import PIL.Image
import PIL.ImageSequence
import pytest

import conicoid as co

from ..command_line import refused, run

SMALL = dict(width=32, height=24, samples=2)
SCENE = co.Scene(
    [co.Body(co.Sphere(0.5, (-1, 0, 0)), "red", "ball"), co.Box((-3, -3, -2), (3, 3, -1))],
    [co.AmbientLight(1)], co.Camera((0, -6, 2), (0, 0, 0)), "black",
    animation=co.scene.BodyTrack("ball", (0, 1), translate=((0, 0, 0), (2, 0, 0))),
)  # fmt: skip


def frames_of(path):
    with PIL.Image.open(path) as file:
        return [np.asarray(frame.convert("RGB")) for frame in PIL.ImageSequence.Iterator(file)]


@pytest.mark.parametrize("shutter", [0, 0.5])
def test_a_film_is_its_frames(tmp_path, shutter):
    path = tmp_path / "film.webp"
    assert co.animate(SCENE, path, frames=4, shutter=shutter, **SMALL) == 4
    for k, frame in enumerate(frames_of(path)):
        time = k / 4
        if shutter == 0:
            image = SCENE.at(time).render(**SMALL)
        else:
            image = SCENE.render(**SMALL, shutter=(time, time + 0.125))
        assert (frame == np.asarray(image)).all()


def test_frames_that_are_there_are_not_made_again(tmp_path):
    path = tmp_path / "film.gif"
    assert co.animate(SCENE, path, frames=4, **SMALL) == 4
    assert co.animate(SCENE, tmp_path / "film.webp", frames=4, **SMALL) == 0
    assert co.animate(SCENE, path, frames=8, shutter=1, **SMALL) == 4, "every other one: the shutter is open as long"
    assert co.animate(SCENE, path, frames=8, shutter=0, **SMALL) == 8
    assert co.animate(SCENE, path, frames=4, shutter=0, **SMALL) == 0, "every other frame of eight"
    other = SCENE.replace(animation=co.scene.BodyTrack("ball", (0, 1), translate=((0, 0, 0), (2, 0, 0.1))))
    assert co.animate(other, path, frames=4, shutter=0, keep=False, **SMALL) == 4


def test_only_what_moves_is_prepared_for_each_frame(monkeypatch):
    """Every other shape of a moment is the very one that was prepared before."""
    moved = SCENE.at(0.4)
    assert moved.bodies[1].shape is SCENE.bodies[1].shape
    assert moved.bodies[0].shape is not SCENE.bodies[0].shape
    assert SCENE.at(-1)._prepared is SCENE._prepared


def test_the_command(tmp_path):
    co.save(SCENE, tmp_path / "scene.yaml")
    options = ("--width", 32, "--height", 24, "--samples", 2, "--frames", 3)
    first = run("animate", tmp_path / "scene.yaml", "-o", tmp_path / "film.gif", *options)
    assert first.exit_code == 0, first.output
    assert "3 frames of 32 x 24 pixels" in first.output
    again = run("animate", tmp_path / "scene.yaml", "-o", tmp_path / "film.gif", *options)
    assert "3 of them were there" in again.output
    picture = run("render", tmp_path / "scene.yaml", "-o", tmp_path / "a.png", *options[:6], "--shutter", "0,0.5")
    assert picture.exit_code == 0, picture.output
    expected = SCENE.render(32, 24, 2, shutter=(0, 0.5))
    assert (np.asarray(PIL.Image.open(tmp_path / "a.png")) == np.asarray(expected)).all()
    still = run("render", tmp_path / "scene.yaml", "-o", tmp_path / "b.png", *options[:6], "--time", "0.5")
    assert still.exit_code == 0, still.output
    assert (np.asarray(PIL.Image.open(tmp_path / "b.png")) == np.asarray(SCENE.at(0.5).render(32, 24, 2))).all()


def test_what_has_no_animation(tmp_path):
    co.save(SCENE.replace(animation=()), tmp_path / "scene.yaml")
    assert "has no animation" in refused("animate", tmp_path / "scene.yaml", "-o", tmp_path / "film.gif")
    with pytest.raises(ValueError, match="shutter must be in"):
        co.animate(SCENE, tmp_path / "a.gif", shutter=2)
    with pytest.raises(ValueError, match="seconds must be given"):
        co.animate(SCENE, tmp_path / "a.gif", start=5)
