"""Plain commands are understood without Typer, and do what the command line proper does."""

from __future__ import annotations

import inspect
import subprocess
import sys
from pathlib import Path

import pytest

from conicoid.cli.drawing import RenderRequest, parse_plain_render
from conicoid.cli.pictures import render

from .command_line import run, written

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
def test_what_is_plain(words):
    assert parse_plain_render(["render", *words]) is not None
    assert parse_plain_render(["turntable", *words]) is None


@pytest.mark.parametrize("words", NOT_PLAIN, ids=lambda words: " ".join(words) or "nothing")
def test_what_is_left_to_the_command_line(words):
    assert parse_plain_render(["render", *words]) is None


def test_no_words():
    assert parse_plain_render([]) is None


def test_defaults_are_those_of_the_options():
    options = inspect.signature(render).parameters
    for name, default in vars(RenderRequest(Path("p.png"))).items():
        if name in options and name not in ("output", "layers"):
            assert options[name].default == default, name


def test_the_same_picture_and_the_same_words(tmp_path: Path):
    scene = written(tmp_path)
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
    result = run("render", scene, "-o", proper, *SIZE)
    assert result.exit_code == 0
    assert ran.stderr.splitlines()[-1] == result.stderr.splitlines()[-1].replace("proper", "plain")
    assert plain.read_bytes() == proper.read_bytes()


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["missing.yaml", "-o", "p.png"], "missing.yaml"),
        (["scene.yaml", "-o", "p.bmp"], "pictures are saved as"),
        (["scene.yaml", "-o", "nowhere/p.png"], "no such folder"),
        (["scene.yaml", "-o", "p.png", "--samples", "9999999"], "samples must be a whole number"),
    ],
)
def test_mistakes_are_told_alike(words, told, tmp_path, monkeypatch, capsys):
    written(tmp_path)
    monkeypatch.chdir(tmp_path)
    command = parse_plain_render(["render", *words])
    assert command is not None
    with pytest.raises(SystemExit) as end:
        command()
    result = run("render", *words)
    assert end.value.code == result.exit_code != 0
    told_by_plain = capsys.readouterr().err
    assert told in told_by_plain
    assert told_by_plain == result.stderr
