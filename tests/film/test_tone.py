"""Tone curves and exposure: formulas evaluated here one number at a time; files that hold what is shown."""

from __future__ import annotations

import math

import numpy as np
import PIL.Image
import pytest

import conicoid as co
from conicoid.render.color_mapping import apply_tone

LIGHT = [0.0, 1e-4, 0.01, 0.18, 0.5, 1.0, 3.9, 12.3]


def hable(x):
    return (x * (0.15 * x + 0.05) + 0.004) / (x * (0.15 * x + 0.5) + 0.06) - 0.02 / 0.3


def test_filmic_is_hables():
    for light in LIGHT:
        found = apply_tone(np.full((1, 1, 3), light), 0, "filmic")
        assert found == pytest.approx(np.full((1, 1, 3), min(1, hable(2 * light) / hable(11.2))), abs=1e-14)


def agx(rgb):
    """Wrensch's minimal AgX, by hand; what it gives is encoded for the display."""
    r, g, b = rgb
    mixed = (
        0.842479062253094 * r + 0.0784335999999992 * g + 0.0792237451477643 * b,
        0.0423282422610123 * r + 0.878468636469772 * g + 0.0791661274605434 * b,
        0.0423756549057051 * r + 0.0784336 * g + 0.879142973793104 * b,
    )
    y = []
    for value in mixed:
        x = (math.log2(max(value, 1e-30)) + 12.47393) / (4.026069 + 12.47393)
        x = min(1, max(0, x))
        y.append(15.5 * x**6 - 40.14 * x**5 + 31.96 * x**4 - 6.868 * x**3 + 0.4298 * x**2 + 0.1191 * x - 0.00232)
    back = (
        1.19687900512017 * y[0] - 0.0980208811401368 * y[1] - 0.0990297440797205 * y[2],
        -0.0528968517574562 * y[0] + 1.15190312990417 * y[1] - 0.0989611768448433 * y[2],
        -0.0529716355144438 * y[0] - 0.0980434501171241 * y[1] + 1.15107367264116 * y[2],
    )
    return [min(1, max(0, value)) for value in back]


@pytest.mark.parametrize("rgb", [(v, v, v) for v in LIGHT] + [(1, 0.1, 0), (0.02, 0.3, 9), (0.18, 0.02, 0.5)])
def test_agx_is_wrenschs(rgb):
    image = co.Image(np.full((1, 1, 3), rgb, np.float32)).developed(tone="agx")
    assert np.abs(np.asarray(image)[0, 0] - 255 * np.array(agx(rgb))).max() <= 0.5 + 1e-4


def test_agx_keeps_grey_grey_and_rises():
    grey = np.repeat(np.geomspace(1e-3, 10, 200)[:, None], 3, axis=1)[None]
    found = apply_tone(grey, 0, "agx")
    assert np.ptp(found, axis=-1).max() < 5e-3
    assert (np.diff(found[0, :, 1]) >= 0).all()


@pytest.mark.parametrize("stops", [-2, 0, 1, 2.5])
def test_a_stop_is_twice_as_bright(stops):
    light = np.array([[[0.02, 0.1, 0.05]]], np.float32)
    assert apply_tone(light, stops, "srgb") == pytest.approx(light * 2.0**stops, rel=1e-7)
    again = co.Image(light * np.float32(2.0**stops))
    assert np.abs(np.asarray(co.Image(light).developed(stops)).astype(int) - np.asarray(again)).max() <= 1


def test_what_is_shown_is_saved_and_light_stays(tmp_path):
    pytest.importorskip("OpenEXR")
    image = co.Image(np.random.default_rng(4).random((5, 6, 3)).astype(np.float32) * 3)
    shown = image.developed(-0.5, "filmic")
    assert (shown.pixels == image.pixels).all()
    assert (np.asarray(shown) != np.asarray(image)).any()
    for suffix in ("png", "webp"):
        shown.save(tmp_path / f"a.{suffix}")
        assert (np.asarray(PIL.Image.open(tmp_path / f"a.{suffix}")) == np.asarray(shown)).all()
    shown.save(tmp_path / "a.exr")
    assert (co.materials.ImageTexture(tmp_path / "a.exr").pixels.array == image.pixels).all()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda image: image.developed(tone="aces"), "developed: tone must be one of srgb, filmic, agx"),
        (lambda image: image.developed(math.inf), "developed: exposure must be finite"),
        (lambda image: image.developed(99), "developed: exposure must be from -64 to 64 stops"),
        (lambda image: co.Image(np.zeros((2, 2))).developed(1), "not a number per pixel"),
        (lambda image: image.save("a.png", bits=12), r"Image: bits of .png must be 16 or 8|must be 8 or 16"),
        (lambda image: image.save("a.webp", bits=16), r"Image: bits of .webp must be 8"),
    ],
)
def test_refusals(call, message):
    with pytest.raises(ValueError, match=message):
        call(co.Image(np.zeros((2, 2, 3))))


def test_png_of_16_bits(tmp_path):
    """Read by FFmpeg in full, and by Pillow, which keeps the upper byte of each number."""
    import av

    pixels = np.random.default_rng(5).random((37, 23, 3)).astype(np.float32)
    co.Image(pixels).save(tmp_path / "deep.png", bits=16)
    encoded = np.where(pixels <= 0.0031308, 12.92 * pixels, 1.055 * pixels.astype(float) ** (1 / 2.4) - 0.055)
    with av.open(str(tmp_path / "deep.png")) as file:
        (frame,) = file.decode(video=0)
        assert frame.format.name == "rgb48be"
        found = frame.to_ndarray(format="rgb48le")
    assert np.abs(found.astype(float) - 65535 * encoded).max() <= 0.5 + 1e-3
    with PIL.Image.open(tmp_path / "deep.png") as file:
        assert file.size == (23, 37)
        upper = np.asarray(file.convert("RGB")).astype(int)
    assert np.abs(upper - found / 257).max() <= 1
