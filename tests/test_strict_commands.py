"""The command line passes nothing over: options that go with others, variables of the environment; and `-o -`."""

from __future__ import annotations

import io
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import PIL.Image
import pytest

import conicoid as co
from conicoid.io.openmc import read
from conicoid.scene import movies as turning

from .command_line import refused, run, written

ROOT = Path(__file__).resolve().parents[1]
PIN = "examples/openmc"
SMALL = ("--width", 16, "--height", 12)


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    return written(tmp_path)


@pytest.mark.parametrize(("arguments", "message"), [
    (("render", "-o", "x.png", "--look-at", "0,0,0"), "render: --look-at goes with --position; it would be ignored"),
    (("render", "-o", "x.png", "--up", "0,0,1"), "render: --up goes with --position"),
    (("render", "-o", "x.png", "--field-of-view", 30), "render: --field-of-view goes with --position"),
    (("render", "-o", "x.png", "--position", "9,0,0", "--fit"), "--fit goes with the scene's camera, without --position"),
    (("render", "-o", "x.png", "--integrator", "normals", "--depth", 3), "--depth goes with --integrator whitted"),
    (("render", "-o", "x.png", "--samples", 1, "--seed", 3), "--seed goes with --samples 2 or more"),
    (("render", "-o", "x.png", "--position", "9,0"), "--position must be three numbers X,Y,Z, got '9,0'"),
    (("render", "-o", "x.png", "--position", "0,0,0", "--look-at", "0,0,0"), "look_at must differ from position"),
    (("turntable", "-o", "x.gif", "--look-at", "0,0,0"), "turntable: --look-at goes with --position"),
    (("turntable", "-o", "x.gif", "--seconds", 0), "seconds must be > 0, got 0"),
    (("turntable", "-o", "x.png"), "movies are saved as .gif, .webp, .mp4, got"),
    (("turntable", "-o", "-"), "movies are saved as .gif, .webp, .mp4, got '-'"),
    (("info", "--rays", 1000), "info: --rays goes with --check; it would be ignored"),
    (("info", "--seed", 1), "info: --seed goes with --check"),
])  # fmt: skip
def test_options_that_would_be_ignored(arguments, message, scene, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert message in refused(arguments[0], scene, *arguments[1:])
    assert [path.name for path in tmp_path.iterdir()] == ["scene.yaml"]


@pytest.mark.parametrize(("variable", "value", "message"), [
    ("CONICOID_THREADS", "many", "CONICOID_THREADS must be an integer from 1 to 65536, got 'many'"),
    ("CONICOID_THREADS", "9" * 5000, "got '9999"),
    ("CONICOID_JIT", "plain", "CONICOID_JIT must be 'own', got 'plain'"),
    ("CONICOID_THREAD", "3", "CONICOID_THREAD is not a Conicoid variable: did you mean CONICOID_THREADS"),
    ("CONICOID_" + "X" * 900, "3", "is not a Conicoid variable: known are CONICOID_THREADS, CONICOID_JIT, CONICOID_LEVEL"),
])  # fmt: skip
@pytest.mark.parametrize("command", ["info", "schema"])
def test_variables_of_the_environment(command, variable, value, message, scene, monkeypatch):
    monkeypatch.setenv(variable, value)
    told = refused(command, *([scene] if command == "info" else []))
    assert re.search(message, told), told
    assert len(told) < 600


def test_a_picture_on_standard_output(scene, tmp_path):
    result = run("render", scene, "-o", "-", *SMALL)
    assert result.exit_code == 0, result.output
    seen = np.asarray(PIL.Image.open(io.BytesIO(result.stdout_bytes)))
    assert run("render", scene, "-o", tmp_path / "x.png", *SMALL).exit_code == 0
    assert np.array_equal(seen, np.asarray(PIL.Image.open(tmp_path / "x.png")))
    assert "standard output: 16 x 12 pixels" in result.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == ["scene.yaml", "x.png"]


@pytest.mark.parametrize("options", [(), ("--spans",)])
def test_a_table_on_standard_output(options, scene, tmp_path):
    (tmp_path / "rays.csv").write_text("0,0,-9,0,0,1\n9,9,9,1,0,0\n")
    result = run("trace", scene, tmp_path / "rays.csv", "-o", "-", *options)
    assert result.exit_code == 0, result.output
    run("trace", scene, tmp_path / "rays.csv", "-o", tmp_path / "x.csv", *options)
    assert result.stdout_bytes == (tmp_path / "x.csv").read_bytes()
    assert "standard output: " in result.stderr


def test_a_scene_on_standard_output(tmp_path):
    geometry = ROOT / PIN / "pin" / "model.xml"
    result = run("import", geometry, "-o", "-")
    assert result.exit_code == 0, result.output
    (tmp_path / "scene.yaml").write_bytes(result.stdout_bytes)
    assert co.load(tmp_path / "scene.yaml").bodies == tuple(read(geometry).bodies)
    assert "standard output: " in result.stderr


def test_standard_output_that_is_full_or_unread():
    """As with results that are printed: 1 and the reason, or 141."""
    scene = "examples/scenes/" + next(iter(sorted((ROOT / "examples/scenes").glob("*.yaml")))).name
    command = [sys.executable, "-m", "conicoid", "render", scene, "-o", "-", "--width", "64", "--height", "48"]
    if Path("/dev/full").exists():
        with open("/dev/full", "w") as full:
            ran = subprocess.run(command, cwd=ROOT, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
        assert ran.returncode == 1
        assert "error: standard output: no space left on device" in ran.stderr


def test_cameras_on_the_command_line(scene, tmp_path):
    """The same picture as from Python."""
    loaded = co.load(scene).replace(camera=co.Camera((1, 2, 3), (0, 0, 0)))
    loaded.save(scene)
    cases = {
        ("--position", "9,-9,5", "--look-at", "0,0,1", "--up", "0,1,0", "--field-of-view", 30): co.Camera(
            (9, -9, 5), (0, 0, 1), (0, 1, 0), 30
        ),
        ("--fit",): loaded.fitting_camera(16 / 12),
        (): loaded.camera,
    }
    for options, camera in cases.items():
        assert run("render", scene, "-o", tmp_path / "x.png", *SMALL, *options).exit_code == 0
        found = np.asarray(PIL.Image.open(tmp_path / "x.png"))
        assert np.array_equal(found, np.asarray(loaded.render(16, 12, camera=camera))), options
    run("render", scene, "-o", tmp_path / "x.png", *SMALL, "--axes", "--labels", "--normals")
    drawn = loaded.render(16, 12, axes=True, labels=True, normals=True)
    assert np.array_equal(np.asarray(PIL.Image.open(tmp_path / "x.png")), np.asarray(drawn))


def test_turntable(scene, tmp_path):
    options = (*SMALL, "--frames", 3, "--samples", 1, "--seconds", 1)
    first = run("turntable", scene, "-o", tmp_path / "spin.gif", *options)
    assert first.exit_code == 0, first.output
    assert first.stderr.endswith("spin.gif: 3 frames of 16 x 12 pixels\n")
    with PIL.Image.open(tmp_path / "spin.gif") as file:
        assert (file.n_frames, file.size) == (3, (16, 12))
    again = run("turntable", scene, "-o", tmp_path / "spin.webp", "--folder", tmp_path / "spin-frames", *options)
    assert again.stderr.endswith("spin.webp: 3 frames of 16 x 12 pixels, 3 of them were there\n")
    assert run("turntable", scene, "-o", tmp_path / "once.gif", "--no-keep", *options).exit_code == 0
    assert not (tmp_path / "once-frames").exists()
    turned = run("turntable", scene, "-o", tmp_path / "b.gif", "--position", "9,0,0", "--axes", *options)
    assert turned.exit_code == 0


def test_turntable_without_its_encoder(scene, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "av", None)
    monkeypatch.setattr(turning, "Frames", None)
    result = run("turntable", scene, "-o", tmp_path / "spin.mp4")
    assert result.exit_code == 1
    assert "pip install 'conicoid[video]'" in result.stderr


def test_preparing_is_told_where_it_takes_long(scene, monkeypatch):
    from conicoid.cli import resources as working

    assert "preparing" not in run("info", scene).stderr
    monkeypatch.setattr(working, "PATIENCE", -1.0)
    assert run("info", scene).stderr.count("preparing 4 entries ...\n") == 1


def test_reading_is_told_where_it_takes_long(scene, monkeypatch):
    from conicoid.cli import resources as working

    assert "reading" not in run("info", scene).stderr
    monkeypatch.setattr(working, "PATIENCE", -1.0)
    assert run("info", scene).stderr.count(f"reading {scene} ...\n") == 1
