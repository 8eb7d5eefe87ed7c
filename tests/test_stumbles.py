"""What a first user stumbles over: help that hides words, answers that are none, messages that mislead."""

from __future__ import annotations

import re

import numpy as np
import pytest

import conicoid as co
from conicoid.formats.ray_file import read_rays
from conicoid.formats.scene_file import parsed
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
    ],
)
def test_tables_without_rays_or_in_another_order_are_refused(tmp_path, content, phrase):
    (tmp_path / "rays.csv").write_text(content)
    with pytest.raises(ValueError, match=phrase):
        read_rays(tmp_path / "rays.csv")


@pytest.mark.parametrize("header", ["x,y,z,dx,dy,dz", "Origin X, Origin Y, Origin Z, Direction X, Direction Y, Direction Z",
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
    scene = co.Scene(parsed(text, "scene.yaml").bodies)
    assert scene == co.Scene(co.Body(co.Sphere(), color))
    scene.save(tmp_path / "again.yaml")
    assert co.load(tmp_path / "again.yaml") == scene


def test_a_name_under_materials_comes_before_the_colour():
    text = "materials: {gray: {mirror: {}}}\nbodies: [{shape: {Sphere: {}}, material: gray}]"
    assert parsed(text, "scene.yaml").bodies[0].material == co.mirror()


@pytest.mark.parametrize("written", ["grayy", "'#ff00'"])
def test_what_is_neither_material_nor_colour_is_told(written):
    with pytest.raises(co.SceneFileError, match="unknown material '{}'".format(written.strip("'"))):
        parsed(f"bodies: [{{shape: {{Sphere: {{}}}}, material: {written}}}]", "scene.yaml")


def test_export_takes_a_shape_and_writes_pages_only(tmp_path):
    export(co.Sphere(), tmp_path / "ball.html")
    assert "<html" in (tmp_path / "ball.html").read_text(encoding="utf-8")
    with pytest.raises(ValueError, match=r"ball.txt: pages are saved as \.html"):
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
        co.Box(2)


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
