"""Files of scenes, of rays and of OpenMC as users write them: accepted forms, and errors."""

import copy
import logging
import pickle
import re

import pytest

import conicoid as co
from conicoid.io import openmc
from conicoid.io.scene_file.scene_file import parse_scene

from .command_line import execute, run

BALL_TEXT = "shape: {Sphere: {}}"


BOX = co.Box((2, 2, 2), (3, 3, 3))


# --- scene files


def of_body(text: str) -> str:
    return f"bodies: [{{{text}}}]"


MISTAKES = [
    # left empty
    *(
        (f"{before}bodies:{empty}\n", phrase)
        for before, phrase in (("", "bodies: must be a list of bodies, each with a shape, got "), ("conicoid: 1\n", "of no bodies at all: `bodies: []`"))
        for empty in ("", " null", " ~", " # - shape: {Sphere: {}}")
    ),
    *(
        (f"bodies:\n  - name: a\n    {BALL_TEXT}\n    {field}\n", phrase)
        for field, phrase in (
            ("material:", 'body "a": material: must be a material such as'), ("move:", "move: must be a list of steps"),
            ("material: #ff0000", "got nothing (# begins a comment"),
        )
    ),
    (f"bodies:\n  - name:\n    {BALL_TEXT}\n", "bodies[0]: name: must be a text, got nothing"),
    (f"background: #ffffff\nbodies:\n  - {BALL_TEXT}\n", "or null, got nothing (# begins a comment"),
    ("bodies:\n  - shape:\n      Ellipsoid:\n        z_range:\n", "or null, got nothing (# begins a comment"),
    (f"materials:\n  a:\n    matte:\n      name: #1\nbodies:\n  - {BALL_TEXT}\n", "or null, got nothing (# begins a comment"),
    # motions
    (of_body("shape: {Box: {}}, move: [{rotate: {axis: z}}]"), "rotate: degrees must be given"),
    (of_body("shape: {Box: {}}, move: [{rotate: {axis: w}}]"), "degrees must be given"),
    (of_body("shape: {Box: {}}, move: [{rotate: {axis: w}}]"), "axis: must be 3 numbers, or one of x, y, z, -x, -y, -z, got 'w'"),
    (of_body("shape: {Box: {}}, move: [{rotate: {axis: z, degrees: 90, about: [2, 2]}}]"), "move[0]: rotate: about: must be 3 numbers, got 2"),
    # materials
    (of_body(f"{BALL_TEXT}, material: glass"), "must be a material such as {matte: {...}}, or the name of one under `materials`, or a colour such as 'gray', got 'glass'$"),
    (of_body(f"{BALL_TEXT}, material: '#3366c'"), "got '#3366c'$"),
    (of_body(f"{BALL_TEXT}, material: bleu"), "got 'bleu' (did you mean 'blue'?)$"),
    (of_body(f"{BALL_TEXT}, material: grayy"), "got 'grayy' (did you mean 'gray'?)$"), (of_body(f"{BALL_TEXT}, material: '#ff00'"), "got '#ff00'$"),
    # shapes and their keys
    (of_body("shape: {Torus: {radius: 1}}"), "unknown shape 'Torus'$"),
    (of_body("shape: {Sphere: {radius: 1,5}}"), "Sphere: unknown key '5' (known: center)$"),
    ("bodies:\n  - shape: {Sphere:{radius: 1}}\n", "scene.yaml:2:19: not YAML: while scanning a plain scalar found unexpected ':' at ':'$"),
    (of_body("shape: {Plane: {normal: z, offset: 0}}"), "normal: must be 3 numbers, got 'z'"),
    (of_body("shape: {Ball: {}}"), "unknown shape 'Ball' (did you mean 'Sphere'?)$"),
    (of_body("shape: {Rotate: {}}"), "unknown shape 'Rotate'$"),
    (of_body("shape: {Sphere: {material: red}}"), "Sphere: unknown key 'material' (known: center, radius)$"),
    (of_body(f"{BALL_TEXT}, colour: red"), "unknown key 'colour' (did you mean 'material'?)$"),
    (of_body("shape: {Sphere: {radios: 1}}"), "Sphere: unknown key 'radios' (did you mean 'radius'?)$"),
    (of_body("shape: {Sphere: {}, name: c, material: red}"), "must have one shape as its key (and `move` beside it), got 3: Sphere, name, material$"),
    # elsewhere in the file
    (f"bodies: [{{{BALL_TEXT}}}]\nbackground: Sky", "must be a mapping, {Sky: {...}}, got the bare word 'Sky'"),
    (f"bodies: [{{{BALL_TEXT}}}]\nbackground: {{Environment: {{pixels: sky.exr}}}}", "is not an existing file: 'sky.exr' beside the scene"),
    (
        f"materials: {{a: {{metal: {{}}, properties: {{density: 3}}}}}}\nbodies: [{{{BALL_TEXT}, material: a}}]",
        "must be a material such as {matte: {...}}, got {metal: {}, properties: {density: 3}}$",
    ),
]  # fmt: skip
"""(text, a part of the message; `$` where the message ends with it)"""


@pytest.mark.parametrize(("text", "message"), MISTAKES)
def test_mistakes_in_scene_files(text, message):
    with pytest.raises(co.SceneFileError, match=re.escape(message.removesuffix("$")) + "$" * message.endswith("$")):
        parse_scene(text, "scene.yaml")


def test_empty_list_of_bodies(tmp_path):
    assert parse_scene("bodies: []", "scene.yaml").bodies == ()
    co.save(co.Scene([]), tmp_path / "empty.yaml")
    assert co.load(tmp_path / "empty.yaml") == co.Scene([])
    result = execute("render", tmp_path / "empty.yaml", "-o", tmp_path / "empty.png", "--width", 8, "--height", 8)
    assert "empty.yaml: holds no bodies" in result.stderr


READ = [
    ("bodies: [{name: null, shape: {Sphere: {}}, material: null}]", co.Body(co.Sphere())),
    ("bodies: [{shape: {Box: {}}, move: [{rotate: {axis: -z, degrees: 30}}]}]", co.Body(co.Box().rotate("-z", 30))),
    (
        "bodies: [{shape: {Box: {low: [2, 2, 2], high: [3, 3, 3]}}, move: [{rotate: {axis: z, degrees: 90, about: [2, 2, 0]}}]}]",
        co.Body(BOX.rotate("z", 90, about=(2, 2, 0))),
    ),
    ("bodies: [{shape: {Sphere: {}}, material: gray}]", co.Body(co.Sphere(), "gray")),
    ('bodies: [{shape: {Sphere: {}}, material: "#ff0000"}]', co.Body(co.Sphere(), "#ff0000")),
    # Materials come before colours
    (
        "materials: {gray: {mirror: {}}}\nbodies: [{shape: {Sphere: {}}, material: gray}]",
        co.Body(co.Sphere(), co.mirror(name="gray")),
    ),
]


@pytest.mark.parametrize(("text", "body"), READ)
def test_a_body_is_read_and_saved(text, body, tmp_path):
    scene = co.Scene(parse_scene(text, "scene.yaml").bodies)
    assert scene == co.Scene([body])
    scene.save(tmp_path / "scene.yaml")
    assert co.load(tmp_path / "scene.yaml") == scene


@pytest.mark.parametrize(("rows", "message"), [
    ("x,y,z,radius\n0,0,0,1\n\n1,1,1,-2\n", r"balls\.csv:4: radii\[1\] must be > 0, got -2\.0"),
    ("x,y,z,diameter\n1,2,3,4\n", r"columns are read as x, y, z, radius, and 'diameter' is none of these"),
])  # fmt: skip
def test_mistakes_in_files_of_balls(rows, message, tmp_path):
    (tmp_path / "balls.csv").write_text(rows)
    (tmp_path / "scene.yaml").write_text("bodies: [{shape: {Spheres: {file: balls.csv}}}]")
    with pytest.raises(co.SceneFileError, match=message):
        co.load(tmp_path / "scene.yaml")


def test_export_takes_a_shape_and_knows_suffixes(tmp_path):
    co.export(co.Sphere(), tmp_path / "ball.html")
    assert "<html" in (tmp_path / "ball.html").read_text(encoding="utf-8")
    with pytest.raises(ValueError, match=r"ball.txt: scenes are exported as a page, \.html, or as models"):
        co.export(co.Sphere(), tmp_path / "ball.txt")
    with pytest.raises(TypeError, match="export: scene must be"):
        co.export(5, tmp_path / "ball.html")


@pytest.mark.parametrize("name", ["geometry.xml", "scene.txt", "scene.YAML.bak"])
def test_save_refuses_other_suffixes(name, tmp_path):
    for save in (co.Scene([co.Sphere()]).save, lambda path: co.save(co.Sphere(), path)):
        with pytest.raises(ValueError, match="scenes are saved as .yaml or .json"):
            save(tmp_path / name)
    assert not list(tmp_path.iterdir())


# --- OpenMC


MODEL = """<model><materials><material id="1" name="fuel">{0}</material></materials>
<geometry><surface id="1" type="sphere" coeffs="0 0 0 2" boundary="vacuum"/>
<surface id="2" type="sphere" coeffs="0 0 0 9"/><cell id="1" material="1" region="-1"/>{1}</geometry></model>"""


DENSITY = '<density value="{0}" units="{1}"/>'


def model(folder, material, cells=""):
    (folder / "model.xml").write_text(MODEL.format(material, cells))
    return folder / "model.xml"


@pytest.mark.parametrize("units", ["g/cm3", "g/cc", "kg/m3", "atom/b-cm", "atom/cm3"])
@pytest.mark.parametrize("value", ["-10.5", "0", "-0.0"])
def test_load_openmc_densities_are_positive(tmp_path, units, value):
    """OpenMC requires: "Need to specify a positive density on material"."""
    with pytest.raises(
        co.SceneFileError, match=rf"model\.xml:1:\d+: material 1 'fuel': density: value must be > 0, got '{value}'"
    ):
        co.load_openmc(model(tmp_path, DENSITY.format(value, units)))
    good = co.load_openmc(model(tmp_path, DENSITY.format("10.5", units)))
    assert max(good.materials[0].properties.values()) > 0


@pytest.mark.parametrize(("part", "message"), [
    ('<nuclide name="U235" ao="-0.04"/>', "nuclide: ao must be >= 0, got '-0.04'"),
    ('<nuclide name="U235" wo="-4"/>', "nuclide: wo must be >= 0, got '-4'"),
    ("<temperature>-20</temperature>", "temperature must be >= 0, got '-20'"),
    ('<volume>-1</volume>', "volume must be >= 0, got '-1'"),
])  # fmt: skip
def test_load_openmc_refuses_negative_values(tmp_path, part, message):
    with pytest.raises(co.SceneFileError, match=message):
        co.load_openmc(model(tmp_path, DENSITY.format("10.5", "g/cm3") + part))


EMPTY_CELL = '<cell id="2" name="gone" region="-1 2" material="1"/>'


def test_load_openmc_and_the_command_report_the_same(tmp_path, caplog):
    path = model(tmp_path, DENSITY.format("10.5", "g/cm3"), EMPTY_CELL)
    with caplog.at_level(logging.WARNING, "conicoid"):
        scene = co.load_openmc(path)
    imported = openmc.read(path)
    assert scene.notes == imported.notes
    assert imported.remarks == ("cell 2 'gone': has no volume in its only place, left out there",)
    assert [record.getMessage() for record in caplog.records] == [f"{path}: {imported.remarks[0]}"]
    assert repr(scene) == f"Scene(1 body, 0 lights, {len(scene.notes)} notes)"
    printed = run("import", path, "-o", tmp_path / "scene.yaml").stdout
    for note in scene.notes:
        assert note in printed


def test_notes_stay_with_the_scene(tmp_path, caplog):
    scene = co.load_openmc(model(tmp_path, DENSITY.format("10.5", "g/cm3"), EMPTY_CELL))
    camera = co.Camera((9, 9, 9), (0, 0, 0))
    for same in (
        copy.copy(scene),
        copy.deepcopy(scene),
        pickle.loads(pickle.dumps(scene)),
        scene.replace(camera=camera),
    ):
        assert same.notes == scene.notes
        assert len(same.notes) > 2
    assert co.Scene(scene.bodies, domain=scene.domain, unit=scene.unit) == scene
    assert co.Scene(scene.bodies).notes == ()
    with pytest.raises(AttributeError, match="read-only, notes cannot be set"):
        scene.notes = ()


def test_notes_without_remarks_are_not_logged(tmp_path, caplog):
    with caplog.at_level(logging.WARNING, "conicoid"):
        scene = co.load_openmc(model(tmp_path, DENSITY.format("10.5", "g/cm3")))
    assert scene.notes[:2] == ("1 cell, 2 surfaces, 1 universe, 0 lattices", "1 body")
    assert not caplog.records


@pytest.mark.parametrize(
    "text", ["<?xml version='1.0'?>\n<geometry/>", "<geometry>\n</geometry>", "<!-- x --><model/>"]
)
def test_load_reads_geometries_of_openmc(tmp_path, text):
    (tmp_path / "geometry.xml").write_text(text)
    with pytest.raises(
        co.SceneFileError, match="geometry.xml:.*(geometry: holds no cells|holds 0 <geometry> elements)"
    ):
        co.load(tmp_path / "geometry.xml")
