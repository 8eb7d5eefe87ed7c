"""conicoid render with what films have: the same as Python's calls."""

from __future__ import annotations

import io

import numpy as np
import PIL.Image
import pytest

import conicoid as co
from tests.command_line import refused, run

OpenEXR = pytest.importorskip("OpenEXR")

SCENE = """
camera: {position: [4, -6, 3], look_at: [0, 0, 0.5], aperture: 0.2}
bodies:
  - shape: {Sphere: {radius: 1, center: [0, 0, 1]}}
    material: {matte: {color: {Gradient: {a: red, b: blue, along: z}}}}
  - shape: {Box: {low: [-2, -2, -1], high: [2, 2, 0]}}
    material: {matte: {color: {Brick: {size: [0.5, 0.2], joint: 0.02}}}}
"""
SMALL = ("--width", "24", "--height", "16", "--samples", "2")


@pytest.fixture
def scene(tmp_path):
    (tmp_path / "scene.yaml").write_text(SCENE)
    return tmp_path / "scene.yaml"


def test_a_picture_with_all_of_it(scene, tmp_path):
    output = tmp_path / "out.exr"
    result = run("render", scene, "-o", output, *SMALL, "--filter", "tent", "--layers", "all", "--bits", "16")
    assert result.exit_code == 0, result.output
    image = co.load(scene).render(24, 16, 2, filter="tent", layers=True)
    channels = OpenEXR.File(str(output), separate_channels=True).channels()
    assert (channels["G"].pixels == image.pixels[..., 1].astype(np.float16)).all()
    assert (channels["body.V"].pixels.astype(np.int32) == image.layers["body"]).all()
    some = run("render", scene, "-o", output, *SMALL, "--layers", "depth, error")
    assert some.exit_code == 0
    names = set(OpenEXR.File(str(output), separate_channels=True).channels())
    assert names == {"R", "G", "B", "depth.V", "error.V"}


def test_exposure_and_tone(scene, tmp_path):
    output = tmp_path / "out.png"
    assert run("render", scene, "-o", output, *SMALL, "--exposure", "-1", "--tone", "agx").exit_code == 0
    shown = co.load(scene).render(24, 16, 2).developed(-1, "agx")
    assert (np.asarray(PIL.Image.open(output)) == np.asarray(shown)).all()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["-o", "a.png", "--layers", "depth"], "--layers goes with an .exr"),
        (["-o", "a.exr", "--tone", "agx"], "--tone goes with a displayed picture"),
        (["-o", "a.webp", "--bits", "16"], "--bits goes with a .png or an .exr"),
        (["-o", "a.png", "--bits", "12"], "--bits must be 16, or 8, got 12"),
        (["-o", "a.png", "--filter", "cubic"], "filter must be one of box"),
        (["-o", "a.png", "--tone", "aces"], "tone must be one of srgb"),
        (["-o", "a.exr", "--layers", "deep"], "layers must be of albedo"),
        (["-o", "a.png", "--noise", "0.01"], "noise goes with integrators"),
        (["-o", "a.png", "--section", "z=0", "--filter", "tent"], "--filter goes with a view"),
    ],
)
def test_what_would_be_ignored_is_refused(scene, options, message):
    options[1] = str(scene.parent / options[1])
    assert message in refused("render", scene, *options, *(SMALL if "--section" not in options else ()))


def test_a_preview_is_written_again_and_again(scene, tmp_path, monkeypatch):
    """The last one is the picture."""
    written = []
    save = co.Image.save
    monkeypatch.setattr(
        co.Image, "save", lambda image, path, **rest: (written.append(str(path)), save(image, path, **rest))
    )
    options = ("--integrator", "path", "--width", "16", "--height", "12", "--samples", "8")
    result = run("render", scene, "-o", tmp_path / "a.png", *options, "--preview", tmp_path / "p.png")
    assert result.exit_code == 0, result.output
    assert written.count(str(tmp_path / "p.png")) == 4
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "p.png").read_bytes()
    told = refused("render", scene, "-o", tmp_path / "a.png", "--preview", tmp_path / "p.png")
    assert "--preview goes with --integrator" in told


def test_a_preview_in_the_terminal(scene, tmp_path, monkeypatch):
    """Above the line of progress, which is made to be a terminal's and to appear at once."""
    from rich.console import Console

    from conicoid.cli import terminal

    shown = io.StringIO()
    made = Console(file=shown, force_terminal=True, color_system="truecolor", width=40, height=12, legacy_windows=False)
    monkeypatch.setattr(terminal, "console", lambda: made)
    monkeypatch.setattr(terminal, "PATIENCE", 0.0)
    options = ("--integrator", "path", "--width", "64", "--height", "48", "--samples", "64", "--preview", "-")
    result = run("render", scene, "-o", tmp_path / "a.png", *options)
    assert result.exit_code == 0, result.output
    assert "\N{UPPER HALF BLOCK}" in shown.getvalue()
    assert not (tmp_path / "-").exists()


def test_pictures_outside_of_the_folder_are_taken_when_that_is_said(tmp_path):
    (tmp_path / "scenes").mkdir()
    PIL.Image.new("RGB", (2, 2), "red").save(tmp_path / "red.png")
    text = "bodies: [{shape: {Sphere: {radius: 1}}, material: {matte: {color: {ImageTexture: {image: ../red.png}}}}}]"
    (tmp_path / "scenes" / "scene.yaml").write_text(text)
    command = ("render", tmp_path / "scenes" / "scene.yaml", "-o", tmp_path / "a.png", *SMALL)
    assert "outside" in refused(*command)
    assert run(*command, "--outside").exit_code == 0
