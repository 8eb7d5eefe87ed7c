"""The command line: help, messages, exit codes."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import time
from pathlib import Path

import pytest

import conicoid as co
from conicoid.render.integrators import INTEGRATORS

from .command_line import refused, run, written
from .formats.broken import CASES


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    return written(tmp_path)


# Help and version -----------------------------------------------------------------------------------


def test_version():
    result = run("--version")
    assert (result.exit_code, result.stdout) == (0, f"conicoid {co.__version__}\n")


@pytest.mark.parametrize(
    "command", ["render", "turntable", "view", "playground", "export", "info", "trace", "import", "schema"]
)
def test_help_has_an_example(command):
    result = run(command, "--help")
    assert result.exit_code == 0
    assert f"conicoid {command} " in " ".join(result.stdout.split("Example")[1].split())


def test_help_lists_what_there_is_and_no_more():
    text = run("--help").stdout
    assert re.findall(
        r"^\W*(render|turntable|info|trace|schema|view|playground|export|import) ", text, re.MULTILINE
    ) == [
        "render",
        "turntable",
        "view",
        "playground",
        "export",
        "info",
        "trace",
        "import",
        "schema",
    ]


def test_help_and_mistakes_come_without_the_compiler(tmp_path):
    """Where there is no machine code too."""
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
    assert time.perf_counter() - started < 60  # what would be parsed takes minutes


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
    assert phrase in re.sub(r"\s+", " ", refused("render", scene, *arguments))
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
    message = refused("trace", scene, tmp_path / "rays.csv", "-o", tmp_path / output)
    assert phrase in message
    assert "rays.csv: " in message or output != "hits.npz"
    assert len(message.splitlines()) == 1
    assert not (tmp_path / output).exists()


@pytest.mark.parametrize(
    ("error", "code", "said"), [(KeyboardInterrupt(), 130, "interrupted"), (MemoryError(), 1, "memory")]
)
def test_other_exit_codes(scene, monkeypatch, error, code, said):
    def fail(path: object, **_: object) -> None:
        raise error

    monkeypatch.setattr("conicoid.scene.files.load", fail)
    result = run("info", scene)
    assert result.exit_code == code
    assert said in result.stderr


def test_bugs_are_not_hidden(scene, monkeypatch):
    def fail(path: object, **_: object) -> None:
        raise RuntimeError("a bug")

    monkeypatch.setattr("conicoid.scene.files.load", fail)
    result = run("info", scene)
    assert result.exit_code == 1
    assert isinstance(result.exception, RuntimeError)
