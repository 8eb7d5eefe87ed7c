"""Files as new users write them: what is left empty, half a step, a bad line, a density; and what an import says."""

from __future__ import annotations

import copy
import logging
import pickle

import numpy as np
import pytest

import conicoid as co
from conicoid.cli.ray_tables import check
from conicoid.io import openmc
from conicoid.io.ray_file import read_rays
from conicoid.io.scene_file.scene_file import parse_scene

from .command_line import run

BALL = "shape: {Sphere: {}}"


def refused(text: str) -> str:
    with pytest.raises(co.SceneFileError) as error:
        parse_scene(text, "scene.yaml")
    return str(error.value)


@pytest.mark.parametrize("written", ["", " null", " ~", " # - shape: {Sphere: {}}"])
def test_bodies_are_not_left_empty(written):
    assert "bodies: must be a list of bodies, each with a shape, got " in refused(f"bodies:{written}\n")
    assert "of no bodies at all: `bodies: []`" in refused(f"conicoid: 1\nbodies:{written}\n")


def test_no_bodies_are_written_as_an_empty_list(tmp_path):
    assert parse_scene("bodies: []", "scene.yaml").bodies == ()
    co.save(co.Scene([]), tmp_path / "empty.yaml")
    assert co.load(tmp_path / "empty.yaml") == co.Scene([])
    result = run("render", tmp_path / "empty.yaml", "-o", tmp_path / "empty.png", "--width", 8, "--height", 8)
    assert result.exit_code == 0
    assert "empty.yaml: holds no bodies" in result.stderr


@pytest.mark.parametrize(("field", "phrase"), [
    ("material:", "body \"a\": material: must be a material such as"), ("material: #ff0000", "got nothing (# begins a comment"),
    ("move:", "move: must be a list of steps"),
])  # fmt: skip
def test_what_is_left_empty_is_told(field, phrase):
    assert phrase in refused(f"bodies:\n  - name: a\n    {BALL}\n    {field}\n")


def test_an_empty_name_is_told():
    assert "bodies[0]: name: must be a text, got nothing" in refused(f"bodies:\n  - name:\n    {BALL}\n")
    assert parse_scene(f"bodies: [{{name: null, {BALL}, material: null}}]", "scene.yaml").bodies == (
        co.Body(co.Sphere()),
    )


@pytest.mark.parametrize("text", [
    f"background: #ffffff\nbodies:\n  - {BALL}\n", "bodies:\n  - shape:\n      Ellipsoid:\n        z_range:\n",
    f"materials:\n  a:\n    matte:\n      name: #1\nbodies:\n  - {BALL}\n",
])  # fmt: skip
def test_empty_values_of_all_kinds_are_told(text):
    assert "or null, got nothing (# begins a comment" in refused(text)


def test_axes_have_names_in_files_too():
    scene = parse_scene("bodies: [{shape: {Box: {}}, move: [{rotate: {axis: -z, degrees: 30}}]}]", "scene.yaml")
    assert scene.bodies[0].shape == co.Box().rotate("-z", 30)
    text = "bodies: [{shape: {Box: {}}, move: [{rotate: {axis: %s}}]}]"
    assert "rotate: degrees must be given" in refused(text % "z")
    told = refused(text % "w")
    assert "degrees must be given" in told
    assert "axis: must be 3 numbers, or one of x, y, z, -x, -y, -z, got 'w'" in told


@pytest.mark.parametrize(("material", "told"), [
    ("glass", "unknown material 'glass': a look is a mapping, {glass: {}} with its arguments"),
    ("'#3366c'", "unknown material '#3366c' (5 digits after #: there must be 6, or 3 as in '#rgb')"),
    ("bleu", "unknown material 'bleu' (did you mean 'blue'?)"),
])  # fmt: skip
def test_what_is_no_material_is_told_apart(material, told):
    assert told in refused(f"bodies: [{{{BALL}, material: {material}}}]")


@pytest.mark.parametrize(("row", "told"), [
    ("0,0,5,0,0,0", "direction must not be zero, got (0.0, 0.0, 0.0)"), ("0,0,nan,0,0,1", "origin must be finite"),
    ("0,0,1e200,0,0,1", "origin must be 0 or of magnitude"),
])  # fmt: skip
def test_a_bad_ray_is_told_with_its_line(tmp_path, row, told):
    path = tmp_path / "rays.csv"
    path.write_text(f"x,y,z,dx,dy,dz\n# two good ones\n0,0,5,0,0,-1\n\n1,0,5,0,0,-1\n{row}\n0,0,5,0,0,0\n")
    with pytest.raises(ValueError, match=r"rays\.csv: 6: ") as error:
        check(read_rays(path))
    assert f"{path}: 6: {told}" in str(error.value)
    co.save(co.Sphere(), tmp_path / "ball.yaml")
    result = run("trace", tmp_path / "ball.yaml", path, "-o", tmp_path / "hits.csv")
    assert result.exit_code == 2
    assert "rays.csv: 6: " in result.stderr


def test_a_bad_ball_is_told_with_its_line(tmp_path):
    (tmp_path / "balls.csv").write_text("x,y,z,radius\n0,0,0,1\n\n1,1,1,-2\n")
    (tmp_path / "scene.yaml").write_text("bodies: [{shape: {Spheres: {file: balls.csv}}}]")
    with pytest.raises(co.SceneFileError, match=r"balls\.csv:4: radii\[1\] must be > 0, got -2\.0"):
        co.load(tmp_path / "scene.yaml")


MODEL = """<model><materials><material id="1" name="fuel">{0}</material></materials>
<geometry><surface id="1" type="sphere" coeffs="0 0 0 2" boundary="vacuum"/>
<surface id="2" type="sphere" coeffs="0 0 0 9"/><cell id="1" material="1" region="-1"/>{1}</geometry></model>"""
DENSITY = '<density value="{0}" units="{1}"/>'


def model(folder, material, cells=""):
    (folder / "model.xml").write_text(MODEL.format(material, cells))
    return folder / "model.xml"


@pytest.mark.parametrize("units", ["g/cm3", "g/cc", "kg/m3", "atom/b-cm", "atom/cm3"])
@pytest.mark.parametrize("value", ["-10.5", "0", "-0.0"])
def test_densities_are_positive(tmp_path, units, value):
    """OpenMC: "Need to specify a positive density on material"."""
    with pytest.raises(
        co.SceneFileError, match=rf"model\.xml:1:\d+: material 1 'fuel': density: value must be > 0, got '{value}'"
    ):
        co.load_openmc(model(tmp_path, DENSITY.format(value, units)))
    good = co.load_openmc(model(tmp_path, DENSITY.format("10.5", units)))
    assert max(good.materials[0].properties.values()) > 0


@pytest.mark.parametrize(("part", "told"), [
    ('<nuclide name="U235" ao="-0.04"/>', "nuclide: ao must be >= 0, got '-0.04'"),
    ('<nuclide name="U235" wo="-4"/>', "nuclide: wo must be >= 0, got '-4'"),
    ("<temperature>-20</temperature>", "temperature must be >= 0, got '-20'"),
    ('<volume>-1</volume>', "volume must be >= 0, got '-1'"),
])  # fmt: skip
def test_what_cannot_be_negative_is_refused(tmp_path, part, told):
    with pytest.raises(co.SceneFileError, match=told):
        co.load_openmc(model(tmp_path, DENSITY.format("10.5", "g/cm3") + part))


EMPTY_CELL = '<cell id="2" name="gone" region="-1 2" material="1"/>'


def test_imports_say_in_python_what_the_command_says(tmp_path, caplog):
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
    assert co.Scene(scene.bodies, domain=scene.domain) == scene
    assert co.Scene(scene.bodies).notes == ()
    with pytest.raises(AttributeError, match="read-only, notes cannot be set"):
        scene.notes = ()


def test_what_is_as_the_file_says_is_not_shown(tmp_path, caplog):
    with caplog.at_level(logging.WARNING, "conicoid"):
        scene = co.load_openmc(model(tmp_path, DENSITY.format("10.5", "g/cm3")))
    assert scene.notes[:2] == ("1 cell, 2 surfaces, 1 universe, 0 lattices", "1 body")
    assert not caplog.records


def test_checks_say_what_they_have_not_looked_for(tmp_path):
    found = co.check(co.Sphere(), rays=500)
    assert found == []
    assert found.not_looked_for == ("undefined regions (the scene has no domain, which says where bodies are to be)",)
    assert repr(found).startswith("Findings([], not looked for: undefined regions (the scene has no domain")
    assert str(found).splitlines() == ["nothing found", f"not looked for: {found.not_looked_for[0]}"]
    assert pickle.loads(pickle.dumps(found)).not_looked_for == found.not_looked_for
    assert copy.copy(found).not_looked_for == found.not_looked_for
    none = co.check(co.Scene([], domain=co.Sphere() & co.Sphere(1, (5, 0, 0))), rays=500)
    assert none.not_looked_for == ("undefined regions (the scene's domain is empty)",)
    whole = co.check(co.Scene(co.Sphere(), domain=co.Sphere()), rays=500)
    assert (whole, whole.not_looked_for, repr(whole)) == ([], (), "Findings([])")
    assert isinstance(whole, co.checks.Findings)


@pytest.mark.parametrize("option", [(), ("--spans",)])
def test_rays_are_not_overwritten_with_what_they_hit(tmp_path, option):
    co.save(co.Scene(co.Sphere()), tmp_path / "scene.yaml")
    rays = tmp_path / "mine.csv"
    rays.write_text("x,y,z,dx,dy,dz\n20,0,0,-1,0,0\n")
    other = tmp_path / "link.csv"
    other.symlink_to(rays)
    for output in (rays, other):
        result = run("trace", tmp_path / "scene.yaml", rays, "-o", output, *option)
        assert result.exit_code == 2
        assert "is read for this and would be lost: choose another file for the results" in result.stderr
    assert rays.read_text().startswith("x,y,z,dx")
    assert run("trace", tmp_path / "scene.yaml", rays, "-o", tmp_path / "new.csv", *option).exit_code == 0


@pytest.mark.parametrize(
    "heading",
    [
        "x,y,z,theta,phi,r",
        "x1,y1,z1,x2,y2,z2",
        "x_start,y_start,z_start,x_end,y_end,z_end",
        "x,y,z,to,azimuth,elevation",
    ],
)
def test_headings_of_other_things_than_rays_are_refused(tmp_path, heading):
    path = tmp_path / "rays.csv"
    path.write_text(f"{heading}\n20,0,0,-1,0,0\n")
    with pytest.raises(ValueError, match=r"rays.csv: 1: columns are read as origin x, .* is none of these"):
        read_rays(path)


def test_a_column_of_diameters_is_not_read_as_radii(tmp_path):
    (tmp_path / "balls.csv").write_text("x,y,z,diameter\n1,2,3,4\n")
    (tmp_path / "scene.yaml").write_text("bodies:\n- shape: {Spheres: {file: balls.csv}}\n")
    with pytest.raises(
        co.SceneFileError, match=r"columns are read as x, y, z, radius, and 'diameter' is none of these"
    ):
        co.load(tmp_path / "scene.yaml")


@pytest.mark.parametrize(("shape", "told"), [
    ("{Torus: {radius: 1}}", "unknown shape 'Torus': bodies are of planes and quadrics; a mesh is {Mesh: ...} or {Triangles: ...}"),
    ("{Torus: {radius: 1}}", "unknown shape 'Torus': bodies are of planes and quadrics"),
    ("{Subtract: [{Sphere: }, {Box: }]}", "unknown shape 'Subtract' (did you mean 'Difference'?)"),
    ("{Plane: {point: [0, 0, 0], normal: [0, 0, 1]}}", "unknown key 'point' (did you mean offset (normal·point)?)"),
    ("{Sphere: {radius: 1,5}}", "unknown key '5' (a comma ends a value: 1.5 is written with a point)"),
    ("{Sphere:{radius: 1}}", "a blank follows a colon: {radius: 1}, and {Sphere: {radius: 1}}"),
    ("{Plane: {normal: z, offset: 0}}", "normal: must be 3 numbers, got 'z'"),
])  # fmt: skip
def test_shapes_as_other_programs_write_them(tmp_path, shape, told):
    (tmp_path / "scene.yaml").write_text(f"bodies:\n  - shape: {shape}\n")
    with pytest.raises(co.SceneFileError) as error:
        co.load(tmp_path / "scene.yaml")
    assert told in str(error.value)


def test_a_file_of_other_arrays_names_them(tmp_path):
    np.savez(tmp_path / "rays.npz", o=np.zeros((2, 3)), d=np.ones((2, 3)))
    with pytest.raises(ValueError, match="it lacks origins, directions and holds o, d"):
        co.Rays.load(tmp_path / "rays.npz")
