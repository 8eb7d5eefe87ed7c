"""What people type, from other programs or from memory: each is told what it is called here, in YAML and Python."""

from __future__ import annotations

import copy
import dataclasses
import pickle

import numpy as np
import pytest

import conicoid as co
from conicoid._util import foreign_names as elsewhere
from conicoid._util import foreign_names as other_names
from conicoid._util import hints as synonyms
from conicoid.io.scene_file.scene_file import parse_scene

from .command_line import refused, run

BALL = co.Sphere()
STEEL = co.matte("red", name="steel", properties={"mu": 2.0})
SCENE = co.Scene([co.Body(BALL, STEEL, "ball"), co.Box((2, 2, 2), (3, 3, 3))], camera=co.Camera((0, 0, 9), (0, 0, 0)))
RAYS = co.Rays([(0, 0, 5), (0.1, 0, 5)], (0, 0, -1))
HITS, SPANS, CROSSINGS = SCENE.first_hit(RAYS), SCENE.spans(RAYS), SCENE.crossings(RAYS)
THINGS = {
    "Hits": HITS, "Rays": RAYS, "Spans": SPANS, "Crossings": CROSSINGS, "Material": STEEL, "Measures": co.measure(BALL),
    "SceneMeasures": co.measure(SCENE), "Image": co.Image(np.eye(3)), "Camera": SCENE.camera,
    "ScanGeometry": co.ct.parallel([0, 90], 4), "ScanRays": co.Rays.from_scan(co.ct.parallel([0, 90], 4)),
    "CameraRays": co.Rays.from_camera(co.Camera((0, 0, 1), (0, 0, 0)), 2, 2),
    "Classification": co.Quadric(np.diag([1, 1, 1, -1])).classification,
    "Finding": co.checks.Finding("empty", (0,), "body 0 is empty", 0.0),
    "OrthographicCamera": co.OrthographicCamera((0, 0, 1), (0, 0, 0)),
    "EquirectangularCamera": co.EquirectangularCamera((0, 0, 1), (0, 0, 0)),
    "FisheyeCamera": co.FisheyeCamera((0, 0, 1), (0, 0, 0)),
    "Molecule": co.molecule([(0, 0, 0)], ["O"]),
    "Paths": co.optics.trace_paths(SCENE, co.Rays([(0, 0, 9)], (0, 0, -1)), depth=1),
}  # fmt: skip


@pytest.mark.parametrize(("ask", "told"), [
    (lambda: HITS.reshape(1, 2), r"reshape a field, hits.t.reshape\(...\)$"), (lambda: HITS.points, "'points': it is called point$"),
    (lambda: HITS.distance, "hits.t is that"), (lambda: HITS.origins, "hits.rays.origins is that$"), (lambda: HITS.nromal, r"did you mean normal\?$"),
    (lambda: HITS.min(), r"hits.t.min\(\)$"), (lambda: HITS.reflect, "hits.spawn"), (lambda: HITS.nonsense, "no attribute 'nonsense'$"),
    (lambda: RAYS.at(3), r"rays.origins \+ t\[..., None\] \* rays.directions"), (lambda: RAYS.direction, "it is called directions$"),
    (lambda: RAYS.first_hit(), r"a scene is asked, scene.first_hit\(rays\)$"), (lambda: RAYS.t_max, "t_max=9"),
    (lambda: RAYS.t, r"a scene is asked: scene.first_hit\(rays\).t$"), (lambda: (BALL | BALL).center, "volume, area, centroid and inertia$"),
    (lambda: SCENE.bodies.append(BALL), r"co.Scene\(\[\*scene.bodies, another\]\)"), (lambda: SPANS.length, r"spans.lengths\(\) are true lengths"), (lambda: SPANS.start, "it is called t_enter$"),
    (lambda: CROSSINGS.distance, "crossings.t is that"), (lambda: STEEL.density, "your own values"), (lambda: STEEL.mu, r"material.properties\['mu'\] is that$"),
    (lambda: STEEL.ior, "refractive_index$"), (lambda: THINGS["Measures"].mass, r"measures.volume \* material.properties\['density'\]$"),
    (lambda: THINGS["SceneMeasures"].area, r"found\['name'\].area"), (lambda: THINGS["Image"].shape, "height, width, 3"),
    (lambda: SCENE.camera.fov, "field_of_view"), (lambda: THINGS["OrthographicCamera"].fov, "height is that of the window$"),
])  # fmt: skip
def test_attributes(ask, told):
    with pytest.raises(AttributeError, match=told):
        ask()


def test_no_hint_is_for_what_there_is():
    """A name of the tables that a class has would never be asked for."""
    for kind, names in other_names._ATTRIBUTE_HINTS.items():
        for name in names:
            thing = THINGS[kind]
            assert not hasattr(thing, name), (kind, name)
            with pytest.raises(AttributeError, match=f"^'{kind}' object has no attribute '{name}': ") as error:
                getattr(thing, name)
            assert "{" not in str(error.value).replace("properties={...}", "")
    assert all(hasattr(co, name) for name in elsewhere.CLASS_SYNONYMS.values())
    assert not any(hasattr(co, name) for name in (*elsewhere.CLASS_SYNONYMS, *elsewhere._PACKAGE_NAME_HINTS))


@pytest.mark.parametrize("thing", THINGS.values(), ids=THINGS)
def test_hints_do_not_get_in_the_way(thing):
    assert (
        type(copy.copy(thing)) is type(copy.deepcopy(thing)) is type(pickle.loads(pickle.dumps(thing))) is type(thing)
    )
    assert not hasattr(thing, "_nonsense")
    assert not hasattr(thing, "__array_interface__")
    assert repr(thing)
    if dataclasses.is_dataclass(thing) and not isinstance(thing, co.measures.SceneMeasures):
        assert dataclasses.replace(thing) is not thing


@pytest.mark.parametrize(("name", "told"), [
    ("Plastic", r"\(did you mean plastic\?\)$"), ("loads", r"scenes are read from files, co.load\(path\)"), ("dump", r"\(did you mean save\?\)$"),
    ("ZCylinder", "co.EllipticCylinder"), ("Vec3", "three numbers"), ("Tetrahedron", "Polyhedron"),
    ("Tubs", "mean Tube"), ("Trd", "mean Trapezoid"), ("Hemisphere", "polar_range"), ("HexPrism", "co.RegularPrism"), ("Shell", "co.SphereSection"),
])  # fmt: skip
def test_names_of_the_package(name, told):
    with pytest.raises(AttributeError, match=told):
        getattr(co, name)


@pytest.mark.parametrize(("call", "told"), [
    (lambda: co.Image(np.eye(3), cmap="gray"), r"has no argument 'cmap' \(did you mean colormap\?\)"),
    (lambda: co.glass(ior=1.5), r"\(did you mean refractive_index\?\)"), (lambda: co.matte("red", density=3), r"\(did you mean properties\?\)"),
    (lambda: co.Cone((0, 0, 0), (0, 0, 1), r1=1, r2=0), r"\(did you mean start_radius\?\).*\(did you mean end_radius\?\)"),
    (lambda: co.refract((0, 0, 1), (0, 0, 1), n1=1, n2=1.5), r"\(did you mean eta \(index before / index behind\)\?\)"),
    (lambda: SCENE.first_hit(RAYS, 0, 100), r"intervals are named: first_hit\(rays, t_min=0, t_max=...\)$"),
    (lambda: SCENE.render(8, 6, background="red"), r"has no argument 'background': a scene has it, scene.replace\(background=...\)"),
    (lambda: SCENE.render(8, 6, threads=2), r"co.set_threads\(count\)"), (lambda: SCENE.render(8, 6, output="x.png"), r"image.save\(path\)"),
    (lambda: SCENE.section(z=1), r"section\('z', 0.5\) is the one by z = 0.5"), (lambda: co.Camera((0, 0, 1), direction=(0, 0, 1)), r"look_at \(position \+ direction\)"),
    (lambda: co.SpotLight((0, 0, 5), target=(0, 0, 0)), r"direction \(target - position\)"), (lambda: co.glass(1.5, color="green"), "transparency"),
    (lambda: co.OrthographicCamera((0, 0, 5), (0, 0, 0), width=4), r"height \(of the window\)"), (lambda: co.turntable(BALL, "x.gif", fps=9), "frames and seconds"),
    (lambda: co.measure(BALL, num=100), r"\(did you mean rays\?\)"), (lambda: co.export(SCENE), r"^export\(\) missing path; call it as export\("),
    (lambda: co.Scene.save("x.yaml"), r"^Scene.save\(\) missing path"), (lambda: co.warmup(1), r"^warmup\(\) takes no arguments, got 1"), (lambda: co.set_threads(), r"^set_threads\(\) missing count"),
    (lambda: SCENE + SCENE, r"co.Scene\(\[\*a.bodies, \*b.bodies\], a.lights\)$"), (lambda: SCENE | SCENE, "put together by their entries"),
    (lambda: co.Scene(SCENE), "got Scene: its entries are scene.bodies$"), (lambda: co.Scene({"a": BALL}), r"Body\(shape, material, name\)$"),
    (lambda: co.Scene([("a", BALL)]), r"Body\(shape, material, name\) is one$"), (lambda: co.Body([BALL, BALL]), r"co.Union\(shapes\) is one of several$"),
    (lambda: co.Scene(BALL, background=0.5), r"got float; that grey is \[0.5, 0.5, 0.5\]$"), (lambda: THINGS["Image"][0, 0], r"image.pixels\[...\]"),
    (lambda: SCENE.spans(RAYS, (0, 0, 1)), "directions must be left out where a Rays is given$"),
])  # fmt: skip
def test_calls(call, told):
    with pytest.raises(TypeError, match=told):
        call()


@pytest.mark.parametrize(("call", "told"), [
    (lambda: HITS.spawn(co.refract((0, 0, 1), HITS.normal, 1.5)), r"; co.refract gives two things, directions, total = co.refract\(...\)$"),
    (lambda: co.glass(1.5, "BK7"), r"got 'BK7'; a name is given by its argument, name='BK7'$"),
    (lambda: co.glass("BK7"), r"refractive_index must be a number, got 'BK7'; a name is given by its argument"),
    (lambda: co.glass([1.5, 1.6]), r"a scene is of one wavelength: make one for each"), (lambda: co.glass(np.array([1.5, 1.6])), "one wavelength"),
    (lambda: co.glass(1.5, "#12"), r"\(2 digits after #: there must be 6, or 3 as in '#rgb'\)$"), (lambda: co.matte("ff0000"), r"\(did you mean '#ff0000'\?\)"),
    (lambda: co.matte(0.5), r"color must be 3 numbers, got the number 0.5; that grey is \[0.5, 0.5, 0.5\]$"),
    (lambda: co.matte(0xC0FFEE), r"that colour is '#c0ffee'$"), (lambda: co.Image(np.eye(3), colormap="viridis"), r"plt.imshow\(image.values, cmap=...\)$"),
    (lambda: co.Sphere(1e-300), "radius must be > 0, from 1e-100 to 1e100, got 1e-300$"), (lambda: co.Sphere(1e300), "radius must be > 0, from 1e-100 to 1e100"),
    (lambda: co.Sphere(-1), "radius must be > 0, got -1.0$"), (lambda: co.SpotLight((0, 0, 1), (0, 0, -1), 200), r"in \(0, 180\], got 200.0 degrees$"),
    (lambda: co.SpotLight((0, 0, 1), (0, 0, -1), 3), r"soft_edge must be in \[0, angle = 3\], got 5.0 degrees$"),
    (lambda: co.Hits.load("hits.csv"), r"read by np.genfromtxt\(path, delimiter=',', names=True\)$"),
])  # fmt: skip
def test_values(call, told):
    with pytest.raises(ValueError, match=told):
        call()


def test_an_entry_that_there_is_not_is_told_before_what_takes_its_place():
    with pytest.raises(KeyError, match="no body named 'cube'; named bodies: 'ball'"):
        SCENE.replace("cube")
    with pytest.raises(
        TypeError, match=r"which entry comes first, its name or number: replace\(name, shape\), got Sphere$"
    ):
        SCENE.replace(BALL)


def test_an_axis_more():
    for hits in (HITS, HITS.detached()):
        more = hits[..., None]
        assert more.shape == more.t.shape == more.rays.shape == (2, 1)
        assert np.array_equal(more.normal, hits.normal[:, None])
        assert np.array_equal(more.uv[:, 0], hits.uv)
        assert more[..., 0] == hits
    assert RAYS[..., None][..., 0] == RAYS == RAYS[None][0]
    assert RAYS[..., 1] == RAYS[1]


@pytest.mark.parametrize("detached", [False, True])
def test_many_rays_are_spawned_on_each_hit(detached):
    """(many, *hits.shape, 3) directions start many rays on each, and they know their surfaces."""
    hits = SCENE.first_hit(co.Rays([(0, 0, 5), (0.1, 0, 5), (0, 9, 0)], (0, 0, -1)))
    given = hits.detached() if detached else hits
    directions = np.random.default_rng(4).normal(size=(7, 3, 3))
    rays = given.spawn(directions)
    assert rays.shape == (7, 3)
    for k in range(7):
        assert rays[k] == hits.spawn(directions[k])
    assert np.array_equal(SCENE.first_hit(rays).t, [SCENE.first_hit(hits.spawn(d)).t for d in directions])
    assert given[0].spawn(directions[:, 0]) == rays[:, 0]
    assert given[:, None].spawn(np.swapaxes(directions, 0, 1)).shape == (3, 7)
    with pytest.raises(
        ValueError,
        match=r"spawn: directions must broadcast to \(3, 3\), got \(3, 1, 3\); for several of each hit, \(many, 3, 3\)",
    ):
        given.spawn(directions[:3, :1])
    bad = directions.copy()
    bad[5, 1] = 0
    with pytest.raises(ValueError, match=r"got \(0.0, 0.0, 0.0\) at \(5, 1\)$"):
        given.spawn(bad)
    bad[5, 1], bad[5, 2] = 1, np.nan
    given.spawn(bad)  # a miss


@pytest.mark.parametrize(("text", "told"), [
    ("camera: {position: [0, 0, 5], target: [0, 0, 0]}", r"unknown key 'target' \(did you mean 'look_at'\?\)"),
    ("camera: {position: [0, 0, 5], look_at: [0, 0, 0], fov: 40}", r"unknown key 'fov' \(did you mean 'field_of_view'\?\)"),
    ("lights: [{PointLight: {position: [0, 0, 5], color: red}}]", r"unknown key 'color' \(did you mean 'intensity'\?\)"),
    ("light: []", r"unknown key 'light' \(did you mean 'lights'\?\)"), ("background: 0x141e5a", r"got 0x141e5a; that colour is '#141e5a'$"),
    ("background: 0.5", r"got 0.5; that grey is \[0.5, 0.5, 0.5\]$"), ("background: skyblu", r"\(did you mean 'skyblue'\?\)$"),
    ("materials: {a: {matte: {color: ff0000}}}", r"\(did you mean '#ff0000'\?\)$"), ("materials: {a: {matte: {color: 5}}}", "got 5$"),
    ("materials: {a: {color: red}}", r"unknown material 'color': it stands among the fields of one, \{matte: \{color: ...\}\}$"),
    ("materials: {a: {matte: {density: 3}}}", r"unknown key 'density' \(did you mean 'properties'\?\)"),
])  # fmt: skip
def test_scene_files(text, told):
    with pytest.raises(co.SceneFileError, match=told):
        parse_scene(f"{text}\nbodies: []", "x.yaml")


@pytest.mark.parametrize(("body", "told"), [
    ("{shape: {Box: {}}, move: [{rotate: {axis: z, angle: 30}}]}", r"unknown key 'angle' \(did you mean 'degrees'\?\)"),
    ("{shape: {Box: {min: [0, 0, 0]}}}", r"unknown key 'min' \(did you mean 'low'\?\)"), ("{shape: {Sphere: {r: 1}}}", r"\(did you mean 'radius'\?\)"),
    ("{shape: {Box: {}}, material: [1, 0, 0]}", r"a colour of three numbers is \{matte: \{color: \[1, 0, 0\]\}\}$"),
    ("{Sphere: {radius: 2}}", r"unknown key 'Sphere' \(known: material, move, name, shape; write \{shape: \{Name: "),
    ("{shape: {Box: {}}, translate: [0, 0, 1]}", r"unknown key 'translate' \(motions are a list: \{move: "),
    ("{shape: {Box: {}}, name: ''}", r"name: must be a text, got '', which is empty \(leave it out where there is none\)$"),
    ("{shape: {Box: {}}, name: }", r"got nothing \(# begins a comment: .*; what has no value is left out\)$"),
])  # fmt: skip
def test_bodies_in_scene_files(body, told):
    with pytest.raises(co.SceneFileError, match=told):
        parse_scene(f"bodies: [{body}]", "x.yaml")


def test_synonyms_name_no_argument_twice():
    assert all(name == name.casefold() for name in synonyms._ARGUMENT_SYNONYMS)


@pytest.mark.parametrize("load", [co.load, co.load_openmc, co.Scene.load])
def test_a_file_that_is_not_there_is_not_found(load, tmp_path):
    with pytest.raises(FileNotFoundError, match="none.yaml: cannot be read: no such file or directory") as error:
        load(tmp_path / "none.yaml")
    assert isinstance(error.value, co.SceneFileError)
    assert (error.value.filename, error.value.errno) == (str(tmp_path / "none.yaml"), 2)
    again = pickle.loads(pickle.dumps(error.value))
    assert type(again) is type(error.value)
    assert str(again) == str(error.value)
    assert "none.yaml: cannot be read: no such file" in refused("info", tmp_path / "none.yaml")


def test_a_file_that_cannot_be_read_is_an_error_of_the_system_too(tmp_path):
    (tmp_path / "loop.yaml").symlink_to(tmp_path / "loop.yaml")
    with pytest.raises(OSError, match="cannot be read") as error:
        co.load(tmp_path / "loop.yaml")
    assert isinstance(error.value, co.SceneFileError)
    assert not isinstance(error.value, FileNotFoundError)


@pytest.fixture
def files(tmp_path):
    SCENE.save(tmp_path / "scene.yaml")
    table = np.column_stack([RAYS.origins, RAYS.directions * 3])
    np.save(tmp_path / "rays.npy", table)
    np.savez(tmp_path / "rays.npz", origins=table[:, :3], directions=table[:, 3:], t_max=[1.5, 9])
    return tmp_path


def test_traces_in_csv_read_back(files):
    rays = co.Rays.load(files / "rays.npy")
    assert run("trace", files / "scene.yaml", files / "rays.npy", "-o", files / "hits.csv", "--errors").exit_code == 0
    table, hits = np.genfromtxt(files / "hits.csv", delimiter=",", names=True), SCENE.first_hit(rays)
    for name in ("t", "body", "face", "surface", "entering", "t_error"):
        assert np.array_equal(table[name], getattr(hits, name))
    assert np.array_equal(np.stack([table["x"], table["y"], table["z"]], axis=-1), hits.point)
    assert (
        run("trace", files / "scene.yaml", files / "rays.npy", "-o", files / "s.csv", "--errors", "--spans").exit_code
        == 0
    )
    table, spans = np.genfromtxt(files / "s.csv", delimiter=",", names=True), SCENE.spans(rays)
    for name in ("t_enter", "t_exit", "t_enter_error", "t_exit_error", "body"):
        assert np.array_equal(table[name], getattr(spans, name))
    assert "--errors goes with .csv" in refused(
        "trace", files / "scene.yaml", files / "rays.npy", "-o", files / "x.npz", "--errors"
    )


def test_intervals_of_the_command_line(files):
    arguments = files / "scene.yaml", files / "rays.npy", "-o", files / "x.npz"
    assert run("trace", *arguments, "--t-min", "1.5", "--t-max", "3").exit_code == 0
    assert (
        co.Hits.load(files / "x.npz")
        == SCENE.first_hit(co.Rays.load(files / "rays.npy"), t_min=1.5, t_max=3).detached()
    )
    assert run("lengths", *arguments, "--t-max", "1.5").exit_code == 0
    with np.load(files / "x.npz") as found:
        assert np.array_equal(found["lengths"], SCENE.lengths(co.Rays.load(files / "rays.npy"), t_max=1.5))
    assert run("trace", *arguments, "--t-min=-inf").exit_code == 0
    assert "--t-min must not be NaN" in refused("trace", *arguments, "--t-min", "nan")
    held = files / "scene.yaml", files / "rays.npz", "-o", files / "x.npz"
    assert "rays.npz: holds t_max for its rays; --t-max 3" in refused("trace", *held, "--t-max", "3")
    assert run("trace", *held, "--t-min", "1").exit_code == 0


def test_the_command_line_tells_of_a_field_of_view_in_radians(files):
    picture = (
        files / "x.png",
        "--width",
        8,
        "--height",
        6,
        "--position",
        "0,0,9",
        "--field-of-view",
        "0.7853981633974483",
    )
    told = run("render", files / "scene.yaml", "-o", *picture)
    assert told.exit_code == 0
    assert (
        "note: Camera: field_of_view must be in degrees, got 0.7853981633974483: 45 degrees are that in radians"
        in told.stderr
    )
