"""Light by groups adds up to all light; previews tell how noisy they are."""

from __future__ import annotations

import io

import numpy as np
import pytest

import conicoid as co

WHITE, BLACK = (1.0, 1.0, 1.0), (0.0, 0.0, 0.0)
SUN = co.DirectionalLight((1, 0, -2), (0.4, 0.3, 0.1))
KEY = co.Body(co.Disc((0, -1, 3), (0, 0, 1), 0.5), co.glow((6, 3, 1)), "key")
FILL = co.Body(co.Sphere(0.4, (2, 0, 2)), co.glow((0, 1, 4)), "fill")
SCENE = co.Scene(
    [co.Body(co.Plane((0, 0, 1), 0), co.matte(WHITE)), co.Body(co.Sphere(0.7, (0, 0, 0.7)), "white"), KEY, FILL],
    [SUN, co.AmbientLight(0.05)], co.Camera((0, -6, 3), (0, 0, 0.5)), (0.05, 0.06, 0.1),
)  # fmt: skip
GROUPS = {"key": ["key"], "rest": ["fill", SUN, co.AmbientLight(0.05)], "sky": "background"}


@pytest.mark.parametrize(("integrator", "samples", "off"), [("path", 256, 0.02), ("whitted", 32, 0.02)])
def test_groups_add_up(integrator, samples, off):
    image = SCENE.render(32, 24, samples, integrator, groups=GROUPS)
    parts = {name: image.layers[f"light.{name}"] for name in GROUPS}
    total = sum(parts.values())
    assert total.mean(axis=(0, 1)) == pytest.approx(image.pixels.mean(axis=(0, 1)), rel=off)
    assert parts["key"][..., 2].mean() < parts["key"][..., 0].mean()
    assert min(parts["key"].max(), parts["rest"].max()) > 0


def test_a_group_is_the_picture_with_its_lights_alone():
    dark = SCENE.replace("fill", material=co.glow(0)).replace(lights=co.AmbientLight(0), background=BLACK)
    image = SCENE.render(16, 12, 8, "path", groups={"key": "key"})
    assert (image.layers["light.key"] == dark.render(16, 12, 8, "path").pixels).all()
    assert (image.pixels == SCENE.render(16, 12, 8, "path").pixels).all()


def test_groups_are_layers_of_an_exr(tmp_path):
    openexr = pytest.importorskip("OpenEXR")
    image = SCENE.render(8, 6, 2, "direct", groups={"key": ["key"]}, layers="depth")
    image.save(tmp_path / "out.exr")
    channels = openexr.File(str(tmp_path / "out.exr"), separate_channels=True).channels()
    assert {"light.key.R", "light.key.G", "light.key.B", "depth.V", "R"} <= set(channels)
    assert (channels["light.key.G"].pixels == image.layers["light.key"][..., 1]).all()


@pytest.mark.parametrize(
    ("groups", "error", "told"),
    [
        (["key"], TypeError, "groups must be a mapping"),
        ({"a": ["kee"]}, ValueError, r"groups\['a'\] must name bodies that glow.*got 'kee'.*key"),
        ({"a": [co.AmbientLight(3)]}, ValueError, "must name bodies that glow, lights of the scene"),
        ({"": ["key"]}, ValueError, "groups must have names"),
    ],
)
def test_refusals(groups, error, told):
    with pytest.raises(error, match=told):
        SCENE.render(4, 4, groups=groups)


def test_previews_tell_their_noise():
    seen = []
    image = SCENE.render(16, 12, 32, "path", preview=seen.append, layers="error")
    noises = [one.noise for one in seen]
    assert len(noises) >= 5
    assert noises[0] == np.inf
    assert (np.diff(noises[1:]) < 0).all()
    assert noises[-1] == pytest.approx(np.sqrt((image.layers["error"].astype(float) ** 2).mean()), rel=1e-6)
    assert (seen[-1].pixels == image.pixels).all()


def test_previews_in_a_notebook(monkeypatch):
    """One display, which is updated."""
    display = pytest.importorskip("IPython.display")
    told = []

    class Handle:
        def update(self, image):
            told.append(image)

    monkeypatch.setattr(display, "display", lambda image, display_id: told.append(image) or Handle())
    image = SCENE.render(8, 6, 8, "path", preview=True)
    assert len(told) == 4
    assert (told[-1].pixels == image.pixels).all()


def test_previews_in_a_terminal(monkeypatch):
    """Half blocks: the upper pixel is the colour of the character, the lower one what is behind it."""
    from rich.console import Console

    from conicoid.io.image_codecs import downsample, render_half_blocks

    pixels = np.zeros((3, 2, 3), np.float32)
    pixels[0, 0], pixels[1, 0], pixels[2, 1] = (1, 0, 0), (0, 1, 0), (0, 0, 1)
    text = render_half_blocks(pixels, 10, 10)
    assert text.plain == "\u2580\u2580\n\u2580\u2580"
    assert [str(span.style) for span in text.spans] == [
        "#ff0000 on #00ff00", "#000000 on #000000", "#000000", "#0000ff",
    ]  # fmt: skip
    assert downsample(np.arange(24.0).reshape(4, 2, 3), 1, 2).tolist() == [[[4.5, 5.5, 6.5]], [[16.5, 17.5, 18.5]]]
    shown = io.StringIO()
    console = Console(
        file=shown, force_terminal=True, color_system="truecolor", width=20, height=9, legacy_windows=False
    )
    monkeypatch.setattr("rich.console.Console", lambda **_: console)
    SCENE.render(16, 12, 8, "path", preview="terminal")
    assert shown.getvalue().count("\x1b[6A") == 3, "four pictures of six rows, each but the first over the one before"
    with pytest.raises(ValueError, match="render: preview must be one of terminal, got 'window'"):
        SCENE.render(8, 6, 8, "path", preview="window")
