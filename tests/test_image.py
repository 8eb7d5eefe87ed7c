"""Images: sRGB on output, color maps, complete files, and refusals."""

import io
import math

import numpy as np
import PIL.Image
import pytest

import conicoid as co

OpenEXR = pytest.importorskip("OpenEXR")


def standard(linear: float) -> int:
    """Apply IEC 61966-2-1 in 8 bits."""
    value = 12.92 * linear if linear <= 0.0031308 else 1.055 * linear ** (1 / 2.4) - 0.055
    return round(255 * value)


def test_png_holds_the_standards_values(tmp_path):
    ramp = np.linspace(0, 1, 300, dtype=np.float32)
    co.Image(np.stack([ramp, ramp**2, ramp**3], axis=-1)[None]).save(tmp_path / "ramp.png")
    values = np.asarray(PIL.Image.open(tmp_path / "ramp.png"))
    assert values.shape == (1, 300, 3)
    assert values.dtype == np.uint8
    for i, value in enumerate(ramp):
        value = np.float32(value)
        assert values[0, i].tolist() == [standard(float(value)), standard(float(value**2)), standard(float(value**3))]


def test_bytes_survive_a_png():
    pixels = np.random.default_rng(2).integers(0, 256, (20, 30, 3), dtype=np.uint8)
    again = np.asarray(PIL.Image.open(io.BytesIO(co.Image(pixels)._repr_png_())))
    assert (again == pixels).all()
    assert (co.Image(again).pixels == co.Image(pixels).pixels).all()


def test_png_is_marked_as_srgb():
    assert PIL.Image.open(io.BytesIO(co.Image(np.zeros((2, 2, 3)))._repr_png_())).info["srgb"] == 0


def test_png_clips_light_beyond_white():
    pixels = np.array([[[-1, 2, math.nan], [math.inf, -math.inf, 1]]])
    values = np.asarray(PIL.Image.open(io.BytesIO(co.Image(pixels)._repr_png_())))
    assert values.tolist() == [[[0, 255, 0], [255, 0, 255]]]


@pytest.mark.parametrize(
    ("pixels", "channel"),
    [
        (np.random.default_rng(0).normal(size=(7, 5, 3)).astype(np.float32) * 1e6, "RGB"),
        (np.arange(12.0).reshape(3, 4) - 5, "Y"),
    ],
)
@pytest.mark.parametrize("suffix", ["exr", "EXR"])
def test_exr_keeps_every_float(tmp_path, pixels, channel, suffix):
    co.Image(pixels).save(tmp_path / f"x.{suffix}")
    assert (OpenEXR.File(str(tmp_path / f"x.{suffix}")).channels()[channel].pixels == pixels).all()


def test_grey_map_is_even_in_lightness():
    """Oklab's grey of lightness L has linear value L³."""
    image = co.Image(np.linspace(0, 1, 5)[None], colormap="grey")
    assert image.pixels[0, :, 0] == pytest.approx(np.linspace(0, 1, 5) ** 3, abs=1e-6)
    assert np.ptp(image.pixels, axis=-1).max() < 1e-6


def test_the_default_map_rises_in_luminance():
    pixels = co.Image(np.arange(256.0)[None]).pixels[0]
    luminance = pixels @ (0.2126, 0.7152, 0.0722)
    assert (np.diff(luminance) > 0).all()
    assert pixels.min() >= 0
    assert pixels.max() <= 1


def test_ends_of_the_map():
    values = np.array([[0.0, 5, 10]])
    whole = co.Image(values, colormap="grey")
    assert whole.pixels[0, :, 0] == pytest.approx([0, 0.125, 1], abs=1e-6)
    cut = co.Image(values, colormap="grey", vmin=5, vmax=7.5)
    assert cut.pixels[0, :, 0] == pytest.approx([0, 0, 1], abs=1e-6)
    assert (co.Image(np.ones((2, 2)), colormap="grey").pixels == 0).all()


def test_numbers_that_are_not_finite_are_shown_apart():
    pixels = co.Image(np.array([[0, 1, math.inf, math.nan]]), colormap="grey").pixels[0, :, 0]
    assert pixels == pytest.approx([0, 1, 0.8, 0.8], abs=1e-6)
    assert np.isfinite(co.Image(np.full((2, 2), math.nan)).pixels).all()


def test_pixels_are_float32_and_read_only():
    array = np.zeros((2, 3, 3))
    image = co.Image(array)
    array[:] = 1
    assert image.pixels.dtype == np.float32
    assert (image.pixels == 0).all()
    assert (image.width, image.height) == (3, 2)
    with pytest.raises(ValueError, match="read-only"):
        image.pixels[0] = 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (dict(array=np.zeros((2, 2, 4))), "Image: array must have shape"),
        (dict(array=np.zeros(3)), "Image: array must have shape"),
        (dict(array=np.zeros((0, 3))), "Image: array must have shape"),
        (dict(array=np.zeros((2, 2), complex)), "Image: array must hold real numbers, got complex128"),
        (dict(array=np.zeros((2, 2)), colormap="jet"), "Image: colormap must be one of dusk, grey, got 'jet'"),
        (dict(array=np.zeros((2, 2)), vmin=2, vmax=1), "Image: vmin must be <= vmax, got 2 and 1"),
        (dict(array=np.array([[[255, 0, 0]]], np.int64)), "integers up to 255 must be of uint8, sRGB bytes; got int64"),
    ],
)
def test_bad_images_are_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        co.Image(**arguments)


def test_bad_paths_are_refused_and_leave_nothing(tmp_path):
    image = co.Image(np.zeros((2, 2, 3)))
    with pytest.raises(ValueError, match=r"saved as \.png, \.exr, \.jpg, \.jpeg, \.webp, got 'picture\.gif'"):
        image.save("picture.gif")
    with pytest.raises(FileNotFoundError, match="missing"):
        image.save(tmp_path / "missing" / "x.png")
    (tmp_path / "folder.png").mkdir()
    with pytest.raises(IsADirectoryError):
        image.save(tmp_path / "folder.png")
    assert [path.name for path in tmp_path.iterdir()] == ["folder.png"]


@pytest.mark.parametrize("name", ["x.png", "x.exr"])
def test_a_write_that_fails_leaves_the_old_file(tmp_path, monkeypatch, name):
    path = tmp_path / name
    co.Image(np.zeros((2, 2, 3))).save(path)
    before = path.read_bytes()

    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("pathlib.Path.write_bytes", interrupted)
    monkeypatch.setattr("OpenEXR.File.write", interrupted)
    with pytest.raises(KeyboardInterrupt):
        co.Image(np.ones((2, 2, 3))).save(path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_integers_are_bytes_or_no_colours():
    assert np.asarray(co.Image(np.array([[[1, 0, 0]]]))).tolist() == [[[255, 0, 0]]]


def test_exr_of_16_bits_holds_bright_light_and_far_depths(tmp_path):
    """65504 is the largest number of 16 bits. Brighter light is as bright as that, and no depth changes."""
    OpenEXR = pytest.importorskip("OpenEXR")
    from conicoid.io.image_codecs import write_exr

    pixels = np.array([[[1e6, 65504, 65519], [-1e6, 0.5, np.inf]]])
    depth = np.array([[1e6, np.inf]])
    write_exr(tmp_path / "x.exr", pixels, {"depth": depth, "albedo": np.full((1, 2, 3), 0.5)}, half=True)
    channels = OpenEXR.File(str(tmp_path / "x.exr"), separate_channels=True).channels()
    light = np.stack([channels[name].pixels for name in "RGB"], axis=-1)
    assert light.dtype == np.float16
    assert light.tolist() == [[[65504, 65504, 65504], [-65504, 0.5, np.inf]]]
    assert channels["depth.V"].pixels.dtype == np.float32
    assert channels["depth.V"].pixels.tolist() == depth.tolist()
