"""Layers of a picture, and the commands' options of film."""

from __future__ import annotations

import io

import numpy as np
import PIL.Image
import pytest

import conicoid as co
from conicoid.render.options import LAYERS

from ..command_line import done, refused, run

# --- Layers: what is seen at the pixels' centres, and files that hold them

OpenEXR = pytest.importorskip("OpenEXR")

SCENE = co.Scene(
    [co.Body(co.Sphere(1, (0, 0, 1)), "tomato"), co.Body(co.Box((-2, -2, -1), (2, 2, 0)), co.matte("teal"))],
    camera=co.Camera((4, -6, 3), (0, 0, 0.5)),
)


def test_layers_are_the_hits_of_the_pixels():
    image = SCENE.render(48, 36, 2, layers=True)
    assert tuple(image.layers) == tuple(LAYERS)
    hits = SCENE.first_hit(SCENE.camera.rays(48, 36))
    assert (image.layers["body"] == np.asarray(hits.body)).all()
    assert (image.layers["depth"] == np.asarray(hits.t, np.float32)).all()
    position, normal = np.asarray(hits.point, np.float32), np.nan_to_num(np.asarray(hits.normal)).astype(np.float32)
    assert np.array_equal(image.layers["position"], position, equal_nan=True)
    assert (image.layers["normal"] == normal).all()
    assert (image.layers["samples"] == 2).all()
    assert (image.pixels == SCENE.render(48, 36, 2).pixels).all()
    teal = np.array([0, 0x80, 0x80]) / 255
    middle = image.layers["albedo"][30, 24]  # on the box
    assert middle == pytest.approx(((teal + 0.055) / 1.055) ** 2.4 * (teal > 0), abs=1e-6)


def test_the_error_is_that_of_the_samples():
    image = SCENE.render(24, 18, 8, layers=("error", "samples"))
    singles = []
    for k in range(8):  # each sample again: what the first k + 1 of them add up to, less the first k
        part = SCENE.render(24, 18, 8, layers="error")
        assert (part.pixels == image.pixels).all()
        singles.append(k)
    error = image.layers["error"]
    assert error.shape == (18, 24)
    assert (error >= 0).all()
    flat = SCENE.first_hit(SCENE.camera.rays(24, 18)).body
    inner = np.asarray(flat)[1:-1, 1:-1]
    same = np.ones_like(inner, bool)
    for dy in (0, 1, 2):
        for dx in (0, 1, 2):
            same &= np.asarray(flat)[dy : dy + 16, dx : dx + 22] == inner
    on_box = same & (inner == 1)
    edges = ~same
    assert error[1:-1, 1:-1][edges].mean() > 5 * error[1:-1, 1:-1][on_box].mean()


def test_all_layers_are_in_the_exr(tmp_path):
    image = SCENE.render(20, 16, 2, layers=True)
    for bits, kind in ((None, np.float32), (16, np.float16)):
        image.save(tmp_path / "layers.exr", bits=bits)
        channels = OpenEXR.File(str(tmp_path / "layers.exr"), separate_channels=True).channels()
        names = {"R", "G", "B", "depth.V", "body.V", "samples.V", "error.V"}
        names |= {f"albedo.{c}" for c in "RGB"} | {f"{name}.{c}" for name in ("normal", "position") for c in "XYZ"}
        assert set(channels) == names
        for k, letter in enumerate("RGB"):
            assert (channels[letter].pixels == image.pixels[..., k].astype(kind)).all()
            assert channels[letter].pixels.dtype == kind
            assert (channels[f"albedo.{letter}"].pixels == image.layers["albedo"][..., k].astype(kind)).all()
        for k, letter in enumerate("XYZ"):
            found, expected = channels[f"position.{letter}"].pixels, image.layers["position"][..., k].astype(kind)
            assert np.array_equal(found, expected, equal_nan=True)
        assert channels["body.V"].pixels.dtype == np.uint32
        assert (channels["body.V"].pixels.astype(np.int32) == image.layers["body"]).all()
        assert (channels["samples.V"].pixels == 2).all()
        assert (channels["depth.V"].pixels == image.layers["depth"].astype(kind)).all()


def test_names_of_layers():
    assert list(SCENE.render(4, 3, 1, layers=["depth", "albedo"]).layers) == ["albedo", "depth"]
    assert SCENE.render(4, 3, 1).layers == {}
    with pytest.raises(ValueError, match=r"render: layers must be of albedo, .*, got 'dept' \(did you mean 'depth'"):
        SCENE.render(4, 3, layers="dept")
    with pytest.raises(TypeError, match="render: layers must be names of layers, or True for all, got 3"):
        SCENE.render(4, 3, layers=3)


# --- conicoid render with what films have: the same as Python's calls

FILE = """
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
    (tmp_path / "scene.yaml").write_text(FILE)
    return tmp_path / "scene.yaml"


def test_a_picture_with_all_of_it(scene, tmp_path):
    output = tmp_path / "out.exr"
    done("render", scene, "-o", output, *SMALL, "--filter", "tent", "--layers", "all", "--bits", "16")
    image = co.load(scene).render(24, 16, 2, filter="tent", layers=True)
    channels = OpenEXR.File(str(output), separate_channels=True).channels()
    assert (channels["G"].pixels == image.pixels[..., 1].astype(np.float16)).all()
    assert (channels["body.V"].pixels.astype(np.int32) == image.layers["body"]).all()
    done("render", scene, "-o", output, *SMALL, "--layers", "depth, error")
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
    done("render", scene, "-o", tmp_path / "a.png", *options, "--preview", tmp_path / "p.png")
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
    done("render", scene, "-o", tmp_path / "a.png", *options)
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
