"""The output, the measures and the errors of commands."""

import csv
import io
import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import conicoid as co
from conicoid.cli import terminal as exit_codes
from conicoid.cli.app import app

from .command_line import arrays, execute, failure, run, scene_file

# --- Output and files of commands


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    return scene_file(tmp_path)


def test_info(scene):
    result = execute("info", scene)
    lines = result.stdout.splitlines()
    assert lines[1].split() == ["0", "ball", "red", "Sphere", "x", "[-1,", "1]", "y", "[-1,", "1]", "z", "[-1,", "1]"]
    assert lines[3].split()[:3] == ["2-3", "-", "Spheres"]
    assert "z [-inf, -3]" in lines[4]
    totals = dict(line.split(maxsplit=1) for line in lines[6:])
    assert totals["bodies"] == "5"
    assert totals["surfaces"] == "10"  # a ball, six walls, two balls, a half-space
    _, unit, text = totals["memory"].split(maxsplit=2)
    assert unit in ("bytes", "kB")
    # The ball, the box, two balls, the half-space; the tree's node has 8 boxes of 6 floats
    assert text.startswith("for 5 primitives: ")
    assert int(text.split(", ")[1].split()[0]) >= 8 * 6 * 8 / 5


def test_info_of_nothing_and_of_many(tmp_path):
    (tmp_path / "scene.yaml").write_text("bodies: []\n")
    result = execute("info", tmp_path / "scene.yaml")
    assert "no bodies" in result.stdout
    assert "bounds    empty" in result.stdout
    (tmp_path / "scene.yaml").write_text("bodies:\n" + "  - shape: {Sphere: {}}\n" * 60)
    assert "and 10 more" in run("info", tmp_path / "scene.yaml").stdout


def test_schema():
    result = execute("schema")
    assert json.loads(result.stdout)["$schema"].startswith("https://json-schema.org/")


def test_trace_first_hits(scene, tmp_path):
    """By hand: the unit ball from above at z = 1, the box's wall x = 2 at t = 1 of a direction of length 2, a miss."""
    rays = np.array([[0, 0, 3, 0, 0, -1], [0, 5, 0.5, 0, 1, 0], [0, 0, 1.5, 2, 0, -0.5]])
    np.save(tmp_path / "rays.npy", rays)
    assert run("trace", scene, tmp_path / "rays.npy", "-o", tmp_path / "hits.npz").exit_code == 0
    hits = arrays(tmp_path / "hits.npz")
    assert hits["t"].tolist() == [2.0, np.inf, 1.0]
    assert hits["body"].tolist() == [0, -1, 1]
    assert hits["point"][0].tolist() == [0, 0, 1]
    assert hits["normal"][2].tolist() == [0, 0, 1] or hits["normal"][2].tolist() == [-1, 0, 0]
    assert hits["entering"].tolist() == [True, False, True]
    assert np.isnan(hits["uv"][1]).all()
    expected = co.load(scene).first_hit(rays[:, :3], rays[:, 3:])
    for name in ("t", "point", "normal", "uv", "body", "face", "surface", "entering"):
        assert np.array_equal(hits[name], getattr(expected, name), equal_nan=hits[name].dtype.kind == "f")


def test_trace_spans(scene, tmp_path):
    (tmp_path / "rays.csv").write_text("0,0,20,0,0,-2\n9,9,9,1,0,0\n")
    result = execute("trace", scene, tmp_path / "rays.csv", "-o", tmp_path / "spans.csv", "--spans")
    assert "4 spans of 2 rays" in result.stderr
    rows = (tmp_path / "spans.csv").read_text().splitlines()
    # along z from 20 downwards, two units at a time
    assert rows[1:] == ["0,3,5.0,6.0,0,0", "0,2,7.0,8.0,0,0", "0,0,9.5,10.5,0,0", "0,4,11.5,inf,0,1"]


def test_trace_keeps_the_shape_and_the_interval_of_rays(scene, tmp_path):
    origins = np.zeros((2, 3, 3))
    origins[..., 2] = 20
    t_max = np.array([[1.0, 11.5, 30.0]])
    np.savez(tmp_path / "rays.npz", origins=origins, directions=np.array([0, 0, -1.0]), t_max=t_max)
    assert run("trace", scene, tmp_path / "rays.npz", "-o", tmp_path / "hits.npz").exit_code == 0
    hits = arrays(tmp_path / "hits.npz")
    assert hits["t"].tolist() == [[np.inf, 10.0, 10.0]] * 2
    assert hits["point"].shape == (2, 3, 3)
    np.savez(tmp_path / "rays.npz", origins=origins, directions=np.array([0, 0, -1.0]), t_max=np.zeros(4))
    assert "t_min and t_max must broadcast" in failure("trace", scene, tmp_path / "rays.npz", "-o", tmp_path / "x.npz")


def test_trace_in_pieces(scene, tmp_path, monkeypatch):
    monkeypatch.setattr("conicoid.cli.app.PIECE", 7)
    rays = np.random.default_rng(5).normal(size=(50, 6))
    np.save(tmp_path / "rays.npy", rays)
    loaded = co.load(scene)
    for options, names in (([], ("t", "body")), (["--spans"], ("offsets", "t_enter", "t_exit", "body"))):
        assert run("trace", scene, tmp_path / "rays.npy", "-o", tmp_path / "out.npz", *options).exit_code == 0
        query = loaded.spans if options else loaded.first_hit
        expected, found = query(rays[:, :3], rays[:, 3:]), arrays(tmp_path / "out.npz")
        for name in names:
            assert np.array_equal(found[name], getattr(expected, name))


@pytest.mark.parametrize("options", [[], ["--spans"]])
def test_trace_no_rays(scene, tmp_path, options):
    (tmp_path / "rays.csv").write_text("")
    assert "rays.csv" in failure("trace", scene, tmp_path / "rays.csv", "-o", tmp_path / "out.csv", *options)
    assert not (tmp_path / "out.csv").exists()
    np.save(tmp_path / "rays.npy", np.zeros((0, 6)))
    assert run("trace", scene, tmp_path / "rays.npy", "-o", tmp_path / "out.csv", *options).exit_code == 0
    assert len((tmp_path / "out.csv").read_text().splitlines()) == 1


# --- Lengths, line integrals and measures on the command line; findings in the exit code; repeated options

LEAD, WATER = (
    co.matte("gray", name="lead", properties={"mu": 1.5}),
    co.matte("blue", name="water", properties={"mu": 0.5}),
)
MEASURED = co.Scene([
    co.Body(co.Sphere(1), LEAD, "ball"), co.Body(co.Box((2, -1, -1), (4, 1, 1)), WATER, "a block, of water"),
    co.Body(co.Sphere(0.5, (8, 0, 0)), LEAD), co.Body(co.Box((5, -1, -1), (6, 1, 1)), "red", "body 0"),
])  # fmt: skip
TABLE = np.array([[(0, 0, 9, 0, 0, -2), (-9, 0, 0, 1, 0, 0)], [(3, 0, 9, 0, 0, -1), (0, 9, 9, 0, 0, 1)]], float)
ALONG = [2, 2, 1, 1]
"""Lengths of the second ray, along x through the middle of all: diameters and widths."""


@pytest.fixture
def files(tmp_path):
    MEASURED.save(tmp_path / "scene.yaml")
    np.save(tmp_path / "rays.npy", TABLE)
    return tmp_path / "scene.yaml", tmp_path / "rays.npy"


def _rows(path):
    text = path.read_text(encoding="utf-8") if hasattr(path, "read_text") else path
    return list(csv.reader(io.StringIO(text)))


def test_lengths_inside_bodies(files, tmp_path):
    result = execute("lengths", *files, "-o", tmp_path / "lengths.npz")
    assert "lengths of 4 rays inside 4 bodies; 3 inside any" in result.stderr
    found = arrays(tmp_path / "lengths.npz")
    assert found["lengths"].tolist() == [[[2, 0, 0, 0], ALONG], [[0, 2, 0, 0], [0, 0, 0, 0]]]
    assert found["columns"].tolist() == ["ball", "a block, of water", "body 2", "body 3 (body 0)"]
    assert run("lengths", *files, "-o", tmp_path / "lengths.csv").exit_code == 0
    head, *rows = _rows(tmp_path / "lengths.csv")
    assert head == found["columns"].tolist()
    assert [[float(cell) for cell in row] for row in rows] == found["lengths"].reshape(4, 4).tolist()


def test_lengths_inside_materials(files):
    result = execute("lengths", *files, "-o", "-", "--by", "material")
    head, *rows = _rows(result.stdout)
    assert head == ["lead", "water", "material 2"]
    assert [float(cell) for cell in rows[1]] == [3, 2, 1]


@pytest.mark.parametrize(("options", "expected"), [
    (["--value", "lead=2", "--value", "water=10", "--otherwise", "0"], 2 * 3 + 10 * 2),
    (["--value", "lead=2", "--value", "water=1e1", "--otherwise", "100"], 2 * 3 + 10 * 2 + 100),
    (["--property", "mu", "--otherwise", "0"], 1.5 * 3 + 0.5 * 2),
])  # fmt: skip
def test_line_integrals(options, expected, files, tmp_path):
    result = execute("lengths", *files, "-o", tmp_path / "found.npz", *options)
    assert "line integrals of 4 rays" in result.stderr
    found = arrays(tmp_path / "found.npz")
    assert list(found) == ["line_integrals"]
    assert found["line_integrals"].shape == (2, 2)
    assert found["line_integrals"][0, 1] == expected
    result = run("lengths", *files, "-o", "-", *options)
    assert result.stdout.splitlines()[0] == "line_integral"
    assert float(result.stdout.splitlines()[2]) == expected


def test_a_property_by_energy_has_columns(files, tmp_path):
    scene = co.Scene([co.Body(co.Sphere(), co.matte(properties={"mu": [1.0, 0.25]}))])
    scene.save(files[0])
    result = run("lengths", *files, "-o", "-", "--property", "mu")
    assert result.stdout.splitlines()[:3] == ["line_integral_0,line_integral_1", "2.0,0.5", "2.0,0.5"]
    assert run("lengths", *files, "-o", tmp_path / "found.npz", "--property", "mu").exit_code == 0
    assert arrays(tmp_path / "found.npz")["line_integrals"].shape == (2, 2, 2)


LENGTHS = "lengths", "SCENE", "RAYS", "-o", "found.csv"
RENDER = "render", "SCENE", "-o", "x.png"


@pytest.mark.parametrize(("words", "message"), [
    ((*LENGTHS, "--by", "bodies"), "lengths: by must be one of body, material, got 'bodies' (did you mean 'body'?)"),
    ((*LENGTHS, "--otherwise", "0"), "lengths: --otherwise goes with --value or --property; it would be ignored"),
    ((*LENGTHS, "--property", "mu", "--by", "material"), "lengths: --by goes with lengths, not with --value or --property"),
    ((*LENGTHS, "--property", "mu", "--value", "lead=1"), "lengths: give either --value or --property"),
    ((*LENGTHS, "--value", "lead"), "lengths: --value must be MATERIAL=NUMBER, got 'lead'"),
    ((*LENGTHS, "--value", "=3"), "lengths: --value must be MATERIAL=NUMBER, got '=3'"),
    ((*LENGTHS, "--value", "lead=1", "--value", "lead=2"), "lengths: --value is given twice for 'lead'"),
    ((*LENGTHS, "--value", "lead=1"), "lengths: no value for material 'water'"),
    ((*LENGTHS, "--value", "lead=1"), "--otherwise 0 would stand"),
    ((*LENGTHS, "--value", "led=1"), "no material is called 'led'"),
    ((*LENGTHS, "--value", "ball=1", "--otherwise", "0"), "materials: 'lead'"),
    ((*LENGTHS, "--value", "lead=nan"), "must be MATERIAL=NUMBER, got 'lead=nan'"),
    ((*RENDER, "--section", "z"), "--section must be x=NUMBER, y=NUMBER or z=NUMBER, got 'z'"),
    ((*RENDER, "--section", "q=0"), "--section must be"),
    ((*RENDER, "--section", "z=ten"), "--section must be"),
    ((*RENDER, "--section", "z=nan"), "at must be finite"),
    ((*RENDER, "--section", "z=0", "--axes"), "--axes goes with a view, not with --section"),
    ((*RENDER, "--section", "z=0", "--depth", "3"), "--depth goes with a view"),
    ((*RENDER, "--section", "z=0", "--fit"), "--fit goes with a view"),
    (("measure", "SCENE", "-o", "found.npz"), "measures are written as .csv"),
    ((*RENDER, "--section", "z=0", "--slice", "x=0"), " is given "),
    ((*RENDER, "-o", "a.png", "--output", "b.png"), " is given "),
    ((*RENDER, *("--section", "z=0") * 3), " is given "),
])  # fmt: skip
def test_senseless_options(words, message, files, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    before = {"SCENE": files[0], "RAYS": files[1]}
    assert message in failure(*(before.get(word, word) for word in words))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["rays.npy", "scene.yaml"]


def test_measures_of_every_body(files, tmp_path):
    result = execute("measure", files[0])
    assert "body 1 'a block, of water'" in result.stdout
    execute("measure", files[0], "-o", tmp_path / "volumes.csv")
    rows = list(csv.DictReader(io.StringIO((tmp_path / "volumes.csv").read_text(encoding="utf-8"))))
    assert [(row["body"], row["name"], row["material"]) for row in rows] == [
        ("0", "ball", "lead"), ("1", "a block, of water", "water"), ("2", "", "lead"), ("3", "body 0", ""),
    ]  # fmt: skip
    volumes = [4 / 3 * math.pi, 8, 4 / 3 * math.pi / 8, 4]
    assert [float(row["volume"]) for row in rows] == pytest.approx(volumes, rel=1e-15)
    assert [float(row["area"]) for row in rows] == pytest.approx([4 * math.pi, 24, math.pi, 16], rel=1e-15)
    assert [float(row["centroid_x"]) for row in rows] == pytest.approx([0, 3, 8, 5.5])
    assert float(rows[1]["inertia_xx"]) == pytest.approx(8 * (4 + 4) / 12)
    assert float(rows[3]["inertia_xx"]) == pytest.approx(4 * (4 + 4) / 12)
    assert float(rows[3]["inertia_yy"]) == pytest.approx(4 * (1 + 4) / 12)


def test_measures_do_not_overwrite_their_scene(files, tmp_path):
    assert "would be lost" in failure("measure", files[0].rename(tmp_path / "scene.csv"), "-o", tmp_path / "scene.csv")


def test_long_names_are_not_cut(tmp_path):
    name = "a body whose name is as long as names of imported models are, with where it stands"
    co.Scene([
        co.Body(co.Sphere(), co.matte("red", name=f"material of {name}"), name), co.Body(co.Box((2, 2, 2), (3, 3, 3))),
    ]).save(tmp_path / "scene.yaml")  # fmt: skip
    lines = run("info", tmp_path / "scene.yaml").stdout.splitlines()
    assert f"{name} material of {name} Sphere" in lines[1]
    assert lines[1].index("x [") == lines[2].index("x [") == lines[0].index("bounds")
    lines = run("measure", tmp_path / "scene.yaml").stdout.splitlines()
    assert f"material 'material of {name}' " in lines[1]
    assert len({len(line) for line in lines}) == 1


def test_findings_are_in_the_exit_code(files, tmp_path):
    assert run("info", files[0], "--check").exit_code == exit_codes.EXIT_OK
    co.Scene([co.Sphere(), co.Sphere(1, (1, 0, 0))]).save(files[0])
    result = run("info", files[0], "--check")
    assert result.exit_code == exit_codes.EXIT_FINDINGS == 3
    assert "overlap: " in result.stdout
    assert run("info", files[0]).exit_code == exit_codes.EXIT_OK


def _options():
    """Return an option with a value, and a flag, of each command that has them."""
    import typer.main

    for name, command in typer.main.get_command(app).commands.items():
        for option in command.params:
            if option.param_type_name == "option" and not option.multiple and option.name != "help":
                yield name, max(option.opts, key=len), [] if option.is_flag else ["1"] * option.nargs


@pytest.mark.parametrize(("command", "option", "value"), list(_options()))
def test_no_option_counts_only_the_last_time(command, option, value):
    assert f"{option} is given twice" in " ".join(failure(command, option, *value, option, *value).split())


def test_a_section_beside_all_bodies_is_reported(files, tmp_path):
    small = ("--width", "40", "--height", "30", "--samples", "1")
    result = execute("render", files[0], "-o", tmp_path / "x.png", "--section", "z=30", *small)
    assert (
        "note: section: no solid is cut by z = 30, so the picture is white; bodies reach from z = -1 to 1"
        in result.stderr
    )
    assert "note" not in run("render", files[0], "-o", tmp_path / "x.png", "--section", "z=0.5", *small).stderr
    with pytest.warns(UserWarning, match="no solid is cut by x = -7") as caught:
        MEASURED.section("x", -7, 8, 6)
    assert caught[0].filename == __file__
    with pytest.warns(UserWarning, match="no solid is cut in the window of this camera"):
        MEASURED.section(co.OrthographicCamera((0, 0, 9), (0, 0, 10)), width=8, height=6)
    with pytest.warns(UserWarning, match="sheets have no inside"):
        co.Scene(co.Disc((0, 0, 0), (0, 0, 1), 1)).section("x", 0, 8, 6)


def test_an_empty_view_is_reported(files, tmp_path):
    view = ("render", files[0], "-o", tmp_path / "x.png", "--width", "40", "--height", "30", "--samples", "1")
    result = execute(*view, "--position", "0,0,9", "--look-at", "0,0,10")
    assert "note: no body is in view; --fit takes a camera that sees all that is bounded" in result.stderr
    assert "note" not in run(*view, "--position", "0,0,9", "--look-at", "0,0,0").stderr
    assert "note" not in run(*view, "--fit").stderr


# --- Output and errors of commands: lists, plans, sections, and command lines that do not fit

SCENE = co.Scene(
    [
        co.Body(co.Box((-1, -2, -3), (1, 2, 3)) - co.Sphere(0.5), "red", "box"),
        co.Body(co.Sphere(0.5), co.matte((0, 0, 1), name="fuel"), "ball"),
        co.Disc((0, 0, 9), (0, 0, 1), 1),
    ]
)


@pytest.fixture
def path(tmp_path):
    SCENE.save(tmp_path / "scene.yaml")
    return tmp_path / "scene.yaml"


def test_info_lists_materials(path):
    lines = run("info", path).stdout.splitlines()
    assert [line.split()[:4] for line in lines[:4]] == [
        ["id", "name", "material", "shape"], ["0", "box", "red", "Difference"], ["1", "ball", "fuel", "Sphere"],
        ["2", "-", "Disc", "x"],
    ]  # fmt: skip


@pytest.mark.parametrize(("domain", "message"), [
    (None, ["not looked for: undefined regions (the scene has no domain for its bodies to fill)"]),
    (co.Box((-1, -2, -3), (1, 2, 3)), []),
    (co.Box() & co.Box((2, 2, 2), (3, 3, 3)), ["not looked for: undefined regions (the scene's domain is empty)"]),
])  # fmt: skip
def test_info_check_names_omitted_checks(domain, message, path):
    SCENE.replace(domain=domain).save(path)
    result = execute("info", path, "--check", "--rays", "300")
    assert [line for line in result.stdout.splitlines() if line.startswith("not looked for")] == message


@pytest.mark.parametrize(("arguments", "text"), [
    (("info", "-"), "scenes"), (("render", "-", "-o", "x.png"), "scenes"), (("view", "-"), "scenes"),
    (("export", "-", "x.html"), "scenes"), (("trace", "-", "RAYS", "-o", "x.csv"), "scenes"),
    (("trace", "SCENE", "-", "-o", "x.csv"), "rays"), (("import", "-", "-o", "x.yaml"), "files of other programs"),
])  # fmt: skip
def test_standard_input_is_refused(arguments, text, path, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "rays.csv").write_text("0,0,9,0,0,-1\n")
    files = {"SCENE": path, "RAYS": tmp_path / "rays.csv"}
    assert f"error: -: {text} are read from files, not from standard input; name a file" in failure(
        *(files.get(argument, argument) for argument in arguments)
    )


def test_trace_names_columns_that_it_does_not_read(path, tmp_path):
    np.savez(tmp_path / "rays.npz", origins=[[0, 0, 9.5]], directions=[[0, 0, -1.0]], wavelength=[5.0])
    result = execute("trace", path, tmp_path / "rays.npz", "-o", tmp_path / "hits.csv")
    assert "rays.npz: not read: wavelength; arrays of rays are" in " ".join(result.stderr.split())
    (tmp_path / "rays.csv").write_text("x,y,z,dx,dy,dz\n")
    result = execute("trace", path, tmp_path / "rays.csv", "-o", tmp_path / "hits.csv")
    assert "rays.csv: holds no rays" in " ".join(result.stderr.split())


def test_trace_knows_where_saved_rays_start(path, tmp_path):
    hits = SCENE.first_hit([(0, 0.1, 12), (0, 0.2, 12), (9, 9, 9)], (0, 0, -1))
    hits.spawn((0, 0.3, -1)).save(tmp_path / "rays.npz")
    execute("trace", path, tmp_path / "rays.npz", "-o", tmp_path / "hits.npz")
    assert np.load(tmp_path / "hits.npz")["t"].tolist() == SCENE.first_hit(hits.spawn((0, 0.3, -1))).t.tolist()
    assert np.load(tmp_path / "hits.npz")["t"].min() > 5  # and not 0 on the disc


def test_render_orthographic(path, tmp_path):
    options = ("--width", "40", "--height", "30", "--samples", "1")
    plan = tmp_path / "plan.png"
    execute("render", path, "-o", plan, "--position", "0,0,20", "--look-at", "0,0,0", "--orthographic", "6", *options)
    SCENE.render(40, 30, 1, camera=co.OrthographicCamera((0, 0, 20), (0, 0, 0), height=6)).save(tmp_path / "again.png")
    assert np.array_equal(Image.open(plan), Image.open(tmp_path / "again.png"))
    assert "--orthographic goes with --position" in failure("render", path, "-o", plan, "--orthographic", "6")
    failure("render", path, "-o", plan, "--position", "0,0,9", "--orthographic", "6", "--field-of-view", "3")
    result = run("render", path, "-o", plan, "--position", "0,0,9", "--orthographic", "-6")
    assert "OrthographicCamera: height must be > 0" in result.stderr


def test_render_slice_has_the_colours_of_bodies(path, tmp_path):
    picture = tmp_path / "section.png"
    execute("render", path, "-o", picture, "--slice", "x=0", "--width", "80", "--height", "60", "--samples", "1")
    pixels = np.asarray(Image.open(picture).convert("RGB"))
    # From y = -2 to 2 and z = -3 to 9: one pixel is 1.05 * 12 / 60 = 0.21 wide, and the middle is at (0, 3)
    size = 1.05 * 12 / 60
    y, z = np.meshgrid((np.arange(80) + 0.5 - 40) * size, 3 + (30 - np.arange(60) - 0.5) * size)
    far = np.abs(np.hypot(y, z) - 0.5)
    is_clear = (np.minimum(np.abs(np.abs(y) - 2), np.abs(np.abs(z) - 3)) > 2 * size) & (far > 2 * size)  # of lines
    is_box = (np.abs(y) < 2) & (np.abs(z) < 3) & (np.hypot(y, z) > 0.5)
    is_ball = np.hypot(y, z) < 0.2
    for where, color in (
        (is_ball, (0, 0, 255)),
        (is_box & is_clear, (255, 0, 0)),
        (~is_box & is_clear, (255, 255, 255)),
    ):
        assert where.any()
        assert (pixels[where] == color).all()
    assert np.array_equal(pixels, SCENE.section("x", 0, 80, 60, 1))


def test_section_of_a_camera():
    low, high = SCENE.extent
    height = 1.05 * float(high[2] - low[2])
    camera = co.OrthographicCamera((1, 0, 3), (0, 0, 3), height=height)
    assert np.array_equal(SCENE.section(camera, width=40, height=30), SCENE.section("x", 1, 40, 30))


@pytest.mark.parametrize(("arguments", "message"), [
    (dict(plane="w"), "plane must be 'x', 'y', 'z' or an OrthographicCamera, got 'w'"),
    (dict(plane=co.Camera((0, 0, 5), (0, 0, 0))), "plane must be .*, got Camera"),
    (dict(plane=co.OrthographicCamera((0, 0, 5), (0, 0, 0)), at=3), "at goes with an axis"),
    (dict(at=float("nan")), "section: at must be finite"),
    (dict(samples=0), "section: samples must be a whole number from 1 to 256, got 0"),
    (dict(width=0), "width must be a whole number of pixels"),
])  # fmt: skip
def test_section_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        SCENE.section(**arguments)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("check", "x"), "No such command 'check'."),
        (("measur", "x"), "No such command 'measur'. Did you mean 'measure'?"),
        (("trace", "x", "rays.npy", "--out", "x.npz"), "--output"),
        (("render", "{}", "-o", "x.png", "--position", "1", "2", "3"), "unexpected extra argument(s) (2 3)"),
        (
            ("render", "{}", "-o", "x.png", "--width", "64x48"),
            "Invalid value for '--width': Input should be a valid integer",
        ),
        (
            ("render", "{}", "-o", "x.png", "--samples", "1.5"),
            "Invalid value for '--samples': Input should be a valid integer",
        ),
        (("render", "{}", "x.png"), "Missing option '--output'"),
    ],
)
def test_command_lines_refused(arguments, message, path):
    assert message in " ".join(
        failure(*(str(path) if word == "{}" else word for word in arguments)).replace("│", " ").split()
    )


def test_help_command():
    assert run("help").stdout == run("--help").stdout
    assert run("help", "render").stdout == run("render", "--help").stdout


def test_export_needs_a_file(path):
    assert "Missing argument 'FILE'" in run("export", path).stderr


@pytest.mark.parametrize(("command", "extra"), [("turntable", "video")])
def test_help_shows_extras_in_brackets(command, extra):
    words = " ".join(re.sub("[^ -~]", " ", run(command, "--help").stdout).split())
    assert f"pip install 'conicoid[{extra}]'" in words


@pytest.mark.parametrize("option", [(), ("--spans",)])
def test_trace_does_not_overwrite_its_rays(tmp_path, option):
    co.save(co.Scene(co.Sphere()), tmp_path / "scene.yaml")
    rays = tmp_path / "mine.csv"
    rays.write_text("x,y,z,dx,dy,dz\n20,0,0,-1,0,0\n")
    other = tmp_path / "link.csv"
    other.symlink_to(rays)
    for output in (rays, other):
        assert "is read for this and would be lost: choose another file for the results" in failure(
            "trace", tmp_path / "scene.yaml", rays, "-o", output, *option
        )
    assert rays.read_text().startswith("x,y,z,dx")
    assert run("trace", tmp_path / "scene.yaml", rays, "-o", tmp_path / "new.csv", *option).exit_code == 0
