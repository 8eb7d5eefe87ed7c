"""Scenes come back equal from files: values to the bit, steps of motions, order, names, materials."""

import json
import math
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings, strategies as st

import conicoid as co
from conicoid.io.scene_file import yaml_parser, yaml_parser as scene_text

from ..samples import sampled
from .strategies import PRIMITIVES, moved, primitive, scenes, sheets, solids

pytestmark = pytest.mark.filterwarnings("ignore::UserWarning")  # for numbers that may be mistakes
RELAXED = settings(max_examples=10, deadline=None, suppress_health_check=list(HealthCheck))


def saved_and_loaded(scene: co.Scene, name: str = "scene.yaml") -> co.Scene:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        co.save(scene, path)
        return co.load(path)


def check(shape: co.Shape) -> None:
    scene = co.Scene([shape])
    back = saved_and_loaded(scene)
    assert back == scene
    assert repr(back.bodies) == repr(scene.bodies)  # == takes -0.0 for 0.0
    assert repr(back.bodies[0].shape.motion) == repr(shape.motion)


@pytest.mark.parametrize("name", sampled(PRIMITIVES, 6))
def test_every_shape(name):
    @RELAXED
    @given(moved(primitive(name)))
    def run(shape):
        check(shape)

    run()


@settings(RELAXED, max_examples=20)
@given(st.one_of(solids(), sheets()))
def test_booleans(shape):
    check(shape)


@settings(RELAXED, max_examples=20)
@given(scenes())
def test_scenes(scene):
    back = saved_and_loaded(scene)
    assert back == scene
    assert repr((back.bodies, back.lights, back.camera, back.background)) == repr(
        (scene.bodies, scene.lights, scene.camera, scene.background)
    )


@settings(RELAXED)
@given(scenes())
def test_json(scene):
    try:
        back = saved_and_loaded(scene, "scene.json")
    except ValueError as error:
        assume("JSON has no infinite numbers" not in str(error))
        raise
    assert back == scene


@pytest.mark.parametrize(
    "name",
    ["no", "on", "1e-9", "0x1F", "1_000", "null", "~", "a: b", "a #b", "- a", "'", '"', "{", " x ", "x\ny", "\u2028",
     "\x7f", "\x1b[31m", "ü", "日本", "😀", "a" * 5000, "*a", "&a", "!a", "%a", "@a", "`a", "?", "=", "<<", "2001-01-01", "12:30"],
)  # fmt: skip
def test_names_that_mean_something_in_yaml(name):
    scene = co.Scene([co.Body(co.Sphere(), name=name)])
    assert saved_and_loaded(scene) == scene


@pytest.mark.parametrize(("body", "name", "message"), [
    (co.Ellipsoid(z_range=(0, math.inf)), "scene.json", "JSON has no infinite numbers"),
    (co.Body(co.Sphere(), name="\ud800"), "scene.yaml", "not Unicode"),
])  # fmt: skip
def test_unsavable_scenes_are_refused(body, name, message, tmp_path):
    with pytest.raises(ValueError, match=message):
        co.save(co.Scene([body]), tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_shared_booleans_are_written_once():
    shape = co.Sphere(0.5)
    for step in range(9):
        shape = shape | shape.translate((2.0**step, 0, 0))  # 2^9 balls
    scene = co.Scene([shape, co.Body(shape.rotate((0, 0, 1), 90))])
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scene.yaml"
        co.save(scene, path)
        assert path.stat().st_size < 5000
        back = co.load(path)
    assert back.bodies[1].shape.motion == scene.bodies[1].shape.motion
    assert (back.bounds[0] == scene.bounds[0]).all()
    assert (back.bounds[1] == scene.bounds[1]).all()


def test_paint_refers_to_materials_by_name(tmp_path):
    """A material of several faces and bodies stands in the file once."""
    red, tiles = co.lacquer("red"), co.matte(co.Checker("white", "black", scale=(0.1, 0.25)))
    bore = co.Cylinder((0, 0, -2), (0, 0, 2), 0.5).painted(red)
    block = (co.Box() - bore - bore.rotate((1, 0, 0), 90)).painted(tiles)
    scene = co.Scene([co.Body(block, red), co.Body(co.Sphere().painted(tiles).translate((3, 0, 0)))])
    co.save(scene, tmp_path / "scene.yaml")
    text = (tmp_path / "scene.yaml").read_text()
    assert text.count("lacquer:") == text.count("matte:") == 1
    assert text.count("operand:") == 3  # bore, block and ball
    assert co.load(tmp_path / "scene.yaml") == scene
    assert co.load(tmp_path / "scene.yaml").bodies[1].shape.material == tiles


def test_paint_by_hand(tmp_path):
    (tmp_path / "scene.yaml").write_text(
        """
materials: {brass: {metal: {color: "#d9a64a"}}}
shapes:
  bore: {Painted: {operand: {Cylinder: {start: [0, 0, -2], end: [0, 0, 2], radius: 0.5}}, material: brass}}
bodies:
  - shape: {Difference: [{Box: {}}, bore]}
    material: brass
  - shape: {Painted: {operand: bore, material: {matte: {color: red}}}, move: [{scale: 2}]}
"""
    )
    brass = co.metal("#d9a64a", name="brass")
    bore = co.Cylinder((0, 0, -2), (0, 0, 2), 0.5).painted(brass)
    expected = [co.Body(co.Box() - bore, brass), bore.painted(co.matte("red")).scale(2)]
    assert co.load(tmp_path / "scene.yaml") == co.Scene(expected)


@pytest.mark.parametrize("levels", [19, 20, 21, 99, 3000])
def test_trees_of_any_depth(levels):
    shape = co.Sphere()
    for level in range(levels):
        shape = ~shape if level % 2 else shape | co.Sphere(level + 2)
    check(shape)


def test_many_balls_go_to_a_file_beside_the_scene(tmp_path):
    rng = np.random.default_rng(1)
    many, few = co.Spheres(rng.normal(size=(500, 3)), rng.uniform(0.1, 1, 500)), co.Spheres([(1, 2, 3)], [0.1])
    scene = co.Scene([co.Body(many, name="many"), few, many.translate((1, 0, 0))])
    co.save(scene, tmp_path / "balls.yaml")
    (table,) = tmp_path.glob("balls-spheres-*.npy")  # one, as both are the same balls
    assert sorted(tmp_path.iterdir()) == [table, tmp_path / "balls.yaml"]
    assert np.load(table, allow_pickle=False).shape == (500, 4)
    assert co.load(tmp_path / "balls.yaml") == scene


def test_balls_from_csv(tmp_path):
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "balls.csv").write_text("# balls\nx, y, z, radius\n0, 0, 0, 1\n\n1e-9, 2, 3, 0.5\n")
    (tmp_path / "scene.yaml").write_text("bodies:\n  - shape: {Spheres: {file: data/balls.csv}}\n")
    assert co.load(tmp_path / "scene.yaml") == co.Scene([co.Spheres([(0, 0, 0), (1e-9, 2, 3)], [1, 0.5])])


def test_the_whole_of_a_file_by_hand(tmp_path):
    (tmp_path / "scene.yaml").write_text(
        """%YAML 1.2
---
conicoid: 1
camera: {position: [4, -6, 3], look_at: [0, 0, 0], field_of_view: 40}
background: {Sky: {zenith: "#4070c0"}}
lights:
  - PointLight: {position: [3, -5, 8], intensity: 1e-9}
  - AmbientLight:
materials:
  no: {phong: {color: [0.8, 0.1, 0.1]}}
  tiles: {matte: {color: {Checker: {a: white, scale: [2, 3], space: true}}}}
shapes:
  bore: {Cylinder: {start: [0, 0, -9], end: [0, 0, 9], radius: .5}}
  wheel: {Difference: [{Sphere: {radius: 0x2}}, bore]}
bodies:
  - name: barrel
    shape: {Ellipsoid: {radii: [1, 2, 3], z_range: [-1, .inf]}}
    move:
      - translate: [0, 0, 1]
      - rotate: {axis: [0, 0, 1], degrees: 30}
      - scale: 2
    material: no
  - shape: wheel
    material: tiles
  - shape: {Union: [{shape: wheel, move: [{translate: [1, 0, 0]}]}, {Complement: {Box: {}}}]}
    material: {mirror: {}}
    move: [{scale: [1, 1, -1]}]
  - shape:
      ClippedSheet: {base: {Plane: {normal: [0, 0, 1], offset: 0}}, solid: bore, keep: outside}
"""
    )
    bore = co.Cylinder((0, 0, -9), (0, 0, 9), 0.5)
    wheel = co.Difference((co.Sphere(2), bore))
    expected = co.Scene(
        [
            co.Body(
                co.Ellipsoid((1, 2, 3), z_range=(-1, math.inf)).translate((0, 0, 1)).rotate((0, 0, 1), 30).scale(2),
                co.phong((0.8, 0.1, 0.1), name="no"),
                "barrel",
            ),
            co.Body(wheel, co.matte(co.Checker("white", scale=(2, 3), space=True), name="tiles")),
            co.Body((wheel.translate((1, 0, 0)) | ~co.Box()).scale((1, 1, -1)), co.mirror()),
            co.Plane((0, 0, 1), 0) - bore,
        ],
        [co.PointLight((3, -5, 8), 1e-9), co.AmbientLight()],
        co.Camera((4, -6, 3), (0, 0, 0), field_of_view=40),
        co.Sky("#4070c0"),
    )
    assert co.load(tmp_path / "scene.yaml") == expected
    assert saved_and_loaded(expected) == expected


def test_unloadable_scenes_are_not_saved(tmp_path, monkeypatch):
    monkeypatch.setattr(yaml_parser, "MAX_NODES", 100)
    small, large = (
        co.Scene([co.Sphere(center=(k, 0, 0)) for k in range(5)]),
        co.Scene([co.Sphere(k + 1.5) for k in range(40)]),
    )
    co.save(small, tmp_path / "small.yaml")
    assert co.load(tmp_path / "small.yaml") == small
    with pytest.raises(ValueError, match=r"large\.yaml: a scene file holds at most 100 values, this scene takes \d+"):
        co.save(large, tmp_path / "large.yaml")
    assert not (tmp_path / "large.yaml").exists()
    monkeypatch.undo()
    monkeypatch.setattr(scene_text, "MAX_SCENE_BYTES", 1 << 20)
    long = co.Scene([co.Body(co.Sphere(), name="é" * (1 << 19))])
    for name in ("long.yaml", "long.json"):
        with pytest.raises(ValueError, match=r"long\.\w+: a scene file has at most 1 MB, this scene takes \d MB"):
            co.save(long, tmp_path / name)
        assert not (tmp_path / name).exists()


def test_json_has_a_line_for_each_body(tmp_path):
    names = ["body 0", "body 1", "body Größe 😀 \x7f"]
    scene = co.Scene([co.Body(co.Sphere(k + 1), "red", name) for k, name in enumerate(names)], [co.AmbientLight()])
    co.save(scene, tmp_path / "scene.json")
    text = (tmp_path / "scene.json").read_text(encoding="utf-8")
    assert co.load(tmp_path / "scene.json") == scene
    assert [body["name"] for body in json.loads(text)["bodies"]] == names
    lines = [line for line in text.split("\n") if '"body ' in line]
    assert [json.loads(line.rstrip(","))["name"] for line in lines] == names
