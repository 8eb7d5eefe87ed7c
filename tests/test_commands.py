"""What the commands print and write."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image as PillowImage

import conicoid as co

from .command_line import arrays, refused, run, written


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    return written(tmp_path)


def test_info(scene):
    result = run("info", scene)
    assert result.exit_code == 0, result.output
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
    result = run("info", tmp_path / "scene.yaml")
    assert result.exit_code == 0
    assert "no bodies" in result.stdout
    assert "bounds    empty" in result.stdout
    (tmp_path / "scene.yaml").write_text("bodies:\n" + "  - shape: {Sphere: {}}\n" * 60)
    assert "and 10 more" in run("info", tmp_path / "scene.yaml").stdout


def test_schema():
    result = run("schema")
    assert result.exit_code == 0
    assert json.loads(result.stdout)["$schema"].startswith("https://json-schema.org/")


def test_render(scene, tmp_path):
    result = run(
        "render", scene, "-o", tmp_path / "x.png", "--width", 32, "--height", 24, "--samples", 1, "--threads", 1
    )
    assert result.exit_code == 0, result.output
    assert result.stdout == ""
    with PillowImage.open(tmp_path / "x.png") as picture:
        assert picture.size == (32, 24)
    co.set_threads(None)
    other = run("render", scene, "-o", tmp_path / "y.png", "--width", 32, "--height", 24, "--samples", 1)
    assert other.exit_code == 0
    assert (tmp_path / "x.png").read_bytes() == (tmp_path / "y.png").read_bytes()


def test_the_picture_of_a_saved_scene_is_the_same_to_the_bit(scene, tmp_path):
    first = co.load(scene)
    co.save(first, tmp_path / "again.yaml")
    options = {"width": 24, "height": 16, "samples": 3}
    assert np.array_equal(first.render(**options).pixels, co.load(tmp_path / "again.yaml").render(**options).pixels)


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
    result = run("trace", scene, tmp_path / "rays.csv", "-o", tmp_path / "spans.csv", "--spans")
    assert result.exit_code == 0, result.output
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
    assert "t_min and t_max must broadcast" in refused("trace", scene, tmp_path / "rays.npz", "-o", tmp_path / "x.npz")


def test_trace_in_pieces(scene, tmp_path, monkeypatch):
    monkeypatch.setattr("conicoid.cli.app.PIECE", 7)
    rays = np.random.default_rng(5).normal(size=(50, 6))
    np.save(tmp_path / "rays.npy", rays)
    loaded = co.load(scene)
    for options, names in (([], ("t", "body")), (["--spans"], ("offsets", "t_enter", "t_exit", "body"))):
        assert run("trace", scene, tmp_path / "rays.npy", "-o", tmp_path / "out.npz", *options).exit_code == 0
        ask = loaded.spans if options else loaded.first_hit
        expected, found = ask(rays[:, :3], rays[:, 3:]), arrays(tmp_path / "out.npz")
        for name in names:
            assert np.array_equal(found[name], getattr(expected, name))


@pytest.mark.parametrize("options", [[], ["--spans"]])
def test_trace_no_rays(scene, tmp_path, options):
    (tmp_path / "rays.csv").write_text("")
    done = run("trace", scene, tmp_path / "rays.csv", "-o", tmp_path / "out.csv", *options)
    assert done.exit_code == 2
    assert "rays.csv" in done.stderr
    assert not (tmp_path / "out.csv").exists()
    np.save(tmp_path / "rays.npy", np.zeros((0, 6)))
    assert run("trace", scene, tmp_path / "rays.npy", "-o", tmp_path / "out.csv", *options).exit_code == 0
    assert len((tmp_path / "out.csv").read_text().splitlines()) == 1
