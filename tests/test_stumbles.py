"""What a first user stumbles over: help that hides words, answers that are none, messages that mislead."""

from __future__ import annotations

import re

import numpy as np
import pytest

import conicoid as co
from conicoid._util import environment
from conicoid.io.ray_file import ray_notes, read_rays
from conicoid.io.scene_file.scene_file import parse_scene
from conicoid.viewer.html import export

from .command_line import run


@pytest.mark.parametrize(("command", "extra"), [("turntable", "video"), ("bench", "bench")])
def test_help_shows_the_extra_in_its_brackets(command, extra):
    words = " ".join(re.sub("[^ -~]", " ", run(command, "--help").stdout).split())
    assert f'pip install ".[{extra}]"' in words


@pytest.mark.parametrize(
    ("content", "phrase"),
    [
        ("0;0;5;0;0;-1\n", "must have 6 numbers .* with commas or spaces between, got only '0;0;5;0;0;-1'"),
        ("0;0;5;0;0;-1\n0;0;4;0;0;-1\n", "rays.csv: 2: must be 6 numbers .*, got '0;0;4;0;0;-1'"),
        ("abc\n", "got only 'abc'"),
        ("", "got nothing"),
        ("# nothing\n\n", "got nothing"),
        ("title\nx,y,z,dx,dy,dz\n0,0,5,0,0,-1\n", "rays.csv: 2: must be 6 numbers"),
        ("dx,dy,dz,x,y,z\n0,0,-1,0,0,5\n", "rays.csv: 1: columns must be in the order origin x,"),
        ("ox dx oy dy oz dz\n0,0,-1,0,0,5\n", "columns must be in the order"),
        ("u,v,w,x,y,z\n0,0,-1,0,0,5\n", "columns must be in the order"),
        ("t,x,y,z,u,v\n0,0,-1,0,0,5\n", "columns must be in the order"),
    ],
)
def test_tables_without_rays_or_in_another_order_are_refused(tmp_path, content, phrase):
    (tmp_path / "rays.csv").write_text(content)
    with pytest.raises(ValueError, match=phrase):
        read_rays(tmp_path / "rays.csv")


@pytest.mark.parametrize("header", ["x,y,z,dx,dy,dz", "x y z u v w", "Origin X, Origin Y, Origin Z, Direction X, Direction Y, Direction Z",
                                    "origin_x origin_y origin_z direction_x direction_y direction_z", "any words"])  # fmt: skip
def test_one_header_line_is_skipped(tmp_path, header):
    (tmp_path / "rays.csv").write_text(header + "\n1,2,3,4,5,6\n")
    assert read_rays(tmp_path / "rays.csv").directions.tolist() == [[4, 5, 6]]


@pytest.mark.parametrize(("name", "meant"), [("tmin", "t_min"), ("T_MAX", "t_max"), ("origin", "origins")])
def test_a_misspelt_array_of_rays_is_refused(tmp_path, name, meant):
    arrays = {"origins": np.zeros((2, 3)), "directions": np.ones((2, 3)), name: np.ones(2)}
    np.savez(tmp_path / "rays.npz", **arrays)
    with pytest.raises(ValueError, match=rf"unknown array '{name}' \(did you mean '{meant}'\?\)"):
        read_rays(tmp_path / "rays.npz")


@pytest.mark.parametrize(("written", "color"), [("gray", "gray"), ('"#ff0000"', "#ff0000")])
def test_colours_are_materials_in_scene_files(tmp_path, written, color):
    text = f"bodies: [{{shape: {{Sphere: {{}}}}, material: {written}}}]"
    scene = co.Scene(parse_scene(text, "scene.yaml").bodies)
    assert scene == co.Scene(co.Body(co.Sphere(), color))
    scene.save(tmp_path / "again.yaml")
    assert co.load(tmp_path / "again.yaml") == scene


def test_a_name_under_materials_comes_before_the_colour():
    text = "materials: {gray: {mirror: {}}}\nbodies: [{shape: {Sphere: {}}, material: gray}]"
    assert parse_scene(text, "scene.yaml").bodies[0].material == co.mirror(name="gray")


@pytest.mark.parametrize("written", ["grayy", "'#ff00'"])
def test_what_is_neither_material_nor_colour_is_told(written):
    with pytest.raises(co.SceneFileError, match="unknown material '{}'".format(written.strip("'"))):
        parse_scene(f"bodies: [{{shape: {{Sphere: {{}}}}, material: {written}}}]", "scene.yaml")


def test_export_takes_a_shape_and_knows_suffixes(tmp_path):
    export(co.Sphere(), tmp_path / "ball.html")
    assert "<html" in (tmp_path / "ball.html").read_text(encoding="utf-8")
    with pytest.raises(ValueError, match=r"ball.txt: scenes are exported as a page, \.html, or as models"):
        export(co.Sphere(), tmp_path / "ball.txt")
    with pytest.raises(TypeError, match="export: scene must be"):
        export(5, tmp_path / "ball.html")


def test_one_bad_ray_needs_no_number():
    with pytest.raises(ValueError, match=r"got \(0\.0, 0\.0, nan\)$"):
        co.Rays((0, 0, 5), (0, 0, np.nan))
    with pytest.raises(ValueError, match=r"got \(0\.0, 0\.0, nan\) for ray\[1\]$"):
        co.Rays((0, 0, 5), [(0, 0, 1), (0, 0, np.nan)])


def test_questions_say_what_they_were_given():
    scene = co.Scene(co.Sphere())
    hits = scene.first_hit((0, 0, 5), (0, 0, -1))
    with pytest.raises(TypeError, match=r"got Hits; use its \.rays, or hits\.spawn"):
        scene.first_hit(hits)
    with pytest.raises(TypeError, match="must be arrays or a Rays, got Scene"):
        scene.spans(scene)
    with pytest.raises(ValueError, match="^contains: points must be finite"):
        scene.contains((0, 0, np.nan))
    with pytest.raises(TypeError, match=r"^Scene\.first_hit\(\) missing"):
        scene.first_hit()


def test_a_number_in_place_of_three_is_called_one():
    with pytest.raises(ValueError, match="low must be 3 numbers, got the number 2$"):
        co.Box(low=2)


def test_the_name_of_a_constructor_is_no_material():
    with pytest.raises(ValueError, match=r"got 'glass'; materials are made by functions: co\.glass\(\.\.\.\)"):
        co.Body(co.Sphere(), "glass")


def test_the_height_of_a_view_is_checked():
    with pytest.raises(ValueError, match="view: height must be an integer >= 1, got 'big'"):
        co.Scene(co.Sphere()).view(height="big")


def test_gray_is_grey():
    values = np.arange(6.0).reshape(2, 3)
    assert (co.Image(values, colormap="gray").pixels == co.Image(values, colormap="grey").pixels).all()


def test_measures_show_themselves_in_a_line():
    found = co.measure(co.Box((0, 0, 0), (1, 2, 3)))
    assert repr(found) == "Measures(volume=6, area=22, rays=0)"
    assert repr(co.measure(co.Scene(co.Box((0, 0, 0), (1, 2, 3))))) == "SceneMeasures(volumes: 6)"


@pytest.mark.parametrize("name", ["geometry.xml", "scene.txt", "scene.YAML.bak"])
def test_scenes_do_not_take_the_place_of_other_files(name, tmp_path):
    for save in (co.Scene([co.Sphere()]).save, lambda path: co.save(co.Sphere(), path)):
        with pytest.raises(ValueError, match="scenes are saved as .yaml or .json"):
            save(tmp_path / name)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("use", [lambda a, b: a and b, lambda a, b: a or b, lambda a, b: not a, lambda a, b: bool(b)])
@pytest.mark.parametrize("shape", [co.Sphere(), co.Sphere() - co.Box(), co.Disc((0, 0, 0), (0, 0, 1), 1), ~co.Box()])
def test_shapes_are_neither_true_nor_false(use, shape):
    with pytest.raises(TypeError, match=r"is neither true nor false: shapes combine with & \| - ~, not with `and`"):
        use(shape, shape)


@pytest.mark.parametrize("two", [2, 2.0, np.int64(2), np.uint8(2), np.float32(2)])
def test_one_rule_for_whole_numbers(two):
    scene = co.Scene(co.Sphere())
    co.set_threads(two)
    co.set_threads(None)
    assert scene.render(two, two, two, seed=two, depth=two).pixels.shape == (2, 2, 3)
    assert co.check(scene, rays=100 * two, seed=two) == []
    shape = co.Sphere() - co.Cone((0, 0, 0), (1, 1, 3), 0.5, 0.1)
    assert co.measure(shape, rays=1e2 * two).volume == co.measure(shape, rays=200).volume
    assert scene.fitting_camera().rays(two, two).shape == (2, 2)


@pytest.mark.parametrize("other", [2.5, True, "2", None, np.array([2, 2]), float("inf"), 1e400, float("nan"), 2 + 0j])
def test_what_is_no_whole_number(other):
    for ask in (lambda: co.check(co.Sphere(), rays=other), lambda: co.Scene(co.Sphere()).render(other, 2),
                lambda: co.Scene(co.Sphere()).render(2, 2, seed=other)):  # fmt: skip
        with pytest.raises(ValueError, match=r"must be an integer|must be a whole number"):
            ask()
    if other is not None:
        with pytest.raises(ValueError, match="set_threads: count must be an integer from 1 to 65536 or None"):
            co.set_threads(other)


def test_scenes_say_that_they_cannot_be_changed():
    scene = co.Scene(co.Sphere())
    with pytest.raises(AttributeError, match=r"read-only, camera cannot be set: scene.replace\(camera=...\) is one"):
        scene.camera = co.Camera((0, 0, 5), (0, 0, 0))
    with pytest.raises(AttributeError, match="a Scene is read-only, ligths cannot be set$"):
        scene.ligths = [co.AmbientLight()]

    class Titled(co.Scene):
        pass

    titled = Titled(co.Sphere())
    titled.title = "a scene of one's own"
    assert titled.title


def test_entries_are_replaced_in_part():
    scene = co.Scene([co.Body(co.Sphere(), "red", "ball"), co.Body(co.Box(), "blue", "box")])
    hits = scene.first_hit((0, 0, 9), (0, 0, -1))
    green = scene.replace("ball", material="green")
    assert green.bodies == (co.Body(co.Sphere(), "green", "ball"), scene.bodies[1])
    assert green.geometry is scene.geometry  # nothing is prepared anew
    assert scene.replace(1, name="cube")["cube"] == co.Body(co.Box(), "blue", "cube")
    assert scene.replace("box", name=None, material=None).bodies[1] == co.Body(co.Box())
    assert scene.replace("box", co.Body(co.Sphere(2), "white")).bodies[1] == co.Body(co.Sphere(2), "white", "box")
    assert scene.replace("box", co.Sphere(2), name="big")["big"] == co.Body(co.Sphere(2), "blue", "big")
    assert hits.name == "ball"
    with pytest.raises(TypeError, match="item must be a shape or a Body, got Material; material= and name= change"):
        scene.replace("ball", co.mirror())
    with pytest.raises(
        TypeError, match="replace: item must be a shape or a Body, got None; material= and name= change these alone$"
    ):
        scene.replace("ball")
    with pytest.raises(TypeError, match="Body: material must be"):
        scene.replace("ball", material=5)


NAMED = co.Scene([co.Body(co.Sphere(), co.matte("red", name=f"m{k}"), name)
                  for k, name in enumerate(["barrel", "bung", "cell 5 'fuel' @ cell 9", "cell 5 'fuel' @ cell 10"])])  # fmt: skip


@pytest.mark.parametrize(("name", "told"), [
    ("barel", r"named bodies: 'barrel', 'bung', .* \(did you mean 'barrel'\?\)$"),
    ("fuel", r"named bodies with it in their names: \"cell 5 'fuel' @ cell 9\", \"cell 5 'fuel' @ cell 10\"$"),
    ("Barrel", r"named bodies with it in their names: 'barrel'$"),
    ("quite other", r"named bodies: 'barrel', 'bung', [^(]*$"),
])  # fmt: skip
def test_names_are_suggested(name, told):
    with pytest.raises(KeyError) as error:
        NAMED[name]
    assert re.search(told, error.value.args[0])


def test_names_of_materials_are_suggested():
    with pytest.raises(ValueError, match=r"no material is called 'm'; materials with it in their names: 'm0', 'm1'"):
        NAMED.line_integral({"m": 1}, (0, 0, 9), (0, 0, -1), otherwise=0)
    with pytest.raises(KeyError, match="no material is called 'mm2'; materials: .*did you mean 'm2'"):
        co.measure(NAMED)["mm2"]


def test_properties_are_suggested():
    lead = co.matte("gray", name="lead", properties={"density": 11.35, "mu": 1})
    scene = co.Scene(co.Body(co.Sphere(), lead))
    with pytest.raises(ValueError, match=r"no property 'densty' for material 'lead'; .* \(did you mean 'density'\?\)$"):
        scene.line_integral("densty", (0, 0, 9), (0, 0, -1))
    with pytest.raises(ValueError, match=r"no material has a property 'densty'; .* \(did you mean 'density'\?\)$"):
        scene.line_integral("densty", (0, 0, 9), (0, 0, -1), otherwise=0)


def test_measures_of_what_is_unbounded_say_so():
    assert str(co.measure(co.Scene(co.HalfSpace((0, 0, 1), 0)))).splitlines()[-1].split() == ["body", "0", "unbounded"]


def test_lists_of_names_are_no_longer_than_a_screen():
    scene = co.Scene([co.Body(co.Sphere(0.1, (k, 0, 0)), co.matte("red", name=f"{k}" * 40)) for k in range(300)])
    with pytest.raises(ValueError, match="no material is called 'x'") as error:
        scene.line_integral({"x": 1}, (0, 0, 9), (0, 0, -1))
    assert len(str(error.value)) < 1200


def test_arrays_of_no_meaning_are_named(tmp_path):
    np.savez(tmp_path / "rays.npz", origins=np.zeros((2, 3)), directions=np.ones((2, 3)), wavelength=np.ones(2))
    table = read_rays(tmp_path / "rays.npz")
    assert table.ignored == ("wavelength",)
    assert list(ray_notes(table)) == [
        f"{tmp_path / 'rays.npz'}: not read: wavelength; arrays of rays are origins, directions, t_min, t_max"
    ]


def test_a_header_alone_is_told(tmp_path):
    (tmp_path / "rays.csv").write_text("x,y,z,dx,dy,dz\n")
    assert list(ray_notes(read_rays(tmp_path / "rays.csv"))) == [f"{tmp_path / 'rays.csv'}: holds no rays"]
    (tmp_path / "rays.csv").write_text("x,y,z,dx,dy,dz\n1,2,3,4,5,6\n")
    assert list(ray_notes(read_rays(tmp_path / "rays.csv"))) == []


@pytest.mark.parametrize(
    "text", ["<?xml version='1.0'?>\n<geometry/>", "<geometry>\n</geometry>", "<!-- x --><model/>"]
)
def test_geometries_of_openmc_are_read_as_such(tmp_path, text):
    (tmp_path / "geometry.xml").write_text(text)
    with pytest.raises(
        co.SceneFileError, match="geometry.xml:.*(geometry: holds no cells|holds 0 <geometry> elements)"
    ):
        co.load(tmp_path / "geometry.xml")


def test_export_is_public(tmp_path):
    co.export(co.Sphere(), tmp_path / "ball.html")
    assert "<title>ball</title>" in (tmp_path / "ball.html").read_text(encoding="utf-8")


def test_unknown_variables_are_warned_of_once(monkeypatch):
    environment.warn_of_unknown.cache_clear()
    monkeypatch.setenv("CONICOID_TREADS", "2")
    with pytest.warns(UserWarning, match="^CONICOID_TREADS is not a Conicoid variable: did you mean CONICOID_THREADS"):
        environment.read_threads()
    environment.read_threads()  # warnings are errors here
    environment.read_jit_mode()
    environment.warn_of_unknown.cache_clear()
