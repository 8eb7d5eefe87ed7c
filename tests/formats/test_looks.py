"""Looks in files: surroundings, colors, and materials by name."""

import json
import pickle
import sys

import numpy as np
import pytest

import conicoid as co
from conicoid.io.image_codecs import _srgb_table, srgb_bytes
from conicoid.io.scene_file.scene_file import parse_scene
from tests.children import ROOT
from tests.command_line import run

from .test_broken_files import VALIDATOR

# --- An environment's picture in a scene file: by the name of its file, or by its numbers

PIXELS = np.random.default_rng(3).random((4, 8, 3)).astype(np.float32)
SCENE = "background: {Environment: {pixels: sky.exr, intensity: 2}}\nbodies: [{shape: Sphere}]\n"


@pytest.fixture
def folder(tmp_path):
    pytest.importorskip("OpenEXR")
    co.Image(PIXELS).save(tmp_path / "sky.exr")
    (tmp_path / "scene.yaml").write_text(SCENE.replace("Sphere", "{Sphere: {}}"))
    return tmp_path


def test_a_scene_file_names_a_picture(folder):
    found = co.load(folder / "scene.yaml").background
    assert found == co.Environment(PIXELS, intensity=2) == co.Environment(folder / "sky.exr", intensity=2)
    assert found == co.Environment(folder / "sky.exr", 2)


def test_saved_files_name_the_preset(folder):
    scene = co.load(folder / "scene.yaml")
    co.save(scene, folder / "again.yaml")
    assert "pixels: sky.exr" in (folder / "again.yaml").read_text()
    assert co.load(folder / "again.yaml") == scene


def test_a_small_one_of_numbers_stands_in_the_file(folder):
    scene = co.Scene([co.Sphere()], background=co.Environment(PIXELS.astype(float) / 3))
    co.save(scene, folder / "numbers.yaml")
    assert co.load(folder / "numbers.yaml") == scene


def test_a_large_one_is_to_be_put_into_a_file(folder):
    """A scene file may not hold so many numbers: `save` wrote them, and `load` refused the file."""
    large = np.full((500, 1000, 3), 0.5)
    with pytest.raises(
        ValueError, match=r"^Environment: pixels must be in a file .*co.Image\(pixels\).save\('sky.exr'\)"
    ):
        co.save(co.Scene([], background=co.Environment(large)), folder / "large.yaml")
    (folder / "below").mkdir()
    co.Image(large).save(folder / "large.exr")
    scene = co.Scene([], background=co.Environment(folder / "large.exr"))
    with pytest.raises(ValueError, match=r"^Environment: pixels must be in a file .*: copy '.*large.exr' there$"):
        co.save(scene, folder / "below" / "scene.yaml")
    co.save(scene, folder / "scene.yaml")
    assert co.load(folder / "scene.yaml") == scene


@pytest.mark.parametrize(("name", "message"), [
    ("no.exr", "Environment: pixels: is not an existing file: 'no.exr' beside the scene"),
    ("../sky.exr", "Environment: pixels: must stay inside the scene's folder"),
    ("sky.txt", "Environment: pixels: .*file must be a picture"),
])  # fmt: skip
def test_mistakes_are_reported_with_their_place(folder, name, message):
    (folder / "sky.txt").write_text("blue")
    inner = folder / "inner"
    inner.mkdir()
    target = inner if name.startswith("..") else folder
    (target / "bad.yaml").write_text(SCENE.replace("sky.exr", name).replace("Sphere", "{Sphere: {}}"))
    with pytest.raises(co.SceneFileError, match=message) as caught:
        co.load(target / "bad.yaml")
    assert ":1:" in str(caught.value)


def test_without_openexr_the_way_to_install_it_is_in_the_message(folder, monkeypatch):
    image, plate = co.Image(PIXELS), co.Scene([co.Sphere()]).slice("z", 0, pixels=8)
    monkeypatch.setitem(sys.modules, "OpenEXR", None)  # Python then finds no OpenEXR
    for work in (
        lambda: co.load(folder / "scene.yaml"), lambda: co.Environment(folder / "sky.exr"),
        lambda: image.save(folder / "new.exr"), lambda: plate.save(folder / "new.exr"),
    ):  # fmt: skip
        with pytest.raises(ImportError, match=r"^\.exr files need OpenEXR: pip install 'conicoid\[exr\]'$"):
            work()
    for command in ("render", "slice"):
        result = run(command, ROOT / "examples" / "scenes" / "barrel.yaml", "-o", folder / "new.exr")
        assert (result.exit_code, "pip install 'conicoid[exr]'" in result.stderr) == (1, True)
    assert not (folder / "new.exr").exists()


# --- Bytes of sRGB: those of the formula, on both sides of every threshold between two of them


def by_formula(linear):
    """Return IEC 61966-2-1 with NumPy's power, right to some ulp."""
    return 255 * np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def test_bytes_are_the_formula_rounded():
    values = np.concatenate([np.linspace(0, 1, 200_001), np.geomspace(1e-12, 1, 100_000), [5e-324, 1e-300]])
    exact = by_formula(values)
    clear = abs(exact - np.floor(exact) - 0.5) > 1e-9  # rounding of the formula decides the others
    assert clear.mean() > 0.99
    assert np.array_equal(srgb_bytes(values)[clear], np.rint(exact[clear]))


def test_each_byte_begins_at_the_threshold_of_the_formula():
    _, thresholds = _srgb_table()
    middles = np.arange(256)[1:] - 0.5  # rounding turns up there
    assert np.abs(by_formula(thresholds[:-1]) - middles).max() < 1e-9
    assert srgb_bytes(thresholds[:-1]).tolist() == list(range(1, 256))
    assert srgb_bytes(np.nextafter(thresholds[:-1], 0)).tolist() == list(range(255))


def test_missing_light_is_black_and_excess_is_white():
    values = np.array([[np.nan, -np.inf, -1.0, -0.0], [1.0, 1.5, np.inf, 1e30]])
    assert srgb_bytes(values).tolist() == [[0] * 4, [255] * 4]
    assert srgb_bytes(values.astype(np.float32)[:, ::2]).tolist() == [[0, 0], [255, 255]]


# --- Materials in scene files: the key is the name, and a saved material has the user's form

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
def test_saved_materials_keep_loaded_names_and_kinds(suffix, tmp_path):
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


@pytest.mark.parametrize("material", [
    lambda m: pickle.loads(pickle.dumps(m)), lambda m: m,
])  # fmt: skip
def test_materials_made_in_python_keep_their_presets(material, tmp_path):
    scene = co.Scene([
        co.Body(co.Sphere(), material(co.metal("gold", 90, 1 / 3, name="gold"))), co.Body(co.Box(), "red"),
        co.Body(co.Sphere(2), material(co.metal("gold", 90, 1 / 3, name="other"))), co.Sphere(3).painted(co.mirror(name="m")),
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


@pytest.mark.parametrize(("written", "expression"), [
    ("{Difference: [disc, ball, bore]}", lambda disc, ball, bore: disc - ball - bore),
    ("{Intersection: [disc, ball]}", lambda disc, ball, bore: disc & ball),
    ("{Intersection: [ball, disc, bore]}", lambda disc, ball, bore: disc & ball & bore),
    ("{Difference: [{Intersection: [ball, disc]}, bore]}", lambda disc, ball, bore: (disc & ball) - bore),
])  # fmt: skip
def test_sheets_are_clipped_by_booleans(written, expression, tmp_path):
    text = """{"shapes": {"disc": {"Disc": {"center": [0, 0, 0], "normal": [0, 0, 1], "radius": 3}}, "ball": {"Sphere":
        {"radius": 2}}, "bore": {"Cylinder": {"start": [1, 0, -1], "end": [1, 0, 1], "radius": 0.5}}}, "bodies": [{"shape": %s}]}"""
    quoted = written
    for word in ("Difference", "Intersection", "disc", "ball", "bore"):
        quoted = quoted.replace(word, f'"{word}"')
    VALIDATOR.validate(json.loads(text % quoted))
    shapes = co.Disc((0, 0, 0), (0, 0, 1), 3), co.Sphere(2), co.Cylinder((1, 0, -1), (1, 0, 1), 0.5)
    scene = co.Scene(parse_scene(text % quoted, "x.json").bodies)
    assert scene.bodies[0].shape == expression(*shapes)
    scene.save(tmp_path / "scene.yaml")
    assert co.load(tmp_path / "scene.yaml") == scene


@pytest.mark.parametrize("written", ["{Union: [{Disc: &d {center: [0, 0, 0], normal: [0, 0, 1], radius: 3}}, {Sphere: {}}]}",
    "{Difference: [{Sphere: {}}, {Disc: {center: [0, 0, 0], normal: [0, 0, 1], radius: 3}}]}"])  # fmt: skip
def test_other_booleans_of_sheets_are_refused(written):
    with pytest.raises(co.SceneFileError, match="Disc is a sheet: only `sheet & solid` and `sheet - solid` clip it"):
        parse_scene(f"bodies: [{{shape: {written}}}]", "x.yaml")
