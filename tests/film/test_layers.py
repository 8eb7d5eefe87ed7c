"""Layers: what is seen at the pixels' centres, and files that hold them."""

from __future__ import annotations

import numpy as np
import pytest

import conicoid as co
from conicoid.render.options import LAYERS

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
