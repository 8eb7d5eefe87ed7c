"""Materials in scene files: the key is the name, and what is saved says them as they were said."""

from __future__ import annotations

import json
import pickle

import pytest

import conicoid as co
from conicoid.io.scene_file.scene_file import parse_scene

from .test_schema import VALIDATOR

BY_HAND = """
materials:
  red: {phong: {color: [0.8, 0.1, 0.1]}}
  brass: {metal: {color: gold, reflectivity: 0.7}}
  crown: {glass: {refractive_index: 1.517, absorption: [0.1, 0, 0]}}
  tiles: {matte: {color: {Checker: {a: white}}}}
  paint: {lacquer: {}}
  half: {mirror: {reflectivity: 0.5}}
  chalk: {blinn_phong: {properties: {density: 2.7}}}
  own: {Material: {color: red, diffuse: 0.5}}
  bare: {matte: }
  tin: {metal: {name: tin plate}}
  without: {matte: {name: null, color: blue}}
bodies:
"""
KEYS = ["red", "brass", "crown", "tiles", "paint", "half", "chalk", "own", "bare", "tin", "without"]
TEXT = BY_HAND + "".join(
    f"  - {{shape: {{Sphere: {{center: [{3 * k}, 0, 0]}}}}, material: {key}}}\n" for k, key in enumerate(KEYS)
)


def test_the_key_is_the_name_unless_another_is_given():
    scene = co.Scene(parse_scene(TEXT, "x.yaml").bodies)
    assert [body.material.name for body in scene.bodies] == [*KEYS[:-2], "tin plate", None]
    assert scene.bodies[0].material == co.phong((0.8, 0.1, 0.1), name="red")
    assert scene.bodies[1].material == co.metal("gold", reflectivity=0.7, name="brass")
    mu = {name: float(k) for k, name in enumerate([*KEYS[:-2], "tin plate"])}
    # through the middle of the second ball, 2 long, of value 1
    assert scene.line_integral(mu, (3, 0, 9), (0, 0, -1), otherwise=0) == 2


@pytest.mark.parametrize("suffix", [".yaml", ".json"])
def test_what_is_saved_has_the_names_and_kinds_that_were_loaded(suffix, tmp_path):
    scene = co.Scene(parse_scene(TEXT, "x.yaml").bodies)
    path, again = tmp_path / f"scene{suffix}", tmp_path / f"again{suffix}"
    scene.save(path)
    loaded = co.load(path)
    assert loaded == scene
    loaded.save(again)
    assert again.read_text() == path.read_text()
    scene.save(tmp_path / "scene.json")
    written = json.loads((tmp_path / "scene.json").read_text())
    VALIDATOR.validate(written)
    found = {key: next(iter(material)) for key, material in written["materials"].items()}
    assert found == {
        "red": "phong", "brass": "metal", "crown": "glass", "tiles": "matte", "paint": "lacquer", "half": "mirror",
        "chalk": "blinn_phong", "own": "Material", "bare": "matte", "tin plate": "metal", "material A": "matte",
    }  # fmt: skip
    assert written["materials"]["brass"] == {"metal": {"color": "gold", "reflectivity": 0.7}}
    assert written["materials"]["paint"] == {"lacquer": {}}
    assert written["materials"]["material A"] == {"matte": {"color": "blue", "name": None}}


@pytest.mark.parametrize("made", [
    lambda m: pickle.loads(pickle.dumps(m)), lambda m: m,
])  # fmt: skip
def test_materials_made_in_python_keep_what_they_were_made_by(made, tmp_path):
    scene = co.Scene([
        co.Body(co.Sphere(), made(co.metal("gold", 90, 1 / 3, name="gold"))), co.Body(co.Box(), "red"),
        co.Body(co.Sphere(2), made(co.metal("gold", 90, 1 / 3, name="other"))), co.Sphere(3).painted(co.mirror(name="m")),
        co.Body(co.Sphere(4), co.matte("blue", name="gold")),
    ])  # fmt: skip
    scene.save(tmp_path / "scene.json")
    written = json.loads((tmp_path / "scene.json").read_text())["materials"]
    gold = {"color": "gold", "shininess": 90, "reflectivity": 1 / 3}
    assert written == {
        "gold": {"metal": gold}, "material A": {"matte": {"color": "red", "name": None}}, "other": {"metal": gold},
        "m": {"mirror": {}}, "gold (2)": {"matte": {"color": "blue", "name": "gold"}},
    }  # fmt: skip
    assert co.load(tmp_path / "scene.json") == scene


def test_a_material_is_equal_however_it_was_made():
    assert co.Material("red") == co.matte("red")
    assert hash(co.Material("red")) == hash(co.matte("red"))
    assert co.Scene([co.Body(co.Sphere(), co.Material("red")), co.Body(co.Box(), "red")]).materials == (
        co.matte("red"),
    )


@pytest.mark.parametrize("name", ["scene", "scene.", "a.b/scene"])
def test_a_file_of_a_scene_says_what_it_is(name, tmp_path):
    (tmp_path / "a.b").mkdir()
    with pytest.raises(ValueError, match=r"scenes are saved as .yaml or .json: .*scene\.?.yaml, say$"):
        co.save(co.Sphere(), tmp_path / name)


@pytest.mark.parametrize(("written", "meant"), [
    ("{Difference: [disc, ball, bore]}", lambda disc, ball, bore: disc - ball - bore),
    ("{Intersection: [disc, ball]}", lambda disc, ball, bore: disc & ball),
    ("{Intersection: [ball, disc, bore]}", lambda disc, ball, bore: disc & ball & bore),
    ("{Difference: [{Intersection: [ball, disc]}, bore]}", lambda disc, ball, bore: (disc & ball) - bore),
])  # fmt: skip
def test_sheets_are_clipped_by_booleans(written, meant, tmp_path):
    text = """{"shapes": {"disc": {"Disc": {"center": [0, 0, 0], "normal": [0, 0, 1], "radius": 3}}, "ball": {"Sphere":
        {"radius": 2}}, "bore": {"Cylinder": {"start": [1, 0, -1], "end": [1, 0, 1], "radius": 0.5}}}, "bodies": [{"shape": %s}]}"""
    quoted = written
    for word in ("Difference", "Intersection", "disc", "ball", "bore"):
        quoted = quoted.replace(word, f'"{word}"')
    VALIDATOR.validate(json.loads(text % quoted))
    shapes = co.Disc((0, 0, 0), (0, 0, 1), 3), co.Sphere(2), co.Cylinder((1, 0, -1), (1, 0, 1), 0.5)
    scene = co.Scene(parse_scene(text % quoted, "x.json").bodies)
    assert scene.bodies[0].shape == meant(*shapes)
    scene.save(tmp_path / "scene.yaml")
    assert co.load(tmp_path / "scene.yaml") == scene


@pytest.mark.parametrize("written", ["{Union: [{Disc: &d {center: [0, 0, 0], normal: [0, 0, 1], radius: 3}}, {Sphere: {}}]}",
    "{Difference: [{Sphere: {}}, {Disc: {center: [0, 0, 0], normal: [0, 0, 1], radius: 3}}]}"])  # fmt: skip
def test_other_booleans_of_sheets_are_told(written):
    with pytest.raises(co.SceneFileError, match="Disc is a sheet: only `sheet & solid` and `sheet - solid` clip it"):
        parse_scene(f"bodies: [{{shape: {written}}}]", "x.yaml")
