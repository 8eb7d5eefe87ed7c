"""What cannot be meant is refused at once, by object and field; what is plainly meant is taken."""

from __future__ import annotations

import re

import numpy as np
import pytest

import conicoid as co

from ..public_names import PUBLIC
from .arguments import CALLS, JUNK, TAKEN

LONGEST = 400
"""Characters of a message: a few lines of a terminal."""


def refusal(call, arguments, argument, value):
    """The message that refuses a value; None where it is taken."""
    try:
        call(**(arguments | {argument: value}))
    except (TypeError, ValueError) as error:
        return str(error)
    return None


@pytest.mark.parametrize("name", CALLS)
def test_junk_is_refused_by_object_and_field(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    call, arguments = CALLS[name]
    for argument in arguments:
        for kind, junk in JUNK.items():
            if (name, argument, kind) in TAKEN:
                continue
            try:
                message = refusal(call, arguments, argument, junk)
            except OSError:
                assert (argument, type(junk)) == ("path", str)  # it may be a path
                continue
            assert message is not None, f"{name}: {argument} takes {kind}"
            assert argument == "path" or len(message) <= LONGEST, (name, argument, kind, message[:80], len(message))
            if argument == "path" and isinstance(junk, str):
                assert str(junk)[:20] in message
            else:
                assert re.match(r"\w+: ", message), (name, argument, kind, message)
                assert re.search(rf"\b{argument}", message), (name, argument, kind, message)


def test_every_public_function_is_in_the_table():
    called = {name.partition(".")[0].partition(" ")[0] for name in CALLS}
    answers = {"Hits", "Spans", "Crossings", "Finding", "Findings", "Measures", "SceneMeasures", "SceneFileError"}
    answers |= {"BodiesAt", "Explanation", "Molecule", "Outline", "SceneSurface", "Slice", "Voxels"}
    kinds = {"Shape", "Solid", "Sheet"}
    for name in set(PUBLIC) - called - answers - kinds - {"warmup"}:
        assert not callable(PUBLIC[name]), f"{name} is not in the table"


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: co.Body(co.Sphere(), co.matte), "Body: material must be .* got the function matte; call it: matte"),
        (lambda: co.Body(co.Sphere(), co.Material), "Body: material must be .* got the class Material; call it: "),
        (lambda: co.Body(co.Sphere(), "rde"), "Body: material must be three linear numbers, .*colour name, got 'rde'"),
        (lambda: co.Body(co.Sphere(), (1, 2, 0)), r"Body: material\[1\] must be in \[0, 1\], got 2"),
        (lambda: co.Body(co.Sphere(), 3), "Body: material must be a Material .* got int"),
        (lambda: co.Body(co.Sphere), "Body: shape must be a shape such as .* got the class Sphere"),
        (lambda: co.Sphere().painted(co.glass), "Painted: material must be .* got the function glass; call it"),
        (lambda: co.Scene(3), "Scene: items must be a list of shapes and Bodies, or one of them, got int"),
        (lambda: co.Scene("ball"), "Scene: items must be .* got str"),
        (lambda: co.Scene({"ball": co.Sphere()}), "Scene: items must be .* got dict"),
        (lambda: co.Scene([co.Sphere, co.Box()]), r"Scene: items\[0\] must be a shape or a Body, got the class Sphere"),
        (lambda: co.Scene([], lights=co.PointLight), "Scene: lights must be a list of .* got the class PointLight"),
        (lambda: co.Scene([], lights=3), "Scene: lights must be a list of .* got int"),
        (lambda: co.Scene([], lights=["sun"]), r"Scene: lights\[0\] must be one of .* got str"),
        (lambda: co.Scene([], camera=dict(position=(1, 2, 3))), "Scene: camera must be a Camera, .* got dict"),
        (lambda: co.Scene([], camera=co.Camera), "Scene: camera must be a Camera, .* got the class Camera"),
        (lambda: co.check([co.Sphere()]), "check: scene must be a Scene, a shape or a Body, got list"),
        (lambda: co.save("scene.yaml", co.Scene([])), "save: scene must be .* got str"),
        (lambda: co.Sphere(center={1, 2, 3}), "Sphere: center must be 3 numbers"),
    ],
)  # fmt: skip
def test_told_apart(call, message):
    with pytest.raises((TypeError, ValueError), match=message):
        call()


def test_a_colour_is_a_matte_material():
    ball = co.Sphere()
    assert co.Body(ball, "red").material == co.matte("red")
    assert co.Body(ball, "#f80").material == co.matte("#f80")
    assert co.Body(ball, (0.5, 0, 1)).material == co.matte((0.5, 0, 1))
    assert co.Body(ball, np.array([0.5, 0, 1])).material == co.matte((0.5, 0, 1))
    assert co.Body(ball, co.Checker("red", "blue")).material == co.matte(co.Checker("red", "blue"))
    assert co.Body(ball, "red") == co.Body(ball, co.matte("red"))


def test_one_thing_is_a_scene_of_it(tmp_path):
    ball = co.Sphere()
    assert co.Scene(ball) == co.Scene([ball])
    assert co.Scene(co.Body(ball, "red", "ball"))["ball"].material == co.matte("red")
    light = co.PointLight((0, 0, 5))
    assert co.Scene(ball, light).lights == (light,)
    assert co.Scene(iter([ball, ball])).bodies == (co.Body(ball), co.Body(ball))
    overlapping = co.Spheres([(0, 0, 0), (1, 0, 0)], 1)
    assert [f.message for f in co.check(overlapping)] == [f.message for f in co.check(co.Scene([overlapping]))]
    assert co.check(overlapping)
    assert co.check(co.Body(ball)) == []
    co.save(ball, tmp_path / "ball.yaml")
    assert co.load(tmp_path / "ball.yaml") == co.Scene([ball])


def test_a_coloured_body_is_drawn_and_saved(tmp_path):
    scene = co.Scene(co.Body(co.Sphere(), "red"), co.AmbientLight(1), co.Camera((0, -5, 0), (0, 0, 0)))
    assert scene.render(1, 1, samples=1).pixels[0, 0].tolist() == [1, 0, 0]
    co.save(scene, tmp_path / "scene.yaml")
    assert co.load(tmp_path / "scene.yaml") == scene
