"""What commands print, and what they refuse: lists, plans, sections, and command lines that do not fit."""

from __future__ import annotations

import re

import numpy as np
import pytest
from PIL import Image

import conicoid as co
from conicoid.cli import resources as working

from .command_line import refused, run

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


def test_info_counts_entries(path, monkeypatch):
    monkeypatch.setattr(working, "PATIENCE", -1)
    SCENE.replace("box", co.Sphere(3)).save(path)
    assert "preparing 3 entries ..." in run("info", path).stderr
    co.save(co.Sphere(), path)
    assert "preparing 1 entry ..." in run("info", path).stderr


def test_info_calls_glass_clear(path):
    SCENE.replace("ball", material=co.glass()).save(path)
    assert run("info", path).stdout.splitlines()[2].split()[:3] == ["1", "ball", "clear"]


@pytest.mark.parametrize(("domain", "told"), [
    (None, ["undefined regions were not looked for: the scene has no domain for its bodies to fill"]),
    (co.Box((-1, -2, -3), (1, 2, 3)), []),
    (co.Box() & co.Box((2, 2, 2), (3, 3, 3)), ["undefined regions were not looked for: the scene's domain is empty"]),
])  # fmt: skip
def test_info_check_says_what_it_could_not_look_for(domain, told, path):
    SCENE.replace(domain=domain).save(path)
    result = run("info", path, "--check", "--rays", "300")
    assert result.exit_code == 0, result.output
    assert [line for line in result.stdout.splitlines() if line.startswith("undefined")] == told


@pytest.mark.parametrize(("arguments", "what"), [
    (("info", "-"), "scenes"), (("render", "-", "-o", "x.png"), "scenes"), (("view", "-"), "scenes"),
    (("export", "-", "x.html"), "scenes"), (("trace", "-", "RAYS", "-o", "x.csv"), "scenes"),
    (("trace", "SCENE", "-", "-o", "x.csv"), "rays"), (("import", "-", "-o", "x.yaml"), "files of other programs"),
])  # fmt: skip
def test_standard_input_is_refused(arguments, what, path, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "rays.csv").write_text("0,0,9,0,0,-1\n")
    files = {"SCENE": path, "RAYS": tmp_path / "rays.csv"}
    result = run(*(files.get(argument, argument) for argument in arguments))
    assert result.exit_code == 2
    assert f"error: -: {what} are read from files, not from standard input; name a file" in result.stderr


def test_trace_tells_what_it_does_not_read(path, tmp_path):
    np.savez(tmp_path / "rays.npz", origins=[[0, 0, 9.5]], directions=[[0, 0, -1.0]], wavelength=[5.0])
    result = run("trace", path, tmp_path / "rays.npz", "-o", tmp_path / "hits.csv")
    assert result.exit_code == 0
    assert "rays.npz: not read: wavelength; arrays of rays are" in " ".join(result.stderr.split())
    (tmp_path / "rays.csv").write_text("x,y,z,dx,dy,dz\n")
    result = run("trace", path, tmp_path / "rays.csv", "-o", tmp_path / "hits.csv")
    assert result.exit_code == 0
    assert "rays.csv: holds no rays" in " ".join(result.stderr.split())


def test_trace_knows_where_saved_rays_start(path, tmp_path):
    hits = SCENE.first_hit([(0, 0.1, 12), (0, 0.2, 12), (9, 9, 9)], (0, 0, -1))
    hits.spawn((0, 0.3, -1)).save(tmp_path / "rays.npz")
    result = run("trace", path, tmp_path / "rays.npz", "-o", tmp_path / "hits.npz")
    assert result.exit_code == 0, result.output
    assert np.load(tmp_path / "hits.npz")["t"].tolist() == SCENE.first_hit(hits.spawn((0, 0.3, -1))).t.tolist()
    assert np.load(tmp_path / "hits.npz")["t"].min() > 5  # and not 0 on the disc


def test_render_orthographic(path, tmp_path):
    options = ("--width", "40", "--height", "30", "--samples", "1")
    plan = tmp_path / "plan.png"
    result = run(
        "render", path, "-o", plan, "--position", "0,0,20", "--look-at", "0,0,0", "--orthographic", "6", *options
    )
    assert result.exit_code == 0, result.output
    SCENE.render(40, 30, 1, camera=co.OrthographicCamera((0, 0, 20), (0, 0, 0), height=6)).save(tmp_path / "again.png")
    assert np.array_equal(Image.open(plan), Image.open(tmp_path / "again.png"))
    result = run("render", path, "-o", plan, "--orthographic", "6")
    assert result.exit_code == 2
    assert "--orthographic goes with --position" in result.stderr
    result = run("render", path, "-o", plan, "--position", "0,0,9", "--orthographic", "6", "--field-of-view", "3")
    assert result.exit_code == 2
    result = run("render", path, "-o", plan, "--position", "0,0,9", "--orthographic", "-6")
    assert "OrthographicCamera: height must be > 0" in result.stderr


def test_render_slice_has_the_colours_of_bodies(path, tmp_path):
    picture = tmp_path / "section.png"
    result = run("render", path, "-o", picture, "--slice", "x=0", "--width", "80", "--height", "60", "--samples", "1")
    assert result.exit_code == 0, result.output
    pixels = np.asarray(Image.open(picture).convert("RGB"))
    # From y = -2 to 2 and z = -3 to 9: one pixel is 1.05 * 12 / 60 = 0.21 wide, and the middle lies at (0, 3)
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


@pytest.mark.parametrize(("section", "more", "message"), [
    ("z", (), "--section must be x=NUMBER, y=NUMBER or z=NUMBER, got 'z'"),
    ("q=0", (), "--section must be"), ("z=ten", (), "--section must be"), ("z=nan", (), "at must be finite"),
    ("z=0", ("--axes",), "--axes goes with a view, not with --section"),
    ("z=0", ("--depth", "3"), "--depth goes with a view"), ("z=0", ("--fit",), "--fit goes with a view"),
])  # fmt: skip
def test_section_options_refused(section, more, message, path, tmp_path):
    result = run("render", path, "-o", tmp_path / "x.png", "--section", section, *more)
    assert result.exit_code == 2
    assert message in result.stderr
    assert not (tmp_path / "x.png").exists()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("validate", "x"), "conicoid info SCENE does that"),
        (("convert", "x"), "scene.save(path) writes"),
        (("gallery",), "make demo"),
        (("render", "{}", "-o", "x.png", "--position", "1", "2", "3"), "written with commas, --position 1,2,3"),
        (("render", "{}", "-o", "x.png", "--width", "64x48"), "'--width': must be a whole number, got '64x48'"),
        (("render", "{}", "-o", "x.png", "--samples", "1.5"), "'--samples': must be a whole number, got '1.5'"),
        (("render", "{}", "x.png"), "write -o x.png"),
        (("trace", "{}", "--origin", "0,0,0"), "rays are read from a file"),
        (("trace", "{}", "r.csv", "-o", "-", "--crossings"), "in Python scene.crossings(rays)"),
    ],
)
def test_command_lines_refused(arguments, message, path):
    result = run(*(str(path) if word == "{}" else word for word in arguments))
    assert result.exit_code == 2
    assert message in " ".join(result.stderr.replace("│", " ").split())


def test_help_command():
    assert run("help").stdout == run("--help").stdout
    assert run("help", "render").stdout == run("render", "--help").stdout


def test_export_output_option(path, tmp_path):
    for k, order in enumerate(
        (("export", path, "-o", "{}"), ("export", "--output", "{}", path), ("export", path, "{}"))
    ):
        page = tmp_path / f"{k}.html"
        assert run(*(page if word == "{}" else word for word in order)).exit_code == 0
        assert page.read_bytes()
    assert "Missing argument 'FILE'" in run("export", path).stderr


def test_rays_option_takes_exponents(path):
    assert "mean" not in run("info", path, "--check", "--rays", "2e3").stderr
    assert run("info", path, "--check", "--rays", "2e3").stdout == run("info", path, "--check", "--rays", "2000").stdout
    assert "Invalid value" in run("info", path, "--check", "--rays", "-1e3").stderr


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
        result = run("trace", tmp_path / "scene.yaml", rays, "-o", output, *option)
        assert result.exit_code == 2
        assert "is read for this and would be lost: choose another file for the results" in result.stderr
    assert rays.read_text().startswith("x,y,z,dx")
    assert run("trace", tmp_path / "scene.yaml", rays, "-o", tmp_path / "new.csv", *option).exit_code == 0


def test_lengths_errors_do_not_speak_of_python(tmp_path):
    co.Scene([co.Body(co.Sphere(), co.metal("gray", name="lead"), "ball")]).save(tmp_path / "s.yaml")
    np.save(tmp_path / "r.npy", [[-5, 0, 0, 1, 0, 0.0]])
    files = tmp_path / "s.yaml", tmp_path / "r.npy", "-o"
    told = refused("lengths", *files, tmp_path / "x.csv", "--value", "ball=1", "--otherwise", "0")
    assert "no material is called 'ball'; materials: 'lead'" in told
    assert "array" not in told
    assert "None" not in refused("lengths", *files, tmp_path / "x.csv", "--overlaps", "no")
    assert "written as .npz, .csv, .parquet or .zarr" in refused("trace", *files, tmp_path / "x.txt")
    assert "written as .npz or .csv" in refused("lengths", *files, tmp_path / "x.txt")
