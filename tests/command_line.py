"""Helpers for tests of the command line: a scene file, and commands that succeed or fail."""

from functools import cache
from pathlib import Path
from unittest.mock import patch

import numpy as np
from typer import testing
from typer.main import get_command

from conicoid.cli.app import app

from . import messages

SCENE = """
materials:
  red: {phong: {color: red}}
bodies:
  - {name: ball, shape: {Sphere: {radius: 1}}, material: red}
  - {shape: {Box: {low: [2, -1, -1], high: [4, 1, 1]}}}
  - {shape: {Spheres: {centers: [[0, 0, 5], [0, 0, 9]], radii: 1}}}
  - {shape: {HalfSpace: {normal: [0, 0, 1], offset: -3}}}
"""


def scene_file(folder: Path) -> Path:
    """Save the scene as a file in `folder`."""
    path = folder / "scene.yaml"
    path.write_text(SCENE)
    return path


@cache
def command():
    """Return the application. Making its commands takes nine tenths of the time of most calls."""
    return get_command(app)


def run(*arguments: object):
    with patch.object(testing, "_get_command", lambda _: command()):
        return testing.CliRunner().invoke(app, [str(argument) for argument in arguments])


def execute(*arguments: object):
    """Run a command that succeeds."""
    result = run(*arguments)
    assert result.exit_code == 0, result.output
    return result


def arrays(path: Path) -> dict[str, np.ndarray]:
    with np.load(path, allow_pickle=False) as found:
        return {name: found[name] for name in found.files}


def failure(*arguments: object) -> str:
    """Run a command that fails by the user's mistake; return its message."""
    result = run(*arguments)
    assert result.exit_code == 2, result.output
    assert "Traceback" not in result.output
    assert isinstance(result.exception, SystemExit)
    messages.check(result.stderr)
    return result.stderr
