"""The command line: results, messages, exit codes."""

from __future__ import annotations

import io
import json
import re
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from PIL import Image as PillowImage
from rich.console import Console
from typer.testing import CliRunner

import conicoid as co
from conicoid import terminal
from conicoid.cli import app
from conicoid.formats.errors import SceneFileError

from .formats.broken import CASES

SCENE = """
materials:
  red: {phong: {color: red}}
bodies:
  - {name: ball, shape: {Sphere: {radius: 1}}, material: red}
  - {shape: {Box: {low: [2, -1, -1], high: [4, 1, 1]}}}
  - {shape: {Spheres: {centers: [[0, 0, 5], [0, 0, 9]], radii: 1}}}
  - {shape: {HalfSpace: {normal: [0, 0, 1], offset: -3}}}
"""


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "scene.yaml"
    path.write_text(SCENE)
    return path


def run(*arguments: object):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def arrays(path: Path) -> dict[str, np.ndarray]:
    with np.load(path, allow_pickle=False) as found:
        return {name: found[name] for name in found.files}


def refused(*arguments: object) -> str:
    """The message of a command that fails by the user's mistake."""
    result = run(*arguments)
    assert result.exit_code == 2, result.output
    assert "Traceback" not in result.output
    assert isinstance(result.exception, SystemExit)
    return result.stderr


# Help and version -----------------------------------------------------------------------------------


def test_version():
    result = run("--version")
    assert (result.exit_code, result.stdout) == (0, f"conicoid {co.__version__}\n")


@pytest.mark.parametrize("command", ["render", "view", "export", "info", "trace", "import", "bench", "schema"])
def test_help_has_an_example(command):
    result = run(command, "--help")
    assert result.exit_code == 0
    assert f"conicoid {command} " in " ".join(result.stdout.split("Example")[1].split())


def test_help_lists_what_there_is_and_no_more():
    text = run("--help").stdout
    assert re.findall(r"^\W*(render|info|trace|schema|view|export|import|bench) ", text, re.MULTILINE) == [
        "render",
        "view",
        "export",
        "info",
        "trace",
        "import",
        "bench",
        "schema",
    ]


def test_help_and_mistakes_come_without_the_compiler(tmp_path):
    (tmp_path / "bad.yaml").write_text("bodies: [{shape: {Spere: {}}}]\n")
    code = (
        "import sys\nfrom conicoid.cli import main\n"
        "for arguments in (['--help'], ['info', 'bad.yaml'], ['schema']):\n"
        "    sys.argv = ['conicoid', *arguments]\n"
        "    try:\n        main()\n    except SystemExit as stop:\n        print('code', stop.code)\n"
        "    print('numpy', 'numpy' in sys.modules, 'numba', 'numba' in sys.modules)\n"
    )
    ran = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True)
    states = re.findall(r"numpy (\w+) numba (\w+)", ran.stdout)
    assert states == [("False", "False"), ("True", "False"), ("True", "False")]
    assert re.findall(r"code (\w+)", ran.stdout) == ["0", "2", "0"]
    assert "did you mean 'Sphere'?" in ran.stderr


# Mistakes -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_broken_scenes(case, tmp_path):
    path = tmp_path / "scene.yaml"
    path.write_bytes(case.content)
    message = refused("info", path)
    assert case.phrases[0] in message
    assert "error" in message


@pytest.mark.parametrize("command", ["render", "info", "trace"])
def test_a_scene_that_is_none(command, tmp_path, scene):
    rest = {
        "render": ["-o", tmp_path / "x.png"],
        "info": [],
        "trace": [tmp_path / "rays.csv", "-o", tmp_path / "x.csv"],
    }[command]
    (tmp_path / "rays.csv").write_text("0,0,5,0,0,-1\n")
    assert "no such file" in refused(command, tmp_path / "none.yaml", *rest)
    assert "is a directory" in refused(command, tmp_path, *rest)


def test_several_mistakes_at_once(tmp_path):
    (tmp_path / "scene.yaml").write_text("bodies: [{shape: {Spere: {}}}, {shape: {Sphere: {radius: -1}}}]\n")
    message = refused("info", tmp_path / "scene.yaml")
    assert message.startswith("2 errors:\n")
    assert "Spere" in message
    assert "radius must be > 0" in message


def test_100_mb_of_brackets_in_a_process_of_its_own(tmp_path):
    (tmp_path / "scene.yaml").write_bytes(b"[" * (100 << 20))
    started = time.perf_counter()
    command = [sys.executable, "-m", "conicoid", "render", "scene.yaml", "-o", "x.png"]
    root = str(Path(__file__).resolve().parent.parent)
    ran = subprocess.run(
        command,
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
        env={"PYTHONPATH": root, "PATH": "/usr/bin:/bin"},
    )
    assert ran.returncode == 2
    assert "error: scene.yaml: is too large: 100 MB" in ran.stderr
    assert "Traceback" not in ran.stderr
    assert time.perf_counter() - started < 20


@pytest.mark.parametrize(
    ("arguments", "phrase"),
    [
        (["-o", "x.jpg"], "x.jpg: pictures are saved as .png or .exr"),
        (["-o", "none/x.png"], "none: no such folder"),
        (["-o", "x.png", "--integrator", "path"], "integrator must be one of whitted, normals, got 'path'"),
        (["-o", "x.png", "--width", "0"], "--width"),
        (["-o", "x.png", "--samples", "many"], "--samples"),
        (["-o", "x.png", "--threads", "0"], "--threads"),
        ([], "Missing option"),
        (["-o", "x.png", "--widht", "3"], "No such option"),
    ],
)
def test_mistakes_in_the_options_of_render(scene, tmp_path, monkeypatch, arguments, phrase):
    monkeypatch.chdir(tmp_path)
    assert phrase in re.sub(r"\s+", " ", refused("render", scene, *arguments))
    assert not list(tmp_path.glob("x.*"))


@pytest.mark.parametrize(
    ("rays", "output", "phrase"),
    [
        ("0,0,5,0,0,0\n", "hits.npz", "direction must not be zero"),
        ("0,0,5,0,0,-1\n0,nan,5,0,0,1\n", "hits.npz", "origin must be finite"),
        ("0,0,5,0,0\n", "hits.npz", "must be 6 numbers"),
        ("0,0,5,0,0,-1\n", "hits.txt", "results are written as .npz or .csv"),
        ("0,0,5,0,0,-1\n", "none/hits.npz", "no such folder"),
        (None, "hits.npz", "no such file"),
    ],
)
def test_mistakes_in_rays(scene, tmp_path, rays, output, phrase):
    if rays is not None:
        (tmp_path / "rays.csv").write_text(rays)
    assert phrase in refused("trace", scene, tmp_path / "rays.csv", "-o", tmp_path / output)
    assert not (tmp_path / output).exists()


@pytest.mark.parametrize(
    ("error", "code", "said"), [(KeyboardInterrupt(), 130, "interrupted"), (MemoryError(), 1, "memory")]
)
def test_other_exit_codes(scene, monkeypatch, error, code, said):
    def fail(path: object) -> None:
        raise error

    monkeypatch.setattr("conicoid.files.load", fail)
    result = run("info", scene)
    assert result.exit_code == code
    assert said in result.stderr


def test_bugs_are_not_hidden(scene, monkeypatch):
    def fail(path: object) -> None:
        raise RuntimeError("a bug")

    monkeypatch.setattr("conicoid.files.load", fail)
    result = run("info", scene)
    assert result.exit_code == 1
    assert isinstance(result.exception, RuntimeError)


# Commands that work ---------------------------------------------------------------------------------


def test_info(scene):
    result = run("info", scene)
    assert result.exit_code == 0, result.output
    lines = result.stdout.splitlines()
    assert lines[1].split() == ["0", "ball", "Sphere", "x", "[-1,", "1]", "y", "[-1,", "1]", "z", "[-1,", "1]"]
    assert lines[3].split()[:2] == ["2-3", "Spheres"]
    assert "z [-inf, -3]" in lines[4]
    totals = dict(line.split(maxsplit=1) for line in lines[6:])
    assert totals["bodies"] == "5"
    assert totals["surfaces"] == "10"  # a ball, six walls, two balls, a half-space
    _, unit, text = totals["memory"].split(maxsplit=2)
    assert unit in ("bytes", "kB")
    # The ball, the box, two balls, the half-space; the tree's node has 8 boxes of 6 floats
    assert text.startswith("for 5 cells: ")
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
    monkeypatch.setattr("conicoid.ray_tables.PIECE", 7)
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
    assert run("trace", scene, tmp_path / "rays.csv", "-o", tmp_path / "out.csv", *options).exit_code == 0
    assert len((tmp_path / "out.csv").read_text().splitlines()) == 1


# Progress and notes ---------------------------------------------------------------------------------


def bar_text(monkeypatch: pytest.MonkeyPatch, is_terminal: bool) -> str:
    stream = io.StringIO()
    monkeypatch.setattr(terminal, "PATIENCE", 0.0)
    monkeypatch.setattr(terminal, "console", lambda: Console(file=stream, force_terminal=is_terminal, width=100))
    with terminal.Bar("tracing", "ray") as bar:
        bar(100, 400)
        bar(200, 400)
    return stream.getvalue()


def test_progress_has_rate_and_time_left(monkeypatch):
    text = bar_text(monkeypatch, is_terminal=True)
    assert "tracing" in text
    assert "50%" in text
    assert "ray/s" in text
    assert re.search(r"\d:\d\d:\d\d", text)


def test_no_progress_where_nobody_watches(monkeypatch):
    assert bar_text(monkeypatch, is_terminal=False) == ""


def test_the_first_compilation_is_announced_once(capsys):
    from numba import njit

    functions = []
    for _ in range(2):

        def work(x: float) -> float:
            return x + 1

        work.__module__ = "conicoid.test"
        functions.append(njit(work))
    with terminal.compile_notes():
        assert [function(1.0) for function in functions] == [2.0, 2.0]
    captured = capsys.readouterr()
    assert captured.err.count("compiling kernels") == 1
    assert captured.out == ""


def test_numbers_for_people():
    assert [terminal.with_prefix(n) for n in (0, 12.345, 1234, 5.6e6, 7e9)] == ["0 ", "12.3 ", "1.23 k", "5.6 M", "7 G"]
    assert [terminal.with_bytes(n) for n in (0, 999, 1000, 12_300_000, 5 * 10**12)] == [
        "0 bytes",
        "999 bytes",
        "1 kB",
        "12.3 MB",
        "5e+03 GB",
    ]


def test_scene_file_errors_are_value_errors(tmp_path):
    (tmp_path / "scene.yaml").write_text("bodies: 3\n")
    with pytest.raises(ValueError, match="must be a list") as caught:
        co.load(tmp_path / "scene.yaml")
    assert isinstance(caught.value, SceneFileError)
    assert caught.value.path == str(tmp_path / "scene.yaml")
