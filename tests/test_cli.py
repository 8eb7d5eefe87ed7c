"""The command line: help, messages, exit codes, plain commands, options that go together, progress bars."""

import inspect
import io
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import PIL.Image
import pytest
from rich.console import Console

import conicoid as co
from conicoid._util.text import format_bytes
from conicoid.cli import resources, terminal
from conicoid.cli.drawing import RenderRequest, parse_plain_render
from conicoid.cli.pictures import render
from conicoid.io.openmc import read
from conicoid.render.integrators import INTEGRATORS
from conicoid.scene import movies as turning

from .command_line import execute, failure, run, scene_file
from .formats.broken import CASES
from .samples import sampled

# --- The command line: help, messages, exit codes


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    return scene_file(tmp_path)


# Help and version -----------------------------------------------------------------------------------


def test_version():
    result = run("--version")
    assert (result.exit_code, result.stdout) == (0, f"conicoid {co.__version__}\n")


@pytest.mark.parametrize(
    "command", ["render", "turntable", "view", "playground", "export", "info", "trace", "import", "schema"]
)
def test_help_has_an_example(command):
    result = execute(command, "--help")
    assert f"conicoid {command} " in " ".join(result.stdout.split("Example")[1].split())


def test_help_lists_the_commands():
    commands = "render turntable view playground export info trace import schema"
    words = re.findall(rf"^\W*({commands.replace(' ', '|')}) ", run("--help").stdout, re.MULTILINE)
    assert words == commands.split()


def test_help_and_mistakes_come_without_the_compiler(tmp_path):
    """They also come where there is no machine code."""
    (tmp_path / "bad.yaml").write_text("bodies: [{shape: {Spere: {}}}]\n")
    code = (
        "import sys\nfrom conicoid.cli.app import main\n"
        "for arguments in (['--help'], ['info', 'bad.yaml'], ['schema']):\n"
        "    sys.argv = ['conicoid', *arguments]\n"
        "    try:\n        main()\n    except SystemExit as stop:\n        print('code', stop.code)\n"
        "    print('numpy', 'numpy' in sys.modules, 'numba', 'numba' in sys.modules)\n"
    )
    own = {**os.environ, "CONICOID_JIT": "own"}
    ran = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True, env=own
    )
    states = re.findall(r"numpy (\w+) numba (\w+)", ran.stdout)
    assert states == [("False", "False"), ("True", "False"), ("True", "False")]
    assert re.findall(r"code (\w+)", ran.stdout) == ["0", "2", "0"]
    assert "did you mean 'Sphere'?" in ran.stderr


# Mistakes -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("case", sampled(CASES, 8), ids=lambda case: case.name)
def test_broken_scenes(case, tmp_path):
    path = tmp_path / "scene.yaml"
    path.write_bytes(case.content)
    message = failure("info", path)
    assert case.phrases[0] in message
    assert "error" in message


@pytest.mark.parametrize("command", ["render", "info", "trace"])
def test_files_that_are_no_scenes_are_refused(command, tmp_path, scene):
    rest = {
        "render": ["-o", tmp_path / "x.png"],
        "info": [],
        "trace": [tmp_path / "rays.csv", "-o", tmp_path / "x.csv"],
    }[command]
    (tmp_path / "rays.csv").write_text("0,0,5,0,0,-1\n")
    assert "no such file" in failure(command, tmp_path / "none.yaml", *rest)
    assert "is a directory" in failure(command, tmp_path, *rest)


@pytest.mark.parametrize(
    ("arguments", "phrase"),
    [
        (["-o", "x.gif"], "x.gif: pictures are saved as .png, .exr, .jpg, .jpeg, .webp"),
        (["-o", "none/x.png"], "none: no such folder"),
        (
            ["-o", "x.png", "--integrator", "photons"],
            f"integrator must be one of {', '.join(INTEGRATORS)}, got 'photons'",
        ),
        (["-o", "x.png", "--width", "0"], "--width"),
        (["-o", "x.png", "--samples", "many"], "--samples"),
        (["-o", "x.png", "--threads", "0"], "--threads"),
        ([], "Missing option"),
        (["-o", "x.png", "--widht", "3"], "No such option"),
    ],
)
def test_mistakes_in_the_options_of_render(scene, tmp_path, monkeypatch, arguments, phrase):
    monkeypatch.chdir(tmp_path)
    assert phrase in re.sub(r"\s+", " ", failure("render", scene, *arguments))
    assert not list(tmp_path.glob("x.*"))


@pytest.mark.parametrize(
    ("rays", "output", "phrase"),
    [
        ("0,0,5,0,0,0\n", "hits.npz", "direction must not be zero"),
        ("0,0,5,0,0,-1\n0,nan,5,0,0,1\n", "hits.npz", "origin must be finite"),
        ("0,0,5,0,0\n", "hits.npz", "must be 6 numbers"),
        ("0,0,5,0,0,-1\n", "hits.txt", "results are written as .npz, .csv, .parquet or .zarr"),
        ("0,0,5,0,0,-1\n", "none/hits.npz", "no such folder"),
        (None, "hits.npz", "no such file"),
    ],
)
def test_mistakes_in_rays(scene, tmp_path, rays, output, phrase):
    if rays is not None:
        (tmp_path / "rays.csv").write_text(rays)
    message = failure("trace", scene, tmp_path / "rays.csv", "-o", tmp_path / output)
    assert phrase in message
    assert "rays.csv: " in message or output != "hits.npz"
    assert len(message.splitlines()) == 1
    assert not (tmp_path / output).exists()


@pytest.mark.parametrize(
    ("error", "code", "message"),
    [(KeyboardInterrupt(), 130, "interrupted"), (MemoryError(), 1, "memory"), (RuntimeError("a bug"), 1, "")],
)
def test_other_exit_codes(scene, monkeypatch, error, code, message):
    def fail(path: object, **_: object) -> None:
        raise error

    monkeypatch.setattr("conicoid.scene.files.load", fail)
    result = run("info", scene)
    assert result.exit_code == code
    assert message in result.stderr
    assert message or result.exception is error  # a bug is not hidden


# --- Commands without Typer for plain arguments do the work of the full command line

SIZE = ["--width", "24", "--height", "16", "--samples", "1"]
PLAIN = (["s.yaml", "-o", "p.png"], ["--output", "p.png", *SIZE, "s.yaml"], ["s.yaml", "-o", "p.png", "--threads", "2"])
NOT_PLAIN = (
    [], ["s.yaml"], ["-o", "p.png"], ["s.yaml", "t.yaml", "-o", "p.png"], ["s.yaml", "-o", "p.png", "--help"],
    ["s.yaml", "-o", "-"], ["s.yaml", "-o", ""], ["", "-o", "p.png"], ["s.yaml", "-o", "p.png", "-o", "q.png"],
    ["s.yaml", "-o", "p.png", "--width"], ["s.yaml", "-o", "p.png", "--width", "0"],
    ["s.yaml", "-o", "p.png", "--width", "-3"], ["s.yaml", "-o", "p.png", "--width", "1e3"],
    ["s.yaml", "-o", "p.png", "--width", "٣"], ["s.yaml", "-o", "p.png", "--width=9"],
    ["s.yaml", "-o", "p.png", "--width", "9", "--width", "9"], ["s.yaml", "-o", "p.png", "--axes"],
    ["--", "s.yaml", "-o", "p.png"], ["s.yaml", "-o", "p.png", "--height", "12345678901234567890"],
)  # fmt: skip


@pytest.mark.parametrize("words", PLAIN, ids=" ".join)
def test_plain_words_take_the_short_route(words):
    assert parse_plain_render(["render", *words]) is not None
    assert parse_plain_render(["turntable", *words]) is None


@pytest.mark.parametrize("words", NOT_PLAIN, ids=lambda words: " ".join(words) or "nothing")
def test_options_of_the_command_line_alone(words):
    assert parse_plain_render(["render", *words]) is None


def test_defaults_are_those_of_the_options():
    options = inspect.signature(render).parameters
    for name, default in RenderRequest(Path("p.png"))._asdict().items():
        if name in options and name not in ("output", "layers"):
            assert options[name].default == default, name


def test_the_same_picture_and_the_same_words(tmp_path: Path):
    scene = scene_file(tmp_path)
    code = (
        "import sys\nfrom conicoid import __main__ as entry\n"
        "from conicoid.cli import terminal, resources\n"
        "terminal.PATIENCE = resources.PATIENCE = float('inf')\n"  # a slow machine draws bars, by Rich
        "code = entry._command(False)\n"
        "print(code, sorted({name.partition('.')[0] for name in sys.modules} & {'typer', 'pydantic', 'rich'}))\n"
    )
    plain, proper = tmp_path / "plain.png", tmp_path / "proper.png"
    words = ["render", str(scene), "-o", str(plain), *SIZE]
    ran = subprocess.run([sys.executable, "-c", code, *words], capture_output=True, text=True, check=True)
    assert ran.stdout == "0 []\n"
    result = execute("render", scene, "-o", proper, *SIZE)
    assert ran.stderr.splitlines()[-1] == result.stderr.splitlines()[-1].replace("proper", "plain")
    assert plain.read_bytes() == proper.read_bytes()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["missing.yaml", "-o", "p.png"], "missing.yaml"),
        (["scene.yaml", "-o", "p.bmp"], "pictures are saved as"),
        (["scene.yaml", "-o", "nowhere/p.png"], "no such folder"),
        (["scene.yaml", "-o", "p.png", "--samples", "9999999"], "samples must be a whole number"),
    ],
)
def test_mistakes_have_the_same_message_on_every_route(words, message, tmp_path, monkeypatch, capsys):
    scene_file(tmp_path)
    monkeypatch.chdir(tmp_path)
    command = parse_plain_render(["render", *words])
    with pytest.raises(SystemExit) as end:
        command()
    result = run("render", *words)
    assert end.value.code == result.exit_code != 0
    told_by_plain = capsys.readouterr().err
    assert message in told_by_plain
    assert told_by_plain == result.stderr


# --- The command line ignores no option: options that need others, variables of the environment, and `-o -`

ROOT = Path(__file__).resolve().parents[1]
PIN = "examples/openmc"
SMALL = ("--width", 16, "--height", 12)


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
    assert message in failure(arguments[0], scene, *arguments[1:])
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
    error = failure(command, *([scene] if command == "info" else []))
    assert re.search(message, error), error
    assert len(error) < 600


def test_a_picture_on_standard_output(scene, tmp_path):
    result = execute("render", scene, "-o", "-", *SMALL)
    pixels = np.asarray(PIL.Image.open(io.BytesIO(result.stdout_bytes)))
    assert run("render", scene, "-o", tmp_path / "x.png", *SMALL).exit_code == 0
    assert np.array_equal(pixels, np.asarray(PIL.Image.open(tmp_path / "x.png")))
    assert "standard output: 16 x 12 pixels" in result.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == ["scene.yaml", "x.png"]


@pytest.mark.parametrize("options", [(), ("--spans",)])
def test_a_table_on_standard_output(options, scene, tmp_path):
    (tmp_path / "rays.csv").write_text("0,0,-9,0,0,1\n9,9,9,1,0,0\n")
    result = execute("trace", scene, tmp_path / "rays.csv", "-o", "-", *options)
    run("trace", scene, tmp_path / "rays.csv", "-o", tmp_path / "x.csv", *options)
    assert result.stdout_bytes == (tmp_path / "x.csv").read_bytes()
    assert "standard output: " in result.stderr


def test_a_scene_on_standard_output(tmp_path):
    geometry = ROOT / PIN / "pin" / "model.xml"
    result = execute("import", geometry, "-o", "-")
    (tmp_path / "scene.yaml").write_bytes(result.stdout_bytes)
    assert co.load(tmp_path / "scene.yaml").bodies == tuple(read(geometry).bodies)
    assert "standard output: " in result.stderr


def test_standard_output_that_is_full_or_unread():
    """As with printed results, the exit code is 1 with a reason, or 141."""
    scene = "examples/scenes/" + next(iter(sorted((ROOT / "examples/scenes").glob("*.yaml")))).name
    command = [sys.executable, "-m", "conicoid", "render", scene, "-o", "-", "--width", "64", "--height", "48"]
    if Path("/dev/full").exists():
        with open("/dev/full", "w") as full:
            ran = subprocess.run(command, cwd=ROOT, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
        assert ran.returncode == 1
        assert "error: standard output: no space left on device" in ran.stderr


def test_cameras_on_the_command_line(scene, tmp_path):
    """The picture is the same as from Python."""
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


@pytest.mark.parametrize(("depth", "middle"), [(0, 0), (1, 255)])
def test_depth_on_the_command_line(depth, middle, tmp_path):
    """A mirror at its depth limit is black, and a ray one level deeper shows the white background."""
    camera, mirror = co.Camera((0, -5, 0), (0, 0, 0)), co.Body(co.Sphere(), co.mirror(1.0))
    co.Scene(mirror, co.AmbientLight(0), camera, "white").save(tmp_path / "scene.yaml")
    execute("render", tmp_path / "scene.yaml", "-o", tmp_path / "x.png", *SMALL, "--samples", 1, "--depth", depth)
    assert PIL.Image.open(tmp_path / "x.png").getpixel((8, 6)) == (middle,) * 3


def test_turntable(scene, tmp_path):
    options = (*SMALL, "--frames", 3, "--samples", 1, "--seconds", 1)
    first = execute("turntable", scene, "-o", tmp_path / "spin.gif", *options)
    assert first.stderr.endswith("spin.gif: 3 frames of 16 x 12 pixels\n")
    with PIL.Image.open(tmp_path / "spin.gif") as file:
        assert (file.n_frames, file.size) == (3, (16, 12))
    again = run("turntable", scene, "-o", tmp_path / "spin.webp", "--folder", tmp_path / "spin-frames", *options)
    assert again.stderr.endswith("spin.webp: 3 frames of 16 x 12 pixels, 3 of them were there\n")
    assert run("turntable", scene, "-o", tmp_path / "once.gif", "--no-keep", *options).exit_code == 0
    assert not (tmp_path / "once-frames").exists()
    execute("turntable", scene, "-o", tmp_path / "b.gif", "--position", "9,0,0", "--axes", *options)


def test_turntable_without_its_encoder(scene, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "av", None)
    monkeypatch.setattr(turning, "Frames", None)
    result = run("turntable", scene, "-o", tmp_path / "spin.mp4")
    assert result.exit_code == 1
    assert "pip install 'conicoid[video]'" in result.stderr


@pytest.mark.parametrize("work", ["reading {} ...", "preparing 4 entries ..."])
def test_long_work_shows_progress(scene, monkeypatch, work):
    assert work.format(scene) not in run("info", scene).stderr
    monkeypatch.setattr(resources, "PATIENCE", -1.0)
    assert run("info", scene).stderr.count(f"{work.format(scene)}\n") == 1


# --- Progress, notes and numbers on a terminal; errors of mistakes in files


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


def test_no_progress_without_a_terminal(monkeypatch):
    assert bar_text(monkeypatch, is_terminal=False) == ""


def test_numbers_for_people():
    assert [terminal.format_si(n) for n in (0, 12.345, 1234, 5.6e6, 7e9)] == ["0 ", "12.3 ", "1.23 k", "5.6 M", "7 G"]
    assert [format_bytes(n) for n in (0, 999, 1000, 12_300_000, 5 * 10**12)] == [
        "0 bytes",
        "999 bytes",
        "1 kB",
        "12.3 MB",
        "5e+03 GB",
    ]
